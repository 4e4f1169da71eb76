//! Why constraints are refused.

/// What a text asks for that cannot be kept, or is not understood: one line with the value and the next
/// step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConstraintError {
    /// Neither robot nor scene has such a frame.
    #[error(
        "constraint {constraint:?}: {frame:?} is no link, attached object or frame; links: {links}; {others}"
    )]
    UnknownFrame {
        /// The constraint.
        constraint: String,
        /// What it names.
        frame: String,
        /// Links of the robot.
        links: String,
        /// What else there is.
        others: String,
    },
    /// The robot has no such joint, it has more than one value, or the path has no column for it.
    #[error(
        "constraint {constraint:?}: {joint:?} is no joint of one value that the path moves; valid: {valid}"
    )]
    UnknownJoint {
        /// The constraint.
        constraint: String,
        /// What it names.
        joint: String,
        /// Joints that can be named.
        valid: String,
    },
    /// A text that is no constraint.
    #[error("constraints: {0}")]
    Syntax(String),
    /// A number that makes no sense.
    #[error("constraint {constraint:?}: {what} is {value}; {rule}")]
    BadValue {
        /// The constraint.
        constraint: String,
        /// What is wrong.
        what: String,
        /// The value.
        value: String,
        /// What it may be, or the next step.
        rule: &'static str,
    },
    /// A region that is none.
    #[error("constraint {constraint:?}: {what}; a region is a box, a sphere or a cylinder")]
    Region {
        /// The constraint.
        constraint: String,
        /// What is wrong with it.
        what: String,
    },
    /// MoveIt has it, and it is not kept here.
    #[error("constraint {constraint:?}: {what} cannot be proved here; {instead}")]
    Unsupported {
        /// The constraint.
        constraint: String,
        /// What it asks for.
        what: String,
        /// What to do.
        instead: &'static str,
    },
}
