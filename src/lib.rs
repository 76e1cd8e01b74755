//! Ray-intersection kernels, each written twice: a scalar reference in [glam] and an 8-wide packet version in [wide],
//! with bit-identical hits. Around them a small tracer that runs them on real scenes, and a study that measures how fast
//! and how right each of them is.
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
//! 1. [`geom`]: [rays](geom::Ray), [hits](geom::Hit) and shapes, generic over the lane type, and [`geom::lanes`], where
//!    every operation lives whose scalar and packet meaning could drift apart.
//! 2. [`kernels`]: the contract between twins ([`kernels::Intersect`], [`kernels::Kernel`]), then one file per method;
//!    start with `triangle/moller_trumbore.rs`.
//! 3. [`registry`]: the list of kernels that tests, benches, study and program walk.
//! 4. `oracle` (feature `study`): the exact answer, in whole numbers. It knows nothing of the kernels.
//! 5. `tracer` (feature `tracer`): meshes, quadrics and instances of them, two levels of trees, traversal under the *box
//!    rule*, which makes the closest hit the same for every way of finding it, and pictures.
//! 6. `study` (feature `study`): workloads, measurement, accuracy, charts, report.
//!
//! Each layer uses only those above it.
//!
//! # Words
//!
//! | word | meaning |
//! | --- | --- |
//! | kernel | one intersection method for one shape |
//! | twins | its scalar and its packet implementation |
//! | packet | eight rays, or eight primitives, as structure of arrays |
//! | face | how rays and primitives are paired: 1×1 (scalar), 8×1 (eight rays, one primitive), 1×8 |
//! | prepared | what is computed once per primitive; its bytes are a reported cost |
//! | setup | what is computed once per ray, such as the inverse direction |
//! | quadric | a surface `f(p) = 0` of second degree, cut off by a box |
//! | instance | a shape, or a whole mesh, put into the world by an affine transform |
//! | oracle | the exact answer |
//! | leak | a ray that exactly hits a closed mesh and is reported to hit nothing |
//! | double | a ray reported to hit two triangles where exactly one is hit |
//! | workload | a named, seeded set of rays and primitives |
//!
//! # Semantics
//!
//! `t` counts in units of `|dir|` and is the same before and after an affine transform of the ray. The interval is closed.
//! Edges belong to the triangle, surfaces to the box, and what is exactly in a plane of its box to the quadric. A ray with a NaN anywhere, a zero direction, or an infinite origin
//! or direction misses everything, and so does a degenerate primitive. No kernel panics, returns a NaN, or uses an
//! absolute epsilon. A lane that misses holds [`geom::Hit::MISS`].
//!
//! # Features
//!
//! With `default-features = false` there are the kernels alone: `no_std`, and no dependencies but glam, libm and wide.
//! `tracer` adds scenes, `study` (the default) everything else, and `peers` other crates to compare the tracer with.
//!
//! [wide] chooses its instructions at compile time. Without a flag an x86-64 build has SSE2 and packets run at half width:
//! build with `RUSTFLAGS="-C target-cpu=native"`, or `x86-64-v3` for AVX2 and FMA everywhere. Hits do not depend on it.
//!
//! # Adding a kernel
//!
//! Write `src/kernels/<family>/<name>.rs`: a header that says what the method is, where it comes from and where it fails;
//! a struct generic over the lanes; `impl Intersect<f32>`, the specification in plain glam; `impl<P: Lanes>
//! Intersect<f32x8>`, its translation line by line; `impl Kernel`. Name it in the family's `mod.rs` and add one line to
//! [`registry`]. It is then compared with its twin and the oracle, benchmarked, recorded, charted, and selectable in the
//! program. `RAYLANES_BLESS=1 cargo test --test cases --test accuracy` pins what it makes of the sharp cases (read
//! the lines marked `<-`) and its errors in every regime. What it claims is enforced; what it does not claim, it has to be
//! seen to break. A kernel of your own crate can implement the same traits and be used with the tracer as it is.

// Tests may use all of std, also those of a build without it.
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![forbid(unsafe_code)]

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
