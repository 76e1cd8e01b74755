//! Two triangles that share an edge, in every order of their vertices.
//!
//! Most kernels treat the edge between `v1` and `v2` unlike the two others. So their leaks depend on which edges meet,
//! and a mesh has whatever order its exporter wrote.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{Grid, shuffled, starting_with, unturned_hinge};
use super::{RAYS_PER_SAMPLE, Sample};
use crate::geom::{Ray, Triangle};

/// The vertices with which the two triangles start. The shared edge is `v0v1` for 0, `v2v0` for 1 and `v1v2` for 2.
/// Exchanging the triangles changes nothing, because they are made alike. The last ones leak most with most kernels.
const STARTS: [[usize; 2]; 6] = [[2, 2], [1, 2], [0, 2], [0, 1], [1, 1], [0, 0]];

/// The numbers of the orders: those of [`STARTS`], each seen from the front and from the back.
pub(super) const ORDERS: [f64; 12] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0];

/// Two triangles that share an edge, and rays that meet the edge: half of them exactly, on a grid. The vertices have
/// the order of this number.
pub(super) fn ordered_hinge(order: usize, rng: &mut Pcg64) -> Sample<Triangle> {
    let Sample { shapes, rays } = if rng.random() { grid_hinge(rng) } else { unturned_hinge(0.0, rng) };
    // Grids are mirrored at random.
    let reversed = shows_front(&shapes[0], &rays[0]) == order.is_multiple_of(2);
    let ordered = |(Triangle { v0, v1, v2 }, start): (Triangle, usize)| {
        let [v0, v1] = if reversed { [v1, v0] } else { [v0, v1] };
        starting_with(start, Triangle { v0, v1, v2 })
    };
    Sample { shapes: shapes.into_iter().zip(STARTS[(order - 1) / 2]).map(ordered).collect(), rays }
}

/// Whether the triangle's normal points against the ray. `f64` is precise enough for rays so steep.
fn shows_front(shape: &Triangle, ray: &Ray<f32>) -> bool {
    let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
    (v1 - v0).cross(v2 - v0).dot(ray.dir.as_dvec3()) < 0.0
}

/// Two triangles on a grid that share the edge between their first two vertices, and rays that meet it exactly.
fn grid_hinge(rng: &mut Pcg64) -> Sample<Triangle> {
    let grid = Grid::any(rng);
    let offset = Grid::COARSE.point(16, rng);
    let corner = |x: f32, y: f32, rng: &mut Pcg64| offset + Vec3::new(x, y, 0.0) + grid.point(2, rng);
    let (a, b) = (corner(0.0, -16.0, rng), corner(0.0, 16.0, rng));
    let (left, right) = (corner(-16.0, 0.0, rng), corner(16.0, 0.0, rng));
    // Eighths need three more digits, which f32 holds, also for the ray.
    let on_edge = |rng: &mut Pcg64| a + (b - a) * (rng.random_range(1..8) as f32 / 8.0);
    let rays = (0..RAYS_PER_SAMPLE).map(|_| grid.ray(on_edge(rng), rng)).collect();
    let shapes = vec![Triangle { v0: a, v1: b, v2: left }, Triangle { v0: b, v1: a, v2: right }];
    shuffled(Sample { shapes, rays }, rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    /// The edge of `shape` that both ends of `other` are on: the number of its first vertex.
    fn shared_edge(shape: &Triangle, other: &Triangle) -> usize {
        let vertices = shape.vertices();
        let apex = vertices.iter().position(|vertex| !other.vertices().contains(vertex)).unwrap();
        (apex + 1) % 3
    }

    #[test]
    fn each_order_has_other_shared_edges_or_another_winding() {
        for (pair, edges) in [[1, 1], [2, 1], [0, 1], [0, 2], [2, 2], [0, 0]].into_iter().enumerate() {
            for order in [2 * pair + 1, 2 * pair + 2] {
                for index in 0..100 {
                    let Sample { shapes, rays } = ordered_hinge(order, &mut rng(1, "", "", &[], index));
                    let [a, b] = &shapes[..] else { panic!("two triangles") };
                    assert_eq!([shared_edge(a, b), shared_edge(b, a)], edges, "order {order}");
                    let [i, j] = edges;
                    let of = |shape: &Triangle, edge: usize| [shape.vertices()[edge], shape.vertices()[(edge + 1) % 3]];
                    let [from, to] = of(b, j);
                    assert_eq!(of(a, i), [to, from], "the triangles must face the same way");
                    assert_eq!(rays.iter().all(|ray| shows_front(b, ray)), order % 2 == 1, "order {order}");
                    assert!(rays.iter().all(|ray| shapes.iter().any(|shape| shape.truth(ray).hit)), "a hole");
                }
            }
        }
    }
}
