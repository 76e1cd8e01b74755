//! Damages hits: an invalid ray, a degenerate primitive and `missed()` must miss.

use glam::Vec3;
use wide::f32x8;

use super::aimed::{Aimed, pair_to_rust};
use super::case::Case;
use super::report::{Rule, Violation};
use super::twins::{hit, hit_gathered, hit8};
use crate::geom::{Hit, Ray};
use crate::kernels::Kernel;

/// Takes the rays of a case that hit its first shape, and damages one number of ray or shape at a time. All of them
/// must miss, with both twins. Also checks degenerate shapes, `missed()` and `gather_partial`.
///
/// Returns how many hits were damaged.
///
/// # Errors
/// The first damaged input that does not miss.
pub fn damage<K: Kernel<Shape: Aimed>>(case: &Case<K::Shape>) -> Result<u64, Violation> {
    let (shape, primitive) = (case.shapes[0], K::prepare(&case.shapes[0]));
    let mut hits = 0;
    for ray in case.rays.iter().filter(|ray| hit(&primitive, ray).mask) {
        hits += 1;
        invalid_rays(ray)
            .into_iter()
            .try_for_each(|(what, bad)| expect_miss(Rule::InvalidRayMisses, what, &primitive, &shape, &bad))?;
        for coordinate in 0..9 {
            let bad = shape.with_coordinate(coordinate, f32::NAN);
            expect_miss(Rule::DegenerateMisses, "NaN coordinate", &K::prepare(&bad), &bad, ray)?;
        }
        for bad in shape.degenerate() {
            let prepared = K::prepare(&bad);
            // At the degenerate shape, and at the original one.
            let target = bad.target(Vec3::new(0.5, 0.5, 0.5));
            let at = Ray { origin: target - ray.dir, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..*ray };
            for ray in [at, *ray] {
                expect_miss(Rule::DegenerateMisses, "degenerate", &prepared, &bad, &ray)?;
            }
        }
    }
    missed::<K>(case)?;
    Ok(hits)
}

/// Every way to make a ray invalid.
fn invalid_rays(ray: &Ray<f32>) -> Vec<(&'static str, Ray<f32>)> {
    let mut rays = vec![
        ("zero direction", Ray { dir: Vec3::ZERO, ..*ray }),
        ("negative zero direction", Ray { dir: -Vec3::ZERO, ..*ray }),
        ("NaN t_min", Ray { t_min: f32::NAN, ..*ray }),
        ("NaN t_max", Ray { t_max: f32::NAN, ..*ray }),
        ("empty interval", Ray { t_min: 2.0, t_max: 1.0, ..*ray }),
        ("inactive", Ray { origin: ray.origin, dir: ray.dir, ..Ray::INACTIVE }),
    ];
    for axis in 0..3 {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (mut origin, mut dir) = (*ray, *ray);
            origin.origin[axis] = value;
            dir.dir[axis] = value;
            rays.extend([("origin", origin), ("direction", dir)]);
        }
    }
    rays
}

fn expect_miss<K: Kernel<Shape: Aimed>>(
    rule: Rule,
    what: &str,
    primitive: &K,
    shape: &K::Shape,
    ray: &Ray<f32>,
) -> Result<(), Violation> {
    let hits = [("scalar", hit(primitive, ray)), ("packet", hit8(primitive, &Ray::splat(ray)).lane(0))];
    for (twin, hit) in hits {
        if hit.to_bits() != Hit::MISS.to_bits() {
            let text = format!("{}{what}, {twin}: {hit:?}\n", pair_to_rust(ray, shape));
            return Err(Violation::of_packet(rule, text));
        }
    }
    Ok(())
}

/// Checks that `missed()` is missed, and that `gather_partial` fills lanes with it.
fn missed<K: Kernel<Shape: Aimed>>(case: &Case<K::Shape>) -> Result<(), Violation> {
    for ray in &case.rays {
        expect_miss(Rule::Missed, "missed()", &K::missed(), &<K::Shape as crate::geom::Shape>::MISSED, ray)?;
        let primitives = case.shapes.each_ref().map(K::prepare);
        let packet: Ray<f32x8> = Ray::splat(ray);
        let all = hit_gathered::<K>(&K::gather(&primitives), &packet);
        for count in [0, 3, 7] {
            let hits = hit_gathered::<K>(&K::gather_partial(&primitives[..count]), &packet);
            for lane in 0..8 {
                let expected = if lane < count { all.lane(lane) } else { Hit::MISS };
                if hits.lane(lane).to_bits() != expected.to_bits() {
                    let text = format!(
                        "{}gather_partial of {count} primitives, lane {lane}: {:?}\nexpected: {expected:?}\n",
                        pair_to_rust(ray, &case.shapes[lane]),
                        hits.lane(lane)
                    );
                    return Err(Violation::of_packet(Rule::Missed, text));
                }
            }
        }
    }
    Ok(())
}
