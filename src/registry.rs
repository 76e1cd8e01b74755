//! The list of kernels. Everything in it is tested against its twin and the oracle, benchmarked, measured, charted
//! and selectable on the command line. `tests/registry.rs` fails if a kernel file is not in the list.
//!
//! A [`Visitor`] walks the list. Its method is generic over the kernel, so every inner loop stays monomorphic. To add
//! a kernel, write `src/kernels/<family>/<name>.rs`, name it in the family's `mod.rs`, and add one line here.

use glam::DVec3;

use crate::geom::{Aabb, Placed, Quadric, Triangle};
#[cfg(fused)]
use crate::kernels::aabb::Fused;
use crate::kernels::aabb::{CenterRadius, Division, Padded, Reciprocal, SignSelected, TwoUlp};
use crate::kernels::instance::{Baked, Instance, Inverse, SubtractFirstF64};
use crate::kernels::quadric::{Mixed, Naive, QuadricF64, QuadricInterval, Sphere, Stable};
use crate::kernels::triangle::{
    BaldwinWeber, Cramer, EmbreeMoller, EmbreePluecker, Exact, ExactHalfOpen, ExactT, KenslerShirley, MollerTrumbore,
    MollerTrumboreEpsilon, MollerTrumboreF64, Pluecker, Woop, WoopHalfOpen,
};
#[cfg(fused)]
use crate::kernels::triangle::{ExactFused, PbrtWoop, WoopDop};
use crate::kernels::{Kernel, Shape};

/// Something that is done with every kernel for shapes of type `S`.
pub trait Visitor<S: Shape> {
    /// Called once for each kernel, in the order of the list.
    fn visit<K: Kernel<Shape = S>>(&mut self);
}

/// The slab tests.
pub fn boxes(visitor: &mut impl Visitor<Aabb>) {
    visitor.visit::<Division<f32>>();
    visitor.visit::<Reciprocal<f32>>();
    visitor.visit::<SignSelected<f32>>();
    visitor.visit::<CenterRadius<f32>>();
    #[cfg(fused)]
    visitor.visit::<Fused<f32>>();
    visitor.visit::<TwoUlp<f32>>();
    visitor.visit::<Padded<f32>>();
}

/// The triangle tests. Each of them can drive the tracer.
pub fn triangles(visitor: &mut impl Visitor<Triangle>) {
    visitor.visit::<Cramer<f32>>();
    visitor.visit::<MollerTrumbore<f32>>();
    visitor.visit::<MollerTrumboreEpsilon<f32>>();
    visitor.visit::<KenslerShirley<f32>>();
    visitor.visit::<EmbreeMoller<f32>>();
    visitor.visit::<BaldwinWeber<f32>>();
    visitor.visit::<Pluecker<f32>>();
    visitor.visit::<EmbreePluecker<f32>>();
    visitor.visit::<Woop<f32>>();
    visitor.visit::<WoopHalfOpen<f32>>();
    #[cfg(fused)]
    visitor.visit::<WoopDop<f32>>();
    #[cfg(fused)]
    visitor.visit::<PbrtWoop<f32>>();
    visitor.visit::<MollerTrumboreF64<f32>>();
    visitor.visit::<Exact<f32>>();
    visitor.visit::<ExactHalfOpen<f32>>();
    visitor.visit::<ExactT<f32>>();
    #[cfg(fused)]
    visitor.visit::<ExactFused<f32>>();
}

/// The tests for surfaces of second degree. Each of them can drive the tracer.
pub fn quadrics(visitor: &mut impl Visitor<Quadric>) {
    visitor.visit::<Naive<f32>>();
    visitor.visit::<Sphere<f32>>();
    visitor.visit::<Stable<f32>>();
    visitor.visit::<QuadricInterval<f32>>();
    visitor.visit::<Mixed<f32>>();
    visitor.visit::<QuadricF64<f32>>();
}

/// Instances, to compare the methods of transforming. All methods of a shape have the same kernel inside: which kernel
/// is best inside an instance is what the study of the kernels themselves tells. One more instance is visited, the one
/// that the tracer has by default: `subtract_first` with `exact`.
pub fn instances<V>(visitor: &mut V)
where
    V: Visitor<Placed<Aabb>> + Visitor<Placed<Triangle>> + Visitor<Placed<Quadric>>,
{
    Placed::<Aabb>::visit_kernels(visitor);
    Placed::<Triangle>::visit_kernels(visitor);
    Placed::<Quadric>::visit_kernels(visitor);
}

/// A shape that has kernels.
pub trait Registered: Shape {
    /// Visits the shape's kernels, in the order of the list.
    fn visit_kernels(visitor: &mut impl Visitor<Self>);
}

impl Registered for Aabb {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        boxes(visitor);
    }
}

impl Registered for Triangle {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        triangles(visitor);
    }
}

impl Registered for Quadric {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        quadrics(visitor);
    }
}

impl Registered for Placed<Aabb> {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        ray_transforms::<Padded<f32>>(visitor);
    }
}

impl Registered for Placed<Triangle> {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        ray_transforms::<MollerTrumbore<f32>>(visitor);
        visitor.visit::<Baked<MollerTrumbore<f32>>>();
        visitor.visit::<Instance<Exact<f32>>>();
    }
}

impl Registered for Placed<Quadric> {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        ray_transforms::<Stable<f32>>(visitor);
    }
}

/// Visits an instance of `K` by each method that transforms the ray.
fn ray_transforms<K: Kernel>(visitor: &mut impl Visitor<Placed<K::Shape>>) {
    visitor.visit::<Instance<K>>();
    visitor.visit::<Instance<K, Inverse<f32>>>();
    visitor.visit::<Instance<K, SubtractFirstF64<DVec3>>>();
}

/// Every kernel.
pub fn all<V>(visitor: &mut V)
where
    V: Visitor<Aabb> + Visitor<Triangle> + Visitor<Quadric>,
    V: Visitor<Placed<Aabb>> + Visitor<Placed<Triangle>> + Visitor<Placed<Quadric>>,
{
    boxes(visitor);
    triangles(visitor);
    quadrics(visitor);
    instances(visitor);
}

/// A kernel that this build does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Absent {
    /// Its ID.
    pub id: &'static str,
    /// What the build lacks.
    pub reason: &'static str,
}

/// The kernels that this build does not have, each with the reason.
pub fn absent() -> &'static [Absent] {
    const REASON: &str = "needs fused multiply-add, which this build does not have (target features avx, fma)";
    const FUSED: [Absent; 4] = [
        Absent { id: "triangle/woop_dop", reason: REASON },
        Absent { id: "triangle/pbrt_woop", reason: REASON },
        Absent { id: "triangle/exact_fused", reason: REASON },
        Absent { id: "aabb/fused", reason: REASON },
    ];
    if cfg!(fused) { &[] } else { &FUSED }
}

/// Something that is done with one kernel for shapes of type `S`. The kernel is chosen by name at run time.
pub trait Task<S: Shape> {
    /// The result.
    type Output;

    /// Called with the chosen kernel.
    fn run<K: Kernel<Shape = S>>(self) -> Self::Output;
}

/// Runs the task with the kernel of this ID. The family may be left out of the ID. `None` if the shape has no such
/// kernel.
pub fn with_kernel<S: Registered, T: Task<S>>(id: &str, task: T) -> Option<T::Output> {
    struct Chosen<'a, T, O> {
        id: &'a str,
        task: Option<T>,
        output: Option<O>,
    }
    impl<S: Shape, T: Task<S>> Visitor<S> for Chosen<'_, T, T::Output> {
        fn visit<K: Kernel<Shape = S>>(&mut self) {
            let method = K::INFO.id.method;
            let name = method.rsplit('/').next();
            if self.id == method || Some(self.id) == name {
                self.output = self.task.take().map(T::run::<K>);
            }
        }
    }
    let mut chosen = Chosen { id, task: Some(task), output: None };
    S::visit_kernels(&mut chosen);
    chosen.output
}

/// The ID of a kernel that is named by its ID, or without its family. `None` if the shape has no such kernel.
pub fn id_of<S: Registered>(name: &str) -> Option<&'static str> {
    struct IdOf;
    impl<S: Shape> Task<S> for IdOf {
        type Output = &'static str;
        fn run<K: Kernel<Shape = S>>(self) -> &'static str {
            K::INFO.id.method
        }
    }
    with_kernel::<S, _>(name, IdOf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_found_by_id_and_by_name() {
        assert_eq!(id_of::<Triangle>("triangle/cramer"), Some("triangle/cramer"));
        assert_eq!(id_of::<Triangle>("moller_trumbore"), Some("triangle/moller_trumbore"));
        assert_eq!(id_of::<Triangle>("aabb/padded"), None);
        assert_eq!(id_of::<Triangle>("naive"), None);
        assert_eq!(id_of::<Quadric>("naive"), Some("quadric/naive"));
        assert_eq!(id_of::<Triangle>(""), None);
    }
}
