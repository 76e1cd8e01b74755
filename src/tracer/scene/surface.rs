//! The surface at a hit: point, normal, surface parameters and colour in the world, for shading and for further rays.
//!
//! Everything is computed in `f64` from the exact transform, not from its rounded inverse, and rounded once.

use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

use glam::{Affine3, DMat3, DVec2, DVec3, Vec2, Vec3};

use super::spawn::{Footing, Leaving};
use super::two_level::Scene;
use super::world::{Geometry, Paint};
use crate::geom::{Hit, Quadric, Ray, Triangle};
use crate::kernels::Kernel;

/// The surface at the point where a ray hits it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfacePoint {
    /// The point in the world. On a triangle it comes from the hit's barycentrics, on a quadric from the hit's `t`.
    pub point: Vec3,
    /// The geometric normal in the world, of unit length, or zero where there is none, as at the apex of a cone.
    ///
    /// The normal of a triangle points to the side from which its vertices in the world appear counter-clockwise. A
    /// mirroring transform flips it. The normal of a quadric points outwards, also after mirroring.
    pub normal: Vec3,
    /// The normal for shading in the world, of unit length: where the triangle has normals at its corners, these,
    /// interpolated as the mesh holds them and transformed by the inverse transpose. It is turned to the side of
    /// [`SurfacePoint::normal`]. Without normals, or if they cancel, it is `normal`.
    pub shading_normal: Vec3,
    /// Surface parameters. On a triangle, the interpolated texture coordinates if the mesh has them there, else the
    /// barycentrics u and v of the hit.
    ///
    /// On a quadric, u is the angle about its z axis in turns, from 0 at `+x` to 1. v is the height along z between the
    /// clip planes, from 0 to 1. On a disc or a plane `z = constant`, u and v run along x and y, from 0 to 1 across it.
    pub uv: Vec2,
    /// Linear red, green and blue from 0 to 1.
    pub color: Vec3,
    /// Whether the ray came from the front side, to which the normal points. True where there is no normal.
    pub front: bool,
    /// Where rays leave; see [`SurfacePoint::spawn`].
    pub(super) footing: Footing,
}

/// The surface at a hit, before rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactSurface {
    /// The point in the world.
    pub(super) point: DVec3,
    /// The unit normal in the world; see [`SurfacePoint::normal`].
    pub(super) normal: DVec3,
    /// The point in the object's coordinates.
    pub(super) in_object: DVec3,
}

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// The surface at a hit that this scene reported for this ray.
    ///
    /// # Accuracy
    ///
    /// Take the values of the hit as exact. The error of each coordinate of the point is then at most half an ulp plus
    /// 2⁻⁴⁷ of the largest term of its sum. The angle between the normal and the exact normal is at most 2⁻²⁴ plus 2⁻⁵⁰
    /// times the condition number of the transform. The same holds for the shading normal, unless the normals at the
    /// corners nearly cancel. On a quadric, add the effect of an error in the point: 2⁻⁵⁰ of the
    /// distance from the ray's origin to the hit, or to the object.
    ///
    /// # Panics
    /// If the hit is a miss, or if this scene has no such instance or triangle.
    pub fn surface(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> SurfacePoint {
        let placement = &self.world().instances()[hit.instance as usize];
        let shape = self.shape_of(hit);
        let exact = ExactSurface::of(&shape, &placement.object_to_world, ray, hit);
        let mut surface = SurfacePoint::of(&exact, &shape, &placement.object_to_world, ray, hit);
        if let Geometry::Mesh(mesh) = &self.world().geometries()[placement.geometry as usize] {
            let primitive = self.primitive_of_mesh(hit);
            if let Some(normals) = mesh.normals(primitive) {
                let linear = placement.object_to_world.matrix3.as_dmat3();
                let world = normalized(cofactors(linear) * interpolated(hit, normals.map(Vec3::as_dvec3)));
                let side = world.dot(exact.normal);
                if side != 0.0 {
                    surface.shading_normal = (world * side.signum()).as_vec3();
                }
            }
            if let Some(corners) = mesh.texture_coordinates(primitive) {
                surface.uv = interpolated(hit, corners.map(Vec2::as_dvec2)).as_vec2();
            }
            surface.color = mesh.color(primitive);
        } else if let Leaving::Quadric(quadric) = &shape {
            surface.uv = quadric_uv(quadric, exact.in_object);
        }
        match &placement.paint {
            Paint::Own => {}
            Paint::Plain(color) => surface.color = *color,
            Paint::Checker(checker) => surface.color = checker.at(surface.uv),
        }
        surface
    }

    /// Whether the ray of a hit came from the front side; see [`SurfacePoint::front`]. It costs less than the surface.
    ///
    /// # Panics
    /// Like [`Scene::surface`].
    pub fn is_front(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> bool {
        let object_to_world = &self.world().instances()[hit.instance as usize].object_to_world;
        comes_from_front(ExactSurface::of(&self.shape_of(hit), object_to_world, ray, hit).normal, ray)
    }

    /// The number of the triangle that was hit, in its mesh; or of the face, in its geometry.
    pub(super) fn primitive_of_mesh(&self, hit: &Hit<f32>) -> u32 {
        hit.primitive - self.first_primitive(hit.instance)
    }

    /// The triangle that was hit, or the face, in the coordinates of its geometry.
    pub(crate) fn shape_of(&self, hit: &Hit<f32>) -> Leaving {
        let placement = &self.world().instances()[hit.instance as usize];
        let primitive = self.primitive_of_mesh(hit);
        match &self.world().geometries()[placement.geometry as usize] {
            Geometry::Mesh(mesh) => Leaving::Triangle(mesh.triangle(primitive)),
            faces => Leaving::Quadric(faces.quadric(primitive).expect("a mesh has no faces")),
        }
    }
}

impl SurfacePoint {
    /// That of one shape, whose colour is white, whose normal is used for shading, and whose surface parameters are
    /// those of the hit.
    #[cfg(feature = "study")]
    pub(crate) fn of_shape(shape: &Leaving, object_to_world: &Affine3, ray: &Ray<f32>, hit: &Hit<f32>) -> Self {
        Self::of(&ExactSurface::of(shape, object_to_world, ray, hit), shape, object_to_world, ray, hit)
    }

    /// [`SurfacePoint::of_shape`], where point and normal are known.
    fn of(exact: &ExactSurface, shape: &Leaving, object_to_world: &Affine3, ray: &Ray<f32>, hit: &Hit<f32>) -> Self {
        let normal = exact.normal.as_vec3();
        Self {
            point: exact.point.as_vec3(),
            normal,
            shading_normal: normal,
            uv: Vec2::new(hit.u, hit.v),
            color: Vec3::ONE,
            front: comes_from_front(exact.normal, ray),
            footing: Footing::of(exact, ray, hit.t, shape, object_to_world),
        }
    }
}

impl ExactSurface {
    /// That of one shape.
    fn of(shape: &Leaving, object_to_world: &Affine3, ray: &Ray<f32>, hit: &Hit<f32>) -> Self {
        let (linear, translation) = (object_to_world.matrix3.as_dmat3(), object_to_world.translation.as_dvec3());
        let (point, normal, in_object) = match shape {
            Leaving::Triangle(triangle) => {
                let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
                let (e1, e2) = (v1 - v0, v2 - v0);
                let in_object = v0 + e1 * f64::from(hit.u) + e2 * f64::from(hit.v);
                (linear * in_object + translation, (linear * e1).cross(linear * e2), in_object)
            }
            Leaving::Quadric(quadric) => {
                let (origin, along) = (ray.origin.as_dvec3(), ray.dir.as_dvec3() * f64::from(hit.t));
                // The translation is subtracted first, as for the ray. So a position far from the world's origin costs
                // no accuracy.
                let in_object = linear.inverse() * ((origin - translation) + along);
                (origin + along, cofactors(linear) * gradient(quadric, in_object), in_object)
            }
        };
        Self { point, normal: normalized(normal), in_object }
    }
}

/// Whether a ray comes from the side to which the normal points. True without a normal.
fn comes_from_front(normal: DVec3, ray: &Ray<f32>) -> bool {
    normal.dot(ray.dir.as_dvec3()) <= 0.0
}

/// The value at a hit, from those at the corners of the triangle.
fn interpolated<V>(hit: &Hit<f32>, [v0, v1, v2]: [V; 3]) -> V
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>,
{
    v0 + (v1 - v0) * f64::from(hit.u) + (v2 - v0) * f64::from(hit.v)
}

/// The matrix of cofactors with the sign of the determinant. It is a positive multiple of the inverse transpose, which
/// transforms gradients to the world, and needs no division.
fn cofactors(linear: DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if x.dot(cofactors.x_axis) < 0.0 { -cofactors } else { cofactors }
}

/// The quadric's polynomial.
pub(super) fn value(quadric: &Quadric, point: DVec3) -> f64 {
    let DVec3 { x, y, z } = point;
    let Quadric { squares, products, linear, constant, .. } = quadric;
    let (squares, products, linear) = (squares.as_dvec3(), products.as_dvec3(), linear.as_dvec3());
    squares.dot(point * point)
        + products.dot(DVec3::new(y * z, z * x, x * y))
        + linear.dot(point)
        + f64::from(*constant)
}

/// Gradient of the quadric's polynomial. It points outwards.
pub(super) fn gradient(quadric: &Quadric, point: DVec3) -> DVec3 {
    let (squares, linear) = (quadric.squares.as_dvec3(), quadric.linear.as_dvec3());
    let (DVec3 { x, y, z }, DVec3 { x: yz, y: zx, z: xy }) = (point, quadric.products.as_dvec3());
    squares * point * 2.0 + DVec3::new(xy * y + zx * z, xy * x + yz * z, zx * x + yz * y) + linear
}

/// Surface parameters of a quadric; see [`SurfacePoint::uv`].
fn quadric_uv(quadric: &Quadric, point: DVec3) -> Vec2 {
    // The padding of the clip box allows hits slightly outside the clip planes.
    let between_clip_planes = |axis: usize| {
        let (bottom, top) = (f64::from(quadric.clip.lo[axis]), f64::from(quadric.clip.hi[axis]));
        let share = if top > bottom { (point[axis] - bottom) / (top - bottom) } else { 0.0 };
        share.clamp(0.0, 1.0) as f32
    };
    let Quadric { squares, products, linear, .. } = quadric;
    if (*squares, *products, linear.truncate()) == (Vec3::ZERO, Vec3::ZERO, Vec2::ZERO) {
        return Vec2::new(between_clip_planes(0), between_clip_planes(1));
    }
    let turn = DVec2::new(point.x, point.y).to_angle() / TAU;
    Vec2::new((if turn < 0.0 { turn + 1.0 } else { turn }) as f32, between_clip_planes(2))
}

/// The vector scaled to unit length, for vectors of any length. Zero stays zero.
fn normalized(vector: DVec3) -> DVec3 {
    // First scale the largest component to 1: the square of the length may be beyond the range of f64.
    (vector / vector.abs().max_element()).normalize_or_zero()
}
