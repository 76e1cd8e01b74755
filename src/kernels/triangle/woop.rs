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
//! the direction last. That saves two multiplications and keeps products in range. If there are vertices on both sides
//! of the ray's start, the terms of this sum have different signs. Where they cancel, rounding would decide the sign.
//! Then `t` is taken from the plane, with a sign that is always right (`kernels::volume`). In a packet every lane has
//! its own axes. That takes two selections per coordinate, or none where all eight lanes agree, as they do for one ray
//! against eight triangles.
//!
//! **Edges:** closed. A ray through an edge or a vertex hits all triangles that it meets there.
//!
//! **Claims:** the triangles of a mesh still share their vertices exactly in the plane, so no point between them is
//! left out. Rounding moves a vertex by up to an ulp of its distance from the origin. If that flips a triangle, a ray
//! can hit two triangles beside it. At the rim of a mesh, where there is no other triangle, it can hit none. A ray that
//! leaves a triangle does not hit it, not even from the point of `f32` next to its plane.
//!
//! **Fails:** products overflow beyond 1e19 and vanish below 1e-23. `t` needs a finite `1 / dir` on the longest axis.
//!
//! **Degenerate input:** the rounded points of a triangle of zero area may span an area. So such triangles are found
//! when they are prepared, and are stored as NaN. That costs nothing per ray. Triangles that are not finite are
//! stored as NaN too. If the rounded points of a triangle are in line, either its three determinants are zero or
//! their signs do not agree. With three zeros, `0·∞` makes `t` NaN. A ray that can hit nothing gets a NaN in its
//! setup.
//!
//! **Seen:** of 11,200,000 rays at fans none leaked. Some rays that are not exactly on a boundary hit two triangles: 22
//! of 1,840,000 aimed at edges; none of 3,730,000 aimed inside; 72 % of 1,560,000 that were aimed at a vertex and pass
//! it by a rounding error, because the rounded vertex is then exactly on the ray. Of 400,000 rays of the regime
//! `leaving`, which start 0 to 32 ulp off a triangle, none hit it. Before `t` came from the plane, a third of those
//! 3 ulp off did.
//!
//! **Cost of the right sign:** packets of the study take 1.1 times as long. In a tracer, it costs 1.0 times the time of
//! primary rays, and 1.05 to 1.1 times that of rays that start on surfaces. Two ways that cost more: comparing every
//! hit with the farthest vertex (packets 1.09 to 1.12 times), and a prepared bound (40 bytes per triangle; a tracer's
//! rays 1.1 to 1.5 times).
//!
//! **Operations:** 19 multiplications, 22 additions, 1 division, 9 minima, maxima and comparisons. Setup: 3
//! divisions. 36 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::{Vertices, normal, sign_agreement, sign_agreement8};
use crate::geom::lanes::{
    Lanes, Mask8, Vec3x8, eq8, ge8, lt8, max, max8, sign_bit, sign_bit8, t_in_range, t_in_range8, to_f32x8, to_f64x8,
};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::{Slabs, VALIDITY};
use crate::kernels::volume::plane_t;
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
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { vertices: prepare(shape) }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn candidate_in_lane(packet: &Self::Packet, lane: usize, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        let vertices = Self::lane(packet, lane).widen().vertices;
        candidate8(&vertices, ray, setup, || Self::careful_in_lane(packet, lane, ray, setup))
    }

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
    fn candidate(&self, ray: &Ray<f32>, setup: &Shear) -> Candidate<f32> {
        let Self { vertices } = self;

        // Shear space: the ray becomes an axis.
        let sheared = Sheared::of(vertices, ray, setup);

        // Compute the weights and compare their signs.
        let weights = sheared.weights();
        let signs = sign_agreement(weights);
        let inside = signs >= 0.0;
        if !inside {
            return Candidate::MISS;
        }

        // Interpolate t.
        let hit = sheared.interpolate(weights, setup);

        // Start again, exactly, where a weight came out as zero or t cancels.
        if signs == 0.0 || sheared.cancels(weights, &hit) {
            return self.careful(ray, setup);
        }

        // Test the range of t.
        hit.in_range(inside, ray)
    }
}

impl<P: Lanes> Intersect<f32x8> for Woop<P> {
    type Setup = Shear8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Shear8 {
        Shear8::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        candidate8(&self.widen().vertices, ray, setup, || self.careful8(ray, setup))
    }
}

/// The packet twin. `careful` gives the hits where this test is not exact enough.
#[inline(always)]
fn candidate8(
    vertices: &Vertices<f32x8>,
    ray: &Ray<f32x8>,
    setup: &Shear8,
    careful: impl FnOnce() -> Candidate<f32x8>,
) -> Candidate<f32x8> {
    // Shear space: the ray becomes an axis.
    let sheared = Sheared8::of(vertices, ray, setup);

    // Compute the weights and compare their signs.
    let weights = sheared.weights();
    let signs = sign_agreement8(weights);
    let inside = ge8(signs, f32x8::ZERO);

    // Interpolate t.
    let hit = sheared.interpolate(weights, setup);

    // Start again, exactly, where a weight came out as zero or t cancels.
    let zero = eq8(signs, f32x8::ZERO);
    if (zero | (inside & sheared.straddles())).any() && (zero | (inside & sheared.cancels(weights, &hit))).any() {
        return careful();
    }

    // Test the range of t.
    hit.in_range(inside, ray)
}

impl Woop<f32> {
    /// The same test, with every weight and every `t` that rounding could spoil computed exactly.
    #[cold]
    #[inline(never)]
    fn careful(&self, ray: &Ray<f32>, setup: &Shear) -> Candidate<f32> {
        let sheared = Sheared::of(&self.vertices, ray, setup);
        let weights = sheared.exact_weights(sheared.weights());
        let inside = sign_agreement(weights) >= 0.0;
        sheared.careful_hit(inside, weights, &self.vertices, ray, setup)
    }

    /// [`Woop::careful8`] for the triangle in one lane.
    #[cold]
    #[inline(never)]
    fn careful_in_lane(packet: &Woop<f32x8>, lane: usize, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        <Self as Kernel>::lane(packet, lane).careful8(ray, setup)
    }
}

impl<P: Lanes> Woop<P> {
    /// [`Woop::careful`] in eight lanes.
    #[cold]
    #[inline(never)]
    fn careful8(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        let Woop { vertices } = self.widen();
        let sheared = Sheared8::of(&vertices, ray, setup);
        let mut weights = sheared.weights();
        if eq8(sign_agreement8(weights), f32x8::ZERO).any() {
            weights = sheared.exact_weights(weights);
        }
        let inside = ge8(sign_agreement8(weights), f32x8::ZERO);
        sheared.careful_hit(inside, weights, &vertices, ray, setup)
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

/// See [`Sheared::cancels`].
const CANCELS: f32 = 8.0 / (1 << 24) as f32;

/// How to shear space for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear {
    /// The axis along which the direction is longest.
    axis: usize,
    x: f32,
    y: f32,
    /// `1 / dir` along the axis, or NaN for a ray that misses everything.
    pub(super) z: f32,
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
    pub(super) z: f32x8,
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
    pub(super) a: Vec3,
    pub(super) b: Vec3,
    pub(super) c: Vec3,
}

/// [`Sheared`] in eight lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared8 {
    pub(super) a: Vec3x8,
    pub(super) b: Vec3x8,
    pub(super) c: Vec3x8,
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

    /// The weights, with zeros computed again. What is still zero is exactly zero.
    #[inline(always)]
    pub(super) fn exact_weights(&self, weights: [f32; 3]) -> [f32; 3] {
        let edges = self.edges();
        [0, 1, 2].map(|edge| {
            let (p, q) = edges[edge];
            let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(f64::from);
            if weights[edge] == 0.0 { (px * qy - py * qx) as f32 } else { weights[edge] }
        })
    }

    /// `t`, `u` and `v` by normalised weights.
    #[inline(always)]
    pub(super) fn interpolate(&self, [u, v, w]: [f32; 3], setup: &Shear) -> Interpolated<f32> {
        // Normalise the weights.
        let inv_det = 1.0 / (u + v + w);
        let (u, v, w) = (u * inv_det, v * inv_det, w * inv_det);

        // Interpolate t. A NaN in any weight makes t NaN: a miss.
        let along = u * self.b.z + v * self.c.z + w * self.a.z;
        Interpolated { t: along * setup.z, u, v, along }
    }

    /// Whether there are vertices on both sides of the ray's start. If not, all terms of `t` have the same sign.
    #[inline(always)]
    fn straddles(&self) -> bool {
        let [a, b, c] = [self.a.z, self.b.z, self.c.z].map(sign_bit);
        (a != b) | (b != c)
    }

    /// Whether `t` may have the wrong sign, because its terms cancel.
    ///
    /// A rounding changes a weight by up to ε times the square of the largest coordinate, relative to the triangle's
    /// area across the ray. [`CANCELS`] is 8 roundings.
    #[inline(always)]
    pub(super) fn cancels(&self, [u, v, w]: [f32; 3], hit: &Interpolated<f32>) -> bool {
        if !self.straddles() {
            return false;
        }
        let Self { a, b, c } = *self;
        let size = |p: Vec3| p.x.abs() + p.y.abs() + p.z.abs();
        let depth = max(max(a.z.abs(), b.z.abs()), c.z.abs());
        let reach = max(max(size(a), size(b)), size(c));
        hit.along.abs() < CANCELS * depth * (reach * reach / (u + v + w).abs())
    }

    /// The hit by exact weights, with `t` from the plane where it cancels.
    #[inline(always)]
    pub(super) fn careful_hit(
        &self,
        inside: bool,
        weights: [f32; 3],
        vertices: &Vertices<f32>,
        ray: &Ray<f32>,
        setup: &Shear,
    ) -> Candidate<f32> {
        let hit = self.interpolate(weights, setup);
        hit.with_plane_t(inside & self.cancels(weights, &hit), vertices, ray).in_range(inside, ray)
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
    #[inline(always)]
    pub(super) fn exact_weights(&self, weights: [f32x8; 3]) -> [f32x8; 3] {
        let edges = self.edges();
        [0, 1, 2].map(|edge| {
            let (p, q) = edges[edge];
            let [px, py, qx, qy] = [p.x, p.y, q.x, q.y].map(to_f64x8);
            eq8(weights[edge], f32x8::ZERO).select(to_f32x8(px * qy - py * qx), weights[edge])
        })
    }

    /// [`Sheared::interpolate`] in eight lanes.
    #[inline(always)]
    pub(super) fn interpolate(&self, [u, v, w]: [f32x8; 3], setup: &Shear8) -> Interpolated<f32x8> {
        // Normalise the weights.
        let inv_det = f32x8::ONE / (u + v + w);
        let (u, v, w) = (u * inv_det, v * inv_det, w * inv_det);

        // Interpolate t. A NaN in any weight makes t NaN: a miss.
        let along = u * self.b.z + v * self.c.z + w * self.a.z;
        Interpolated { t: along * setup.z, u, v, along }
    }

    /// [`Sheared::straddles`] in eight lanes.
    #[inline(always)]
    pub(super) fn straddles(&self) -> Mask8 {
        sign_bit8((self.a.z ^ self.b.z) | (self.b.z ^ self.c.z))
    }

    /// [`Sheared::cancels`] in eight lanes.
    #[inline(always)]
    pub(super) fn cancels(&self, [u, v, w]: [f32x8; 3], hit: &Interpolated<f32x8>) -> Mask8 {
        let Self { a, b, c } = *self;
        let size = |p: Vec3x8| p.x.abs() + p.y.abs() + p.z.abs();
        let depth = max8(max8(a.z.abs(), b.z.abs()), c.z.abs());
        let reach = max8(max8(size(a), size(b)), size(c));
        self.straddles() & lt8(hit.along.abs(), f32x8::splat(CANCELS) * depth * (reach * reach / (u + v + w).abs()))
    }

    /// [`Sheared::careful_hit`] in eight lanes.
    #[inline(always)]
    pub(super) fn careful_hit(
        &self,
        inside: Mask8,
        weights: [f32x8; 3],
        vertices: &Vertices<f32x8>,
        ray: &Ray<f32x8>,
        setup: &Shear8,
    ) -> Candidate<f32x8> {
        let hit = self.interpolate(weights, setup);
        hit.with_plane_t(inside & self.cancels(weights, &hit), vertices, ray).in_range(inside, ray)
    }
}

/// The numbers of a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interpolated<L: Lanes> {
    t: L,
    u: L,
    v: L,
    /// `t` in coordinates along the axis.
    along: L,
}

impl Interpolated<f32> {
    /// Takes `t` from the plane where it `cancels`.
    #[inline(always)]
    fn with_plane_t(self, cancels: bool, vertices: &Vertices<f32>, ray: &Ray<f32>) -> Self {
        let Vertices { v0, v1, v2 } = *vertices;
        let t = if cancels { plane_t([v0, v1, v2], ray.origin, ray.dir) } else { self.t };
        Self { t, ..self }
    }

    /// The hit, if `t` is in the ray's interval.
    #[inline(always)]
    pub(super) fn in_range(&self, inside: bool, ray: &Ray<f32>) -> Candidate<f32> {
        Candidate::<f32>::new(inside & t_in_range(ray.t_min, self.t, ray.t_max), self.t, self.u, self.v)
    }
}

impl Interpolated<f32x8> {
    /// [`Interpolated::<f32>::with_plane_t`] in eight lanes.
    #[inline(always)]
    fn with_plane_t(self, cancels: Mask8, vertices: &Vertices<f32x8>, ray: &Ray<f32x8>) -> Self {
        let Vertices { v0, v1, v2 } = vertices;
        let mut t = self.t.to_array();
        let mut lanes = cancels.bits();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            t[lane] = plane_t([v0.lane(lane), v1.lane(lane), v2.lane(lane)], ray.origin.lane(lane), ray.dir.lane(lane));
            lanes &= lanes - 1;
        }
        Self { t: f32x8::new(t), ..self }
    }

    /// [`Interpolated::<f32>::in_range`] in eight lanes.
    #[inline(always)]
    pub(super) fn in_range(&self, inside: Mask8, ray: &Ray<f32x8>) -> Candidate<f32x8> {
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, self.t, ray.t_max), self.t, self.u, self.v)
    }
}
