//! What only tests use: a made-up record, and tests of documents in the repository that are made from the code.

mod fields;
pub(crate) mod fixture;
mod readme;
