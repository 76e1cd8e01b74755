//! Worlds in which a geometry is replaced by several pieces, and each of its instances by instances of these.

use glam::{BVec3, DAffine3, Vec3};

use super::symmetric::eigen;
use crate::geom::Aabb;
use crate::tracer::{Geometry, Paint, Placement, World};

/// What a geometry is replaced by.
pub(super) struct Pieces {
    pub(super) geometries: Vec<Geometry>,
    pub(super) placed: Vec<Piece>,
    /// The greatest distance between the surfaces, in the coordinates of the geometry.
    pub(super) deviation: f64,
}

/// A piece of a geometry.
pub(super) struct Piece {
    /// Number among the pieces' geometries.
    pub(super) geometry: usize,
    /// From the piece's coordinates to those of the whole.
    pub(super) to_whole: DAffine3,
    /// Its colour, where the instance shows the geometry's own colours.
    pub(super) color: Option<Vec3>,
}

/// The world with the pieces of each geometry that has some, and the greatest distance between the surfaces. Both
/// the deviation of the pieces and the rounding of their transforms count. `None` if the world would not be valid, for
/// example because a transform has no inverse after rounding.
pub(super) fn replaced(world: &World, pieces: &[Option<Pieces>]) -> Option<(World, f64)> {
    let (mut geometries, mut firsts) = (Vec::new(), Vec::new());
    for (geometry, pieces) in world.geometries().iter().zip(pieces) {
        firsts.push(geometries.len());
        match pieces {
            Some(pieces) => geometries.extend(pieces.geometries.iter().cloned()),
            None => geometries.push(geometry.clone()),
        }
    }
    let bounds: Vec<_> = geometries.iter().map(Geometry::bounds).collect();
    let (mut instances, mut deviation) = (Vec::new(), 0.0);
    for placement in world.instances() {
        let (number, first) = (placement.geometry as usize, firsts[placement.geometry as usize]);
        let Some(pieces) = &pieces[number] else {
            instances.push(Placement { geometry: first as u32, ..*placement });
            continue;
        };
        let to_world = placement.object_to_world.as_daffine3();
        let approximation = pieces.deviation * stretch(&to_world);
        for piece in &pieces.placed {
            let exact = to_world * piece.to_whole;
            let geometry = first + piece.geometry;
            let object_to_world = exact.as_affine3();
            let rounding = distance(&exact, &object_to_world.as_daffine3(), &bounds[geometry]);
            deviation = f64::max(deviation, approximation + rounding);
            let paint = match (placement.paint, piece.color) {
                (Paint::Own, Some(color)) => Paint::Plain(color),
                (paint, _) => paint,
            };
            instances.push(Placement { geometry: geometry as u32, object_to_world, paint, ..*placement });
        }
    }
    Some((World::new(geometries, instances).ok()?, deviation))
}

/// The greatest distance between the images of a point of the box under both transforms.
fn distance(a: &DAffine3, b: &DAffine3, bounds: &Aabb) -> f64 {
    let difference = DAffine3 { matrix3: a.matrix3 - b.matrix3, translation: a.translation - b.translation };
    let corner = |number: u32| {
        let is_high = BVec3::new(number & 1 != 0, number & 2 != 0, number & 4 != 0);
        difference.transform_point3(Vec3::select(is_high, bounds.hi, bounds.lo).as_dvec3()).length()
    };
    (0..8).map(corner).fold(0.0, f64::max)
}

/// How many times as long the transform makes a vector at most.
fn stretch(transform: &DAffine3) -> f64 {
    let squared = (transform.matrix3.transpose() * transform.matrix3).to_cols_array_2d();
    eigen(squared).into_iter().fold(0.0, |most: f64, (value, _)| most.max(value)).sqrt()
}

/// The world of these instances and the geometries that they show. `None` if it is not valid.
pub(super) fn without_unused(geometries: Vec<Geometry>, mut instances: Vec<Placement>) -> Option<World> {
    let mut is_used = vec![false; geometries.len()];
    for placement in &instances {
        is_used[placement.geometry as usize] = true;
    }
    let mut next = 0;
    let numbers: Vec<u32> = is_used.iter().map(|&used| (next, next += u32::from(used)).0).collect();
    for placement in &mut instances {
        placement.geometry = numbers[placement.geometry as usize];
    }
    let used = geometries.into_iter().zip(is_used).filter(|(_, used)| *used).map(|(geometry, _)| geometry);
    World::new(used.collect(), instances).ok()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::tests::mesh;
    use super::*;

    #[test]
    fn the_rounding_of_transforms_counts() {
        let mesh = Geometry::Mesh(mesh("sphere:1e3"));
        let to_whole = DAffine3::from_translation(DVec3::X * 0.1);
        let placed = vec![Piece { geometry: 0, to_whole, color: None }];
        let world = World::new(vec![mesh.clone()], vec![Placement::new(0, glam::Affine3::IDENTITY)]).unwrap();
        let (_, deviation) =
            replaced(&world, &[Some(Pieces { geometries: vec![mesh], placed, deviation: 0.0 })]).unwrap();
        let rounding = (f64::from(0.1_f32) - 0.1).abs();
        assert!((deviation - rounding).abs() < 1e-3 * rounding, "{deviation}");
    }
}
