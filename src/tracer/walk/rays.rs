//! Rays as walks need them: packets made of scattered rays, lanes, octants.

use wide::{f32x8, u32x8};

use crate::geom::lanes::{Mask8, Vec3x8, eq8};
use crate::geom::{Candidate, Hit, Ray};

/// A hit for rays that ask only whether there is any: all fields but the mask are zero.
pub(crate) const ANY_HIT: Hit<f32> = Hit { mask: true, t: 0.0, u: 0.0, v: 0.0, primitive: 0, instance: 0 };

/// For each axis, 1 if the directions of this octant have their sign bit set, else 0. Bit `i` of `octant` is axis `i`.
#[inline(always)]
pub(crate) fn dir_is_neg(octant: usize) -> [usize; 3] {
    [octant & 1, octant >> 1 & 1, octant >> 2 & 1]
}

/// The octant of a direction: bit `i` is the sign bit of axis `i`.
#[inline(always)]
pub(crate) fn octant(ray: &Ray<f32>) -> usize {
    let [x, y, z] = ray.dir.to_array().map(|dir| usize::from(dir.is_sign_negative()));
    x | y << 1 | z << 2
}

/// A packet of at most eight rays; the other lanes are inactive.
#[inline(always)]
pub(crate) fn packet<'a>(rays: impl IntoIterator<Item = &'a Ray<f32>>) -> Ray<f32x8> {
    let mut rows = [row(&Ray::INACTIVE); 8];
    for (row_of, ray) in rows.iter_mut().zip(rays) {
        *row_of = row(ray);
    }
    packet_of_rows(rows)
}

/// The eight numbers of a ray in memory order.
#[inline(always)]
pub(crate) fn row(ray: &Ray<f32>) -> f32x8 {
    f32x8::new(ray.to_array())
}

/// Eight rows as a packet. Transposing takes a fifth of the instructions of gathering component by component.
#[inline(always)]
pub(crate) fn packet_of_rows(rows: [f32x8; 8]) -> Ray<f32x8> {
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = f32x8::transpose(rows);
    Ray { origin: Vec3x8 { x: ox, y: oy, z: oz }, dir: Vec3x8 { x: dx, y: dy, z: dz }, t_min, t_max }
}

/// The mask that is set in this lane only.
#[inline(always)]
pub(crate) fn only_lane(lane: usize) -> Mask8 {
    eq8(f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]), f32x8::splat(lane as f32))
}

/// The hit of one ray, placed in its lane of a packet. The other lanes miss.
#[inline(always)]
pub(crate) fn hit_in_lane(lane: usize, hit: &Hit<f32>) -> Candidate<f32x8> {
    Candidate::from(Hit {
        mask: if hit.mask { only_lane(lane) } else { Mask8::none() },
        t: f32x8::splat(hit.t),
        u: f32x8::splat(hit.u),
        v: f32x8::splat(hit.v),
        primitive: u32x8::splat(hit.primitive),
        instance: u32x8::splat(hit.instance),
    })
}
