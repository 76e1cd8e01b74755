//! Counts about all hits that a kernel reports for one ray: crossings, the closest hit, and the shapes' own boxes.

use crate::geom::{Hit, Ray};
use crate::kernels::aabb::InverseDirection;
use crate::kernels::box_rule::TInterval;
use crate::oracle::Truth;
use crate::study::workload::{Counts, Subject};

/// How often something happened, and how often it could have.
#[derive(Default)]
pub(super) struct Share {
    events: u64,
    pub(super) of: u64,
}

impl Share {
    fn add(&mut self, event: bool) {
        self.events += u64::from(event);
        self.of += 1;
    }

    fn merge(&mut self, other: &Self) {
        self.events += other.events;
        self.of += other.of;
    }

    /// Events per million. 0 if there could not be any.
    pub(super) fn per_million(&self) -> f64 {
        if self.of == 0 { 0.0 } else { 1e6 * self.events as f64 / self.of as f64 }
    }
}

#[derive(Default)]
pub(super) struct PerRay {
    /// Rays that hit an odd number of triangles of a closed mesh.
    pub(super) odd: Share,
    /// Rays whose closest hit is on another shape than the exact one, or that hit nothing.
    pub(super) wrong_closest: Share,
    /// Hits on a shape whose own box the ray misses.
    pub(super) rejected: Share,
    /// Hits before or behind the shape's own box.
    pub(super) clamped: Share,
}

impl PerRay {
    /// Counts what the workload asks for.
    pub(super) fn add<S: Subject>(
        &mut self,
        counts: Counts,
        ray: &Ray<f32>,
        shapes: &[S],
        truths: &[Truth],
        hits: &[Hit<f32>],
    ) {
        match counts {
            Counts::Tests | Counts::Mesh => {}
            Counts::Crossings => self.odd.add(hits.iter().filter(|hit| hit.mask).count() % 2 == 1),
            Counts::Closest => {
                if let Some(exact) = exactly_closest(truths) {
                    self.wrong_closest.add(closest(hits) != Some(exact));
                }
            }
            Counts::Boxes => {
                let slabs = InverseDirection::<f32>::of(ray);
                for (shape, hit) in shapes.iter().zip(hits).filter(|(_, hit)| hit.mask) {
                    let Some(own) = shape.own_box() else { continue };
                    let interval = TInterval::<f32>::of(&own.into(), ray.origin, &slabs);
                    self.rejected.add(interval.is_none());
                    self.clamped.add(interval.is_some_and(|interval| interval.clamp(hit.t) != hit.t));
                }
            }
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.odd.merge(&other.odd);
        self.wrong_closest.merge(&other.wrong_closest);
        self.rejected.merge(&other.rejected);
        self.clamped.merge(&other.clamped);
    }
}

/// The shape that is hit first. Between equal `t`, the lower number wins, as in the tracer.
fn closest(hits: &[Hit<f32>]) -> Option<usize> {
    let hits = hits.iter().enumerate().filter(|(_, hit)| hit.mask);
    hits.min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t)).map(|(index, _)| index)
}

/// The shape that is exactly hit first, of several. `None` if their correctly rounded `t` are equal: no `f32` tells
/// them apart. `None` also if a hit is on a boundary.
fn exactly_closest(truths: &[Truth]) -> Option<usize> {
    let mut hits: Vec<_> = truths.iter().enumerate().filter(|(_, truth)| truth.hit).collect();
    hits.sort_by(|(_, a), (_, b)| a.t.total_cmp(&b.t));
    let [(closest, first), (_, second), ..] = hits[..] else { return None };
    (first.t < second.t && hits.iter().all(|(_, truth)| !truth.boundary)).then_some(closest)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::Triangle;

    const MISS: Hit<f32> = Hit::MISS;

    fn hit(t: f32) -> Hit<f32> {
        Hit::<f32>::new(true, t, 0.25, 0.25)
    }

    fn truth(t: f32) -> Truth {
        Truth { hit: true, boundary: false, t, u: 0.25, v: 0.25 }
    }

    fn counted(counts: Counts, truths: [Truth; 2], hits: &[[Hit<f32>; 2]]) -> PerRay {
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        // The ray misses the box of the second one.
        let first = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
        let shapes = [first, Triangle { v0: Vec3::X, v1: Vec3::X + Vec3::X, v2: Vec3::X + Vec3::Y }];
        let mut per_ray = PerRay::default();
        for hits in hits {
            per_ray.add(counts, &ray, &shapes, &truths, hits);
        }
        per_ray
    }

    #[test]
    fn crossings_are_odd_if_one_of_two_triangles_is_hit() {
        let hits = [[MISS, MISS], [hit(1.0), MISS], [MISS, hit(1.0)], [hit(1.0), hit(2.0)]];
        let odd = counted(Counts::Crossings, [truth(1.0); 2], &hits).odd;
        assert_eq!((odd.events, odd.of), (2, 4));
    }

    #[test]
    fn the_closest_hit_is_wrong_if_another_one_is_reported_or_none() {
        let hits = [[hit(2.0), hit(1.0)], [hit(1.0), hit(1.0)], [hit(1.0), MISS], [MISS, MISS], [MISS, hit(3.0)]];
        let of = |truths| counted(Counts::Closest, truths, &hits).wrong_closest;
        let second = of([truth(2.0), truth(1.0)]);
        // Between equal t the lower number wins, here the wrong one.
        assert_eq!((second.events, second.of), (3, 5));
        let first = of([truth(1.0), truth(2.0)]);
        assert_eq!((first.events, first.of), (3, 5));
        // No order is exact if both are at one t, if one is missed, or if an equality decides.
        let boundary = Truth { boundary: true, ..truth(2.0) };
        for truths in [[truth(1.0), truth(1.0)], [truth(1.0), Truth::MISS], [truth(1.0), boundary]] {
            assert_eq!(of(truths).of, 0, "{truths:?}");
        }
    }

    #[test]
    fn hits_outside_the_own_box_are_rejected_or_clamped() {
        let (before, at, behind) = (1f32.next_down(), 1.0, 1.0 + 1e-5);
        let hits = [[hit(before), MISS], [hit(at), MISS], [hit(behind), hit(at)], [MISS, hit(before)]];
        let PerRay { rejected, clamped, .. } = counted(Counts::Boxes, [truth(1.0); 2], &hits);
        assert_eq!((rejected.events, rejected.of), (2, 5));
        assert_eq!((clamped.events, clamped.of), (2, 5));
    }

    #[test]
    fn nothing_is_counted_that_the_workload_does_not_ask_for() {
        for counts in [Counts::Tests, Counts::Mesh] {
            let PerRay { odd, wrong_closest, rejected, clamped } =
                counted(counts, [truth(1.0), truth(2.0)], &[[hit(1.0), hit(2.0)]]);
            assert_eq!([odd, wrong_closest, rejected, clamped].map(|share| share.of), [0; 4]);
        }
    }
}
