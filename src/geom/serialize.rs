//! Serialization of rays and hits (feature `serde`). Shapes derive it where they are defined.
//!
//! Both are written with all their fields, in every format. JSON has no infinity: it writes `null`. So an infinite
//! `t_max` is written as "none", and read as infinity where it is none or missing. The `t` of a miss is "none" too. Any
//! other number that JSON writes as `null` cannot be read again: that is an error. Formats with infinities and NaN keep
//! them.

use glam::Vec3;
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Hit, Ray};

#[derive(Serialize, Deserialize)]
#[serde(rename = "Ray")]
struct RayData {
    origin: Vec3,
    t_min: f32,
    dir: Vec3,
    /// None: infinite.
    t_max: Option<f32>,
}

/// An infinite `t_max` is none. In text, a `t_max` of NaN or -∞ is refused: JSON would make it infinite.
impl Serialize for Ray<f32> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { origin, t_min, dir, t_max } = *self;
        if serializer.is_human_readable() && (t_max.is_nan() || t_max == f32::NEG_INFINITY) {
            return Err(S::Error::custom(format_args!("t_max of a ray is {t_max}, which text formats do not keep")));
        }
        let t_max = (t_max != f32::INFINITY).then_some(t_max);
        RayData { origin, t_min, dir, t_max }.serialize(serializer)
    }
}

/// `t_max` is infinite if it is none or missing.
impl<'de> Deserialize<'de> for Ray<f32> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let RayData { origin, t_min, dir, t_max } = RayData::deserialize(deserializer)?;
        Ok(Self { origin, t_min, dir, t_max: t_max.unwrap_or(f32::INFINITY) })
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Hit")]
struct HitData {
    mask: bool,
    /// None: a miss.
    t: Option<f32>,
    u: f32,
    v: f32,
    primitive: u32,
    instance: u32,
}

/// The `t` of a miss is none.
impl Serialize for Hit<f32> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { mask, t, u, v, primitive, instance } = *self;
        HitData { mask, t: mask.then_some(t), u, v, primitive, instance }.serialize(serializer)
    }
}

/// Where the mask is false, any content becomes [`Hit::MISS`]. A hit without a `t`, with a NaN, or with the primitive
/// or instance number of a miss is refused.
impl<'de> Deserialize<'de> for Hit<f32> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let HitData { mask, t, u, v, primitive, instance } = HitData::deserialize(deserializer)?;
        if !mask {
            return Ok(Self::MISS);
        }
        let t = t.ok_or_else(|| D::Error::missing_field("t"))?;
        if t.is_nan() || u.is_nan() || v.is_nan() || primitive == u32::MAX || instance == u32::MAX {
            let found = format_args!("t {t}, u {u}, v {v}, primitive {primitive}, instance {instance}");
            return Err(D::Error::custom(format_args!("a hit holds no NaN and no number of a miss; found {found}")));
        }
        Ok(Self { mask, t, u, v, primitive, instance })
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3;
    use serde::de::DeserializeOwned;

    use super::*;
    use crate::geom::{Aabb, Placed, Quadric, Triangle};

    /// Writes and reads JSON and TOML.
    fn round_trips<T: Serialize + DeserializeOwned>(value: &T) -> [T; 2] {
        let (json, toml) = (serde_json::to_string(value).unwrap(), toml::to_string(value).unwrap());
        [serde_json::from_str(&json).unwrap(), toml::from_str(&toml).unwrap()]
    }

    #[test]
    fn rays_come_back_bit_for_bit() {
        let infinite = Ray::new(Vec3::new(0.1, -0.0, 1e-45), Vec3::new(f32::MAX, -1.0 / 3.0, 0.0));
        for ray in [infinite, Ray { t_min: -0.0, t_max: 16_777_217.0, ..infinite }, Ray { t_max: -2.5, ..infinite }] {
            for again in round_trips(&ray) {
                assert_eq!(again.to_array().map(f32::to_bits), ray.to_array().map(f32::to_bits));
            }
            assert_eq!(toml::to_string(&ray).unwrap().contains("t_max"), ray.t_max.is_finite());
        }
    }

    #[test]
    fn json_refuses_rays_that_it_would_change() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        for t_max in [f32::NAN, f32::NEG_INFINITY] {
            let error = serde_json::to_string(&Ray { t_max, ..ray }).unwrap_err().to_string();
            assert_eq!(error, format!("t_max of a ray is {t_max}, which text formats do not keep"));
        }
        for changed in [
            Ray { t_min: f32::NEG_INFINITY, ..ray },
            Ray { origin: Vec3::new(0.0, f32::NAN, 0.0), ..ray },
            Ray { dir: Vec3::INFINITY, ..ray },
        ] {
            let json = serde_json::to_string(&changed).unwrap();
            assert!(serde_json::from_str::<Ray<f32>>(&json).is_err(), "{json}");
        }
    }

    #[test]
    fn hits_come_back_bit_for_bit() {
        let hit = Hit { primitive: 7, instance: u32::MAX - 1, ..Hit::<f32>::new(true, 1.0 / 3.0, -0.0, 1e-45) };
        for hit in [hit, Hit::MISS] {
            assert!(round_trips(&hit).iter().all(|again| again.mask == hit.mask && again.to_bits() == hit.to_bits()));
            assert_eq!(toml::to_string(&hit).unwrap().contains("\nt = "), hit.mask);
        }
    }

    #[test]
    fn a_miss_that_is_read_has_one_content() {
        let miss = "mask = false\nt = 3.0\nu = nan\nv = 2.0\nprimitive = 5\ninstance = 6";
        assert_eq!(toml::from_str::<Hit<f32>>(miss).unwrap().to_bits(), Hit::MISS.to_bits());
    }

    #[test]
    fn what_no_hit_holds_is_refused() {
        let hit = |t, u, v, primitive, instance| {
            let [t, u, v]: [&str; 3] = [t, u, v];
            let text =
                format!("mask = true\nt = {t}\nu = {u}\nv = {v}\nprimitive = {primitive}\ninstance = {instance}");
            toml::from_str::<Hit<f32>>(&text).map_err(|error| error.to_string())
        };
        assert!(hit("1.0", "0.5", "0.25", 0, 0).unwrap().mask);
        for (t, u, v, primitive, instance) in [
            ("nan", "0.5", "0.25", 0, 0),
            ("1.0", "-nan", "0.25", 0, 0),
            ("1.0", "0.5", "nan", 0, 0),
            ("1.0", "0.5", "0.25", u32::MAX, 0),
            ("1.0", "0.5", "0.25", 0, u32::MAX),
        ] {
            let error = hit(t, u, v, primitive, instance).unwrap_err();
            assert!(error.contains("a hit holds no NaN and no number of a miss; found t "), "{error}");
        }
        let without_t = r#"{"mask":true,"t":null,"u":0.0,"v":0.0,"primitive":0,"instance":0}"#;
        assert!(serde_json::from_str::<Hit<f32>>(without_t).unwrap_err().to_string().contains("missing field `t`"));
    }

    #[test]
    fn shapes_come_back() {
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X / 3.0, v2: Vec3::Y };
        let placed = Placed { shape: triangle, object_to_world: Affine3::from_translation(Vec3::splat(0.1)) };
        let (quadric, bounds) = (Quadric::cone(1.0, 3.0), triangle.bounds());
        assert_eq!(round_trips(&triangle), [triangle; 2]);
        assert_eq!(round_trips(&placed), [placed; 2]);
        assert_eq!(round_trips(&quadric), [quadric; 2]);
        assert_eq!(round_trips(&bounds), [bounds; 2]);
        assert_eq!(toml::from_str::<Aabb>(&toml::to_string(&Aabb::EMPTY).unwrap()).unwrap(), Aabb::EMPTY);
        let empty = serde_json::to_string(&Aabb::EMPTY).unwrap();
        assert!(serde_json::from_str::<Aabb>(&empty).is_err(), "JSON has no infinity: {empty}");
    }
}
