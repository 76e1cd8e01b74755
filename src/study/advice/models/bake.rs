//! Instances of meshes that become part of one untransformed mesh.
//!
//! Rays then need no transform, and pass one tree instead of two levels. A mesh that has one instance can always be
//! baked. A mesh with several is copied for each of them, so it is baked only if the triangles remain few.
//!
//! Not baked are instances in a checker pattern: other instances do not have that pattern. Neither are small ones far
//! from the origin, where rounding their vertices would change their shape. These are the ones that a transform serves.

use glam::{Affine3, DMat3, DVec3, Vec3};

use super::pieces::without_unused;
use super::{Deviation, SimplerModel, in_place};
use crate::tracer::{Geometry, Mesh, Paint, Placement, World};

pub(super) const NAME: &str = "bake instances";

/// Meshes with several instances are baked if the triangles become at most this many times those that are stored.
const MAX_GROWTH: usize = 2;
/// And at most this many.
const MAX_TRIANGLES: usize = 1_000_000;
/// A vertex may be rounded by this fraction of its mesh's diagonal at most.
const MAX_ROUNDING: f64 = 1e-5;

/// Bakes instances into one mesh for each mask that they have.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let meshes: Vec<Option<&Mesh>> = world
        .geometries()
        .iter()
        .map(|geometry| if let Geometry::Mesh(mesh) = geometry { Some(mesh) } else { None })
        .collect();
    let mut uses = vec![0usize; meshes.len()];
    for placement in world.instances() {
        uses[placement.geometry as usize] += 1;
    }
    let shown = uses.iter().zip(&meshes).filter_map(|(&uses, mesh)| Some((uses, (*mesh)?.len())));
    let baked_triangles: usize = shown.map(|(uses, triangles)| uses * triangles).sum();
    let copies = baked_triangles <= MAX_TRIANGLES.min(MAX_GROWTH * world.triangles());
    let mesh_to_bake = |placement: &Placement| {
        let number = placement.geometry as usize;
        let may_bake = !matches!(placement.paint, Paint::Checker(_)) && (copies || uses[number] == 1);
        meshes[number].filter(|_| may_bake)
    };

    let mut groups: Vec<Group> = Vec::new();
    let (mut geometries, mut instances) = (world.geometries().to_vec(), Vec::new());
    let mut rounding: f64 = 0.0;
    for placement in world.instances() {
        let Some((mesh, rounded)) = mesh_to_bake(placement).and_then(|mesh| baked(mesh, placement)) else {
            instances.push(*placement);
            continue;
        };
        rounding = rounding.max(rounded);
        let is_transformed = placement.object_to_world != Affine3::IDENTITY;
        match groups.iter_mut().find(|group| group.mask == placement.mask) {
            Some(group) => {
                group.meshes.push(mesh);
                group.transformed += usize::from(is_transformed);
            }
            None => {
                let transformed = usize::from(is_transformed);
                groups.push(Group { mask: placement.mask, meshes: vec![mesh], transformed });
            }
        }
    }
    // One untransformed mesh is what baking would make of it.
    let transformed: usize = groups.iter().map(|group| group.transformed).sum();
    let baked: usize = groups.iter().map(|group| group.meshes.len()).sum();
    if baked == groups.len() && transformed == 0 {
        return None;
    }
    let made = groups.len();
    for Group { mask, meshes, .. } in groups {
        instances.push(Placement::new(geometries.len() as u32, Affine3::IDENTITY).with_mask(mask));
        geometries.push(Geometry::Mesh(Mesh::joined(&meshes).ok()?));
    }
    let simpler = without_unused(geometries, instances)?;
    let about = format!(
        "{baked} of {} instances, {transformed} of them transformed, become {made} untransformed {} of {} triangles",
        world.instances().len(),
        if made == 1 { "mesh" } else { "meshes" },
        simpler.triangles(),
    );
    let deviation = if rounding > 0.0 { Deviation::Rounding(rounding) } else { Deviation::None };
    Some(in_place(NAME, about, simpler, deviation))
}

/// Instances that become one mesh.
struct Group {
    mask: u32,
    /// In the world, in the colours of the instances.
    meshes: Vec<Mesh>,
    /// How many were transformed.
    transformed: usize,
}

/// The mesh in the world, and how far its vertices were rounded at most. `None` if that is too far.
fn baked(mesh: &Mesh, placement: &Placement) -> Option<(Mesh, f64)> {
    let colored = |mesh: Mesh| match placement.paint {
        Paint::Plain(color) => mesh.in_color(color),
        _ => mesh,
    };
    // Even a product with 1 can change a vertex: it turns -0 + 0 into 0.
    if placement.object_to_world == Affine3::IDENTITY {
        return Some((colored(mesh.clone()), 0.0));
    }
    let to_world = placement.object_to_world.as_daffine3();
    let exact = |position: Vec3| to_world.transform_point3(position.as_dvec3());
    let to_normals = normals_to_world(to_world.matrix3);
    let in_world =
        mesh.mapped(|position| exact(position).as_vec3(), |normal| (to_normals * normal.as_dvec3()).as_vec3()).ok()?;
    let moved = mesh.positions().iter().zip(in_world.positions());
    let rounding = moved.map(|(&from, to)| exact(from).distance(to.as_dvec3())).fold(0.0, f64::max);
    (rounding <= MAX_ROUNDING * in_world.bounds().diagonal()).then_some((colored(in_world), rounding))
}

/// The inverse transpose, scaled so that normals keep about their length.
fn normals_to_world(linear: DMat3) -> DMat3 {
    let normals = linear.inverse().transpose();
    let largest = normals.to_cols_array().into_iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    DMat3::from_diagonal(DVec3::splat(1.0 / largest)) * normals
}

#[cfg(test)]
mod tests {
    use super::super::tests::{
        BLUE, IntoGeometry, RED, assert_same_picture, assert_similar_picture, built_in, mesh, moved, rotation,
        variants, with_values, world,
    };
    use super::*;
    use crate::tracer::Checker;

    fn at(x: f32) -> Affine3 {
        Affine3::from_translation(Vec3::X * x)
    }

    #[test]
    fn a_transformed_mesh_is_baked_with_rounded_vertices() {
        for (variant, sphere) in variants(&mesh("sphere:1e3")) {
            let mut transform = rotation() * Affine3::from_scale(Vec3::new(1.0, -2.0, 0.5));
            transform.translation = sphere.bounds().extent();
            let world = world(vec![(with_values(sphere.clone()).into_geometry(), transform)]);
            let simpler = find(&world).unwrap_or_else(|| panic!("{variant}"));
            let [Geometry::Mesh(baked)] = simpler.world.geometries() else { panic!("{variant}") };
            let exact = |point: &Vec3| transform.as_daffine3().transform_point3(point.as_dvec3());
            let worst =
                sphere.positions().iter().zip(baked.positions()).map(|(from, to)| exact(from).distance(to.as_dvec3()));
            let worst = worst.fold(0.0, f64::max);
            assert_eq!(simpler.deviation, Deviation::Rounding(worst), "{variant}");
            assert!(worst > 0.0 && worst <= 1e-5 * world.bounds().diagonal(), "{variant}");
            assert_eq!(simpler.world.instances(), [Placement::new(0, Affine3::IDENTITY)], "{variant}");
            assert_similar_picture(&world, &simpler);
        }
    }

    #[test]
    fn shading_normals_are_baked_too() {
        let stretched = rotation() * Affine3::from_scale(Vec3::new(1.0, 3.0, 1.0));
        let world = world(vec![(with_values(mesh("sphere:1e3")).into_geometry(), stretched)]);
        let simpler = find(&world).unwrap();
        let [Geometry::Mesh(before)] = world.geometries() else { panic!() };
        let [Geometry::Mesh(after)] = simpler.world.geometries() else { panic!() };
        let expected = normals_to_world(stretched.matrix3.as_dmat3());
        for triangle in 0..before.len() as u32 {
            let (before, after) = (before.normals(triangle).unwrap(), after.normals(triangle).unwrap());
            for (before, after) in before.into_iter().zip(after) {
                let normal = (expected * before.as_dvec3()).normalize().as_vec3();
                assert!(normal.abs_diff_eq(after.normalize(), 1e-6), "{normal} {after}");
            }
            // A normal stays at right angles to what was at right angles to it.
            let (normal, tangent) = (before[0].as_dvec3(), before[0].any_orthogonal_vector());
            let tangent = stretched.transform_vector3(tangent).as_dvec3();
            assert!((expected * normal).dot(tangent).abs() < 1e-6);
        }
    }

    #[test]
    fn untransformed_meshes_become_one_for_each_mask_in_the_colours_of_their_instances() {
        let [sphere, room] = ["sphere:1e3", "room:1e3"].map(mesh);
        let meshes = [0.0, 1.5, 3.0].map(|x| with_values(moved(&sphere, at(x))).into_geometry());
        let geometries = [&meshes[..], &[moved(&room, at(12.0)).into_geometry(), meshes[0].clone()]].concat();
        let paints = [Paint::Own, Paint::Plain(RED), Paint::Plain(BLUE), Paint::Own, Paint::Own];
        let placement = |(number, paint)| Placement::new(number, Affine3::IDENTITY).with_paint(paint);
        let mut instances: Vec<_> = (0..).zip(paints).map(placement).collect();
        let world = World::new(geometries.clone(), instances.clone()).unwrap();
        let simpler = find(&world).unwrap();
        let [Geometry::Mesh(joined)] = simpler.world.geometries() else { panic!("{}", simpler.about) };
        assert_eq!(joined.len(), world.triangles());
        let colors = [0, 1, 2].map(|number| joined.color(number * sphere.len() as u32));
        assert_eq!(colors, [sphere.color(0), RED, BLUE]);
        assert_same_picture(&world, &simpler);

        instances[1].mask = 2;
        instances[4].mask = 2;
        let masked = find(&World::new(geometries, instances).unwrap()).unwrap();
        let masks: Vec<_> = masked.world.instances().iter().map(|placement| placement.mask).collect();
        assert_eq!(masks, [u32::MAX, 2]);
    }

    #[test]
    fn what_instances_are_good_for_is_not_baked() {
        let sphere = mesh("sphere:1e3");
        let checker = Checker { colors: [RED, BLUE], uv_to_squares: glam::Affine2::IDENTITY };
        let placed =
            |instances: Vec<Placement>| find(&World::new(vec![sphere.clone().into_geometry()], instances).unwrap());
        let instance = |x: f32| Placement::new(0, at(x));
        // Two instances are copied, three are too many.
        assert_eq!(placed(vec![instance(0.0), instance(2.0)]).unwrap().world.triangles(), 2 * sphere.len());
        assert!(placed(vec![instance(0.0), instance(2.0), instance(4.0)]).is_none());
        assert!(placed(vec![instance(2.0).with_paint(Paint::Checker(checker))]).is_none());
        // Rounding would move the vertices by more than 1e-5 of the diagonal.
        assert!(placed(vec![instance(100.1)]).is_some());
        assert!(placed(vec![instance(10_000.1)]).is_none());
        assert!(placed(vec![instance(0.0)]).is_none());
        assert!(find(&built_in("forest:1000")).is_none());
    }
}
