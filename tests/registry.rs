//! Everything that is a kernel is in the registry, and under one name only.

use std::collections::BTreeSet;
use std::path::Path;

use raylanes::geom::Shape;
use raylanes::kernels::{Kernel, Operations};
use raylanes::registry::{self, Visitor};

#[derive(Default)]
struct Methods {
    ids: Vec<String>,
    methods: BTreeSet<String>,
}

impl<S: Shape> Visitor<S> for Methods {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let info = K::INFO;
        assert!(info.id.method.starts_with(&format!("{}/", S::FAMILY)), "{} is not of family {}", info.id, S::FAMILY);
        assert!(!info.idea.is_empty() && !info.source.is_empty(), "{} does not say what it is", info.id);
        assert_ne!(info.operations, Operations::default(), "{} does not count its operations", info.id);
        self.ids.push(info.id.to_string());
        self.methods.insert(info.id.method.into());
    }
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
        assert!(!absent.reason.is_empty(), "{} does not say why it is absent", absent.id);
        assert!(methods.insert(absent.id.into()), "{} is both registered and absent", absent.id);
    }
    assert_eq!(files, methods, "left: kernel files, right: registry, with what it names absent");
}
