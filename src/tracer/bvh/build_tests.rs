//! Trees over items of every kind, also where a builder can go wrong: equal, nested and collinear items, sizes that
//! differ by many powers of ten.

use std::time::{Duration, Instant};

use glam::Vec3;

use super::split::MAX_DEPTH;
use super::{Bvh, Leaf};
use crate::geom::Aabb;
use crate::tracer::meshes::generator::{hash, unit_interval};

/// A number from -1 to 1.
fn random(item: u32, number: u32) -> f32 {
    2.0 * unit_interval(hash(item, number, 7)) - 1.0
}

fn random_point(item: u32) -> Vec3 {
    Vec3::new(random(item, 0), random(item, 1), random(item, 2))
}

fn around(center: Vec3, half: f32) -> Aabb {
    Aabb { lo: center - half, hi: center + half }
}

fn ordinary(item: u32) -> Aabb {
    around(random_point(item), 0.01 * (1.5 + random(item, 3)))
}

/// The box of an item.
type BoundsOf = fn(u32) -> Aabb;

const KINDS: [(&str, BoundsOf); 14] = [
    ("ordinary", ordinary),
    ("equal", |_| around(Vec3::ONE, 1.0)),
    ("points at one place", |_| around(Vec3::ONE, 0.0)),
    ("points", |item| around(random_point(item), 0.0)),
    ("nested", |item| around(Vec3::ZERO, 1.0 + item as f32 * 1e-6)),
    ("nested, of all sizes", |item| around(Vec3::ZERO, f32::from_bits(item.wrapping_mul(4001) % 0x7f00_0000))),
    ("collinear", |item| around(Vec3::X * item as f32, 0.5)),
    ("a fan", |item| Aabb::EMPTY.including(Vec3::ZERO).including(Vec3::Z).including(random_point(item))),
    ("ever closer together", |item| around(Vec3::X * 0.9_f32.powi(item as i32 % 900), 0.0)),
    ("clusters", |item| around(random_point(item % 5) + random_point(item) * 1e-6, 1e-7)),
    ("small ones on a large ground", |item| {
        if item < 2 { around(Vec3::X * item as f32, 1e6) } else { around(random_point(item) * 0.05, 1e-3) }
    }),
    ("far away", |item| around(Vec3::splat(1e5) + random_point(item), 0.01)),
    ("of all sizes", |item| around(random_point(item) * 1e30, 10_f32.powi(item as i32 % 68 - 38))),
    ("without end", |item| Aabb { lo: random_point(item), hi: Vec3::splat(f32::INFINITY) }),
];

/// Checks the tree and returns its depth.
fn check(what: &str, count: u32, bounds_of: BoundsOf) -> usize {
    let what = format!("{count} items, {what}");
    let tree = Bvh::build(count as usize, bounds_of);
    let mut depth = vec![0; tree.nodes.len()];
    let mut deepest = 0;
    let mut seen = vec![0; count as usize];
    let mut check_leaf = |leaf: &Leaf, bounds: &Aabb| {
        assert!(leaf.len() > 0, "{what}: an empty leaf");
        for item in leaf.numbers() {
            seen[item as usize] += 1;
        }
        assert_eq!(*bounds, leaf.numbers().fold(Aabb::EMPTY, |bounds, item| bounds.union(&bounds_of(item))), "{what}");
    };
    if let Ok(leaf) = tree.root.leaf() {
        check_leaf(&tree.leaves[leaf], &tree.extent.bounds);
    }
    for (number, node) in tree.nodes.iter().enumerate() {
        deepest = deepest.max(depth[number] + 1);
        let mut children = 0;
        for (slot, child) in node.children.into_iter().enumerate() {
            let lane = node.boxes.lane(slot);
            let bounds = Aabb { lo: lane.lo, hi: lane.hi };
            match child.leaf() {
                Ok(leaf) => check_leaf(&tree.leaves[leaf], &bounds),
                Err(0) => {
                    assert_eq!(bounds, Aabb::EMPTY, "{what}: an unused slot");
                    continue;
                }
                Err(child) => {
                    assert!(child > number && depth[child] == 0, "{what}: child {child} of {number}");
                    depth[child] = depth[number] + 1;
                    assert_eq!(bounds, tree.nodes[child].boxes.union(), "{what}");
                }
            }
            children += 1;
        }
        assert!(children >= 2, "{what}: node {number} has {children} children");
    }
    assert_eq!(seen.iter().find(|&&times| times != 1), None, "{what}: an item is not in the tree exactly once");
    assert!(deepest <= MAX_DEPTH as usize, "{what}: depth {deepest}");
    deepest
}

#[test]
fn trees_hold_every_item_once_and_stay_flat() {
    for (what, bounds_of) in KINDS {
        for count in [1, 2, 3, 7, 8, 9, 17, 64, 100, 513, 4096, 20_000] {
            check(what, count, bounds_of);
        }
    }
}

/// Nothing distinguishes these items, so halves are best.
#[test]
fn trees_over_equal_items_are_balanced() {
    for (what, bounds_of) in &KINDS[1..3] {
        assert!(check(what, 32_768, *bounds_of) <= 5, "{what}");
    }
}

/// The time to build a tree grows with the number of items, and little depends on what they are. A build that takes
/// time in proportion to the square would take a thousand times as long.
#[test]
fn no_kind_of_items_takes_long() {
    const COUNT: usize = 200_000;
    let time = |bounds_of: BoundsOf| {
        let start = Instant::now();
        Bvh::build(COUNT, bounds_of);
        start.elapsed()
    };
    // A machine that does other work at the same time slows down single builds.
    let least = |bounds_of: BoundsOf| (0..3).map(|_| time(bounds_of)).min().unwrap_or_default();
    let ordinary = least(ordinary).max(Duration::from_millis(10));
    for (what, bounds_of) in KINDS {
        let taken = least(bounds_of);
        println!("{what}: {:.2} of the time of ordinary items", taken.as_secs_f64() / ordinary.as_secs_f64());
        assert!(taken < 5 * ordinary, "{what}: {taken:?}, ordinary items: {ordinary:?}");
    }
}
