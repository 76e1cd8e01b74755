//! `raylanes render`: writes a picture, and on demand a second one that shows where two kernels differ.

use std::path::{Path, PathBuf};

use raylanes::geom::{Hit, Ray, Triangle};
use raylanes::kernels::Kernel;
use raylanes::registry::Task;
use raylanes::study::Progress;
use raylanes::tracer::{self, Differences, Error, Picture, Shade, Shot, World, printable_path};

use super::args::RenderArguments;
use super::memory;
use super::scene::{ChosenKernels, Loaded};

/// A ray, its hit, those of its shadow, its colour, and its bytes in the file.
const BYTES_PER_PIXEL: usize = 2 * (size_of::<Ray<f32>>() + size_of::<Hit<f32>>()) + 40;

pub(super) fn run(arguments: &RenderArguments, progress: &Progress) -> Result<String, Error> {
    let scene = &arguments.scene;
    // A large mesh takes long to load, so the other arguments are checked before it.
    let (kernels, mode) = scene.kernels_and_mode()?;
    let marked = with_name_ending(&arguments.out, "-compare");
    let mut outputs = vec![&*arguments.out];
    outputs.extend(arguments.compare.as_ref().map(|_| &*marked));
    outputs.iter().try_for_each(|output| tracer::check_output(output))?;
    let pool = scene.pool()?;
    let other = arguments.compare.as_deref().map(|id| kernels.with(id, &["triangle", "quadric"])).transpose()?;
    let Loaded { world, camera, light } = pool.install(|| scene.load(&outputs, progress))?;
    let (width, height) = scene.size;
    memory::check(&scene.name(), &world, width as usize * height as usize, BYTES_PER_PIXEL)?;
    let shot = Shot { camera: camera?, light, mode, width, height };
    let name = scene.name();
    pool.install(|| {
        progress.note(&format!("{name}: rendering"));
        let (picture, hits, world) = kernels.run(Render { kernels, world, shot: &shot, shade: arguments.shade.into() });
        picture.write(&arguments.out)?;
        let Some(other) = other else { return Ok(String::new()) };
        progress.note(&format!("{name}: comparing"));
        let other_hits = other.run(FindHits { kernels: other, world, shot: &shot });
        let (picture, differences) = tracer::compare(&shot, &picture, &hits, &other_hits);
        picture.write(&marked)?;
        let [first, second] = if kernels.triangle == other.triangle {
            [kernels.quadric, other.quadric]
        } else {
            [kernels.triangle, other.triangle]
        };
        let Differences { only_first, only_second, other_primitive, other_t, .. } = differences;
        Ok(format!(
            "{} of {} pixels differ: {only_first} are hit by {first} only (red), {only_second} by {second} only \
             (blue), and {other_primitive} show different primitives or instances (yellow); see {}\n\
             On {other_t} more pixels both hit the same primitive, but t differs.\n",
            differences.marked(),
            hits.len(),
            printable_path(&marked)
        ))
    })
}

/// Builds the scene, finds the hits and shades them. Returns the world, so that it can be traced again.
pub(super) struct Render<'a> {
    pub(super) kernels: ChosenKernels,
    pub(super) world: World,
    pub(super) shot: &'a Shot,
    pub(super) shade: Shade,
}

impl Task<Triangle> for Render<'_> {
    type Output = (Picture, Vec<Hit<f32>>, World);

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        let Self { kernels, world, shot, shade } = self;
        let scene = kernels.scene::<K>(world);
        let hits = tracer::picture_hits(&scene, shot);
        (tracer::shade(&scene, shot, &hits, shade), hits, scene.into_world())
    }
}

/// Builds the scene and finds the hits.
struct FindHits<'a> {
    kernels: ChosenKernels,
    world: World,
    shot: &'a Shot,
}

impl Task<Triangle> for FindHits<'_> {
    type Output = Vec<Hit<f32>>;

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        tracer::picture_hits(&self.kernels.scene::<K>(self.world), self.shot)
    }
}

/// Adds `ending` to the file's name, before the extension: `out.png` becomes `out-compare.png`.
fn with_name_ending(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(ending);
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}
