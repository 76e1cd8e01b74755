//! Checks every claim in the rows that test it, for kernels that make the claim and for kernels that do not.

use super::rate::{Rate, double_hits, gross, leaks, lost_by_boxes, odd_crossings, wrong};
use crate::geom::{Aabb, Quadric, Shape, Triangle};
use crate::kernels::Claim;
use crate::study::measure::accuracy::Kernels;
use crate::study::record::{AccuracyRow, ClaimRow};
use crate::study::workload::Workload;

/// Whether a row tests a claim.
fn concerns(claim: Claim, family: &str, row: &AccuracyRow) -> bool {
    let is_of = |workloads: [&str; 2]| workloads.contains(&row.workload.as_str());
    let (at_edges, at_vertices) = (is_of(["shared_edge", "vertex_order"]), is_of(["vertex_fan", "closed_mesh"]));
    match claim {
        Claim::EdgeWatertight => at_edges,
        Claim::VertexWatertight => at_vertices,
        Claim::SingleHit => at_edges || at_vertices,
        // Every miss of this regime is behind the ray's start.
        Claim::NoHitBehind => row.workload == "leaving",
        Claim::Conservative => true,
        // For quadrics, these claims do not cover rays that pass so close to an apex.
        Claim::RightDecision | Claim::NoGrossError => {
            family == Triangle::FAMILY || row.workload != Workload::Edge.name()
        }
        Claim::EvenCrossings => row.workload == "silhouette",
    }
}

/// The families whose kernels can make a claim, as far as the study tests it.
fn families(claim: Claim) -> &'static [&'static str] {
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight | Claim::SingleHit | Claim::NoHitBehind => &[Triangle::FAMILY],
        Claim::Conservative => &[Aabb::FAMILY],
        Claim::RightDecision => &[Triangle::FAMILY, Quadric::FAMILY],
        Claim::NoGrossError => &[Quadric::FAMILY],
        // No ray of the regime `silhouette` breaks it for `triangle/woop_half_open`, which does not claim it. Lines of
        // `tests/watertight.rs` do.
        Claim::EvenCrossings => &[],
    }
}

/// Number of violations in a row, and number of rays or pairs that were checked.
fn violations(claim: Claim, row: &AccuracyRow) -> [u64; 2] {
    let count = |rate: Option<Rate>| rate.map_or([0; 2], |rate| [rate.events, rate.of]);
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight => count(leaks(row)),
        Claim::SingleHit => {
            let ([leaks, of], [double_hits, _]) = (count(leaks(row)), count(double_hits(row)));
            [leaks + double_hits + row.boundary_many, of]
        }
        Claim::NoHitBehind => count(Rate::new(row.false_hit_per_million, row.exact_misses)),
        Claim::Conservative => count(lost_by_boxes(row)),
        Claim::RightDecision => count(wrong(row)),
        Claim::EvenCrossings => count(odd_crossings(row)),
        Claim::NoGrossError => count(gross(row)),
    }
}

/// Checks every kernel of a shape for every claim of its family, whether the kernel makes the claim or not. `rows` may
/// contain rows of other kernels; these are ignored. Returns one row per kernel and claim.
pub fn judged<S: Shape>(kernels: &Kernels<S>, rows: &[AccuracyRow]) -> Vec<ClaimRow> {
    let mut judged = Vec::new();
    for kernel in kernels.iter() {
        for claim in Claim::ALL.into_iter().filter(|&claim| families(claim).contains(&S::FAMILY)) {
            let concerned = rows.iter().filter(|row| row.id == kernel.id && concerns(claim, S::FAMILY, row));
            let [violations, of] =
                concerned.map(|row| violations(claim, row)).fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
            let claimed = kernel.claims.contains(&claim);
            judged.push(ClaimRow { id: kernel.id.clone(), claim: claim.name().into(), claimed, violations, of });
        }
    }
    judged
}
