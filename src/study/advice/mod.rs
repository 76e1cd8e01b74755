//! Advice: which kernel and mode a scene needs, and why.

#[cfg_attr(not(test), expect(dead_code, reason = "the judge of a scene, which asks for the traits, is not there yet"))]
mod traits;
