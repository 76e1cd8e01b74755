//! Candidates: what a kernel finds out about one primitive, before it becomes a hit.

use wide::{f32x8, u32x8};

use super::hit::Hit;
use super::lanes::{Lanes, Mask, Mask8, eq8, min};

/// Outcome of one test: which lanes hit, and with which values. A lane that misses may hold anything, also NaN.
///
/// A kernel returns candidates, because writing [`Hit::MISS`] into lanes that miss, for every primitive, made packets
/// 0.84 to 1.01 times as fast. A loop over primitives [keeps the closer one](Hit::keep_closer) of each lane;
/// [`Candidate::or_miss`] makes a hit of a single one.
///
/// ```
/// use glam::Vec3;
/// use raylanes::geom::{Hit, Ray, Triangle};
/// use raylanes::kernels::triangle::ExactHalfOpen;
/// use raylanes::kernels::{Intersect, Kernel};
/// use wide::{f32x8, u32x8};
///
/// let near = ExactHalfOpen::prepare(&Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y });
/// let far = ExactHalfOpen::prepare(&Triangle { v0: Vec3::NEG_Z, v1: Vec3::new(1.0, 0.0, -1.0), v2: Vec3::Y });
/// let ray = Ray::splat(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z));
/// let setup = <ExactHalfOpen<f32> as Intersect<f32x8>>::setup(&ray);
///
/// // Eight rays, one triangle after the other.
/// let mut closest = Hit::<f32x8>::miss();
/// for (number, triangle) in [far, near].into_iter().enumerate() {
///     let candidate = Intersect::<f32x8>::candidate(&triangle, &ray, &setup);
///     closest.keep_closer(&candidate.of_primitives(u32x8::splat(number as u32)));
/// }
/// assert_eq!((closest.lane(7).primitive, closest.lane(7).t), (1, 1.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Candidate<L: Lanes> {
    hit: Hit<L>,
}

impl<L: Lanes> Candidate<L> {
    /// Which lanes hit.
    #[inline(always)]
    pub fn mask(&self) -> L::Mask {
        self.hit.mask
    }

    /// Ray parameter. Undefined in lanes that miss.
    #[inline(always)]
    pub fn t(&self) -> L {
        self.hit.t
    }

    /// First surface parameter. Undefined in lanes that miss.
    #[inline(always)]
    pub fn u(&self) -> L {
        self.hit.u
    }

    /// Second surface parameter. Undefined in lanes that miss.
    #[inline(always)]
    pub fn v(&self) -> L {
        self.hit.v
    }

    /// The hit: [`Hit::MISS`] in lanes that miss.
    #[inline(always)]
    pub fn or_miss(self) -> Hit<L> {
        L::or_miss(self)
    }

    /// The hits, from the first lane that hits to the last.
    #[inline(always)]
    pub fn hits(&self) -> impl Iterator<Item = Hit<f32>> {
        self.hit.mask.set_lanes().map(|lane| self.hit.lane(lane))
    }

    /// The values of all lanes, also of those that miss.
    #[inline(always)]
    pub(super) fn values(self) -> Hit<L> {
        self.hit
    }
}

/// A hit is a candidate whose lanes that miss are defined.
impl<L: Lanes> From<Hit<L>> for Candidate<L> {
    #[inline(always)]
    fn from(hit: Hit<L>) -> Self {
        Self { hit }
    }
}

impl Candidate<f32> {
    /// A miss.
    pub const MISS: Self = Self { hit: Hit::MISS };

    /// A hit of primitive 0 if `mask` is set. Its `t`, `u` and `v` must then be numbers.
    #[inline(always)]
    pub fn new(mask: bool, t: f32, u: f32, v: f32) -> Self {
        if mask { Self { hit: Hit { mask, t, u, v, primitive: 0, instance: 0 } } } else { Self::MISS }
    }

    /// [`Candidate::<f32>::new`] without a branch, for a `mask` that is set about half the time. A comparison of `t`
    /// that follows then needs no branch on the mask.
    #[inline(always)]
    pub fn select(mask: bool, t: f32, u: f32, v: f32) -> Self {
        let hit = Self::new(mask, t, u, v).hit;
        Self { hit: Hit { t: core::hint::select_unpredictable(mask, t, f32::INFINITY), ..hit } }
    }
}

impl Candidate<f32x8> {
    /// A hit of primitive 0 in the lanes of `mask`. There, `t`, `u` and `v` must be numbers.
    #[inline(always)]
    pub fn new(mask: Mask8, t: f32x8, u: f32x8, v: f32x8) -> Self {
        let number = u32x8::splat(0);
        Self { hit: Hit { mask, t, u, v, primitive: number, instance: number } }
    }

    /// Only the hits in these lanes, with another `t`, which must be a number there.
    #[inline(always)]
    pub fn narrowed(self, lanes: Mask8, t: f32x8) -> Self {
        let Hit { mask, u, v, primitive, instance, .. } = self.hit;
        Self { hit: Hit { mask: mask & lanes, t, u, v, primitive, instance } }
    }

    /// With these primitive numbers: eight of one primitive, or those of eight primitives that met one ray.
    #[inline(always)]
    pub fn of_primitives(self, primitive: u32x8) -> Self {
        let Hit { mask, t, u, v, instance, .. } = self.hit;
        Self { hit: Hit { mask, t, u, v, primitive, instance } }
    }

    /// In this instance.
    #[inline(always)]
    pub fn of_instance(self, instance: u32) -> Self {
        let Hit { mask, t, u, v, primitive, .. } = self.hit;
        Self { hit: Hit { mask, t, u, v, primitive, instance: u32x8::splat(instance) } }
    }

    /// The first of the lanes that hit, in the order of [`Hit::is_closer_than`]. For one ray against eight primitives,
    /// that is the closest hit.
    #[inline]
    pub fn closest(&self) -> Hit<f32> {
        let Self { hit } = self;
        if !hit.mask.any() {
            return Hit::MISS;
        }
        let infinite = f32x8::splat(f32::INFINITY);
        let t = hit.mask.select(hit.t, infinite);
        // The minimum of pairs, then of pairs of pairs: half the latency of one after the other.
        let lanes = t.to_array();
        let halves = [0, 1, 2, 3].map(|index| min(lanes[index], lanes[index + 4]));
        let least = min(min(halves[0], halves[2]), min(halves[1], halves[3]));
        let mut tied = (hit.mask & eq8(t, f32x8::splat(least))).bits();
        let mut best = hit.lane(tied.trailing_zeros() as usize);
        tied &= tied - 1;
        while tied != 0 {
            let other = hit.lane(tied.trailing_zeros() as usize);
            best = if other.is_closer_than(&best) { other } else { best };
            tied &= tied - 1;
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closest_finds_the_first_lane_among_ties_and_ignores_lanes_that_miss() {
        for missing in [f32::NAN, -1.0, 0.0, f32::NEG_INFINITY, f32::INFINITY] {
            let candidates = |t: [f32; 8], primitive: [u32; 8]| {
                let mask = Mask8::from_lanes(t.map(|t| t < 9.0));
                let t = f32x8::new(t.map(|t| if t < 9.0 { t } else { missing }));
                Candidate::<f32x8>::new(mask, t, t, f32x8::ZERO).of_primitives(u32x8::new(primitive))
            };
            let closest = |t, primitive| candidates(t, primitive).closest().primitive;
            assert_eq!(closest([3.0, 2.0, 1.0, 4.0, 5.0, 6.0, 7.0, 8.0], [0, 1, 2, 3, 4, 5, 6, 7]), 2);
            assert_eq!(closest([3.0, 1.0, 9.0, 1.0, 9.0, 1.0, 2.0, 9.0], [0, 7, 9, 3, 9, 5, 6, 9]), 3);
            assert_eq!(closest([-0.0, 0.0, 1.0, 9.0, 9.0, 9.0, 9.0, 9.0], [5, 4, 0, 9, 9, 9, 9, 9]), 4);
            assert_eq!(closest([9.0, 9.0, 9.0, 7.0, 9.0, 9.0, 9.0, 9.0], [0, 0, 0, 6, 0, 0, 0, 0]), 6);
            assert_eq!(candidates([9.0; 8], [3; 8]).closest().to_bits(), Hit::MISS.to_bits());
        }
        // An infinite t is possible: a box that is never left.
        let infinite = f32x8::splat(f32::INFINITY);
        let one = Mask8::from_lanes([false, false, true, false, false, false, false, false]);
        let hit =
            Candidate::<f32x8>::new(one, infinite, infinite, f32x8::ZERO).of_primitives(u32x8::splat(5)).closest();
        assert_eq!((hit.mask, hit.t, hit.primitive), (true, f32::INFINITY, 5));
    }

    #[test]
    fn lanes_that_miss_become_the_one_miss() {
        let nan = f32x8::splat(f32::NAN);
        let t = f32x8::new([f32::NAN, 2.0, -0.0, f32::NAN, -1.0, 0.0, 1.0, f32::INFINITY]);
        let mask = Mask8::from_lanes([false, true, false, false, true, false, false, false]);
        let hits = Candidate::<f32x8>::new(mask, t, mask.select(t, nan), mask.select(t, nan)).or_miss();
        for lane in [0, 2, 3, 5, 6, 7] {
            assert_eq!(hits.lane(lane).to_bits(), Hit::MISS.to_bits());
        }
        assert_eq!(hits.lane(4).to_bits(), Hit::<f32>::new(true, -1.0, -1.0, -1.0).to_bits());
        assert_eq!(Candidate::<f32>::select(false, f32::NAN, 1.0, 1.0).or_miss().to_bits(), Hit::MISS.to_bits());
    }
}
