//! Which vertices are at the same position, and which triangles hang together.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::tracer::Mesh;

/// For each vertex, the lowest number of a vertex at the same position. A negative zero is zero.
pub(super) fn welded(mesh: &Mesh) -> Vec<u32> {
    let key = |(number, position): (usize, &Vec3)| ((*position + 0.0).to_array().map(f32::to_bits), number as u32);
    let mut order: Vec<_> = mesh.positions().par_iter().enumerate().map(key).collect();
    order.par_sort_unstable();
    let mut welded = vec![0; order.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        for &(_, number) in same {
            welded[number as usize] = same[0].1;
        }
    }
    welded
}

/// The larger components of a mesh: triangles that hang together by vertices at the same position.
pub(super) struct Components {
    /// In order of their first triangle.
    pub(super) components: Vec<Component>,
    /// For each vertex of the mesh, its place in [`Component::vertices`] of its component.
    places: Vec<u32>,
}

/// Triangles that hang together.
pub(super) struct Component {
    /// Their numbers, ascending.
    pub(super) triangles: Vec<u32>,
    /// The numbers of their vertices, ascending, one for each position.
    vertices: Vec<u32>,
}

impl Components {
    /// The components with at least this many triangles.
    pub(super) fn of(mesh: &Mesh, min_triangles: usize) -> Self {
        let welded = welded(mesh);
        let mut parents: Vec<u32> = (0..welded.len() as u32).collect();
        let vertices = |triangle: &[u32; 3]| triangle.map(|index| welded[index as usize]);
        for [a, b, c] in mesh.triangles().iter().map(vertices) {
            join(&mut parents, a, b);
            join(&mut parents, a, c);
        }
        let roots: Vec<u32> = (0..welded.len() as u32).map(|vertex| root(&mut parents, vertex)).collect();
        let root = |triangle: &[u32; 3]| roots[vertices(triangle)[0] as usize] as usize;
        let mut sizes = vec![0usize; welded.len()];
        for triangle in mesh.triangles() {
            sizes[root(triangle)] += 1;
        }
        let mut numbers = vec![None; welded.len()];
        let mut components: Vec<Component> = Vec::new();
        for (number, triangle) in (0..).zip(mesh.triangles()) {
            let root = root(triangle);
            if sizes[root] < min_triangles {
                continue;
            }
            let component = *numbers[root].get_or_insert_with(|| {
                components.push(Component { triangles: Vec::with_capacity(sizes[root]), vertices: Vec::new() });
                components.len() - 1
            });
            components[component].triangles.push(number);
        }
        let mut places = vec![0; welded.len()];
        for (vertex, &first) in (0..).zip(&welded) {
            if first != vertex {
                places[vertex as usize] = places[first as usize];
            } else if let Some(component) = numbers[roots[vertex as usize] as usize] {
                places[vertex as usize] = components[component].vertices.len() as u32;
                components[component].vertices.push(vertex);
            }
        }
        Self { components, places }
    }

    /// The vertices of a component, each once, and for each triangle three indices into them.
    pub(super) fn shape(&self, mesh: &Mesh, component: &Component) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corners = |&triangle: &u32| mesh.triangles()[triangle as usize].map(|vertex| self.places[vertex as usize]);
        let position = |&vertex: &u32| mesh.positions()[vertex as usize].as_dvec3();
        (component.vertices.iter().map(position).collect(), component.triangles.iter().map(corners).collect())
    }
}

/// The root of a vertex's component. The path to it is halved.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let grandparent = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = grandparent;
        vertex = grandparent;
    }
    vertex
}

fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// The colour of these triangles, if they have only one. There must be at least one triangle.
pub(super) fn only_color(mesh: &Mesh, triangles: &[u32]) -> Option<Vec3> {
    let color = mesh.color(triangles[0]);
    triangles.iter().all(|&triangle| mesh.color(triangle) == color).then_some(color)
}

/// The triangles of the mesh that are in none of these sets.
pub(super) fn remaining<'a>(mesh: &Mesh, sets: impl Iterator<Item = &'a [u32]>) -> Vec<u32> {
    let mut is_taken = vec![false; mesh.len()];
    for &triangle in sets.flatten() {
        is_taken[triangle as usize] = true;
    }
    (0..mesh.len() as u32).filter(|&triangle| !is_taken[triangle as usize]).collect()
}
