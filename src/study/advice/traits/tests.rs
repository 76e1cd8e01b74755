//! Each trait decides in a scene that is made for it, and none decides in a small room at the origin.

use glam::{Affine3, Mat3, Vec3};
use rand::RngExt;
use rand::seq::SliceRandom;

use super::*;
use crate::geom::{Quadric, Ray, Triangle};
use crate::study::measure::ray_sets::ray_sets;
use crate::study::workload::{direction, in_cube, rng};
use crate::tracer::{Geometry, Mesh, Placement, SceneSource};

/// A mesh and its rays.
#[derive(Clone)]
struct Case {
    triangles: Vec<Triangle>,
    rays: Vec<Ray<f32>>,
}

/// Makes a ray from the way from the target to the eye, and the target.
type MakeRay = fn(Vec3, Vec3) -> Ray<f32>;

/// Cells along a side of the meadow.
const CELLS: u32 = 40;
/// Size of a cell.
const CELL: f32 = 0.1;

/// A meadow of this roughness around the origin, and steep rays at it, eight of each direction.
fn meadow(roughness: f32) -> Case {
    let mut rng = rng(1, "traits", "meadow", &[], 0);
    let heights: Vec<f32> = (0..(CELLS + 1).pow(2)).map(|_| rng.random_range(0.0..1.0) * roughness).collect();
    let vertex = |x: u32, y: u32| {
        let [across, along] = [x, y].map(|cell| (cell as f32 - CELLS as f32 / 2.0) * CELL);
        Vec3::new(across, along, heights[(x * (CELLS + 1) + y) as usize])
    };
    let cells = (0..CELLS).flat_map(|x| (0..CELLS).map(move |y| [x, y]));
    let triangles = cells.flat_map(|[x, y]| {
        let [a, b, c, d] = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
        [Triangle { v0: a, v1: b, v2: c }, Triangle { v0: a, v1: c, v2: d }]
    });
    let triangles = triangles.collect();
    let mut rays = Vec::new();
    for _ in 0..200 {
        let away = (direction(&mut rng) + Vec3::Z * 2.0) * rng.random_range(0.5..1.5);
        rays.extend((0..8).map(|_| {
            let target = (in_cube(&mut rng, 1.5)).with_z(0.0);
            Ray::new(target + away, -away)
        }));
    }
    Case { triangles, rays }
}

impl Case {
    /// Vertices and origins as this function maps them, directions as this matrix does.
    fn mapped(&self, point: impl Fn(Vec3) -> Vec3, vector: Mat3) -> Self {
        let triangle = |&Triangle { v0, v1, v2 }: &Triangle| Triangle { v0: point(v0), v1: point(v1), v2: point(v2) };
        let ray = |ray: &Ray<f32>| Ray { origin: point(ray.origin), dir: vector * ray.dir, ..*ray };
        Self { triangles: self.triangles.iter().map(triangle).collect(), rays: self.rays.iter().map(ray).collect() }
    }

    fn moved(&self, by: Vec3) -> Self {
        self.mapped(|point| point + by, Mat3::IDENTITY)
    }

    fn scaled(&self, by: f32) -> Self {
        self.mapped(|point| point * by, Mat3::IDENTITY * by)
    }

    fn rotated(&self) -> Self {
        let turn = Mat3::from_rotation_x(0.5) * Mat3::from_rotation_y(-0.6) * Mat3::from_rotation_z(0.7);
        self.mapped(|point| turn * point, turn)
    }

    fn shuffled(&self) -> Self {
        let mut shuffled = self.clone();
        shuffled.triangles.shuffle(&mut rng(1, "traits", "shuffled", &[], 0));
        shuffled
    }

    /// Each triangle starts with another of its vertices.
    fn renumbered(&self) -> Self {
        let triangles = self.triangles.iter().map(|&Triangle { v0, v1, v2 }| Triangle { v0: v1, v1: v2, v2: v0 });
        Self { triangles: triangles.collect(), rays: self.rays.clone() }
    }

    fn with_triangles(mut self, triangles: impl IntoIterator<Item = Triangle>) -> Self {
        self.triangles.extend(triangles);
        self
    }

    /// The same with other rays, made like a [`MakeRay`].
    fn with_rays(mut self, ray: impl Fn(Vec3, Vec3) -> Ray<f32>) -> Self {
        for old in &mut self.rays {
            *old = ray(-old.dir, old.origin + old.dir);
        }
        self
    }

    fn traits(&self) -> Vec<Trait> {
        measured(Mesh::from_triangles(&self.triangles).unwrap().into(), self.rays.clone())
    }
}

fn measured(world: World, rays: Vec<Ray<f32>>) -> Vec<Trait> {
    traits(&Scene::new(world), &[RaySet { name: "rays", any_hit: false, rays }])
}

fn find<'a>(traits: &'a [Trait], name: &str) -> &'a Trait {
    traits.iter().find(|found| found.name == name).unwrap_or_else(|| panic!("no {name} in {traits:#?}"))
}

fn deciding(traits: &[Trait]) -> Vec<&str> {
    traits.iter().filter(|found| found.decides).map(|found| found.name).collect()
}

/// Thin triangles in any position near the origin, below the meadow.
fn slivers(aspect: f32) -> impl Iterator<Item = Triangle> {
    let mut rng = rng(1, "traits", "slivers", &[], 0);
    std::iter::repeat_with(move || {
        let (v0, along) = (in_cube(&mut rng, 1.0) - Vec3::Z * 3.0, direction(&mut rng));
        let across = along.any_orthonormal_vector() / aspect;
        Triangle { v0, v1: v0 + along, v2: v0 + along * 0.4 + across }
    })
}

/// A triangle of this size around the origin.
fn large(size: f32) -> Triangle {
    let [v0, v1, v2] = [[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0) * size);
    Triangle { v0, v1, v2 }
}

/// For each trait of triangles and rays, a severity where it decides, and one where it does not.
const SEVERITIES: [(&str, [f32; 2]); 11] = [
    ("extent", [1e13, 1e6]),
    ("offset from the origin", [2e4, 2e2]),
    ("small triangles far from the origin", [2.0, 0.2]),
    ("slivers", [1e4, 1e2]),
    ("nearly degenerate triangles", [1e4, 1e2]),
    ("triangles without area", [20.0, 3.0]),
    ("small triangles far away", [500.0, 20.0]),
    ("large triangles nearby", [1e5, 1e2]),
    ("grazing rays", [3e-4, 3e-3]),
    ("small determinants", [1e-3, 1e-1]),
    ("coherence", [0.1, 0.01]),
];

/// The case that is made for this trait.
fn made_for(name: &str, severity: f32) -> Case {
    let good = meadow(0.02);
    match name {
        "extent" | "small determinants" => good.scaled(severity),
        "offset from the origin" => good.moved(Vec3::new(1.0, -0.5, 0.25) * severity),
        "small triangles far from the origin" => {
            good.scaled(0.01).moved(Vec3::splat(severity)).with_triangles([large(2.0)])
        }
        "slivers" | "nearly degenerate triangles" => good.with_triangles(slivers(severity).take(20)),
        "triangles without area" => {
            let flat = slivers(1.0).map(|sliver| Triangle { v2: sliver.v1, ..sliver });
            good.with_triangles(flat.take(severity as usize))
        }
        "small triangles far away" => good.with_rays(|away, target| Ray::new(target + away * severity, -away)),
        "large triangles nearby" => Case { triangles: vec![large(severity)], ..good },
        "grazing rays" => meadow(0.0).with_rays(|away, target| {
            let away = away.with_z(0.0).normalize() + Vec3::Z * severity;
            Ray::new(target + away * 0.5, -away)
        }),
        "coherence" => {
            let mut number = 0;
            let turned = good.rays.iter().map(|ray| {
                number += 1;
                let turn = direction(&mut rng(1, "traits", "turns", &[], number)) * (severity * ray.dir.length());
                Ray { dir: ray.dir + turn, ..*ray }
            });
            Case { rays: turned.collect(), ..good }
        }
        _ => panic!("{name}"),
    }
}

#[test]
fn each_trait_decides_beyond_its_limit_also_in_the_same_scene_rotated_shuffled_scaled_and_renumbered() {
    for (name, severities) in SEVERITIES {
        for (severity, decides) in severities.into_iter().zip([true, false]) {
            let case = made_for(name, severity);
            let mut cases = vec![case.rotated(), case.shuffled(), case.renumbered()];
            if !["extent", "small determinants"].contains(&name) {
                cases.push(case.scaled(1000.0));
            }
            cases.push(case);
            for case in cases {
                let traits = case.traits();
                assert_eq!(find(&traits, name).decides, decides, "{name}, {severity}: {traits:#?}");
            }
        }
    }
}

#[test]
fn a_few_hits_and_triangles_decide() {
    let decides = |case: &Case, name: &str| find(&case.traits(), name).decides;
    let changes: [(&str, MakeRay); 4] = [
        ("small triangles far away", |away, target| Ray::new(target + away * 500.0, -away)),
        ("large triangles nearby", |away, target| Ray::new(target + away * 1e-5, -away)),
        ("grazing rays", |away, target| {
            let away = away.with_z(0.0).normalize() + Vec3::Z * 3e-4;
            Ray::new(target + away * 0.5, -away)
        }),
        ("small determinants", |away, target| Ray::new(target + away, away * -1e-6)),
    ];
    for (name, change) in changes {
        let (mut case, bad) = (meadow(0.0), meadow(0.0).with_rays(change));
        for (count, expected) in [(1, false), (8, true)] {
            case.rays[..count].copy_from_slice(&bad.rays[..count]);
            assert_eq!(decides(&case, name), expected, "{name}: {count} of {} rays", case.rays.len());
        }
    }
    for name in ["slivers", "nearly degenerate triangles"] {
        for (count, expected) in [(3, false), (20, true)] {
            let case = meadow(0.0).with_triangles(slivers(1e5).take(count));
            assert_eq!(decides(&case, name), expected, "{name}: {count} of {} triangles", case.triangles.len());
        }
    }
}

#[test]
fn no_trait_decides_in_a_meadow_at_the_origin() {
    let case = meadow(0.02);
    let changed =
        [case.rotated(), case.shuffled(), case.scaled(1000.0), case.renumbered(), case.moved(Vec3::splat(50.0))];
    for case in [case].iter().chain(&changed) {
        let traits = case.traits();
        assert_eq!(deciding(&traits), [""; 0], "{traits:#?}");
        assert_eq!(traits.len(), 13);
    }
}

#[test]
fn only_rounding_changes_ratios_in_the_same_scene_shuffled_scaled_and_renumbered() {
    for (name, [severity, _]) in SEVERITIES {
        let case = made_for(name, severity);
        let traits = case.traits();
        for changed in [case.shuffled(), case.scaled(1000.0), case.renumbered()] {
            for (old, new) in traits.iter().zip(changed.traits()) {
                // The first two are no ratios, and the third is rounding itself.
                if !["extent", "small determinants", "nearly degenerate triangles"].contains(&old.name) {
                    let apart = (new.value - old.value).abs();
                    assert!(apart <= 0.05 * old.value, "{name}: {old:?}, {new:?}");
                }
            }
        }
    }
}

#[test]
fn a_small_room_at_the_origin_has_no_trait_that_decides() {
    let loaded = SceneSource::parse("room:small").unwrap().load().unwrap();
    let scene = Scene::new(loaded.world);
    let found = traits(&scene, &ray_sets(&scene, &loaded.view, 128, 1));
    assert_eq!(deciding(&found), [""; 0], "{found:#?}");
    for (number, found_here) in found.iter().enumerate() {
        assert!(found[..number].iter().all(|before| before.name != found_here.name));
        let lines = [found_here.name, &found_here.text, found_here.why];
        assert!(lines.iter().all(|line| !line.is_empty() && !line.contains('\n') && !line.contains('–')), "{lines:?}");
    }
}

#[test]
fn one_triangle_and_one_ray_are_measured_in_the_coordinates_of_the_mesh() {
    // A right triangle with the sides 3, 4 and 5, seen from 10 units above.
    let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X * 3.0, v2: Vec3::Y * 4.0 };
    let ray = Ray::new(Vec3::new(1.0, 1.0, 10.0), Vec3::new(0.0, 0.0, -2.0));
    let values = |object_to_world: Affine3, ray: Ray<f32>| {
        let geometry = Geometry::Mesh(Mesh::from_triangles(&[triangle]).unwrap());
        let traits = measured(World::new(vec![geometry], vec![Placement::new(0, object_to_world)]).unwrap(), vec![ray]);
        [
            "slivers",
            "small triangles far from the origin",
            "small triangles far away",
            "large triangles nearby",
            "grazing rays",
            "small determinants",
        ]
        .map(|name| find(&traits, name).value)
    };
    let expected = [25.0 / 12.0, 4.0 / 5.0, 2.0, 2.0, 1.0, 24.0];
    let close = |values: [f64; 6]| values.iter().zip(expected).all(|(value, right)| (value / right - 1.0).abs() < 1e-6);
    let alone = values(Affine3::IDENTITY, ray);
    assert!(close(alone), "{alone:?}");
    let transform = Affine3 { matrix3: Mat3::from_rotation_x(0.3) * 7.0, translation: Vec3::new(10.0, 20.0, 30.0) };
    let placed =
        values(transform, Ray::new(transform.transform_point3(ray.origin), transform.transform_vector3(ray.dir)));
    assert!(close(placed), "{placed:?}");
}

#[test]
fn rays_at_quadrics_are_measured() {
    let values = |quadric: Quadric, rays: Vec<Ray<f32>>| {
        let world = World::new(vec![quadric.into()], vec![Placement::new(0, Affine3::IDENTITY)]).unwrap();
        let traits = measured(world, rays);
        let of_quadrics = ["small quadrics far away", "large quadrics nearby", "rays along the axis of quadrics"];
        of_quadrics.map(|name| (find(&traits, name).value, find(&traits, name).decides))
    };
    let down = |height: f32, slope: f32| Ray::new(Vec3::new(0.0, 0.0, height), Vec3::new(slope, 0.0, -3.0));
    let seen = values(Quadric::sphere(2.0), vec![down(12.0, 0.1)]);
    for ((value, decides), expected) in seen.into_iter().zip([6.0, 5.0, 1.0 / 3f64.sqrt()]) {
        assert!((value / expected - 1.0).abs() < 3e-3 && !decides, "{seen:?}");
    }
    let decides = |quadric, rays| values(quadric, rays).map(|(_, decides)| decides);
    assert_eq!(decides(Quadric::sphere(2.0), vec![down(2e4, 0.0)]), [true, false, false]);
    // Long in one direction: the others decide.
    assert_eq!(decides(Quadric::ellipsoid(Vec3::new(0.1, 2.0, 0.1)), vec![down(12.0, 0.0)]), [true, false, false]);
    assert_eq!(decides(Quadric::sphere(8192.0), vec![down(8192.0 + 1.0 / 1024.0, 0.1)]), [false, true, false]);
    assert_eq!(decides(Quadric::sphere(8192.0), vec![down(8193.0, 0.1)]), [false; 3]);
    assert_eq!(decides(Quadric::paraboloid(1.0, 1.0), vec![down(3.0, 0.003)]), [false, false, true]);
    assert_eq!(decides(Quadric::paraboloid(1.0, 1.0), vec![down(3.0, 0.3)]), [false; 3]);
    // A plane has no t² in any direction.
    let plane: World =
        World::new(vec![Quadric::plane(glam::Vec2::ONE).into()], vec![Placement::new(0, Affine3::IDENTITY)]).unwrap();
    let traits = measured(plane, vec![down(3.0, 0.0)]);
    assert_eq!(
        traits.iter().map(|found| found.name).collect::<Vec<_>>(),
        ["size", "extent", "offset from the origin", "condition of transforms", "coherence"]
    );
}

#[test]
fn one_in_a_thousand_may_be_beyond_the_limit() {
    let values = |worst: usize| (0..2000).map(|number| if number < worst { 9.0 } else { 1.0 }).collect::<Vec<_>>();
    assert_eq!([2, 3].map(|worst| quantile(&mut values(worst), HIGH)), [1.0, 9.0]);
    let values = |worst: usize| (0..2000).map(|number| if number < worst { 0.0 } else { 1.0 }).collect::<Vec<_>>();
    assert_eq!([1, 2].map(|worst| quantile(&mut values(worst), LOW)), [1.0, 0.0]);
    assert_eq!([LOW, 0.5, HIGH, 1.0].map(|share| quantile(&mut [3.0, 1.0, 2.0], share)), [1.0, 2.0, 3.0, 3.0]);
}
