//! Compares the twins of a kernel on one packet of rays and one packet of primitives, in every pairing.

use std::fmt::Write;

use wide::f32x8;

use super::aimed::{Aimed, pair_to_rust};
use super::report::{Rule, Violation};
use super::rust::decimal_and_hex;
use crate::geom::{Aabb, Hit, Mask8, Ray};
use crate::kernels::{Intersect, Kernel};

// Not inlined: one copy of each twin instead of one per call.

#[inline(never)]
pub(super) fn hit<K: Kernel>(primitive: &K, ray: &Ray<f32>) -> Hit<f32> {
    Intersect::<f32>::hit(primitive, ray)
}

#[inline(never)]
fn any_hit<K: Kernel>(primitive: &K, ray: &Ray<f32>) -> bool {
    primitive.any_hit(ray, &<K as Intersect<f32>>::setup(ray))
}

#[inline(never)]
pub(super) fn hit8<K: Kernel>(primitive: &K, packet: &Ray<f32x8>) -> Hit<f32x8> {
    Intersect::<f32x8>::hit(primitive, packet)
}

#[inline(never)]
fn any_hit8<K: Kernel>(primitive: &K, packet: &Ray<f32x8>) -> Mask8 {
    primitive.any_hit(packet, &<K as Intersect<f32x8>>::setup(packet))
}

#[inline(never)]
pub(super) fn hit_gathered<K: Kernel>(primitives: &K::Packet, packet: &Ray<f32x8>) -> Hit<f32x8> {
    primitives.hit(packet)
}

#[inline(never)]
fn any_hit_gathered<K: Kernel>(primitives: &K::Packet, packet: &Ray<f32x8>) -> Mask8 {
    primitives.any_hit(packet, &K::Packet::setup(packet))
}

#[inline(never)]
fn hit_in_lane<K: Kernel>(primitives: &K::Packet, lane: usize, packet: &Ray<f32x8>) -> Hit<f32x8> {
    K::candidate_in_lane(primitives, lane, packet, &<K as Intersect<f32x8>>::setup(packet)).or_miss()
}

/// Compares the twins of a kernel on eight rays and eight shapes, in every pairing: each ray with each shape, each ray
/// in each lane, full and partial packets, eight rays and one primitive, one ray and eight primitives. Also compares
/// `any_hit`, `lane`, `candidate_in_lane` and `bounds` with what the contract says, and checks that hits and misses are
/// well formed.
///
/// Returns which ray hits which shape: the bit `8·shape + ray` of the result.
///
/// # Errors
/// The first difference, with the ray, the shape, the lane, and the bits of both hits.
pub fn compare_twins<K: Kernel<Shape: Aimed>>(rays: &[Ray<f32>; 8], shapes: &[K::Shape; 8]) -> Result<u64, Violation> {
    let case = Comparison::<K> { rays, shapes };
    let primitives = shapes.each_ref().map(K::prepare);
    let gathered = K::gather(&primitives);
    let scalar = primitives.map(|primitive| rays.each_ref().map(|ray| hit(&primitive, ray)));

    for (shape, row) in scalar.iter().enumerate() {
        for (ray, hit) in row.iter().enumerate() {
            case.well_formed(shape, ray, hit)?;
        }
    }

    // Eight rays against one primitive, in every lane position.
    for shift in 0..8 {
        let source = |lane: usize| (lane + shift) % 8;
        let packet = Ray::from_lanes(&std::array::from_fn(|lane| rays[source(lane)]));
        let hits = hit8(&primitives[0], &packet);
        for lane in 0..8 {
            let width = || format!("8 rays x 1 primitive, packet turned by {shift}, lane {lane}");
            case.equal(Rule::TwinsAgree, width, [0, source(lane)], &scalar[0][source(lane)], &hits.lane(lane))?;
        }
        case.any(
            || format!("8 rays x 1 primitive, packet turned by {shift}"),
            hits.mask,
            any_hit8(&primitives[0], &packet),
        )?;
    }

    // Partial packets.
    for active in 0..8 {
        let hits = hit8(&primitives[0], &Ray::from_slice(&rays[..active]));
        for (lane, hit) in scalar[0].iter().enumerate() {
            let expected = if lane < active { hit } else { &Hit::MISS };
            let width = || format!("8 rays x 1 primitive, {active} of 8 active, lane {lane}");
            case.equal(Rule::TwinsAgree, width, [0, lane], expected, &hits.lane(lane))?;
        }
    }

    // One ray against eight primitives.
    for (ray, one) in rays.iter().enumerate() {
        let packet = Ray::splat(one);
        let hits = hit_gathered::<K>(&gathered, &packet);
        for (lane, primitive) in primitives.iter().enumerate() {
            let expected = &scalar[lane][ray];
            let width = || format!("1 ray x 8 primitives, lane {lane}");
            case.equal(Rule::TwinsAgree, width, [lane, ray], expected, &hits.lane(lane))?;
            let any = any_hit(primitive, one);
            if any != expected.mask {
                let text = format!("scalar: any_hit {any}, closest_hit {}\n", expected.mask);
                return Err(case.broken(Rule::AnyHit, [lane, ray], text));
            }
        }
        case.any(|| "1 ray x 8 primitives".into(), hits.mask, any_hit_gathered::<K>(&gathered, &packet))?;
    }

    // Lane by lane.
    let packet = Ray::from_lanes(rays);
    let hits = hit_gathered::<K>(&gathered, &packet);
    for (lane, row) in scalar.iter().enumerate() {
        let width = || format!("8 rays x 8 primitives, lane {lane}");
        case.equal(Rule::TwinsAgree, width, [lane, lane], &row[lane], &hits.lane(lane))?;
        let taken_out = hit(&K::lane(&gathered, lane), &rays[lane]);
        let width = || format!("1 ray x 1 primitive, taken out of lane {lane} of 8");
        case.equal(Rule::Lane, width, [lane, lane], &row[lane], &taken_out)?;
        let in_lane = hit_in_lane::<K>(&gathered, lane, &packet);
        for (ray, expected) in row.iter().enumerate() {
            let width = || format!("8 rays x the primitive in lane {lane} of 8, lane {ray}");
            case.equal(Rule::CandidateInLane, width, [lane, ray], expected, &in_lane.lane(ray))?;
        }
    }

    case.bounds(&gathered, &scalar)?;
    let bits = scalar.as_flattened().iter().enumerate().map(|(index, hit)| u64::from(hit.mask) << index);
    Ok(bits.sum())
}

struct Comparison<'a, K: Kernel> {
    rays: &'a [Ray<f32>; 8],
    shapes: &'a [K::Shape; 8],
}

impl<K: Kernel<Shape: Aimed>> Comparison<'_, K> {
    fn broken(&self, rule: Rule, [shape, ray]: [usize; 2], text: String) -> Violation {
        let pair = pair_to_rust(&self.rays[ray], &self.shapes[shape]);
        Violation::of_packet(rule, format!("{pair}{text}"))
    }

    /// Checks that a miss is [`Hit::MISS`], and that a hit contains no NaN and is within the interval.
    fn well_formed(&self, shape: usize, ray: usize, hit: &Hit<f32>) -> Result<(), Violation> {
        let Ray { t_min, t_max, .. } = self.rays[ray];
        let good = if hit.mask {
            let numbers = !hit.u.is_nan() && !hit.v.is_nan();
            numbers && t_min <= hit.t && hit.t <= t_max && hit.primitive == 0 && hit.instance == 0
        } else {
            hit.to_bits() == Hit::MISS.to_bits()
        };
        if good { Ok(()) } else { Err(self.broken(Rule::WellFormed, [shape, ray], format!("scalar: {hit:?}\n"))) }
    }

    fn equal(
        &self,
        rule: Rule,
        width: impl FnOnce() -> String,
        pair: [usize; 2],
        scalar: &Hit<f32>,
        packet: &Hit<f32>,
    ) -> Result<(), Violation> {
        if scalar.mask == packet.mask && scalar.to_bits() == packet.to_bits() {
            return Ok(());
        }
        let mut text = format!("{}\n{:9} {:>24} {:>24}\n", width(), "", "scalar", "other");
        let mut line = |name: &str, a: String, b: String| {
            let mark = if a == b { "" } else { "  <-" };
            writeln!(text, "{name:9} {a:>24} {b:>24}{mark}").expect("a string takes all text");
        };
        line("mask", scalar.mask.to_string(), packet.mask.to_string());
        for (name, a, b) in [("t", scalar.t, packet.t), ("u", scalar.u, packet.u), ("v", scalar.v, packet.v)] {
            line(name, decimal_and_hex(a), decimal_and_hex(b));
        }
        line("primitive", scalar.primitive.to_string(), packet.primitive.to_string());
        line("instance", scalar.instance.to_string(), packet.instance.to_string());
        Err(self.broken(rule, pair, text))
    }

    /// Compares the masks of eight lanes.
    fn any(&self, width: impl FnOnce() -> String, closest: Mask8, any: Mask8) -> Result<(), Violation> {
        if any == closest {
            return Ok(());
        }
        let rays = self.rays.each_ref().map(super::rust::ray).join(",\n    ");
        let shapes = self.shapes.each_ref().map(Aimed::to_rust).join(",\n    ");
        let masks = format!("any_hit {:08b}, closest_hit {:08b}", any.bits(), closest.bits());
        let text = format!(
            "let rays = [\n    {rays}\n];\nlet shapes = [\n    {shapes}\n];\n{}: {masks}, lane 0 is the last digit\n",
            width()
        );
        Err(Violation::of_packet(Rule::AnyHit, text))
    }

    /// Compares the boxes of the shapes that a ray hits. Nothing is said about the others.
    fn bounds(&self, gathered: &K::Packet, scalar: &[[Hit<f32>; 8]; 8]) -> Result<(), Violation> {
        let Some(bounds) = K::bounds(gathered) else { return Ok(()) };
        for (lane, row) in scalar.iter().enumerate() {
            let Some(ray) = row.iter().position(|hit| hit.mask) else { continue };
            let found = Aabb { lo: bounds.lo.lane(lane), hi: bounds.hi.lane(lane) };
            let expected = self.shapes[lane].exact_bounds();
            if expected != Some(found) {
                let expected = expected.map_or("none: the box of an instance is not exact".into(), |one| one.to_rust());
                let text = format!("bounds, lane {lane}: {}\nexpected: {expected}\n", found.to_rust());
                return Err(self.broken(Rule::Bounds, [lane, ray], text));
            }
        }
        Ok(())
    }
}
