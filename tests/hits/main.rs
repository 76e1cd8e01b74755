//! Tests what users do with hits: all hits of a ray, filters, groups of instances, points inside closed meshes, and, in
//! `spawn`, rays that leave a surface; in `faces`, discs.
//!
//! The meshes and rays of the cases at the end are our own, after reports by users of other libraries.

mod faces;
mod reference;
mod spawn;
#[path = "../worlds/mod.rs"]
mod worlds;

use std::sync::LazyLock;

use glam::{Affine3, Mat3, Quat, Vec3};
use raylanes::conformance::Random;
use raylanes::geom::{Aabb, Candidate, Hit, Lanes, Quadric, Ray, Triangle};
use raylanes::kernels::aabb::Slabs;
use raylanes::kernels::triangle::{ExactHalfOpen, MollerTrumbore, Woop};
use raylanes::kernels::{Claim, Info, Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::tracer::{Geometry, Mesh, Mode, Placement, Scene, World, occluded, trace};
use wide::f32x8;

use worlds::{built_in_mesh, place, unit, vec3};

/// Instances of every geometry at random places, in one of three groups.
fn scattered(seed: u64, count: usize) -> World {
    let mut random = Random::from_seed(seed);
    let geometries = worlds::geometries(&mut random);
    let instances = (0..count)
        .map(|number| {
            let transform = worlds::transform(&mut random, 3.0);
            place(number % geometries.len(), transform).with_mask(1 << random.below(3))
        })
        .collect();
    World::new(geometries, instances).unwrap()
}

fn numbers(hit: &Hit<f32>) -> (u32, u32) {
    (hit.instance, hit.primitive)
}

/// Accepts about half of the hits, by their numbers and by where they are.
fn accepted(hit: &Hit<f32>) -> bool {
    let hash =
        hit.to_bits().into_iter().fold(7u32, |hash, word| (hash ^ word).wrapping_mul(0x9e37_79b1).rotate_left(13));
    hash & 0x100 == 0
}

fn first_where(hits: &[Hit<f32>], counts: impl Fn(&Hit<f32>) -> bool) -> Hit<f32> {
    hits.iter().find(|hit| counts(hit)).copied().unwrap_or(Hit::MISS)
}

struct EveryKernel<'a> {
    world: &'a World,
    rays: &'a [Ray<f32>],
}

impl Visitor<Triangle> for EveryKernel<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let Self { world, rays } = *self;
        let scene = Scene::<K>::new(world.clone());
        let all: Vec<_> = rays.iter().map(|ray| scene.all_hits(ray)).collect();
        let id = K::INFO.id;

        // In order, each once, and the first is the closest hit.
        let (mut several, mut meshes) = (0, 0);
        for (ray, hits) in rays.iter().zip(&all) {
            assert_eq!(scene.count_hits(ray), hits.len(), "{id}: {ray:?}");
            let closest = hits.first().copied().unwrap_or(Hit::MISS);
            assert_eq!(closest.to_bits(), Intersect::<f32>::hit(&scene, ray).to_bits(), "{id}: {ray:?}");
            for pair in hits.windows(2) {
                let one_place = (pair[0].t, pair[0].instance) == (pair[1].t, pair[1].instance);
                assert!(pair[0].is_closer_than(&pair[1]) || one_place, "{id}: {ray:?} {pair:?}");
            }
            for (index, hit) in hits.iter().enumerate() {
                assert!(hit.mask && ray.t_min <= hit.t && hit.t <= ray.t_max, "{id}: {ray:?} {hit:?}");
                let same = hits[..index].iter().filter(|other| numbers(other) == numbers(hit)).count();
                let geometry = world.instances()[hit.instance as usize].geometry as usize;
                let is_mesh = matches!(world.geometries()[geometry], Geometry::Mesh(_));
                assert!(same <= usize::from(!is_mesh), "{id}: {ray:?} {hit:?}");
                meshes += usize::from(is_mesh);
            }
            several += usize::from(hits.len() > 2);
        }
        assert!(several > rays.len() / 8 && meshes > rays.len() / 4, "{id}: {several} of {}, {meshes}", rays.len());

        // A filter and a mask leave out hits, in every mode.
        for mask in [u32::MAX, 0b011, 0b100, 0] {
            let shown = |hit: &Hit<f32>| world.instances()[hit.instance as usize].mask & mask != 0;
            let masked: Vec<_> = all.iter().map(|hits| first_where(hits, shown)).collect();
            let both = |hit: &Hit<f32>| shown(hit) && accepted(hit);
            let expected: Vec<_> = all.iter().map(|hits| first_where(hits, both)).collect();
            let filter = |ray: &Ray<f32>, hit: &Hit<f32>| {
                assert!(ray.t_min <= hit.t && hit.t <= ray.t_max && hit.mask, "{ray:?} {hit:?}");
                accepted(hit)
            };
            let filtered = scene.with_filter(filter).with_mask(mask);
            for mode in Mode::ALL {
                let got = trace(&scene.with_mask(mask), rays, mode);
                compare(&format!("{id}, {}, mask {mask:b}", mode.name()), rays, &masked, &got);
                let got = trace(&filtered, rays, mode);
                compare(&format!("{id}, {}, filtered", mode.name()), rays, &expected, &got);
                let hit: Vec<_> = expected.iter().map(|hit| hit.mask).collect();
                assert_eq!(occluded(&filtered, rays, mode), hit, "{id}, {}", mode.name());
            }
            for ((packet, expected), all) in rays.chunks_exact(8).zip(expected.chunks_exact(8)).zip(all.chunks_exact(8))
            {
                let eight = Ray::from_slice(packet);
                let hits = Intersect::<f32x8>::hit(&filtered, &eight);
                compare(&format!("{id}, packet"), packet, expected, &hits.lanes());
                assert_eq!(filtered.any_hit(&eight, &()), hits.mask);
                for (ray, all) in packet.iter().zip(all) {
                    let counted: Vec<_> = all.iter().filter(|hit| both(hit)).copied().collect();
                    assert_eq!(filtered.all_hits(ray), counted);
                }
            }
        }
    }
}

fn compare(what: &str, rays: &[Ray<f32>], expected: &[Hit<f32>], got: &[Hit<f32>]) {
    assert_eq!(expected.len(), got.len(), "{what}");
    for ((ray, expected), got) in rays.iter().zip(expected).zip(got) {
        assert_eq!(expected.to_bits(), got.to_bits(), "{what}: {ray:?}\nexpected {expected:?}\n     got {got:?}");
    }
}

#[test]
fn all_hits_are_in_order_and_filters_leave_some_out() {
    let world = scattered(1, 60);
    let rays = worlds::rays(&world, 3, 1_200);
    registry::triangles(&mut EveryKernel { world: &world, rays: &rays });
}

#[test]
fn a_mesh_without_some_triangles_is_the_mesh_that_a_filter_shows() {
    let mesh = built_in_mesh("sphere:1e3");
    let keeps = |number: u32| number.wrapping_mul(0x9e37_79b1) >> 30 != 0;
    let (kept, rest): (Vec<u32>, Vec<u32>) = (0..mesh.len() as u32).partition(|&number| keeps(number));
    assert!(rest.len() > 100);
    let part = Mesh::from_triangles(&kept.iter().map(|&number| mesh.triangle(number)).collect::<Vec<_>>()).unwrap();
    let world = World::from(mesh);
    let rays = worlds::rays(&world, 11, 4_000);
    let (scene, part) = (Scene::<Woop<f32>>::new(world), Scene::<Woop<f32>>::from(part));
    let filtered = scene.with_filter(|_: &Ray<f32>, hit: &Hit<f32>| keeps(hit.primitive));
    for mode in Mode::ALL {
        for ((ray, expected), got) in rays.iter().zip(trace(&part, &rays, mode)).zip(trace(&filtered, &rays, mode)) {
            let primitive = if expected.mask { kept[expected.primitive as usize] } else { u32::MAX };
            assert_eq!(Hit { primitive, ..expected }.to_bits(), got.to_bits(), "{}: {ray:?}", mode.name());
        }
    }
}

#[test]
fn fronts_are_the_sides_that_normals_point_to() {
    let mut random = Random::from_seed(5);
    let world = scattered(9, 40);
    let rays = worlds::rays(&world, 21, 2_000);
    let scene = Scene::<ExactHalfOpen<f32>>::new(world);
    let (mut front, mut back) = (0, 0);
    for ray in &rays {
        for hit in scene.all_hits(ray) {
            let surface = scene.surface(ray, &hit);
            assert_eq!(scene.is_front(ray, &hit), surface.front);
            let cosine = surface.normal.dot(ray.dir.normalize_or(Vec3::X));
            assert!(cosine.abs() < 1e-5 || (cosine < 0.0) == surface.front, "{ray:?} {hit:?}");
            (front, back) = (front + usize::from(surface.front), back + usize::from(!surface.front));
        }
    }
    assert!(front > 500 && back > 500, "{front} {back}");
    // A mirror turns a mesh inside out, but not a quadric.
    let mirror = Affine3::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for (geometry, mirrored) in
        [(Geometry::Mesh(built_in_mesh("sphere:1e3")), true), (Geometry::Quadric(Quadric::sphere(1.0)), false)]
    {
        for (transform, flips) in [(Affine3::IDENTITY, false), (mirror, mirrored)] {
            let world = World::new(vec![geometry.clone()], vec![place(0, transform)]).unwrap();
            let scene = Scene::<Woop<f32>>::new(world);
            let ray = Ray::new(vec3(&mut random) * 0.1 + Vec3::Z * 9.0, Vec3::NEG_Z);
            let sides: Vec<_> = scene.all_hits(&ray).iter().map(|hit| scene.is_front(&ray, hit)).collect();
            assert_eq!(sides, [!flips, flips]);
        }
    }
}

#[test]
fn quadrics_are_crossed_twice() {
    let scene = |quadric, transform| {
        Scene::<Woop<f32>>::new(World::new(vec![Geometry::Quadric(quadric)], vec![place(0, transform)]).unwrap())
    };
    let t = |scene: &Scene<Woop<f32>>, ray| scene.all_hits(&ray).iter().map(|hit| hit.t).collect::<Vec<_>>();
    let down = |x: f32| Ray::new(Vec3::new(x, 0.0, 3.0), Vec3::NEG_Z);
    let ball = scene(Quadric::sphere(1.0), Affine3::IDENTITY);
    assert_eq!(t(&ball, down(0.0)), [2.0, 4.0]);
    assert_eq!(t(&ball, down(1.0)), [3.0], "a ray that touches");
    assert_eq!(t(&ball, Ray { t_min: 2.5, ..down(0.0) }), [4.0]);
    assert_eq!(t(&ball, Ray { t_max: 3.5, ..down(0.0) }), [2.0]);
    assert!(t(&ball, Ray { t_min: 2.5, t_max: 3.5, ..down(0.0) }).is_empty());
    assert_eq!(t(&scene(Quadric::cone(1.0, 2.0), Affine3::IDENTITY), down(0.5)), [2.0], "the base is open");
    let moved = scene(Quadric::sphere(1.0), Affine3::from_translation(Vec3::X * 5.0));
    assert_eq!(t(&moved, down(5.0)), [2.0, 4.0]);
}

/// Every kernel that claims even crossings keeps it through a whole scene: in turned, mirrored and flattened instances,
/// along rays through vertices, edges and silhouettes.
struct Even {
    kernels: Vec<String>,
}

impl Visitor<Triangle> for Even {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        if !K::INFO.claims_to(Claim::EvenCrossings) {
            return;
        }
        self.kernels.push(K::INFO.id.to_string());
        let mut random = Random::from_seed(17);
        for mesh in [
            built_in_mesh("sphere:1e3"),
            worlds::cuboid(Vec3::ONE),
            notched(),
            worlds::cuboid(Vec3::new(1.0, 2.0, 0.0)),
        ] {
            assert!(mesh.is_closed());
            let targets: Vec<_> = mesh.positions().to_vec();
            for _ in 0..12 {
                let transform = worlds::transform(&mut random, 3.0);
                for identity in [false, true] {
                    let object_to_world = if identity { Affine3::IDENTITY } else { transform };
                    let world =
                        World::new(vec![Geometry::Mesh(mesh.clone())], vec![place(0, object_to_world)]).unwrap();
                    let scene = Scene::<K>::new(world);
                    for _ in 0..200 {
                        let ends = [(); 2].map(|()| {
                            let [a, b] = [(); 2].map(|()| targets[random.below(targets.len())]);
                            let between = [0.0, 0.5, 0.25, unit(&mut random)][random.below(4)];
                            object_to_world.transform_point3(a + (b - a) * between)
                        });
                        let dir = ends[1] - ends[0];
                        // The whole line.
                        let ray = Ray { t_min: f32::NEG_INFINITY, ..Ray::new(ends[0], dir) };
                        let hits = scene.all_hits(&ray);
                        assert!(
                            hits.len().is_multiple_of(2),
                            "{}: {ray:?} crosses {hits:?}\n{object_to_world:?}",
                            K::INFO.id
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn lines_cross_closed_meshes_an_even_number_of_times() {
    let mut even = Even { kernels: Vec::new() };
    registry::triangles(&mut even);
    assert!(even.kernels.contains(&"triangle/exact_half_open".to_owned()), "{:?}", even.kernels);
}

/// A square prism with a notch: an L along z, whose inner edge is a silhouette inside its box.
fn notched() -> Mesh {
    let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let corner = |index: usize, z: f32| Vec3::new(outline[index % 6].0 as f32, outline[index % 6].1 as f32, z);
    let mut triangles = Vec::new();
    for side in 0..6 {
        let [a, b, c, d] = [corner(side, 0.0), corner(side + 1, 0.0), corner(side + 1, 1.0), corner(side, 1.0)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.push([corner(a, 1.0), corner(b, 1.0), corner(c, 1.0)]);
        triangles.push([corner(c, 0.0), corner(b, 0.0), corner(a, 0.0)]);
    }
    let triangles: Vec<_> = triangles.into_iter().map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
    Mesh::from_triangles(&triangles).unwrap()
}

/// `Open3D`, issue 5105: rays from outside touched a vertex or an edge of the unit cube, and the points were inside.
#[test]
fn points_beside_a_cube_are_outside() {
    let half = Vec3::splat(0.5);
    let world = World::new(vec![Geometry::Mesh(worlds::cuboid(half))], vec![place(0, Affine3::from_translation(half))]);
    let scene = Scene::<ExactHalfOpen<f32>>::new(world.unwrap());
    let cube = Scene::<ExactHalfOpen<f32>>::from(worlds::cuboid(half));
    for x in -4..=8 {
        for y in -4..=8 {
            for z in -4..=8 {
                let point = Vec3::new(x as f32, y as f32, z as f32) * 0.25;
                let inside = point.cmpgt(Vec3::ZERO).all() && point.cmplt(Vec3::ONE).all();
                let outside = point.cmplt(Vec3::ZERO).any() || point.cmpgt(Vec3::ONE).any();
                if !inside && !outside {
                    continue; // on the surface
                }
                assert_eq!((scene.contains(point), cube.contains(point - half)), (inside, inside), "{point}");
                // In every direction, also where the ray touches edges and vertices.
                for (dx, dy, dz) in (0..27).map(|index| (index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1)) {
                    let dir = Vec3::new(dx as f32, dy as f32, dz as f32);
                    let crossings = cube.count_hits(&Ray::new(point - half, dir));
                    assert!(dir == Vec3::ZERO || crossings % 2 == usize::from(inside), "{point} {dir}: {crossings}");
                }
            }
        }
    }
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.5, f32::NAN, 0.5)] {
        assert!(!scene.contains(bad));
    }
}

/// trimesh, issue 85: a ray from outside met an edge three times. Issue 242: points beside a mesh that is not convex.
#[test]
fn points_in_the_notch_of_a_prism_are_outside() {
    let scene = Scene::<ExactHalfOpen<f32>>::from(notched());
    for x in -2..=10 {
        for y in -2..=10 {
            for z in -2..=6 {
                let [px, py, pz] = [x, y, z].map(|step| step as f32 * 0.25);
                let on = [px, py].into_iter().any(|c| c == 0.0 || c == 1.0 || c == 2.0) || pz == 0.0 || pz == 1.0;
                if on {
                    continue;
                }
                let square = |limit: f32, c: f32| (0.0..limit).contains(&c);
                let inside =
                    square(1.0, pz) && (square(2.0, px) && square(1.0, py) || square(1.0, px) && square(2.0, py));
                let point = Vec3::new(px, py, pz);
                assert_eq!(scene.contains(point), inside, "{point}");
                // Towards every vertex, and along every edge that leaves it.
                for target in scene.world().geometries().iter().flat_map(|geometry| match geometry {
                    Geometry::Mesh(mesh) => mesh.positions().to_vec(),
                    other => panic!("{other:?}"),
                }) {
                    let crossings = scene.count_hits(&Ray::new(point, target - point));
                    assert_eq!(crossings % 2, usize::from(inside), "{point} {target}: {crossings}");
                }
            }
        }
    }
}

/// libigl, issue 2026: a ray through the diagonal of a cube's face was reported to hit the face twice.
#[test]
fn a_ray_through_an_edge_has_one_hit_on_each_side() {
    let scene = Scene::<ExactHalfOpen<f32>>::from(worlds::cuboid(Vec3::splat(0.5)));
    let hits = scene.all_hits(&Ray::new(Vec3::new(1.0, 0.1, 0.1), Vec3::NEG_X));
    assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [0.5, 1.5]);
}

/// A box of closed things is not inside out: cavities, quadrics, several instances, and groups.
#[test]
fn points_are_inside_instances_not_between_them() {
    let sphere = Geometry::Mesh(built_in_mesh("sphere:1e3"));
    let center = sphere.bounds().center();
    let unit_sphere = Affine3::from_translation(-center);
    let at = |x: f32, turn: f32, size: f32| {
        let linear = Mat3::from_quat(Quat::from_rotation_y(turn)) * Mat3::from_diagonal(Vec3::splat(size));
        Affine3 { matrix3: linear, translation: Vec3::X * x } * unit_sphere
    };
    let geometries = vec![sphere, Geometry::Quadric(Quadric::sphere(1.0))];
    let instances: Vec<Placement> = vec![
        place(0, at(0.0, 0.3, 1.0)).with_mask(1),
        place(0, at(0.5, 1.0, 1.0)).with_mask(2),
        place(1, Affine3::from_translation(Vec3::X * 5.0)).with_mask(1),
    ];
    let scene = Scene::<ExactHalfOpen<f32>>::new(World::new(geometries, instances).unwrap());
    let points = [-0.9, 0.25, 1.4, 3.0, 4.5, 5.5, 6.5].map(|x| Vec3::X * x);
    assert_eq!(points.map(|point| scene.contains(point)), [true, true, true, false, true, true, false]);
    let masked = scene.with_mask(2);
    assert_eq!(points.map(|point| masked.contains(point)), [false, true, true, false, false, false, false]);
}

/// Where many faces are hit at one `t`, each is reported once, in the order of its number.
#[test]
fn coincident_faces_are_all_reported() {
    let one = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
    let scene = Scene::<ExactHalfOpen<f32>>::from(Mesh::from_triangles(&[one; 100]).unwrap());
    let hits = scene.all_hits(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z));
    assert!(hits.iter().map(|hit| hit.primitive).eq(0..100));
}

static INNER: LazyLock<Scene<Woop<f32>>> = LazyLock::new(|| built_in_mesh("sphere:1e3").into());

/// A kernel whose primitive is a triangle that shows a scene, like a portal.
#[derive(Clone, Copy, Debug)]
struct Portal<P: Lanes>(MollerTrumbore<P>);

impl Intersect<f32> for Portal<f32> {
    type Setup = ();
    fn setup(_: &Ray<f32>) {}
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        if Intersect::<f32>::hit(&self.0, ray).mask { INNER.candidate(ray, &()) } else { Candidate::MISS }
    }
}

impl<P: Lanes> Intersect<f32x8> for Portal<P> {
    type Setup = ();
    fn setup(_: &Ray<f32x8>) {}
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let seen = Intersect::<f32x8>::hit(&self.0, ray).mask;
        let hit = Intersect::<f32x8>::hit(&*INNER, ray);
        Candidate::<f32x8>::new(seen & hit.mask, hit.t, hit.u, hit.v)
    }
}

impl Kernel for Portal<f32> {
    type Shape = Triangle;
    type Packet = Portal<f32x8>;
    const INFO: Info = Info::new("triangle/portal", "shows a scene", "this test");

    fn prepare(shape: &Triangle) -> Self {
        Self(MollerTrumbore::prepare(shape))
    }

    fn gather(primitives: &[Self; 8]) -> Portal<f32x8> {
        Portal(MollerTrumbore::gather(&primitives.map(|portal| portal.0)))
    }

    fn lane(packet: &Portal<f32x8>, lane: usize) -> Self {
        Self(MollerTrumbore::lane(&packet.0, lane))
    }

    fn bounds(_: &Portal<f32x8>) -> Option<Slabs<f32x8>> {
        None
    }
}

/// The memory that a thread traces with is in use while a kernel runs.
#[test]
fn a_kernel_may_trace_a_scene() {
    let Aabb { lo, hi } = INNER.bounds();
    let window = Triangle {
        v0: lo * 4.0,
        v1: Vec3::new(hi.x * 4.0, lo.y * 4.0, hi.z * 4.0),
        v2: Vec3::new(0.0, hi.y * 4.0, 0.0),
    };
    let scene = Scene::<Portal<f32>>::from(Mesh::from_triangles(&[window; 9]).unwrap());
    let mut random = Random::from_seed(3);
    let towards = |target: Vec3, from: Vec3| Ray::new(from, target - from);
    let middle = INNER.bounds().center();
    let rays: Vec<_> = (0..400)
        .map(|_| towards(middle + vec3(&mut random) * 0.5, middle + vec3(&mut random).normalize_or(Vec3::X) * 20.0))
        .collect();
    let expected = trace(&scene, &rays, Mode::Single);
    assert!(expected.iter().filter(|hit| hit.mask).count() > 3);
    for mode in Mode::ALL {
        compare(mode.name(), &rays, &expected, &trace(&scene, &rays, mode));
    }
    for (ray, expected) in rays.iter().zip(&expected) {
        assert_eq!(Intersect::<f32>::hit(&scene, ray).to_bits(), expected.to_bits());
        assert_eq!(Intersect::<f32>::any_hit(&scene, ray, &()), expected.mask);
        assert!(scene.count_hits(ray) == 0 || expected.mask);
    }
    let eight: Hit<f32x8> = scene.hit(&Ray::from_slice(&rays));
    compare("packet", &rays[..8], &expected[..8], &eight.lanes());
    assert_eq!(Intersect::<f32x8>::any_hit(&scene, &Ray::from_slice(&rays), &()), eight.mask);
}
