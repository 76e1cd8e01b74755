//! Generated meshes of any size: a room, a terrain, a sphere, a tree, a square.
//!
//! They are the same, bit for bit, on every machine. So generators use whole numbers, `+ - * /` and square roots only:
//! sines and powers differ between platforms. Neighbouring triangles share their vertices, so the surfaces are
//! watertight.

mod hash;
mod room;
mod sphere;
mod square;
mod terrain;
mod tree;

pub(crate) use hash::{hash, unit_interval};

use super::mesh::Mesh;

/// What mesh to make: the kind and the resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Generator {
    kind: Kind,
    resolution: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Room,
    Terrain,
    Sphere,
    Tree,
    Square,
}

impl Kind {
    /// The number of triangles as a function of the resolution.
    fn triangles(self) -> fn(u32) -> u32 {
        match self {
            Self::Room => room::triangles,
            Self::Terrain => terrain::triangles,
            Self::Sphere => sphere::triangles,
            Self::Tree => tree::triangles,
            Self::Square => |_| u32::MAX,
        }
    }
}

const KINDS: [(&str, Kind); 5] = [
    ("room", Kind::Room),
    ("terrain", Kind::Terrain),
    ("sphere", Kind::Sphere),
    ("tree", Kind::Tree),
    ("square", Kind::Square),
];

/// Names for sizes.
const NAMED_SIZES: [(&str, u32); 3] = [("small", 10_000), ("medium", 100_000), ("large", 1_000_000)];
/// The size of a mesh or scene that is named without one.
pub(crate) const DEFAULT_SIZE: u32 = NAMED_SIZES[1].1;
const MIN_SIZE: u32 = 1_000;
/// The largest size.
pub(crate) const MAX_SIZE: u32 = 10_000_000;

impl Generator {
    /// Parses `NAME` or `NAME:SIZE`. Without a size in the text, the mesh gets `size` triangles. The mesh has that many
    /// triangles or the next larger number that its shape allows. The square has no size: it has two triangles.
    ///
    /// # Errors
    /// The text names no generator, or its size is not valid. The message says what was expected.
    pub(crate) fn parse(text: &str, size: u32) -> Result<Self, String> {
        let (name, own_size) = match text.split_once(':') {
            Some((name, size)) => (name, Some(size)),
            None => (text, None),
        };
        let Some(&(_, kind)) = KINDS.iter().find(|(known, _)| *known == name) else {
            return Err(format!("no such generator, expected one of {}", KINDS.map(|(name, _)| name).join(", ")));
        };
        if kind == Kind::Square {
            return if own_size.is_some() {
                Err("a square has no size".into())
            } else {
                Ok(Self { kind, resolution: 1 })
            };
        }
        let triangles = own_size.map_or(Ok(size), |size| parse_size(size, "triangles"))?;
        Ok(Self::with_triangles(kind, triangles))
    }

    /// Uses the smallest resolution that gives at least this many triangles.
    fn with_triangles(kind: Kind, triangles: u32) -> Self {
        let count = kind.triangles();
        // Counts grow with the square of the resolution, so this takes a few thousand steps at most.
        let resolution = (1..).find(|&resolution| count(resolution) >= triangles).unwrap_or(u32::MAX);
        Self { kind, resolution }
    }

    /// About the memory that making the mesh takes: indices, vertices, and as much again for vectors that grow.
    pub(crate) fn bytes(self) -> usize {
        const PER_TRIANGLE: usize = 40;
        let triangles = if self.kind == Kind::Square { 2 } else { self.kind.triangles()(self.resolution) };
        triangles as usize * PER_TRIANGLE
    }

    /// Makes the mesh.
    pub(crate) fn mesh(self) -> Mesh {
        match self.kind {
            Kind::Room => room::mesh(self.resolution),
            Kind::Terrain => terrain::mesh(self.resolution),
            Kind::Sphere => sphere::mesh(self.resolution),
            Kind::Tree => tree::mesh(self.resolution),
            Kind::Square => square::mesh(),
        }
    }
}

/// Parses a size: `small` (10,000), `medium` (100,000), `large` (1,000,000), or a whole number from 1,000 to
/// 10,000,000. Forms like `1e6` and `1_000_000` are numbers too.
///
/// # Errors
/// The text is none of these. The message says what was expected; `unit` names the things that the size counts.
pub(crate) fn parse_size(size: &str, unit: &str) -> Result<u32, String> {
    if let Some(&(_, number)) = NAMED_SIZES.iter().find(|(name, _)| *name == size) {
        return Ok(number);
    }
    // As f64, so that 1e6 is accepted. It represents every whole number in the range.
    match size.replace('_', "").parse::<f64>() {
        Ok(number) if (f64::from(MIN_SIZE)..=f64::from(MAX_SIZE)).contains(&number) && number.fract() == 0.0 => {
            Ok(number as u32)
        }
        _ => {
            let names = NAMED_SIZES.map(|(name, _)| name).join(", ");
            Err(format!("the size must be one of {names} or a number of {unit} from {MIN_SIZE} to {MAX_SIZE}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use glam::Vec3;

    use super::*;

    fn parse(text: &str) -> Generator {
        Generator::parse(text, DEFAULT_SIZE).expect("a generator")
    }

    /// Names of the generators that have a size.
    fn sized() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|&(name, _)| name).filter(|&name| name != "square")
    }

    #[test]
    fn names_and_sizes_are_parsed() {
        for name in sized() {
            let million = parse(&format!("{name}:large"));
            for size in ["1000000", "1e6", "1_000_000", "1E6", "1000000.0"] {
                assert_eq!(parse(&format!("{name}:{size}")), million, "{name}:{size}");
            }
            assert_eq!(parse(name), parse(&format!("{name}:medium")));
            assert_eq!(Generator::parse(name, 1_000_000), Ok(million));
            assert_ne!(parse(name), million);
        }
        for other in ["", "rooms", "Room", "room.obj", ":1e6", "forest", "gallery"] {
            let message = Generator::parse(other, DEFAULT_SIZE).unwrap_err();
            assert_eq!(message, "no such generator, expected one of room, terrain, sphere, tree, square", "{other}");
        }
        for size in
            ["", "huge", "0", "-1e6", "999", "1e7x", "10000001", "1000.5", "nan", "inf", "1e400", "a\nb", "1e6:"]
        {
            let message = Generator::parse(&format!("room:{size}"), DEFAULT_SIZE).unwrap_err();
            let expected = "small, medium, large or a number of triangles from 1000 to 10000000";
            assert_eq!(message, format!("the size must be one of {expected}"), "{size}");
        }
        assert_eq!(Generator::parse("square:1e3", DEFAULT_SIZE).unwrap_err(), "a square has no size");
    }

    #[test]
    fn a_mesh_has_the_requested_number_of_triangles_or_slightly_more() {
        for name in sized() {
            for triangles in [1_000u32, 2_048, 10_000, 123_457, 1_000_000] {
                let mesh = parse(&format!("{name}:{triangles}")).mesh();
                let excess = mesh.len() as f64 / f64::from(triangles) - 1.0;
                // One more step of resolution n adds about 2/n of the triangles, or 4/n for the boxes of the room.
                let allowed = 24.0 / f64::from(triangles).sqrt();
                assert!((0.0..allowed).contains(&excess), "{name}:{triangles} has {} triangles", mesh.len());
                assert_eq!(mesh.degenerate_triangles(), 0, "{name}:{triangles}");
            }
        }
        assert_eq!(parse("terrain:1e6").mesh().len(), 1_002_528);
        assert_eq!(parse("sphere:2048").mesh().len(), 2_048);
        assert_eq!(parse("sphere:1e7").resolution, 1119);
        assert_eq!(parse("square").mesh().len(), 2);
    }

    /// FNV-1a over all bits. If a sum changes, the scene has changed, and old measurements can no longer be compared.
    #[test]
    fn meshes_are_the_same_on_every_machine() {
        let sums = ["room:small", "terrain:small", "sphere:small", "tree:small", "square"].map(|name| {
            let mesh = parse(name).mesh();
            let positions = mesh.positions().iter().flat_map(|position| position.to_array().map(f32::to_bits));
            let indices = mesh.triangles().iter().copied().flatten();
            positions
                .chain(indices)
                .fold(0xcbf2_9ce4_8422_2325u64, |sum, word| (sum ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3))
        });
        assert_eq!(
            sums.map(|sum| format!("{sum:016x}")),
            ["add189b8927fbd73", "dce403645e818f45", "04fdabc1199cc8d1", "b7445e44f45ad6e3", "d40ef114ee58d71b"]
        );
    }

    /// Counts each directed edge.
    fn edges(mesh: &Mesh) -> HashMap<(u32, u32), usize> {
        let mut edges = HashMap::new();
        for &[a, b, c] in mesh.triangles() {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        edges
    }

    /// The enclosed volume of a closed mesh: positive if its triangles face outwards, else negative.
    fn volume(mesh: &Mesh) -> f64 {
        let six_volumes: f64 = mesh
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.vertices().map(Vec3::as_dvec3);
                a.dot(b.cross(c))
            })
            .sum();
        six_volumes / 6.0
    }

    #[test]
    fn room_sphere_and_tree_are_closed_and_consistently_wound() {
        for scene in ["room:1e3", "room", "sphere:1e3", "sphere", "tree:1e3", "tree"] {
            let mesh = parse(scene).mesh();
            let edges = edges(&mesh);
            for (&(a, b), &count) in &edges {
                assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "{scene}: edge from {a} to {b}");
            }
            // No two vertices have the same position, so triangles that touch share the vertex itself.
            let distinct: HashSet<_> =
                mesh.positions().iter().map(|position| position.to_array().map(f32::to_bits)).collect();
            assert_eq!(distinct.len(), mesh.positions().len(), "{scene}");
        }
    }

    #[test]
    fn the_sphere_faces_outwards() {
        let mesh = parse("sphere:large").mesh();
        assert!((volume(&mesh) / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
        for triangle in mesh.iter() {
            assert!(triangle.normal().dot(triangle.v0) > 0.99, "{triangle:?}");
        }
    }

    #[test]
    fn the_room_faces_inwards_and_its_boxes_outwards() {
        let mesh = parse("room:small").mesh();
        let box_volume = |cuboid: &room::Cuboid| 8.0 * f64::from(cuboid.half.x * cuboid.half.y * cuboid.half.z);
        let boxes: f64 = room::BOXES.iter().map(|(cuboid, _)| box_volume(cuboid)).sum();
        let expected = boxes - box_volume(&room::SHELL);
        assert!((volume(&mesh) / expected - 1.0).abs() < 1e-5, "{} {expected}", volume(&mesh));
        assert!(mesh.parts().len() > 10);
        assert_eq!(mesh.bounds().extent(), room::SHELL.half * 2.0);
    }

    #[test]
    fn a_tree_faces_outwards_and_stands_on_its_origin() {
        let mesh = parse("tree").mesh();
        assert!(volume(&mesh) > 0.0);
        let [bark, needles] = mesh.parts() else { panic!("{:?}", mesh.parts()) };
        assert!(needles.first_triangle > 0 && bark.color != needles.color);
        let bounds = mesh.bounds();
        assert_eq!((bounds.lo.y, bounds.hi.y), (0.0, 1.0));
        assert!(bounds.extent().x < 0.6 && bounds.extent().z < 0.6, "{bounds:?}");
    }

    #[test]
    fn a_square_faces_up_and_opposite_points_have_equal_barycentrics() {
        let mesh = parse("square").mesh();
        assert_eq!((mesh.bounds().lo, mesh.bounds().hi), (Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0)));
        let [a, b] = [mesh.triangle(0), mesh.triangle(1)];
        assert_eq!([a.normal(), b.normal()], [Vec3::Y; 2]);
        for (u, v) in [(0.25, 0.5), (1.0, 0.0), (0.0, 1.0), (0.125, 0.25)] {
            assert_eq!(b.point(u, v), Vec3::new(1.0, 0.0, 1.0) - a.point(u, v));
        }
    }

    #[test]
    fn the_terrain_faces_up_and_stays_in_bounds() {
        let mesh = parse("terrain").mesh();
        let bounds = mesh.bounds();
        assert_eq!((bounds.lo.x, bounds.hi.x, bounds.lo.z, bounds.hi.z), (-50.0, 50.0, -50.0, 50.0));
        assert!((5.0..30.0).contains(&bounds.extent().y), "{bounds:?}");
        for triangle in mesh.iter() {
            assert!(triangle.normal().y > 0.1, "{triangle:?}");
        }
        // A sheet: each inner edge has an opposite edge, each edge of the rim has none.
        let edges = edges(&mesh);
        assert!(edges.values().all(|&count| count == 1));
        let rim = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count();
        assert_eq!(rim, 4 * parse("terrain").resolution as usize);
    }
}
