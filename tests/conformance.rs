//! Tests that the conformance kit passes the kernel of the example, and that it names what is wrong with the same
//! kernel with one defect. `twins.rs` runs the kit on all registered kernels.

use std::fmt::Debug;
use std::marker::PhantomData;

use glam::Vec3;
use raylanes::conformance::{Options, Report, Rule, check, check_with, compare_twins};
use raylanes::geom::lanes::{Lanes, Mask8, Vec3x8, eq8};
use raylanes::geom::{Candidate, Ray, Triangle};
use raylanes::kernels::aabb::Slabs;
use raylanes::kernels::{Claim, Info, Intersect, Kernel};
use wide::f32x8;

use own_kernel::OwnKernel;

#[path = "../examples/own_kernel.rs"]
#[expect(dead_code, reason = "a test does not call the example's main function")]
mod own_kernel;

/// One thing that a kernel does wrong. Every function is right unless a defect replaces it.
trait Defect: Copy + Debug + Send + Sync + 'static {
    const CLAIMS: &'static [Claim] = &[];

    fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
        inner.candidate(ray, &())
    }

    fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
        inner.candidate(ray, &())
    }

    fn any_hit(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> bool {
        Self::scalar(inner, ray).mask()
    }

    fn any_hit8(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Mask8 {
        Self::packet(inner, ray).mask()
    }

    fn source_of_lane(lane: usize) -> usize {
        lane
    }

    fn taken_from_lane(lane: usize) -> usize {
        lane
    }

    fn candidate_in_lane(packet: &OwnKernel<f32x8>, lane: usize, ray: &Ray<f32x8>) -> Candidate<f32x8> {
        Self::packet(&widened(&OwnKernel::lane(packet, lane)), ray)
    }

    fn bounds() -> Option<Slabs<f32x8>> {
        None
    }

    fn missed() -> OwnKernel<f32> {
        OwnKernel::missed()
    }
}

fn widened(one: &OwnKernel<f32>) -> OwnKernel<f32x8> {
    OwnKernel::gather(&[*one; 8])
}

/// The kernel of the example with a defect.
#[derive(Clone, Copy, Debug)]
struct Defective<D, P: Lanes>(OwnKernel<P>, PhantomData<D>);

impl<D: Defect> Kernel for Defective<D, f32> {
    type Shape = Triangle;
    type Packet = Defective<D, f32x8>;
    const INFO: Info = OwnKernel::INFO.with_claims(D::CLAIMS);

    fn prepare(shape: &Triangle) -> Self {
        Self(OwnKernel::prepare(shape), PhantomData)
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Defective(OwnKernel::gather(&std::array::from_fn(|lane| primitives[D::source_of_lane(lane)].0)), PhantomData)
    }

    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        Self(OwnKernel::lane(&packet.0, D::taken_from_lane(lane)), PhantomData)
    }

    fn missed() -> Self {
        Self(D::missed(), PhantomData)
    }

    fn candidate_in_lane(packet: &Self::Packet, lane: usize, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        D::candidate_in_lane(&packet.0, lane, ray)
    }

    fn bounds(_: &Self::Packet) -> Option<Slabs<f32x8>> {
        D::bounds()
    }
}

impl<D: Defect> Intersect<f32> for Defective<D, f32> {
    type Setup = ();

    fn setup(_: &Ray<f32>) {}

    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        D::scalar(&self.0, ray)
    }

    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        D::any_hit(&self.0, ray)
    }
}

impl<D: Defect> Intersect<f32x8> for Defective<D, f32> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        D::packet(&widened(&self.0), ray)
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        D::any_hit8(&widened(&self.0), ray)
    }
}

impl<D: Defect> Intersect<f32x8> for Defective<D, f32x8> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        D::packet(&self.0, ray)
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        D::any_hit8(&self.0, ray)
    }
}

/// Defines a defect, and the test that expects it to break a rule.
macro_rules! defects {
    ($($test:ident: $Name:ident breaks $rule:expr, { $($item:item)* })*) => {$(
        #[derive(Clone, Copy, Debug)]
        struct $Name;

        impl Defect for $Name {
            $($item)*
        }

        #[test]
        fn $test() {
            let report = check_with::<Defective<$Name, f32>>(&Options::new().with_packets(1_000));
            assert_named(&report, $rule);
        }
    )*};
}

/// Checks that the report names this rule, with an example.
fn assert_named(report: &Report, rule: Rule) {
    let text = report.to_string();
    let violation = report.violations.iter().find(|violation| violation.rule == rule);
    let violation = violation.unwrap_or_else(|| panic!("{} is not named:\n{text}", rule.name()));
    assert!(violation.broken > 0 && violation.broken <= violation.of, "{violation}");
    assert!(violation.example.contains("Ray {") && violation.example.contains("Triangle {"), "{violation}");
    assert!(!report.is_ok() && text.contains(&format!("{}: broken by", rule.name())), "{text}");
    let panic = std::panic::catch_unwind(|| report.assert_ok()).expect_err("the report is not ok");
    assert_eq!(panic.downcast_ref::<String>(), Some(&text));
}

defects! {
    a_different_rounding_in_one_twin_is_named: OtherRounding breaks Rule::TwinsAgree, {
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            let found = inner.candidate(ray, &());
            let v = f32x8::ONE - (f32x8::ONE - found.v());
            Candidate::<f32x8>::new(found.mask(), found.t(), found.u(), v)
        }
    }

    a_hit_beyond_the_end_of_the_ray_is_named: EndIgnored breaks Rule::WellFormed, {
        fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
            inner.candidate(&Ray { t_max: f32::INFINITY, ..*ray }, &())
        }
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            inner.candidate(&Ray { t_max: f32x8::splat(f32::INFINITY), ..*ray }, &())
        }
    }

    a_nan_in_a_hit_is_named: NanLetThrough breaks Rule::WellFormed, {
        fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
            let found = inner.candidate(ray, &());
            if found.u() == 0.0 { Candidate::<f32>::new(found.mask(), found.t(), f32::NAN, found.v()) } else { found }
        }
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            let found = inner.candidate(ray, &());
            let u = eq8(found.u(), f32x8::ZERO).select(f32x8::splat(f32::NAN), found.u());
            Candidate::<f32x8>::new(found.mask(), found.t(), u, found.v())
        }
    }

    a_ray_without_a_direction_that_hits_is_named: DirectionIgnored breaks Rule::InvalidRayMisses, {
        fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
            if ray.dir == Vec3::ZERO && ray.t_min <= 0.0 && ray.t_max >= 0.0 {
                return Candidate::<f32>::new(true, 0.0, 0.0, 0.0);
            }
            inner.candidate(ray, &())
        }
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            lane_by_lane::<Self>(inner, ray)
        }
    }

    a_degenerate_triangle_that_is_hit_is_named: DegenerateHit breaks Rule::DegenerateMisses, {
        fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
            if inner.v0.is_nan() && ray.t_min <= 0.0 && ray.t_max >= 0.0 {
                return Candidate::<f32>::new(true, 0.0, 0.0, 0.0);
            }
            inner.candidate(ray, &())
        }
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            lane_by_lane::<Self>(inner, ray)
        }
    }

    a_gather_into_the_wrong_lane_is_named: Exchanged breaks Rule::TwinsAgree, {
        fn source_of_lane(lane: usize) -> usize {
            lane ^ 1
        }
    }

    a_wrong_lane_taken_out_is_named: WrongLane breaks Rule::Lane, {
        fn taken_from_lane(lane: usize) -> usize {
            lane ^ 4
        }
    }

    another_candidate_in_a_lane_is_named: OtherCandidate breaks Rule::CandidateInLane, {
        fn candidate_in_lane(packet: &OwnKernel<f32x8>, _: usize, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            packet.candidate(ray, &())
        }
    }

    another_scalar_any_hit_is_named: OtherAnyHit breaks Rule::AnyHit, {
        fn any_hit(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> bool {
            inner.candidate(&Ray { t_max: f32::INFINITY, ..*ray }, &()).mask()
        }
    }

    another_packet_any_hit_is_named: OtherAnyHit8 breaks Rule::AnyHit, {
        fn any_hit8(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Mask8 {
            inner.candidate(&Ray { t_max: f32x8::splat(f32::INFINITY), ..*ray }, &()).mask()
        }
    }

    wrong_bounds_are_named: WrongBounds breaks Rule::Bounds, {
        fn bounds() -> Option<Slabs<f32x8>> {
            Some(Slabs { lo: Vec3x8::splat(Vec3::splat(-9.0)), hi: Vec3x8::splat(Vec3::splat(9.0)) })
        }
    }

    a_missed_primitive_that_is_hit_is_named: MissedIsHit breaks Rule::Missed, {
        fn missed() -> OwnKernel<f32> {
            OwnKernel::prepare(&Triangle { v0: Vec3::splat(-99.0), v1: Vec3::X * 99.0, v2: Vec3::Y * 99.0 })
        }
    }

    a_panic_is_named: Panics breaks Rule::NoPanic, {
        fn scalar(inner: &OwnKernel<f32>, ray: &Ray<f32>) -> Candidate<f32> {
            assert!(!ray.t_max.is_nan(), "the ray must have an end");
            inner.candidate(ray, &())
        }
    }

    a_panic_in_the_packet_twin_is_named: Panics8 breaks Rule::NoPanic, {
        fn packet(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
            assert!(!ray.t_max.to_array()[3].is_nan(), "the ray must have an end");
            inner.candidate(ray, &())
        }
    }

    a_false_claim_about_edges_is_named: EdgeClaim breaks Rule::Claim(Claim::EdgeWatertight), {
        const CLAIMS: &'static [Claim] = &[Claim::EdgeWatertight];
    }

    false_claims_are_named: AllClaims breaks Rule::Claim(Claim::RightDecision), {
        const CLAIMS: &'static [Claim] = &Claim::ALL;
    }
}

/// The scalar twin in each lane.
fn lane_by_lane<D: Defect>(inner: &OwnKernel<f32x8>, ray: &Ray<f32x8>) -> Candidate<f32x8> {
    let hits: [_; 8] = std::array::from_fn(|lane| D::scalar(&OwnKernel::lane(inner, lane), &ray.lane(lane)));
    let mask = Mask8::from_lanes(hits.map(|hit| hit.mask()));
    let [t, u, v] =
        [Candidate::<f32>::t, Candidate::u, Candidate::v].map(|part| f32x8::new(hits.map(|hit| part(&hit))));
    Candidate::<f32x8>::new(mask, t, u, v)
}

#[derive(Clone, Copy, Debug)]
struct NoDefect;
impl Defect for NoDefect {}

#[test]
fn the_kernel_of_the_example_conforms() {
    let report = check::<OwnKernel<f32>>();
    report.assert_ok();
    println!("{report}");
    // It makes no claim. All claims about triangles are counted, and all of them are broken.
    for claim in Claim::ALL.into_iter().filter(|claim| !matches!(claim, Claim::Conservative | Claim::NoGrossError)) {
        let count = report.claims.of(claim);
        assert!(count.broken > 0 && count.rays > 10_000, "{}: {count:?}", claim.name());
    }
    assert!(report.damaged > 500 && report.packets == 4_000, "{report}");
    // The defects above are seen because of themselves, not because of how they are made.
    check::<Defective<NoDefect, f32>>().assert_ok();
}

#[test]
fn a_difference_names_lane_and_bits() {
    let shape = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
    let ray = Ray::new(Vec3::new(0.3, 1e-9, 1.0), Vec3::NEG_Z);
    assert_eq!(compare_twins::<OwnKernel<f32>>(&[ray; 8], &[shape; 8]).expect("the twins agree"), u64::MAX);
    let difference = compare_twins::<Defective<OtherRounding, f32>>(&[ray; 8], &[shape; 8]).unwrap_err();
    let text = difference.to_string();
    for part in [
        "twins-agree: broken by 1 of 1 packets. One is:",
        "let ray = Ray { origin: Vec3::new(0.3, 1e-9, 1.0), dir: Vec3::new(0.0, 0.0, -1.0), t_min: 0.0, ",
        "let shape = Triangle { v0: Vec3::new(0.0, 0.0, 0.0), v1: Vec3::new(1.0, 0.0, 0.0), v2: Vec3::new(0.0, ",
        "8 rays x 1 primitive, packet turned by 0, lane 0",
        "1e-9 3089705f             0e0 00000000  <-",
    ] {
        assert!(text.contains(part), "{part}\nis not in\n{text}");
    }
}
