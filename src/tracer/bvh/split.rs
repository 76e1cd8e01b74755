//! Building a binary tree from the root down: items are sorted into bins along each axis, and split where that costs
//! least.
//!
//! **Source:** I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.
//!
//! **Differs from the paper:** few items are sorted and not binned, so every split between them is examined. Equal
//! items are split in half, and so are items where the tree would become deeper than [`MAX_DEPTH`]. So the time is at
//! most proportional to the number of items times that depth, whatever the items are.

use glam::{Vec3, Vec3A};

use super::binary::{BinaryNode, BinaryTree, half_area};
use crate::geom::Aabb;

/// The greatest depth of a tree. It leaves room for 2³² items, and trees of real meshes stay below it.
pub(super) const MAX_DEPTH: u32 = 96;

/// Number of bins along each axis.
const BINS: usize = 32;

/// Up to this many items are sorted.
const SORTED: usize = 8;

/// From this many items on, both halves are built at the same time.
const PARALLEL: usize = 4096;

/// An item that is being sorted into the tree.
#[derive(Clone, Copy, Debug)]
struct Item {
    lo: Vec3A,
    hi: Vec3A,
    number: u32,
}

impl Item {
    /// Half the centre of the box. Neither it nor the distance of two of them overflows.
    #[inline(always)]
    fn middle(&self) -> Vec3A {
        self.lo * 0.25 + self.hi * 0.25
    }
}

/// A box in registers.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    lo: Vec3A,
    hi: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY };

    #[inline(always)]
    fn union(self, lo: Vec3A, hi: Vec3A) -> Self {
        Self { lo: self.lo.min(lo), hi: self.hi.max(hi) }
    }

    fn aabb(self) -> Aabb {
        Aabb { lo: self.lo.into(), hi: self.hi.into() }
    }

    #[inline(always)]
    fn half_area(self) -> f64 {
        half_area(&self.aabb())
    }
}

/// Builds a tree over `count` items, at least one.
pub(super) fn split(count: usize, bounds_of: impl Fn(u32) -> Aabb + Sync) -> BinaryTree {
    // A side of a box may be infinite.
    let finite = |point: Vec3| Vec3A::from(point.clamp(Vec3::MIN, Vec3::MAX));
    let item = |number| {
        let Aabb { lo, hi } = bounds_of(number);
        Item { lo: finite(lo), hi: finite(hi), number }
    };
    let mut items: Vec<_> = (0..count as u32).map(item).collect();
    let mut nodes = vec![BinaryNode::of_item(0, Aabb::EMPTY); 2 * count - 1];
    let (root, below) = nodes.split_first_mut().expect("at least one item");
    build(&mut items, root, below, 1, 0);
    BinaryTree { nodes }
}

/// Builds the tree over `items` in `root` and `below`. `first` is the index of the first node of `below`.
fn build(items: &mut [Item], root: &mut BinaryNode, below: &mut [BinaryNode], first: usize, depth: u32) {
    let (mut bounds, mut middles) = (Bounds::EMPTY, Bounds::EMPTY);
    for item in &*items {
        bounds = bounds.union(item.lo, item.hi);
        middles = middles.union(item.middle(), item.middle());
    }
    if let [item] = items {
        *root = BinaryNode::of_item(item.number, bounds.aabb());
        return;
    }
    *root = BinaryNode::of_children(first as u32, bounds.aabb());
    let middle = divide(items, middles, depth);
    let (left, right) = items.split_at_mut(middle);
    let (children, below) = below.split_at_mut(2);
    let [left_root, right_root] = children else { unreachable!("two children were split off") };
    let (below_left, below_right) = below.split_at_mut(2 * left.len() - 2);
    let (first_left, first_right) = (first + 2, first + 2 * left.len());
    if left.len() + right.len() >= PARALLEL {
        rayon::join(
            || build(left, left_root, below_left, first_left, depth + 1),
            || build(right, right_root, below_right, first_right, depth + 1),
        );
    } else {
        build(left, left_root, below_left, first_left, depth + 1);
        build(right, right_root, below_right, first_right, depth + 1);
    }
}

/// Reorders the items and returns where to split them. `middles` is a box around their middles.
fn divide(items: &mut [Item], middles: Bounds, depth: u32) -> usize {
    let half = items.len() / 2;
    let extent = middles.hi - middles.lo;
    // A tree over so many items that is split in half from here on has the greatest depth.
    if depth + items.len().next_power_of_two().ilog2() >= MAX_DEPTH {
        let axis = extent.max_position();
        items.select_nth_unstable_by(half, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
        return half;
    }
    if extent.max_element() <= 0.0 {
        half
    } else if items.len() <= SORTED {
        divide_sorted(items)
    } else {
        divide_binned(items, middles.lo, extent)
    }
}

fn sort_along(items: &mut [Item], axis: usize) {
    items.sort_unstable_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.number.cmp(&b.number)));
}

/// Sorts the items along the best axis and returns the best place to split.
fn divide_sorted(items: &mut [Item]) -> usize {
    let count = items.len();
    let mut best = (f64::INFINITY, 0, count / 2);
    for axis in 0..3 {
        sort_along(items, axis);
        let mut right_areas = [0.0; SORTED];
        let mut right = Bounds::EMPTY;
        for index in (1..count).rev() {
            right = right.union(items[index].lo, items[index].hi);
            right_areas[index] = right.half_area();
        }
        let mut left = Bounds::EMPTY;
        for index in 1..count {
            left = left.union(items[index - 1].lo, items[index - 1].hi);
            let cost = left.half_area() * index as f64 + right_areas[index] * (count - index) as f64;
            if cost < best.0 {
                best = (cost, axis, index);
            }
        }
    }
    let axis = best.1;
    if axis != 2 {
        sort_along(items, axis);
    }
    best.2
}

/// A bin along an axis.
#[derive(Clone, Copy, Debug)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

/// Sorts the items into bins, divides them between the two bins where that costs least, and returns the number on the
/// left. `least` and `extent` are of the items' middles.
fn divide_binned(items: &mut [Item], least: Vec3A, extent: Vec3A) -> usize {
    let scale = Vec3A::splat(BINS as f32) / extent;
    // Along an axis without extent this is 0 times infinity, a NaN: bin 0.
    let bin_of = |item: &Item| {
        let at = (item.middle() - least) * scale;
        [at.x, at.y, at.z].map(|at| (at as usize).min(BINS - 1))
    };
    let mut bins = [[Bin { bounds: Bounds::EMPTY, count: 0 }; BINS]; 3];
    for item in &*items {
        for (bins, bin) in bins.iter_mut().zip(bin_of(item)) {
            bins[bin].bounds = bins[bin].bounds.union(item.lo, item.hi);
            bins[bin].count += 1;
        }
    }
    let mut best = (f64::INFINITY, 0, 0);
    for (axis, bins) in bins.iter().enumerate() {
        let mut right_costs = [0.0; BINS];
        let (mut right, mut count) = (Bounds::EMPTY, 0);
        for index in (1..BINS).rev() {
            right = right.union(bins[index].bounds.lo, bins[index].bounds.hi);
            count += bins[index].count;
            right_costs[index] = if count == 0 { f64::INFINITY } else { right.half_area() * f64::from(count) };
        }
        let (mut left, mut count) = (Bounds::EMPTY, 0);
        for index in 1..BINS {
            left = left.union(bins[index - 1].bounds.lo, bins[index - 1].bounds.hi);
            count += bins[index - 1].count;
            let cost =
                if count == 0 { f64::INFINITY } else { left.half_area() * f64::from(count) } + right_costs[index];
            if cost < best.0 {
                best = (cost, axis, index);
            }
        }
    }
    let (_, axis, split) = best;
    partition(items, |item| bin_of(item)[axis] < split)
}

/// Moves the items that belong to the left before the others. Returns their number.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut end) = (0, items.len());
    while left < end {
        if is_left(&items[left]) {
            left += 1;
        } else {
            end -= 1;
            items.swap(left, end);
        }
    }
    left
}
