//! Reproducible pseudo-random numbers for generators, scatters and picture samples.

/// Hashes three numbers to 32 bits, with the finaliser of `MurmurHash3` (Austin Appleby).
pub(crate) fn hash(a: u32, b: u32, c: u32) -> u32 {
    let mut hash = a.wrapping_mul(0x9e37_79b1) ^ b.wrapping_mul(0x85eb_ca77) ^ c.wrapping_mul(0xc2b2_ae3d);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

/// Maps 32 bits to a number from 0 to 1, excluding 1. Uses the upper 24 bits.
pub(crate) fn unit_interval(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}
