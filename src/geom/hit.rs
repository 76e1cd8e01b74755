//! Hits, and the one fixed content of a miss.

use wide::{f32x8, u32x8};

use super::candidate::Candidate;
use super::lanes::{Lanes, Mask, Mask8, eq8, lt8};

/// Outcome of intersecting one ray (`Hit<f32>`) or a packet (`Hit<f32x8>`).
///
/// A lane that misses holds exactly [`Hit::MISS`]. So two hits are identical if their bits are ([`Hit::to_bits`]). A
/// hit never holds a NaN. Kernels return a [`Candidate`], whose lanes that miss may hold anything.
///
/// | shape | `t` | `u`, `v` |
/// | --- | --- | --- |
/// | triangle | where the ray hits it | barycentrics: `p = v0 + u·(v1 - v0) + v·(v2 - v0)` |
/// | box | where the ray enters it, clipped to the ray's interval | `u`: where the ray leaves it, clipped; `v = 0` |
/// | quadric | where the ray hits it | 0 |
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit<L: Lanes> {
    /// Which lanes hit.
    pub mask: L::Mask,
    /// Ray parameter, in units of `|dir|`.
    pub t: L,
    /// First surface parameter.
    pub u: L,
    /// Second surface parameter.
    pub v: L,
    /// The primitive that was hit. 0 where there is only one, `u32::MAX` in a lane that misses.
    pub primitive: L::Index,
    /// The instance in a scene. 0 where there is only one, `u32::MAX` in a lane that misses.
    pub instance: L::Index,
}

impl<L: Lanes> Hit<L> {
    /// The hit in a lane.
    ///
    /// # Panics
    /// If `lane >= L::LANES`.
    #[inline]
    pub fn lane(&self, lane: usize) -> Hit<f32> {
        Hit {
            mask: self.mask.lane(lane),
            t: self.t.lane(lane),
            u: self.u.lane(lane),
            v: self.v.lane(lane),
            primitive: L::lane_of_index(self.primitive, lane),
            instance: L::lane_of_index(self.instance, lane),
        }
    }
}

impl Hit<f32> {
    /// The content of every miss.
    pub const MISS: Self =
        Self { mask: false, t: f32::INFINITY, u: 0.0, v: 0.0, primitive: u32::MAX, instance: u32::MAX };

    /// A hit of primitive 0 if `mask` is set and `t`, `u` and `v` are numbers, else [`Hit::MISS`].
    #[inline(always)]
    pub fn new(mask: bool, t: f32, u: f32, v: f32) -> Self {
        if mask & !t.is_nan() & !u.is_nan() & !v.is_nan() {
            Self { mask, t, u, v, primitive: 0, instance: 0 }
        } else {
            Self::MISS
        }
    }

    /// The bits of `t`, `u` and `v`, and the numbers of primitive and instance. They determine the mask.
    #[inline]
    pub fn to_bits(&self) -> [u32; 5] {
        [self.t.to_bits(), self.u.to_bits(), self.v.to_bits(), self.primitive, self.instance]
    }

    /// Whether this hit comes before `other`: by the smaller `t`, then by the lower instance number, then by the
    /// lower primitive number.
    #[inline(always)]
    pub fn is_closer_than(&self, other: &Self) -> bool {
        let number = |hit: &Self| (hit.instance, hit.primitive);
        (self.t < other.t) | ((self.t == other.t) & (number(self) < number(other)))
    }
}

impl Hit<f32x8> {
    /// Eight misses.
    #[inline(always)]
    pub fn miss() -> Self {
        Self::new(Mask8::none(), f32x8::ZERO, f32x8::ZERO, f32x8::ZERO)
    }

    /// A hit of primitive 0 in the lanes where `mask` is set and `t`, `u` and `v` are numbers, [`Hit::MISS`] in the
    /// others.
    #[inline(always)]
    pub fn new(mask: Mask8, t: f32x8, u: f32x8, v: f32x8) -> Self {
        Candidate::<f32x8>::new(mask & eq8(t, t) & eq8(u, u) & eq8(v, v), t, u, v).or_miss()
    }

    /// Lane `i` becomes `lanes[i]`.
    #[inline]
    pub fn from_lanes(lanes: &[Hit<f32>; 8]) -> Self {
        Self {
            mask: Mask8::from_lanes(lanes.map(|hit| hit.mask)),
            t: f32x8::new(lanes.map(|hit| hit.t)),
            u: f32x8::new(lanes.map(|hit| hit.u)),
            v: f32x8::new(lanes.map(|hit| hit.v)),
            primitive: u32x8::new(lanes.map(|hit| hit.primitive)),
            instance: u32x8::new(lanes.map(|hit| hit.instance)),
        }
    }

    /// The first of the lanes in the order of [`Hit::is_closer_than`]. For one ray against eight primitives, that is
    /// the closest hit.
    #[inline]
    pub fn closest(&self) -> Hit<f32> {
        Candidate::from(*self).closest()
    }

    /// Replaces the hit in the lanes where the candidate is closer, by [`Hit::is_closer_than`].
    #[inline(always)]
    pub fn keep_closer(&mut self, candidate: &Candidate<f32x8>) {
        let other = candidate.values();
        let mut closer = other.mask & lt8(other.t, self.t);
        let tied = other.mask & eq8(other.t, self.t);
        if tied.any() {
            let is_closer = |lane| other.lane(lane).is_closer_than(&self.lane(lane));
            closer = closer | (tied & Mask8::from_lanes(core::array::from_fn(is_closer)));
        }
        self.replace(closer, candidate);
    }

    /// Takes over these lanes from a candidate that hits there.
    #[inline(always)]
    pub(crate) fn replace(&mut self, lanes: Mask8, candidate: &Candidate<f32x8>) {
        let other = candidate.values();
        *self = Self {
            mask: self.mask | lanes,
            t: lanes.select(other.t, self.t),
            u: lanes.select(other.u, self.u),
            v: lanes.select(other.v, self.v),
            primitive: lanes.select_u32(other.primitive, self.primitive),
            instance: lanes.select_u32(other.instance, self.instance),
        };
    }

    /// Writes the first lanes to `hits`, as many as fit.
    #[inline(always)]
    pub fn write(&self, hits: &mut [Hit<f32>]) {
        let bits = self.mask.bits();
        let numbers = |numbers: u32x8| f32x8::new(numbers.to_array().map(f32::from_bits));
        let nothing = f32x8::ZERO;
        // After transposing, each row is a hit. On primary rays that is 0.98 to 1.06 times as fast as writing
        // component by component.
        let (primitive, instance) = (numbers(self.primitive), numbers(self.instance));
        let rows = f32x8::transpose([self.t, self.u, self.v, primitive, instance, nothing, nothing, nothing]);
        for (lane, (hit, row)) in hits.iter_mut().zip(rows).enumerate() {
            let [t, u, v, primitive, instance, ..] = row.to_array();
            let mask = bits >> lane & 1 == 1;
            *hit = Hit { mask, t, u, v, primitive: primitive.to_bits(), instance: instance.to_bits() };
        }
    }

    /// All eight lanes.
    #[inline]
    pub fn lanes(&self) -> [Hit<f32>; 8] {
        core::array::from_fn(|index| self.lane(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_miss_has_one_content() {
        let nan = f32x8::splat(f32::NAN);
        let mask = Mask8::from_lanes([true, false, false, false, false, false, false, true]);
        let hit = Hit::<f32x8>::new(mask, f32x8::splat(2.0), f32x8::splat(0.25), f32x8::splat(-0.0));
        assert_eq!(hit.lane(0).to_bits(), Hit::<f32>::new(true, 2.0, 0.25, -0.0).to_bits());
        for lane in 1..7 {
            assert_eq!(hit.lane(lane).to_bits(), Hit::MISS.to_bits());
            assert_eq!(Hit::<f32x8>::new(Mask8::none(), nan, nan, nan).lane(lane).to_bits(), Hit::MISS.to_bits());
        }
        let sharp = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0];
        for t in sharp {
            for u in sharp {
                for v in sharp {
                    let numbers = !(t.is_nan() || u.is_nan() || v.is_nan());
                    assert_eq!(Hit::<f32>::new(false, t, u, v).to_bits(), Hit::MISS.to_bits());
                    assert_eq!(Hit::<f32>::new(true, t, u, v).mask, numbers, "{t} {u} {v}");
                    let eight = [t, u, v].map(f32x8::splat);
                    let packet = Hit::<f32x8>::new(Mask8::all_lanes(), eight[0], eight[1], eight[2]);
                    assert_eq!(packet.lane(7).to_bits(), Hit::<f32>::new(true, t, u, v).to_bits());
                }
            }
        }
    }

    #[test]
    fn for_equal_t_the_lower_instance_and_then_the_lower_primitive_wins() {
        let mut first = Hit::<f32>::new(true, 1.0, 0.0, 0.0);
        let mut second = first;
        first.primitive = 3;
        second.primitive = 4;
        assert!(first.is_closer_than(&second) && !second.is_closer_than(&first));
        (second.primitive, second.instance) = (2, 1);
        assert!(first.is_closer_than(&second) && !second.is_closer_than(&first));
        assert!(!first.is_closer_than(&first));
        assert!(second.is_closer_than(&Hit::MISS) && !Hit::<f32>::MISS.is_closer_than(&Hit::MISS));
    }

    #[test]
    fn write_and_lane_agree() {
        let mask = Mask8::from_lanes([true, false, true, false, false, false, false, true]);
        let t = f32x8::new([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let packet = Hit::<f32x8>::new(mask, t, t * t, -t);
        for count in 0..10 {
            let mut hits = [Hit { primitive: 7, ..Hit::MISS }; 10];
            packet.write(&mut hits[..count]);
            for (lane, hit) in hits.iter().enumerate() {
                let expected = if lane < count.min(8) { packet.lane(lane) } else { Hit { primitive: 7, ..Hit::MISS } };
                assert_eq!((hit.mask, hit.to_bits()), (expected.mask, expected.to_bits()));
            }
        }
        assert_eq!(Hit::from_lanes(&packet.lanes()), packet);
    }
}
