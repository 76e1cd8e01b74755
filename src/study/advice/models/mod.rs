//! Simpler models of a world: fewer or simpler things that give the same picture.
//!
//! Each file finds one kind of simpler model and makes it. Nothing is measured here: a simpler model may be slower.
//!
//! | file | what it finds |
//! | --- | --- |
//! | `degenerate` | triangles of zero area |
//! | `coincident` | triangles with the same vertices, and equal instances |
//! | `share` | meshes that are equal |
//! | `quadrics` | tessellated quadrics; `fit` finds the surface through their vertices |
//! | `copies` | parts of a mesh that are moved copies of each other |
//! | `bake` | instances that could be part of one untransformed mesh |
//! | `origin` | a world far from the origin |
//!
//! `weld` finds the components of a mesh, `pieces` replaces a geometry by pieces, `symmetric` has eigenvectors.

mod bake;
mod coincident;
mod copies;
mod degenerate;
mod fit;
mod origin;
mod pieces;
mod quadrics;
mod share;
mod symmetric;
#[cfg(test)]
mod tests;
mod weld;

use glam::Vec3;

use crate::tracer::World;

/// A simpler model of a world.
#[derive(Clone, Debug)]
pub(crate) struct SimplerModel {
    /// What is done.
    pub(crate) name: &'static str,
    /// What was found and what was done, with figures: one sentence, without a full stop.
    pub(crate) about: String,
    /// The simpler world. Numbers of primitives and instances may differ from those of the given one.
    pub(crate) world: World,
    /// Points of the simpler world are points of the given one plus this. Rays and the camera must move too.
    pub(crate) moved_by: Vec3,
    /// How the surfaces differ.
    pub(crate) deviation: Deviation,
}

/// How the surface of a simpler model differs from the given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Deviation {
    /// Not at all. A hit of the same triangle has the same bits of `t`, u and v with the kernel `exact`; numbers of
    /// triangles and instances may differ.
    None,
    /// Vertices or transforms are rounded. The greatest distance between the surfaces, in units of the world.
    Rounding(f64),
    /// One surface approximates the other. The greatest distance between them that was found.
    Approximation(f64),
}

impl Deviation {
    /// Whether the surface stays the same, up to rounding.
    pub(crate) fn keeps_surface(self) -> bool {
        !matches!(self, Self::Approximation(_))
    }

    /// The greatest distance between the surfaces, in units of the world. 0 if they are exactly the same.
    pub(crate) fn distance(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Rounding(distance) | Self::Approximation(distance) => distance,
        }
    }

    /// That of two changes, one after the other.
    fn and(self, next: Self) -> Self {
        let distance = self.distance() + next.distance();
        match (self, next) {
            (Self::None, Self::None) => Self::None,
            _ if self.keeps_surface() && next.keeps_surface() => Self::Rounding(distance),
            _ => Self::Approximation(distance),
        }
    }
}

type Find = fn(&World) -> Option<SimplerModel>;

/// Finds each kind of model, in the order in which they are combined.
///
/// Triangles that show nothing go first, so that they spoil neither equality nor a fit. Equal meshes are shared before
/// anything looks into them, so it looks once. A tessellation is replaced before its copies would be found. Moving is
/// last: by then, coordinates are those of the world.
const FIND: [(&str, Find); 7] = [
    (degenerate::NAME, degenerate::find),
    (coincident::NAME, coincident::find),
    (share::NAME, share::find),
    (quadrics::NAME, quadrics::find),
    (copies::NAME, copies::find),
    (bake::NAME, bake::find),
    (origin::NAME, origin::find),
];

/// All simpler models of a world. Each is made from the given world. Empty if there are none.
pub(crate) fn simpler_models(world: &World) -> Vec<SimplerModel> {
    FIND.iter().filter_map(|(_, find)| find(world)).collect()
}

/// The simpler models that are wanted, one after the other, as one world. `None` if there are none. Without a reason to
/// choose, those are wanted that [keep the surface](Deviation::keeps_surface).
///
/// Sharing and baking undo each other, so nothing is baked once a mesh or a part of one is shared.
pub(crate) fn combined(world: &World, is_wanted: impl Fn(&SimplerModel) -> bool) -> Option<SimplerModel> {
    let mut all: Option<SimplerModel> = None;
    let mut is_shared = false;
    for (name, find) in FIND {
        if name == bake::NAME && is_shared {
            continue;
        }
        let Some(next) = find(all.as_ref().map_or(world, |all| &all.world)).filter(&is_wanted) else { continue };
        is_shared |= name == share::NAME || name == copies::NAME;
        all = Some(match all {
            None => next,
            Some(all) => SimplerModel {
                name: "all of these",
                about: format!("{}; {}", all.about, next.about),
                world: next.world,
                moved_by: all.moved_by + next.moved_by,
                deviation: all.deviation.and(next.deviation),
            },
        });
    }
    all
}

/// A model that is not moved.
fn in_place(name: &'static str, about: String, world: World, deviation: Deviation) -> SimplerModel {
    SimplerModel { name, about, world, moved_by: Vec3::ZERO, deviation }
}
