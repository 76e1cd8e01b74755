//! Coherence: whether eight consecutive rays are alike, so that packets pay.

use glam::DVec3;
use rayon::prelude::*;

use super::Trait;
use crate::geom::Ray;
use crate::study::figures::percent;
use crate::study::measure::ray_sets::RaySet;

/// Rays of a group: as many as a packet has lanes.
const GROUP: usize = 8;

/// Greatest angle between a direction of a coherent group and the mean of its directions, in radians. In the report's
/// section on coherence, packets pay up to a jitter of 0.01, which turns rays by up to 0.01 radians. From 0.03 on,
/// single rays are faster. Pixels of a group are up to 0.004 radians from its middle there.
const MAX_ANGLE: f64 = 0.025;

/// Decides if no set has this share of coherent groups. There is no regime for it: no hit depends on it.
const MIN_COHERENT: f64 = 0.5;

/// The shares of coherent groups. The set with the greatest one decides. None if there are no rays.
pub(super) fn coherence(sets: &[RaySet]) -> Option<Trait> {
    let shares: Vec<_> =
        sets.iter().filter(|set| !set.rays.is_empty()).map(|set| (set.name, coherent_share(&set.rays))).collect();
    let greatest = shares.iter().map(|(_, share)| *share).reduce(f64::max)?;
    let each: Vec<_> = shares.iter().map(|(name, share)| format!("{name} {}", percent(Some(*share)))).collect();
    Some(Trait::below(
        MIN_COHERENT,
        "coherence",
        greatest,
        format!("groups of eight similar rays: {}", each.join(", ")),
        "packets pay only where eight consecutive rays are similar",
    ))
}

/// The share of groups of [`GROUP`] consecutive rays that are coherent. The last group may be smaller.
fn coherent_share(rays: &[Ray<f32>]) -> f64 {
    let groups = rays.par_chunks(GROUP);
    let all = groups.len();
    groups.filter(|group| is_coherent(group)).count() as f64 / all as f64
}

/// Whether all directions are in one octant and within [`MAX_ANGLE`] of their mean. A zero or a NaN is not.
fn is_coherent(group: &[Ray<f32>]) -> bool {
    let unit = |ray: &Ray<f32>| ray.dir.as_dvec3().normalize_or_zero();
    let mean = group.iter().map(unit).sum::<DVec3>().normalize_or_zero();
    let octant = |ray: &Ray<f32>| ray.dir.is_negative_bitmask();
    group.iter().all(|ray| octant(ray) == octant(&group[0]) && unit(ray).dot(mean) >= MAX_ANGLE.cos())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn groups_of_eight_rays_are_coherent_in_one_octant_and_a_narrow_cone() {
        let coherent = |dirs: [Vec3; 8]| is_coherent(&dirs.map(|dir| Ray::new(Vec3::Z, dir)));
        // The length does not count.
        let turned = |angle: f32| Vec3::new(1.0, 1.0, 1.0 + 2.12 * angle) * (1.0 + 10.0 * angle);
        let spread = |greatest: f32| std::array::from_fn(|ray| turned(greatest * (ray as f32 / 3.5 - 1.0)));
        assert_eq!([0.0, 0.01, 0.02, 0.03, 0.1].map(|angle| coherent(spread(angle))), [true, true, true, false, false]);
        let mut dirs = [Vec3::new(1.0, 1.0, 0.0); 8];
        assert!(coherent(dirs));
        dirs[5].z = -0.001;
        assert!(!coherent(dirs), "two octants");
        assert!(!coherent([Vec3::ZERO; 8]) && !coherent([Vec3::NAN; 8]));
    }

    #[test]
    fn the_most_coherent_set_decides() {
        let alike = [Ray::new(Vec3::ZERO, Vec3::ONE); 8];
        let opposite: [_; 8] =
            std::array::from_fn(|ray| Ray { dir: alike[ray].dir * [1.0, -1.0][ray % 2], ..alike[ray] });
        let set = |name, groups: &[[Ray<f32>; 8]]| RaySet { name, any_hit: false, rays: groups.concat() };
        let (quarter, none) = (set("a", &[alike, opposite, opposite, opposite]), set("b", &[opposite]));
        let found = coherence(&[none.clone(), quarter.clone(), set("empty", &[])]).unwrap();
        assert_eq!((found.value, found.decides), (0.25, true));
        assert!(found.text.contains("b 0 %, a 25 % "), "{}", found.text);
        let found = coherence(&[none, quarter, set("c", &[alike])]).unwrap();
        assert_eq!((found.value, found.decides), (1.0, false));
        assert!(coherence(&[set("empty", &[])]).is_none());
    }
}
