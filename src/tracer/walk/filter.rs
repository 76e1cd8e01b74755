//! Which hits count: all of them, or those that a caller accepts.

use wide::f32x8;

use crate::geom::{Candidate, Hit, Mask8, Ray};

/// Decides which hits count. A closure `|ray, hit| -> bool` is a filter.
///
/// A hit that is refused is as if the primitive were not there. The answer may depend on the ray and the hit only. Then
/// the closest hit does not depend on the order in which a tree is searched, and stays the same for every mode.
pub trait Filter {
    /// Whether every hit counts. Then nothing is asked.
    #[doc(hidden)]
    const ALL: bool = false;

    /// Whether this hit counts.
    fn accepts(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> bool;

    /// [`Filter::accepts`] for a hit of an instance. `t_in_object` is its `t` before it was clamped to the instance's
    /// box in the world.
    #[doc(hidden)]
    #[inline(always)]
    fn accepts_in_instance(&self, ray: &Ray<f32>, hit: &Hit<f32>, t_in_object: f32) -> bool {
        let _ = t_in_object;
        self.accepts(ray, hit)
    }
}

impl<F: Fn(&Ray<f32>, &Hit<f32>) -> bool> Filter for F {
    #[inline(always)]
    fn accepts(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> bool {
        self(ray, hit)
    }
}

/// The filter that accepts every hit.
#[derive(Clone, Copy, Debug)]
pub struct Everything;

impl Filter for Everything {
    const ALL: bool = true;

    #[inline(always)]
    fn accepts(&self, _: &Ray<f32>, _: &Hit<f32>) -> bool {
        true
    }
}

/// The candidates that count, of eight rays.
#[inline(always)]
pub(crate) fn accepted<F: Filter>(candidates: Candidate<f32x8>, ray: &Ray<f32x8>, filter: &F) -> Candidate<f32x8> {
    if F::ALL {
        return candidates;
    }
    let hits = candidates.or_miss();
    let accepts = |lane| hits.mask.lane(lane) && filter.accepts(&ray.lane(lane), &hits.lane(lane));
    candidates.narrowed(Mask8::from_lanes(std::array::from_fn(accepts)), candidates.t())
}

/// The closest of the candidates that count.
#[inline(always)]
pub(crate) fn closest_accepted<F: Filter>(
    candidates: &Candidate<f32x8>,
    ray: impl Fn() -> Ray<f32>,
    filter: &F,
) -> Hit<f32> {
    if F::ALL {
        return candidates.closest();
    }
    let ray = ray();
    let accepted = candidates.hits().filter(|hit| filter.accepts(&ray, hit));
    accepted.fold(Hit::MISS, |best, hit| if hit.is_closer_than(&best) { hit } else { best })
}
