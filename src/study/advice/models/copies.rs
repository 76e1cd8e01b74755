//! Components of one mesh that are moved copies of each other: they become instances of one of them.
//!
//! Neither the order of triangles nor that of vertices matters. Two components are compared in time `n log n`: vertices
//! are sorted along a direction in which hardly any two are level, and matched one to one. Triangles must then join
//! matched vertices, in the same orientation.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::pieces::{Piece, Pieces, replaced};
use super::weld::{self, Components, only_color, remaining};
use super::{Deviation, SimplerModel, in_place};
use crate::tracer::{Geometry, Mesh, Paint, World};

pub(super) const NAME: &str = "instance repeated parts";

/// Smaller components are not worth a transform.
const MIN_TRIANGLES: usize = 64;
/// At least one triangle of so many must be saved.
const MIN_SAVED: usize = 4;
/// Vertices of two copies may differ by this fraction of the largest coordinate: up to four ulp.
const TOLERANCE: f64 = 1.0 / (1 << 22) as f64;
/// A component that is not so many times as large as the tolerance has no certain shape.
const MIN_SIZE: f64 = 1e4;
/// Along this direction vertices are sorted. Grids have no two vertices level in it.
const ALONG: DVec3 = DVec3::new(0.532_907_1, 0.617_283_9, 0.578_703_3);

/// Makes instances of repeated components, in meshes that have one instance without a checker pattern.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let (mut copies, mut saved) = (0, 0);
    let pieces: Vec<_> = (0..)
        .zip(world.geometries())
        .map(|(number, geometry)| {
            let Geometry::Mesh(mesh) = geometry else { return None };
            let mut shown = world.instances().iter().filter(|placement| placement.geometry == number);
            let (Some(only), None) = (shown.next(), shown.next()) else { return None };
            if matches!(only.paint, Paint::Checker(_)) {
                return None;
            }
            let classes = classes(mesh);
            let saved_here =
                classes.iter().map(|class| class.copies.len() * class.first.triangles.len()).sum::<usize>();
            if saved_here * MIN_SAVED < mesh.len() {
                return None;
            }
            copies += classes.iter().map(|class| class.copies.len()).sum::<usize>();
            saved += saved_here;
            Some(pieces(mesh, &classes))
        })
        .collect();
    if copies == 0 {
        return None;
    }
    let about = format!(
        "{copies} parts of meshes are moved copies of others; as instances they save {saved} of {} triangles",
        world.triangles()
    );
    let (simpler, deviation) = replaced(world, &pieces)?;
    Some(in_place(NAME, about, simpler, Deviation::Rounding(deviation)))
}

/// The pieces of a mesh: what is not repeated, and the components of each class.
fn pieces(mesh: &Mesh, classes: &[Class]) -> Pieces {
    let (mut geometries, mut placed) = (Vec::new(), Vec::new());
    let components =
        classes.iter().flat_map(|class| class.copies.iter().map(|copy| &copy.component).chain([&class.first]));
    let rest = remaining(mesh, components.map(|component| &component.triangles[..]));
    if !rest.is_empty() {
        geometries.push(Geometry::Mesh(mesh.subset(&rest)));
        placed.push(Piece { geometry: 0, to_whole: DAffine3::IDENTITY, color: None });
    }
    for Class { first, copies } in classes {
        let geometry = geometries.len();
        geometries.push(Geometry::Mesh(mesh.subset(&first.triangles)));
        placed.push(Piece { geometry, to_whole: DAffine3::IDENTITY, color: None });
        placed.extend(copies.iter().map(|MovedCopy { component, moved_by, .. }| Piece {
            geometry,
            to_whole: DAffine3::from_translation(*moved_by),
            color: component.color,
        }));
    }
    let deviation = classes.iter().flat_map(|class| &class.copies).map(|copy| copy.deviation).fold(0.0, f64::max);
    Pieces { geometries, placed, deviation }
}

/// Components of one shape.
struct Class {
    first: Component,
    copies: Vec<MovedCopy>,
}

struct MovedCopy {
    component: Component,
    /// From the first component to this one.
    moved_by: DVec3,
    /// The greatest distance between two matched vertices.
    deviation: f64,
}

/// The classes with at least two components.
fn classes(mesh: &Mesh) -> Vec<Class> {
    let all = Components::of(mesh, MIN_TRIANGLES);
    if all.components.len() < 2 {
        return Vec::new();
    }
    let mut components: Vec<_> =
        all.components.par_iter().map(|component| Component::new(mesh, &all, component)).collect();
    let counts = |component: &Component| (component.triangles.len(), component.vertices.len());
    components.sort_by(|a, b| counts(a).cmp(&counts(b)).then(a.extent().x.total_cmp(&b.extent().x)));
    let (mut classes, mut first_open): (Vec<Class>, usize) = (Vec::new(), 0);
    for component in components {
        // No class before this one is as wide as the component, or as any that follows.
        while classes.get(first_open).is_some_and(|class| {
            let width = class.first.extent().x + 2.0 * class.first.tolerance.max(component.tolerance);
            counts(&class.first) != counts(&component) || width < component.extent().x
        }) {
            first_open += 1;
        }
        let same =
            classes[first_open..].iter_mut().find_map(|class| Some((class.first.matched(mesh, &component)?, class)));
        match same {
            Some(((moved_by, deviation), class)) => class.copies.push(MovedCopy { component, moved_by, deviation }),
            None => classes.push(Class { first: component, copies: Vec::new() }),
        }
    }
    classes.retain(|class| !class.copies.is_empty());
    classes
}

/// Triangles of a mesh that hang together.
struct Component {
    /// Their numbers, ascending.
    triangles: Vec<u32>,
    /// The vertices, each once, sorted by their place along [`ALONG`].
    vertices: Vec<DVec3>,
    /// For each triangle, its vertices as indices into `vertices`.
    corners: Vec<[u32; 3]>,
    /// The least corner of the box, and the greatest.
    bounds: [DVec3; 2],
    /// How far vertices of copies may be apart.
    tolerance: f64,
    /// If all triangles have the same.
    color: Option<Vec3>,
}

impl Component {
    fn new(mesh: &Mesh, all: &Components, component: &weld::Component) -> Self {
        let (positions, mut corners) = all.shape(mesh, component);
        let mut order: Vec<_> = (0..).zip(&positions).map(|(number, point)| (point.dot(ALONG), number)).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut places = vec![0; order.len()];
        for (place, &(_, number)) in (0..).zip(&order) {
            places[number as usize] = place;
        }
        for corner in corners.as_flattened_mut() {
            *corner = places[*corner as usize];
        }
        let vertices: Vec<_> = order.iter().map(|&(_, number): &(f64, u32)| positions[number as usize]).collect();
        let lo = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let hi = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let tolerance = lo.abs().max(hi.abs()).max_element() * TOLERANCE;
        let (triangles, color) = (component.triangles.clone(), only_color(mesh, &component.triangles));
        Self { triangles, vertices, corners, bounds: [lo, hi], tolerance, color }
    }

    fn extent(&self) -> DVec3 {
        self.bounds[1] - self.bounds[0]
    }

    /// How far the other component is from this one, if it is a copy, and how far vertices are apart at most.
    fn matched(&self, mesh: &Mesh, other: &Self) -> Option<(DVec3, f64)> {
        let tolerance = self.tolerance.max(other.tolerance);
        let differs = (self.extent() - other.extent()).abs().max_element() > 2.0 * tolerance;
        if differs || self.extent().length() < MIN_SIZE * tolerance {
            return None;
        }
        let moved_by = other.bounds[0] - self.bounds[0];
        let (mut matches, mut deviation): (Vec<u32>, f64) = (Vec::with_capacity(other.vertices.len()), 0.0);
        for vertex in &other.vertices {
            let wanted = *vertex - moved_by;
            let from = self.vertices.partition_point(|own| own.dot(ALONG) < wanted.dot(ALONG) - 2.0 * tolerance);
            let near =
                self.vertices[from..].iter().take_while(|own| own.dot(ALONG) <= wanted.dot(ALONG) + 2.0 * tolerance);
            let distances = near.enumerate().map(|(index, own)| (own.distance(wanted), from + index));
            let (distance, index) = distances.min_by(|a, b| a.0.total_cmp(&b.0))?;
            if distance > 2.0 * tolerance {
                return None;
            }
            matches.push(index as u32);
            deviation = deviation.max(distance);
        }
        let own = self.turned(|corner| corner);
        let others = other.turned(|corner| matches[corner as usize]);
        let are_equal =
            own.iter().zip(&others).all(|(a, b)| a.corners == b.corners && self.looks_same(mesh, other, a, b));
        are_equal.then_some((moved_by, deviation))
    }

    /// The triangles with the least corner first, sorted by their corners.
    fn turned(&self, corner: impl Fn(u32) -> u32) -> Vec<Turned> {
        let turned = |(index, corners): (usize, &[u32; 3])| {
            let mut corners = corners.map(&corner);
            let turn = (0..3).min_by_key(|&turn| corners[turn]).unwrap_or(0);
            corners.rotate_left(turn);
            Turned { corners, index, turn }
        };
        let mut triangles: Vec<_> = self.corners.iter().enumerate().map(turned).collect();
        triangles.sort_unstable_by_key(|triangle| (triangle.corners, triangle.index));
        triangles
    }

    /// Whether two triangles have the same colour, normals and texture coordinates. Components of one colour may have
    /// different colours, because their instances are painted.
    fn looks_same(&self, mesh: &Mesh, other: &Self, own: &Turned, others: &Turned) -> bool {
        let (a, b) = (self.triangles[own.index], other.triangles[others.index]);
        let is_painted = self.color.is_some() && other.color.is_some();
        (is_painted || mesh.color(a) == mesh.color(b))
            && own.rotated(mesh.normals(a)) == others.rotated(mesh.normals(b))
            && own.rotated(mesh.texture_coordinates(a)) == others.rotated(mesh.texture_coordinates(b))
    }
}

/// A triangle whose corners were rotated.
struct Turned {
    corners: [u32; 3],
    /// Number of the triangle in its component.
    index: usize,
    /// By how many corners.
    turn: usize,
}

impl Turned {
    /// The values at the rotated corners.
    fn rotated<T>(&self, values: Option<[T; 3]>) -> Option<[T; 3]> {
        values.map(|mut values| {
            values.rotate_left(self.turn);
            values
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3;

    use super::super::tests::{
        BLUE, IntoGeometry, RED, assert_similar_picture, built_in, mesh, moved, rotation, variants, with_values, world,
    };
    use super::*;
    use crate::tracer::Placement;

    /// A tree at each place, in a colour, and a sphere that is there once.
    fn trees(places: &[(Vec3, Option<Vec3>)]) -> Mesh {
        let (tree, sphere) = (tree(), mesh("sphere:1e3"));
        let at = |(place, color): &(Vec3, Option<Vec3>)| {
            let tree = moved(&tree, Affine3::from_translation(*place));
            color.map_or(tree.clone(), |color| tree.in_color(color))
        };
        let mut meshes: Vec<_> = places.iter().map(at).collect();
        meshes.insert(1, moved(&sphere, Affine3::from_translation(Vec3::new(0.5, 0.0, 3.0))));
        Mesh::joined(&meshes).unwrap()
    }

    /// That of the built-in forest: two colours.
    fn tree() -> Mesh {
        match &built_in("forest:1000").geometries()[1] {
            Geometry::Mesh(mesh) => mesh.clone(),
            other => panic!("{other:?}"),
        }
    }

    const PLACES: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.1, 0.0, 0.3), Vec3::new(-0.9, 0.2, 0.1), Vec3::new(0.1, -1.3, 1.0)];

    #[test]
    fn moved_copies_become_instances_in_their_colours() {
        for colors in [[None; 4], [RED, RED, BLUE, RED].map(Some)] {
            let places: Vec<_> = PLACES.into_iter().zip(colors).collect();
            for (variant, forest) in variants(&trees(&places)) {
                let transform = Affine3::from_scale(Vec3::new(1.0, 2.0, 1.0)) * rotation();
                let world = world(vec![(forest.clone().into_geometry(), transform)]);
                let simpler = find(&world).unwrap_or_else(|| panic!("{variant}"));
                let [rest, shared] = simpler.world.geometries() else { panic!("{variant}: {}", simpler.about) };
                assert_eq!(rest.primitives(), mesh("sphere:1e3").len(), "{variant}");
                assert_eq!(shared.primitives(), tree().len(), "{variant}");
                assert_eq!(simpler.world.instances().len(), 5, "{variant}");
                let deviation = simpler.deviation.distance();
                assert!(simpler.deviation.keeps_surface());
                assert!(deviation > 0.0 && deviation < 1e-4 * world.bounds().diagonal(), "{variant}: {deviation}");
                assert_similar_picture(&world, &simpler);
            }
        }
    }

    #[test]
    fn what_only_resembles_a_copy_stays() {
        let found = |mesh: Mesh| find(&world(vec![(mesh.into_geometry(), Affine3::IDENTITY)])).is_some();
        let beside = |transform: Affine3| {
            let other = moved(&tree(), Affine3::from_translation(Vec3::X * 2.0) * transform);
            Mesh::joined(&[tree(), other]).unwrap()
        };
        let both = beside(Affine3::IDENTITY);
        assert!(found(both.clone()));
        let mut triangles = both.triangles().to_vec();
        triangles[both.len() / 2..].iter_mut().for_each(|corners| corners.rotate_left(1));
        assert!(found(Mesh::new(both.positions().to_vec(), triangles, both.parts().to_vec()).unwrap()));
        assert!(!found(beside(Affine3::from_scale(Vec3::splat(1.001)))));
        assert!(!found(beside(Affine3::from_scale(Vec3::new(-1.0, 1.0, 1.0)))));
        assert!(!found(beside(rotation())));
        // One vertex is elsewhere; two triangles join other vertices; colours are exchanged; normals differ.
        let last = both.positions().len() - 40;
        for elsewhere in [ALONG, ALONG.cross(DVec3::X)] {
            let mut positions = both.positions().to_vec();
            positions[last] += (elsewhere * 1e-4).as_vec3();
            assert!(!found(Mesh::new(positions, both.triangles().to_vec(), both.parts().to_vec()).unwrap()));
        }
        let mut triangles = both.triangles().to_vec();
        triangles[both.len() - 7].swap(0, 1);
        assert!(!found(Mesh::new(both.positions().to_vec(), triangles, both.parts().to_vec()).unwrap()));
        let mut parts = both.parts().to_vec();
        parts[3].color = parts[2].color;
        parts[2].color = RED;
        assert!(!found(Mesh::new(both.positions().to_vec(), both.triangles().to_vec(), parts).unwrap()));
        assert!(!found(with_values(both)));
        let same = with_values(tree());
        let shifted = moved(&same, Affine3::from_translation(Vec3::X * 2.0));
        assert!(found(Mesh::joined(&[same, shifted]).unwrap()));
    }

    #[test]
    fn sharing_must_be_worth_it() {
        let forest = trees(&PLACES.map(|place| (place, None)));
        let shown = |instances: Vec<Placement>| {
            find(&World::new(vec![forest.clone().into_geometry()], instances).unwrap()).is_some()
        };
        let instance = |x: f32| Placement::new(0, Affine3::from_translation(Vec3::X * x));
        assert!(shown(vec![instance(0.0)]));
        assert!(!shown(vec![instance(0.0), instance(9.0)]), "its instances share it already");
        // Two trees beside a terrain of many more triangles.
        let few = [tree(), moved(&tree(), Affine3::from_translation(Vec3::X)), mesh("terrain:1e5")];
        assert!(find(&Mesh::joined(&few).unwrap().into()).is_none());
        assert!(find(&built_in("terrain:1e3")).is_none());
    }
}
