//! The box rule: every way of tracing a ray gives the same bits. Trying all triangles, single rays, packets, coherent and
//! shuffled order, one thread and two, closest hit and any hit.

mod random;

use glam::Vec3;
use raylanes::geom::{Hit, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::tracer::{Geometry, LoadedScene, Mesh, Mode, Part, Scene, SceneSource, thread_pool, trace};

use random::Random;

/// In 0..1.
fn unit(random: &mut Random) -> f32 {
    random.below(1 << 24) as f32 / (1u64 << 24) as f32
}

fn vec3(random: &mut Random) -> Vec3 {
    Vec3::new(unit(random), unit(random), unit(random)) * 2.0 - 1.0
}

/// Rays that make trouble: at vertices and edges, where triangles tie; along axes, within the planes of boxes; with every
/// kind of interval; and some that miss everything.
fn hard_rays(mesh: &Mesh, count: usize) -> Vec<Ray<f32>> {
    let mut random = Random(7);
    let size = mesh.bounds().extent().length();
    (0..count)
        .map(|_| {
            let Triangle { v0, v1, v2 } = mesh.triangle(random.below(mesh.len()) as u32);
            let target = match random.below(4) {
                0 => v0,
                1 => (v1 + v2) * 0.5,
                2 => v0 + (v1 - v0) * unit(&mut random),
                _ => v0 + (v1 - v0) * (0.5 * unit(&mut random)) + (v2 - v0) * (0.5 * unit(&mut random)),
            };
            let mut dir = match random.below(4) {
                0 => Vec3::AXES[random.below(3)] * if random.below(2) == 0 { size } else { -size },
                1 => v1 - target,
                _ => vec3(&mut random) * size,
            };
            if random.below(4) == 0 {
                dir[random.below(3)] = -0.0;
            }
            let distance = [0.0, 0.5, 1.0, 3.0][random.below(4)];
            let mut ray = Ray::new(target - dir * distance, dir);
            match random.below(12) {
                0 => (ray.t_min, ray.t_max) = (f32::NEG_INFINITY, f32::INFINITY),
                1 => ray.t_max = distance,
                2 => ray.t_min = distance,
                3 => (ray.t_min, ray.t_max) = (1.0, 0.5),
                4 => ray.dir[random.below(3)] = f32::NAN,
                5 => ray.origin[random.below(3)] = f32::INFINITY,
                _ => {}
            }
            ray
        })
        .collect()
}

fn assert_same(what: &str, rays: &[Ray<f32>], expected: &[Hit<f32>], got: &[Hit<f32>]) {
    assert_eq!(expected.len(), got.len());
    for (index, (a, b)) in expected.iter().zip(got).enumerate() {
        assert!(
            a.mask == b.mask && a.to_bits() == b.to_bits(),
            "{what}: ray {index} {:?}\nexpected {a:?} {:08x?}\ngot      {b:?} {:08x?}",
            rays[index],
            a.to_bits(),
            b.to_bits()
        );
    }
}

/// Traces the rays in every way; brute force gets every `stride`-th.
fn every_way<K: Kernel<Shape = Triangle>>(name: &str, scene: &Scene<K>, rays: &[Ray<f32>], stride: usize) {
    let name = format!("{name}, {}", K::INFO.id);
    let expected = trace(scene, rays, false, Mode::Scalar);
    let hits = expected.iter().filter(|hit| hit.mask).count();
    assert!(hits * 5 > rays.len(), "{name}: only {hits} of {} rays hit", rays.len());

    let some: Vec<_> = rays.iter().step_by(stride).copied().collect();
    let brute: Vec<_> = some.iter().map(|ray| scene.closest_hit_brute_force(ray)).collect();
    let tree: Vec<_> = expected.iter().step_by(stride).copied().collect();
    assert_same(&format!("{name}: tree and brute force"), &some, &brute, &tree);

    let mut order: Vec<usize> = (0..rays.len()).collect();
    let mut random = Random(1);
    for last in (1..order.len()).rev() {
        order.swap(last, random.below(last + 1));
    }
    let shuffled: Vec<_> = order.iter().map(|&index| rays[index]).collect();
    let expected_shuffled: Vec<_> = order.iter().map(|&index| expected[index]).collect();
    let masks = |hits: &[Hit<f32>]| {
        hits.iter()
            .map(|hit| if hit.mask { Hit::<f32>::new(true, 0.0, 0.0, 0.0) } else { Hit::MISS })
            .collect::<Vec<_>>()
    };
    for mode in Mode::ALL {
        for threads in [1, 2] {
            let pool = thread_pool(threads).unwrap();
            let way = format!("{name}, {}, {threads} threads", mode.name());
            pool.install(|| {
                assert_same(&way, rays, &expected, &trace(scene, rays, false, mode));
                assert_same(&format!("{way}, any hit"), rays, &masks(&expected), &trace(scene, rays, true, mode));
                let got = trace(scene, &shuffled, false, mode);
                assert_same(&format!("{way}, shuffled"), &shuffled, &expected_shuffled, &got);
            });
        }
    }
    // A packet cut off in the middle, and an empty one.
    assert_same(&format!("{name}, partial"), rays, &expected[..13], &trace(scene, &rays[..13], false, Mode::Packet));
    assert!(trace(scene, &[], false, Mode::Packet).is_empty());
}

struct EveryKernel<'a> {
    name: &'a str,
    mesh: &'a Mesh,
    rays: &'a [Ray<f32>],
    stride: usize,
}

impl Visitor<Triangle> for EveryKernel<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        every_way(self.name, &Scene::<K>::from(self.mesh.clone()), self.rays, self.stride);
    }
}

fn check(source: &SceneSource) {
    let LoadedScene { world, view, .. } = source.load().unwrap();
    let [Geometry::Mesh(mesh)] = world.geometries() else { panic!("{} is more than a mesh", source.name()) };
    let mut rays = view.camera(64, 64).rays(64, 64);
    rays.extend(hard_rays(mesh, 8_000));
    // About 20 million tests by brute force, whatever the size of the mesh.
    let stride = (rays.len() * mesh.len() / 20_000_000).max(1);
    registry::triangles(&mut EveryKernel { name: &source.name(), mesh, rays: &rays, stride });
}

#[test]
fn built_in_scenes_have_identical_hits() {
    for name in ["room:small", "room", "terrain:1e3", "terrain:1e5", "sphere:small", "sphere"] {
        check(&SceneSource::parse(name).unwrap());
    }
}

#[test]
fn real_scenes_have_identical_hits() {
    for file in ["bunny.obj", "sponza.obj"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(file);
        if !path.exists() {
            eprintln!("skipped: {file} is not beside this checkout");
            continue;
        }
        check(&SceneSource::Obj(path));
    }
}

/// Triangles that tie in `t`: each is there several times, and the copies are in different leaves.
#[test]
fn the_lower_primitive_number_wins_ties() {
    let scene = SceneSource::parse("sphere:small").unwrap().load().unwrap();
    let [Geometry::Mesh(mesh)] = scene.world.geometries() else { panic!("a sphere is a mesh") };
    let copies = 5;
    let triangles: Vec<_> = (0..copies).flat_map(|_| mesh.triangles().iter().copied()).collect();
    let many =
        Mesh::new(mesh.positions().to_vec(), triangles, vec![Part { first_triangle: 0, color: Vec3::ONE }]).unwrap();
    let rays = hard_rays(mesh, 4_000);
    registry::triangles(&mut EveryKernel { name: "copies", mesh: &many, rays: &rays, stride: 1 });
    let hits = trace(&Scene::<raylanes::kernels::triangle::Cramer<f32>>::from(many), &rays, false, Mode::Packet);
    assert!(hits.iter().all(|hit| !hit.mask || (hit.primitive as usize) < mesh.len()));
}

/// Meshes that trees stumble over: one triangle, many in one place, points, lines, sizes at the ends of the range.
#[test]
fn odd_meshes_have_identical_hits() {
    let mut random = Random(11);
    let part = || vec![Part { first_triangle: 0, color: Vec3::ONE }];
    for scale in [1e-42, 1e-30, 1.0, 1e15, 1e30, f32::MAX] {
        for count in [1, 2, 3, 5, 9, 100] {
            for kind in 0..4 {
                let mut positions = Vec::new();
                for _ in 0..count {
                    let [a, b, c] = [vec3(&mut random), vec3(&mut random), vec3(&mut random)];
                    positions.extend(match kind {
                        0 => [a, b, c],
                        1 => [Vec3::ZERO, Vec3::X, Vec3::Y],
                        2 => [a; 3],
                        _ => [Vec3::ZERO, Vec3::X * a.x, Vec3::X * b.x],
                    });
                }
                positions.iter_mut().for_each(|position| *position *= scale);
                let triangles = (0..count).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
                let mesh = Mesh::new(positions, triangles, part()).unwrap();
                let rays: Vec<_> = hard_rays(&mesh, 64);
                registry::triangles(&mut TreeAgainstBruteForce { mesh: &mesh, rays: &rays });
            }
        }
    }
}

/// No demands on how many rays hit.
struct TreeAgainstBruteForce<'a> {
    mesh: &'a Mesh,
    rays: &'a [Ray<f32>],
}

impl Visitor<Triangle> for TreeAgainstBruteForce<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let scene = Scene::<K>::from(self.mesh.clone());
        let brute: Vec<_> = self.rays.iter().map(|ray| scene.closest_hit_brute_force(ray)).collect();
        for mode in Mode::ALL {
            let what = format!("{} triangles, {}, {}", self.mesh.len(), K::INFO.id, mode.name());
            assert_same(&what, self.rays, &brute, &trace(&scene, self.rays, false, mode));
        }
    }
}

/// The kind of Embree's issue 387: rays from afar, nearly parallel to a triangle, are reported to hit it where it is not,
/// since barycentrics and `t` are quotients of rounding errors. The rule removes what is outside the triangle's own box.
#[test]
fn hits_stay_in_their_own_box() {
    let mut random = Random(3);
    let (mut removed, mut kept) = (0, 0);
    for _ in 0..200_000 {
        let triangle = Triangle { v0: vec3(&mut random), v1: vec3(&mut random), v2: vec3(&mut random) };
        // Through a point of the plane beside the triangle, or in it, from afar and almost within the plane.
        let [e1, e2] = [triangle.v1 - triangle.v0, triangle.v2 - triangle.v0];
        let target = triangle.v0 + e1 * (3.0 * unit(&mut random) - 1.0) + e2 * (3.0 * unit(&mut random) - 1.0);
        let dir = e1 * unit(&mut random) + e2 * unit(&mut random) + vec3(&mut random) * 1e-4;
        let ray = Ray::new(target - dir * 1e4, dir);
        let corners = triangle.vertices().to_vec();
        let part = Part { first_triangle: 0, color: Vec3::ONE };
        let scene = Scene::<raylanes::kernels::triangle::MollerTrumbore<f32>>::from(
            Mesh::new(corners, vec![[0, 1, 2]], vec![part]).unwrap(),
        );
        let bare = Intersect::<f32>::hit(&raylanes::kernels::triangle::MollerTrumbore::prepare(&triangle), &ray);
        let hit = Intersect::<f32>::hit(&scene, &ray);
        assert!(bare.mask || !hit.mask, "the rule only removes hits");
        removed += u32::from(bare.mask && !hit.mask);
        if hit.mask {
            kept += 1;
            let bounds = triangle.bounds();
            // The padding, 4 ulp of t.
            let (point, slack) = (ray.at(hit.t), Vec3::splat(4e-6 * hit.t.abs() * dir.length()));
            assert!(point.cmpge(bounds.lo - slack).all() && point.cmple(bounds.hi + slack).all(), "{hit:?} at {point}");
        }
    }
    assert!(removed > 100 && kept > 100, "{removed} removed, {kept} kept: the case does not show what it should");
}
