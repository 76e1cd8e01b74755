//! What became of each promise, kept or not made, in the rows that put it to the test.

use super::accuracy::Kernels;
use super::record::{AccuracyRow, ClaimRow};
use crate::geom::{Aabb, Shape, Triangle};
use crate::kernels::Claim;

/// Which rows put a claim to the test.
fn concerns(claim: Claim, row: &AccuracyRow) -> bool {
    match claim {
        Claim::EdgeWatertight => row.workload == "shared_edge",
        Claim::VertexWatertight => ["vertex_fan", "closed_mesh"].contains(&row.workload.as_str()),
        Claim::SingleHit => ["shared_edge", "vertex_fan", "closed_mesh"].contains(&row.workload.as_str()),
        Claim::Conservative => true,
    }
}

/// The family of kernels that a claim is for.
fn family(claim: Claim) -> &'static str {
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight | Claim::SingleHit => Triangle::FAMILY,
        Claim::Conservative => Aabb::FAMILY,
    }
}

/// Violations, and what they are violations among.
fn violations(claim: Claim, row: &AccuracyRow) -> [u64; 2] {
    let events = |per_million: f64, of: u64| (per_million * of as f64 / 1e6).round() as u64;
    let leaks = events(row.leak_per_million, row.mesh_hits);
    match claim {
        Claim::EdgeWatertight | Claim::VertexWatertight => [leaks, row.mesh_hits],
        Claim::SingleHit => {
            [leaks + events(row.double_per_million, row.single_hits) + row.boundary_many, row.mesh_hits]
        }
        Claim::Conservative => [
            events(row.false_miss_per_million, row.exact_hits) + row.boundary_none,
            row.exact_hits + row.boundary_none + row.boundary_one + row.boundary_many,
        ],
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
