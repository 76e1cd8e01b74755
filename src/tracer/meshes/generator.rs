//! Meshes made by code, in any size: they need no files and are the same, bit for bit, on every machine. Generators
//! therefore use whole numbers, `+ - * /` and square roots, but no sines or powers, which differ between platforms.
//! Neighbouring triangles share their vertices, so the surfaces are watertight.

mod hash;
mod room;
mod sphere;
mod square;
mod terrain;
mod tree;

pub(crate) use hash::hash;

use super::mesh::Mesh;

/// A mesh that has been named but not yet made.
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

const KINDS: [(&str, Kind); 5] = [
    ("room", Kind::Room),
    ("terrain", Kind::Terrain),
    ("sphere", Kind::Sphere),
    ("tree", Kind::Tree),
    ("square", Kind::Square),
];

/// What may stand for a number.
const SIZES: [(&str, u32); 3] = [("small", 10_000), ("medium", 100_000), ("large", 1_000_000)];
/// The size of what comes in sizes and is given none.
pub(crate) const DEFAULT_SIZE: u32 = SIZES[1].1;
const FEWEST: u32 = 1_000;
/// The greatest size.
pub(crate) const MOST: u32 = 10_000_000;

impl Generator {
    /// Understands `NAME` and `NAME:SIZE`; without a size, and for all but the square, which always has two triangles, the
    /// mesh gets `size` triangles. It has as many as asked for, or the next number it can be made of.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
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

    /// The least resolution that gives so many triangles.
    fn with_triangles(kind: Kind, triangles: u32) -> Self {
        let count = match kind {
            Kind::Room => room::triangles,
            Kind::Terrain => terrain::triangles,
            Kind::Sphere => sphere::triangles,
            Kind::Tree => tree::triangles,
            Kind::Square => |_| u32::MAX,
        };
        // All counts grow with the square of the resolution, so this ends after at most some thousand steps.
        let resolution = (1..).find(|&resolution| count(resolution) >= triangles).unwrap_or(u32::MAX);
        Self { kind, resolution }
    }

    /// The triangles.
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

/// Understands `small` (10,000), `medium` (100,000), `large` (1,000,000) and a whole number from 1,000 to 10,000,000, also
/// written `1e6` or `1_000_000`.
///
/// # Errors
/// What would be right; `unit` says what is counted.
pub(crate) fn parse_size(size: &str, unit: &str) -> Result<u32, String> {
    if let Some(&(_, number)) = SIZES.iter().find(|(name, _)| *name == size) {
        return Ok(number);
    }
    // As a floating-point number, since that is what 1e6 is; it holds all whole numbers in the range.
    match size.replace('_', "").parse::<f64>() {
        Ok(number) if (f64::from(FEWEST)..=f64::from(MOST)).contains(&number) && number.fract() == 0.0 => {
            Ok(number as u32)
        }
        _ => {
            let names = SIZES.map(|(name, _)| name).join(", ");
            Err(format!("the size must be one of {names} or a number of {unit} from {FEWEST} to {MOST}"))
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

    /// Those that come in sizes.
    fn sized() -> impl Iterator<Item = &'static str> {
        KINDS.iter().map(|&(name, _)| name).filter(|&name| name != "square")
    }

    #[test]
    fn names_and_sizes_are_understood() {
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
    fn a_mesh_has_the_triangles_asked_for_or_slightly_more() {
        for name in sized() {
            for triangles in [1_000u32, 2_048, 10_000, 123_457, 1_000_000] {
                let mesh = parse(&format!("{name}:{triangles}")).mesh();
                let excess = mesh.len() as f64 / f64::from(triangles) - 1.0;
                // One step more of resolution n adds about two parts in n, or four for the boxes of the room.
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

    /// FNV-1a over all bits. Another sum means another scene, and that old measurements can no longer be compared.
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

    /// How often each directed edge occurs.
    fn edges(mesh: &Mesh) -> HashMap<(u32, u32), usize> {
        let mut edges = HashMap::new();
        for &[a, b, c] in mesh.triangles() {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        edges
    }

    /// Positive where the triangles of a closed mesh face outwards.
    fn volume(mesh: &Mesh) -> f64 {
        let six_fold: f64 = mesh
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.vertices().map(Vec3::as_dvec3);
                a.dot(b.cross(c))
            })
            .sum();
        six_fold / 6.0
    }

    #[test]
    fn room_sphere_and_tree_are_closed_and_consistently_wound() {
        for scene in ["room:1e3", "room", "sphere:1e3", "sphere", "tree:1e3", "tree"] {
            let mesh = parse(scene).mesh();
            let edges = edges(&mesh);
            for (&(a, b), &count) in &edges {
                assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "{scene}: edge from {a} to {b}");
            }
            // As many vertices as positions: nothing is shared by position only.
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
        let content = |cuboid: &room::Cuboid| 8.0 * f64::from(cuboid.half.x * cuboid.half.y * cuboid.half.z);
        let boxes: f64 = room::BOXES.iter().map(|(cuboid, _)| content(cuboid)).sum();
        let expected = boxes - content(&room::SHELL);
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
    fn a_square_faces_up_and_its_barycentrics_continue_across_the_diagonal() {
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
        // A sheet: inner edges have a neighbour, and only the rim's have none.
        let edges = edges(&mesh);
        assert!(edges.values().all(|&count| count == 1));
        let rim = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count();
        assert_eq!(rim, 4 * parse("terrain").resolution as usize);
    }
}
