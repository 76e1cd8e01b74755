//! A world far from the origin: everything is moved there, by a vector for which no coordinate is rounded.
//!
//! Far away, `f32` numbers are far apart, and kernels that multiply positions lose digits. Differences of positions are
//! the same near the origin. So the surface is exactly the same, and less is rounded.

use glam::{Affine3, Vec3};

use super::{Deviation, SimplerModel};
use crate::tracer::{Geometry, Placement, World, two_sum};

pub(super) const NAME: &str = "move to the origin";

/// How many diagonals of the world's box away from 0 counts as far.
const FAR: f64 = 100.0;

/// Moves the world to the origin if it is far away and every coordinate can be moved without rounding.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let bounds = world.bounds();
    let (center, diagonal) = (bounds.center(), bounds.diagonal());
    if center.as_dvec3().length() <= FAR * diagonal {
        return None;
    }
    // Whole steps of a power of two make a short vector, and then rays too can often be moved without rounding. Near 0,
    // coordinates are finer than what the vector could leave of them. There it is 0.
    let step = diagonal.max(f64::from(f32::MIN_POSITIVE)).log2().ceil().exp2();
    let by = center.to_array().map(f64::from).map(|coordinate| {
        if coordinate.abs() <= FAR / 2.0 * diagonal { 0.0 } else { ((coordinate / step).round() * step) as f32 }
    });
    let moved = Moved { by: Vec3::from_array(by) };

    let mut is_placed_directly = vec![true; world.geometries().len()];
    for placement in world.instances() {
        is_placed_directly[placement.geometry as usize] &= placement.object_to_world == Affine3::IDENTITY;
    }
    let geometry = |(geometry, is_placed_directly): (&Geometry, &bool)| match geometry {
        Geometry::Mesh(mesh) if *is_placed_directly => {
            let exact = mesh.positions().iter().all(|&position| moved.point(position).is_some());
            let moved = mesh.mapped(|position| moved.point(position).unwrap_or(Vec3::NAN), |normal| normal);
            exact.then_some(moved.ok()?).map(Geometry::Mesh)
        }
        other => Some(other.clone()),
    };
    let geometries = world.geometries().iter().zip(&is_placed_directly).map(geometry).collect::<Option<Vec<_>>>()?;
    let instance = |placement: &Placement| {
        let mut placement = *placement;
        let number = placement.geometry as usize;
        if !(is_placed_directly[number] && matches!(world.geometries()[number], Geometry::Mesh(_))) {
            placement.object_to_world.translation = moved.point(placement.object_to_world.translation)?;
        }
        Some(placement)
    };
    let instances = world.instances().iter().map(instance).collect::<Option<Vec<_>>>()?;
    let world = World::new(geometries, instances).ok()?;
    let about = format!(
        "the world is {:.0} times its diagonal away from the origin; it is moved by {}, and no coordinate is rounded",
        center.as_dvec3().length() / diagonal,
        -moved.by
    );
    Some(SimplerModel { name: NAME, about, world, moved_by: -moved.by, deviation: Deviation::None })
}

/// The move of the world.
struct Moved {
    /// What is subtracted.
    by: Vec3,
}

impl Moved {
    /// The moved point, if nothing is rounded.
    fn point(&self, point: Vec3) -> Option<Vec3> {
        let moved = point - self.by;
        let is_exact = (0..3).all(|axis| {
            let (difference, lost) = two_sum(point[axis].into(), -f64::from(self.by[axis]));
            lost == 0.0 && difference == f64::from(moved[axis])
        });
        is_exact.then_some(moved)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{IntoGeometry, assert_same_picture, built_in, mesh, moved, rotation, variants, world};
    use super::*;
    use crate::geom::Quadric;

    fn far(distance: f32) -> Affine3 {
        Affine3::from_translation(Vec3::new(-distance, 0.0, distance * 0.75))
    }

    #[test]
    fn a_far_world_is_moved_without_rounding() {
        for (variant, terrain) in variants(&mesh("terrain:1e3")) {
            let terrain = moved(&terrain, Affine3::from_translation(-terrain.bounds().center()));
            let distance = terrain.bounds().diagonal() as f32 * 3000.0;
            let instance = Affine3 { translation: terrain.bounds().extent() * 2.0, ..rotation() };
            let rotated = Affine3 { translation: (far(distance) * instance).translation, ..instance };
            let size = terrain.bounds().diagonal() as f32;
            let ball = Affine3::from_translation((far(distance).translation / size).round() * size);
            let world = world(vec![
                (moved(&terrain, far(distance)).into_geometry(), Affine3::IDENTITY),
                (terrain.into_geometry(), rotated),
                (Quadric::sphere(size * 0.2).into(), ball),
            ]);
            let simpler = find(&world).unwrap_or_else(|| panic!("{variant}"));
            let bounds = simpler.world.bounds();
            assert!(f64::from(bounds.center().length()) <= 2.0 * bounds.diagonal(), "{variant}: {bounds:?}");
            assert!(simpler.moved_by.x > 0.0 && simpler.moved_by.z < 0.0, "{variant}: {}", simpler.moved_by);
            assert_same_picture(&world, &simpler);
        }
    }

    #[test]
    fn a_world_that_is_near_or_would_be_rounded_stays() {
        assert!(find(&built_in("terrain:1e3")).is_none());
        let terrain = mesh("terrain:1e3");
        assert!(find(&world(vec![(moved(&terrain, far(8000.0)).into_geometry(), Affine3::IDENTITY)])).is_none());
        // The mesh is far away in its own coordinates, and the translation is too small to take that back.
        let distant = moved(&terrain, far(1e6));
        let small = Affine3 { translation: Vec3::new(0.1, 0.0, 0.0), ..rotation() };
        assert!(find(&world(vec![(distant.into_geometry(), small)])).is_none());
    }
}
