//! raylanes.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

pub mod geom;
pub mod kernels;
pub mod registry;
