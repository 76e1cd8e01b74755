//! What a walk has still to visit.

/// A stack that grows before a node is opened, so that its children are put down without asking each time whether there is
/// room. It is kept from walk to walk.
#[derive(Debug)]
pub(super) struct Stack<T> {
    places: Vec<T>,
    top: usize,
}

impl<T: Copy> Stack<T> {
    pub(super) const fn new() -> Self {
        Self { places: Vec::new(), top: 0 }
    }

    /// Begins a walk, which may have ended early before.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.top = 0;
    }

    /// Room for a node's children; the places are filled with anything.
    #[inline(always)]
    pub(super) fn make_room(&mut self, anything: T) {
        if self.places.len() - self.top < 8 {
            self.grow(anything);
        }
    }

    #[cold]
    fn grow(&mut self, anything: T) {
        self.places.resize(2 * self.places.len() + 128, anything);
    }

    /// Puts something on top, to stay there only if it is kept: nothing branches.
    #[inline(always)]
    pub(super) fn push_if(&mut self, item: T, kept: bool) {
        self.places[self.top] = item;
        self.top += usize::from(kept);
    }

    /// Puts something on top of all that was put there since there were `base`, but below what comes `before` it.
    #[inline(always)]
    pub(super) fn insert_above(&mut self, base: usize, item: T, before: impl Fn(&T, &T) -> bool) {
        let mut at = self.top;
        while at > base && before(&self.places[at - 1], &item) {
            self.places[at] = self.places[at - 1];
            at -= 1;
        }
        self.places[at] = item;
        self.top += 1;
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.top
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<T> {
        self.top = self.top.checked_sub(1)?;
        Some(self.places[self.top])
    }
}
