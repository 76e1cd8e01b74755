//! What the tests of all models share, and the tests of all models together.

use glam::{Affine3, EulerRot, Quat, Vec2};

use super::*;
use crate::geom::{Hit, Ray};
use crate::kernels::triangle::Exact;
use crate::tracer::{Geometry, Mesh, Mode, Part, Placement, Scene, SceneSource, View, trace};

pub(super) const RED: Vec3 = Vec3::new(0.9, 0.1, 0.1);
pub(super) const BLUE: Vec3 = Vec3::new(0.1, 0.1, 0.9);

/// The world of a built-in scene.
pub(super) fn built_in(name: &str) -> World {
    SceneSource::parse(name).unwrap().load().unwrap().world
}

/// The first mesh of a built-in scene.
pub(super) fn mesh(name: &str) -> Mesh {
    match &built_in(name).geometries()[0] {
        Geometry::Mesh(mesh) => mesh.clone(),
        other => panic!("{other:?}"),
    }
}

/// A mesh of one colour.
pub(super) fn colored(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, color: Vec3) -> Mesh {
    Mesh::new(positions, triangles, vec![Part { first_triangle: 0, color }]).unwrap()
}

/// With a normal and texture coordinates of its own at each corner.
pub(super) fn with_values(mesh: Mesh) -> Mesh {
    let corners: Vec<_> = (0..mesh.len() as u32).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect();
    let number = |index: usize| (index as f32 * 0.618).fract();
    let normals = (0..3 * mesh.len()).map(|index| Vec3::new(number(index), 1.0, number(index + 7))).collect();
    let uvs = (0..3 * mesh.len()).map(|index| Vec2::new(number(index + 1), number(index + 2))).collect();
    mesh.with_normals(normals, corners.clone()).unwrap().with_texture_coordinates(uvs, corners).unwrap()
}

pub(super) fn moved(mesh: &Mesh, transform: Affine3) -> Mesh {
    mesh.mapped(|point| transform.transform_point3(point), |normal| normal).unwrap()
}

/// A world of geometries that all have one instance.
pub(super) fn world(placed: Vec<(Geometry, Affine3)>) -> World {
    let (geometries, transforms): (Vec<_>, Vec<_>) = placed.into_iter().unzip();
    let instances = (0..).zip(transforms).map(|(number, transform)| Placement::new(number, transform)).collect();
    World::new(geometries, instances).unwrap()
}

/// A rotation about no axis in particular.
pub(super) fn rotation() -> Affine3 {
    Affine3::from_quat(Quat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7))
}

/// The mesh, and the same surface otherwise: rotated, enlarged, far away; with triangles in another order and from
/// another corner, and vertices in another order.
pub(super) fn variants(mesh: &Mesh) -> Vec<(&'static str, Mesh)> {
    let mut order: Vec<u32> = (0..mesh.len() as u32).collect();
    order.sort_by_key(|&number| number.wrapping_mul(0x9e37_79b1));
    let shuffled = mesh.subset(&order);
    let last = mesh.positions().len() as u32 - 1;
    let turned = shuffled.triangles().iter().map(|&[a, b, c]| [last - b, last - c, last - a]).collect();
    let positions = shuffled.positions().iter().rev().copied().collect();
    let renumbered = Mesh::new(positions, turned, shuffled.parts().to_vec()).unwrap();
    let far = Affine3::from_translation(Vec3::new(1.0, -0.5, 0.25) * mesh.bounds().diagonal() as f32 * 20.0);
    vec![
        ("as it is", mesh.clone()),
        ("rotated", moved(mesh, rotation())),
        ("enlarged", moved(mesh, Affine3::from_scale(Vec3::splat(1000.0)))),
        ("far away", moved(mesh, far)),
        ("shuffled", shuffled),
        ("renumbered", renumbered),
    ]
}

/// Rays at the world from outside. Their origins are on a coarse grid, so that they can be moved without rounding.
pub(super) fn rays(world: &World) -> Vec<Ray<f32>> {
    let bounds = world.bounds();
    let step = (bounds.diagonal().log2().ceil().exp2() / 256.0) as f32;
    let mut rays = View::around(&bounds).camera(80, 80).rays(80, 80);
    for ray in &mut rays {
        ray.origin = (ray.origin / step).round() * step;
    }
    rays
}

/// A hit, and how its surface looks: normal, texture coordinates, colour.
pub(super) type Seen = (Hit<f32>, Vec3, Vec2, Vec3);

pub(super) fn seen(world: &World, rays: &[Ray<f32>]) -> Vec<Option<Seen>> {
    let scene = Scene::<Exact<f32>>::new(world.clone());
    let looks = |(ray, hit): (&Ray<f32>, Hit<f32>)| {
        hit.mask.then(|| {
            let surface = scene.surface(ray, &hit);
            (hit, surface.shading_normal, surface.uv, surface.color)
        })
    };
    rays.iter().zip(trace(&scene, rays, Mode::Auto)).map(looks).collect()
}

/// Asserts that every ray sees the same in both worlds, bit for bit.
pub(super) fn assert_same_picture(world: &World, simpler: &SimplerModel) {
    assert_eq!(simpler.deviation, Deviation::None);
    let rays_there = rays(&simpler.world);
    let back = |ray: &Ray<f32>| {
        let origin = ray.origin - simpler.moved_by;
        assert_eq!(origin + simpler.moved_by, ray.origin);
        Ray { origin, dir: ray.dir, t_min: ray.t_min, t_max: ray.t_max }
    };
    let rays_here: Vec<_> = rays_there.iter().map(back).collect();
    let bits = |seen: Option<Seen>| {
        seen.map(|(hit, normal, uv, color)| ([hit.t, hit.u, hit.v].map(f32::to_bits), normal, uv, color))
    };
    let (here, there) = (seen(world, &rays_here), seen(&simpler.world, &rays_there));
    assert!(here.iter().flatten().count() > rays_here.len() / 100);
    for ((ray, here), there) in rays_here.iter().zip(here).zip(there) {
        assert_eq!(bits(here), bits(there), "{ray:?}");
    }
}

/// Asserts that nearly all rays that hit see the same colour at nearly the same place. At silhouettes, `t` may differ
/// by far more than the surfaces.
pub(super) fn assert_similar_picture(world: &World, simpler: &SimplerModel) {
    let rays = rays(world);
    let (here, there) = (seen(world, &rays), seen(&simpler.world, &rays));
    let tolerance = 4.0 * simpler.deviation.distance() + 1e-5 * world.bounds().diagonal();
    let is_similar = |ray: &Ray<f32>, here: &Option<Seen>, there: &Option<Seen>| match (here, there) {
        (Some((hit, .., color)), Some((other, .., other_color))) => {
            f64::from((hit.t - other.t).abs() * ray.dir.length()) <= tolerance && color == other_color
        }
        _ => false,
    };
    let (mut hits, mut similar) = (0, 0);
    for (ray, (here, there)) in rays.iter().zip(here.iter().zip(&there)) {
        hits += usize::from(here.is_some() || there.is_some());
        similar += usize::from(is_similar(ray, here, there));
    }
    assert!(hits > rays.len() / 100, "{hits}");
    assert!(similar * 100 >= hits * 95, "{similar} of {hits}: {}", simpler.about);
}

#[test]
fn built_in_scenes_are_as_simple_as_they_look() {
    for (name, expected) in [
        ("room:small", &[][..]),
        ("terrain:1e3", &[]),
        ("gallery", &[]),
        ("forest:1000", &[]),
        ("sphere:small", &[quadrics::NAME]),
    ] {
        let found: Vec<_> = simpler_models(&built_in(name)).into_iter().map(|model| model.name).collect();
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn models_are_combined_in_order_and_sharing_is_not_baked() {
    let sphere = mesh("sphere:1e3");
    let far = Affine3::from_translation(Vec3::new(1e5, 0.0, 0.0));
    let beside = Affine3::from_translation(Vec3::new(1e5, 2.5, 0.0));
    // A triangle of no area, and one that is there twice.
    let numbers: Vec<u32> = [0, 0].into_iter().chain(0..sphere.len() as u32).collect();
    let flawed = sphere.subset(&numbers);
    let mut triangles = flawed.triangles().to_vec();
    triangles[0] = [5, 5, 6];
    let flawed = colored(flawed.positions().to_vec(), triangles, RED);
    let world = world(vec![(flawed.clone().into_geometry(), far), (flawed.into_geometry(), beside)]);

    let all = combined(&world, |model| model.deviation.keeps_surface()).unwrap();
    let [shared] = all.world.geometries() else { panic!("{}", all.about) };
    assert_eq!(shared.primitives(), sphere.len());
    assert_eq!(all.world.instances().len(), 2);
    assert_eq!(all.moved_by.x, -1e5);
    assert_same_picture(&world, &all);

    let round = combined(&world, |_| true).unwrap();
    assert_eq!((round.world.triangles(), round.world.quadrics()), (0, 1), "{}", round.about);
    assert!(!round.deviation.keeps_surface());
    let baked = combined(&world, |model| model.name == bake::NAME).map(|model| model.world.instances().len());
    assert_eq!(baked, None, "too far away to be baked");
    assert!(combined(&built_in("terrain:1e3"), |_| true).is_none());

    let near = [0.0, 2.5].map(|x| (sphere.clone().into_geometry(), Affine3::from_translation(Vec3::X * x)));
    let shared = combined(&self::world(near.to_vec()), |model| model.deviation.keeps_surface()).unwrap();
    assert_eq!((shared.name, shared.world.instances().len()), (share::NAME, 2));
}

/// Meshes as geometries, for short.
pub(super) trait IntoGeometry {
    fn into_geometry(self) -> Geometry;
}

impl IntoGeometry for Mesh {
    fn into_geometry(self) -> Geometry {
        Geometry::Mesh(self)
    }
}
