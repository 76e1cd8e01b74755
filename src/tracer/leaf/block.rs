//! The block walk in a leaf: each packet against the triangles whose boxes its interval may hit.

use wide::f32x8;

use super::mesh_tree::{MeshTree, Setup};
use super::scratch::TraversalScratch;
use crate::geom::lanes;
use crate::geom::{Candidate, Hit, Mask8, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::walk::Counter;
use crate::tracer::walk::block::{Block, Outcome, PACKETS};
use crate::tracer::walk::filter::Filter;
use crate::tracer::walk::packet::PacketRays;
use crate::tracer::walk::rays::{ANY_HIT, dir_is_neg};

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// Traces at most [`RAYS`](crate::tracer::walk::block::RAYS) rays as a block.
    ///
    /// With [`Outcome::Traced`], `hits` holds all hits. With another outcome it holds misses, and with `ANY` possibly
    /// some hits already.
    #[inline(always)]
    pub(crate) fn trace_block<const ANY: bool, T: Counter>(
        &self,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        filter: &impl Filter,
        scratch: &mut TraversalScratch,
        counter: &mut T,
    ) -> Outcome {
        if ANY {
            let (outcome, masks) = self.any_hit_block(rays, filter, scratch, counter);
            for (hits, mask) in hits.chunks_mut(8).zip(masks) {
                let bits = mask.bits();
                for (lane, hit) in hits.iter_mut().enumerate() {
                    *hit = if bits >> lane & 1 == 1 { ANY_HIT } else { Hit::MISS };
                }
            }
            return outcome;
        }
        let outcome = self.closest_hit_block(rays, hits, filter, scratch, counter);
        if outcome != Outcome::Traced {
            hits.fill(Hit::MISS);
        }
        outcome
    }

    #[inline(always)]
    fn closest_hit_block<T: Counter>(
        &self,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        filter: &impl Filter,
        TraversalScratch { block: storage, block_rays: block, .. }: &mut TraversalScratch,
        counter: &mut T,
    ) -> Outcome {
        let extremes = block.take(rays);
        if !block.bound(extremes, self.bvh.item_size) {
            return Outcome::Incoherent;
        }
        let mut search = BlockSearch::new(self, block, filter);
        let mut best = [Hit::<f32x8>::miss(); PACKETS];
        let mut any = false;
        let ended = self.bvh.walk_block::<false, T>(block, storage, counter, |leaf, packets, block, counter| {
            search.test_leaf(leaf, packets, block, counter, |packet, _, candidate, limit| {
                any = true;
                best[packet].keep_closer(candidate);
                lanes::min8(best[packet].t, limit)
            });
        });
        if !ended {
            return Outcome::GivenUp;
        }
        if any {
            for (hits, best) in hits.chunks_mut(8).zip(&best) {
                best.write(hits);
            }
        } else {
            hits.fill(Hit::MISS);
        }
        Outcome::Traced
    }

    /// The rays that hit anything: all of them with [`Outcome::Traced`], possibly some of them with another outcome.
    #[inline(always)]
    fn any_hit_block<T: Counter>(
        &self,
        rays: &[Ray<f32>],
        filter: &impl Filter,
        TraversalScratch { block: storage, block_rays: block, occluder, .. }: &mut TraversalScratch,
        counter: &mut T,
    ) -> (Outcome, [Mask8; PACKETS]) {
        let extremes = block.take(rays);
        let mut search = BlockSearch::new(self, block, filter);
        let mut found = [Mask8::none(); PACKETS];
        let mut keep = |packet: usize, candidate: &Candidate<f32x8>, limit: f32x8| {
            found[packet] = found[packet] | candidate.mask();
            candidate.mask().select(f32x8::splat(f32::NEG_INFINITY), limit)
        };
        if let Some((leaf, slot)) = occluder.take().filter(|&(leaf, _)| leaf < self.leaves.len()) {
            let hit = search.test_occluder(leaf, slot, block, counter, &mut keep);
            *occluder = hit.then_some((leaf, slot));
            if search.is_over() {
                return (Outcome::Traced, found);
            }
        }
        if !block.bound(extremes, self.bvh.item_size) {
            return (Outcome::Incoherent, found);
        }
        if occluder.is_some() {
            for (packet, &limit) in search.limits.iter().enumerate() {
                block.set_limit(packet, limit);
            }
        }
        let ended = self.bvh.walk_block::<true, T>(block, storage, counter, |leaf, packets, block, counter| {
            search.test_leaf(leaf, packets, block, counter, |packet, slot, candidate, limit| {
                *occluder = Some((leaf, slot));
                keep(packet, candidate, limit)
            });
        });
        (if ended { Outcome::Traced } else { Outcome::GivenUp }, found)
    }
}

/// The packets of a block on their way through a mesh. Per-ray data is computed at first use: many blocks reach no
/// triangle.
struct BlockSearch<'a, K: Kernel, F> {
    tree: &'a MeshTree<K>,
    filter: &'a F,
    setups: [Option<Setup<K, f32x8>>; PACKETS],
    rays: [Option<PacketRays>; PACKETS],
    /// The largest useful `t` of each ray.
    limits: [f32x8; PACKETS],
}

impl<'a, K: Kernel<Shape = Triangle>, F: Filter> BlockSearch<'a, K, F> {
    #[inline(always)]
    fn new(tree: &'a MeshTree<K>, block: &Block, filter: &'a F) -> Self {
        let [a, b, c, d, e, f, g, h] = &block.packets;
        Self {
            tree,
            filter,
            // Written one by one: `[None; 8]` would copy the whole array.
            setups: [None, None, None, None, None, None, None, None],
            rays: [None, None, None, None, None, None, None, None],
            limits: [a.t_max, b.t_max, c.t_max, d.t_max, e.t_max, f.t_max, g.t_max, h.t_max],
        }
    }

    /// Tests the triangles of a leaf. `packets` is a bit mask of the packets that may hit this leaf.
    ///
    /// For each candidate of [`MeshTree::test_packet`], `keep` gets the packet, the slot, the candidate and the largest
    /// useful `t`. It returns the new largest useful `t`.
    #[inline(always)]
    fn test_leaf<T: Counter>(
        &mut self,
        leaf: usize,
        mut packets: u32,
        block: &mut Block,
        counter: &mut T,
        mut keep: impl FnMut(usize, usize, &Candidate<f32x8>, f32x8) -> f32x8,
    ) {
        let (boxes, used) = (self.tree.boxes(leaf), (1 << self.tree.leaves[leaf].numbers.len()) - 1);
        let dir_is_neg = dir_is_neg(block.octant);
        while packets != 0 {
            let packet = packets.trailing_zeros() as usize & 7;
            packets &= packets - 1;
            let mut slots = block.boxes_hit_by(packet, &boxes, dir_is_neg) & used;
            let ray = &block.packets[packet];
            let setup = self.setups[packet].get_or_insert_with(|| Setup::<K, f32x8>::of(ray));
            let (mut limit, mut any) = (self.limits[packet], false);
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize & 7;
                slots &= slots - 1;
                block.tests += 1;
                // Without a common origin the interval is wide, and most of the boxes that it hits are missed by every
                // ray.
                if !block.one_origin {
                    let extent = &self.tree.bvh.extent;
                    let rays = self.rays[packet].get_or_insert_with(|| PacketRays::of(ray, &setup.slabs, extent));
                    if !rays.enter(&boxes, slot, dir_is_neg, limit).1.any() {
                        continue;
                    }
                }
                if let Some(candidate) = self.tree.test_packet(leaf, slot, &boxes, ray, setup, self.filter, counter) {
                    limit = keep(packet, slot, &candidate, limit);
                    any = true;
                }
            }
            if any {
                self.limits[packet] = limit;
                block.set_limit(packet, limit);
            }
        }
    }

    /// Tests one triangle against all packets, before the block is bounded. Returns whether there was a candidate.
    #[inline(always)]
    fn test_occluder<T: Counter>(
        &mut self,
        leaf: usize,
        slot: usize,
        block: &Block,
        counter: &mut T,
        mut keep: impl FnMut(usize, &Candidate<f32x8>, f32x8) -> f32x8,
    ) -> bool {
        let (boxes, mut any) = (self.tree.boxes(leaf), false);
        for packet in 0..PACKETS {
            let ray = &block.packets[packet];
            let setup = self.setups[packet].get_or_insert_with(|| Setup::<K, f32x8>::of(ray));
            if let Some(candidate) = self.tree.test_packet(leaf, slot, &boxes, ray, setup, self.filter, counter) {
                self.limits[packet] = keep(packet, &candidate, self.limits[packet]);
                any = true;
            }
        }
        any
    }

    /// Whether the search of every ray has ended.
    #[inline(always)]
    fn is_over(&self) -> bool {
        self.limits.iter().all(|&limit| lanes::eq8(limit, f32x8::splat(f32::NEG_INFINITY)).all())
    }
}
