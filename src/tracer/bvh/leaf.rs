//! A leaf of the tree: up to eight items.

/// A leaf: the numbers of up to eight items. Unused slots come last and hold [`Leaf::NONE`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf(pub(crate) [u32; 8]);

impl Leaf {
    pub(crate) const NONE: u32 = u32::MAX;

    /// The items in the used slots.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = u32> {
        self.0.into_iter().take_while(|&item| item != Self::NONE)
    }

    /// Number of used slots.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.0.iter().filter(|&&item| item != Self::NONE).count()
    }
}
