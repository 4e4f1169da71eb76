//! What a case is about: each is one way in which files and proofs may part.

/// The oddity of a case; everything else about it is as random as ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Theme {
    /// Nothing in particular: all joint kinds, mimics, primitives, meshes, named frames.
    Plain,
    /// A continuous joint that others follow.
    Leaders,
    /// Paths that wind about continuous joints and planar bases.
    Winding,
    /// Steps of half a turn, exact and rounded.
    HalfTurns,
    /// Numbers that differ by whole turns from waypoint to waypoint.
    LongSteps,
    /// Orientations half a turn apart, and of either sign.
    Quaternions,
    /// Objects placed by frames of objects and their subframes.
    Frames,
    /// Something in the way that only an octomap knows of.
    Octomap,
    /// A word of the scene with a wrong letter.
    Misspelt,
    /// Meshes far from the origin of their file.
    FarMeshes,
    /// Polygons with notches.
    Concave,
    /// Quads that are not flat.
    Warped,
    /// Turns as URDF 1.1's quaternions, many near vertical.
    QuaternionOrigins,
    /// A robot that only has a look.
    VisualOnly,
    /// Limits within the limits.
    SoftLimits,
    /// Links that touch at rest, with the SRDF lines that are offered for them.
    RestContacts,
    /// A request whose path must keep a constraint.
    Constraint,
    /// Several of these at once, where they go together.
    Mixed,
}

impl Theme {
    pub const ALL: [Self; 18] = [
        Self::Plain,
        Self::Leaders,
        Self::Winding,
        Self::HalfTurns,
        Self::LongSteps,
        Self::Quaternions,
        Self::Frames,
        Self::Octomap,
        Self::Misspelt,
        Self::FarMeshes,
        Self::Concave,
        Self::Warped,
        Self::QuaternionOrigins,
        Self::VisualOnly,
        Self::SoftLimits,
        Self::RestContacts,
        Self::Constraint,
        Self::Mixed,
    ];

    /// Whether an oddity is of this theme's cases.
    pub fn has(self, other: Self) -> bool {
        let goes_with_others = !matches!(
            other,
            Self::Octomap
                | Self::Misspelt
                | Self::VisualOnly
                | Self::RestContacts
                | Self::Constraint
        );
        self == other || self == Self::Mixed && goes_with_others
    }
}
