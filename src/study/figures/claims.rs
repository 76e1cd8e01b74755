//! What became of each promise, kept or not made, in the rows that put it to the test.

use super::rate::{Rate, doubles, gross, leaks, lost_by_boxes, wrong};
use crate::geom::{Aabb, Quadric, Shape, Triangle};
use crate::kernels::Claim;
use crate::study::measure::accuracy::Kernels;
use crate::study::record::{AccuracyRow, ClaimRow};
use crate::study::workload::Workload;

/// Which rows put a claim to the test.
fn concerns(claim: Claim, row: &AccuracyRow) -> bool {
    let (at_edges, at_vertices) =
        (row.workload == "shared_edge", ["vertex_fan", "closed_mesh"].contains(&row.workload.as_str()));
    match claim {
        Claim::EdgeWatertight => at_edges,
        Claim::VertexWatertight => at_vertices,
        Claim::SingleHit => at_edges || at_vertices,
        Claim::Conservative => true,
        // Its rays pass an apex more closely than the promises reach.
        Claim::RightDecision | Claim::NoGrossError => row.workload != Workload::Edge.name(),
    }
}

/// The family of kernels that a claim is for.
fn family(claim: Claim) -> &'static str {
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight | Claim::SingleHit => Triangle::FAMILY,
        Claim::Conservative => Aabb::FAMILY,
        Claim::RightDecision | Claim::NoGrossError => Quadric::FAMILY,
    }
}

/// Violations, and what they are violations among.
fn violations(claim: Claim, row: &AccuracyRow) -> [u64; 2] {
    let count = |rate: Option<Rate>| rate.map_or([0; 2], |rate| [rate.events().round() as u64, rate.of]);
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight => count(leaks(row)),
        Claim::SingleHit => {
            let ([leaks, of], [doubles, _]) = (count(leaks(row)), count(doubles(row)));
            [leaks + doubles + row.boundary_many, of]
        }
        Claim::Conservative => count(lost_by_boxes(row)),
        Claim::RightDecision => count(wrong(row)),
        Claim::NoGrossError => count(gross(row)),
    }
}

/// Every kernel of a shape against every claim of its family, whether it makes it or not. `rows` may be those of other
/// kernels too.
pub fn judged<S: Shape>(kernels: &Kernels<S>, rows: &[AccuracyRow]) -> Vec<ClaimRow> {
    let mut judged = Vec::new();
    for kernel in kernels.iter() {
        for claim in Claim::ALL.into_iter().filter(|&claim| family(claim) == S::FAMILY) {
            let concerned = rows.iter().filter(|row| row.id == kernel.id && concerns(claim, row));
            let [violations, of] =
                concerned.map(|row| violations(claim, row)).fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
            let claimed = kernel.claims.contains(&claim);
            judged.push(ClaimRow { id: kernel.id.clone(), claim: claim.name().into(), claimed, violations, of });
        }
    }
    judged
}
