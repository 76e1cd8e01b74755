//! Tests that instances share their geometry: the allocator counts the bytes of a scene with 10,000 instances.

use glam::{Affine3, Vec3};
use peak_alloc::PeakAlloc;
use raylanes::kernels::triangle::MollerTrumbore;
use raylanes::tracer::{Geometry, Placement, Scene, SceneSource, World};

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// The bytes that the scene reports, and the bytes that the allocator counts.
fn bytes(instances: usize) -> (usize, usize) {
    let before = HEAP.current_usage();
    let (mut geometries, _) = SceneSource::parse("sphere:70000").unwrap().load().unwrap().world.into_parts();
    let Some(Geometry::Mesh(mesh)) = geometries.pop() else { panic!("a sphere is a mesh") };
    let place = |index: usize| {
        let at = Vec3::new((index % 100) as f32, (index / 100) as f32, 0.0) * 3.0;
        Placement::new(0, Affine3::from_translation(at))
    };
    let world = World::new(vec![Geometry::Mesh(mesh)], (0..instances).map(place).collect()).unwrap();
    let scene = Scene::<MollerTrumbore<f32>>::new(world);
    (scene.bytes(), HEAP.current_usage() - before)
}

/// An instance takes about 275 bytes, as the documentation of [`Scene`] says.
#[test]
fn instances_share_the_memory_of_their_mesh() {
    // The first scene also allocates what stays, such as the threads.
    bytes(1);
    let (one, many) = (bytes(1), bytes(10_000));
    let each = (many.0 - one.0) as f64 / 9_999.0;
    assert!((265.0..285.0).contains(&each), "{each} bytes for each instance");
    for (claimed, taken) in [one, many] {
        let ratio = taken as f64 / claimed as f64;
        assert!((0.99..1.03).contains(&ratio), "{claimed} bytes claimed, {taken} taken");
    }
}
