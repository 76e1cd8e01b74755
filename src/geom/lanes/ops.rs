//! Operations on numbers in one lane and in eight, each pair with the same bits.

use wide::{f32x4, f32x8, u32x8};

use super::mask::{Mask8, ge8, gt8, le8, lt8};

/// The smaller of two numbers. `b` where they are equal (0 and -0 are) or one is NaN.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// [`min`] in eight lanes.
#[inline(always)]
pub fn min8(a: f32x8, b: f32x8) -> f32x8 {
    // This definition is the x86 instruction `minps`. The compiler does not find it in a comparison and a selection.
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.fast_min(b) } else { lt8(a, b).select(a, b) }
}

/// The larger of two numbers. `b` where they are equal (0 and -0 are) or one is NaN.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// [`max`] in eight lanes.
#[inline(always)]
pub fn max8(a: f32x8, b: f32x8) -> f32x8 {
    // As in `min8`, with `maxps`.
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.fast_max(b) } else { gt8(a, b).select(a, b) }
}

/// Whether a hit at `t` counts: `t` is finite and lies in the closed interval. NaN and ±∞ do not count, even if the
/// interval is infinite.
#[inline(always)]
pub fn t_in_range(t_min: f32, t: f32, t_max: f32) -> bool {
    // The ends become finite once per ray. Testing `t` itself would cost an operation per primitive.
    (t >= max(-f32::MAX, t_min)) & (t <= min(f32::MAX, t_max))
}

/// [`t_in_range`] in eight lanes.
#[inline(always)]
pub fn t_in_range8(t_min: f32x8, t: f32x8, t_max: f32x8) -> Mask8 {
    let most = f32x8::splat(f32::MAX);
    ge8(t, max8(-most, t_min)) & le8(t, min8(most, t_max))
}

/// The square root, correctly rounded. `-0` for `-0`, NaN for other negative numbers.
#[inline(always)]
pub fn sqrt(a: f32) -> f32 {
    // `f32::sqrt` is not in core. One of these four lanes is used.
    f32x4::splat(a).sqrt().to_array()[0]
}

/// [`sqrt`] in eight lanes. A NaN may differ in sign and payload.
#[inline(always)]
pub fn sqrt8(a: f32x8) -> f32x8 {
    a.sqrt()
}

/// The largest power of two that is at most `|a|`. 0 where `a` is zero or subnormal, +∞ where it is infinite or NaN.
#[inline(always)]
pub fn power_of_two(a: f32) -> f32 {
    f32::from_bits(a.to_bits() & f32::INFINITY.to_bits())
}

/// [`power_of_two`] in eight lanes.
#[inline(always)]
pub fn power_of_two8(a: f32x8) -> f32x8 {
    f32x8::from_bits(f32x8::to_bits(a) & u32x8::splat(f32::INFINITY.to_bits()))
}

/// `a·b + c`, rounded once.
#[cfg(any(fused, doc))]
#[inline(always)]
pub fn mul_add(a: f32, b: f32, c: f32) -> f32 {
    // `f32::mul_add` is not in core. The compiler keeps one of these four lanes.
    let [a, b, c] = [a, b, c].map(f32x4::splat);
    a.mul_add(b, c).to_array()[0]
}

/// [`mul_add`] in eight lanes.
#[cfg(any(fused, doc))]
#[inline(always)]
pub fn mul_add8(a: f32x8, b: f32x8, c: f32x8) -> f32x8 {
    a.mul_add(b, c)
}

#[cfg(test)]
mod tests {
    use super::super::SHARP;
    use super::*;

    /// Checks a binary pair on every pair of sharp numbers, in every lane.
    fn same_bits(name: &str, scalar: fn(f32, f32) -> f32, packet: fn(f32x8, f32x8) -> f32x8) {
        for a in SHARP {
            for b in SHARP {
                let expected = scalar(a, b).to_bits();
                for (lane, got) in packet(f32x8::splat(a), f32x8::splat(b)).to_array().iter().enumerate() {
                    assert_eq!(got.to_bits(), expected, "{name}({a:?}, {b:?}) in lane {lane}");
                }
            }
        }
    }

    #[test]
    fn min_and_max_agree_in_eight_lanes() {
        same_bits("min", min, min8);
        same_bits("max", max, max8);
    }

    #[test]
    fn min_and_max_return_the_second_operand_if_equal_or_nan() {
        assert_eq!(min(0.0, -0.0).to_bits(), (-0.0f32).to_bits());
        assert_eq!(max(-0.0, 0.0).to_bits(), 0);
        assert_eq!(min(f32::NAN, 1.0), 1.0);
        assert!(min(1.0, f32::NAN).is_nan());
        assert_eq!(max(f32::NAN, 1.0), 1.0);
        assert!(max(1.0, f32::NAN).is_nan());
    }

    #[test]
    fn accepted_t_is_finite_and_in_the_interval() {
        for t in SHARP {
            for a in SHARP {
                for b in SHARP {
                    let expected = (t >= a) & (t <= b) & t.is_finite();
                    assert_eq!(t_in_range(a, t, b), expected, "t = {t:?} in [{a:?}, {b:?}]");
                    let eight = t_in_range8(f32x8::splat(a), f32x8::splat(t), f32x8::splat(b));
                    assert_eq!(
                        eight.bits(),
                        if expected { 0xff } else { 0 },
                        "t = {t:?} in [{a:?}, {b:?}], eight lanes"
                    );
                }
            }
        }
    }

    #[test]
    fn square_roots_and_powers_of_two_agree_in_eight_lanes() {
        for a in SHARP {
            let (root, power) = (sqrt(a), power_of_two(a));
            for lane in sqrt8(f32x8::splat(a)).to_array() {
                assert!(
                    lane.to_bits() == root.to_bits() || (lane.is_nan() && root.is_nan()),
                    "{a:?}: {lane:?}, {root:?}"
                );
            }
            for lane in power_of_two8(f32x8::splat(a)).to_array() {
                assert_eq!(lane.to_bits(), power.to_bits(), "{a:?}");
            }
        }
        // The constant is the `f32` nearest to the root of 2.
        assert_eq!(sqrt(2.0), core::f32::consts::SQRT_2);
        assert_eq!((sqrt(9.0), sqrt(-0.0).to_bits(), sqrt(-1e-45).is_nan()), (3.0, 1 << 31, true));
        assert_eq!([3.9, -4.0, 1e-45, -0.0, f32::MAX].map(power_of_two), [2.0, 4.0, 0.0, 0.0, 2f32.powi(127)]);
        assert_eq!([f32::INFINITY, f32::NAN].map(power_of_two), [f32::INFINITY; 2]);
    }

    #[cfg(fused)]
    #[test]
    fn mul_add_rounds_once_in_both_twins() {
        for c in SHARP {
            let packet = |a, b, c| mul_add8(f32x8::splat(a), f32x8::splat(b), f32x8::splat(c)).to_array();
            for a in SHARP {
                for b in SHARP {
                    let expected = mul_add(a, b, c);
                    for (lane, got) in packet(a, b, c).into_iter().enumerate() {
                        let same = got.to_bits() == expected.to_bits() || (got.is_nan() && expected.is_nan());
                        assert!(same, "mul_add({a:?}, {b:?}, {c:?}) in lane {lane}: {got:?}, {expected:?}");
                    }
                }
            }
        }
        // (1 + ε)² - (1 + 2ε) is ε². Two roundings lose it.
        let (a, c) = (1.0 + f32::EPSILON, -1.0 - 2.0 * f32::EPSILON);
        assert_eq!((mul_add(a, a, c), a * a + c), (f32::EPSILON * f32::EPSILON, 0.0));
    }
}
