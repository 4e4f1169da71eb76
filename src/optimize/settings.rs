//! What a request may choose.

use super::mode::Mode;
use crate::constraint::ConstraintsFile;
use crate::validation::Layers;

/// Settings of one request. `Settings::default()` is what a request gets that says nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Optimizer.
    pub mode: Mode,
    /// Seed of every random choice: same request, same answer.
    pub seed: u64,
    /// Distance that every pair must keep (m).
    pub clearance_m: f64,
    /// Refuse an input that keeps less, instead of lowering the floors of the pairs that do.
    pub strict: bool,
    /// Take the columns of continuous joints as they stand instead of as angles on the circle.
    pub unwrapped: bool,
    /// Keep the goal's numbers to the last bit, also where a path that ends whole turns away is
    /// shorter; an input whose numbers do not lead there is refused.
    pub keep_goal: bool,
    /// Weights of the metric, one per velocity coordinate; `None` = reach weights.
    pub weights: Option<Vec<f64>>,
    /// Most work (pairs examined at nodes) to spend after the input is proved; 0 = the default.
    pub work_budget: u64,
    /// Waypoints that must stay bit-equal, one entry per waypoint; `None` = first and last only.
    pub fixed_waypoints: Option<Vec<bool>>,
    /// Velocity coordinates that may move, one entry each; `None` = all.
    pub moving: Option<Vec<bool>>,
    /// What the path must keep besides clearances, in MoveIt's words; empty = nothing.
    pub constraints: ConstraintsFile,
    /// Values of the held variables; `None` = their defaults.
    pub held: Option<Vec<f64>>,
    /// Look for what is nearest along the answer once it is proved; costs a few times its proof.
    pub contacts: bool,
    /// Prove each segment of the answer again at the largest clearance that it keeps, up to 10 cm,
    /// for its corridor; costs some times its proof.
    pub corridor: bool,
    /// What the validator may use: all of it, but where a measurement wants to know what a layer is
    /// worth.
    pub layers: Layers,
}

impl Settings {
    /// Clearance of a request that gives none (m).
    pub const DEFAULT_CLEARANCE_M: f64 = 1e-3;
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            seed: 0,
            clearance_m: Self::DEFAULT_CLEARANCE_M,
            strict: false,
            unwrapped: false,
            keep_goal: false,
            weights: None,
            work_budget: 0,
            fixed_waypoints: None,
            moving: None,
            constraints: ConstraintsFile::default(),
            held: None,
            contacts: true,
            corridor: false,
            layers: Layers::default(),
        }
    }
}
