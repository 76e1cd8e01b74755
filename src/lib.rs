//! raylanes.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

pub mod geom;
pub mod kernels;
#[cfg(feature = "study")]
pub mod oracle;
pub mod registry;
#[cfg(feature = "study")]
pub mod study;
#[cfg(feature = "tracer")]
pub mod tracer;
