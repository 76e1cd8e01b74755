//! The list of kernels. Whatever is named here is tested against its twin and the oracle, benchmarked, measured, charted
//! and selectable on the command line; `tests/registry.rs` fails for a kernel file that is not.
//!
//! The list is walked by a [`Visitor`], whose method is generic over the kernel, so that every inner loop stays
//! monomorphic. To add a kernel, write `src/kernels/<family>/<name>.rs`, name it in the family's `mod.rs`, and add one
//! line here.

use crate::geom::{Aabb, Placed, Triangle};
use crate::kernels::aabb::{Division, Padded, Reciprocal, SignSelected};
use crate::kernels::instance::Instance;
use crate::kernels::triangle::{Cramer, MollerTrumbore};
use crate::kernels::{Kernel, Shape};

/// Something done with every kernel for shapes of type `S`.
pub trait Visitor<S: Shape> {
    /// Called once for each kernel, in the order of the list.
    fn visit<K: Kernel<Shape = S>>(&mut self);
}

/// The slab tests.
pub fn boxes(visitor: &mut impl Visitor<Aabb>) {
    visitor.visit::<Division<f32>>();
    visitor.visit::<Reciprocal<f32>>();
    visitor.visit::<SignSelected<f32>>();
    visitor.visit::<Padded<f32>>();
}

/// The triangle tests; every one of them can drive the tracer.
pub fn triangles(visitor: &mut impl Visitor<Triangle>) {
    visitor.visit::<Cramer<f32>>();
    visitor.visit::<MollerTrumbore<f32>>();
}

/// An instance of each kernel.
pub fn instances(visitor: &mut (impl Visitor<Placed<Aabb>> + Visitor<Placed<Triangle>>)) {
    Placed::<Aabb>::visit_kernels(visitor);
    Placed::<Triangle>::visit_kernels(visitor);
}

/// A shape that there are kernels for.
pub trait Registered: Shape {
    /// Visits them in the order of the list.
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

impl<S: Registered> Registered for Placed<S> {
    fn visit_kernels(visitor: &mut impl Visitor<Self>) {
        struct Instances<'a, V>(&'a mut V);
        impl<S: Shape, V: Visitor<Placed<S>>> Visitor<S> for Instances<'_, V> {
            fn visit<K: Kernel<Shape = S>>(&mut self) {
                self.0.visit::<Instance<K>>();
            }
        }
        S::visit_kernels(&mut Instances(visitor));
    }
}

/// Everything.
pub fn all<V>(visitor: &mut V)
where
    V: Visitor<Aabb> + Visitor<Triangle> + Visitor<Placed<Aabb>> + Visitor<Placed<Triangle>>,
{
    boxes(visitor);
    triangles(visitor);
    instances(visitor);
}

/// Something done with one kernel that is chosen by name at run time.
pub trait TriangleTask {
    /// What comes of it.
    type Output;

    /// Called with the chosen kernel.
    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output;
}

/// Runs the task with the triangle kernel of this ID, of which the family may be left out; `None` if there is no such
/// kernel.
pub fn with_triangle<T: TriangleTask>(id: &str, task: T) -> Option<T::Output> {
    struct Chosen<'a, T: TriangleTask> {
        id: &'a str,
        task: Option<T>,
        output: Option<T::Output>,
    }
    impl<T: TriangleTask> Visitor<Triangle> for Chosen<'_, T> {
        fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
            let method = K::INFO.id.method;
            let name = method.rsplit('/').next();
            if self.id == method || Some(self.id) == name {
                self.output = self.task.take().map(TriangleTask::run::<K>);
            }
        }
    }
    let mut chosen = Chosen { id, task: Some(task), output: None };
    triangles(&mut chosen);
    chosen.output
}

#[cfg(test)]
mod tests {
    use super::*;

    struct IdOf;
    impl TriangleTask for IdOf {
        type Output = &'static str;
        fn run<K: Kernel<Shape = Triangle>>(self) -> &'static str {
            K::INFO.id.method
        }
    }

    #[test]
    fn kernels_are_found_by_id_and_by_name() {
        assert_eq!(with_triangle("triangle/cramer", IdOf), Some("triangle/cramer"));
        assert_eq!(with_triangle("moller_trumbore", IdOf), Some("triangle/moller_trumbore"));
        assert_eq!(with_triangle("aabb/padded", IdOf), None);
        assert_eq!(with_triangle("", IdOf), None);
    }
}
