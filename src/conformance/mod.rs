//! Checks a kernel of your own: the rules that hold for the kernels of this crate, as one call.
//!
//! ```
//! use raylanes::conformance;
//! # type MyKernel = raylanes::kernels::triangle::MollerTrumbore<f32>;
//!
//! // With #[test] before it:
//! fn my_kernel_conforms() {
//!     conformance::check::<MyKernel>().assert_ok();
//! }
//! # my_kernel_conforms();
//! ```
//!
//! Such a test takes about a second in an optimised build. `examples/own_kernel.rs` has a complete kernel.
//!
//! # What is checked
//!
//! | what | on which inputs |
//! | --- | --- |
//! | twins give the same bits: every lane, partial packets, 8×1, 1×8, `any_hit`, `lane`, `candidate_in_lane` | cases |
//! | hits hold no NaN and are within the interval; a miss is exactly [`Hit::MISS`](crate::geom::Hit::MISS) | cases |
//! | `bounds`, if given, are the exact boxes | cases |
//! | invalid rays, degenerate primitives and `missed()` miss | hits of cases, damaged one number at a time |
//! | no input makes the kernel panic | all |
//! | claims about meshes of triangles | rays that exactly meet edges and vertices |
//! | right-decision and no-hit-behind of triangles | rays beside edges, and rays that leave a triangle |
//! | conservative boxes | rays that exactly meet corners, edges and faces |
//!
//! A [case](Case) is eight rays aimed at eight shapes. The rays start near and far away, graze, and meet edges exactly.
//! The shapes are huge and tiny, slivers, degenerate, and not finite.
//!
//! Claims are checked whether the kernel makes them or not. The report says which claims it could make.
//!
//! # What is not checked
//!
//! The errors of `t`, `u` and `v`, and the claims of quadrics: they need the oracle (feature `study`). Exact answers
//! here have 128 bits. Triangles and rays that need more are not decided. A report lists what was not checked.
//!
//! A kernel that passes is not proven right. Inputs are finite, and they depend on a [seed](Options::with_seed).

mod aimed;
mod beside;
mod boxes;
mod case;
mod counts;
mod crossings;
mod exact;
mod int3;
mod invalid;
mod meshes;
mod numbers;
mod random;
mod report;
mod rust;
mod small_grid;
mod threads;
mod triangles;
mod twins;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use aimed::Aimed;
pub use beside::beside_edges;
pub use case::Case;
pub use counts::{Count, Counts};
pub use exact::{Decision, decide};
pub use invalid::damage;
pub use numbers::Numbers;
pub use random::Random;
pub use report::{Report, Rule, Violation};
pub use triangles::{Inputs, describe};
pub use twins::compare_twins;

use crate::geom::Ray;
use crate::kernels::{Claim, Intersect, Kernel};

/// How much is checked, and on which random inputs.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// The seed of all random inputs.
    pub seed: u64,
    /// Packets of eight rays and eight shapes on which the twins are compared. One in four is also damaged.
    pub packets: u32,
    /// Whether claims are checked on everything that there is: both small grids, all edges on them, and meshes of up
    /// to 65,536 triangles. Otherwise on a part.
    pub exhaustive: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self::new()
    }
}

impl Options {
    /// Seed 0, 4,000 packets, not exhaustive.
    pub const fn new() -> Self {
        Self { seed: 0, packets: 4_000, exhaustive: false }
    }

    /// With this seed.
    #[must_use]
    pub const fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// With this number of packets.
    #[must_use]
    pub const fn with_packets(self, packets: u32) -> Self {
        Self { packets, ..self }
    }

    /// With everything that there is to check claims on. Takes about ten seconds of computing.
    #[must_use]
    pub const fn exhaustive(self) -> Self {
        Self { exhaustive: true, ..self }
    }

    /// The seed of one of many inputs.
    fn seed_of(&self, index: u64) -> u64 {
        self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index)
    }
}

/// Checks a kernel with [`Options::new`].
pub fn check<K: Kernel<Shape: Aimed>>() -> Report {
    check_with::<K>(&Options::new())
}

/// Checks a kernel.
pub fn check_with<K: Kernel<Shape: Aimed>>(options: &Options) -> Report {
    let mut found = Found::default();
    let (mut random, mut damaged) = (Random::from_seed(options.seed), 0);
    let damages = options.packets / 4;
    for packet in 0..options.packets {
        let case = Case::random(&mut random);
        found.add(caught::<K, _>(&case, || compare_twins::<K>(&case.rays, &case.shapes)));
        if packet < damages {
            damaged += found.add(caught::<K, _>(&case, || damage::<K>(&case))).unwrap_or(0);
        }
    }
    let mut violations = found.violations(options.packets.into(), damages.into());
    let claims = catch_unwind(|| K::Shape::claims::<K>(options)).unwrap_or_else(|panic| {
        violations.push(Violation::of_packet(Rule::NoPanic, format!("on rays that test claims: {}", text(&*panic))));
        Counts::default()
    });
    let claimed = K::INFO.claims;
    violations.extend(claimed.iter().filter_map(|&claim| broken(claim, claims.of(claim))));
    let not_checked = K::Shape::NOT_CHECKED.iter().map(|&text| text.into()).collect();
    Report {
        kernel: K::INFO.id,
        seed: options.seed,
        packets: options.packets.into(),
        damaged,
        claimed,
        claims,
        violations,
        not_checked,
    }
}

/// Counts how many rays break each claim, whether the kernel makes it or not. To test many kernels for triangles, share
/// [`Inputs`].
pub fn claims<K: Kernel<Shape: Aimed>>(options: &Options) -> Counts {
    K::Shape::claims::<K>(options)
}

fn broken(claim: Claim, count: &Count) -> Option<Violation> {
    let example = count.example.clone()?;
    Some(Violation { rule: Rule::Claim(claim), broken: count.broken, of: count.rays, example })
}

/// The rules that packets break.
#[derive(Default)]
struct Found(BTreeMap<&'static str, Violation>);

impl Found {
    fn add<T>(&mut self, outcome: Result<T, Violation>) -> Option<T> {
        outcome
            .map_err(|violation| {
                let same = self.0.entry(violation.rule.name());
                same.and_modify(|earlier| earlier.broken += 1).or_insert(violation);
            })
            .ok()
    }

    /// All of them, in the order of their names, with the number of packets that were tested.
    fn violations(self, packets: u64, damages: u64) -> Vec<Violation> {
        let tested = |rule| match rule {
            Rule::InvalidRayMisses | Rule::DegenerateMisses | Rule::Missed => damages,
            _ => packets,
        };
        self.0.into_values().map(|violation| Violation { of: tested(violation.rule), ..violation }).collect()
    }
}

/// Turns a panic of the kernel into a violation.
fn caught<K: Kernel<Shape: Aimed>, T>(
    case: &Case<K::Shape>,
    compare: impl FnOnce() -> Result<T, Violation>,
) -> Result<T, Violation> {
    catch_unwind(AssertUnwindSafe(compare)).unwrap_or_else(|panic| {
        // The scalar twin may say which ray and shape it is.
        let panics = |ray: &Ray<f32>, shape: &K::Shape| {
            catch_unwind(AssertUnwindSafe(|| Intersect::<f32>::hit(&K::prepare(shape), ray))).is_err()
        };
        let pairs = case.shapes.iter().flat_map(|shape| case.rays.iter().map(move |ray| (ray, shape)));
        let pair = pairs.clone().find(|(ray, shape)| panics(ray, shape));
        let one = |(ray, shape)| aimed::pair_to_rust(ray, shape);
        let inputs = pair.map_or_else(|| format!("one of:\n{}", pairs.map(one).collect::<String>()), one);
        Err(Violation::of_packet(Rule::NoPanic, format!("{inputs}{}\n", text(&*panic))))
    })
}

/// What a panic said.
fn text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic without text").into()
}
