//! `quadric/mixed`

use glam::Vec3;
use wide::f32x8;

use super::{Approach, Form, Span, roots, roots8};
use crate::geom::lanes::{Lanes, dot_f64x8, double8, to_f32x8, to_f64x8};
use crate::geom::{Hit, Quadric, Ray};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

/// Quadrics whose polynomial is evaluated in `f64` and solved in `f32`: the coefficients and the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixed<P: Lanes> {
    form: Form<P>,
    clip: Slabs<P>,
}

impl Kernel for Mixed<f32> {
    type Shape = Quadric;
    type Packet = Mixed<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/mixed"),
        idea: "b and c in f64, where they cancel; discriminant and roots in f32",
        source: "Goldberg 1991",
        operations: Operations { mul: 44, add: 40, div: 3 },
        claims: &[Claim::NoGrossError],
    };

    fn prepare(shape: &Quadric) -> Self {
        Self { form: Form::about(shape, Vec3::ZERO), clip: shape.bounds().into() }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Mixed {
            form: Form::gather(primitives.map(|one| one.form)),
            clip: Slabs::gather(primitives.map(|one| one.clip)),
        }
    }
}

impl Intersect<f32> for Mixed<f32> {
    type Setup = Approach<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Approach<f32> {
        Approach::<f32>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32>, setup: &Approach<f32>) -> Hit<f32> {
        let span = Span::<f32>::of(&self.clip, ray.origin, &setup.slabs);
        let form = &self.form;
        let moved = span.start(ray.origin, setup.back);
        let d = setup.dir.as_dvec3();
        let p = ray.origin.as_dvec3() + d * f64::from(moved * setup.unit);

        let g = form.half_gradient_f64(p);
        let a = form.squares.dot(setup.squares) + form.products.dot(setup.products);
        let b = d.dot(g) as f32;
        let c = (p.dot(g + form.linear.as_dvec3()) + f64::from(form.constant)) as f32;
        let [t0, t1] = roots(a, b, c);
        span.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}

impl<P: Lanes> Intersect<f32x8> for Mixed<P> {
    type Setup = Approach<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Approach<f32x8> {
        Approach::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32x8>, setup: &Approach<f32x8>) -> Hit<f32x8> {
        let span = Span::<f32x8>::of(&self.clip.widen(), ray.origin, &setup.slabs);
        let form = self.form.widen();
        let moved = span.start(ray.origin, setup.back);
        let (o, d) = (double8(ray.origin), double8(setup.dir));
        let step = to_f64x8(moved * setup.unit);
        let p = [0, 1, 2].map(|axis| o[axis] + d[axis] * step);

        let g = form.half_gradient_f64(p);
        let a = form.squares.dot(setup.squares) + form.products.dot(setup.products);
        let b = to_f32x8(dot_f64x8(d, g));
        let h = double8(form.linear);
        let c = to_f32x8(dot_f64x8(p, [0, 1, 2].map(|axis| g[axis] + h[axis])) + to_f64x8(form.constant));
        let [t0, t1] = roots8(a, b, c);
        span.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}
