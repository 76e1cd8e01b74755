use glam::Vec3;
use raylanes::geom::{Hit, Ray, Triangle};
use raylanes::kernels::{Kernel, triangle::*};
use raylanes::tracer::*;
use std::time::Instant;
fn rng(s: &mut u64) -> f32 { *s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); ((*s >> 40) as f32) / (1u64 << 24) as f32 }
fn sets<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, mesh: &Mesh, view: &View, size: u32) -> Vec<(&'static str, bool, Vec<Ray<f32>>)> {
    let prim = view.camera(size, size).rays(size, size);
    let hits = trace(scene, &prim, false, Mode::Scalar);
    let b = scene.bounds();
    let diag = (b.hi - b.lo).length();
    let light = match std::env::var("LIGHT") { _ => view.light.position };
    let (mut sh, mut bo, mut ao) = (vec![], vec![], vec![]);
    let mut s = 1u64;
    for (r, h) in prim.iter().zip(&hits) {
        if !h.mask { continue; }
        let t = mesh.triangle(h.primitive);
        let mut n = (t.v1 - t.v0).cross(t.v2 - t.v0).normalize();
        if n.dot(r.dir) > 0.0 { n = -n; }
        let p = r.at(h.t) + n * (diag * 1e-4);
        let d = light - p;
        sh.push(Ray { origin: p, dir: d, t_min: 0.0, t_max: 1.0 });
        let mut dir = || loop { let v = Vec3::new(rng(&mut s) * 2.0 - 1.0, rng(&mut s) * 2.0 - 1.0, rng(&mut s) * 2.0 - 1.0); let l = v.length(); if l < 1.0 && l > 1e-3 { let d = v / l + n; if d.length() > 1e-3 { return d.normalize(); } } };
        bo.push(Ray { origin: p, dir: dir(), t_min: 0.0, t_max: f32::INFINITY });
        ao.push(Ray { origin: p, dir: dir(), t_min: 0.0, t_max: 0.1 * diag });
    }
    vec![("primary", false, prim), ("shadow", true, sh), ("bounce", false, bo), ("ao", true, ao)]
}
fn run<K: Kernel<Shape = Triangle>>(name: &str, rounds: usize, size: u32, modes: &[Mode]) {
    let (name, view) = name.split_once('@').map_or((name, None), |(a, b)| (a, Some(b)));
    let LoadedScene { world, mut view, .. } = { let v = view; let mut l = SceneSource::parse(name).unwrap().load().unwrap(); if let Some(v) = v { let f: Vec<f32> = v.split([',', ':']).map(|x| x.parse().unwrap()).collect(); l.view.eye = Vec3::new(f[0], f[1], f[2]); l.view.look_at = Vec3::new(f[3], f[4], f[5]); } l };
    if name.contains("sponza") { view.light.position = Vec3::new(0.0, 12.0, 0.0); }
    let mesh = match &world.geometries()[0] { Geometry::Mesh(m) => m.clone(), _ => panic!() };
    let scene = Scene::<K>::new(world);
    let only = std::env::var("SET").ok();
    for (set, any, rays) in sets(&scene, &mesh, &view, size) {
        if only.as_ref().is_some_and(|o| o != set) { continue; }
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut times = vec![vec![]; modes.len()];
        let mut sums = vec![0; modes.len()];
        for round in 0..=rounds {
            for (m, &mode) in modes.iter().enumerate() {
                let t = Instant::now();
                trace_into(&scene, &rays, any, mode, &mut hits);
                if round > 0 { times[m].push(t.elapsed().as_secs_f64()); }
                if round == 0 { sums[m] = checksum(&hits); }
            }
        }
        let n = hits.iter().filter(|h| h.mask).count();
        print!("{:8} {set:8} {:7} rays {:3.0}% hit:", name.rsplit('/').next().unwrap(), rays.len(), 100.0 * n as f64 / rays.len() as f64);
        for (m, mode) in modes.iter().enumerate() {
            times[m].sort_by(f64::total_cmp);
            print!(" {} {:6.2}{}", mode.name(), rays.len() as f64 / times[m][times[m].len() / 2] / 1e6, if sums[m] == sums[0] { "" } else { "!" });
        }
        println!();
    }
}
fn main() {
    let scenes: Vec<String> = std::env::args().skip(1).collect();
    let rounds = std::env::var("ROUNDS").map_or(5, |v| v.parse().unwrap());
    let modes: Vec<Mode> = std::env::var("MODES").unwrap_or("spba".into()).chars().map(|c| match c { 's' => Mode::Scalar, 'p' => Mode::Packet, 'b' => Mode::Auto, _ => Mode::Single }).collect();
    let pool = thread_pool(1).unwrap();
    pool.install(|| for s in &scenes { match std::env::var("K").as_deref() { Ok("mt") => run::<MollerTrumbore<f32>>(s, rounds, 1024, &modes), #[cfg(target_feature = "fma")] Ok("dop") => run::<WoopDop<f32>>(s, rounds, 1024, &modes), Ok("ho") => run::<WoopHalfOpen<f32>>(s, rounds, 1024, &modes), _ => run::<Woop<f32>>(s, rounds, 1024, &modes) } });
}
