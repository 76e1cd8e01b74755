//! Code for tests only: a made-up record, and tests of documents that are generated from the code.

mod fields;
pub(crate) mod fixture;
mod readme;
