//! Where things are: poses made ready for moving many points.

use crate::math::{Mat3, Pose, Vec3};

/// A pose with its rotation as a matrix, for moving many points.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// Rotation.
    pub rotation: Mat3,
    /// Translation (m).
    pub translation: Vec3,
}

impl Transform {
    /// No motion at all.
    pub const IDENTITY: Self = Self {
        rotation: Mat3::IDENTITY,
        translation: Vec3::ZERO,
    };

    /// The frame with this origin, turned by nothing.
    pub fn shift(translation: Vec3) -> Self {
        Self {
            translation,
            ..Self::IDENTITY
        }
    }

    /// Moves a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// `self · other`: where `other`, given in this frame, is in the frame that this one is given
    /// in.
    pub fn of(&self, other: &Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            translation: self.point(other.translation),
        }
    }

    /// `self⁻¹ · other`: other's frame as seen from this one.
    pub fn inverse_of(&self, other: &Self) -> Self {
        let back = self.rotation.transpose();
        Self {
            rotation: back * other.rotation,
            translation: back * (other.translation - self.translation),
        }
    }

    /// Brings a point back into the body's frame.
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.rotation.transpose() * (p - self.translation)
    }
}

impl From<&Pose> for Transform {
    fn from(pose: &Pose) -> Self {
        Self {
            rotation: Mat3::from_quat(pose.rotation),
            translation: pose.translation,
        }
    }
}
