//! What the kit found out about one kernel.

use std::fmt::{Display, Formatter, Result};

use super::counts::Counts;
use crate::kernels::{Claim, Id};

/// What a kernel has to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rule {
    /// Scalar and packet twin give the same bits: in every lane, in full and partial packets, for eight rays and one
    /// primitive, and for one ray and eight primitives.
    TwinsAgree,
    /// `any_hit` is the mask of `closest_hit`.
    AnyHit,
    /// `lane` returns the primitive that `gather` put into the lane.
    Lane,
    /// `candidate_in_lane` is the candidate of the primitive in that lane.
    CandidateInLane,
    /// `bounds` returns the exact boxes of the shapes that rays can hit.
    Bounds,
    /// A miss is exactly `Hit::MISS`. A hit holds no NaN, has primitive 0, and its `t` is within the interval.
    WellFormed,
    /// A ray with a NaN, a zero direction, an infinite origin or direction, or an empty interval misses.
    InvalidRayMisses,
    /// A degenerate primitive, or one with a NaN, is missed by every ray.
    DegenerateMisses,
    /// Every ray misses `missed()`, and the lanes that `gather_partial` fills with it.
    Missed,
    /// No input makes the kernel panic.
    NoPanic,
    /// A claim that the kernel makes.
    Claim(Claim),
}

impl Rule {
    /// One word.
    pub fn name(self) -> &'static str {
        match self {
            Self::TwinsAgree => "twins-agree",
            Self::AnyHit => "any-hit",
            Self::Lane => "lane",
            Self::CandidateInLane => "candidate-in-lane",
            Self::Bounds => "bounds",
            Self::WellFormed => "well-formed",
            Self::InvalidRayMisses => "invalid-ray-misses",
            Self::DegenerateMisses => "degenerate-misses",
            Self::Missed => "missed",
            Self::NoPanic => "no-panic",
            Self::Claim(claim) => claim.name(),
        }
    }

    /// What [`Violation::broken`] counts.
    fn unit(self) -> &'static str {
        if matches!(self, Self::Claim(_)) { "rays" } else { "packets" }
    }
}

/// A rule that a kernel breaks.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// How often it was broken: rays for a claim, packets of eight rays and eight primitives for everything else. A
    /// packet that breaks several rules counts for the first of them.
    pub broken: u64,
    /// How often it was tested.
    pub of: u64,
    /// One example: the ray and the primitives as expressions in Rust, and what the kernel made of them.
    pub example: String,
}

impl Violation {
    /// One packet that breaks a rule.
    pub(super) fn of_packet(rule: Rule, example: String) -> Self {
        Self { rule, broken: 1, of: 1, example }
    }
}

impl Display for Violation {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { rule, broken, of, example } = self;
        write!(f, "{}: broken by {broken} of {of} {}. One is:", rule.name(), rule.unit())?;
        example.lines().try_for_each(|line| write!(f, "\n    {line}"))
    }
}

impl std::error::Error for Violation {}

/// The outcome of checking one kernel. It prints as text.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[must_use]
pub struct Report {
    /// The kernel.
    pub kernel: Id,
    /// The seed of the inputs. [`Options::with_seed`](super::Options::with_seed) makes them again.
    pub seed: u64,
    /// Packets of eight rays and eight primitives on which the twins were compared.
    pub packets: u64,
    /// Hits that were damaged, to see that they then miss.
    pub damaged: u64,
    /// Claims of the kernel.
    pub claimed: &'static [Claim],
    /// How many rays break each claim, also of the claims that the kernel does not make.
    pub claims: Counts,
    /// Every rule that is broken. Empty if the kernel conforms.
    pub violations: Vec<Violation>,
    /// What was not checked, each with the reason.
    pub not_checked: Vec<String>,
}

impl Report {
    /// Whether no rule is broken.
    pub fn is_ok(&self) -> bool {
        self.violations.is_empty()
    }

    /// For a test.
    ///
    /// # Panics
    /// With this report, if a rule is broken.
    #[track_caller]
    pub fn assert_ok(&self) {
        assert!(self.is_ok(), "{self}");
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let outcome = if self.is_ok() { "conforms".into() } else { format!("breaks {} rules", self.violations.len()) };
        writeln!(f, "{}: {outcome} (seed {})", self.kernel, self.seed)?;
        writeln!(f, "  twins compared on {} packets, {} hits damaged", self.packets, self.damaged)?;
        for claim in Claim::ALL {
            let (count, is_claimed) = (self.claims.of(claim), self.claimed.contains(&claim));
            let verdict = match (is_claimed, count.rays, count.broken) {
                (true, 0, _) => "claimed, not checked".into(),
                (false, 0, _) => continue,
                (true, rays, 0) => format!("claimed, kept by all of {rays} rays"),
                (true, rays, broken) => format!("claimed, but broken by {broken} of {rays} rays"),
                (false, rays, 0) => format!("not claimed, but none of {rays} rays breaks it"),
                (false, rays, broken) => format!("not claimed, broken by {broken} of {rays} rays"),
            };
            writeln!(f, "  {}: {verdict}", claim.name())?;
        }
        for text in &self.not_checked {
            writeln!(f, "  not checked: {text}")?;
        }
        for violation in &self.violations {
            writeln!(f, "{violation}")?;
        }
        Ok(())
    }
}
