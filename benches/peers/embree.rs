//! Embree 4, loaded at run time. This is the only file of the package with unsafe code.
//!
//! S. Woop, C. Benthin, A. T. Áfra, I. Wald, "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014. The
//! declarations follow `include/embree4/rtcore_*.h`.
//!
//! The unsafe code relies on the following. The library is Embree, major version 4. Every pointer passed to it lives
//! for the whole call, has the alignment that the headers demand, and points to the declared layout (asserted below). A
//! committed scene may be traced from any thread.
#![allow(unsafe_code, reason = "a C library can only be called by unsafe code")]

use std::ffi::{c_char, c_void};
use std::fmt;
use std::mem::offset_of;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::time::Instant;

use libloading::Library;
use raylanes::geom::{Hit, Ray};
use raylanes::study::peers::{Tracer, in_chunks};
use raylanes::tracer::{Error, Mesh};
use wide::f32x8;

const INVALID: u32 = u32::MAX;
const FORMAT_FLOAT3: u32 = 0x9003;
const FORMAT_UINT3: u32 = 0x5003;
const BUFFER_TYPE_INDEX: u32 = 0;
const BUFFER_TYPE_VERTEX: u32 = 1;
const GEOMETRY_TYPE_TRIANGLE: u32 = 0;
const SCENE_FLAG_ROBUST: u32 = 1 << 2;
const QUERY_FLAG_COHERENT: u32 = 1 << 16;
const PROPERTY_VERSION_MAJOR: u32 = 1;
const PROPERTY_VERSION_MINOR: u32 = 2;
const PROPERTY_VERSION_PATCH: u32 = 3;
const PROPERTY_NATIVE_RAY16_SUPPORTED: u32 = 34;

/// `RTCRay`.
#[repr(C, align(16))]
struct RtcRay {
    origin: [f32; 3],
    t_near: f32,
    dir: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// `RTCHit`. The last field exists only in some builds of the library. It is not read.
#[repr(C, align(16))]
struct RtcHit {
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: u32,
    instance_primitive: u32,
}

/// `RTCRayHit`.
#[repr(C)]
struct RtcRayHit {
    ray: RtcRay,
    hit: RtcHit,
}

/// `RTCRay8` and `RTCRay16`. The alignment is that of `RTCRay16`, which is the stricter one.
#[repr(C, align(64))]
struct RtcRays<const N: usize> {
    origin: [[f32; N]; 3],
    t_near: [f32; N],
    dir: [[f32; N]; 3],
    time: [f32; N],
    t_far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

/// `RTCHit8` and `RTCHit16`.
#[repr(C, align(64))]
struct RtcHits<const N: usize> {
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    primitive: [u32; N],
    geometry: [u32; N],
    instance: [u32; N],
    instance_primitive: [u32; N],
}

/// `RTCRayHit8` and `RTCRayHit16`.
#[repr(C)]
struct RtcRayHits<const N: usize> {
    rays: RtcRays<N>,
    hits: RtcHits<N>,
}

/// Which rays of a packet to trace: -1 to trace, 0 to skip.
#[repr(C, align(64))]
struct Valid<const N: usize>([i32; N]);

/// `RTCIntersectArguments` and `RTCOccludedArguments`. The last field exists only in some builds of the library.
#[repr(C)]
struct RtcArguments {
    flags: u32,
    feature_mask: u32,
    context: *mut c_void,
    filter: *const c_void,
    callback: *const c_void,
    min_width_distance_factor: f32,
}

// The layout of the C compiler: sizes and offsets in bytes.
const _: () = {
    assert!(size_of::<RtcRay>() == 48 && align_of::<RtcRayHit>() == 16 && size_of::<RtcRayHit>() == 96);
    assert!(offset_of!(RtcRay, t_near) == 12 && offset_of!(RtcRay, dir) == 16 && offset_of!(RtcRay, t_far) == 32);
    assert!(offset_of!(RtcRay, mask) == 36 && offset_of!(RtcRay, flags) == 44 && offset_of!(RtcRayHit, hit) == 48);
    assert!(offset_of!(RtcHit, u) == 12 && offset_of!(RtcHit, primitive) == 20 && offset_of!(RtcHit, geometry) == 24);
    assert!(offset_of!(RtcHit, instance) == 28 && offset_of!(RtcHit, instance_primitive) == 32);
    assert!(size_of::<RtcRays<8>>() == 384 && size_of::<RtcRays<16>>() == 768);
    assert!(offset_of!(RtcRays<8>, t_near) == 96 && offset_of!(RtcRays<8>, dir) == 128);
    assert!(offset_of!(RtcRays<8>, t_far) == 256 && offset_of!(RtcRays<8>, flags) == 352);
    assert!(offset_of!(RtcRays<16>, t_far) == 512 && offset_of!(RtcRayHits<16>, hits) == 768);
    assert!(offset_of!(RtcRayHits<8>, hits) == 384 && offset_of!(RtcHits<8>, u) == 96);
    assert!(offset_of!(RtcHits<8>, primitive) == 160 && offset_of!(RtcHits<8>, geometry) == 192);
    assert!(offset_of!(RtcHits<16>, primitive) == 320 && offset_of!(RtcHits<16>, instance) == 448);
    assert!(align_of::<Valid<8>>() >= 32 && align_of::<Valid<16>>() == 64);
    assert!(offset_of!(RtcArguments, context) == 8 && offset_of!(RtcArguments, callback) == 8 + 2 * size_of::<usize>());
};

type Handle = *mut c_void;
type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
type Query1<R> = unsafe extern "C" fn(Handle, *mut R, *mut RtcArguments);
type QueryN<R> = unsafe extern "C" fn(*const i32, Handle, *mut R, *mut RtcArguments);

/// Declares the functions that are used, and code that loads them all.
macro_rules! api {
    ($($name:ident: $symbol:literal, $type:ty;)*) => {
        struct Api {
            $($name: $type,)*
        }

        impl Api {
            fn new(library: Library) -> Result<Self, libloading::Error> {
                // SAFETY: these are the types of the functions of these names in Embree 4.
                let api = unsafe { Self { $($name: *library.get::<$type>($symbol)?,)* } };
                // The library stays loaded, because its threads may outlive the last device.
                std::mem::forget(library);
                Ok(api)
            }
        }
    };
}

api! {
    new_device: c"rtcNewDevice", unsafe extern "C" fn(*const c_char) -> Handle;
    release_device: c"rtcReleaseDevice", unsafe extern "C" fn(Handle);
    device_property: c"rtcGetDeviceProperty", unsafe extern "C" fn(Handle, u32) -> isize;
    device_error: c"rtcGetDeviceError", unsafe extern "C" fn(Handle) -> u32;
    set_memory_monitor: c"rtcSetDeviceMemoryMonitorFunction", unsafe extern "C" fn(Handle, MemoryMonitor, *mut c_void);
    new_scene: c"rtcNewScene", unsafe extern "C" fn(Handle) -> Handle;
    release_scene: c"rtcReleaseScene", unsafe extern "C" fn(Handle);
    set_scene_flags: c"rtcSetSceneFlags", unsafe extern "C" fn(Handle, u32);
    set_scene_quality: c"rtcSetSceneBuildQuality", unsafe extern "C" fn(Handle, u32);
    commit_scene: c"rtcCommitScene", unsafe extern "C" fn(Handle);
    new_geometry: c"rtcNewGeometry", unsafe extern "C" fn(Handle, u32) -> Handle;
    release_geometry: c"rtcReleaseGeometry", unsafe extern "C" fn(Handle);
    new_buffer: c"rtcSetNewGeometryBuffer", unsafe extern "C" fn(Handle, u32, u32, u32, usize, usize) -> *mut c_void;
    commit_geometry: c"rtcCommitGeometry", unsafe extern "C" fn(Handle);
    attach_geometry: c"rtcAttachGeometry", unsafe extern "C" fn(Handle, Handle) -> u32;
    intersect1: c"rtcIntersect1", Query1<RtcRayHit>;
    occluded1: c"rtcOccluded1", Query1<RtcRay>;
    intersect8: c"rtcIntersect8", QueryN<RtcRayHits<8>>;
    occluded8: c"rtcOccluded8", QueryN<RtcRays<8>>;
    intersect16: c"rtcIntersect16", QueryN<RtcRayHits<16>>;
    occluded16: c"rtcOccluded16", QueryN<RtcRays<16>>;
}

/// The loaded library.
pub(crate) struct Embree {
    api: Arc<Api>,
    /// Version, as reported by the library.
    pub(crate) version: String,
    /// Whether it traces sixteen rays natively, and not as two times eight.
    pub(crate) native16: bool,
}

impl Embree {
    /// Loads the library that the environment variable `EMBREE_LIB` names, or else the system's. `None` if there is
    /// none.
    ///
    /// # Errors
    /// If `EMBREE_LIB` is set but is not the path of a usable Embree 4.
    pub(crate) fn load() -> Result<Option<Self>, Error> {
        if let Some(path) = std::env::var_os("EMBREE_LIB") {
            let bad = |message: String| Error::Argument {
                argument: format!("EMBREE_LIB={}", path.display()),
                message: format!("expected the path of an Embree 4 library: {message}"),
            };
            return Self::open(Path::new(&path)).map(Some).map_err(bad);
        }
        let names = ["libembree4.so.4", "libembree4.so", "libembree4.4.dylib", "libembree4.dylib", "embree4.dll"];
        Ok(names.iter().find_map(|name| Self::open(Path::new(name)).ok()))
    }

    fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: loading runs the library's initialisers. Whoever names the library trusts it.
        let library = unsafe { Library::new(path) }.map_err(|error| reason(&error))?;
        let api = Arc::new(Api::new(library).map_err(|error| reason(&error))?);
        let device = Device::new(&api).ok_or("it cannot create a device")?;
        let property = |number| unsafe { (api.device_property)(device.handle, number) };
        let [major, minor, patch] =
            [PROPERTY_VERSION_MAJOR, PROPERTY_VERSION_MINOR, PROPERTY_VERSION_PATCH].map(property);
        let version = format!("{major}.{minor}.{patch}");
        if major != 4 {
            return Err(format!("expected version 4, found {version}"));
        }
        let native16 = property(PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
        drop(device);
        Ok(Self { api, version, native16 })
    }
}

/// The message of the operating system, which libloading does not print.
fn reason(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}

/// A device, and the number of bytes that it holds.
struct Device {
    api: Arc<Api>,
    handle: Handle,
    bytes: Box<AtomicIsize>,
}

impl Device {
    fn new(api: &Arc<Api>) -> Option<Self> {
        let handle = unsafe { (api.new_device)(c"".as_ptr()) };
        if handle.is_null() {
            return None;
        }
        unsafe extern "C" fn monitor(count: *mut c_void, bytes: isize, _post: bool) -> bool {
            // SAFETY: `count` points to the counter below, which outlives the device.
            unsafe { &*count.cast::<AtomicIsize>() }.fetch_add(bytes, Ordering::Relaxed);
            true
        }
        let bytes = Box::new(AtomicIsize::new(0));
        unsafe { (api.set_memory_monitor)(handle, monitor, std::ptr::from_ref(&*bytes).cast_mut().cast()) };
        Some(Self { api: api.clone(), handle, bytes })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        unsafe { (self.api.release_device)(self.handle) };
    }
}

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// The default: binned surface-area heuristic.
    Medium = 1,
    /// With spatial splits.
    High = 2,
}

/// How many rays a call traces, and with which flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Calls {
    /// One ray per call.
    One,
    /// Eight rays per call.
    Eight {
        /// With `RTC_RAY_QUERY_FLAG_COHERENT`.
        coherent: bool,
    },
    /// Sixteen rays per call.
    Sixteen {
        /// With `RTC_RAY_QUERY_FLAG_COHERENT`.
        coherent: bool,
    },
}

impl fmt::Display for Calls {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (rays, coherent) = match *self {
            Self::One => ("1 ray", false),
            Self::Eight { coherent } => ("8 rays", coherent),
            Self::Sixteen { coherent } => ("16 rays", coherent),
        };
        write!(f, "{rays}{}", if coherent { ", coherent" } else { "" })
    }
}

/// A committed scene of one mesh.
pub(crate) struct Scene {
    handle: Handle,
    device: Device,
    pub(crate) build_seconds: f64,
}

// SAFETY: a committed scene is only read.
unsafe impl Send for Scene {}
unsafe impl Sync for Scene {}

impl Scene {
    /// Builds a tree over the mesh, with all of Embree's threads.
    ///
    /// # Errors
    /// If the library reports an error.
    pub(crate) fn new(embree: &Embree, mesh: &Mesh, robust: bool, quality: Quality) -> Result<Self, Error> {
        let api = &embree.api;
        let failed = |code: u32| Error::Argument {
            argument: format!("Embree {}", embree.version),
            message: format!("cannot build the scene (RTCError {code})"),
        };
        let device = Device::new(api).ok_or_else(|| failed(0))?;
        let start = Instant::now();
        let handle = unsafe {
            let handle = (api.new_scene)(device.handle);
            (api.set_scene_flags)(handle, if robust { SCENE_FLAG_ROBUST } else { 0 });
            (api.set_scene_quality)(handle, quality as u32);
            let geometry = (api.new_geometry)(device.handle, GEOMETRY_TYPE_TRIANGLE);
            let points = mesh.positions();
            let buffer = (api.new_buffer)(geometry, BUFFER_TYPE_VERTEX, 0, FORMAT_FLOAT3, 12, points.len());
            if !buffer.is_null() {
                points.as_ptr().cast::<[f32; 3]>().copy_to_nonoverlapping(buffer.cast(), points.len());
            }
            let triangles = mesh.triangles();
            let buffer = (api.new_buffer)(geometry, BUFFER_TYPE_INDEX, 0, FORMAT_UINT3, 12, triangles.len());
            if !buffer.is_null() {
                triangles.as_ptr().copy_to_nonoverlapping(buffer.cast(), triangles.len());
            }
            (api.commit_geometry)(geometry);
            (api.attach_geometry)(handle, geometry);
            (api.release_geometry)(geometry);
            (api.commit_scene)(handle);
            handle
        };
        let scene = Self { handle, device, build_seconds: start.elapsed().as_secs_f64() };
        match unsafe { (api.device_error)(scene.device.handle) } {
            0 => Ok(scene),
            code => Err(failed(code)),
        }
    }

    /// Bytes that the library holds for the scene: mesh and tree.
    pub(crate) fn bytes(&self) -> usize {
        self.device.bytes.load(Ordering::Relaxed).unsigned_abs()
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        unsafe { (self.device.api.release_scene)(self.handle) };
    }
}

/// A scene, and the calls that trace it.
pub(crate) struct Caller {
    pub(crate) scene: Arc<Scene>,
    pub(crate) calls: Calls,
}

impl Tracer for Caller {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        let scene = &*self.scene;
        let api = &*scene.device.api;
        in_chunks(rays, hits, |rays, hits| {
            let _denormals = FlushDenormals::new();
            match self.calls {
                Calls::One => scene.one_by_one(rays, any_hit, hits),
                Calls::Eight { coherent } => {
                    scene.packets((api.intersect8, api.occluded8), coherent, rays, any_hit, hits);
                }
                Calls::Sixteen { coherent } => {
                    scene.packets((api.intersect16, api.occluded16), coherent, rays, any_hit, hits);
                }
            }
        });
    }
}

fn arguments(coherent: bool) -> RtcArguments {
    RtcArguments {
        flags: if coherent { QUERY_FLAG_COHERENT } else { 0 },
        feature_mask: u32::MAX,
        context: null_mut(),
        filter: std::ptr::null(),
        callback: std::ptr::null(),
        min_width_distance_factor: 0.0,
    }
}

/// The hit of an any-hit ray: only the mask matters.
const ANY: Hit<f32> = Hit { mask: true, t: 0.0, u: 0.0, v: 0.0, primitive: 0, instance: 0 };

/// Whether Embree has marked a ray as occluded. Compares bits, because no floats are computed between the calls of
/// Embree (see [`FlushDenormals`]).
fn is_occluded(t_far: f32) -> bool {
    t_far.to_bits() == f32::NEG_INFINITY.to_bits()
}

impl Scene {
    fn one_by_one(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        let api = &self.device.api;
        let mut arguments = arguments(false);
        for (ray, hit) in rays.iter().zip(hits) {
            let ray = RtcRay {
                origin: ray.origin.to_array(),
                t_near: ray.t_min,
                dir: ray.dir.to_array(),
                time: 0.0,
                t_far: ray.t_max,
                mask: u32::MAX,
                id: 0,
                flags: 0,
            };
            if any_hit {
                let mut ray = ray;
                unsafe { (api.occluded1)(self.handle, &raw mut ray, &raw mut arguments) };
                *hit = if is_occluded(ray.t_far) { ANY } else { Hit::MISS };
                continue;
            }
            let found = RtcHit {
                normal: [0.0; 3],
                u: 0.0,
                v: 0.0,
                primitive: INVALID,
                geometry: INVALID,
                instance: INVALID,
                instance_primitive: INVALID,
            };
            let mut query = RtcRayHit { ray, hit: found };
            unsafe { (api.intersect1)(self.handle, &raw mut query, &raw mut arguments) };
            let RtcRayHit { ray, hit: found } = query;
            *hit = if found.geometry == INVALID {
                Hit::MISS
            } else {
                Hit { mask: true, t: ray.t_far, u: found.u, v: found.v, primitive: found.primitive, instance: 0 }
            };
        }
    }

    /// Traces rays in packets of N, as a structure of arrays.
    fn packets<const N: usize>(
        &self,
        (intersect, occluded): (QueryN<RtcRayHits<N>>, QueryN<RtcRays<N>>),
        coherent: bool,
        rays: &[Ray<f32>],
        any_hit: bool,
        hits: &mut [Hit<f32>],
    ) {
        let mut arguments = arguments(coherent);
        let mut query = RtcRayHits::<N> {
            rays: RtcRays {
                origin: [[0.0; N]; 3],
                t_near: [0.0; N],
                dir: [[0.0; N]; 3],
                time: [0.0; N],
                t_far: [0.0; N],
                mask: [u32::MAX; N],
                id: [0; N],
                flags: [0; N],
            },
            hits: RtcHits {
                normal: [[0.0; N]; 3],
                u: [0.0; N],
                v: [0.0; N],
                primitive: [INVALID; N],
                geometry: [INVALID; N],
                instance: [INVALID; N],
                instance_primitive: [INVALID; N],
            },
        };
        for (rays, hits) in rays.chunks(N).zip(hits.chunks_mut(N)) {
            let valid = Valid::<N>(std::array::from_fn(|lane| if lane < rays.len() { -1 } else { 0 }));
            for (part, eight) in rays.chunks(8).enumerate() {
                query.rays.load(8 * part, eight);
            }
            if any_hit {
                unsafe { occluded(valid.0.as_ptr(), self.handle, &raw mut query.rays, &raw mut arguments) };
                for (hit, &t_far) in hits.iter_mut().zip(&query.rays.t_far) {
                    *hit = if is_occluded(t_far) { ANY } else { Hit::MISS };
                }
            } else {
                query.hits.geometry = [INVALID; N];
                unsafe { intersect(valid.0.as_ptr(), self.handle, &raw mut query, &raw mut arguments) };
                for (lane, hit) in hits.iter_mut().enumerate() {
                    *hit = if query.hits.geometry[lane] == INVALID {
                        Hit::MISS
                    } else {
                        Hit {
                            mask: true,
                            t: query.rays.t_far[lane],
                            u: query.hits.u[lane],
                            v: query.hits.v[lane],
                            primitive: query.hits.primitive[lane],
                            instance: 0,
                        }
                    };
                }
            }
        }
    }
}

impl<const N: usize> RtcRays<N> {
    /// Writes up to eight rays into the lanes from `first` on.
    fn load(&mut self, first: usize, rays: &[Ray<f32>]) {
        let row = |ray: &Ray<f32>| {
            let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin.to_array(), ray.dir.to_array());
            f32x8::new([ox, oy, oz, ray.t_min, dx, dy, dz, ray.t_max])
        };
        let mut rows = [f32x8::ZERO; 8];
        for (lane, ray) in rows.iter_mut().zip(rays) {
            *lane = row(ray);
        }
        let [ox, oy, oz, t_near, dx, dy, dz, t_far] = f32x8::transpose(rows).map(f32x8::to_array);
        let lanes = first..first + 8;
        let [x, y, z] = &mut self.origin;
        let [u, v, w] = &mut self.dir;
        let columns = [
            (x, ox),
            (y, oy),
            (z, oz),
            (&mut self.t_near, t_near),
            (u, dx),
            (v, dy),
            (w, dz),
            (&mut self.t_far, t_far),
        ];
        for (column, values) in columns {
            column[lanes.clone()].copy_from_slice(&values);
        }
    }
}

/// While this exists, the thread treats denormal operands and results as zero, as Embree's manual asks. Between the
/// calls of Embree, floats are only copied and not computed with.
struct FlushDenormals {
    #[cfg(target_arch = "x86_64")]
    before: u32,
}

impl FlushDenormals {
    #[cfg(target_arch = "x86_64")]
    fn new() -> Self {
        const DENORMALS_ARE_ZERO: u32 = 1 << 6;
        const FLUSH_TO_ZERO: u32 = 1 << 15;
        let mut before = 0;
        unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut before, options(nostack)) };
        let flushing: u32 = before | DENORMALS_ARE_ZERO | FLUSH_TO_ZERO;
        unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const flushing, options(nostack)) };
        Self { before }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn new() -> Self {
        Self {}
    }
}

impl Drop for FlushDenormals {
    fn drop(&mut self) {
        #[cfg(target_arch = "x86_64")]
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const self.before, options(nostack));
        }
    }
}
