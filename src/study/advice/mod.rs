//! Advice: what kernel, mode and model a scene needs.

#[cfg_attr(not(test), expect(dead_code, reason = "the command that gives advice is not written yet"))]
pub(crate) mod models;
