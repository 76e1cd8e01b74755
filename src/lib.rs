//! Ray-intersection kernels, each written twice: a scalar reference in [glam] and an 8-wide packet version in [wide],
//! with bit-identical hits. Around them are a small tracer, which runs them on real scenes, and a study, which
//! measures how fast and how accurate each of them is.
//!
//! ```
//! use raylanes::geom::{Hit, Ray, Triangle};
//! use raylanes::kernels::triangle::MollerTrumbore;
//! use raylanes::kernels::{Intersect, Kernel};
//! use glam::Vec3;
//! use wide::f32x8;
//!
//! let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
//! let prepared = MollerTrumbore::prepare(&triangle);
//!
//! // One ray.
//! let ray = Ray::new(Vec3::new(0.25, 0.5, 2.0), Vec3::NEG_Z);
//! let hit: Hit<f32> = prepared.hit(&ray);
//! assert_eq!((hit.mask, hit.t, hit.u, hit.v), (true, 2.0, 0.25, 0.5));
//!
//! // Eight rays against one triangle: the same bits in every lane.
//! let packet = Ray::from_slice(&[ray; 3]); // five lanes are inactive, and miss
//! let hits: Hit<f32x8> = prepared.hit(&packet);
//! assert_eq!(hits.mask.bits(), 0b0000_0111);
//! assert_eq!(hits.lane(2).to_bits(), hit.to_bits());
//!
//! // One ray against eight triangles.
//! let eight = MollerTrumbore::gather(&[prepared; 8]);
//! assert_eq!(eight.hit(&Ray::splat(&ray)).lane(7).to_bits(), hit.to_bits());
//! ```
//!
//! # Reading order
//!
//! 1. [`geom`]: [rays](geom::Ray), [hits](geom::Hit) and shapes, generic over the lane type. [`geom::lanes`] holds
//!    every operation whose scalar and eight-lane forms could differ.
//! 2. [`kernels`]: the contract between twins ([`kernels::Intersect`], [`kernels::Kernel`]), then one file per
//!    method. Start with `triangle/moller_trumbore.rs`.
//! 3. [`registry`]: the list of kernels. Tests, benches, study and program walk it.
//! 4. `conformance` (feature `std`): checks of a kernel, also of your own.
//! 5. `oracle` (feature `study`): the exact answer, in integers. It knows nothing of the kernels.
//! 6. `tracer` (feature `tracer`): meshes, quadrics and instances of them, two levels of trees, traversal, pictures.
//!    Its *box rule* makes the closest hit the same for every way of finding it.
//! 7. `study` (feature `study`): workloads, measurement, accuracy, charts, report.
//!
//! Each layer uses only the layers above it. `ARCHITECTURE.md` has a picture of them and the reasons behind the
//! design.
//!
//! # Words
//!
//! | word | meaning |
//! | --- | --- |
//! | kernel | one intersection method for one shape |
//! | twins | the scalar and the packet implementation of a kernel |
//! | packet | eight rays, or eight primitives, as structure of arrays |
//! | suffix `8` | eight lanes: `min8` is `min` in eight lanes |
//! | width | how many rays meet how many primitives at once: 1×1 (scalar), 8×1 (eight rays, one primitive), 1×8 |
//! | prepared | data computed once per primitive; its bytes are a reported cost |
//! | setup | data computed once per ray, such as the inverse direction |
//! | quadric | a surface `f(p) = 0` of second degree, clipped by a box |
//! | instance | a shape, or a whole mesh, placed in the world by an affine transform |
//! | oracle | the exact answer |
//! | leak | a ray that exactly hits a closed mesh and is reported to hit nothing |
//! | double hit | a ray reported to hit two triangles where exactly one is hit |
//! | workload | a named, seeded set of rays and primitives |
//! | regime | a workload that makes one thing worse, step by step |
//!
//! # Semantics
//!
//! `t` counts in units of `|dir|` and is the same before and after an affine transform of the ray. The interval is
//! closed. Shapes are closed too: triangle edges, box faces and clip planes count as hits. A ray misses everything if
//! it holds a NaN, if its direction is zero, or if its origin or direction is infinite. A degenerate primitive is
//! never hit. No kernel panics or returns a NaN. None uses an absolute epsilon, except
//! [`MollerTrumboreEpsilon`](kernels::triangle::MollerTrumboreEpsilon), which warns of it. A lane that misses holds
//! [`geom::Hit::MISS`].
//!
//! # Features
//!
//! With `default-features = false` the crate is the kernels alone: `no_std`, with no dependencies except glam, libm
//! and wide. `serde`, also `no_std`, writes and reads rays, hits and shapes. JSON has no infinity: it keeps an infinite
//! `t_max` and misses, and other numbers that are not finite cannot be read again. `std` adds `conformance`, `tracer`
//! scenes, `study` (the default) everything else, and `peers` other crates to compare the tracer with.
//!
//! [wide] chooses its instructions at compile time. Without a flag, an x86-64 build has SSE2, and packets run at half
//! width. Build with `RUSTFLAGS="-C target-cpu=native"`, or with `x86-64-v3` for every CPU with AVX2 and FMA. Hits do
//! not depend on it. One build cannot choose at run time. Ship two builds for that: `examples/portable/src/levels.rs`
//! starts the faster one where the CPU can run it.
//!
//! # Versions
//!
//! Types of [glam] and [wide] are part of the interface. Both crates are exported, so `raylanes::glam` and
//! `raylanes::wide` are always the right versions. glam is supported from 0.33.8 to 0.34, with the same hits. Cargo
//! takes the newest one. A crate that itself uses glam 0.33 makes both use it with
//! `cargo update -p glam@0.34.2 --precise 0.33.12`, where the versions are those of its lock file.
//!
//! To drop a minor version of glam or to move to wide 2 is a breaking change of this crate. To allow another one is
//! not. Enums and structs that may grow are non-exhaustive: they are made by constructors.
//!
//! # Adding a kernel
//!
//! Write `src/kernels/<family>/<name>.rs`, name it in the family's `mod.rs`, and add one line to [`registry`]. The
//! kernel is then compared with its twin and with the oracle, benchmarked, recorded, charted, and selectable in the
//! program. `CONTRIBUTING.md` has the steps and the commands.
//!
//! A kernel in your own crate can implement the same traits and run in the tracer. One call in a test,
//! `conformance::check::<MyKernel>().assert_ok()`, compares its twins, checks its behaviour on invalid input, and holds
//! it to its claims. The module `conformance` (feature `std`) says what is checked. `examples/own_kernel.rs` is such a
//! kernel.

// Tests use std even in a build without it.
#![cfg_attr(not(any(feature = "conformance", test)), no_std)]
#![forbid(unsafe_code)]

// Their types are part of this crate's interface.
pub use {glam, wide};

#[cfg(feature = "conformance")]
pub mod conformance;
#[cfg(feature = "tracer")]
mod error;
#[cfg(feature = "tracer")]
mod files;
pub mod geom;
pub mod kernels;
#[cfg(feature = "study")]
pub mod oracle;
pub mod registry;
#[cfg(feature = "study")]
pub mod study;
#[cfg(feature = "tracer")]
pub mod tracer;

/// The README's example must compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
