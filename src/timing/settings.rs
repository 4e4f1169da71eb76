//! What a trajectory is asked to be.

use super::controller::Controller;
use super::limits::Limits;

/// What a trajectory is asked to be: [`Settings::new`] asks for no more than limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What the motors allow.
    pub limits: Limits,
    /// Whether no floor may be lowered.
    pub strict: bool,
    /// Of the random choices.
    pub seed: u64,
    /// Work, in a validator's tests of bodies, after which no more is looked for.
    pub most_work: u64,
    /// The velocity of each column when the trajectory begins (m/s or rad/s); `None` at rest.
    pub start_velocity: Option<Vec<f64>>,
    /// Waypoints whose positions are passed, to the last bit.
    pub fixed_waypoints: Fixed,
    /// Who makes a curve of the points.
    pub controller: Controller,
}

impl Settings {
    /// Work that is enough for most paths.
    pub const DEFAULT_WORK: u64 = 3_000_000;

    /// A trajectory from rest to rest within these limits, for a controller that goes by cubics.
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            strict: false,
            seed: 0,
            most_work: Self::DEFAULT_WORK,
            start_velocity: None,
            fixed_waypoints: Fixed::Ends,
            controller: Controller::Cubic,
        }
    }
}

/// Waypoints that stay as they are, counted from 0; both ends always do.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Fixed {
    /// The ends alone.
    #[default]
    Ends,
    /// These, and the ends.
    These(Vec<usize>),
    /// All of the path.
    All,
}

impl Fixed {
    /// Whether a waypoint between the ends is one of them.
    pub fn contains(&self, waypoint: usize) -> bool {
        match self {
            Self::Ends => false,
            Self::These(list) => list.contains(&waypoint),
            Self::All => true,
        }
    }
}
