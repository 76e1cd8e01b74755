//! Meshes that are equal to an earlier one: their instances show that one.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::pieces::without_unused;
use super::{Deviation, SimplerModel, in_place};
use crate::tracer::{Geometry, Mesh, World};

pub(super) const NAME: &str = "share equal meshes";

/// Lets instances of meshes that are equal bit for bit share one.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let mut seen: HashMap<u64, Vec<u32>> = HashMap::new();
    let mut saved = 0;
    let first_equal = |(number, geometry): (u32, &Geometry)| {
        let Geometry::Mesh(mesh) = geometry else { return number };
        let same_hash = seen.entry(hash(mesh)).or_default();
        // Of positions, `==` alone would take -0 for 0; of everything else that makes no difference to a picture.
        let equal = same_hash.iter().find(|&&other| world.geometries()[other as usize] == *geometry);
        if let Some(&first) = equal {
            saved += mesh.len();
            return first;
        }
        same_hash.push(number);
        number
    };
    let firsts: Vec<u32> = (0..).zip(world.geometries()).map(first_equal).collect();
    let repeated = (0..).zip(&firsts).filter(|&(number, &first)| number != first).count();
    if repeated == 0 {
        return None;
    }
    let mut instances = world.instances().to_vec();
    for placement in &mut instances {
        placement.geometry = firsts[placement.geometry as usize];
    }
    let about = format!(
        "{repeated} of {} geometries are equal to an earlier one; instances share it, which saves {saved} triangles",
        world.geometries().len()
    );
    Some(in_place(NAME, about, without_unused(world.geometries().to_vec(), instances)?, Deviation::None))
}

/// Over the bits of the vertices, and the triangles.
fn hash(mesh: &Mesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    for position in mesh.positions() {
        position.to_array().map(f32::to_bits).hash(&mut hasher);
    }
    mesh.triangles().hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use glam::{Affine3, Vec3};

    use super::super::tests::{
        BLUE, IntoGeometry, assert_same_picture, built_in, mesh, moved, variants, with_values, world,
    };
    use super::*;

    #[test]
    fn equal_meshes_become_one() {
        for (variant, mesh) in variants(&with_values(mesh("sphere:1e3"))) {
            let shift = mesh.bounds().extent() * Vec3::new(1.0, 0.5, 0.0);
            let at = |step: f32| Affine3::from_translation(shift * step);
            let mut bent = mesh.positions().to_vec();
            bent[7].x = bent[7].x.next_up();
            let bent = Mesh::new(bent, mesh.triangles().to_vec(), mesh.parts().to_vec()).unwrap();
            let other = [bent.into_geometry(), mesh.clone().in_color(BLUE).into_geometry()];
            let [bent, blue] = other;
            let world = world(vec![
                (mesh.clone().into_geometry(), at(0.0)),
                (bent, at(1.0)),
                (mesh.clone().into_geometry(), at(2.0)),
                (blue, at(3.0)),
                (mesh.into_geometry(), at(-1.0)),
            ]);
            let simpler = find(&world).unwrap();
            let shown: Vec<_> = simpler.world.instances().iter().map(|placement| placement.geometry).collect();
            assert_eq!(shown, [0, 1, 0, 2, 0], "{variant}");
            assert_same_picture(&world, &simpler);
        }
    }

    #[test]
    fn different_meshes_stay() {
        let sphere = mesh("sphere:1e3");
        let larger = moved(&sphere, Affine3::from_scale(Vec3::splat(2.0)));
        let at = |x| Affine3::from_translation(Vec3::X * x);
        assert!(find(&world(vec![(sphere.into_geometry(), at(0.0)), (larger.into_geometry(), at(4.0))])).is_none());
        assert!(find(&built_in("forest:1000")).is_none());
    }
}
