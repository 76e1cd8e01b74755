//! Cases: eight rays aimed at eight shapes.
//!
//! Uniformly random rays miss nearly everything. They never meet an edge or a corner exactly, never run along a plane,
//! and never contain a number at the end of the range. These rays do. They start near and far away, and they graze.
//! Shapes are of all sizes, and some are slivers, degenerate or not finite.

use glam::Vec3;

use super::aimed::Aimed;
use super::numbers::Numbers;
use super::random::Random;
use crate::geom::Ray;

/// Numbers that decide one shape, and one ray.
const PER_SHAPE: usize = 96;
const PER_RAY: usize = 40;

/// Eight rays and eight shapes.
#[derive(Clone, Copy, Debug)]
pub struct Case<S> {
    /// The shapes. About half of them are equal to the first.
    pub shapes: [S; 8],
    /// About half of the rays aim at the first shape, and every other one at that of its own lane.
    pub rays: [Ray<f32>; 8],
}

impl<S: Aimed> Case<S> {
    /// How many numbers decide a case.
    pub const NUMBERS: usize = 8 * (PER_SHAPE + PER_RAY) + 2;

    /// The case that these numbers decide. Smaller numbers make simpler cases. Missing ones are taken as 0.
    pub fn from_numbers(numbers: &[u32]) -> Self {
        let mut numbers = Numbers::of(numbers);
        let scale = numbers.block(2).scale();
        let mut first = None;
        // Each shape and each ray has its own numbers: if one of them changes, the others stay as they are.
        let mut corruptions = [None; 8];
        let clean: [S; 8] = std::array::from_fn(|index| {
            let mut numbers = numbers.block(PER_SHAPE);
            corruptions[index] = numbers.corruption(9);
            let copied = numbers.choose([1, 1]) == 0;
            let first = *first.get_or_insert_with(|| S::any(&mut numbers.clone()));
            if copied { first } else { S::any(&mut numbers) }.scaled(scale)
        });
        let rays = std::array::from_fn(|lane| {
            let mut numbers = numbers.block(PER_RAY);
            let at_first = numbers.choose([1, 1]) == 0;
            Aim::of(&mut numbers).at(&clean[if at_first { 0 } else { lane }])
        });
        let shapes = std::array::from_fn(|index| match corruptions[index] {
            Some((coordinate, value)) => clean[index].with_coordinate(coordinate, value),
            None => clean[index],
        });
        Self { shapes, rays }
    }

    /// A random case.
    pub fn random(random: &mut Random) -> Self {
        let numbers: Vec<u32> = (0..Self::NUMBERS).map(|_| random.bits() as u32).collect();
        Self::from_numbers(&numbers)
    }
}

impl Numbers<'_> {
    /// One in 13 times: a special number, and which of `fields` it replaces.
    fn corruption(&mut self, fields: u32) -> Option<(usize, f32)> {
        let (is_corrupted, field, value) = (self.choose([12, 1]) == 1, self.below(fields), self.sharp());
        is_corrupted.then_some((field as usize, value))
    }
}

/// How one ray is aimed at its shape.
#[derive(Clone, Debug)]
struct Aim {
    weights: Vec3,
    dir: Vec3,
    /// The direction is a tangent, turned towards the normal by this angle.
    grazing: Option<f32>,
    distance: f32,
    dir_scale: f32,
    interval: Interval,
    corruption: Option<(usize, f32)>,
}

#[derive(Clone, Debug)]
enum Interval {
    Ahead,
    Line,
    EndsAtTarget,
    StartsAtTarget,
    OnlyTarget,
    Empty,
    Between(f32, f32),
}

impl Aim {
    fn of(numbers: &mut Numbers) -> Self {
        Self {
            corruption: numbers.corruption(8),
            weights: Vec3::from([(); 3].map(|()| numbers.weight())),
            dir: Vec3::from([(); 3].map(|()| match numbers.choose([1, 2, 1, 1, 4]) {
                0 => 1.0,
                1 => 0.0,
                2 => -0.0,
                3 => -1.0,
                _ => numbers.between(-1.0, 1.0),
            })),
            grazing: (numbers.choose([4, 1]) == 1).then(|| numbers.power_of_ten(-7, 0)),
            distance: match numbers.choose([2, 3, 1, 1, 1]) {
                0 => (1 + numbers.below(8)) as f32,
                1 => numbers.between(0.0, 10.0),
                2 => 0.0,
                3 => numbers.between(-3.0, 0.0),
                _ => numbers.power_of_ten(2, 7),
            },
            dir_scale: numbers.scale(),
            interval: match numbers.choose([8, 2, 1, 1, 1, 1, 1]) {
                0 => Interval::Ahead,
                1 => Interval::Line,
                2 => Interval::EndsAtTarget,
                3 => Interval::StartsAtTarget,
                4 => Interval::OnlyTarget,
                5 => Interval::Empty,
                _ => Interval::Between(numbers.between(-5.0, 5.0), numbers.between(-5.0, 20.0)),
            },
        }
    }

    fn at(&self, shape: &impl Aimed) -> Ray<f32> {
        let target = shape.target(self.weights);
        let (tangent, normal) = shape.tangent_and_normal(target);
        let dir = match self.grazing {
            Some(angle) => tangent + normal * angle,
            // In proportion to the shape: the distance is then in proportion too.
            None => self.dir * (tangent.abs().max_element() + normal.abs().max_element()),
        } * self.dir_scale;
        let distance = self.distance / self.dir_scale;
        let (t_min, t_max) = match self.interval {
            Interval::Ahead => (0.0, f32::INFINITY),
            Interval::Line => (f32::NEG_INFINITY, f32::INFINITY),
            Interval::EndsAtTarget => (0.0, distance),
            Interval::StartsAtTarget => (distance, f32::MAX),
            Interval::OnlyTarget => (distance, distance),
            Interval::Empty => (1.0, 0.5),
            Interval::Between(t_min, t_max) => (t_min, t_max),
        };
        let mut ray = Ray { origin: target - dir * distance, dir, t_min, t_max };
        if let Some((field, value)) = self.corruption {
            match field {
                0..3 => ray.origin[field] = value,
                3..6 => ray.dir[field - 3] = value,
                6 => ray.t_min = value,
                _ => ray.t_max = value,
            }
        }
        ray
    }
}
