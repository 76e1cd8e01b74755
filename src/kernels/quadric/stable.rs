//! `quadric/stable`

use wide::f32x8;

use super::{Approach, Form, Span, center, roots, roots8};
use crate::geom::lanes::{Lanes, Vec3x8};
use crate::geom::{Hit, Quadric, Ray};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

/// Quadrics for the roots that keep their digits: the polynomial about a point near the surface, that point, and the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stable<P: Lanes> {
    form: Form<P>,
    center: P::Vec3,
    clip: Slabs<P>,
}

impl Kernel for Stable<f32> {
    type Shape = Quadric;
    type Packet = Stable<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/stable"),
        idea: "origin moved to the closest approach, roots as q/a and c/q",
        source: "Haines, Günther, Akenine-Möller, \"Precision Improvements for Ray/Sphere Intersection\", 2019",
        operations: Operations { mul: 44, add: 40, div: 3 },
        claims: &[],
    };

    fn prepare(shape: &Quadric) -> Self {
        let center = center(&shape.clip);
        Self { form: Form::about(shape, center), center, clip: shape.bounds().into() }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Stable {
            form: Form::gather(primitives.map(|one| one.form)),
            center: Vec3x8::from_lanes(primitives.map(|one| one.center)),
            clip: Slabs::gather(primitives.map(|one| one.clip)),
        }
    }
}

impl Intersect<f32> for Stable<f32> {
    type Setup = Approach<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Approach<f32> {
        Approach::<f32>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32>, setup: &Approach<f32>) -> Hit<f32> {
        let span = Span::<f32>::of(&self.clip, ray.origin, &setup.slabs);
        let form = &self.form;
        let from_center = ray.origin - self.center;
        let moved = span.clamp(from_center.dot(setup.back));
        let p = from_center + ray.dir * moved;

        let g = form.half_gradient(p);
        let a = form.squares.dot(setup.squares) + form.products.dot(setup.products);
        let b = setup.dir.dot(g);
        let c = p.dot(g + form.linear) + form.constant;
        let [t0, t1] = roots(a, b, c);
        span.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}

impl<P: Lanes> Intersect<f32x8> for Stable<P> {
    type Setup = Approach<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Approach<f32x8> {
        Approach::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32x8>, setup: &Approach<f32x8>) -> Hit<f32x8> {
        let span = Span::<f32x8>::of(&self.clip.widen(), ray.origin, &setup.slabs);
        let form = self.form.widen();
        let from_center = ray.origin - P::widen_vec3(self.center);
        let moved = span.clamp(from_center.dot(setup.back));
        let p = from_center + ray.dir * moved;

        let g = form.half_gradient(p);
        let a = form.squares.dot(setup.squares) + form.products.dot(setup.products);
        let b = setup.dir.dot(g);
        let c = p.dot(g + form.linear) + form.constant;
        let [t0, t1] = roots8(a, b, c);
        span.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}
