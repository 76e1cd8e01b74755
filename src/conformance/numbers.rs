//! Whole numbers that decide what a case looks like.
//!
//! A case is a function of a list of numbers. Random numbers make random cases. A tool that simplifies a failing case,
//! such as proptest, makes the numbers smaller: 0 always stands for the simplest choice.

use glam::Vec3;

/// Special numbers: zeros and infinities of both signs, NaN, subnormals, the ends of the range.
const SHARP: [f32; 14] = [
    0.0,
    -0.0,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1e-45,
    -1e-40,
    f32::MIN_POSITIVE,
    -1e-38,
    1e38,
    -1e38,
    f32::MAX,
    f32::MIN,
    1e-20,
];

/// A list of numbers, taken one after the other. Behind its end, all numbers are 0.
#[derive(Clone, Debug)]
pub struct Numbers<'a>(&'a [u32]);

impl<'a> Numbers<'a> {
    /// All of these numbers.
    pub fn of(numbers: &'a [u32]) -> Self {
        Self(numbers)
    }

    /// Takes `count` numbers off the front.
    pub(super) fn block(&mut self, count: usize) -> Self {
        let (block, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        Self(block)
    }

    /// In 0..end.
    pub fn below(&mut self, end: u32) -> u32 {
        let Some((number, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        ((u64::from(*number) * u64::from(end)) >> 32) as u32
    }

    /// An index, each as often as its weight says.
    pub fn choose<const N: usize>(&mut self, weights: [u32; N]) -> usize {
        let mut left = self.below(weights.iter().sum());
        let chosen = weights.iter().position(|weight| {
            let is_here = left < *weight;
            left = left.wrapping_sub(*weight);
            is_here
        });
        chosen.unwrap_or(0)
    }

    /// In `from..to`, or `to` where that is the nearest number.
    pub fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * (self.below(1 << 24) as f32 / (1 << 24) as f32)
    }

    /// 1 to 4.
    pub(super) fn small_whole(&mut self) -> f32 {
        (1 + self.below(4)) as f32
    }

    /// A special number, such as an infinity.
    pub(super) fn sharp(&mut self) -> f32 {
        SHARP[self.below(SHARP.len() as u32) as usize]
    }

    /// Ten to a power of `from` or more, and less than `to`.
    pub(super) fn power_of_ten(&mut self, from: i32, to: i32) -> f32 {
        10f32.powi(from + self.below((to - from) as u32) as i32)
    }

    /// A small whole number, whose products are exact, or another number.
    pub(super) fn coordinate(&mut self) -> f32 {
        match self.choose([2, 3, 1]) {
            0 => [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0][self.below(9) as usize],
            1 => self.between(-4.0, 4.0),
            _ => -0.0,
        }
    }

    /// Three coordinates.
    pub fn point(&mut self) -> Vec3 {
        Vec3::from([(); 3].map(|()| self.coordinate()))
    }

    /// 1, or a power of ten from the whole range.
    pub(super) fn scale(&mut self) -> f32 {
        if self.choose([6, 1]) == 0 { 1.0 } else { self.power_of_ten(-38, 38) }
    }

    /// 0, 1 or one half, in between, or a little outside.
    pub(super) fn weight(&mut self) -> f32 {
        match self.choose([1, 2, 2, 5, 1]) {
            0 => 0.5,
            1 => 0.0,
            2 => 1.0,
            3 => self.between(0.0, 1.0),
            _ => self.between(-0.5, 1.5),
        }
    }
}
