//! The random transforms of scattered instances. They depend on the seed alone.

use glam::{Affine3, DVec2, DVec3, Mat3, Vec3};

use crate::geom::{Aabb, Ray};
use crate::kernels::Intersect;
use crate::kernels::triangle::Woop;
use crate::tracer::meshes::generator::hash;
use crate::tracer::scene::{Geometry, Placement, Scene, World};

/// How the instances of one scatter vary.
pub(super) struct Variation {
    pub(super) seed: u32,
    /// Smallest and largest corner of the area, in x and z.
    pub(super) area: [DVec2; 2],
    /// Transform of every instance, applied before the random ones.
    pub(super) transform: Affine3,
    /// Smallest and largest scale factor.
    pub(super) scale: [f64; 2],
    /// Largest shear of x and z by y.
    pub(super) lean: f64,
}

/// The surface that instances stand on. The kernel is watertight, so no instance falls through a shared edge.
pub(super) struct Ground {
    scene: Scene<Woop<f32>>,
}

impl Ground {
    /// A geometry, as these placements place it.
    pub(super) fn new<'a>(geometry: &Geometry, placements: impl Iterator<Item = &'a Placement>) -> Self {
        let placements = placements.map(|placement| Placement { geometry: 0, ..*placement }).collect();
        let world = World::new(vec![geometry.clone()], placements).expect("geometry and placements have been checked");
        Self { scene: Scene::new(world) }
    }

    /// Smallest and largest corner in x and z.
    pub(super) fn area(&self) -> [DVec2; 2] {
        let Aabb { lo, hi } = self.scene.bounds();
        [lo, hi].map(|corner| DVec2::new(corner.x.into(), corner.z.into()))
    }

    /// The largest height at this x and z, or `None` if there is no surface.
    fn height(&self, at: DVec2) -> Option<f64> {
        // The ray points down from y = 0, and its interval begins at -infinity. So -t is the height, without rounding.
        let ray = Ray { t_min: f32::NEG_INFINITY, ..Ray::new(Vec3::new(at.x as f32, 0.0, at.y as f32), Vec3::NEG_Y) };
        let hit = Intersect::<f32>::hit(&self.scene, &ray);
        hit.mask.then_some(f64::from(-hit.t))
    }
}

/// Number of random places that are tried for one instance.
pub(super) const ATTEMPTS: u32 = 64;

impl Variation {
    /// The transform of instance number `index`: first `transform`, then random scale, rotation about y, shear and
    /// place. `None` if no ground was found in [`ATTEMPTS`] places.
    pub(super) fn transform(&self, index: u32, ground: Option<&Ground>) -> Option<Affine3> {
        let draw = |number: u32| f64::from(hash(index, number, self.seed)) / f64::from(u32::MAX);
        // Each purpose has its own range of numbers, so no number is drawn twice.
        let pair = |number: u32| DVec2::new(draw(2 * number), draw(2 * number + 1));
        let [place, rotation, lean, scale] = [0, 1, 2, 3].map(|purpose| purpose * ATTEMPTS);
        // A random point in the unit disc: the first of several points of the enclosing square that lies in the disc.
        let in_disc = |purpose: u32| {
            let points = (purpose..purpose + ATTEMPTS).map(|number| pair(number) * 2.0 - 1.0);
            points.into_iter().find(|point| (0.01..=1.0).contains(&point.length_squared())).unwrap_or(DVec2::X)
        };

        let [lo, hi] = self.area;
        let foot = (place..place + ATTEMPTS).find_map(|number| {
            let at = lo + (hi - lo) * pair(number);
            Some(DVec3::new(at.x, ground.map_or(Some(0.0), |ground| ground.height(at))?, at.y))
        })?;
        let DVec2 { x: cos, y: sin } = in_disc(rotation).normalize();
        let lean = in_disc(lean) * self.lean;
        let [least, greatest] = self.scale;
        let scale = least + (greatest - least) * draw(2 * scale);

        let apply = |v: Vec3| {
            let DVec3 { x, y, z } = v.as_dvec3() * scale;
            DVec3::new(x * cos + z * sin + lean.x * y, y, z * cos - x * sin + lean.y * y)
        };
        let Affine3 { matrix3, translation } = self.transform;
        let [x, y, z] = [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis].map(|column| apply(column).as_vec3());
        let translation = (apply(translation) + foot).as_vec3();
        Some(Affine3 { matrix3: Mat3::from_cols(x, y, z), translation })
    }
}
