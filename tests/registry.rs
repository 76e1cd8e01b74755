//! Tests that every kernel file is in the registry, that IDs are unique, and that every kernel describes itself.

use std::collections::BTreeSet;
use std::path::Path;

use glam::Vec3;
use raylanes::geom::{Aabb, Shape, Triangle};
use raylanes::kernels::{Intersect, Kernel, Operations};
use raylanes::registry::{self, Visitor};

#[derive(Default)]
struct Methods {
    ids: Vec<String>,
    methods: BTreeSet<String>,
}

impl<S: Shape> Visitor<S> for Methods {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let info = K::INFO;
        assert!(
            info.id.method.starts_with(&format!("{}/", S::FAMILY)),
            "the family of {} is not {}",
            info.id,
            S::FAMILY
        );
        assert!(!info.idea.is_empty() && !info.source.is_empty(), "{} has no idea or no source", info.id);
        assert_ne!(info.operations, Operations::NONE, "{} has no operation counts", info.id);
        let prepares_rays = size_of::<<K as Intersect<f32>>::Setup>() > 0;
        assert_eq!(
            info.setup != Operations::NONE,
            prepares_rays,
            "{} has wrong operation counts of its setup",
            info.id
        );
        assert!(
            info.operations.reads as usize * 4 <= size_of::<K>(),
            "{} counts more reads than it has prepared numbers",
            info.id
        );
        self.ids.push(info.id.to_string());
        self.methods.insert(info.id.method.into());
    }
}

/// Compares the boxes that kernels return for eight triangles with the boxes of the triangles.
struct Bounds {
    triangles: [Triangle; 8],
    known: usize,
}

impl Visitor<Triangle> for Bounds {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let Some(bounds) = K::bounds(&K::gather(&self.triangles.each_ref().map(K::prepare))) else { return };
        self.known += 1;
        for (lane, triangle) in self.triangles.iter().enumerate() {
            let bounds = Aabb { lo: bounds.lo.lane(lane), hi: bounds.hi.lane(lane) };
            assert_eq!(bounds, triangle.bounds(), "{}, lane {lane}", K::INFO.id);
        }
    }
}

#[test]
fn kernels_return_the_boxes_of_their_triangles() {
    let vertex = |number: usize| {
        let component = |by: usize| ((number * 7919 + 17) * by % 1009) as f32 / 1009.0 - 0.5;
        Vec3::new(component(31), component(101), component(331))
    };
    let triangles = std::array::from_fn(|index| Triangle {
        v0: vertex(3 * index),
        v1: vertex(3 * index + 1),
        v2: vertex(3 * index + 2),
    });
    let mut bounds = Bounds { triangles, known: 0 };
    registry::triangles(&mut bounds);
    assert!(bounds.known >= 4, "only {} kernels return boxes", bounds.known);
}

fn registered() -> Methods {
    let mut methods = Methods::default();
    registry::all(&mut methods);
    methods
}

#[test]
fn ids_are_unique() {
    let ids = registered().ids;
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "{ids:?}");
}

#[test]
fn every_kernel_file_is_registered_or_named_absent() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/kernels");
    let mut files = BTreeSet::new();
    for family in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        for file in std::fs::read_dir(&family).unwrap().map(|entry| entry.unwrap().path()) {
            let [family, name] = [&family, &file].map(|path| path.file_stem().unwrap().to_str().unwrap());
            if name != "mod" {
                files.insert(format!("{family}/{name}"));
            }
        }
    }
    assert!(files.len() >= 7, "only found {files:?}");
    let mut methods = registered().methods;
    for absent in registry::absent() {
        assert!(!absent.reason.is_empty(), "{} is absent without a reason", absent.id);
        assert!(methods.insert(absent.id.into()), "{} is both registered and absent", absent.id);
    }
    assert_eq!(files, methods, "left: kernel files, right: registered and absent kernels");
}
