//! The contract between twins, and the families of kernels.
//!
//! A kernel is a struct generic over its lane type: `MollerTrumbore<f32>` is one prepared triangle,
//! `MollerTrumbore<f32x8>` is eight. It is written twice:
//!
//! - The **scalar twin**, `impl Intersect<f32> for K<f32>`, in plain glam, is the specification.
//! - The **packet twin**, `impl<P: Lanes> Intersect<f32x8> for K<P>`, is its translation, line by line. It first
//!   widens the primitive to eight lanes. So one body serves eight rays against one primitive (`P = f32`) and one
//!   ray, copied to eight lanes, against eight primitives (`P = f32x8`).
//!
//! Both give the same bits for every input. `tests/twins.rs` checks that for every kernel in the
//! [registry](crate::registry).

#[macro_use]
mod prepared;

pub mod aabb;
pub mod box_rule;
pub mod instance;
pub mod quadric;
pub mod triangle;
mod volume;

use wide::f32x8;

use self::aabb::Slabs;
pub use crate::geom::Shape;
use crate::geom::{Candidate, Hit, Lanes, Ray};

/// Anything that one ray (`L = f32`) or eight (`L = f32x8`) can be intersected with: a prepared primitive, an
/// instance, a whole scene.
///
/// Implementations are total: no input makes them panic, and no hit holds a NaN.
pub trait Intersect<L: Lanes> {
    /// Data that is computed once per ray and used for every primitive, such as the inverse direction.
    type Setup: Copy;

    /// Computes the per-ray data.
    fn setup(ray: &Ray<L>) -> Self::Setup;

    /// Like [`Intersect::closest_hit`], but cheaper: lanes that miss may hold anything. For a loop over primitives.
    fn candidate(&self, ray: &Ray<L>, setup: &Self::Setup) -> Candidate<L>;

    /// The closest hit within the ray's interval. `setup` must be that of the same ray.
    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<L>, setup: &Self::Setup) -> Hit<L> {
        self.candidate(ray, setup).or_miss()
    }

    /// Which rays hit anything within their interval: the mask of [`Intersect::closest_hit`], possibly for less work.
    #[inline(always)]
    fn any_hit(&self, ray: &Ray<L>, setup: &Self::Setup) -> L::Mask {
        self.candidate(ray, setup).mask()
    }

    /// [`Intersect::closest_hit`] with setup and test in one call, for a ray that is tested once.
    #[inline(always)]
    fn hit(&self, ray: &Ray<L>) -> Hit<L> {
        self.closest_hit(ray, &Self::setup(ray))
    }
}

/// One intersection method for one shape. The prepared primitive of the scalar twin implements this trait.
pub trait Kernel: Intersect<f32> + Intersect<f32x8> + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// The shape that it intersects.
    type Shape: Shape;
    /// Eight prepared primitives, for one ray against eight of them.
    type Packet: Intersect<f32x8, Setup = <Self as Intersect<f32x8>>::Setup> + Copy + core::fmt::Debug + Send + Sync;
    /// Name, source, cost and claims.
    const INFO: Info;

    /// Computes what does not depend on the ray. A shape that the kernel cannot represent (degenerate or not finite)
    /// becomes a primitive that misses.
    fn prepare(shape: &Self::Shape) -> Self;

    /// Lane `i` becomes `primitives[i]`.
    fn gather(primitives: &[Self; 8]) -> Self::Packet;

    /// A primitive that every ray misses.
    fn missed() -> Self {
        Self::prepare(&Self::Shape::MISSED)
    }

    /// Lane `i` becomes `primitives[i]`. The lanes beyond the last primitive become [`Kernel::missed`].
    ///
    /// # Panics
    /// If there are more than eight primitives.
    fn gather_partial(primitives: &[Self]) -> Self::Packet {
        let mut lanes = [Self::missed(); 8];
        lanes[..primitives.len()].copy_from_slice(primitives);
        Self::gather(&lanes)
    }

    /// The primitive that [`Kernel::gather`] put into a lane.
    ///
    /// # Panics
    /// If `lane >= 8`.
    fn lane(packet: &Self::Packet, lane: usize) -> Self;

    /// The candidate of eight rays and the primitive in one lane of a packet. A kernel that calls a cold function may
    /// do without a copy of the primitive in memory. Handing that function the widened vertices instead made
    /// occlusion rays take 1.03 to 1.22 times as long.
    #[inline(always)]
    fn candidate_in_lane(
        packet: &Self::Packet,
        lane: usize,
        ray: &Ray<f32x8>,
        setup: &<Self as Intersect<f32x8>>::Setup,
    ) -> Candidate<f32x8> {
        Intersect::<f32x8>::candidate(&Self::lane(packet, lane), ray, setup)
    }

    /// The boxes of the eight shapes, if the prepared primitives determine them exactly. A tree then need not store
    /// them.
    #[inline(always)]
    fn bounds(_packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        None
    }
}

/// What a kernel says about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Info {
    /// Name, as used in tests, benches, records, charts and on the command line.
    pub id: Id,
    /// The idea in one line.
    pub idea: &'static str,
    /// Authors, title, year.
    pub source: &'static str,
    /// Arithmetic per test, once primitive and ray are prepared.
    pub operations: Operations,
    /// Arithmetic per ray to prepare it.
    pub setup: Operations,
    /// Promises that the tests enforce, without tolerance.
    pub claims: &'static [Claim],
}

impl Info {
    /// What a kernel says that claims nothing and counts no operations. `method` is `family/name`, `idea` one line, and
    /// `source` gives authors, title and year.
    pub const fn new(method: &'static str, idea: &'static str, source: &'static str) -> Self {
        let (operations, setup) = (Operations::NONE, Operations::NONE);
        Self { id: Id::of(method), idea, source, operations, setup, claims: &[] }
    }

    /// With this arithmetic per test.
    #[must_use]
    pub const fn with_operations(self, operations: Operations) -> Self {
        Self { operations, ..self }
    }

    /// With this arithmetic per ray.
    #[must_use]
    pub const fn with_setup(self, setup: Operations) -> Self {
        Self { setup, ..self }
    }

    /// Whether the kernel makes this promise.
    pub const fn claims_to(&self, claim: Claim) -> bool {
        let mut index = 0;
        while index < self.claims.len() {
            if self.claims[index] as u8 == claim as u8 {
                return true;
            }
            index += 1;
        }
        false
    }

    /// With these promises.
    #[must_use]
    pub const fn with_claims(self, claims: &'static [Claim]) -> Self {
        Self { claims, ..self }
    }
}

/// Name of a kernel: `family/name`. For an instance the name of the inner kernel follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Id {
    /// `family/name`.
    pub method: &'static str,
    /// The method of the kernel inside an instance.
    pub inner: Option<&'static str>,
}

impl Id {
    /// The ID of a kernel without an inner one.
    pub const fn of(method: &'static str) -> Self {
        Self { method, inner: None }
    }
}

impl core::fmt::Display for Id {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.method)?;
        self.inner.map_or(Ok(()), |inner| write!(f, "/{inner}"))
    }
}

/// Floating-point operations of one test that runs to its end. Selections, logic and conversions are not counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Operations {
    /// Multiplications, in `f32` and `f64` together. The next fields count both too.
    pub mul: u32,
    /// Additions and subtractions.
    pub add: u32,
    /// Comparisons, minima and maxima.
    pub compare: u32,
    /// Divisions and square roots.
    pub div: u32,
    /// Multiplications that are fused with an addition. Both are counted above.
    pub fused: u32,
    /// Numbers of the prepared primitive that are read.
    pub reads: u32,
    /// The part of the above that is in `f64`.
    pub double: DoubleOperations,
}

/// The part of [`Operations`] that is in `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct DoubleOperations {
    /// Multiplications.
    pub mul: u32,
    /// Additions and subtractions.
    pub add: u32,
    /// Comparisons, minima and maxima.
    pub compare: u32,
    /// Divisions and square roots.
    pub div: u32,
}

impl DoubleOperations {
    /// None.
    pub const NONE: Self = Self { mul: 0, add: 0, compare: 0, div: 0 };

    /// Multiplications, additions, comparisons and divisions.
    pub const fn new(mul: u32, add: u32, compare: u32, div: u32) -> Self {
        Self { mul, add, compare, div }
    }
}

impl Operations {
    /// None.
    pub const NONE: Self =
        Self { mul: 0, add: 0, compare: 0, div: 0, fused: 0, reads: 0, double: DoubleOperations::NONE };

    /// Multiplications, additions, comparisons and divisions.
    pub const fn new(mul: u32, add: u32, compare: u32, div: u32) -> Self {
        Self { mul, add, compare, div, ..Self::NONE }
    }

    /// With so many multiplications that are fused with an addition.
    #[must_use]
    pub const fn with_fused(self, fused: u32) -> Self {
        Self { fused, ..self }
    }

    /// With so many numbers read.
    #[must_use]
    pub const fn with_reads(self, reads: u32) -> Self {
        Self { reads, ..self }
    }

    /// With this part in `f64`.
    #[must_use]
    pub const fn with_double(self, double: DoubleOperations) -> Self {
        Self { double, ..self }
    }

    /// The sum of both.
    pub const fn and(self, other: Self) -> Self {
        let (a, b) = (self.double, other.double);
        Self {
            mul: self.mul + other.mul,
            add: self.add + other.add,
            compare: self.compare + other.compare,
            div: self.div + other.div,
            fused: self.fused + other.fused,
            reads: self.reads + other.reads,
            double: DoubleOperations {
                mul: a.mul + b.mul,
                add: a.add + b.add,
                compare: a.compare + b.compare,
                div: a.div + b.div,
            },
        }
    }
}

/// A promise that a kernel makes. The tests enforce it without tolerance. The study also looks for a violation by
/// every kernel of the family that does not make it: a promise that every kernel could make is no information.
///
/// The claims about meshes hold for triangles that all face the ray in the same way: at a silhouette a ray may pass
/// between two of them. Rounding the vertices by one ulp of their distance from the ray's origin must not flip any
/// triangle. A triangle seen nearly edge-on, or a sliver, may be rejected by its other edges or hit beside its
/// neighbours. No claim holds where an intermediate product overflows or is subnormal.
///
/// The claims about quadrics exclude rays that pass an apex, or the rim where the box cuts, within an ulp of their
/// own coordinates. They also exclude rays that start inside a box but 1e7 times the surface's size away from the
/// surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Claim {
    /// A ray through an edge of two triangles hits at least one of them.
    EdgeWatertight,
    /// A ray through a vertex hits at least one of the triangles around it.
    VertexWatertight,
    /// A ray through a mesh hits exactly one of its triangles, even exactly at an edge or a vertex.
    SingleHit,
    /// The line of a ray crosses a closed mesh an even number of times: also through edges and vertices, and also where
    /// the triangles around them do not all face the ray in the same way.
    EvenCrossings,
    /// A ray whose interval starts at 0 never hits a triangle that it passes only behind its start, however close.
    NoHitBehind,
    /// A box: never misses where the exact answer is a hit.
    Conservative,
    /// A triangle or a quadric: always right about hitting, for an interval that starts at 0 or does not
    /// start, except where the exact answer depends on an equality.
    RightDecision,
    /// A quadric: `t` of every true hit is right to 1 %.
    NoGrossError,
}

impl Claim {
    /// Every claim.
    pub const ALL: [Self; 8] = [
        Self::EdgeWatertight,
        Self::VertexWatertight,
        Self::SingleHit,
        Self::EvenCrossings,
        Self::NoHitBehind,
        Self::Conservative,
        Self::RightDecision,
        Self::NoGrossError,
    ];

    /// One word, as printed in tables and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::EdgeWatertight => "edge-watertight",
            Self::VertexWatertight => "vertex-watertight",
            Self::SingleHit => "single-hit",
            Self::EvenCrossings => "even-crossings",
            Self::NoHitBehind => "no-hit-behind",
            Self::Conservative => "conservative",
            Self::RightDecision => "right-decision",
            Self::NoGrossError => "no-gross-error",
        }
    }
}

/// The power of two at or below a positive normal number. All bits except those of the exponent are cleared.
pub(crate) fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & f64::INFINITY.to_bits())
}
