//! How many rays break each claim.

use std::fmt::{Display, Formatter};

use crate::kernels::Claim;

/// The rays that a claim is about, and how many of them break it.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Count {
    /// Rays that were tested.
    pub rays: u64,
    /// Rays that break the claim.
    pub broken: u64,
    /// The first ray that breaks it, and the primitives that it meets.
    pub example: Option<String>,
}

/// One [`Count`] for each claim.
#[derive(Clone, Debug, Default)]
pub struct Counts([Count; Claim::ALL.len()]);

impl Counts {
    /// The count of a claim. It is zero if no ray of this shape can test the claim.
    pub fn of(&self, claim: Claim) -> &Count {
        &self.0[index(claim)]
    }

    /// Counts more rays. `example` is called if these are the first that break the claim.
    pub fn add(&mut self, claim: Claim, rays: u64, broken: u64, example: impl FnOnce() -> String) {
        let count = &mut self.0[index(claim)];
        count.rays += rays;
        count.broken += broken;
        if broken > 0 && count.example.is_none() {
            count.example = Some(example());
        }
    }

    /// The sum of both. The example is that of the first.
    #[must_use]
    pub fn plus(self, later: Self) -> Self {
        let mut later = later.0.into_iter();
        Self(self.0.map(|count| {
            let other = later.next().expect("both have a count for each claim");
            Count {
                rays: count.rays + other.rays,
                broken: count.broken + other.broken,
                example: count.example.or(other.example),
            }
        }))
    }
}

fn index(claim: Claim) -> usize {
    Claim::ALL.iter().position(|other| *other == claim).expect("all claims are in the list")
}

/// `edge-watertight 3 of 800, …`, for the claims that were tested.
impl Display for Counts {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let tested = Claim::ALL.into_iter().map(|claim| (claim, self.of(claim))).filter(|(_, count)| count.rays > 0);
        let counts = tested.map(|(claim, count)| format!("{} {} of {}", claim.name(), count.broken, count.rays));
        f.write_str(&counts.collect::<Vec<_>>().join(", "))
    }
}
