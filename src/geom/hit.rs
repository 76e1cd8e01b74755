//! Hits, and the one fixed content of a miss.

use wide::{f32x8, u32x8};

use super::lanes::{Lanes, Mask8, eq8, min};

/// Outcome of intersecting one ray (`Hit<f32>`) or a packet (`Hit<f32x8>`).
///
/// A lane that misses holds exactly [`Hit::MISS`]. So two hits are identical if their bits are ([`Hit::to_bits`]). A
/// hit never holds a NaN. Only a [candidate](Hit::candidate) may hold anything in the lanes that miss.
///
/// | shape | `t` | `u`, `v` |
/// | --- | --- | --- |
/// | triangle | where the ray hits it | barycentrics: `p = v0 + u·(v1 - v0) + v·(v2 - v0)` |
/// | box | where the ray enters it, clipped to the ray's interval | `u`: where the ray leaves it, clipped; `v = 0` |
/// | quadric | where the ray hits it | 0 |
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl Hit<f32> {
    /// The content of every miss.
    pub const MISS: Self =
        Self { mask: false, t: f32::INFINITY, u: 0.0, v: 0.0, primitive: u32::MAX, instance: u32::MAX };

    /// A hit of primitive 0 if `mask` is set, else [`Hit::MISS`].
    #[inline(always)]
    pub fn new(mask: bool, t: f32, u: f32, v: f32) -> Self {
        if mask { Self { mask, t, u, v, primitive: 0, instance: 0 } } else { Self::MISS }
    }

    /// [`Hit::new`] without a branch, for a `mask` that is set about half the time. A comparison of `t` that follows
    /// then needs no branch on the mask.
    #[inline(always)]
    pub fn select(mask: bool, t: f32, u: f32, v: f32) -> Self {
        Self { t: core::hint::select_unpredictable(mask, t, f32::INFINITY), ..Self::new(mask, t, u, v) }
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

    /// A hit of primitive 0 in the lanes of `mask`. The other lanes keep the given values and are no hits. Writing
    /// [`Hit::MISS`] into them for every primitive made packets 0.84 to 1.01 times as fast.
    #[inline(always)]
    pub fn candidate(mask: Mask8, t: f32x8, u: f32x8, v: f32x8) -> Self {
        let number = u32x8::splat(0);
        Self { mask, t, u, v, primitive: number, instance: number }
    }

    /// A hit of primitive 0 in the lanes of `mask`, [`Hit::MISS`] in the others.
    #[inline(always)]
    pub fn new(mask: Mask8, t: f32x8, u: f32x8, v: f32x8) -> Self {
        Self::candidate(mask, t, u, v).or_miss()
    }

    /// Writes [`Hit::MISS`] into the lanes that miss.
    #[inline(always)]
    pub fn or_miss(self) -> Self {
        let Self { mask, t, u, v, primitive, instance } = self;
        let none = u32x8::splat(u32::MAX);
        Self {
            mask,
            t: mask.select(t, f32x8::splat(f32::INFINITY)),
            u: mask.select(u, f32x8::ZERO),
            v: mask.select(v, f32x8::ZERO),
            primitive: mask.select_u32(primitive, none),
            instance: mask.select_u32(instance, none),
        }
    }

    /// The hit in lane `index`.
    ///
    /// # Panics
    /// If `index >= 8`.
    #[inline]
    pub fn lane(&self, index: usize) -> Hit<f32> {
        Hit {
            mask: self.mask.lane(index),
            t: self.t.to_array()[index],
            u: self.u.to_array()[index],
            v: self.v.to_array()[index],
            primitive: self.primitive.to_array()[index],
            instance: self.instance.to_array()[index],
        }
    }

    /// The first of the lanes in the order of [`Hit::is_closer_than`]. For one ray against eight primitives, that is
    /// the closest hit.
    #[inline]
    pub fn closest(&self) -> Hit<f32> {
        if !self.mask.any() {
            return Hit::MISS;
        }
        // The minimum of pairs, then of pairs of pairs: half the latency of one after the other.
        let t = self.t.to_array();
        let halves = [0, 1, 2, 3].map(|index| min(t[index], t[index + 4]));
        let least = min(min(halves[0], halves[2]), min(halves[1], halves[3]));
        let mut tied = eq8(self.t, f32x8::splat(least)).bits();
        let mut best = self.lane(tied.trailing_zeros() as usize);
        tied &= tied - 1;
        while tied != 0 {
            let other = self.lane(tied.trailing_zeros() as usize);
            best = if other.is_closer_than(&best) { other } else { best };
            tied &= tied - 1;
        }
        best
    }

    /// Takes over these lanes from `other`. They must be hits of `other`.
    #[inline(always)]
    pub fn replace(&mut self, lanes: Mask8, other: &Self) {
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
        assert_eq!(Hit::<f32>::new(false, f32::NAN, f32::NAN, f32::NAN).to_bits(), Hit::MISS.to_bits());
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
    }

    #[test]
    fn closest_finds_the_first_lane_among_ties_and_misses() {
        let hits = |t: [f32; 8], primitive: [u32; 8]| Hit::<f32x8> {
            primitive: u32x8::new(primitive),
            ..Hit::<f32x8>::new(Mask8::from_lanes(t.map(|t| t < 9.0)), f32x8::new(t), f32x8::ZERO, f32x8::ZERO)
        };
        let closest = |t, primitive| hits(t, primitive).closest().primitive;
        assert_eq!(closest([3.0, 2.0, 1.0, 4.0, 5.0, 6.0, 7.0, 8.0], [0, 1, 2, 3, 4, 5, 6, 7]), 2);
        assert_eq!(closest([3.0, 1.0, 9.0, 1.0, 9.0, 1.0, 2.0, 9.0], [0, 7, 9, 3, 9, 5, 6, 9]), 3);
        assert_eq!(closest([-0.0, 0.0, 1.0, 9.0, 9.0, 9.0, 9.0, 9.0], [5, 4, 0, 9, 9, 9, 9, 9]), 4);
        assert_eq!(hits([9.0; 8], [u32::MAX; 8]).closest().to_bits(), Hit::MISS.to_bits());
    }
}
