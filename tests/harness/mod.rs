//! Tests made at run time: one for each registered kernel, named by its ID.
//!
//! A test binary that uses this has `harness = false` in `Cargo.toml` and its own `main`. It takes the usual options.
//! `cargo test woop` runs every test with "woop" in its name. `-- --list` lists the tests. `-- --nocapture` also prints
//! the summaries of tests that pass.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};
use raylanes::geom::Shape;
use raylanes::kernels::Kernel;
use raylanes::registry::Visitor;

/// A test of one kernel. `kind` says what is tested; it is printed before the ID. `check` returns a summary, or what is
/// wrong.
pub(crate) fn of_kernel(
    kind: &str,
    id: impl Into<String>,
    check: impl FnOnce() -> Result<String, String> + Send + 'static,
) -> Trial {
    let (id, nocapture) = (id.into(), std::env::args().any(|argument| argument == "--nocapture"));
    let run = move || {
        let summary = check()?;
        if nocapture && !summary.is_empty() {
            println!("{summary}");
        }
        Ok(())
    };
    Trial::test(id, run).with_kind(kind)
}

/// A test that fails by a panic, like a function with `#[test]`.
pub(crate) fn test(name: &str, check: impl FnOnce() + Send + 'static) -> Trial {
    Trial::test(name, move || {
        check();
        Ok(())
    })
}

/// The IDs of kernels, in the order of the registry.
#[derive(Default)]
pub(crate) struct Ids(Vec<String>);

impl<S: Shape> Visitor<S> for Ids {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.push(K::INFO.id.to_string());
    }
}

/// Runs the tests that the command line selects. Tests of one group share inputs, which the first of them makes: the
/// groups take turns, so that several threads make the inputs of several groups.
///
/// # Panics
///
/// If one of the kernels that `registered` visits has no test.
pub(crate) fn run(groups: Vec<Vec<Trial>>, registered: fn(&mut Ids)) -> ExitCode {
    let mut groups: Vec<_> = groups.into_iter().map(Vec::into_iter).collect();
    let mut trials = Vec::new();
    while !groups.is_empty() {
        groups.retain_mut(|group| group.next().map(|trial| trials.push(trial)).is_some());
    }
    let mut ids = Ids::default();
    registered(&mut ids);
    assert!(!ids.0.is_empty(), "the registry is empty");
    for id in ids.0 {
        assert!(trials.iter().any(|trial| trial.name() == id), "{id} is registered, but has no test");
    }
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
