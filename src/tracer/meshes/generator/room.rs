//! A closed room, seen from inside, with boxes of several colours.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::tracer::meshes::{Mesh, Part};

/// A box, rotated about its vertical axis.
pub(super) struct Cuboid {
    center: Vec3,
    pub(super) half: Vec3,
    /// Cosine and sine of the rotation. They come from a Pythagorean triple, so no platform computes them.
    rotation: Vec2,
}

const UNROTATED: Vec2 = Vec2::new(1.0, 0.0);

pub(super) const SHELL: Cuboid =
    Cuboid { center: Vec3::new(0.0, 2.5, 0.0), half: Vec3::new(6.0, 2.5, 8.0), rotation: UNROTATED };

/// Left, right, floor, ceiling, far and near wall.
const WALLS: [Vec3; 6] = [
    Vec3::new(0.65, 0.12, 0.1),
    Vec3::new(0.15, 0.45, 0.15),
    Vec3::new(0.5, 0.45, 0.4),
    Vec3::new(0.8, 0.8, 0.8),
    Vec3::new(0.6, 0.65, 0.75),
    Vec3::new(0.75, 0.7, 0.6),
];

pub(super) const BOXES: [(Cuboid, Vec3); 7] = [
    (standing(-2.2, -3.5, Vec3::new(1.0, 3.2, 1.0), Vec2::new(0.96, 0.28)), Vec3::new(0.8, 0.8, 0.8)),
    (standing(2.0, -0.5, Vec3::new(1.2, 1.3, 1.1), Vec2::new(0.8, -0.6)), Vec3::new(0.75, 0.5, 0.15)),
    (standing(-0.6, 1.8, Vec3::new(0.6, 0.6, 0.6), Vec2::new(0.6, 0.8)), Vec3::new(0.1, 0.3, 0.7)),
    (standing(4.6, -6.4, Vec3::new(0.8, 4.2, 0.8), UNROTATED), Vec3::new(0.7, 0.7, 0.65)),
    (standing(-4.6, -6.4, Vec3::new(0.8, 4.2, 0.8), UNROTATED), Vec3::new(0.7, 0.7, 0.65)),
    (standing(3.6, 3.0, Vec3::new(0.5, 0.9, 1.4), Vec2::new(0.96, -0.28)), Vec3::new(0.45, 0.15, 0.5)),
    (
        // A board near the wall, above the floor.
        Cuboid { center: Vec3::new(5.7, 2.6, -1.5), half: Vec3::new(0.15, 0.1, 1.5), rotation: UNROTATED },
        Vec3::new(0.35, 0.2, 0.1),
    ),
];

/// Divisions per edge of a box in a room whose walls have `n × n` squares.
const fn box_divisions(n: u32) -> u32 {
    n.div_ceil(3)
}

pub(super) fn triangles(n: u32) -> u32 {
    let cuboid = |n: u32| 12 * n * n;
    cuboid(n) + BOXES.len() as u32 * cuboid(box_divisions(n))
}

pub(super) fn mesh(n: u32) -> Mesh {
    let mut builder = Builder::default();
    builder.add(&SHELL, n, WALLS, Facing::In);
    for (cuboid, color) in &BOXES {
        builder.add(cuboid, box_divisions(n), [*color; 6], Facing::Out);
    }
    Mesh::new(builder.positions, builder.triangles, builder.parts).expect("a room is a valid mesh")
}

/// A box of these dimensions above a point of the floor. A small gap separates it from the floor: if two surfaces lay
/// in one plane, rounding would decide which one a ray hits.
const fn standing(x: f32, z: f32, half_width_height_half_depth: Vec3, rotation: Vec2) -> Cuboid {
    let Vec3 { x: half_width, y: height, z: half_depth } = half_width_height_half_depth;
    const GAP: f32 = 0.01;
    Cuboid {
        center: Vec3::new(x, GAP + height / 2.0, z),
        half: Vec3::new(half_width, height / 2.0, half_depth),
        rotation,
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Facing {
    In,
    Out,
}

#[derive(Default)]
struct Builder {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    parts: Vec<Part>,
}

impl Builder {
    /// Adds the six sides in the order -x, +x, -y, +y, -z, +z. Each is divided into `n × n` squares.
    fn add(&mut self, cuboid: &Cuboid, n: u32, colors: [Vec3; 6], facing: Facing) {
        let mut grid = Grid { cuboid, n, vertices: HashMap::new() };
        for (side, color) in colors.into_iter().enumerate() {
            self.begin_part(color);
            let (axis, is_high) = (side / 2, side % 2 == 1);
            // Seen from the high end of this axis, the next two axes are counter-clockwise.
            let counter_clockwise = is_high == (facing == Facing::Out);
            for row in 0..n {
                for column in 0..n {
                    let mut corner = |across: u32, up: u32| {
                        let mut point = [0; 3];
                        point[axis] = if is_high { n } else { 0 };
                        point[(axis + 1) % 3] = column + across;
                        point[(axis + 2) % 3] = row + up;
                        grid.vertex(point, &mut self.positions)
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let square = if counter_clockwise { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    self.triangles.extend(square);
                }
            }
        }
    }

    fn begin_part(&mut self, color: Vec3) {
        if self.parts.last().is_none_or(|part| part.color != color) {
            self.parts.push(Part { first_triangle: self.triangles.len() as u32, color });
        }
    }
}

/// Vertex numbers of lattice points on a box's surface, with `n` steps per axis. Numbers follow first use.
struct Grid<'a> {
    cuboid: &'a Cuboid,
    n: u32,
    vertices: HashMap<[u32; 3], u32>,
}

impl Grid<'_> {
    /// The vertex at a lattice point. Adds it to `positions` on first use.
    fn vertex(&mut self, point: [u32; 3], positions: &mut Vec<Vec3>) -> u32 {
        *self.vertices.entry(point).or_insert_with(|| {
            let offset = point.map(|step| 2.0 * step as f32 / self.n as f32 - 1.0);
            positions.push(self.cuboid.point(Vec3::from_array(offset)));
            (positions.len() - 1) as u32
        })
    }
}

impl Cuboid {
    /// The point at an offset from the centre. Each coordinate of the offset is from -1 to 1, along the box's own axes.
    fn point(&self, offset: Vec3) -> Vec3 {
        let Vec2 { x: cos, y: sin } = self.rotation;
        let Vec3 { x, y, z } = offset * self.half;
        self.center + Vec3::new(x * cos + z * sin, y, z * cos - x * sin)
    }
}
