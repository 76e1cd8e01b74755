//! Triangles of exactly zero area: no ray hits them, so they are dropped.

use rayon::prelude::*;

use super::{Deviation, SimplerModel, in_place};
use crate::tracer::{Geometry, World, has_zero_area};

pub(super) const NAME: &str = "drop degenerate triangles";

/// Drops triangles of zero area. A mesh keeps its first triangle if it has no others.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let mut dropped = 0;
    let geometries = world.geometries().iter().map(|geometry| {
        let Geometry::Mesh(mesh) = geometry else { return geometry.clone() };
        let mut kept: Vec<u32> =
            (0..mesh.len() as u32).into_par_iter().filter(|&number| !has_zero_area(&mesh.triangle(number))).collect();
        if kept.is_empty() {
            kept.push(0);
        }
        if kept.len() == mesh.len() {
            return geometry.clone();
        }
        dropped += mesh.len() - kept.len();
        Geometry::Mesh(mesh.subset(&kept))
    });
    let geometries = geometries.collect();
    if dropped == 0 {
        return None;
    }
    let about = format!(
        "{dropped} of {} triangles have zero area and are dropped, so later triangles change their numbers",
        world.triangles()
    );
    let simpler = World::new(geometries, world.instances().to_vec()).expect("less of a valid world");
    Some(in_place(NAME, about, simpler, Deviation::None))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::tests::{BLUE, RED, assert_same_picture, built_in, mesh, variants, with_values};
    use super::*;
    use crate::tracer::{Mesh, Part};

    #[test]
    fn triangles_without_area_go_and_the_others_keep_their_looks() {
        let sphere = mesh("sphere:1e3");
        for (variant, sphere) in variants(&sphere) {
            // After every tenth triangle one of two vertices, and one of a vertex alone.
            let with_flaws = |(number, &[a, b, c]): (usize, &[u32; 3])| {
                let flaws = if number % 10 == 0 { &[[b, a, a], [c; 3]][..] } else { &[] };
                [[a, b, c]].into_iter().chain(flaws.iter().copied()).collect::<Vec<_>>()
            };
            let triangles: Vec<_> = sphere.triangles().iter().enumerate().flat_map(with_flaws).collect();
            let parts = [(0, RED), (1, BLUE), (700, RED)].map(|(first_triangle, color)| Part { first_triangle, color });
            let flawed = Mesh::new(sphere.positions().to_vec(), triangles, parts.to_vec()).unwrap();
            let world = World::from(with_values(flawed));
            let simpler = find(&world).unwrap();
            assert_eq!(simpler.world.triangles(), sphere.len(), "{variant}: {}", simpler.about);
            assert_same_picture(&world, &simpler);
        }
    }

    #[test]
    fn a_mesh_is_never_empty_and_a_clean_one_stays() {
        let line = [Vec3::ZERO, Vec3::ONE, Vec3::ONE * 3.0];
        let flat = Mesh::new(line.to_vec(), vec![[0, 1, 2], [2, 1, 0]], mesh("sphere:1e3").parts().to_vec()).unwrap();
        assert_eq!(find(&flat.into()).unwrap().world.triangles(), 1);
        assert!(find(&built_in("terrain:1e3")).is_none());
    }
}
