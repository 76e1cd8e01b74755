//! Triangles, by the determinants of Möller and Trumbore. Their signs decide, and their quotients are `t`, `u` and
//! `v`.
//!
//! A triangle that has zero area or is parallel to the ray has the determinant zero and misses.

use core::cmp::Ordering;

use crate::geom::{Placed, Ray, Triangle};

use super::exact::Dyadic;
use super::number::{Linear, Number, compare, cross, dot, minus};
use super::{ExactHit, HIT, Locate, Truth, can_hit};

impl Locate for Triangle {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        if !can_hit(ray) || !is_finite(self) {
            return Some(Truth::MISS);
        }
        solve(&sides::<N>(self, ray), ray)
    }

    fn locate_hit(&self, ray: &Ray<f32>, _truth: &Truth) -> ExactHit {
        hit(&sides(self, ray), ray)
    }
}

/// Transforms the triangle into the world: `t`, `u` and `v` are the same in both spaces.
impl Locate for Placed<Triangle> {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        let transform = &self.object_to_world;
        if !can_hit(ray) || !is_finite(&self.shape) || !transform.is_finite() {
            return Some(Truth::MISS);
        }
        let Some(linear) = Linear::<N>::of(transform)? else {
            return Some(Truth::MISS);
        };
        solve(&placed_sides(self, &linear, ray), ray)
    }

    fn locate_hit(&self, ray: &Ray<f32>, _truth: &Truth) -> ExactHit {
        let linear = Linear::<Dyadic>::of(&self.object_to_world).flatten().expect(HIT);
        hit(&placed_sides(self, &linear, ray), ray)
    }
}

fn is_finite(triangle: &Triangle) -> bool {
    triangle.vertices().iter().all(|vertex| vertex.is_finite())
}

/// `s`, which goes from a vertex to the ray's origin, and the edges `e1` and `e2`, which start at that vertex.
fn sides<N: Number>(triangle: &Triangle, ray: &Ray<f32>) -> [[N; 3]; 3] {
    let [o, v0, v1, v2] = &N::vectors([ray.origin, triangle.v0, triangle.v1, triangle.v2]);
    [minus(o, v0), minus(v1, v0), minus(v2, v0)]
}

/// [`sides`] of the triangle in the world.
fn placed_sides<N: Number>(triangle: &Placed<Triangle>, linear: &Linear<N>, ray: &Ray<f32>) -> [[N; 3]; 3] {
    let [v0, v1, v2] = &N::vectors(triangle.shape.vertices());
    let [o, translation] = &N::vectors([ray.origin, triangle.object_to_world.translation]);
    let s = minus(&minus(o, translation), &linear.apply(v0));
    [s, linear.apply(&minus(v1, v0)), linear.apply(&minus(v2, v0))]
}

/// The point in the plane of the triangle, by the normal.
fn hit([s, e1, e2]: &[[Dyadic; 3]; 3], ray: &Ray<f32>) -> ExactHit {
    let [d] = &Dyadic::vectors([ray.dir]);
    let normal = cross(e1, e2);
    ExactHit::at(ray, [dot(&normal, s).negated(), dot(&normal, d)], |_, _| normal)
}

/// The answer for [`sides`].
fn solve<N: Number>([s, e1, e2]: &[[N; 3]; 3], ray: &Ray<f32>) -> Option<Truth> {
    let [d] = &N::vectors([ray.dir]);
    let mut boundary = false;

    let p = cross(d, e2);
    let det = dot(e1, &p);
    // Negates the determinants if `det` is negative. Each then has the sign of its quantity.
    let facing = det.sign()?;
    let scaled = |determinant: N| if facing == Ordering::Less { determinant.negated() } else { determinant };
    if facing == Ordering::Equal {
        return Some(Truth::MISS);
    }
    let det = scaled(det);

    let u_scaled = scaled(dot(s, &p));
    match u_scaled.sign()? {
        Ordering::Less => return Some(Truth::MISS),
        side => boundary |= side.is_eq(),
    }

    let q = cross(s, e1);
    let v_scaled = scaled(dot(d, &q));
    match v_scaled.sign()? {
        Ordering::Less => return Some(Truth::MISS),
        side => boundary |= side.is_eq(),
    }
    match det.minus(&u_scaled).minus(&v_scaled).sign()? {
        Ordering::Less => return Some(Truth::MISS),
        side => boundary |= side.is_eq(),
    }

    let t_scaled = scaled(dot(e2, &q));
    match compare(&t_scaled, &det, ray.t_min)? {
        Ordering::Less => return Some(Truth::MISS),
        side => boundary |= side.is_eq(),
    }
    match compare(&t_scaled, &det, ray.t_max)? {
        Ordering::Greater => return Some(Truth::MISS),
        side => boundary |= side.is_eq(),
    }

    Some(Truth {
        hit: true,
        boundary,
        t: t_scaled.divided_by(&det)?,
        u: u_scaled.divided_by(&det)?,
        v: v_scaled.divided_by(&det)?,
    })
}
