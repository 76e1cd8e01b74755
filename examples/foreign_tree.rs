//! The closest hit in a tree of another crate: obvhs builds it, a kernel tests its leaves, eight triangles at once.
//!
//! The box rule makes the hits independent of the tree: they are those of the crate's own tree, bit for bit.
//! `cargo run --release --example foreign_tree --features peers`

use std::error::Error;
use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use raylanes::geom::{Aabb, Hit, Ray, Triangle};
use raylanes::kernels::aabb::InverseDirection;
use raylanes::kernels::box_rule::{self, TInterval};
use raylanes::kernels::{Intersect, Kernel, triangle::ExactHalfOpen};
use raylanes::tracer::{Geometry, Mode, Scene, SceneSource, checksum, trace};
use raylanes::wide::{f32x8, u32x8};

/// Up to eight triangles, and their numbers in the mesh.
struct Leaf(ExactHalfOpen<f32x8>, u32x8);

impl Leaf {
    fn new(triangles: &[Triangle], numbers: &[u32]) -> Self {
        let prepared: Vec<_> =
            numbers.iter().map(|&number| ExactHalfOpen::prepare(&triangles[number as usize])).collect();
        let number = |index: usize| numbers.get(index).copied().unwrap_or(u32::MAX);
        Self(ExactHalfOpen::gather_partial(&prepared), u32x8::new(std::array::from_fn(number)))
    }
}

/// The closest hit. The nearer child of each node is visited first.
fn closest(tree: &Bvh2, leaves: &[Option<Leaf>], ray: &Ray<f32>) -> Hit<f32> {
    let (slabs, ray8) = (InverseDirection::<f32>::of(ray), Ray::splat(ray));
    let slabs8 = InverseDirection::<f32x8>::of(&ray8);
    let setup8 = <ExactHalfOpen<f32> as Intersect<f32x8>>::setup(&ray8);
    let entry = |node: usize| {
        let bounds = Aabb { lo: tree.nodes[node].aabb.min.into(), hi: tree.nodes[node].aabb.max.into() };
        TInterval::<f32>::of(&bounds.into(), ray.origin, &slabs).map(|interval| (interval.entry, node))
    };
    let (mut best, mut stack) = (Hit::MISS, Vec::from_iter(entry(0)));
    while let Some((entry_t, node)) = stack.pop() {
        if entry_t > best.t {
            continue;
        }
        if let Some(Leaf(prepared, numbers)) = &leaves[node] {
            let candidates = prepared.candidate(&ray8, &setup8);
            let bounds = ExactHalfOpen::bounds(prepared).expect("this kernel knows the boxes of its triangles");
            let hit = box_rule::apply8(candidates, &bounds, ray8.origin, &slabs8).of_primitives(*numbers).closest();
            best = if hit.is_closer_than(&best) { hit } else { best };
        } else {
            let first = tree.nodes[node].first_index as usize;
            let base = stack.len();
            stack.extend([entry(first), entry(first + 1)].into_iter().flatten());
            stack[base..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
    }
    best
}

fn main() -> Result<(), Box<dyn Error>> {
    let loaded = SceneSource::parse("terrain:1e5")?.load()?;
    let Geometry::Mesh(mesh) = &loaded.world.geometries()[0] else { unreachable!("a terrain is a mesh") };
    let (triangles, rays) = (Vec::from_iter(mesh.iter()), loaded.view.camera(256, 256).rays(256, 256));

    let boxes: Vec<_> =
        triangles.iter().map(Triangle::bounds).map(|b| obvhs::aabb::Aabb::new(b.lo.into(), b.hi.into())).collect();
    let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
    let leaf = |node: &obvhs::bvh2::node::Bvh2Node| {
        let first = node.first_index as usize;
        node.is_leaf().then(|| Leaf::new(&triangles, &tree.primitive_indices[first..first + node.prim_count as usize]))
    };
    let leaves: Vec<_> = tree.nodes.iter().map(leaf).collect();

    let hits: Vec<_> = rays.iter().map(|ray| closest(&tree, &leaves, ray)).collect();
    let own = trace(&Scene::<ExactHalfOpen<f32>>::from(mesh.clone()), &rays, Mode::Auto);
    println!("{} rays, {} hits", rays.len(), hits.iter().filter(|hit| hit.mask).count());
    println!("checksum in the foreign tree {:016x}, in the own tree {:016x}", checksum(&hits), checksum(&own));
    assert_eq!(checksum(&hits), checksum(&own));
    Ok(())
}
