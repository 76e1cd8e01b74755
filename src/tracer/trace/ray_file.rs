//! Raw files of rays and hits: 32-bit little-endian numbers, no header.

use std::io::Read;
use std::path::Path;

use glam::Vec3;

use crate::error::Error;
use crate::files::{Input, write_atomically};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::scene::Scene;

const RAY_BYTES: usize = 32;
const HIT_BYTES: usize = 16;
const WIDE_HIT_BYTES: usize = 36;

/// Largest size of a file: 134,217,728 rays. Without a limit, an endless device would fill the memory.
const MAX_BYTES: u64 = 1 << 32;

/// Reads rays: eight `f32` each, `ox oy oz t_min dx dy dz t_max`. Every value is allowed: an invalid ray misses.
///
/// # Errors
/// If the file cannot be read, ends inside a ray, has no rays, has more than 134,217,728 rays, or if its rays do not
/// fit into memory.
pub fn read_rays(path: &Path) -> Result<Vec<Ray<f32>>, Error> {
    read_at_most(MAX_BYTES, path)
}

fn read_at_most(max_bytes: u64, path: &Path) -> Result<Vec<Ray<f32>>, Error> {
    // Read in chunks, so that a large file is never in memory twice.
    const CHUNK_BYTES: usize = RAY_BYTES << 15;
    let mut file = Input::open(path, max_bytes)?;
    let not_enough_memory = |bytes| Error::in_file(path, format!("not enough memory: the rays take {bytes} bytes"));
    let mut rays = Vec::new();
    if let Some(bytes) = file.size() {
        rays.try_reserve_exact(bytes as usize / RAY_BYTES).map_err(|_| not_enough_memory(bytes))?;
    }
    let mut chunk = Vec::with_capacity(CHUNK_BYTES);
    loop {
        chunk.clear();
        (&mut file).take(CHUNK_BYTES as u64).read_to_end(&mut chunk).map_err(Error::reading(path))?;
        let (complete, rest) = chunk.as_chunks();
        rays.try_reserve(complete.len()).map_err(|_| not_enough_memory((rays.len() * RAY_BYTES) as u64))?;
        rays.extend(complete.iter().map(decode_ray));
        if !rest.is_empty() {
            let bytes = rays.len() * RAY_BYTES + rest.len();
            let message =
                format!("truncated: {bytes} bytes is not a multiple of {RAY_BYTES} (ray {} is incomplete)", rays.len());
            return Err(Error::in_file(path, message));
        }
        if chunk.len() < CHUNK_BYTES {
            break;
        }
    }
    if rays.is_empty() { Err(Error::in_file(path, "no rays")) } else { Ok(rays) }
}

/// Writes rays in the format of [`read_rays`].
///
/// # Errors
/// If the file cannot be written; see [`write_atomically`].
pub fn write_rays(path: &Path, rays: &[Ray<f32>]) -> Result<(), Error> {
    write_records(path, rays.iter().map(encode_ray))
}

/// Writes hits, 16 bytes each: `t u v` as `f32` and the primitive number as `u32`. A miss has the primitive number
/// `u32::MAX`.
///
/// # Errors
/// If the file cannot be written; see [`write_atomically`].
pub fn write_hits<'a>(path: &Path, hits: impl IntoIterator<Item = &'a Hit<f32>>) -> Result<(), Error> {
    write_records(path, hits.into_iter().map(encode_hit))
}

/// Writes hits with their surface, 36 bytes each. `traced` holds rays and the closest hits that this scene reported
/// for them.
///
/// | word | type | content | of a miss |
/// | --- | --- | --- | --- |
/// | 0, 1, 2 | `f32` | `t u v` | +∞, 0, 0 |
/// | 3 | `u32` | primitive number | `u32::MAX` |
/// | 4 | `u32` | instance number | `u32::MAX` |
/// | 5 | `u32` | side: 1 for the [front](crate::tracer::SurfacePoint::front), else 0 | `u32::MAX` |
/// | 6, 7, 8 | `f32` | geometric unit normal in the world; see [`SurfacePoint::normal`] | 0, 0, 0 |
///
/// [`SurfacePoint::normal`]: crate::tracer::SurfacePoint::normal
///
/// # Errors
/// If the file cannot be written; see [`write_atomically`].
///
/// # Panics
/// If the scene has no such instance or triangle.
pub fn write_wide_hits<'a, K: Kernel<Shape = Triangle>>(
    path: &Path,
    scene: &Scene<K>,
    traced: impl IntoIterator<Item = (&'a Ray<f32>, &'a Hit<f32>)>,
) -> Result<(), Error> {
    write_records(path, traced.into_iter().map(|(ray, hit)| encode_wide_hit(scene, ray, hit)))
}

fn write_records<const N: usize>(path: &Path, records: impl Iterator<Item = [u8; N]>) -> Result<(), Error> {
    write_atomically(path, |out| {
        for record in records {
            out.write_all(&record)?;
        }
        Ok(())
    })
}

fn decode_ray(bytes: &[u8; RAY_BYTES]) -> Ray<f32> {
    Ray::from_array(core::array::from_fn(|index| {
        f32::from_le_bytes(core::array::from_fn(|byte| bytes[4 * index + byte]))
    }))
}

fn encode_ray(ray: &Ray<f32>) -> [u8; RAY_BYTES] {
    little_endian(ray.to_array().map(f32::to_bits))
}

fn encode_hit(hit: &Hit<f32>) -> [u8; HIT_BYTES] {
    let [t, u, v, primitive, _] = hit.to_bits();
    little_endian([t, u, v, primitive])
}

fn encode_wide_hit<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    ray: &Ray<f32>,
    hit: &Hit<f32>,
) -> [u8; WIDE_HIT_BYTES] {
    let [t, u, v, primitive, instance] = hit.to_bits();
    let (side, normal) = if hit.mask {
        let surface = scene.surface(ray, hit);
        (u32::from(surface.front), surface.normal)
    } else {
        (u32::MAX, Vec3::ZERO)
    };
    let [x, y, z] = normal.to_array().map(f32::to_bits);
    little_endian([t, u, v, primitive, instance, side, x, y, z])
}

fn little_endian<const WORDS: usize, const BYTES: usize>(words: [u32; WORDS]) -> [u8; BYTES] {
    const { assert!(BYTES == 4 * WORDS) };
    core::array::from_fn(|byte| words[byte / 4].to_le_bytes()[byte % 4])
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn written_rays_are_read_back_with_the_same_bits() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        // More than one chunk, and f32 numbers of every kind.
        let rays: Vec<_> = (0..70_000u32)
            .map(|number| {
                let x = f32::from_bits(number.wrapping_mul(0x9e37_79b1));
                Ray { origin: Vec3::new(x, 1.0, 2.0), dir: Vec3::new(3.0, x, 4.0), t_min: 5.0, t_max: x }
            })
            .collect();
        write_rays(&path, &rays).unwrap();
        let read = read_rays(&path).unwrap();
        assert_eq!(read.len(), rays.len());
        for (read, ray) in read.iter().zip(&rays) {
            assert_eq!(encode_ray(read), encode_ray(ray));
        }
    }

    #[test]
    fn the_formats_are_as_documented() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        let ray = Ray { origin: Vec3::new(1.0, 2.0, 3.0), t_min: 4.0, dir: Vec3::new(5.0, 6.0, 7.0), t_max: 8.0 };
        write_rays(&path, &[ray]).unwrap();
        let numbers: Vec<u8> = (1..=8).flat_map(|number: i16| f32::from(number).to_le_bytes()).collect();
        assert_eq!(fs::read(&path).unwrap(), numbers);
        assert_eq!(read_rays(&path).unwrap(), [ray]);

        let mut hit = Hit::<f32>::new(true, 1.0, 2.0, 3.0);
        hit.primitive = 0x0403_0201;
        write_hits(&path, &[hit, Hit::MISS]).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert_eq!(bytes[..12], numbers[..12]);
        assert_eq!(bytes[12..20], [1, 2, 3, 4, 0, 0, 0x80, 0x7f]);
        assert_eq!(bytes[20..], [0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255]);
    }

    #[test]
    fn files_with_too_many_rays_are_refused() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        write_rays(&path, &[Ray::INACTIVE; 3]).unwrap();
        assert_eq!(read_at_most(96, &path).unwrap().len(), 3);
        let error = read_at_most(95, &path).unwrap_err().to_string();
        assert_eq!(error, format!("cannot read {}: longer than 95 bytes", path.display()));
    }

    #[test]
    fn incomplete_files_are_refused() {
        let path = tempfile::NamedTempFile::new().unwrap().into_temp_path();
        let message = |bytes: usize| {
            fs::write(&path, vec![0; bytes]).unwrap();
            read_rays(&path).unwrap_err().to_string()
        };
        let name = path.display();
        assert_eq!(message(0), format!("{name}: no rays"));
        for (bytes, ray) in [(1, 0), (100, 3), ((32 << 15) + 31, 1 << 15)] {
            let expected =
                format!("{name}: truncated: {bytes} bytes is not a multiple of 32 (ray {ray} is incomplete)");
            assert_eq!(message(bytes), expected);
        }
        let directory = tempfile::tempdir().unwrap();
        assert!(read_rays(directory.path()).unwrap_err().to_string().starts_with("cannot read "));
    }
}
