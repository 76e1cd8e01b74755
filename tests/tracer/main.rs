//! Tests of the box rule: every way of tracing a ray gives the same bits.
//!
//! The ways are: testing all primitives of all instances, single rays, packets, coherent and shuffled order, one and
//! two threads, closest hit and any hit.

mod pictures;
#[path = "../worlds/mod.rs"]
mod worlds;

use glam::{Affine3, Mat3, Vec3};
use raylanes::geom::{Hit, Quadric, Ray, Triangle};
use raylanes::kernels::instance::Instance;
use raylanes::kernels::triangle::{Cramer, Exact, MollerTrumbore, Woop};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::tracer::{
    Camera, Geometry, LoadedScene, Mesh, Mode, Part, Scene, SceneSource, World, occluded_into, thread_pool, trace,
    trace_into, traversal_stats,
};

use raylanes::conformance::Random;
use worlds::{built_in_mesh, on_triangle, pick, place, unit, vec3};

/// Rays that are hard to trace: at vertices and edges, where triangles have the same `t`; along axes, within planes of
/// boxes; and with every kind of interval. Some miss everything.
fn hard_rays(mesh: &Mesh, count: usize) -> Vec<Ray<f32>> {
    let mut random = Random::from_seed(7);
    let size = mesh.bounds().extent().length();
    (0..count)
        .map(|_| {
            let triangle = mesh.triangle(random.below(mesh.len()) as u32);
            let target = on_triangle(&mut random, triangle);
            let mut dir = match random.below(4) {
                0 => pick(&mut random, &Vec3::AXES) * pick(&mut random, &[size, -size]),
                1 => triangle.v1 - target,
                _ => vec3(&mut random) * size,
            };
            if random.below(4) == 0 {
                dir[random.below(3)] = -0.0;
            }
            let distance = pick(&mut random, &[0.0, 0.5, 1.0, 3.0]);
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

/// [`trace`] into a buffer that is full of other hits: all of them must be overwritten.
fn retrace<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
) -> Vec<Hit<f32>> {
    let mut hits = vec![Hit::<f32>::new(true, -1.0, 0.0, 0.0); rays.len()];
    if any_hit {
        for turn in [false, true] {
            let mut occluded: Vec<_> = (0..rays.len()).map(|index| (index % 2 == 0) == turn).collect();
            occluded_into(scene, rays, mode, &mut occluded);
            let masks = occluded.into_iter().map(|mask| Hit::<f32>::new(mask, 0.0, 0.0, 0.0));
            let first = std::mem::replace(&mut hits, masks.collect());
            assert!(!turn || first == hits, "{}: a value was not overwritten", mode.name());
        }
    } else {
        trace_into(scene, rays, mode, &mut hits);
    }
    hits
}

/// Traces the rays in every way. Brute force traces every `stride`-th ray.
fn every_way<K: Kernel<Shape = Triangle>>(name: &str, scene: &Scene<K>, rays: &[Ray<f32>], stride: usize) {
    let name = format!("{name}, {}", K::INFO.id);
    let expected = trace(scene, rays, Mode::Scalar);
    let some: Vec<_> = rays.iter().step_by(stride).copied().collect();
    let brute: Vec<_> = some.iter().map(|ray| scene.closest_hit_brute_force(ray)).collect();
    let tree: Vec<_> = expected.iter().step_by(stride).copied().collect();
    assert_same(&format!("{name}: tree and brute force"), &some, &brute, &tree);

    let mut order: Vec<usize> = (0..rays.len()).collect();
    let mut random = Random::from_seed(1);
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
                assert_same(&way, rays, &expected, &retrace(scene, rays, false, mode));
                assert_same(&format!("{way}, any hit"), rays, &masks(&expected), &retrace(scene, rays, true, mode));
                let got = trace(scene, &shuffled, mode);
                assert_same(&format!("{way}, shuffled"), &shuffled, &expected_shuffled, &got);
            });
        }
    }
    // A partial packet, and no rays.
    assert_same(&format!("{name}, partial"), rays, &expected[..13], &trace(scene, &rays[..13], Mode::Packet));
    assert!(trace(scene, &[], Mode::Packet).is_empty());
}

struct EveryKernel<'a> {
    name: &'a str,
    world: World,
    rays: &'a [Ray<f32>],
    stride: usize,
}

impl Visitor<Triangle> for EveryKernel<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        every_way(self.name, &Scene::<K>::new(self.world.clone()), self.rays, self.stride);
    }
}

/// Checks every triangle kernel on the same rays. A fifth of them must hit, by the exact kernel: rays past the scene
/// would check nothing. A kernel itself may lose most hits, such as one with an absolute epsilon on small triangles.
fn every_kernel(name: &str, world: World, rays: &[Ray<f32>], stride: usize) {
    let hits = trace(&Scene::<Exact<f32>>::new(world.clone()), rays, Mode::Auto);
    let count = hits.iter().filter(|hit| hit.mask).count();
    assert!(count * 5 > rays.len(), "{name}: only {count} of {} rays hit", rays.len());
    registry::triangles(&mut EveryKernel { name, world, rays, stride });
}

fn check(source: &SceneSource) {
    let LoadedScene { world, view, .. } = source.load().unwrap();
    let [Geometry::Mesh(mesh)] = world.geometries() else { panic!("{} is not one mesh", source.name()) };
    let mut rays = view.camera(64, 64).rays(64, 64);
    rays.extend(hard_rays(mesh, 8_000));
    // About 10 million brute-force tests for every size of mesh.
    let stride = (rays.len() * mesh.len() / 10_000_000).max(1);
    every_kernel(&source.name(), world, &rays, stride);
}

#[test]
fn built_in_scenes_have_identical_hits() {
    for name in ["room:small", "room", "terrain:1e3", "terrain:1e5", "sphere:small", "sphere"] {
        check(&SceneSource::parse(name).unwrap());
    }
}

#[test]
fn built_in_scenes_of_instances_have_identical_hits() {
    for (name, stride) in [("gallery", 1), ("forest:1000", 64)] {
        let LoadedScene { world, view, .. } = SceneSource::parse(name).unwrap().load().unwrap();
        let rays = view.camera(64, 64).rays(64, 64);
        every_kernel(name, world, &rays, stride);
    }
}

/// Blocks of rays meet the same few triangles one after the other. The triangles end inside blocks and packets.
#[test]
fn large_overlapping_triangles_have_identical_hits() {
    let mut random = Random::from_seed(29);
    let world = World::from(worlds::some_triangles(&mut random, 8));
    let eye = Vec3::new(1.0, 0.5, 3.0);
    let mut rays = Camera::new(eye, Vec3::ZERO, 45.0, 96, 96).rays(96, 96);
    // Parallel rays, like those to a far light.
    rays.extend(rays.clone().iter().map(|ray| Ray::new(eye + ray.dir, -eye)));
    every_kernel("large triangles", world, &rays, 16);
}

#[test]
fn real_scenes_have_identical_hits() {
    for file in ["bunny.obj", "sponza.obj"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(file);
        if !path.exists() {
            eprintln!("skipped: {} does not exist", path.display());
            continue;
        }
        check(&SceneSource::Mesh(path));
    }
}

/// Each triangle is there several times, so its copies have the same `t`. The copies are in different leaves.
#[test]
fn the_lower_primitive_number_wins_ties() {
    let mesh = built_in_mesh("sphere:small");
    let copies = 5;
    let triangles: Vec<_> = (0..copies).flat_map(|_| mesh.triangles().iter().copied()).collect();
    let many = worlds::mesh(mesh.positions().to_vec(), triangles);
    let rays = hard_rays(&mesh, 4_000);
    every_kernel("copies", many.clone().into(), &rays, 4);
    let hits = trace(&Scene::<Cramer<f32>>::from(many), &rays, Mode::Packet);
    assert!(hits.iter().all(|hit| !hit.mask || (hit.primitive as usize) < mesh.len()));
}

/// Instances of all geometries at random places. Some are at the same place, some are exact copies.
fn scattered(seed: u64, count: usize) -> World {
    let mut random = Random::from_seed(seed);
    let geometries = worlds::geometries(&mut random);
    let mut instances = vec![place(0, Affine3::IDENTITY)];
    while instances.len() < count {
        let instance = match random.below(6) {
            0 => instances[random.below(instances.len())],
            1 => place(random.below(geometries.len()), instances[random.below(instances.len())].object_to_world),
            _ => place(random.below(geometries.len()), worlds::transform(&mut random, 8.0)),
        };
        instances.push(instance);
    }
    World::new(geometries, instances).unwrap()
}

/// Instances that are equal in the world up to rounding: cubes and squares of different sizes, each scaled to size 1,
/// some rotated to themselves, sheared or mirrored, some far from the origin. Their faces are in planes of their boxes
/// and of the other boxes.
fn coincident(seed: u64, count: usize) -> World {
    let mut random = Random::from_seed(seed);
    let sizes = [Vec3::ONE, Vec3::splat(3.0), Vec3::splat(0.7), Vec3::splat(1e-3), Vec3::new(0.3, 1.1, 17.0)];
    let flats = sizes.map(|size| worlds::cuboid(size * Vec3::new(1.0, 1.0, 0.0)));
    let geometries = sizes.map(worlds::cuboid).into_iter().chain(flats).map(Geometry::Mesh).collect();
    let centers = [Vec3::ZERO, vec3(&mut random), vec3(&mut random) * 1e6];
    let instances = (0..count)
        .map(|_| {
            let kind = random.below(sizes.len());
            let scale = Mat3::from_diagonal(Vec3::ONE / sizes[kind]);
            let turn = worlds::pick(
                &mut random,
                &[
                    Mat3::IDENTITY,
                    Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z),
                    Mat3::from_cols(Vec3::NEG_X, Vec3::Y, Vec3::Z),
                    Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X),
                    // A shear within the plane of the squares, and one out of this plane.
                    Mat3::from_cols(Vec3::X, Vec3::new(1.3, 1.0, 0.0), Vec3::Z),
                    Mat3::from_cols(Vec3::X, Vec3::new(0.0, 1.0, 0.7), Vec3::Z),
                ],
            );
            let translation = worlds::pick(&mut random, &centers);
            place(kind + sizes.len() * random.below(2), Affine3 { matrix3: turn * scale, translation })
        })
        .collect();
    World::new(geometries, instances).unwrap()
}

#[test]
fn worlds_of_instances_have_identical_hits() {
    for (name, world) in [
        ("scattered", scattered(1, 80)),
        ("crowded", scattered(2, 400)),
        ("coincident", coincident(3, 60)),
        ("one quadric", {
            let (geometry, object_to_world) = (Geometry::Quadric(Quadric::cone(1.0, 2.0)), Affine3::IDENTITY);
            World::new(vec![geometry], vec![place(0, object_to_world)]).unwrap()
        }),
    ] {
        let rays = worlds::rays(&world, 5, 3_000);
        every_kernel(name, world.clone(), &rays, 1);
        registry::quadrics(&mut EveryQuadric { name, world: &world, rays: &rays });
    }
}

struct EveryQuadric<'a> {
    name: &'a str,
    world: &'a World,
    rays: &'a [Ray<f32>],
}

impl Visitor<Quadric> for EveryQuadric<'_> {
    fn visit<Q: Kernel<Shape = Quadric>>(&mut self) {
        let scene = Scene::<Cramer<f32>>::with_quadrics::<Q>(self.world.clone());
        every_way(&format!("{}, {}", self.name, Q::INFO.id), &scene, self.rays, 1);
    }
}

/// Instances at the ends of the range of `f32`: their boxes, rays and distances overflow or are subnormal.
#[test]
fn odd_worlds_have_identical_hits() {
    let mut random = Random::from_seed(13);
    for scale in [1e-42, 1e-38, 1e-20, 1e20, 1e38, f32::MAX] {
        for reach in [0.0, 1.0, 1e20, f32::MAX] {
            let geometries = worlds::geometries(&mut random);
            let instances = (0..40).filter_map(|number| {
                let Affine3 { matrix3, translation } = worlds::transform(&mut random, reach);
                let matrix3 = matrix3 * if number % 4 == 0 { 1.0 } else { scale };
                Instance::new((), Affine3 { matrix3, translation })
                    .is_ok()
                    .then(|| place(number % geometries.len(), Affine3 { matrix3, translation }))
            });
            let instances = instances.collect();
            let world = World::new(geometries, instances).unwrap();
            let rays = worlds::rays(&world, 5, 500);
            let scene = Scene::<MollerTrumbore<f32>>::new(world);
            let brute: Vec<_> = rays.iter().map(|ray| scene.closest_hit_brute_force(ray)).collect();
            assert!(brute.iter().all(|hit| !hit.mask || hit.t.is_finite()));
            for mode in Mode::ALL {
                let what = format!("{scale:e}, {reach:e}, {}", mode.name());
                assert_same(&what, &rays, &brute, &trace(&scene, &rays, mode));
            }
        }
    }
}

/// Rays that are traced as blocks: 64 rays from one point or from nearby points, nearly parallel, with a direction per
/// block. Some are inactive or end early, some start or end on the surface. A few contain a NaN or an infinity, and
/// their block cannot be traced as one.
fn coherent_rays(mesh: &Mesh, random: &mut Random) -> Vec<Ray<f32>> {
    let bounds = mesh.bounds();
    let size = bounds.extent().length();
    let item = size / (mesh.len() as f32).sqrt();
    let mut rays = Vec::new();
    for block in 0..200 {
        let Triangle { v0, v1, v2 } = mesh.triangle(random.below(mesh.len()) as u32);
        let dir = vec3(random).normalize() * size;
        let spread = [0.0, 0.01, 0.05][random.below(3)];
        for index in 0..64 {
            let target = v0 + (v1 - v0) * (0.5 * unit(random)) + (v2 - v0) * (0.5 * unit(random));
            let dir = dir + vec3(random) * (spread * size);
            let origin = if block % 2 == 0 { v0 - dir * 0.5 } else { target - dir * 0.25 };
            let mut ray = match block % 4 {
                // From one point, the eye.
                0 | 2 => Ray::new(
                    v0 - Vec3::splat(0.3 * size),
                    v0 + vec3(random) * (spread * size) - (v0 - Vec3::splat(0.3 * size)),
                ),
                // Towards a surface or away from it.
                1 => Ray::new(origin, dir),
                _ => Ray::new(v0 + vec3(random) * item, dir),
            };
            match random.below(200) {
                0 => (ray.t_min, ray.t_max) = (1.0, 0.5),
                1 => ray.t_max = 0.25,
                2 => ray.t_min = 0.25,
                3 if index == 0 => ray.dir.y = f32::NAN,
                4 if index == 0 => ray.origin.x = f32::INFINITY,
                _ => {}
            }
            rays.push(ray);
        }
    }
    rays
}

#[test]
fn coherent_rays_have_identical_hits() {
    for name in ["room:small", "terrain:1e3", "sphere:small"] {
        let mesh = built_in_mesh(name);
        let mut rays = coherent_rays(&mesh, &mut Random::from_seed(21));
        // Very long and very short directions: their inverses are tiny and huge.
        for (ray, scale) in rays.clone().into_iter().zip([1e-30, 1e-20, 1e20, 1e30].into_iter().cycle()).step_by(7) {
            rays.push(Ray { origin: ray.origin, dir: ray.dir * scale, t_min: ray.t_min, t_max: ray.t_max / scale });
        }
        let scene = Scene::<Woop<f32>>::from(mesh);
        every_way(name, &scene, &rays, 16);
        // Blocks are traced as one: a block visits few more nodes than one of its rays.
        let rays = &rays[..12_800];
        let hits = trace(&scene, rays, Mode::Scalar).iter().filter(|hit| hit.mask).count() as u64;
        let [scalar, single, packet, _] = Mode::ALL.map(|mode| traversal_stats(&scene, rays, false, mode));
        assert!(packet.nodes * 5 < single.nodes, "{name}: {packet:?}, {single:?}");
        for (counts, width) in [(scalar, 1), (single, 8), (packet, 8)] {
            assert!(counts.rays == 12_800 && counts.leaves > 0, "{name}: {counts:?}");
            assert!((hits..=width * counts.tests).contains(&counts.lanes), "{name}: {hits} hits, {counts:?}");
        }
        assert!(scalar.tests > single.tests, "{name}: {scalar:?}, {single:?}");
    }
}

/// Neighbours start at one point and diverge slightly, but the triangles are much smaller. A block would test hundreds
/// of triangles; it must stop early.
#[test]
fn diverging_rays_have_identical_hits_and_few_more_tests() {
    let LoadedScene { world, view, .. } = SceneSource::parse("terrain:1e5").unwrap().load().unwrap();
    let mut random = Random::from_seed(23);
    let mut rays = view.camera(64, 64).rays(64, 64);
    for ray in &mut rays {
        ray.dir += vec3(&mut random) * (0.03 * ray.dir.length());
    }
    let scene = Scene::<Woop<f32>>::new(world);
    for any_hit in [false, true] {
        let expected = retrace(&scene, &rays, any_hit, Mode::Single);
        for mode in [Mode::Packet, Mode::Auto] {
            assert_same("turned rays", &rays, &expected, &retrace(&scene, &rays, any_hit, mode));
        }
        let [single, packet, auto] =
            [Mode::Single, Mode::Packet, Mode::Auto].map(|mode| traversal_stats(&scene, &rays, any_hit, mode));
        assert!(packet.tests.max(auto.tests) < 3 * single.tests, "{packet:?}, {auto:?}, {single:?}");
    }
}

/// A ball on a square ground of this half width, the ground last; without it if there is none.
fn ball_on_ground(half_width: Option<f32>, at: Vec3) -> World {
    let ball = built_in_mesh("sphere:5e3");
    let (center, scale) = (ball.bounds().center(), 0.1 / ball.bounds().extent().max_element());
    let mut corners = Vec::new();
    for number in 0..ball.len() as u32 {
        let Triangle { v0, v1, v2 } = ball.triangle(number);
        corners.extend([v0, v1, v2].map(|vertex| (vertex - center) * scale + Vec3::Y * 0.05 + at));
    }
    if let Some(half) = half_width {
        let [a, b, c, d] =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x * half, 0.0, z * half) + at);
        corners.extend([a, b, c, a, c, d]);
    }
    let triangles = (0..corners.len() as u32).collect::<Vec<_>>();
    let triangles = triangles.chunks_exact(3).map(|one| [one[0], one[1], one[2]]).collect();
    Mesh::new(corners, triangles, vec![Part { first_triangle: 0, color: Vec3::ONE }]).unwrap().into()
}

/// The tree must find a small object on a large ground, also where one ray has room for a whole scene between two
/// numbers of the other end. So must every walk: none may test boxes with an error as large as the object.
#[test]
fn a_large_ground_does_not_hide_a_small_object() {
    let view = |at: Vec3| Camera::new(Vec3::new(0.1, 0.3, 0.3) + at, Vec3::new(0.0, 0.05, 0.0) + at, 40.0, 64, 64);
    let tests = |ground, at: Vec3, any_hit, mode| {
        let scene = Scene::<Woop<f32>>::new(ball_on_ground(ground, at));
        traversal_stats(&scene, &view(at).rays(64, 64), any_hit, mode).tests
    };
    for mode in Mode::ALL {
        for any_hit in [false, true] {
            let alone = tests(None, Vec3::ZERO, any_hit, mode);
            for half_width in [1e2, 1e4, 1e5, 1e6, 1e12, 1e18] {
                let got = tests(Some(half_width), Vec3::ZERO, any_hit, mode);
                // Each ray that misses the ball hits the ground.
                let most = 2 * alone + if mode == Mode::Scalar { 4 } else { 1 } * 64 * 64;
                assert!(got <= most, "{mode:?}, ground of {half_width:e}: {got} tests, alone {alone}");
            }
            let far = tests(None, Vec3::splat(1e4), any_hit, mode);
            assert!(far <= 2 * alone, "{mode:?}, at 1e4: {far} tests, at the origin {alone}");
        }
    }
}

/// The box rule applied to the world box of an instance. A scene of one instance has the hits of the transformed ray,
/// with two exceptions: rays that miss the world box have no hit, and `t` is clamped to the box. Rays from far away
/// often need the clamp.
#[test]
fn hits_of_an_instance_are_clamped_to_its_world_box() {
    let mut random = Random::from_seed(17);
    let (mut same, mut clamped, mut removed) = (0, 0, 0);
    for _ in 0..300 {
        let mesh = worlds::cuboid(vec3(&mut random));
        let object_to_world = worlds::transform(&mut random, 8.0);
        let bare = Instance::new(Scene::<Cramer<f32>>::from(mesh.clone()), object_to_world).unwrap();
        let world = World::new(vec![Geometry::Mesh(mesh)], vec![place(0, object_to_world)]).unwrap();
        let rays = worlds::rays(&world, 1 + random.below(1000) as u64, 100);
        let scene = Scene::<Cramer<f32>>::new(world);
        let bounds = scene.bounds();
        for ray in &rays {
            let (expected, got) = (Intersect::<f32>::hit(&bare, ray), Intersect::<f32>::hit(&scene, ray));
            if !got.mask {
                removed += u32::from(expected.mask);
                continue;
            }
            // An identity is not applied.
            if object_to_world != Affine3::IDENTITY {
                assert_eq!((got.u, got.v, got.primitive), (expected.u, expected.v, expected.primitive));
            }
            let point = ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(got.t);
            let slack = ray.dir.abs().as_dvec3() * f64::from(got.t.abs()) * 1e-6;
            assert!(
                point.cmpge(bounds.lo.as_dvec3() - slack).all() && point.cmple(bounds.hi.as_dvec3() + slack).all(),
                "{ray:?}: {got:?} at {point} is outside of {bounds:?}"
            );
            same += u32::from(got.t == expected.t);
            clamped += u32::from(got.t != expected.t);
        }
    }
    assert!(same > 1000 && clamped > 100 && removed > 10, "{same} the same, {clamped} clamped, {removed} removed");
}

/// A wall at 0.4 from an origin of 2²³, where neighbours in `f32` are 1 apart. With rounding to nearest its box would
/// be flat and 0.4 away from the wall, and a ray that ends between them would miss.
#[test]
fn world_boxes_are_rounded_outwards() {
    for (side, sign) in [(0.4, 1.0), (0.6, -1.0)] {
        for axis in 0..3 {
            let turn = [
                Mat3::IDENTITY,
                Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X),
                Mat3::from_cols(Vec3::Z, Vec3::X, Vec3::Y),
            ];
            let wall = [Vec3::new(side, -1.0, -1.0), Vec3::new(side, 1.0, -1.0), Vec3::new(side, 0.0, 1.0)];
            let [far, towards] = [8_388_608.0 * Vec3::AXES[axis], Vec3::AXES[axis]];
            let placement = place(0, Affine3 { matrix3: turn[axis], translation: far });
            let mesh = worlds::mesh(wall.to_vec(), vec![[0, 1, 2]]);
            let scene =
                Scene::<MollerTrumbore<f32>>::new(World::new(vec![Geometry::Mesh(mesh)], vec![placement]).unwrap());
            let origin = far + if sign > 0.0 { towards } else { Vec3::ZERO };
            let ray = Ray { t_max: 0.75, ..Ray::new(origin, towards * -sign) };
            let hit = Intersect::<f32>::hit(&scene, &ray);
            assert!(hit.mask && (hit.t - 0.6).abs() < 1e-6, "{axis}: {hit:?}");
        }
    }
}

/// An instance with the identity transform, next to another instance, has the hits of the mesh.
#[test]
fn an_identity_transform_changes_no_hit() {
    let mesh = built_in_mesh("sphere:1e3");
    let rays = hard_rays(&mesh, 4_000);
    let alone = trace(&Scene::<MollerTrumbore<f32>>::from(mesh.clone()), &rays, Mode::Scalar);
    let instances = vec![place(0, Affine3::from_translation(Vec3::splat(1e9))), place(0, Affine3::IDENTITY)];
    let world = World::new(vec![Geometry::Mesh(mesh)], instances).unwrap();
    let scene = Scene::<MollerTrumbore<f32>>::new(world);
    for mode in Mode::ALL {
        let mut hits = trace(&scene, &rays, mode);
        for hit in hits.iter_mut().filter(|hit| hit.mask) {
            assert_eq!(hit.instance, 1);
            hit.instance = 0;
        }
        assert_same(mode.name(), &rays, &alone, &hits);
    }
}

/// Primitive numbers count through all geometries, also unused ones. Of two equal instances the first is hit.
#[test]
fn primitives_count_through_all_geometries() {
    let geometries = vec![
        Geometry::Mesh(worlds::cuboid(Vec3::ONE)),
        Geometry::Quadric(Quadric::sphere(1.0)),
        Geometry::Mesh(worlds::cuboid(Vec3::ONE)),
        Geometry::Quadric(Quadric::sphere(1.0)),
    ];
    let instances = [(3, 0.0), (3, 0.0), (1, 4.0), (2, 8.0), (2, 8.0), (0, 12.0)]
        .map(|(geometry, x)| place(geometry, Affine3::from_translation(Vec3::X * x)));
    let scene = Scene::<MollerTrumbore<f32>>::new(World::new(geometries, instances.to_vec()).unwrap());
    assert_eq!(scene.primitives(), 26);
    for (x, primitives, instance) in [(0.0, 25..26, 0), (4.0, 12..13, 2), (8.0, 13..25, 3), (12.0, 0..12, 5)] {
        let ray = Ray::new(Vec3::new(x + 0.25, 0.125, 5.0), Vec3::NEG_Z);
        for hit in
            [Intersect::<f32>::hit(&scene, &ray), Intersect::<wide::f32x8>::hit(&scene, &Ray::splat(&ray)).lane(5)]
        {
            assert!(hit.mask && primitives.contains(&hit.primitive) && hit.instance == instance, "{x}: {hit:?}");
        }
    }
}

/// Meshes that are hard for trees: one triangle, many at one place, points, lines, sizes at the ends of the range.
#[test]
fn odd_meshes_have_identical_hits() {
    let mut random = Random::from_seed(11);
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
                let mesh = worlds::mesh(positions, triangles);
                let rays: Vec<_> = hard_rays(&mesh, 64);
                registry::triangles(&mut TreeAgainstBruteForce { mesh: &mesh, rays: &rays });
            }
        }
    }
}

/// Compares all modes with brute force. Any number of rays may hit.
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
            assert_same(&what, self.rays, &brute, &trace(&scene, self.rays, mode));
        }
    }
}

/// Like Embree's issue 387: rays from far away and nearly parallel to a triangle are reported to hit it at a wrong
/// place, because barycentrics and `t` are quotients of rounding errors. The rule removes hits outside of the
/// triangle's own box.
#[test]
fn hits_stay_in_their_own_box() {
    let mut random = Random::from_seed(3);
    let (mut removed, mut kept) = (0, 0);
    for _ in 0..200_000 {
        let triangle = Triangle { v0: vec3(&mut random), v1: vec3(&mut random), v2: vec3(&mut random) };
        // From far away and almost within the plane, through a point of the plane inside or outside of the triangle.
        let [e1, e2] = [triangle.v1 - triangle.v0, triangle.v2 - triangle.v0];
        let target = triangle.v0 + e1 * (3.0 * unit(&mut random) - 1.0) + e2 * (3.0 * unit(&mut random) - 1.0);
        let dir = e1 * unit(&mut random) + e2 * unit(&mut random) + vec3(&mut random) * 1e-4;
        let ray = Ray::new(target - dir * 1e4, dir);
        let mesh = worlds::mesh(triangle.vertices().to_vec(), vec![[0, 1, 2]]);
        let scene = Scene::<MollerTrumbore<f32>>::from(mesh);
        let bare = Intersect::<f32>::hit(&MollerTrumbore::prepare(&triangle), &ray);
        let hit = Intersect::<f32>::hit(&scene, &ray);
        assert!(bare.mask || !hit.mask, "the rule added a hit");
        removed += u32::from(bare.mask && !hit.mask);
        if hit.mask {
            kept += 1;
            let bounds = triangle.bounds();
            // The padding is 4 ulp of t.
            let (point, slack) = (ray.at(hit.t), Vec3::splat(4e-6 * hit.t.abs() * dir.length()));
            assert!(point.cmpge(bounds.lo - slack).all() && point.cmple(bounds.hi + slack).all(), "{hit:?} at {point}");
        }
    }
    assert!(removed > 100 && kept > 100, "only {removed} hits removed and {kept} kept");
}
