//! Lines through the points of a small grid, and all closed meshes of four triangles there. Most lines meet edges and
//! vertices, many of them at silhouettes.
//!
//! The answer of a kernel for one triangle does not depend on its neighbours. So each triangle is tested once, against
//! all lines. A tetrahedron is crossed an even number of times if the sets of lines that hit its four faces cancel.

use super::counts::Counts;
use super::int3::{exactly, plus};
use super::small_grid::{Grid, directions, triangle};
use super::threads;
use super::triangles::describe;
use super::twins::hit8;
use crate::geom::{Ray, Triangle};
use crate::kernels::{Claim, Kernel};

/// Lines through every point of the grid, without a start and an end.
fn lines(grid: &Grid) -> Vec<Ray<f32>> {
    let at = |point, dir| {
        let origin = exactly(plus(point, dir, -grid.distance));
        Ray { t_min: f32::NEG_INFINITY, ..Ray::new(origin, exactly(dir)) }
    };
    grid.points().into_iter().flat_map(|point| directions().into_iter().map(move |dir| at(point, dir))).collect()
}

/// Counts how often a kernel crosses a tetrahedron an odd number of times.
pub(super) fn count<K: Kernel<Shape = Triangle>>(grid: &Grid) -> Counts {
    let (points, lines) = (grid.points(), lines(grid));
    let packets: Vec<_> = lines.chunks(8).map(Ray::from_slice).collect();
    // Which lines hit the triangle of three points, one bit each. The order of the vertices differs.
    let hits = |a: usize, b: usize, c: usize| {
        let mut corners = [points[a], points[b], points[c]];
        corners.rotate_left((a + b + c) % 3);
        if (a + b).is_multiple_of(2) {
            corners.swap(0, 1);
        }
        let primitive = K::prepare(&triangle(corners));
        packets.iter().map(|ray| hit8(&primitive, ray).mask.bits() as u8).collect::<Vec<_>>()
    };
    let triples = |n: usize| (0..n).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| [a, b, c])));
    // In this order, the number of a triangle is c + b(b - 1)/2 + a(a - 1)(a - 2)/6.
    let number =
        |[a, b, c]: [usize; 3]| c + b * b.saturating_sub(1) / 2 + a * a.saturating_sub(1) * a.saturating_sub(2) / 6;
    let sets: Vec<_> = triples(points.len()).map(|[a, b, c]| hits(a, b, c)).collect();
    let at_apex = |&a: &usize| {
        let mut counts = Counts::default();
        for [b, c, d] in triples(a) {
            let faces = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
            let [p, q, r, s] = faces.map(|face| &sets[number(face)]);
            let odd = |packet: usize| p[packet] ^ q[packet] ^ r[packet] ^ s[packet];
            let broken: u32 = (0..packets.len()).map(|packet| odd(packet).count_ones()).sum();
            counts.add(Claim::EvenCrossings, lines.len() as u64, broken.into(), || {
                let packet = (0..packets.len()).find(|packet| odd(*packet) != 0).expect("there is one");
                let lane = odd(packet).trailing_zeros() as usize;
                let face = |index: usize| {
                    let corners = faces[index].map(|point| points[point]);
                    (index as u32, triangle(corners), sets[number(faces[index])][packet] >> lane & 1 == 1)
                };
                describe(&lines[8 * packet + lane], &[0, 1, 2, 3].map(face))
            });
        }
        counts
    };
    threads::sum(&Vec::from_iter(0..points.len()), at_apex)
}
