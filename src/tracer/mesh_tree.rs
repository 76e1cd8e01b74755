//! One mesh's prepared triangles and the tree over them, in the mesh's own coordinates.

use wide::{f32x8, u32x8};

use super::Mesh;
use super::box_rule::Span;
use super::block::{self, Bundle, PACKETS, RAYS};
use super::bvh::Bvh;
use super::bvh8::{Bvh8, Costs, Leaf};
use super::single::{self, SingleRay};
use super::traverse::{Room, Visit, keep_closer8};
use crate::geom::{Hit, Lanes, Mask8, Ray, Triangle, lanes};
use crate::kernels::aabb::{InverseDirection, Slabs};
use crate::kernels::{Intersect, Kernel};

/// What the kernel `K` needs to trace a mesh. The mesh itself stays where it is, and is handed to every call.
#[derive(Debug)]
pub(super) struct MeshTree<K: Kernel> {
    bvh: Bvh,
    bvh8: Bvh8,
    /// Eight for each leaf.
    one: Vec<[K; 8]>,
    /// The same, gathered.
    eight: Vec<K::Packet>,
    /// In slot order.
    prepared: Vec<K>,
}

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// Builds the tree and prepares the triangles, on all threads of the current rayon pool.
    pub(super) fn new(mesh: &Mesh) -> Self {
        use rayon::prelude::*;

        // Packets test a few triangles faster than the boxes of more nodes.
        let bvh = Bvh::build(mesh.len(), 4, |primitive| mesh.triangle(primitive).bounds());
        let prepared = bvh.item_of_slot.par_iter().map(|&primitive| K::prepare(&mesh.triangle(primitive))).collect();
        let start = std::time::Instant::now();
        let var = |n: &str, d: f32| std::env::var(n).map_or(d, |v| v.parse().unwrap());
        let bvh8 = Bvh8::build(mesh.len(), Costs { node: var("CN", 1.0), leaf: var("CL", 1.0), item: var("CI", 0.05) }, |primitive| mesh.triangle(primitive).bounds());
        let one: Vec<[K; 8]> = bvh8
            .leaves
            .par_iter()
            .map(|leaf| {
                leaf.items.map(|item| {
                    let nan = glam::Vec3::NAN;
                    let none = Triangle { v0: nan, v1: nan, v2: nan };
                    K::prepare(&if item == Leaf::NONE { none } else { mesh.triangle(item) })
                })
            })
            .collect();
        let eight = one.par_iter().map(K::gather).collect();
        if std::env::var("V").is_ok() {
            eprintln!("bvh8: {} nodes, {} leaves, {:.2} items per leaf, depth {}, {:.3} s", bvh8.nodes.len(), bvh8.leaves.len(), mesh.len() as f32 / bvh8.leaves.len() as f32, bvh8.depth, start.elapsed().as_secs_f64());
        }
        Self { bvh, prepared, bvh8, one, eight }
    }

    pub(super) fn single_closest(&self, rays: &[Ray<f32>], hits: &mut [Hit<f32>]) {
        let mut room = single::EMPTY;
        for (ray, hit) in rays.iter().zip(hits) {
            let walk = SingleRay::of(ray, &self.bvh8.bounds);
            let eight = Ray::splat(ray);
            let setup = <K as Intersect<f32x8>>::setup(&eight);
            *hit = self.bvh8.closest_hit1(&walk, Hit::MISS, &mut room, |leaf, best| {
                let hit = self.eight[leaf].closest_hit(&eight, &setup);
                if hit.mask.any() {
                    let closest = self.by_box_rule(hit, leaf, &walk).closest();
                    if closest.is_closer_than(best) {
                        *best = Hit { instance: 0, ..closest };
                    }
                }
            });
            if !hit.mask {
                *hit = Hit::MISS;
            }
        }
    }

    #[inline(always)]
    fn by_box_rule(&self, hit: Hit<f32x8>, leaf: usize, walk: &SingleRay) -> Hit<f32x8> {
        let leaf = &self.bvh8.leaves[leaf];
        let (inside, span) = Span::<f32x8>::of_boxes(&leaf.boxes.slabs(), walk.origin, &walk.slabs);
        let mask = hit.mask & inside;
        Hit {
            mask,
            t: mask.select(span.clamp(hit.t), f32x8::splat(f32::INFINITY)),
            u: hit.u,
            v: hit.v,
            primitive: u32x8::new(leaf.items),
            instance: hit.instance,
        }
    }

    pub(super) fn single_any(&self, rays: &[Ray<f32>], hits: &mut [Hit<f32>]) {
        let mut room = single::EMPTY;
        for (ray, hit) in rays.iter().zip(hits) {
            let walk = SingleRay::of(ray, &self.bvh8.bounds);
            let eight = Ray::splat(ray);
            let setup = <K as Intersect<f32x8>>::setup(&eight);
            let found = self.bvh8.any_hit1(&walk, &mut room, |leaf| {
                let hit = self.eight[leaf].closest_hit(&eight, &setup);
                hit.mask.any() && self.by_box_rule(hit, leaf, &walk).mask.any()
            });
            *hit = Hit::<f32>::new(found, 0.0, 0.0, 0.0);
        }
    }

    pub(super) fn block_closest(&self, rays: &[Ray<f32>], hits: &mut [Hit<f32>]) {
        let mut room = block::EMPTY;
        let inactive = Ray::splat(&Ray::INACTIVE);
        let mut packets = [inactive; PACKETS];
        let mut best = [Hit::<f32x8>::miss(); PACKETS];
        let mut setups = [Setup::<K, f32x8>::of(&inactive); PACKETS];
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            let octant = |ray: &Ray<f32>| ray.dir.to_array().map(f32::is_sign_negative);
            if !rays.iter().all(|ray| octant(ray) == octant(&rays[0])) {
                self.single_closest(rays, hits);
                continue;
            }
            let mut bundle = Bundle::of(rays, &mut packets);
            for packet in 0..PACKETS {
                setups[packet] = Setup::<K, f32x8>::of(&packets[packet]);
                best[packet] = Hit::<f32x8>::miss();
            }
            self.bvh8.walk_block::<true>(&mut bundle, &mut room, |leaf, mut mask, bundle| {
                let nodes = &self.bvh8.leaves[leaf];
                let one = &self.one[leaf];
                let mut changed = false;
                while mask != 0 {
                    let packet = mask.trailing_zeros() as usize & 7;
                    mask &= mask - 1;
                    let mut lanes = bundle.boxes_hit_by(packet, &nodes.boxes);
                    let (ray, setup) = (&packets[packet], &setups[packet]);
                    let mut found = false;
                    while lanes != 0 {
                        let lane = lanes.trailing_zeros() as usize & 7;
                        lanes &= lanes - 1;
                        let hit = Intersect::<f32x8>::closest_hit(&one[lane], ray, &setup.kernel);
                        if hit.mask.any() {
                            let (inside, span) = Span::<f32x8>::of(&nodes.boxes.lane(lane), ray.origin, &setup.slabs);
                            let candidate = Hit {
                                mask: hit.mask & inside,
                                t: span.clamp(hit.t),
                                u: hit.u,
                                v: hit.v,
                                primitive: u32x8::splat(nodes.items[lane]),
                                instance: hit.instance,
                            };
                            keep_closer8(&mut best[packet], &candidate);
                            found = true;
                        }
                    }
                    if found {
                        let limit = lanes::min8(best[packet].t, setup.slabs.t_max).to_array();
                        bundle.set_limit(packet, limit.into_iter().fold(f32::NEG_INFINITY, lanes::max));
                        changed = true;
                    }
                }
                if changed {
                    bundle.update_whole();
                }
            });
            for (hits, best) in hits.chunks_mut(8).zip(&best) {
                for (hit, lane) in hits.iter_mut().zip(best.lanes()) {
                    *hit = lane;
                }
            }
        }
    }

    pub(super) fn block_any(&self, rays: &[Ray<f32>], hits: &mut [Hit<f32>]) {
        let mut room = block::EMPTY;
        let inactive = Ray::splat(&Ray::INACTIVE);
        let mut packets = [inactive; PACKETS];
        let mut setups = [Setup::<K, f32x8>::of(&inactive); PACKETS];
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            let octant = |ray: &Ray<f32>| ray.dir.to_array().map(f32::is_sign_negative);
            if !rays.iter().all(|ray| octant(ray) == octant(&rays[0])) {
                self.single_any(rays, hits);
                continue;
            }
            let mut bundle = Bundle::of(rays, &mut packets);
            let mut limits = [f32x8::ZERO; PACKETS];
            let mut found = [Mask8::none(); PACKETS];
            for packet in 0..PACKETS {
                setups[packet] = Setup::<K, f32x8>::of(&packets[packet]);
                limits[packet] = setups[packet].slabs.t_max;
            }
            self.bvh8.walk_block::<false>(&mut bundle, &mut room, |leaf, mut mask, bundle| {
                let nodes = &self.bvh8.leaves[leaf];
                let one = &self.one[leaf];
                let mut changed = false;
                while mask != 0 {
                    let packet = mask.trailing_zeros() as usize & 7;
                    mask &= mask - 1;
                    let mut lanes = bundle.boxes_hit_by(packet, &nodes.boxes);
                    let (ray, setup) = (&packets[packet], &setups[packet]);
                    let mut any = false;
                    while lanes != 0 {
                        let lane = lanes.trailing_zeros() as usize & 7;
                        lanes &= lanes - 1;
                        let hit = Intersect::<f32x8>::closest_hit(&one[lane], ray, &setup.kernel);
                        if hit.mask.any() {
                            let (inside, _) = Span::<f32x8>::of(&nodes.boxes.lane(lane), ray.origin, &setup.slabs);
                            found[packet] = found[packet] | (hit.mask & inside);
                            any = true;
                        }
                    }
                    if any {
                        limits[packet] = found[packet].select(f32x8::splat(f32::NEG_INFINITY), limits[packet]);
                        bundle.set_limit(packet, limits[packet].to_array().into_iter().fold(f32::NEG_INFINITY, lanes::max));
                        changed = true;
                    }
                }
                if changed {
                    bundle.update_whole();
                }
            });
            for (hits, found) in hits.chunks_mut(8).zip(&found) {
                let bits = found.bits();
                for (lane, hit) in hits.iter_mut().enumerate() {
                    *hit = Hit::<f32>::new(bits >> lane & 1 == 1, 0.0, 0.0, 0.0);
                }
            }
        }
    }

    /// Bytes of nodes and prepared triangles, without the mesh.
    pub(super) fn bytes(&self) -> usize {
        self.bvh.bytes() + size_of_val(&self.prepared[..])
    }

    /// The closest hit, if its `t` is at most `farthest`; else that, or a hit beyond `farthest`, or a miss. As a call it
    /// would be a tenth slower for single rays.
    #[inline(always)]
    pub(super) fn closest_hit(
        &self,
        mesh: &Mesh,
        ray: &Ray<f32>,
        farthest: f32,
        room: &mut Room<Visit<f32>>,
    ) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        let nothing = Hit { t: farthest, ..Hit::MISS };
        self.bvh.closest_hit(ray, &setup.slabs, nothing, room, |slot, best| {
            if let Some(candidate) = self.candidate(mesh, slot, ray, &setup)
                && candidate.is_closer_than(best)
            {
                *best = candidate;
            }
        })
    }

    /// Whether there is a hit.
    pub(super) fn any_hit(&self, mesh: &Mesh, ray: &Ray<f32>) -> bool {
        let setup = Setup::<K, f32>::of(ray);
        self.bvh.any_hit(ray, &setup.slabs, |slot| self.candidate(mesh, slot, ray, &setup).is_some())
    }

    /// [`MeshTree::closest_hit`] in eight lanes.
    #[inline(always)]
    pub(super) fn closest_hit8(
        &self,
        mesh: &Mesh,
        ray: &Ray<f32x8>,
        farthest: f32x8,
        room: &mut Room<Visit<f32x8>>,
    ) -> Hit<f32x8> {
        let setup = Setup::<K, f32x8>::of(ray);
        let mut nothing = Hit::<f32x8>::miss();
        nothing.t = farthest;
        self.bvh.closest_hit8(ray, &setup.slabs, nothing, room, |slot, best| {
            if let Some(candidate) = self.candidate8(mesh, slot, ray, &setup) {
                keep_closer8(best, &candidate);
            }
        })
    }

    /// [`MeshTree::any_hit`] in eight lanes.
    pub(super) fn any_hit8(&self, mesh: &Mesh, ray: &Ray<f32x8>) -> Mask8 {
        let setup = Setup::<K, f32x8>::of(ray);
        self.bvh.any_hit8(ray, &setup.slabs, |slot, _| Some(self.candidate8(mesh, slot, ray, &setup)?.mask))
    }

    /// The closest hit by trying every triangle, in any order.
    pub(super) fn closest_hit_brute_force(&self, mesh: &Mesh, ray: &Ray<f32>) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        (0..self.prepared.len())
            .filter_map(|slot| self.candidate(mesh, slot, ray, &setup))
            .fold(Hit::MISS, |best, candidate| if candidate.is_closer_than(&best) { candidate } else { best })
    }

    /// The triangle in a slot, by the box rule.
    #[inline(always)]
    fn candidate(&self, mesh: &Mesh, slot: usize, ray: &Ray<f32>, setup: &Setup<K, f32>) -> Option<Hit<f32>> {
        let hit = self.prepared[slot].closest_hit(ray, &setup.kernel);
        if !hit.mask {
            return None;
        }
        let (primitive, bounds) = self.own_box(mesh, slot);
        let span = Span::<f32>::of(&bounds, ray.origin, &setup.slabs)?;
        Some(Hit { t: span.clamp(hit.t), primitive, ..hit })
    }

    /// [`MeshTree::candidate`] in eight lanes. Lanes that miss hold anything, not the fixed content of a miss.
    #[inline(always)]
    fn candidate8(&self, mesh: &Mesh, slot: usize, ray: &Ray<f32x8>, setup: &Setup<K, f32x8>) -> Option<Hit<f32x8>> {
        let hit = Intersect::<f32x8>::closest_hit(&self.prepared[slot], ray, &setup.kernel);
        if !hit.mask.any() {
            return None;
        }
        let (primitive, bounds) = self.own_box(mesh, slot);
        let (inside, span) = Span::<f32x8>::of(&bounds, ray.origin, &setup.slabs);
        Some(Hit {
            mask: hit.mask & inside,
            t: span.clamp(hit.t),
            u: hit.u,
            v: hit.v,
            primitive: u32x8::splat(primitive),
            instance: hit.instance,
        })
    }

    /// The primitive in a slot, and the box of its triangle.
    #[inline(always)]
    fn own_box(&self, mesh: &Mesh, slot: usize) -> (u32, Slabs<f32>) {
        let primitive = self.bvh.item_of_slot[slot];
        (primitive, mesh.triangle(primitive).bounds().into())
    }
}

/// The per-ray data of the tree and of the kernel.
#[derive(Clone, Copy)]
struct Setup<K: Intersect<L>, L: Lanes> {
    slabs: InverseDirection<L>,
    kernel: K::Setup,
}

impl<K: Intersect<f32>> Setup<K, f32> {
    #[inline(always)]
    fn of(ray: &Ray<f32>) -> Self {
        Self { slabs: InverseDirection::<f32>::of(ray), kernel: K::setup(ray) }
    }
}

impl<K: Intersect<f32x8>> Setup<K, f32x8> {
    #[inline(always)]
    fn of(ray: &Ray<f32x8>) -> Self {
        Self { slabs: InverseDirection::<f32x8>::of(ray), kernel: K::setup(ray) }
    }
}
