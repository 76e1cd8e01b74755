//! The exact answer for a ray and a whole scene, and whether a reported hit agrees with it.
//!
//! The oracle decides every primitive whose box the ray may meet. Its own tree in `f64` finds these; it shares no code
//! with the tracer's. Boxes are padded by far more than the rounding errors of `f64`, and by far less than `f32`
//! resolves, so no primitive is overlooked.
//!
//! **What counts as right.** The ray ends at the first *solid* hit: inside a primitive, or on an edge or a vertex that
//! several triangles of an instance share and that they all turn the same side to. Another boundary before it, such as
//! a silhouette, may be reported or not. Exact values of `t` that round to one `f32` count as equal.

use glam::{Affine3, DAffine3, DVec3, Vec3};

use crate::geom::{Aabb, Hit, Placed, Ray, Triangle};
use crate::oracle::{Exact, Truth};
use crate::tracer::{Disc, Face, Geometry, Placement, World};

/// A primitive of an instance: both numbers as in [`Hit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    instance: u32,
    primitive: u32,
}

/// The exact answer for one ray.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    /// What may be reported as the closest hit, and the exact `t` of each, rounded.
    accepted: Vec<(Place, f32)>,
    /// Whether the ray ends at a solid hit, so that a miss is wrong.
    pub(crate) solid: bool,
}

impl Answer {
    /// Whether either answer is right, because the ray only touches boundaries.
    pub(crate) fn is_open(&self) -> bool {
        !self.solid && !self.accepted.is_empty()
    }
}

/// How a reported hit compares with the exact answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Judgement {
    Right,
    /// The ray exactly ends at a surface, and the report looks through it: a miss, or an exact hit farther away.
    Lost,
    /// The report is a hit of a primitive that the ray exactly misses.
    False,
    /// The same, but the primitive touches the right one: they share a vertex. The place is right up to rounding.
    Neighbour,
}

/// A world, ready to be asked.
pub(crate) struct SceneTruth<'a> {
    world: &'a World,
    /// For each geometry, the number of its first primitive.
    first_primitive: Vec<u32>,
    /// For each geometry, the boxes of its primitives.
    trees: Vec<Tree>,
    /// For each instance, from the world to the object.
    to_object: Vec<DAffine3>,
    /// The instances' boxes in the world.
    instances: Tree,
    /// For each instance, the diagonal of its box.
    sizes: Vec<f64>,
}

/// One exact hit.
struct Found {
    place: Place,
    truth: Truth,
    /// Whether the front of a triangle is seen.
    front: bool,
}

impl<'a> SceneTruth<'a> {
    pub(crate) fn new(world: &'a World) -> Self {
        let mut first_primitive = Vec::new();
        let mut count = 0;
        let mut trees = Vec::new();
        for geometry in world.geometries() {
            first_primitive.push(count);
            count += geometry.primitives() as u32;
            trees.push(Tree::new((0..geometry.primitives() as u32).map(|number| primitive_box(geometry, number))));
        }
        let world_box = |placement: &Placement| {
            let bounds = trees[placement.geometry as usize].bounds();
            let transform = placement.object_to_world.as_daffine3();
            let corner = |which: usize| DVec3::from_array(std::array::from_fn(|axis| bounds[which >> axis & 1][axis]));
            let corners = (0..8).map(|which| transform.transform_point3(corner(which)));
            corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], corner| [lo.min(corner), hi.max(corner)])
        };
        let boxes: Vec<_> = world.instances().iter().map(world_box).collect();
        let sizes = boxes.iter().map(|[lo, hi]| lo.distance(*hi)).collect();
        let instances = Tree::new(boxes.into_iter());
        let to_object =
            world.instances().iter().map(|placement| placement.object_to_world.as_daffine3().inverse()).collect();
        Self { world, first_primitive, trees, to_object, instances, sizes }
    }

    /// The exact answer for a ray. With `any_hit`, only [`Answer::solid`] and whether anything is accepted count.
    pub(crate) fn answer(&self, ray: &Ray<f32>, any_hit: bool) -> Answer {
        let mut found: Vec<Found> = Vec::new();
        // Nothing beyond a hit inside a primitive matters.
        let mut end = f64::from(ray.t_max);
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        self.instances.visit(&Line { origin, dir, start: ray.t_min.into() }, &mut end, &mut |instance, end| {
            let placement = &self.world.instances()[instance as usize];
            let transform = &self.to_object[instance as usize];
            let line = Line {
                origin: transform.transform_point3(origin),
                dir: transform.transform_vector3(dir),
                start: ray.t_min.into(),
            };
            self.trees[placement.geometry as usize].visit(&line, end, &mut |number, end| {
                let place = Place { instance, primitive: self.first_primitive[placement.geometry as usize] + number };
                let truth = self.truth(place, ray);
                if !truth.hit {
                    return;
                }
                if !truth.boundary {
                    *end = if any_hit { f64::NEG_INFINITY } else { end.min(f64::from(truth.t.next_up())) };
                }
                found.push(Found { place, truth, front: self.shows_front(place, dir) });
            });
        });
        found.sort_by(|a, b| a.truth.t.total_cmp(&b.truth.t));
        let mut answer = Answer::default();
        for same_t in found.chunk_by(|a, b| a.truth.t == b.truth.t) {
            answer.accepted.extend(same_t.iter().map(|found| (found.place, found.truth.t)));
            answer.solid = same_t.iter().any(|found| !found.truth.boundary) || is_crossed(same_t);
            if answer.solid {
                break;
            }
        }
        answer
    }

    /// Compares a reported closest hit with the exact answer.
    pub(crate) fn judge(&self, answer: &Answer, ray: &Ray<f32>, hit: &Hit<f32>) -> Judgement {
        if !hit.mask {
            return if answer.solid { Judgement::Lost } else { Judgement::Right };
        }
        let place = Place { instance: hit.instance, primitive: hit.primitive };
        if answer.accepted.iter().any(|&(right, _)| right == place) {
            Judgement::Right
        } else if self.truth(place, ray).hit {
            Judgement::Lost
        } else if answer.accepted.iter().any(|&(right, _)| self.touch(right, place)) {
            Judgement::Neighbour
        } else {
            Judgement::False
        }
    }

    /// How far along the ray a reported hit is from the exact one, relative to its distance from the ray's origin, or
    /// to the diagonal of the instance's box in the world where that is less. `None` unless the hit is
    /// [`Judgement::Right`].
    pub(crate) fn displacement(&self, answer: &Answer, ray: &Ray<f32>, hit: &Hit<f32>) -> Option<f64> {
        let place = Place { instance: hit.instance, primitive: hit.primitive };
        let (_, t) = answer.accepted.iter().find(|(right, _)| hit.mask && *right == place)?;
        let [exact, reported] = [*t, hit.t].map(f64::from);
        let length = ray.dir.as_dvec3().length();
        // A hit at the origin of its ray has no distance.
        let scale = (exact.abs() * length).min(self.sizes[hit.instance as usize]).max(f64::MIN_POSITIVE);
        Some((reported - exact).abs() * length / scale)
    }

    /// Compares a report of any hit with the exact answer.
    pub(crate) fn judge_any(answer: &Answer, occluded: bool) -> Judgement {
        match occluded {
            false if answer.solid => Judgement::Lost,
            true if answer.accepted.is_empty() => Judgement::False,
            _ => Judgement::Right,
        }
    }

    /// The vertices in the world of a triangle that was hit, rounded. `None` for a miss and for other shapes.
    pub(crate) fn vertices(&self, hit: &Hit<f32>) -> Option<[Vec3; 3]> {
        let place = Place { instance: hit.instance, primitive: hit.primitive };
        let Shape::Triangle(triangle) = hit.mask.then(|| self.shape(place))? else { return None };
        let transform = self.world.instances()[hit.instance as usize].object_to_world.as_daffine3();
        Some(triangle.vertices().map(|vertex| transform.transform_point3(vertex.as_dvec3()).as_vec3()))
    }

    fn truth(&self, place: Place, ray: &Ray<f32>) -> Truth {
        let transform = &self.world.instances()[place.instance as usize].object_to_world;
        match self.shape(place) {
            Shape::Triangle(triangle) => truth(triangle, transform, ray),
            Shape::Face(face) => {
                let truth = truth(face.quadric(), transform, ray);
                let Face::Disc(disc) = face else { return truth };
                let to_object = &self.to_object[place.instance as usize];
                let origin = to_object.transform_point3(ray.origin.as_dvec3());
                match inside_disc(&disc, origin, to_object.transform_vector3(ray.dir.as_dvec3())) {
                    Some(true) => truth,
                    Some(false) => Truth::MISS,
                    None => Truth { boundary: truth.hit, ..truth },
                }
            }
        }
    }

    fn shape(&self, place: Place) -> Shape {
        let geometry = self.world.instances()[place.instance as usize].geometry as usize;
        let number = place.primitive - self.first_primitive[geometry];
        match &self.world.geometries()[geometry] {
            Geometry::Mesh(mesh) => Shape::Triangle(mesh.triangle(number)),
            Geometry::Quadric(quadric) => Shape::Face(Face::Quadric(*quadric)),
            Geometry::Faces(faces) => Shape::Face(faces[number as usize]),
        }
    }

    /// Whether a ray of this direction sees the front of a triangle; false for other shapes.
    fn shows_front(&self, place: Place, dir: DVec3) -> bool {
        let Shape::Triangle(triangle) = self.shape(place) else { return false };
        let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
        self.to_object[place.instance as usize].transform_vector3(dir).dot((v1 - v0).cross(v2 - v0)) < 0.0
    }

    /// Whether two triangles of an instance share a vertex.
    fn touch(&self, a: Place, b: Place) -> bool {
        match (self.shape(a), self.shape(b)) {
            (Shape::Triangle(one), Shape::Triangle(other)) if a.instance == b.instance => {
                one.vertices().iter().any(|vertex| other.vertices().contains(vertex))
            }
            _ => false,
        }
    }
}

enum Shape {
    Triangle(Triangle),
    Face(Face),
}

fn truth<S: Exact>(shape: S, object_to_world: &Affine3, ray: &Ray<f32>) -> Truth
where
    Placed<S>: Exact,
{
    if *object_to_world == Affine3::IDENTITY {
        shape.truth(ray)
    } else {
        Placed { shape, object_to_world: *object_to_world }.truth(ray)
    }
}

/// Whether boundary hits at one `t` are an edge or a vertex inside a surface: several triangles of an instance, all
/// seen from the same side.
fn is_crossed(found: &[Found]) -> bool {
    found.len() > 1
        && found.iter().all(|other| other.place.instance == found[0].place.instance && other.front == found[0].front)
}

/// Whether a ray in the object's coordinates meets the plane of a disc inside the circle. `None` where it meets the
/// circle to the precision of `f64`.
fn inside_disc(disc: &Disc, origin: DVec3, dir: DVec3) -> Option<bool> {
    let t = (f64::from(disc.height) - origin.z) / dir.z;
    let distance = (origin + dir * t).truncate().length() / f64::from(disc.radius);
    ((distance - 1.0).abs() > 1e-9).then_some(distance < 1.0)
}

fn primitive_box(geometry: &Geometry, number: u32) -> [DVec3; 2] {
    let Aabb { lo, hi } = match geometry {
        Geometry::Mesh(mesh) => mesh.triangle(number).bounds(),
        Geometry::Quadric(quadric) => quadric.bounds(),
        Geometry::Faces(faces) => faces[number as usize].quadric().bounds(),
    };
    [lo.as_dvec3(), hi.as_dvec3()]
}

/// A ray in `f64`.
struct Line {
    origin: DVec3,
    dir: DVec3,
    /// The least `t`.
    start: f64,
}

/// A binary tree over boxes, split at medians.
struct Tree {
    nodes: Vec<Node>,
    /// Numbers of the boxes, in the order of the leaves.
    items: Vec<u32>,
}

struct Node {
    bounds: [DVec3; 2],
    /// The items below the node are `items[first..first + count]`.
    first: u32,
    count: u32,
    /// The first of two nodes; zero for a leaf.
    children: u32,
}

const LEAF: usize = 4;
/// Padding of boxes, relative to the largest number that takes part.
const PADDING: f64 = 1e-10;

impl Tree {
    fn new(boxes: impl Iterator<Item = [DVec3; 2]>) -> Self {
        let boxes: Vec<_> = boxes.collect();
        let mut tree = Self { nodes: Vec::new(), items: (0..boxes.len() as u32).collect() };
        let root = tree.node(&boxes, 0, boxes.len());
        tree.nodes.push(root);
        let mut next = 0;
        while next < tree.nodes.len() {
            tree.split(next, &boxes);
            next += 1;
        }
        tree
    }

    fn node(&self, boxes: &[[DVec3; 2]], first: usize, count: usize) -> Node {
        let bounds = self.items[first..first + count].iter().map(|&item| boxes[item as usize]);
        let bounds =
            bounds.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], other| [lo.min(other[0]), hi.max(other[1])]);
        Node { bounds, first: first as u32, count: count as u32, children: 0 }
    }

    fn split(&mut self, node: usize, boxes: &[[DVec3; 2]]) {
        let Node { bounds: [lo, hi], first, count, .. } = self.nodes[node];
        let (first, count) = (first as usize, count as usize);
        if count <= LEAF {
            return;
        }
        let axis = (0..3).max_by(|&a, &b| (hi - lo)[a].total_cmp(&(hi - lo)[b])).expect("three axes");
        let middle = |item: u32| boxes[item as usize].iter().map(|corner| corner[axis]).sum::<f64>();
        let half = count / 2;
        self.items[first..first + count].select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)));
        let children = [self.node(boxes, first, half), self.node(boxes, first + half, count - half)];
        self.nodes[node].children = self.nodes.len() as u32;
        self.nodes.extend(children);
    }

    fn bounds(&self) -> [DVec3; 2] {
        self.nodes[0].bounds
    }

    /// Calls `meet` with the number of each box that the line may meet between its start and `end`, which `meet` may
    /// move. Near boxes come first.
    fn visit(&self, line: &Line, end: &mut f64, meet: &mut dyn FnMut(u32, &mut f64)) {
        let [lo, hi] = self.bounds();
        let largest = lo.abs().max(hi.abs()).max(line.origin.abs()).max_element();
        let (pad, inverse) = (largest * PADDING, 1.0 / line.dir);
        let entry = |node: &Node| {
            let [lo, hi] = node.bounds;
            let (a, b) = ((lo - pad - line.origin) * inverse, (hi + pad - line.origin) * inverse);
            let (entry, exit) = (a.min(b).max_element(), a.max(b).min_element());
            // The rounding of `inverse` is relative to the distance.
            let slack = |t: f64| if t.is_finite() { 1e-12 * t.abs() } else { 0.0 };
            let (entry, exit) = (entry - slack(entry), exit + slack(exit));
            (entry <= exit && exit >= line.start).then_some(entry)
        };
        let mut stack: Vec<(f64, u32)> = entry(&self.nodes[0]).map(|entry| (entry, 0)).into_iter().collect();
        while let Some((at, number)) = stack.pop() {
            if at > *end {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.children == 0 {
                let items = &self.items[node.first as usize..(node.first + node.count) as usize];
                items.iter().for_each(|&item| meet(item, end));
                continue;
            }
            let mut children = [0, 1].map(|child| {
                let number = node.children + child;
                (entry(&self.nodes[number as usize]), number)
            });
            children.sort_by(|(a, _), (b, _)| b.partial_cmp(a).unwrap_or(std::cmp::Ordering::Equal));
            stack.extend(children.iter().filter_map(|&(entry, number)| Some((entry?, number))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Quadric;
    use crate::study::workload::{in_cube, rng};
    use crate::tracer::{Mesh, Placement};

    fn triangle(vertices: [[f32; 3]; 3]) -> Triangle {
        let [v0, v1, v2] = vertices.map(Vec3::from);
        Triangle { v0, v1, v2 }
    }

    fn world(triangles: &[Triangle]) -> World {
        Mesh::from_triangles(triangles).unwrap().into()
    }

    fn hit(primitive: u32) -> Hit<f32> {
        Hit { primitive, instance: 0, ..Hit::<f32>::new(true, 1.0, 0.0, 0.0) }
    }

    /// A ray down at a point of the plane `z = 0`.
    fn down(x: f32, y: f32) -> Ray<f32> {
        Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z)
    }

    /// A square of two triangles, and a larger triangle below it.
    fn square() -> World {
        world(&[
            triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]]),
            triangle([[0.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]]),
            triangle([[-9.0, -9.0, -1.0], [19.0, -9.0, -1.0], [-9.0, 19.0, -1.0]]),
        ])
    }

    #[test]
    fn reports_are_judged_by_what_the_ray_exactly_hits() {
        use Judgement::{False, Lost, Neighbour, Right};
        let world = square();
        let truth = SceneTruth::new(&world);
        let judge = |ray: &Ray<f32>| {
            let answer = truth.answer(ray, false);
            [Hit::MISS, hit(0), hit(1), hit(2)].map(|hit| truth.judge(&answer, ray, &hit))
        };
        assert_eq!(judge(&down(3.0, 1.0)), [Lost, Right, Neighbour, Lost], "inside the first triangle");
        assert_eq!(judge(&down(2.0, 2.0)), [Lost, Right, Right, Lost], "on the diagonal");
        assert_eq!(judge(&down(4.0, 2.0)), [Lost, Right, Neighbour, Right], "on the border: it may count or not");
        assert_eq!(judge(&down(5.0, 1.0)), [Lost, False, False, Right], "beside the square");
        assert_eq!(judge(&down(18.0, 18.0)), [Right, False, False, False], "beside everything");
        let any = |ray: &Ray<f32>| [false, true].map(|hit| SceneTruth::judge_any(&truth.answer(ray, true), hit));
        assert_eq!(any(&down(3.0, 1.0)), [Lost, Right]);
        assert_eq!(any(&down(18.0, 18.0)), [Right, False]);
        let ray = Ray { t_max: 1.5, ..down(4.0, 2.0) };
        assert_eq!(any(&ray), [Right, Right], "only a border");
        assert_eq!(judge(&ray), [Right, Right, Neighbour, False], "only a border");
        assert!(truth.answer(&ray, false).is_open());
    }

    #[test]
    fn displacements_are_relative_to_the_distance_or_to_the_object() {
        let world = square();
        let truth = SceneTruth::new(&world);
        let displacement = |origin_z: f32, dir_z: f32, primitive, error: f32| {
            let ray = Ray::new(Vec3::new(3.0, 1.0, origin_z), Vec3::Z * dir_z);
            let answer = truth.answer(&ray, false);
            truth.displacement(&answer, &ray, &Hit { t: origin_z / -dir_z + error, ..hit(primitive) })
        };
        assert_eq!(displacement(2.0, -1.0, 0, 0.5), Some(0.25));
        assert_eq!(displacement(2.0, -4.0, 0, 0.125), Some(0.25), "t is in units of the direction");
        let diagonal = (28.0f64 * 28.0 * 2.0 + 1.0).sqrt();
        assert_eq!(displacement(4096.0, -1.0, 0, -2.0), Some(2.0 / diagonal), "the object is smaller");
        assert_eq!(displacement(2.0, -1.0, 1, 0.5), None, "another triangle");
        let ray = down(18.0, 18.0);
        assert_eq!(truth.displacement(&truth.answer(&ray, false), &ray, &Hit::MISS), None);
    }

    #[test]
    fn an_edge_is_solid_unless_its_triangles_face_different_ways() {
        // A ridge along x. A ray along y touches it; a ray along z crosses it. Seen from above, both triangles wind the
        // same way.
        let ridge = world(&[
            triangle([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -1.0]]),
            triangle([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, -1.0]]),
        ]);
        let truth = SceneTruth::new(&ridge);
        let touching = truth.answer(&Ray::new(Vec3::new(0.0, -5.0, 0.0), Vec3::Y), false);
        assert!(touching.is_open() && touching.accepted.len() == 2);
        let crossing = truth.answer(&Ray::new(Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z), false);
        assert!(crossing.solid && crossing.accepted.len() == 2);
        let solid = square();
        assert!(SceneTruth::new(&solid).answer(&down(1.0, 1.0), false).solid);
    }

    #[test]
    fn everything_at_the_least_t_is_accepted() {
        // More triangles than a leaf of the tree holds.
        let same = [triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]]); 20];
        let answer = SceneTruth::new(&world(&same)).answer(&down(3.0, 1.0), false);
        assert!(answer.solid && answer.accepted.len() == same.len(), "{answer:?}");
    }

    #[test]
    fn instances_share_no_edge_and_no_vertex() {
        // A square of one triangle and the same triangle, turned around the middle of its longest edge.
        let mesh = Mesh::from_triangles(&[triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]])]).unwrap();
        let matrix3 = glam::Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0));
        let turned = Affine3 { matrix3, translation: Vec3::new(4.0, 4.0, 0.0) };
        let placements = [Affine3::IDENTITY, turned].map(|object_to_world| Placement::new(0, object_to_world));
        let world = World::new(vec![Geometry::Mesh(mesh)], placements.into()).unwrap();
        let truth = SceneTruth::new(&world);
        let edge = truth.answer(&down(2.0, 2.0), false);
        assert!(edge.is_open() && edge.accepted.len() == 2, "{edge:?}");
        let inside = down(3.0, 1.0);
        let other = Hit { instance: 1, ..hit(0) };
        assert_eq!(truth.judge(&truth.answer(&inside, false), &inside, &other), Judgement::False);
    }

    #[test]
    fn a_disc_ends_at_its_circle() {
        let placements = vec![Placement::new(0, Affine3::IDENTITY)];
        let world = World::new(vec![Geometry::closed_cylinder(5.0, 0.5)], placements).unwrap();
        let truth = SceneTruth::new(&world);
        let answer = |y| truth.answer(&down(3.0, y), false);
        assert!(answer(3.9).solid, "inside");
        assert!(answer(4.0).is_open(), "on the circle");
        assert!(answer(4.1).accepted.is_empty(), "between the circle and the square around it");
    }

    #[test]
    fn the_tree_overlooks_nothing() {
        let mut rng = rng(7, "scene", "truth", &[], 0);
        let mut vector = |size| in_cube(&mut rng, size);
        let triangles: Vec<_> = (0..60)
            .map(|_| {
                let (at, [a, b, c]) = (vector(4.0), [0, 1, 2].map(|_| vector(1.0)));
                Triangle { v0: at + a, v1: at + b, v2: at + c }
            })
            .collect();
        let geometries = vec![
            Geometry::Mesh(Mesh::from_triangles(&triangles).unwrap()),
            Quadric::ellipsoid(Vec3::new(1.0, 2.0, 0.5)).into(),
            Geometry::closed_cylinder(1.0, 0.5),
        ];
        let mut placements: Vec<_> = (0..20)
            .map(|number| {
                let [x, y, z] = [0, 1, 2].map(|_| vector(1.0));
                let matrix3 = glam::Mat3::from_cols(x + Vec3::X, y + Vec3::Y, z + Vec3::Z);
                Placement::new(number % 3, Affine3 { matrix3, translation: vector(1e3) })
            })
            .collect();
        placements.push(Placement::new(0, Affine3::IDENTITY));
        let world = World::new(geometries, placements).unwrap();
        let truth = SceneTruth::new(&world);
        let mut hits = 0;
        for _ in 0..2000 {
            let target = world.instances()[(vector(1.0).x.abs() * 20.99) as usize].object_to_world.translation;
            let origin = vector(1e3);
            let ray = Ray::new(origin, target + vector(3.0) - origin);
            let mut all: Vec<(f32, Place)> = Vec::new();
            for (instance, placement) in (0..).zip(world.instances()) {
                let first = truth.first_primitive[placement.geometry as usize];
                for number in 0..world.geometries()[placement.geometry as usize].primitives() as u32 {
                    let place = Place { instance, primitive: first + number };
                    let truth = truth.truth(place, &ray);
                    if truth.hit {
                        assert!(!truth.boundary, "random rays meet no boundary");
                        all.push((truth.t, place));
                    }
                }
            }
            let least = all.iter().map(|(t, _)| *t).fold(f32::INFINITY, f32::min);
            let nearest: Vec<_> = all.iter().filter(|(t, _)| *t == least).map(|(_, place)| *place).collect();
            let answer = truth.answer(&ray, false);
            let accepted: Vec<_> = answer.accepted.iter().map(|&(place, _)| place).collect();
            assert_eq!((accepted, answer.solid), (nearest, !all.is_empty()), "{ray:?}");
            assert_eq!(truth.answer(&ray, true).solid, !all.is_empty(), "{ray:?}");
            hits += usize::from(!all.is_empty());
        }
        assert!(hits > 300, "{hits}");
    }
}
