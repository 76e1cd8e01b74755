//! Rays that fit no block: collected, sorted by octant, and traced as streams or packets.

use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::scene::{Scene, Scratch, Visible};
use crate::tracer::walk::filter::Filter;
use crate::tracer::walk::rays::{octant, packet};
use crate::tracer::walk::{Counter, stream};

/// Capacity in rays.
pub(super) const CAPACITY: usize = stream::RAYS;
// The number of a ray and its octant share 16 bits.
const _: () = assert!(8 * CAPACITY <= 1 << 16);

/// Numbers of rays that fit no block.
pub(super) struct IncoherentRays {
    /// Ray numbers, with the octant in the bits above.
    numbers: [u16; CAPACITY],
    len: usize,
    octant_lens: [usize; 8],
}

impl IncoherentRays {
    pub(super) fn new() -> Self {
        Self { numbers: [0; CAPACITY], len: 0, octant_lens: [0; 8] }
    }

    /// Adds the rays whose hits are not known yet. The first ray has the number `start`.
    pub(super) fn extend(&mut self, start: usize, rays: &[Ray<f32>], hits: &[Hit<f32>]) {
        for (index, ray) in rays.iter().enumerate() {
            if hits[index].mask {
                continue;
            }
            let octant = octant(ray);
            self.numbers[self.len % CAPACITY] = (octant * CAPACITY + start + index) as u16;
            self.octant_lens[octant] += 1;
            self.len += 1;
        }
    }

    /// Sorts by octant. Rays of one octant keep their order.
    pub(super) fn by_octant(&self) -> ByOctant {
        let (mut next, mut start) = ([0; 8], 0);
        for (next, len) in next.iter_mut().zip(self.octant_lens) {
            *next = start;
            start += len;
        }
        let mut numbers = [0; CAPACITY];
        for &number in &self.numbers[..self.len] {
            let place = &mut next[usize::from(number) / CAPACITY % 8];
            numbers[*place % CAPACITY] = number % CAPACITY as u16;
            *place += 1;
        }
        ByOctant { numbers, lens: self.octant_lens }
    }
}

/// Ray numbers, octant by octant.
pub(super) struct ByOctant {
    numbers: [u16; CAPACITY],
    /// Rays per octant.
    lens: [usize; 8],
}

impl ByOctant {
    /// Traces each octant as a stream.
    pub(super) fn trace_streams<const ANY: bool, K: Kernel<Shape = Triangle>>(
        &mut self,
        scene: &Scene<K>,
        filter: &impl Filter,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) {
        let mut rest = &mut self.numbers[..];
        for (octant, len) in self.lens.into_iter().enumerate() {
            let numbers = rest.split_off_mut(..len).unwrap_or_default();
            if !numbers.is_empty() {
                scene.trace_stream::<ANY>(rays, octant, numbers, hits, filter, scratch, counter);
            }
        }
    }

    /// Traces each octant as packets of eight.
    pub(super) fn trace_packets<const ANY: bool, K: Kernel<Shape = Triangle>>(
        &self,
        scene: &Scene<K>,
        visible: &Visible<impl Filter>,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) {
        let mut rest = &self.numbers[..];
        let octants = self.lens.map(|len| rest.split_off(..len).unwrap_or_default());
        for numbers in octants.into_iter().flat_map(|numbers| numbers.chunks(8)) {
            if let [number] = numbers {
                let number = usize::from(*number);
                hits[number] = scene.trace_single::<ANY>(&rays[number], visible, scratch, counter);
                continue;
            }
            let ray = packet(numbers.iter().map(|&number| &rays[usize::from(number)]));
            let mut lanes = [Hit::MISS; 8];
            scene.trace_packet::<ANY>(&ray, visible, scratch, counter).write(&mut lanes);
            for (hit, &number) in lanes.iter().zip(numbers) {
                hits[usize::from(number)] = *hit;
            }
        }
    }
}
