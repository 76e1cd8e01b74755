//! What `trace` and `render` share: the kernels and the scene that their arguments name.

use std::marker::PhantomData;
use std::path::Path;

use raylanes::geom::{Quadric, Triangle};
use raylanes::kernels::{Kernel, Shape};
use raylanes::registry::{self, Task, Visitor};
use raylanes::study::Progress;
use raylanes::study::advice::Plan;
use raylanes::tracer::{
    Camera, Error, Light, LoadedScene, Mode, Scene, SceneSource, View, ViewError, World, check_output, printable,
    thread_pool,
};
use rayon::ThreadPool;

use super::args::SceneArguments;
use super::terminal;

/// Vertical field of view in degrees of a camera given by `--eye`.
const FIELD_OF_VIEW: f32 = 60.0;

/// A loaded scene. No kernel has prepared it yet.
pub(super) struct Loaded {
    pub(super) world: World,
    /// An error if the view gives no picture.
    pub(super) camera: Result<Camera, Error>,
    pub(super) light: Light,
}

impl SceneArguments {
    /// Looks up the kernels and the mode that were asked for.
    pub(super) fn kernels_and_mode(&self) -> Result<(ChosenKernels, Mode), Error> {
        if let Some(plan) = &self.plan {
            let Plan { kernel, quadric_kernel, mode } = Plan::read(plan)?;
            return Ok((ChosenKernels { triangle: kernel, quadric: quadric_kernel }, mode));
        }
        let kernels = ChosenKernels { triangle: "", quadric: "" }
            .with(&self.kernel, &["triangle"])?
            .with(&self.quadric_kernel, &["quadric"])?;
        Ok((kernels, self.mode))
    }

    /// Starts the threads that the scene is loaded, built and traced with.
    pub(super) fn pool(&self) -> Result<ThreadPool, Error> {
        thread_pool(self.threads.into())
    }

    /// The scene as it was given, for a message.
    pub(super) fn name(&self) -> String {
        printable(&self.scene)
    }

    /// Loads the scene. Remarks about its files go to standard error. Refuses to write `outputs` over one of its files.
    pub(super) fn load(&self, outputs: &[&Path], progress: &Progress) -> Result<Loaded, Error> {
        progress.note(&format!("{}: loading", self.name()));
        let source = SceneSource::parse(&self.scene)?;
        let LoadedScene { world, mut view, remarks } = source.load()?;
        outputs.iter().try_for_each(|output| check_output(output))?;
        progress.suspend(|| terminal::remarks(&source.name(), &remarks));
        if let (Some(eye), Some(look_at)) = (self.eye, self.look_at) {
            view = View { eye, look_at, vertical_fov: FIELD_OF_VIEW, transform: None, light: view.light };
        }
        view.vertical_fov = self.fov.unwrap_or(view.vertical_fov);
        let (width, height) = self.size;
        let in_scene = |error: ViewError| Error::Argument { argument: source.name(), message: error.to_string() };
        let camera = view.check(&world).map(|()| view.camera(width, height)).map_err(in_scene);
        Ok(Loaded { world, camera, light: view.light })
    }
}

/// The IDs of one registered triangle kernel and one registered quadric kernel.
#[derive(Clone, Copy)]
pub(super) struct ChosenKernels {
    pub(super) triangle: &'static str,
    pub(super) quadric: &'static str,
}

impl ChosenKernels {
    /// Replaces the triangle or the quadric kernel by the one with this ID. The ID may leave out the family;
    /// `families` lists the families to search.
    pub(super) fn with(self, id: &str, families: &[&str]) -> Result<Self, Error> {
        let triangle = families.contains(&"triangle").then(|| registry::id_of::<Triangle>(id)).flatten();
        let quadric = families.contains(&"quadric").then(|| registry::id_of::<Quadric>(id)).flatten();
        match (triangle, quadric) {
            (Some(triangle), _) => Ok(Self { triangle, ..self }),
            (None, Some(quadric)) => Ok(Self { quadric, ..self }),
            (None, None) => {
                let mut ids = Ids(Vec::new());
                registry::triangles(&mut ids);
                registry::quadrics(&mut ids);
                ids.0.retain(|id| families.iter().any(|family| id.starts_with(family)));
                let message = format!("no such {} kernel: expected one of {}", families.join(" or "), ids.0.join(", "));
                Err(Error::Argument { argument: id.into(), message })
            }
        }
    }

    /// Builds the scene: prepares the world for triangle kernel `K` and for the chosen quadric kernel.
    pub(super) fn scene<K: Kernel<Shape = Triangle>>(self, world: World) -> Scene<K> {
        struct Build<K>(World, PhantomData<K>);
        impl<K: Kernel<Shape = Triangle>> Task<Quadric> for Build<K> {
            type Output = Scene<K>;
            fn run<Q: Kernel<Shape = Quadric>>(self) -> Scene<K> {
                Scene::with_quadrics::<Q>(self.0)
            }
        }
        registry::with_kernel(self.quadric, Build::<K>(world, PhantomData)).expect("the kernel was found before")
    }

    /// Runs a task with the chosen triangle kernel.
    pub(super) fn run<T: Task<Triangle>>(self, task: T) -> T::Output {
        registry::with_kernel(self.triangle, task).expect("the kernel was found before")
    }
}

struct Ids(Vec<String>);

impl<S: Shape> Visitor<S> for Ids {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.push(K::INFO.id.to_string());
    }
}
