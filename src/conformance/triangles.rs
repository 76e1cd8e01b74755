//! The claims of triangle kernels: rays that exactly meet edges and vertices of meshes, that leave a triangle, and that
//! pass close to edges.
//!
//! `meshes` has random fans, lattices, split triangles and stars. Vulkan's conformance suite does such a test on
//! graphics hardware. `small_grid` adds all edges and fans on a small grid, `crossings` all closed meshes of four
//! triangles there. `beside` compares with exact answers, beside edges and behind the start of rays.

use std::fmt::Write;

use super::counts::Counts;
use super::meshes::{self, Mesh, Shot};
use super::small_grid::{self, GRIDS};
use super::{Options, beside, crossings, threads};
use crate::geom::{Ray, Triangle};
use crate::kernels::Kernel;

/// Inputs that test the claims of triangle kernels. Making them takes longer than testing one kernel, so tests of many
/// kernels share them.
#[derive(Debug)]
pub struct Inputs {
    options: Options,
    meshes: Vec<(Mesh, Vec<Shot>)>,
}

impl Inputs {
    /// Makes the inputs.
    pub fn new(options: &Options) -> Self {
        Self { options: options.clone(), meshes: meshes::all(options) }
    }

    /// Counts how many rays break each claim, whether the kernel makes it or not.
    pub fn count<K: Kernel<Shape = Triangle>>(&self) -> Counts {
        let on_meshes = threads::sum(&self.meshes, |(mesh, shots)| mesh.count::<K>(shots));
        // The products on the first grid are exact, so most kernels are right there.
        let grids = if self.options.exhaustive { &GRIDS[..] } else { &GRIDS[1..] };
        let on_grids =
            grids.iter().map(|grid| small_grid::count::<K>(grid, &self.options).plus(crossings::count::<K>(grid)));
        on_grids.fold(on_meshes.plus(beside::count::<K>(&self.options)), Counts::plus)
    }
}

/// The ray and the first eight of these triangles as expressions in Rust. Each triangle has a number, and says whether
/// the kernel reports a hit.
pub fn describe(ray: &Ray<f32>, triangles: &[(u32, Triangle, bool)]) -> String {
    use super::aimed::Aimed;
    let mut text = format!("let ray = {};\n", super::rust::ray(ray));
    for (index, triangle, hit) in triangles.iter().take(8) {
        let reported = if *hit { "reported" } else { "not reported" };
        writeln!(text, "{}, // triangle {index}, {reported}", triangle.to_rust()).expect("a string takes all text");
    }
    if triangles.len() > 8 {
        writeln!(text, "// and {} more", triangles.len() - 8).expect("a string takes all text");
    }
    text
}
