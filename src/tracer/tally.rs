//! Counting what the walks do, where someone asks for it.

/// What it took to trace rays, all of them together. Where rays are taken together, what is visited is counted once for
/// all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays.
    pub rays: u64,
    /// Nodes visited, each with up to eight boxes, leaves not counted.
    pub nodes: u64,
    /// Leaves visited, each with up to eight triangles.
    pub leaves: u64,
    /// Triangle tests: of eight rays and one triangle, or one ray and up to eight; in scalar mode of one and one.
    pub tests: u64,
    /// Lanes of those tests in which the ray hits the box of the triangle.
    pub lanes: u64,
}

/// What a walk reports to. The empty one costs nothing.
pub(super) trait Tally {
    /// A node above others is visited.
    #[inline(always)]
    fn node(&mut self) {}
    /// A leaf is visited.
    #[inline(always)]
    fn leaf(&mut self) {}
    /// Eight lanes are tested, of which so many, computed only if it is asked for, are of use.
    #[inline(always)]
    fn test(&mut self, lanes: impl FnOnce() -> u32) {
        let _ = lanes;
    }
}

impl Tally for () {}

impl Tally for Counts {
    fn node(&mut self) {
        self.nodes += 1;
    }

    fn leaf(&mut self) {
        self.leaves += 1;
    }

    fn test(&mut self, lanes: impl FnOnce() -> u32) {
        self.tests += 1;
        self.lanes += u64::from(lanes());
    }
}
