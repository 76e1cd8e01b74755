//! Small scenes, each made so that one thing about it decides which kernel it needs, and ways to write the same scene
//! differently.

use glam::{Affine3, DAffine3, DMat3, DVec3, Mat3, Vec3};
use raylanes::geom::Quadric;
use raylanes::tracer::{Geometry, Light, LoadedScene, Mesh, Part, Placement, SceneSource, View, World};

/// A mesh that grows.
#[derive(Default)]
struct Builder {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Builder {
    /// A parallelogram of `2·n·m` triangles. Its front is where `u × v` points.
    fn grid(&mut self, corner: Vec3, [u, v]: [Vec3; 2], [n, m]: [u32; 2]) {
        let first = self.positions.len() as u32;
        for j in 0..=m {
            for i in 0..=n {
                self.positions.push(corner + u * (i as f32 / n as f32) + v * (j as f32 / m as f32));
            }
        }
        for j in 0..m {
            for i in 0..n {
                let a = first + j * (n + 1) + i;
                let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// A box with `n × n` squares per face, seen from outside, or from inside.
    fn cuboid(&mut self, lo: Vec3, hi: Vec3, n: u32, from_inside: bool) {
        let size = hi - lo;
        for axis in 0..3 {
            let [u, v] = [1, 2].map(|next| Vec3::AXES[(axis + next) % 3] * size);
            let normal = Vec3::AXES[axis] * size;
            for (corner, out) in [(lo, false), (lo + normal, true)] {
                let sides = if out == from_inside { [v, u] } else { [u, v] };
                self.grid(corner, sides, [n, n]);
            }
        }
    }

    fn mesh(self) -> Mesh {
        Mesh::new(self.positions, self.triangles, vec![Part { first_triangle: 0, color: Vec3::splat(0.8) }]).unwrap()
    }
}

fn view(eye: [f32; 3], look_at: [f32; 3], vertical_fov: f32, light: Light) -> View {
    View { eye: eye.into(), look_at: look_at.into(), vertical_fov, transform: None, light }
}

fn loaded(world: impl Into<World>, view: View) -> LoadedScene {
    LoadedScene { world: world.into(), view, remarks: Vec::new() }
}

/// A room of about 9,000 triangles with eight blocks, around this point of the floor.
fn room_at(at: Vec3) -> LoadedScene {
    let mut builder = Builder::default();
    builder.cuboid(at + Vec3::new(-5.0, 0.0, -5.0), at + Vec3::splat(5.0), 16, true);
    for number in 0..8 {
        let place = at + Vec3::new(-4.1 + (number % 4) as f32 * 2.13, 0.01, -4.2 + (number / 4) as f32 * 3.7);
        let size = 0.6 + 0.1 * number as f32;
        builder.cuboid(place, place + Vec3::new(size, 1.5 * size, size), 8, false);
    }
    let at = |x, y, z| (at + Vec3::new(x, y, z)).to_array();
    let light = Light::Point(at(0.3, 4.5, 0.2).into());
    loaded(builder.mesh(), view(at(4.5, 3.0, 4.5), at(0.0, 1.0, 0.0), 60.0, light))
}

/// A small room at the origin: nothing about it is hard.
pub(crate) fn room() -> LoadedScene {
    room_at(Vec3::ZERO)
}

/// The same room far away. Its coordinates are rounded there.
pub(crate) fn far_room() -> LoadedScene {
    room_at(Vec3::new(1e5, 0.0, 1e5))
}

/// Blocks on one triangle that is ten million times as large as they are.
pub(crate) fn huge_ground() -> LoadedScene {
    let positions = vec![Vec3::new(-1e7, 0.0, -1e7), Vec3::new(1e7, 0.0, -1e7), Vec3::new(0.0, 0.0, 2e7)];
    let mut builder = Builder { positions, triangles: vec![[0, 2, 1]] };
    for number in 0..20 {
        let place = Vec3::new(-5.3 + (number % 5) as f32 * 2.3, 0.0, -4.1 + (number / 5) as f32 * 2.1);
        builder.cuboid(place, place + Vec3::ONE, 4, false);
    }
    loaded(builder.mesh(), view([0.0, 3.0, 14.0], [0.0; 3], 60.0, Light::Point(Vec3::new(5.0, 9.0, 5.0))))
}

/// Waves of triangles a thousand times as long as they are wide.
pub(crate) fn slivers() -> LoadedScene {
    let mut builder = Builder::default();
    builder.grid(Vec3::new(-5.0, 0.0, -5.0), [Vec3::Z * 10.0, Vec3::X * 10.0], [1000, 1]);
    for position in &mut builder.positions {
        position.y = 0.05 * wave(position.z * 0.5);
    }
    loaded(builder.mesh(), view([0.0, 6.0, 4.0], [0.0; 3], 60.0, Light::Point(Vec3::new(3.0, 9.0, 3.0))))
}

/// A hill of height 1/4 in each unit interval.
fn wave(x: f32) -> f32 {
    let x = x.rem_euclid(1.0);
    x * (1.0 - x)
}

/// A plain with low hills that reaches ten thousand times as far as the eye is high.
pub(crate) fn horizon() -> LoadedScene {
    let mut builder = Builder::default();
    builder.grid(Vec3::new(-1000.0, 0.0, -10_000.0), [Vec3::Z * 10_020.0, Vec3::X * 2000.0], [500, 100]);
    for position in &mut builder.positions {
        position.y = 0.3 * wave(position.x * 0.08) * wave(position.z * 0.05);
    }
    let light = Light::Point(Vec3::new(3.0, 900.0, 3.0));
    loaded(builder.mesh(), view([0.0, 0.1, 15.0], [0.0, 0.0, -1000.0], 40.0, light))
}

/// A block, sheared by a factor of a thousand.
pub(crate) fn sheared() -> LoadedScene {
    let mut builder = Builder::default();
    builder.cuboid(-Vec3::ONE, Vec3::ONE, 16, false);
    let shear = Affine3::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(1000.0, 1.0, 0.0), Vec3::Z));
    let world = World::new(vec![Geometry::Mesh(builder.mesh())], vec![Placement::new(0, shear)]).unwrap();
    // It is thin where it is seen.
    loaded(world, view([0.0, 3.0, 40.0], [0.0; 3], 2.0, Light::Directional(Vec3::new(1.0, 2.0, 3.0))))
}

/// A unit sphere, seen from ten thousand radii.
pub(crate) fn far_sphere() -> LoadedScene {
    let sphere = Geometry::Quadric(Quadric::sphere(1.0));
    let world = World::new(vec![sphere], vec![Placement::new(0, Affine3::IDENTITY)]).unwrap();
    // The picture is as wide as the sphere is seen.
    let view = View { vertical_fov: 0.02, ..view([0.0, 0.0, 1e4], [0.0; 3], 1.0, Light::Directional(Vec3::Y)) };
    loaded(world, view)
}

fn ball(at: Vec3) -> Mesh {
    let LoadedScene { world, .. } = SceneSource::parse("sphere:1000").unwrap().load().unwrap();
    let (geometries, _) = world.into_parts();
    let Some(Geometry::Mesh(mesh)) = geometries.into_iter().next() else { panic!("the sphere is a mesh") };
    let positions = mesh.positions().iter().map(|position| position + at).collect();
    Mesh::new(positions, mesh.triangles().to_vec(), mesh.parts().to_vec()).unwrap()
}

/// A tessellated sphere.
pub(crate) fn tessellated_sphere() -> LoadedScene {
    let mesh = ball(Vec3::ZERO);
    let view = View::around(&mesh.bounds());
    loaded(mesh, view)
}

/// Four equal rooms, each a mesh of its own.
pub(crate) fn duplicates() -> LoadedScene {
    let LoadedScene { world, .. } = room();
    let (geometries, _) = world.into_parts();
    let mesh = geometries.into_iter().next().unwrap();
    let place = |number: u32| {
        let at = Vec3::new(1.0 + (number % 2) as f32 * 12.0, 0.0, (number / 2) as f32 * 12.0);
        Placement::new(number, Affine3::from_translation(at))
    };
    let world = World::new(vec![mesh; 4], (0..4).map(place).collect()).unwrap();
    let light = Light::Directional(Vec3::new(1.0, 2.0, 0.5));
    loaded(world, view([30.0, 25.0, 40.0], [6.0, 0.0, 6.0], 50.0, light))
}

/// Writes a scene differently.
type Rewrite = fn(LoadedScene) -> LoadedScene;

/// Ways to write the same scene.
pub(crate) const VARIANTS: [(&str, Rewrite); 5] = [
    ("as it is", |scene| scene),
    ("rotated", |scene| {
        let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        placed(scene, DAffine3::from_mat3(rotation))
    }),
    ("scaled by 1000", |scene| placed(scene, DAffine3::from_scale(DVec3::splat(1000.0)))),
    ("shuffled", |scene| {
        with_meshes(scene, |mesh| {
            let mut triangles = mesh.triangles().to_vec();
            // A fixed permutation: by a multiple that has no factor in common with any small count.
            let count = triangles.len();
            triangles.sort_by_cached_key(|corners| (corners[0] as usize * 7_919 + corners[2] as usize) % count);
            Mesh::new(mesh.positions().to_vec(), triangles, mesh.parts()[..1].to_vec()).unwrap()
        })
    }),
    ("renumbered", |scene| {
        with_meshes(scene, |mesh| {
            let last = mesh.positions().len() as u32 - 1;
            let positions = mesh.positions().iter().rev().copied().collect();
            let triangle = |&[a, b, c]: &[u32; 3]| [last - b, last - c, last - a];
            let triangles = mesh.triangles().iter().map(triangle).collect();
            Mesh::new(positions, triangles, mesh.parts().to_vec()).unwrap()
        })
    }),
];

fn with_meshes(scene: LoadedScene, change: impl Fn(&Mesh) -> Mesh) -> LoadedScene {
    let (mut geometries, placements) = scene.world.into_parts();
    for geometry in &mut geometries {
        if let Geometry::Mesh(mesh) = geometry {
            *mesh = change(mesh);
        }
    }
    LoadedScene { world: World::new(geometries, placements).unwrap(), ..scene }
}

/// The scene, moved as a whole. Untransformed meshes stay untransformed.
fn placed(scene: LoadedScene, transform: DAffine3) -> LoadedScene {
    let point = |point: Vec3| transform.transform_point3(point.as_dvec3()).as_vec3();
    let (mut geometries, mut placements) = scene.world.into_parts();
    for placement in &mut placements {
        let geometry = &mut geometries[placement.geometry as usize];
        match geometry {
            Geometry::Mesh(mesh) if placement.object_to_world == Affine3::IDENTITY => {
                let positions = mesh.positions().iter().map(|position| point(*position)).collect();
                *mesh = Mesh::new(positions, mesh.triangles().to_vec(), mesh.parts().to_vec()).unwrap();
            }
            _ => {
                let Affine3 { matrix3, translation } = placement.object_to_world;
                let inner = DAffine3 { matrix3: matrix3.as_dmat3(), translation: translation.as_dvec3() };
                let DAffine3 { matrix3, translation } = transform * inner;
                placement.object_to_world = Affine3 { matrix3: matrix3.as_mat3(), translation: translation.as_vec3() };
            }
        }
    }
    let View { eye, look_at, light, .. } = scene.view;
    let light = match light {
        Light::Point(light) => Light::Point(point(light)),
        Light::Directional(light) => Light::Directional(transform.transform_vector3(light.as_dvec3()).as_vec3()),
    };
    let view = View { eye: point(eye), look_at: point(look_at), light, ..scene.view };
    LoadedScene { world: World::new(geometries, placements).unwrap(), view, ..scene }
}
