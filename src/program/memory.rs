//! The memory that a picture takes, checked before it is made.

use raylanes::tracer::{Error, World, check_memory};

/// Bytes for each triangle or quadric while its tree is built, beside those that are loaded already. Measured.
const PER_PRIMITIVE: usize = 150;

/// Bytes for each instance, as the documentation of `Scene` says, and for the tree over the instances.
const PER_INSTANCE: usize = 400;

/// Checks that the system grants the memory for the trees of a world and for some rays.
pub(super) fn check(scene: &str, world: &World, rays: usize, bytes_per_ray: usize) -> Result<(), Error> {
    let (primitives, instances) = (world.triangles() + world.quadrics(), world.instances().len());
    let bytes = primitives * PER_PRIMITIVE + instances * PER_INSTANCE + rays * bytes_per_ray;
    check_memory(bytes).map_err(|message| Error::Argument {
        argument: scene.to_owned(),
        message: format!("{message} ({primitives} primitives, {instances} instances, {rays} rays)"),
    })
}
