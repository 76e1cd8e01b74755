//! The modes: how rays are grouped for tracing. All modes give the same hits.

/// How rays are grouped for tracing. The hits do not depend on it, only the speed does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mode {
    /// One ray at a time in scalar arithmetic: the reference.
    Scalar,
    /// One ray at a time against eight boxes or eight triangles: for incoherent rays.
    Single,
    /// Blocks of consecutive coherent rays; packets of eight rays of one octant for the others.
    Packet,
    /// Blocks of consecutive coherent rays; for the others, streams where the scene is one untransformed mesh, and
    /// packets where it has instances.
    Auto,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Single, Self::Packet, Self::Auto];

    /// The name on the command line and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Single => "single",
            Self::Packet => "packet",
            Self::Auto => "auto",
        }
    }

    /// One line about it.
    pub fn about(self) -> &'static str {
        match self {
            Self::Scalar => "One ray at a time, with scalar code: the reference",
            Self::Single => "One ray at a time, against eight boxes or eight triangles at once",
            Self::Packet => "Similar rays in blocks, the others in packets of eight",
            Self::Auto => "Similar rays in blocks, the others in streams or packets, whichever suits the scene",
        }
    }
}
