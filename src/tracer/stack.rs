//! What a walk has still to visit.

/// Places of a stack: a power of two, so that an index is made valid by a mask and not by a branch. Single rays were 1.1 to 1.3
/// times as fast as with a vector.
const PLACES: usize = 512;

/// Where stacks live, from walk to walk.
#[derive(Debug)]
pub(super) struct Places<T> {
    places: Box<[T; PLACES]>,
    spilled: Vec<T>,
}

impl<T: Copy> Places<T> {
    /// Filled with anything.
    pub(super) fn new(anything: T) -> Self {
        Self { places: Box::new([anything; PLACES]), spilled: Vec::new() }
    }

    /// An empty stack.
    #[inline(always)]
    pub(super) fn stack(&mut self) -> Stack<'_, T> {
        self.spilled.clear();
        Stack { places: &mut self.places, spilled: &mut self.spilled, top: 0 }
    }
}

/// A stack that makes room before a node is opened, so that its children are put down without asking each time. It is a
/// variable of the walk, so that its top stays in a register. Trees of real meshes stay within its places; one that does not
/// spills.
#[derive(Debug)]
pub(super) struct Stack<'a, T> {
    places: &'a mut [T; PLACES],
    spilled: &'a mut Vec<T>,
    top: usize,
}

impl<T: Copy> Stack<'_, T> {
    /// Makes room for a node's children.
    #[inline(always)]
    pub(super) fn make_room(&mut self) {
        if self.top + 8 >= PLACES {
            self.spill();
        }
    }

    #[cold]
    fn spill(&mut self) {
        self.spilled.extend_from_slice(&self.places[..self.top]);
        self.top = 0;
    }

    #[cold]
    fn unspill(&mut self) -> Option<T> {
        self.spilled.pop()
    }

    /// Puts something on top, to stay there only if it is kept: nothing branches.
    #[inline(always)]
    pub(super) fn push_if(&mut self, item: T, kept: bool) {
        self.places[self.top & (PLACES - 1)] = item;
        self.top += usize::from(kept);
    }

    /// How many there are, without what has been spilled.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.top
    }

    /// Puts something above the first `base`, and below all that comes `before` it.
    #[inline(always)]
    pub(super) fn insert_above(&mut self, base: usize, item: T, below: impl Fn(&T, &T) -> bool) {
        let mut at = self.top;
        while at > base && below(&self.places[(at - 1) & (PLACES - 1)], &item) {
            self.places[at & (PLACES - 1)] = self.places[(at - 1) & (PLACES - 1)];
            at -= 1;
        }
        self.places[at & (PLACES - 1)] = item;
        self.top += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<T> {
        if self.top == 0 {
            return self.unspill();
        }
        self.top -= 1;
        Some(self.places[self.top & (PLACES - 1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_down_comes_back_last_first_also_after_spilling() {
        let mut places = Places::new(0);
        for round in 0..2 {
            let mut stack = places.stack();
            for item in 0..10 * PLACES {
                stack.make_room();
                stack.push_if(item, true);
                stack.push_if(usize::MAX, false);
            }
            for item in (0..10 * PLACES).rev().take(if round == 0 { 3 * PLACES + 7 } else { 10 * PLACES }) {
                assert_eq!(stack.pop(), Some(item));
            }
            assert_eq!(stack.pop().is_none(), round == 1);
        }
    }

    #[test]
    fn what_is_inserted_is_sorted_above_the_base() {
        let mut places = Places::new(0);
        let mut stack = places.stack();
        for item in [5, 1] {
            stack.push_if(item, true);
        }
        let base = stack.len();
        for item in [3, 9, 2, 4] {
            stack.insert_above(base, item, |below, item| below < item);
        }
        let popped: Vec<_> = std::iter::from_fn(|| stack.pop()).collect();
        assert_eq!(popped, [2, 3, 4, 9, 1, 5]);
    }
}
