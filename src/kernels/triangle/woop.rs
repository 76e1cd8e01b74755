//! `triangle/woop`: the watertight test.
//!
//! **Source:** S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
//!
//! **Idea:** move the ray's origin to zero. Shear space until the ray runs along the axis on which its direction is
//! longest. This turns each vertex, by itself and with one rounding, into a point of the plane across that axis. So
//! all triangles at a vertex see the same point. It remains to decide whether the plane's origin lies in a triangle
//! of rounded points. The signs of three 2×2 determinants tell. `a·b - c·d` rounded three times has the right sign or
//! is zero, because rounding is monotonic. Where it is zero, it is computed again in `f64`, in which products of
//! `f32` numbers are exact.
//!
//! **Differs from the paper:** the other two axes always follow in cyclic order. The paper swaps them for a negative
//! direction, to keep the winding. Here both sides hit, so all three signs may change together. Only determinants
//! that are zero are computed again, not all three. `t` is interpolated with the normalised weights and divided by
//! the direction last. That saves two multiplications and keeps products in range. In a packet every lane has its own
//! axes. That takes two selections per coordinate, or none where all eight lanes agree, as they do for one ray
//! against eight triangles.
//!
//! **Edges:** closed. A ray through an edge or a vertex hits all triangles that it meets there.
//!
//! **Claims:** the triangles of a mesh still share their vertices exactly in the plane, so no point between them is
//! left out. Rounding moves a vertex by up to an ulp of its distance from the origin. If that flips a triangle, a ray
//! can hit two triangles beside it. At the rim of a mesh, where there is no other triangle, it can hit none.
//!
//! **Fails:** products overflow beyond 1e19 and vanish below 1e-23. `t` needs a finite `1 / dir` on the longest axis.
//!
//! **Degenerate input:** the rounded points of a triangle of zero area may span an area. So such triangles are found
//! when they are prepared, and are stored as NaN. That costs nothing per ray. Triangles that are not finite are
//! stored as NaN too. If the rounded points of a triangle are in line, either its three determinants are zero or
//! their signs do not agree. With three zeros, `0·∞` makes `t` NaN. A ray that can hit nothing gets a NaN in its
//! setup.
//!
//! **Seen:** of 11,200,000 rays at fans none leaked. Some rays that are not exactly on a boundary hit two triangles:
//! 22 of 1,840,000 aimed at edges; none of 3,730,000 aimed inside; 72 % of 1,560,000 that were aimed at a vertex and
//! pass it by a rounding error, because the rounded vertex is then exactly on the ray.
//!
//! **Operations:** 19 multiplications, 22 additions, 1 division, 9 minima, maxima and comparisons. Setup: 3
//! divisions. 36 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::{Vertices, normal, sign_agreement, sign_agreement8};
use crate::geom::lanes::{
    Lanes, Mask8, Vec3x8, eq8, ge8, lt8, max, max8, t_in_range, t_in_range8, to_f32x8, to_f64x8,
};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::aabb::{Slabs, VALIDITY};
use crate::kernels::plane::plane_t;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the watertight test.
    pub struct Woop<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for Woop<f32> {
    type Shape = Triangle;
    type Packet = Woop<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/woop"),
        idea: "shear the ray to an axis, then exact signs of 2×2 determinants of the rounded vertices",
        source: "Woop, Benthin, Wald, \"Watertight Ray/Triangle Intersection\", 2013",
        operations: Operations { mul: 19, add: 22, compare: 9, div: 1, reads: 9, ..Operations::NONE },
        setup: Shear::OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { vertices: prepare(shape) }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

impl Intersect<f32> for Woop<f32> {
    type Setup = Shear;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Shear {
        Shear::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Shear) -> Hit<f32> {
        let Self { vertices } = self;

        // Shear space: the ray becomes an axis.
        let sheared = Sheared::of(vertices, ray, setup);

        // Compute the weights and compare their signs.
        let mut weights = sheared.weights();
        let mut signs = sign_agreement(weights);

        // Compute again, exactly, what came out as zero.
        if signs == 0.0 {
            weights = sheared.exact_weights(weights);
            signs = sign_agreement(weights);
        }

        // Compute t and test its range.
        sheared.hit(signs >= 0.0, weights, vertices, ray, setup)
    }
}

impl<P: Lanes> Intersect<f32x8> for Woop<P> {
    type Setup = Shear8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Shear8 {
        Shear8::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Hit<f32x8> {
        let Woop { vertices } = self.widen();

        // Shear space: the ray becomes an axis.
        let sheared = Sheared8::of(&vertices, ray, setup);

        // Compute the weights and compare their signs.
        let mut weights = sheared.weights();
        let mut signs = sign_agreement8(weights);

        // Compute again, exactly, what came out as zero.
        if eq8(signs, f32x8::ZERO).any() {
            weights = sheared.exact_weights(weights);
            signs = sign_agreement8(weights);
        }

        // Compute t and test its range.
        sheared.hit(ge8(signs, f32x8::ZERO), weights, &vertices, ray, setup)
    }
}

/// The unchanged vertices, or NaN for a triangle that misses everything.
pub(super) fn prepare(shape: &Triangle) -> Vertices<f32> {
    let squared = normal(shape).length_squared();
    if squared > 0.0 && squared < f64::INFINITY {
        shape.into()
    } else {
        Vertices { v0: Vec3::NAN, v1: Vec3::NAN, v2: Vec3::NAN }
    }
}

/// How to shear space for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear {
    /// The axis along which the direction is longest.
    axis: usize,
    x: f32,
    y: f32,
    /// `1 / dir` along the axis, or NaN for a ray that misses everything.
    z: f32,
}

/// [`Shear`] in eight lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear8 {
    along_x: Mask8,
    along_y: Mask8,
    /// The axis of all eight lanes, or [`Shear8::MIXED`] where they differ.
    axis: usize,
    x: f32x8,
    y: f32x8,
    z: f32x8,
}

/// Cycles the coordinates so that the one of `axis` comes last.
#[inline(always)]
fn cycle_axes(v: Vec3, axis: usize) -> Vec3 {
    match axis {
        0 => Vec3::new(v.y, v.z, v.x),
        1 => Vec3::new(v.z, v.x, v.y),
        _ => v,
    }
}

/// [`cycle_axes`] for one axis in all lanes.
#[inline(always)]
fn cycle_axes8(v: Vec3x8, axis: usize) -> Vec3x8 {
    match axis {
        0 => Vec3x8 { x: v.y, y: v.z, z: v.x },
        1 => Vec3x8 { x: v.z, y: v.x, z: v.y },
        _ => v,
    }
}

impl Shear {
    /// Operations of [`Shear::of`].
    pub(super) const OPERATIONS: Operations = VALIDITY.and(Operations { compare: 3, div: 3, ..Operations::NONE });

    /// The shear for `ray`. Costs three divisions and the validity check.
    #[inline(always)]
    pub fn of(ray: &Ray<f32>) -> Self {
        // Find the axis along which the direction is longest.
        let size = ray.dir.abs();
        let along_x = (size.x >= size.y) & (size.x >= size.z);
        let along_y = size.y >= size.z;
        let axis = if along_x {
            0
        } else if along_y {
            1
        } else {
            2
        };

        // Compute the shear. A ray that misses everything gets a NaN.
        let d = cycle_axes(ray.dir, axis);
        let z = if ray.is_valid() { 1.0 / d.z } else { f32::NAN };
        Self { axis, x: d.x / d.z, y: d.y / d.z, z }
    }

    #[inline(always)]
    fn apply(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.x - self.x * v.z, v.y - self.y * v.z, v.z)
    }
}

impl Shear8 {
    const MIXED: usize = 3;

    /// [`Shear::of`] in eight lanes.
    #[inline(always)]
    pub fn of(ray: &Ray<f32x8>) -> Self {
        // Find the axis along which the direction is longest.
        let size = Vec3x8 { x: ray.dir.x.abs(), y: ray.dir.y.abs(), z: ray.dir.z.abs() };
        let along_x = ge8(size.x, size.y) & ge8(size.x, size.z);
        let along_y = ge8(size.y, size.z) & !along_x;
        let axis = match (along_x.bits(), along_y.bits()) {
            (0xff, _) => 0,
            (_, 0xff) => 1,
            (0, 0) => 2,
            _ => Self::MIXED,
        };

        // Compute the shear. A ray that misses everything gets a NaN.
        let d = Self::cycle_mixed_axes(ray.dir, along_x, along_y);
        let z = ray.is_valid().select(f32x8::ONE / d.z, f32x8::splat(f32::NAN));
        Self { along_x, along_y, axis, x: d.x / d.z, y: d.y / d.z, z }
    }

    #[inline(always)]
    fn cycle_mixed_axes(v: Vec3x8, along_x: Mask8, along_y: Mask8) -> Vec3x8 {
        let pick = |if_x, if_y, if_z| along_x.select(if_x, along_y.select(if_y, if_z));
        Vec3x8 { x: pick(v.y, v.z, v.x), y: pick(v.z, v.x, v.y), z: pick(v.x, v.y, v.z) }
    }

    /// [`cycle_axes`] in eight lanes, each with its own axis.
    #[inline(always)]
    fn cycle_axes(&self, [a, b, c]: [Vec3x8; 3]) -> [Vec3x8; 3] {
        let (along_x, along_y) = (self.along_x, self.along_y);
        match self.axis {
            0 => [cycle_axes8(a, 0), cycle_axes8(b, 0), cycle_axes8(c, 0)],
            1 => [cycle_axes8(a, 1), cycle_axes8(b, 1), cycle_axes8(c, 1)],
            2 => [a, b, c],
            _ => [
                Self::cycle_mixed_axes(a, along_x, along_y),
                Self::cycle_mixed_axes(b, along_x, along_y),
                Self::cycle_mixed_axes(c, along_x, along_y),
            ],
        }
    }

    #[inline(always)]
    fn apply(&self, v: Vec3x8) -> Vec3x8 {
        Vec3x8 { x: v.x - self.x * v.z, y: v.y - self.y * v.z, z: v.z }
    }
}

/// A triangle after the shear: `x` and `y` across the ray, `z` along its axis. `z` is not yet divided by the
/// direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared {
    a: Vec3,
    b: Vec3,
    c: Vec3,
}

/// [`Sheared`] in eight lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared8 {
    a: Vec3x8,
    b: Vec3x8,
    c: Vec3x8,
}

/// A hit is closer to the ray's start than this share of the farthest vertex, measured along the axis: its `t` is
/// taken from the plane.
const CANCELS: f32 = 0.125;

/// `plane_t` in the lanes of `mask`, `t` in the others. Takes everything by value: a reference would keep all of it in
/// memory.
#[cold]
#[inline(never)]
fn planes_t(mask: Mask8, Vertices { v0, v1, v2 }: Vertices<f32x8>, ray: Ray<f32x8>, t: f32x8) -> f32x8 {
    let mut t = t.to_array();
    for (lane, t) in t.iter_mut().enumerate().filter(|(lane, _)| mask.bits() >> lane & 1 == 1) {
        *t = plane_t([v0.lane(lane), v1.lane(lane), v2.lane(lane)], ray.origin.lane(lane), ray.dir.lane(lane));
    }
    f32x8::new(t)
}

#[inline(always)]
fn cross2((p, q): (Vec3, Vec3)) -> f32 {
    p.x * q.y - p.y * q.x
}

/// [`cross2`] in eight lanes.
#[inline(always)]
fn cross2x8((p, q): (Vec3x8, Vec3x8)) -> f32x8 {
    p.x * q.y - p.y * q.x
}

impl Sheared {
    #[inline(always)]
    pub(super) fn of(vertices: &Vertices<f32>, ray: &Ray<f32>, setup: &Shear) -> Self {
        let Vertices { v0, v1, v2 } = *vertices;

        // Move the origin to zero and put the ray's axis last.
        let [a, b, c] = [v0 - ray.origin, v1 - ray.origin, v2 - ray.origin];
        let [a, b, c] = [cycle_axes(a, setup.axis), cycle_axes(b, setup.axis), cycle_axes(c, setup.axis)];

        // Project onto the plane across the ray.
        Self { a: setup.apply(a), b: setup.apply(b), c: setup.apply(c) }
    }

    /// The edges opposite v1, v2 and v0, all walked in the same direction.
    #[inline(always)]
    pub(super) fn edges(&self) -> [(Vec3, Vec3); 3] {
        [(self.c, self.a), (self.a, self.b), (self.b, self.c)]
    }

    /// The weights of v1, v2 and v0, up to a common factor. Each has the right sign or is zero.
    #[inline(always)]
    pub(super) fn weights(&self) -> [f32; 3] {
        let [u, v, w] = self.edges();
        [cross2(u), cross2(v), cross2(w)]
    }

    /// The weights, with zeros computed again. What is still zero is exactly zero. Takes the triangle by value: a
    /// reference would keep all of it in memory.
    #[cold]
    #[inline(never)]
    pub(super) fn exact_weights(self, weights: [f32; 3]) -> [f32; 3] {
        let edges = self.edges();
        [0, 1, 2].map(|edge| {
            let (p, q) = edges[edge];
            let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(f64::from);
            if weights[edge] == 0.0 { (px * qy - py * qx) as f32 } else { weights[edge] }
        })
    }

    /// The hit, if the signs of the weights say `inside`. `vertices` are those before the shear.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        inside: bool,
        weights: [f32; 3],
        vertices: &Vertices<f32>,
        ray: &Ray<f32>,
        setup: &Shear,
    ) -> Hit<f32> {
        if !inside {
            return Hit::MISS;
        }

        // Normalise the weights.
        let [u, v, w] = weights;
        let inv_det = 1.0 / (u + v + w);
        let (u, v, w) = (u * inv_det, v * inv_det, w * inv_det);

        // Interpolate t. A NaN in any weight makes t NaN: a miss.
        let along = u * self.b.z + v * self.c.z + w * self.a.z;
        let mut t = along * setup.z;

        // Where the sum cancels, rounding may have changed its sign. Take t from the plane.
        let [a, b, c] = [self.a.z.abs(), self.b.z.abs(), self.c.z.abs()];
        if along.abs() < CANCELS * max(max(a, b), c) {
            t = plane_t([vertices.v0, vertices.v1, vertices.v2], ray.origin, ray.dir);
        }

        // Test the range of t.
        Hit::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl Sheared8 {
    #[inline(always)]
    pub(super) fn of(vertices: &Vertices<f32x8>, ray: &Ray<f32x8>, setup: &Shear8) -> Self {
        let Vertices { v0, v1, v2 } = *vertices;

        // Move the origin to zero and put the ray's axis last.
        let [a, b, c] = [v0 - ray.origin, v1 - ray.origin, v2 - ray.origin];
        let [a, b, c] = setup.cycle_axes([a, b, c]);

        // Project onto the plane across the ray.
        Self { a: setup.apply(a), b: setup.apply(b), c: setup.apply(c) }
    }

    /// [`Sheared::edges`] in eight lanes.
    #[inline(always)]
    pub(super) fn edges(&self) -> [(Vec3x8, Vec3x8); 3] {
        [(self.c, self.a), (self.a, self.b), (self.b, self.c)]
    }

    /// [`Sheared::weights`] in eight lanes.
    #[inline(always)]
    pub(super) fn weights(&self) -> [f32x8; 3] {
        let [u, v, w] = self.edges();
        [cross2x8(u), cross2x8(v), cross2x8(w)]
    }

    /// [`Sheared::exact_weights`] in eight lanes.
    #[cold]
    #[inline(never)]
    pub(super) fn exact_weights(self, weights: [f32x8; 3]) -> [f32x8; 3] {
        let edges = self.edges();
        [0, 1, 2].map(|edge| {
            let (p, q) = edges[edge];
            let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(to_f64x8);
            eq8(weights[edge], f32x8::ZERO).select(to_f32x8(px * qy - py * qx), weights[edge])
        })
    }

    /// [`Sheared::hit`] in eight lanes.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        inside: Mask8,
        weights: [f32x8; 3],
        vertices: &Vertices<f32x8>,
        ray: &Ray<f32x8>,
        setup: &Shear8,
    ) -> Hit<f32x8> {
        // Normalise the weights.
        let [u, v, w] = weights;
        let inv_det = f32x8::ONE / (u + v + w);
        let (u, v, w) = (u * inv_det, v * inv_det, w * inv_det);

        // Interpolate t. A NaN in any weight makes t NaN: a miss.
        let along = u * self.b.z + v * self.c.z + w * self.a.z;
        let mut t = along * setup.z;

        // Where the sum cancels, rounding may have changed its sign. Take t from the plane.
        let [a, b, c] = [self.a.z.abs(), self.b.z.abs(), self.c.z.abs()];
        let cancels = inside & lt8(along.abs(), f32x8::splat(CANCELS) * max8(max8(a, b), c));
        if cancels.any() {
            t = planes_t(cancels, *vertices, *ray, t);
        }

        // Test the range of t.
        Hit::<f32x8>::candidate(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
