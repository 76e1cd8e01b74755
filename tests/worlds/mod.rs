//! Meshes, geometries and transforms for worlds that are hard for a tree over instances, and rays that are hard there.

use glam::{Affine3, Mat3, Quat, Vec2, Vec3};
use raylanes::geom::{Aabb, Quadric, Ray, Triangle};
use raylanes::tracer::{Geometry, Mesh, Part, Placement, SceneSource, World};

use raylanes::conformance::Random;

/// A number in 0..1.
pub(crate) fn unit(random: &mut Random) -> f32 {
    random.below(1 << 24) as f32 / (1u64 << 24) as f32
}

/// A point with coordinates in -1..1.
pub(crate) fn vec3(random: &mut Random) -> Vec3 {
    Vec3::new(unit(random), unit(random), unit(random)) * 2.0 - 1.0
}

pub(crate) fn pick<T: Copy>(random: &mut Random, choices: &[T]) -> T {
    choices[random.below(choices.len())]
}

/// A mesh of one colour.
pub(crate) fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::new(positions, triangles, vec![Part { first_triangle: 0, color: Vec3::ONE }]).unwrap()
}

/// The box from `-half` to `half`, which may be flat, as a mesh.
pub(crate) fn cuboid(half: Vec3) -> Mesh {
    let corner = |index: u32| Vec3::from_array([0, 1, 2].map(|axis| if index >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh((0..8).map(|index| corner(index) * half).collect(), triangles)
}

/// Triangles with vertices in -1..1. They share no vertex.
pub(crate) fn some_triangles(random: &mut Random, count: u32) -> Mesh {
    mesh(
        (0..3 * count).map(|_| vec3(random)).collect(),
        (0..count).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect(),
    )
}

/// The first geometry of a built-in scene.
pub(crate) fn built_in_mesh(name: &str) -> Mesh {
    let (geometries, _) = SceneSource::parse(name).unwrap().load().unwrap().world.into_parts();
    match geometries.into_iter().next() {
        Some(Geometry::Mesh(mesh)) => mesh,
        other => panic!("{name} begins with {other:?}"),
    }
}

/// Meshes: a sphere, boxes, a flat box, loose triangles. Quadrics: one of every kind. A disc, and
/// quadrics that discs close.
pub(crate) fn geometries(random: &mut Random) -> Vec<Geometry> {
    let sphere = built_in_mesh("sphere:1e3");
    let abc = Vec3::new(0.5, 0.75, 0.25);
    let meshes = [
        sphere,
        cuboid(Vec3::ONE),
        cuboid(Vec3::new(3.0, 3.0, 0.0)),
        cuboid(Vec3::splat(1.0 / 3.0)),
        some_triangles(random, 20),
    ];
    let quadrics = [
        Quadric::sphere(1.0),
        Quadric::ellipsoid(abc),
        Quadric::cylinder(0.5, 1.0),
        Quadric::cone(1.0, 2.0),
        Quadric::paraboloid(1.0, 2.0),
        Quadric::elliptic_paraboloid(Vec2::new(0.5, 2.0), 1.0),
        Quadric::hyperboloid_of_one_sheet(abc, 1.0),
        Quadric::hyperboloid_of_two_sheets(abc, 1.0),
        Quadric::plane(Vec2::new(1.0, 0.5)),
    ];
    let faces = [
        Geometry::disc(0.75),
        Geometry::closed_cylinder(0.5, 1.0),
        Geometry::closed_cone(1.0, 2.0),
        Geometry::closed_paraboloid(1.0, 2.0),
    ];
    meshes.into_iter().map(Geometry::Mesh).chain(quadrics.into_iter().map(Geometry::Quadric)).chain(faces).collect()
}

/// An instance with the geometry's own paint.
pub(crate) fn place(geometry: usize, object_to_world: Affine3) -> Placement {
    Placement::new(geometry as u32, object_to_world)
}

/// A rotation, mirror, shear or scale, near the origin or far from it.
pub(crate) fn transform(random: &mut Random, reach: f32) -> Affine3 {
    let turn = {
        let v = vec3(random);
        Mat3::from_quat(Quat::from_xyzw(v.x, v.y, v.z, unit(random) - 0.5).normalize())
    };
    let linear = match random.below(8) {
        0 => Mat3::IDENTITY,
        1 => turn,
        2 => turn * Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0)),
        3 => Mat3::from_diagonal(Vec3::splat(pick(random, &[1e-6, 1e-3, 1.0 / 3.0, 3.0, 1e3, 1e6]))),
        4 => turn * Mat3::from_diagonal(Vec3::new(0.1, 1.0, 10.0)) * turn.transpose(),
        5 => Mat3::from_cols(Vec3::X, vec3(random) * 3.0 + Vec3::Y * 4.0, vec3(random) + Vec3::Z * 2.0),
        6 => Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z * 0.7),
        _ => turn * pick(random, &[1e-6, 1e-2, 0.1, 3.0, 1e6]),
    };
    let far = pick(random, &[0.0, 1.0, 1.0, 1.0, 1e3]);
    Affine3 { matrix3: linear, translation: vec3(random) * reach * far }
}

/// A vertex, a point on an edge, or a point inside of the triangle.
pub(crate) fn on_triangle(random: &mut Random, Triangle { v0, v1, v2 }: Triangle) -> Vec3 {
    match random.below(4) {
        0 => v0,
        1 => (v1 + v2) * 0.5,
        2 => v0 + (v1 - v0) * unit(random),
        _ => v0 + (v1 - v0) * (0.5 * unit(random)) + (v2 - v0) * (0.5 * unit(random)),
    }
}

/// A point of the geometry, and a direction: of a mesh, a point of a triangle and the direction to its second vertex;
/// of a quadric or of faces, a point in its box and an axis as long as the box.
fn target(random: &mut Random, geometry: &Geometry) -> (Vec3, Vec3) {
    match geometry {
        Geometry::Mesh(mesh) => {
            let triangle = mesh.triangle(random.below(mesh.len()) as u32);
            let target = on_triangle(random, triangle);
            (target, triangle.v1 - target)
        }
        Geometry::Quadric(_) | Geometry::Faces(_) => {
            let Aabb { lo, hi } = geometry.bounds();
            let target = lo + (hi - lo) * (vec3(random) * 0.25 + 0.5);
            (target, pick(random, &Vec3::AXES) * (hi - lo))
        }
        other => unreachable!("no rays for {other:?}"),
    }
}

/// Rays at the instances: from inside, from near and from very far, along axes and edges, with zeros of both signs, and
/// with every kind of interval. Some miss everything.
pub(crate) fn rays(world: &World, seed: u64, count: usize) -> Vec<Ray<f32>> {
    let mut random = Random::from_seed(seed);
    (0..count)
        .map(|_| {
            let &Placement { geometry, object_to_world: Affine3 { matrix3, translation }, .. } =
                &world.instances()[random.below(world.instances().len())];
            let (target, edge) = target(&mut random, &world.geometries()[geometry as usize]);
            let size = (matrix3 * Vec3::splat(0.5)).length();
            let target = (matrix3.as_dmat3() * target.as_dvec3() + translation.as_dvec3()).as_vec3();
            let mut dir = match random.below(4) {
                0 => pick(&mut random, &Vec3::AXES) * pick(&mut random, &[size, -size]),
                1 => matrix3 * edge,
                _ => vec3(&mut random) * size,
            };
            if random.below(4) == 0 {
                dir[random.below(3)] = pick(&mut random, &[0.0, -0.0]);
            }
            let distance = pick(&mut random, &[0.0, 0.5, 1.0, 3.0, 100.0, 1e4, 1e6]);
            let origin = (target.as_dvec3() - dir.as_dvec3() * f64::from(distance)).as_vec3();
            let mut ray = Ray::new(origin, dir);
            match random.below(12) {
                0 => (ray.t_min, ray.t_max) = (f32::NEG_INFINITY, f32::INFINITY),
                1 => ray.t_max = distance,
                2 => ray.t_min = distance,
                3 => ray.t_min = -2.0,
                4 => (ray.t_min, ray.t_max) = (1.0, 0.5),
                5 => ray.dir[random.below(3)] = f32::NAN,
                6 => ray.origin[random.below(3)] = f32::INFINITY,
                _ => {}
            }
            ray
        })
        .collect()
}
