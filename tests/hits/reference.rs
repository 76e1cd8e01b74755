//! A reference tracer in `f64`: a binary tree of triangles, one ray at a time. It shares no code with the library.

use glam::{DVec3, Vec3};
use raylanes::geom::{Ray, Triangle};

/// A tree of triangles.
pub(crate) struct Reference {
    nodes: Vec<Node>,
    triangles: Vec<[DVec3; 3]>,
}

struct Node {
    lo: DVec3,
    hi: DVec3,
    content: Content,
}

enum Content {
    /// The first of two nodes.
    Inner(usize),
    Leaf(Vec<u32>),
}

impl Reference {
    pub(crate) fn new(triangles: impl Iterator<Item = Triangle>) -> Self {
        let triangles: Vec<_> = triangles.map(|triangle| triangle.vertices().map(Vec3::as_dvec3)).collect();
        let mut reference = Self { nodes: Vec::new(), triangles };
        let numbers: Vec<_> = (0..reference.triangles.len() as u32).collect();
        let root = reference.node(&numbers);
        reference.nodes.push(root);
        reference.split(0, numbers);
        reference
    }

    /// A leaf with these triangles.
    fn node(&self, numbers: &[u32]) -> Node {
        let vertices = || numbers.iter().flat_map(|&number| self.triangles[number as usize]);
        let (lo, hi) = (vertices().fold(DVec3::INFINITY, DVec3::min), vertices().fold(DVec3::NEG_INFINITY, DVec3::max));
        // More than the rounding errors of the slab test.
        let pad = lo.abs().max(hi.abs()).max_element() * 1e-12;
        Node { lo: lo - pad, hi: hi + pad, content: Content::Leaf(numbers.to_vec()) }
    }

    /// Splits a leaf at the median along its longest side.
    fn split(&mut self, node: usize, mut numbers: Vec<u32>) {
        if numbers.len() <= 4 {
            return;
        }
        let extent = self.nodes[node].hi - self.nodes[node].lo;
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap();
        let middle = |number: u32| self.triangles[number as usize].iter().map(|vertex| vertex[axis]).sum::<f64>();
        let half = numbers.len() / 2;
        numbers.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)));
        let right = numbers.split_off(half);
        let first = self.nodes.len();
        let children = [self.node(&numbers), self.node(&right)];
        self.nodes.extend(children);
        self.nodes[node].content = Content::Inner(first);
        self.split(first, numbers);
        self.split(first + 1, right);
    }

    /// Where the line of a ray meets the plane of a triangle.
    pub(crate) fn point(&self, ray: &Ray<f32>, number: u32) -> DVec3 {
        let [v0, v1, v2] = self.triangles[number as usize];
        let (origin, dir, normal) = (ray.origin.as_dvec3(), ray.dir.as_dvec3(), (v1 - v0).cross(v2 - v0));
        origin + dir * (normal.dot(v0 - origin) / normal.dot(dir))
    }

    /// The `t` and the number of the first triangle that the ray hits behind its start, without `skipped`.
    pub(crate) fn closest(&self, origin: DVec3, dir: DVec3, skipped: u32) -> (f64, u32) {
        let inverse = 1.0 / dir;
        let (mut best, mut stack) = ((f64::INFINITY, u32::MAX), vec![0]);
        while let Some(node) = stack.pop() {
            let Node { lo, hi, content } = &self.nodes[node];
            let (a, b) = ((*lo - origin) * inverse, (*hi - origin) * inverse);
            let (entry, exit) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
            if entry > exit || entry > best.0 {
                continue;
            }
            match content {
                Content::Inner(first) => stack.extend([*first, first + 1]),
                Content::Leaf(numbers) => {
                    for &number in numbers.iter().filter(|&&number| number != skipped) {
                        if let Some(t) = self.test(number, origin, dir).filter(|&t| t > 0.0) {
                            best = if (t, number) < best { (t, number) } else { best };
                        }
                    }
                }
            }
        }
        best
    }

    /// The `t` of a triangle, by Cramer's rule.
    fn test(&self, number: u32, origin: DVec3, dir: DVec3) -> Option<f64> {
        let [v0, v1, v2] = self.triangles[number as usize];
        let (e1, e2, s) = (v1 - v0, v2 - v0, origin - v0);
        let (p, q) = (dir.cross(e2), s.cross(e1));
        let det = e1.dot(p);
        let [u, v, t] = [s.dot(p), dir.dot(q), e2.dot(q)].map(|numerator| numerator / det);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(t)
    }
}
