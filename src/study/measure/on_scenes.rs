//! The same scenes for every kernel: how many rays of a picture get a wrong answer.
//!
//! All kernels get the same trees and the same rays, which start where the exact kernel hits. Every answer is compared
//! with the exact one of the whole scene ([`SceneTruth`]). So the figures say what a picture suffers, and not what a
//! kernel does where rays are aimed at its weakness.

use rand::RngExt;
use rayon::prelude::*;

use super::built_scene::{BuiltScene, TracerKernel};
use super::ray_sets::{EDGES, RaySet};
use super::scene_truth::{Answer, Judgement, SceneTruth};
use super::tally::quantile;
use crate::geom::{Hit, Quadric, Ray, Triangle};
use crate::kernels::Kernel;
use crate::kernels::quadric::Mixed;
use crate::registry::{self, Visitor};
use crate::study::progress::Progress;
use crate::study::record::OnSceneRow;
use crate::study::workload;
use crate::tracer::{Error, Mode, Scene, SceneSource, checksum, trace, trace_set_into};

/// The greatest displacement of a right hit that does not count: see [`OnSceneRow::displaced`].
pub(crate) const MOST_DISPLACED: f64 = 1e-3;

/// A set of rays, and the exact answer for each.
pub(crate) struct Answered {
    pub(crate) set: RaySet,
    answers: Vec<Answer>,
}

impl Answered {
    pub(crate) fn new(truth: &SceneTruth, set: RaySet) -> Self {
        let answers = set.rays.par_iter().map(|ray| truth.answer(ray, set.any_hit)).collect();
        Self { set, answers }
    }

    /// Whether a ray hits anything.
    pub(crate) fn hits(&self) -> bool {
        self.answers.iter().any(|answer| answer.solid)
    }

    /// Judges a kernel: compares its answers for these rays with the exact ones. `most_displaced` is the greatest
    /// displacement of a right hit that does not count.
    pub(crate) fn judge<K: Kernel<Shape = Triangle>>(
        &self,
        truth: &SceneTruth,
        [scene_name, kernel]: [&str; 2],
        scene: &Scene<K>,
        most_displaced: f64,
    ) -> OnSceneRow {
        let Self { set, answers } = self;
        let mut hits = vec![Hit::MISS; set.rays.len()];
        trace_set_into(scene, &set.rays, set.any_hit, Mode::Auto, &mut hits);
        let judged = set.rays.par_iter().zip(answers).zip(&hits).map(|((ray, answer), hit)| {
            if set.any_hit {
                (SceneTruth::judge_any(answer, hit.mask), None)
            } else {
                (truth.judge(answer, ray, hit), truth.displacement(answer, ray, hit))
            }
        });
        let (judged, displacements): (Vec<Judgement>, Vec<_>) = judged.unzip();
        let mut displacements: Vec<f64> = displacements.into_iter().flatten().collect();
        let displaced = displacements.iter().filter(|&&displacement| displacement > most_displaced).count() as u64;
        let last = quantile(0.99, displacements.len());
        let has_hits = !displacements.is_empty();
        let displacement_p99 =
            if has_hits { *displacements.select_nth_unstable_by(last, f64::total_cmp).1 } else { 0.0 };
        let count = |judgement| judged.iter().filter(|&&other| other == judgement).count() as u64;
        OnSceneRow {
            scene: scene_name.into(),
            rays: set.name.into(),
            kernel: kernel.into(),
            ray_count: set.rays.len() as u64,
            solid: answers.iter().filter(|answer| answer.solid).count() as u64,
            open: answers.iter().filter(|answer| answer.is_open()).count() as u64,
            lost: count(Judgement::Lost),
            false_hits: count(Judgement::False),
            neighbours: count(Judgement::Neighbour),
            displaced,
            displacement_p99,
            checksum: format!("{:016x}", checksum(&hits)),
        }
    }
}

/// A scene, its rays, and the exact answers.
struct Asked<'a> {
    built: &'a BuiltScene,
    truth: &'a SceneTruth<'a>,
    /// The sets of a picture, and the rays aimed at edges.
    sets: Vec<Answered>,
    rows: Vec<OnSceneRow>,
}

/// Judges every kernel on the rays of a picture of `size` × `size` pixels of one scene.
///
/// # Errors
/// If the scene cannot be loaded.
pub(crate) fn judge(
    source: &SceneSource,
    (size, seed): (u32, u64),
    progress: &Progress,
) -> Result<Vec<OnSceneRow>, Error> {
    progress.note(&format!("{}: exact answers", source.name()));
    let built = BuiltScene::new(source, (size, seed))?;
    let truth = SceneTruth::new(built.scene.world());
    let edges = edge_rays(&built.scene, &built.sets[0].rays, &truth, seed);
    let sets = built.sets.iter().cloned().chain([edges]).filter(|set| !set.rays.is_empty());
    let sets = sets.map(|set| Answered::new(&truth, set)).collect();
    let mut asked = Asked { built: &built, truth: &truth, sets, rows: Vec::new() };
    progress.reach(0.5);
    progress.note(&format!("{}: kernels", built.name));
    for_each_kernel(&built.scene, &mut asked);
    progress.reach(1.0);
    Ok(asked.rows)
}

/// Rays from the origins of these rays at random points on edges of the triangles that they hit, one for each hit.
pub(crate) fn edge_rays(scene: &Scene<TracerKernel>, rays: &[Ray<f32>], truth: &SceneTruth, seed: u64) -> RaySet {
    let hits = trace(scene, rays, Mode::Auto);
    let at_edge = |(number, (ray, hit)): (u64, (&Ray<f32>, &Hit<f32>))| {
        let [v0, v1, v2] = truth.vertices(hit)?;
        let mut rng = workload::rng(seed, "scene", "edges", &[], number);
        let [from, to] = [[v0, v1], [v1, v2], [v2, v0]][rng.random_range(0..3)];
        Some(Ray::new(ray.origin, from.lerp(to, rng.random()) - ray.origin))
    };
    let rays = (0..).zip(rays.iter().zip(&hits)).filter_map(at_edge).collect();
    RaySet { name: EDGES, any_hit: false, rays }
}

/// Something that is done with a scene for each kernel.
pub(super) trait ForKernels {
    /// Called with the ID of a kernel, and the scene prepared for it.
    fn scene<K: Kernel<Shape = Triangle>>(&mut self, id: &str, scene: Scene<K>);
}

/// Prepares a scene for each kernel of its triangles and of its quadrics. While one of both varies, the other is that
/// of the tracer.
pub(super) fn for_each_kernel(scene: &Scene<TracerKernel>, action: &mut impl ForKernels) {
    // A few triangles among quadrics, such as a ground, tell nothing about a kernel for triangles.
    let (triangles, quadrics) = (scene.world().triangles(), scene.world().quadrics());
    if triangles > quadrics {
        registry::triangles(&mut Prepared { scene, action });
    }
    if quadrics > 0 {
        registry::quadrics(&mut Prepared { scene, action });
    }
}

struct Prepared<'a, A> {
    scene: &'a Scene<TracerKernel>,
    action: &'a mut A,
}

impl<A: ForKernels> Visitor<Triangle> for Prepared<'_, A> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        self.action.scene(&K::INFO.id.to_string(), self.scene.prepared_for::<K, Mixed<f32>>());
    }
}

impl<A: ForKernels> Visitor<Quadric> for Prepared<'_, A> {
    fn visit<K: Kernel<Shape = Quadric>>(&mut self) {
        self.action.scene(&K::INFO.id.to_string(), self.scene.prepared_for::<TracerKernel, K>());
    }
}

impl ForKernels for Asked<'_> {
    fn scene<K: Kernel<Shape = Triangle>>(&mut self, id: &str, scene: Scene<K>) {
        let names = [self.built.name.as_str(), id];
        let rows = self.sets.iter().map(|set| set.judge(self.truth, names, &scene, MOST_DISPLACED));
        self.rows.extend(rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a small picture: the kernel's lost and false rays in pictures, and at edges.
    fn wrong(scene: &str, kernel: &str) -> [u64; 2] {
        let rows = judge(&SceneSource::parse(scene).unwrap(), (48, 1), &Progress::bar()).unwrap();
        let sum = |edges: bool| {
            let rows = rows.iter().filter(|row| row.kernel == kernel && (row.rays == EDGES) == edges);
            rows.map(|row| row.lost + row.false_hits).sum()
        };
        assert!(rows.iter().any(|row| row.kernel == kernel && row.solid > 500));
        [sum(false), sum(true)]
    }

    #[test]
    fn exact_kernels_are_right_in_scenes_and_others_are_not() {
        assert_eq!(wrong("sphere:1e3", "triangle/exact"), [0, 0]);
        let [pictures, _] = wrong("sphere:1e3", "triangle/baldwin_weber");
        assert!(pictures > 50, "prepared planes shadow themselves: {pictures}");
        let [_, edges] = wrong("terrain:1e3", "triangle/moller_trumbore");
        assert!(edges > 10, "{edges}");
        assert_eq!(wrong("gallery", "quadric/f64")[0], 0);
    }

    #[test]
    fn rays_and_answers_of_each_kind_are_counted_apart() {
        let rows = |scene| judge(&SceneSource::parse(scene).unwrap(), (48, 1), &Progress::bar()).unwrap();
        let find = |rows: &[OnSceneRow], rays, kernel| {
            rows.iter().find(|row| row.rays == rays && row.kernel == kernel).unwrap().clone()
        };
        let sphere = rows("sphere:1e3");
        let background = find(&sphere, "primary", "triangle/exact");
        assert!(background.solid > 500 && background.solid < background.ray_count / 2, "{background:?}");
        assert_eq!(background.open, 0);
        // A false hit beside an edge of a closed mesh is one of a neighbour.
        let edges = find(&sphere, EDGES, "triangle/moller_trumbore");
        assert!(edges.neighbours > 100 && edges.false_hits < 10, "{edges:?}");
        // The ground of the gallery has a border.
        let gallery = rows("gallery");
        let border = find(&gallery, EDGES, "quadric/f64");
        assert!(
            border.solid > 100 && border.open > 100 && border.solid + border.open <= border.ray_count,
            "{border:?}"
        );
        assert!(gallery.iter().all(|row| row.kernel.starts_with("quadric/")), "most of it is quadrics");
    }

    #[test]
    fn rays_are_aimed_at_all_edges_of_the_triangles_that_are_seen() {
        let built = BuiltScene::new(&SceneSource::parse("sphere:1e3").unwrap(), (48, 1)).unwrap();
        let truth = SceneTruth::new(built.scene.world());
        let hits = trace(&built.scene, &built.sets[0].rays, Mode::Auto);
        let seen = hits.iter().filter_map(|hit| truth.vertices(hit));
        let mut aimed = [0; 3];
        for (vertices, ray) in seen.zip(&edge_rays(&built.scene, &built.sets[0].rays, &truth, 1).rays) {
            let distance = |edge: usize| {
                let (from, along) = (vertices[edge], (vertices[(edge + 1) % 3] - vertices[edge]).normalize());
                (ray.origin + ray.dir - from).cross(along).length()
            };
            let nearest = (0..3).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap();
            assert!(distance(nearest) < 1e-5, "{vertices:?} {ray:?}");
            aimed[nearest] += 1;
        }
        assert!(aimed.iter().all(|&rays| rays > 200), "{aimed:?}");
    }
}
