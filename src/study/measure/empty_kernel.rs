//! A kernel whose test is one comparison that never holds. Timed like the others, it shows what the timed loop itself
//! takes: reading rays and primitives, keeping the closest hit, and writing it.

use wide::f32x8;

use crate::geom::lanes::{Lanes, lt8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Info, Intersect, Kernel};

/// The kernel. It is not registered.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmptyKernel<P: Lanes> {
    /// Less than any distance. The compiler cannot know that, because it is read from memory.
    never: P,
}

impl Kernel for EmptyKernel<f32> {
    type Shape = Triangle;
    type Packet = EmptyKernel<f32x8>;
    const INFO: Info = Info::new("loop", "one comparison that never holds", "");

    fn prepare(_: &Triangle) -> Self {
        Self { never: f32::NEG_INFINITY }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        EmptyKernel { never: f32x8::new(primitives.map(|one| one.never)) }
    }

    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        Self { never: packet.never.as_array()[lane] }
    }
}

impl Intersect<f32> for EmptyKernel<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        Candidate::<f32>::new(ray.t_max < self.never, ray.t_max, 0.0, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for EmptyKernel<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        Candidate::<f32x8>::new(lt8(ray.t_max, self.never.widen()), ray.t_max, f32x8::ZERO, f32x8::ZERO)
    }
}
