//! The variables of a robot: columns of a path and those that hold still, with their limits.

use super::description::JointDescription;

/// A column of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// MoveIt's variable name.
    pub name: String,
    /// Lowest value (m or rad), −∞ where there is none: the greater one of limit and soft limit, as
    /// in MoveIt.
    pub lower: f64,
    /// Highest value (m or rad), ∞ where there is none.
    pub upper: f64,
    /// Lowest value without soft limits.
    pub hard_lower: f64,
    /// Highest value without soft limits.
    pub hard_upper: f64,
}

/// A variable of a movable joint that is no column of the path.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldVariable {
    /// MoveIt's variable name.
    pub name: String,
    /// Value where a request gives none.
    pub default: f64,
    /// Lowest value (m or rad), −∞ where there is none; within the soft limits.
    pub lower: f64,
    /// Highest value (m or rad), ∞ where there is none.
    pub upper: f64,
    /// Lowest value without soft limits.
    pub hard_lower: f64,
    /// Highest value without soft limits.
    pub hard_upper: f64,
}

impl Variable {
    /// A variable with these limits and no soft ones.
    pub fn within(name: &str, lower: f64, upper: f64) -> Self {
        Self {
            name: name.to_owned(),
            lower,
            upper,
            hard_lower: lower,
            hard_upper: upper,
        }
    }

    /// Whether it has soft limits within its limits.
    pub fn has_soft_limits(&self) -> bool {
        self.lower > self.hard_lower || self.upper < self.hard_upper
    }
}

/// Limits of a variable, and what they are without soft limits.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub lower: f64,
    pub upper: f64,
    pub hard_lower: f64,
    pub hard_upper: f64,
}

impl Bounds {
    pub const NONE: Self = Self::hard((f64::NEG_INFINITY, f64::INFINITY));

    pub const fn hard((lower, upper): (f64, f64)) -> Self {
        Self {
            lower,
            upper,
            hard_lower: lower,
            hard_upper: upper,
        }
    }

    pub fn of(joint: &JointDescription) -> Option<Self> {
        let (hard_lower, hard_upper) = joint.limits?;
        let (lower, upper) = joint
            .soft_limits
            .unwrap_or((hard_lower, hard_upper));
        Some(Self {
            lower: hard_lower.max(lower),
            upper: hard_upper.min(upper),
            hard_lower,
            hard_upper,
        })
    }
}
