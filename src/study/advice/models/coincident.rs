//! Triangles with the same three vertices, and instances that show the same in the same place: one of each is kept.
//!
//! The kept one has the lower number. The box rule reports it between equal `t`, so where all have their vertices in
//! the same order, no hit changes. In another order, or turned around, kernels may round `t` differently. Then a
//! picture was a mixture of all of them. Now it shows the first.

use std::collections::HashSet;

use rayon::prelude::*;

use super::weld::welded;
use super::{Deviation, SimplerModel, in_place};
use crate::tracer::{Geometry, Mesh, Placement, World};

pub(super) const NAME: &str = "merge coincident triangles";

/// Keeps of coincident triangles, and of equal instances, the first.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let (mut merged, mut turned) = (0, 0);
    let geometries = world.geometries().iter().map(|geometry| {
        let Geometry::Mesh(mesh) = geometry else { return geometry.clone() };
        let (kept, opposite) = distinct(mesh);
        if kept.len() == mesh.len() {
            return geometry.clone();
        }
        merged += mesh.len() - kept.len();
        turned += opposite;
        Geometry::Mesh(mesh.subset(&kept))
    });
    let geometries = geometries.collect();
    let mut seen = HashSet::new();
    let is_first = |placement: &&Placement| {
        let transform = placement.object_to_world.to_cols_array().map(f32::to_bits);
        seen.insert((placement.geometry, transform, placement.mask))
    };
    let instances: Vec<_> = world.instances().iter().filter(is_first).copied().collect();
    let repeated = world.instances().len() - instances.len();
    let mut found = Vec::new();
    if merged > 0 {
        let facing = if turned > 0 { format!(", {turned} of them facing the other way") } else { String::new() };
        found.push(format!(
            "{merged} of {} triangles have the vertices of an earlier one{facing}; the first of each is kept, \
             so later triangles change their numbers",
            world.triangles()
        ));
    }
    if repeated > 0 {
        found
            .push(format!("{repeated} of {} instances repeat an earlier one and are dropped", world.instances().len()));
    }
    if found.is_empty() {
        return None;
    }
    let simpler = World::new(geometries, instances).expect("less of a valid world");
    Some(in_place(NAME, found.join("; "), simpler, Deviation::None))
}

/// The triangles that do not have the same vertices as an earlier one, and how many of the others are opposite to it.
fn distinct(mesh: &Mesh) -> (Vec<u32>, usize) {
    let welded = welded(mesh);
    let key = |(number, triangle): (usize, &[u32; 3])| {
        let mut vertices = triangle.map(|index| welded[index as usize]);
        // An odd permutation sorts the vertices of one orientation, an even one those of the other.
        let [a, b, c] = vertices;
        let is_odd = (a > b) ^ (b > c) ^ (a > c);
        vertices.sort_unstable();
        (vertices, number as u32, is_odd)
    };
    let mut order: Vec<_> = mesh.triangles().par_iter().enumerate().map(key).collect();
    order.par_sort_unstable();
    let mut opposite = 0;
    let mut kept: Vec<u32> = order
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| {
            opposite += same.iter().filter(|other| other.2 != same[0].2).count();
            same[0].1
        })
        .collect();
    kept.par_sort_unstable();
    (kept, opposite)
}

#[cfg(test)]
mod tests {
    use glam::{Affine3, Vec3};

    use super::super::tests::{BLUE, RED, assert_same_picture, built_in, mesh, rays, seen, variants, with_values};
    use super::*;
    use crate::tracer::Part;

    /// The mesh in red, and behind it in blue every third triangle again, as `repeat` makes it of the vertices. The
    /// vertices are new ones at the same positions. Every corner has its own normal and texture coordinates.
    fn repeated(mesh: &Mesh, repeat: impl Fn(u32, [u32; 3]) -> [u32; 3]) -> World {
        let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
        for (number, corners) in (0..).zip(mesh.triangles()).step_by(3) {
            let first = positions.len() as u32;
            positions.extend(corners.map(|index| mesh.positions()[index as usize]));
            triangles.push(repeat(number / 3, [first, first + 1, first + 2]));
        }
        let parts = [(0, RED), (mesh.len() as u32, BLUE)];
        let parts = parts.map(|(first_triangle, color)| Part { first_triangle, color });
        with_values(Mesh::new(positions, triangles, parts.to_vec()).unwrap()).into()
    }

    #[test]
    fn triangles_that_are_there_twice_become_one_and_no_hit_changes() {
        for (variant, sphere) in variants(&mesh("sphere:1e3")) {
            let world = repeated(&sphere, |_, corners| corners);
            let simpler = find(&world).unwrap();
            assert_eq!(simpler.world.triangles(), sphere.len(), "{variant}");
            assert!(!simpler.about.contains("facing"), "{variant}: {}", simpler.about);
            assert_same_picture(&world, &simpler);
        }
    }

    #[test]
    fn triangles_from_another_corner_or_turned_around_are_the_same() {
        for (variant, sphere) in variants(&mesh("sphere:1e3")) {
            let world = repeated(&sphere, |number, [a, b, c]| [[b, c, a], [c, a, b], [a, c, b]][number as usize % 3]);
            let repeated = world.triangles() - sphere.len();
            let simpler = find(&world).unwrap();
            let about = format!(
                "{repeated} of {} triangles have the vertices of an earlier one, {} of them facing the other way",
                world.triangles(),
                repeated / 3
            );
            assert!(simpler.about.starts_with(&about), "{variant}: {}", simpler.about);
            let kept = with_values(sphere.in_color(RED)).into();
            assert_eq!(seen(&simpler.world, &rays(&world)), seen(&kept, &rays(&world)), "{variant}");
        }
    }

    #[test]
    fn zero_and_its_negative_are_the_same_coordinate() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::ZERO, Vec3::Y * 2.0];
        let parts = vec![Part { first_triangle: 0, color: RED }];
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [1, 2, 3], [0, 1, 4]], parts).unwrap();
        assert_eq!(find(&mesh.into()).unwrap().world.triangles(), 2);
    }

    #[test]
    fn equal_instances_go_unless_other_rays_see_them() {
        let at = |x| Placement::new(0, Affine3::from_translation(Vec3::X * x));
        let instances = vec![at(0.0), at(1.0), at(0.0), at(1.0).with_mask(2), at(1.0)];
        let world = World::new(vec![Geometry::Mesh(mesh("sphere:1e3"))], instances).unwrap();
        let simpler = find(&world).unwrap();
        assert_eq!(simpler.world.instances(), [at(0.0), at(1.0), at(1.0).with_mask(2)]);
        assert_same_picture(&world, &simpler);
        assert!(find(&simpler.world).is_none());
    }

    #[test]
    fn triangles_that_share_two_vertices_stay() {
        assert!(find(&built_in("terrain:1e3")).is_none());
    }
}
