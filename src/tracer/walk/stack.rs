//! The stack of subtrees that a walk has still to visit.

/// Capacity of a stack. A power of two: an index is then made valid by a mask and not by a branch. Single rays were 1.1
/// to 1.3 times as fast as with a vector.
const CAPACITY: usize = 512;

/// Memory for a stack, reused from walk to walk.
#[derive(Debug)]
pub(crate) struct StackStorage<T> {
    entries: Box<[T; CAPACITY]>,
    spilled: Vec<T>,
}

impl<T: Copy> StackStorage<T> {
    /// Allocates the memory. `filler` is the content of unused entries; nothing reads it.
    pub(crate) fn new(filler: T) -> Self {
        Self { entries: Box::new([filler; CAPACITY]), spilled: Vec::new() }
    }

    /// An empty stack in this memory.
    #[inline(always)]
    pub(crate) fn stack(&mut self) -> Stack<'_, T> {
        self.spilled.clear();
        Stack { entries: &mut self.entries, spilled: &mut self.spilled, top: 0 }
    }
}

/// A stack with one capacity check per node, in [`Stack::make_room`], instead of one per child.
///
/// It is a local variable of the walk, which keeps `top` in a register. Trees of real meshes stay within the capacity;
/// a deeper tree spills to the heap.
#[derive(Debug)]
pub(crate) struct Stack<'a, T> {
    entries: &'a mut [T; CAPACITY],
    spilled: &'a mut Vec<T>,
    top: usize,
}

impl<T: Copy> Stack<'_, T> {
    /// Makes room for eight children.
    #[inline(always)]
    pub(crate) fn make_room(&mut self) {
        if self.top + 8 >= CAPACITY {
            self.spill();
        }
    }

    #[cold]
    fn spill(&mut self) {
        self.spilled.extend_from_slice(&self.entries[..self.top]);
        self.top = 0;
    }

    #[cold]
    fn unspill(&mut self) -> Option<T> {
        self.spilled.pop()
    }

    /// Pushes `entry` if `condition` holds, without a branch.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, entry: T, condition: bool) {
        self.entries[self.top & (CAPACITY - 1)] = entry;
        self.top += usize::from(condition);
    }

    /// Number of entries, not counting spilled ones.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.top
    }

    /// Inserts `entry` above the first `base` entries. From the top down, entries for which `moves_up(it, entry)` holds
    /// move up by one; `entry` goes below them.
    #[inline(always)]
    pub(crate) fn insert_above(&mut self, base: usize, entry: T, moves_up: impl Fn(&T, &T) -> bool) {
        let mut at = self.top;
        while at > base && moves_up(&self.entries[(at - 1) & (CAPACITY - 1)], &entry) {
            self.entries[at & (CAPACITY - 1)] = self.entries[(at - 1) & (CAPACITY - 1)];
            at -= 1;
        }
        self.entries[at & (CAPACITY - 1)] = entry;
        self.top += 1;
    }

    /// Removes the topmost entry and returns it.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        if self.top == 0 {
            return self.unspill();
        }
        self.top -= 1;
        Some(self.entries[self.top & (CAPACITY - 1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_popped_last_in_first_out_also_after_spilling() {
        let mut storage = StackStorage::new(0);
        for round in 0..2 {
            let mut stack = storage.stack();
            for item in 0..10 * CAPACITY {
                stack.make_room();
                stack.push_if(item, true);
                stack.push_if(usize::MAX, false);
            }
            for item in (0..10 * CAPACITY).rev().take(if round == 0 { 3 * CAPACITY + 7 } else { 10 * CAPACITY }) {
                assert_eq!(stack.pop(), Some(item));
            }
            assert_eq!(stack.pop().is_none(), round == 1);
        }
    }

    #[test]
    fn inserted_entries_are_sorted_above_the_base() {
        let mut storage = StackStorage::new(0);
        let mut stack = storage.stack();
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
