//! Statistics of a traversal, collected only when somebody asks for them.

/// What tracing a set of rays took. A node, leaf or test that serves several rays at once counts once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct TraversalStats {
    /// Number of rays.
    pub rays: u64,
    /// Inner nodes visited, each with up to eight boxes. Leaves are not included.
    pub nodes: u64,
    /// Leaves visited, each with up to eight triangles.
    pub leaves: u64,
    /// Triangle tests: eight rays against one triangle, or one ray against up to eight. In scalar mode, one against
    /// one.
    pub tests: u64,
    /// Lanes of those tests in which the ray hits the triangle's box.
    pub lanes: u64,
}

/// Receives what a walk does. The implementation for `()` costs nothing.
pub(crate) trait Counter {
    /// Records a visit of an inner node.
    #[inline(always)]
    fn node(&mut self) {}
    /// Records a visit of a leaf.
    #[inline(always)]
    fn leaf(&mut self) {}
    /// Records one triangle test. `lanes` counts the useful lanes; it is called only when counting.
    #[inline(always)]
    fn test(&mut self, lanes: impl FnOnce() -> u32) {
        let _ = lanes;
    }
}

impl Counter for () {}

impl Counter for TraversalStats {
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
