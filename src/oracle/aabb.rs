//! Boxes, by slabs: each pair of planes cuts the ray's own interval in turn.
//!
//! A box is the set of the points that it contains. A ray parallel to a slab is either in it or not. An infinite
//! plane cuts nothing off. A box whose least plane is `+∞`, or whose greatest plane is `-∞`, is empty.

use core::cmp::Ordering;

use glam::Vec3;

use crate::geom::{Aabb, Placed, Ray};

use super::exact::Dyadic;
use super::number::{Line, Number, compare, minus};
use super::{ExactHit, HIT, Locate, Truth, can_hit};

impl Locate for Aabb {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        if can_hit(ray) { truth(self, &Line::<N>::of(ray), ray) } else { Some(Truth::MISS) }
    }

    fn locate_hit(&self, ray: &Ray<f32>, _truth: &Truth) -> ExactHit {
        hit(self, &Line::of(ray), ray)
    }
}

impl Locate for Placed<Aabb> {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        if !can_hit(ray) {
            return Some(Truth::MISS);
        }
        let line = Line::<N>::in_object_space(&self.object_to_world, ray)?;
        line.map_or(Some(Truth::MISS), |line| truth(&self.shape, &line, ray))
    }

    fn locate_hit(&self, ray: &Ray<f32>, _truth: &Truth) -> ExactHit {
        let line = Line::in_object_space(&self.object_to_world, ray).flatten().expect(HIT);
        hit(&self.shape, &line, ray)
    }
}

/// Where the ray enters. A box has no normal here: no ray leaves its surface.
fn hit(shape: &Aabb, line: &Line<Dyadic>, ray: &Ray<f32>) -> ExactHit {
    let segment = Segment::of(shape, line, ray).flatten().expect(HIT);
    let quotient = match segment.entry {
        Bound::Interval(t) => [Dyadic::new(t), Dyadic::new(1.0)],
        Bound::Plane { num, den } => [num, den],
    };
    ExactHit::at(ray, quotient, |_, _| [0.0; 3].map(Dyadic::new))
}

fn truth<N: Number>(shape: &Aabb, line: &Line<N>, ray: &Ray<f32>) -> Option<Truth> {
    let Some(Segment { entry, exit, in_box_plane }) = Segment::of(shape, line, ray)? else {
        return Some(Truth::MISS);
    };
    let order = entry.compare(&exit)?;
    if order.is_gt() {
        return Some(Truth::MISS);
    }
    // If entry and exit are one point, the ray touches the surface there. The exception is an interval of one point
    // that no plane cut: the box reaches beyond it on both sides.
    let touching = order.is_eq() && !matches!((&entry, &exit), (Bound::Interval(_), Bound::Interval(_)));
    Some(Truth { hit: true, boundary: in_box_plane | touching, t: entry.round()?, u: exit.round()?, v: 0.0 })
}

/// The part of the ray inside both its interval and the box. Empty if `exit` comes before `entry`.
pub(super) struct Segment<N> {
    pub(super) entry: Bound<N>,
    pub(super) exit: Bound<N>,
    /// Whether the ray runs in a plane of the box.
    pub(super) in_box_plane: bool,
}

impl<N: Number> Segment<N> {
    /// The outer `None` is a doubt. The inner `None` is an empty box, or a ray that passes it parallel to a slab.
    pub(super) fn of(shape: &Aabb, line: &Line<N>, ray: &Ray<f32>) -> Option<Option<Self>> {
        if is_empty(shape) {
            return Some(None);
        }
        let corners = N::vectors([zero_unless_finite(shape.lo), zero_unless_finite(shape.hi)]);
        let [lo, hi] = corners.map(|corner| minus(&corner.map(|plane| line.scaled(plane)), &line.origin));
        let (mut entry, mut exit) = (Bound::Interval(ray.t_min), Bound::Interval(ray.t_max));
        let mut in_box_plane = false;
        for axis in 0..3 {
            let d = &line.dir[axis];
            let lo = shape.lo[axis].is_finite().then_some(&lo[axis]);
            let hi = shape.hi[axis].is_finite().then_some(&hi[axis]);
            match d.sign()? {
                Ordering::Greater => {
                    entry = entry.latest(lo.map(|lo| Bound::plane(lo.clone(), d.clone())))?;
                    exit = exit.earliest(hi.map(|hi| Bound::plane(hi.clone(), d.clone())))?;
                }
                Ordering::Less => {
                    entry = entry.latest(hi.map(|hi| Bound::plane(hi.negated(), d.negated())))?;
                    exit = exit.earliest(lo.map(|lo| Bound::plane(lo.negated(), d.negated())))?;
                }
                Ordering::Equal => {
                    for (plane, outside) in [(lo, Ordering::Greater), (hi, Ordering::Less)] {
                        let side = plane.map_or(Some(outside.reverse()), N::sign)?;
                        if side == outside {
                            return Some(None);
                        }
                        in_box_plane |= side.is_eq();
                    }
                }
            }
        }
        Some(Some(Self { entry, exit, in_box_plane }))
    }
}

fn is_empty(shape: &Aabb) -> bool {
    let ordered = shape.lo.cmple(shape.hi) & shape.lo.cmplt(Vec3::INFINITY) & shape.hi.cmpgt(Vec3::NEG_INFINITY);
    !ordered.all()
}

/// Replaces infinite planes, which are skipped.
fn zero_unless_finite(corner: Vec3) -> Vec3 {
    Vec3::select(corner.is_finite_mask(), corner, Vec3::ZERO)
}

/// Where the ray enters or leaves: at an end of its own interval, or at a plane.
pub(super) enum Bound<N> {
    Interval(f32),
    /// `t = num / den`, `den > 0`.
    Plane {
        num: N,
        den: N,
    },
}

impl<N: Number> Bound<N> {
    fn plane(num: N, den: N) -> Self {
        Self::Plane { num, den }
    }

    fn compare(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Interval(a), Self::Interval(b)) => a.partial_cmp(b),
            (Self::Plane { num, den }, Self::Interval(t)) => compare(num, den, *t),
            (Self::Interval(t), Self::Plane { num, den }) => compare(num, den, *t).map(Ordering::reverse),
            (Self::Plane { num: n, den: d }, Self::Plane { num: m, den: e }) => n.times(e).minus(&m.times(d)).sign(),
        }
    }

    /// The later bound. The plane if they are equal.
    fn latest(self, plane: Option<Self>) -> Option<Self> {
        let Some(plane) = plane else { return Some(self) };
        Some(if plane.compare(&self)?.is_ge() { plane } else { self })
    }

    /// The earlier bound. The plane if they are equal.
    fn earliest(self, plane: Option<Self>) -> Option<Self> {
        let Some(plane) = plane else { return Some(self) };
        Some(if plane.compare(&self)?.is_le() { plane } else { self })
    }

    fn round(&self) -> Option<f32> {
        match self {
            Self::Interval(t) => Some(*t),
            Self::Plane { num, den } => num.divided_by(den),
        }
    }
}
