//! Modes and options, made from the table of options by
//! `UPDATE_OPTIONS=1 cargo test -p taut-ipc --test options`; do not edit.

use crate::borrow::{array, maybe_text, texts};
use crate::values::{flag, given, mode, named, seconds};
use std::ffi::c_char;
use std::ptr::null;
use taut_ipc::planner::{PlannerError, Request};

/// `taut_options.mode`: prove the path, change nothing.
pub const TAUT_MODE_CHECK: u32 = 0;
/// `taut_options.mode`: the gradient method.
pub const TAUT_MODE_GRADIENT: u32 = 1;
/// `taut_options.mode`: shortcuts between random configurations.
pub const TAUT_MODE_RANDOM_SHORTCUT: u32 = 2;
/// `taut_options.mode`: shortcuts of single joints.
pub const TAUT_MODE_PARTIAL_SHORTCUT: u32 = 3;
/// `taut_options.mode`: the gradient method with contact half-spaces.
pub const TAUT_MODE_CONTACT: u32 = 4;
/// `taut_options.mode`: shortcuts and contact half-spaces in turns, by what they gain.
pub const TAUT_MODE_HYBRID: u32 = 5;

/// Options of a request; `taut_options_default` fills them in. Arrays and strings are read during
/// the call that they are given to, and not kept. `docs/options.md` has them in other languages.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Options {
    /// sizeof(taut_options).
    pub size: usize,
    /// Time that the request may take, from when it is sent; the best path by then is the answer,
    /// in seconds; 0 = no limit.
    pub deadline_s: f64,
    /// Distance that every pair of bodies must keep, in metres; 0 = 1mm.
    pub clearance_m: f64,
    /// Most work to spend on a shorter path, in the units of the answer's `work`: the same on every
    /// machine; 0 = 200,000,000.
    pub work_budget: u64,
    /// Seed of every random choice.
    pub seed: u64,
    /// Version of the scene, of those that are kept; 0 = the newest.
    pub scene_version: u64,
    /// Refuse where what a sensor sees of the scene is older than this, in seconds; 0 = any age.
    pub max_age_s: f64,
    /// Optimizer, one of TAUT_MODE_*.
    pub mode: u32,
    /// Class of the request: one of a higher class is served first.
    pub priority: u32,
    /// Refuse a path that keeps less, instead of lowering the clearance of the pairs that come
    /// closer: 0 or 1.
    pub strict: u8,
    /// Take the columns of continuous joints as they stand, as real numbers and not as angles on
    /// the circle: 0 or 1.
    pub unwrapped: u8,
    /// Do not look for what is nearest along the path; without it the answer comes sooner: 0 or 1.
    pub without_contacts: u8,
    /// Mode check only: tell again when a change of the scene makes the path unsafe or safe, until
    /// the request is dropped: 0 or 1.
    pub watch: u8,
    /// Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than
    /// half a turn, and take no path that ends whole turns away: 0 or 1.
    pub keep_goal: u8,
    /// Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell how far
    /// what is executed may stray from the path: 0 or 1.
    pub corridor: u8,
    /// 0; keeps what follows aligned.
    pub reserved: [u8; 2],
    /// Names of the path's columns, in the path's order; joints of the robot that are missing stand
    /// still; NULL = all of the robot's, in its order.
    pub columns: *const *const c_char,
    /// How many.
    pub column_count: usize,
    /// Where a joint stands that is no column of the path, instead of at 0: names, and a number for
    /// each; 0 of them = 0.
    pub held_names: *const *const c_char,
    /// The number of each.
    pub held_values: *const f64,
    /// How many.
    pub held_count: usize,
    /// Weights of the metric, one per velocity coordinate of the robot; NULL = metres of reach.
    pub weights: *const f64,
    /// How many.
    pub weight_count: usize,
    /// Weight of a joint in the metric, by its name, instead of the one that it has: names, and a
    /// number for each; 0 of them = the metric's.
    pub joint_weight_names: *const *const c_char,
    /// The number of each.
    pub joint_weights: *const f64,
    /// How many.
    pub joint_weight_count: usize,
    /// Waypoints that stay as they are to the last bit, counted from 0; the ends always do; NULL =
    /// the ends.
    pub fixed_waypoints: *const usize,
    /// How many.
    pub fixed_count: usize,
    /// Group of the robot: only its joints may move otherwise than on the path given; NULL = all
    /// may.
    pub group: *const c_char,
    /// What the path must keep besides clearance, see docs/constraints.md: MoveIt's Constraints in
    /// JSON, a list of such, or few words such as "upright hand:x=0.1"; NULL = nothing.
    pub constraints: *const c_char,
    /// A trajectory along the path, near the least time that the motors allow and proved as it is
    /// written, see docs/timing.md: what they allow, and how it is executed. MoveIt's
    /// joint_limits.yaml, with our words beside it, or few words such as "acceleration=2/s
    /// speed=0.5"; NULL = no times.
    pub timing: *const c_char,
}

/// What a request means that says nothing more.
pub(crate) const DEFAULT: Options = Options {
    size: size_of::<Options>(),
    deadline_s: 0.0,
    clearance_m: 0.0,
    work_budget: 0,
    seed: 0,
    scene_version: 0,
    max_age_s: 0.0,
    mode: TAUT_MODE_HYBRID,
    priority: 0,
    strict: 0,
    unwrapped: 0,
    without_contacts: 0,
    watch: 0,
    keep_goal: 0,
    corridor: 0,
    reserved: [0; 2],
    columns: null(),
    column_count: 0,
    held_names: null(),
    held_values: null(),
    held_count: 0,
    weights: null(),
    weight_count: 0,
    joint_weight_names: null(),
    joint_weights: null(),
    joint_weight_count: 0,
    fixed_waypoints: null(),
    fixed_count: 0,
    group: null(),
    constraints: null(),
    timing: null(),
};

/// Enters the numbers.
pub(crate) fn enter_numbers(options: &Options, request: &mut Request) -> Result<(), PlannerError> {
    request.deadline = seconds("options.deadline_s", options.deadline_s)?;
    request.clearance_m = given(options.clearance_m);
    request.work_budget = options.work_budget;
    request.seed = options.seed;
    request.scene_version = options.scene_version;
    request.max_age = seconds("options.max_age_s", options.max_age_s)?;
    request.mode = mode(options.mode)?;
    request.priority = options.priority;
    Ok(())
}

/// Enters the flags.
pub(crate) fn enter_flags(options: &Options, request: &mut Request) -> Result<(), PlannerError> {
    request.strict = flag("strict", options.strict)?;
    request.unwrapped = flag("unwrapped", options.unwrapped)?;
    request.contacts = !flag("without_contacts", options.without_contacts)?;
    request.watch = flag("watch", options.watch)?;
    request.keep_goal = flag("keep_goal", options.keep_goal)?;
    request.corridor = flag("corridor", options.corridor)?;
    Ok(())
}

/// Enters the names and arrays.
///
/// # Safety
/// Pointers lead where the header says.
pub(crate) unsafe fn enter_arrays(
    options: &Options,
    request: &mut Request,
) -> Result<(), PlannerError> {
    // SAFETY: the caller promises arrays of what it counts.
    let columns = unsafe { texts("options.columns", options.columns, options.column_count) }?;
    request.columns = columns;
    // SAFETY: the caller promises arrays of what it counts.
    let held = unsafe { named("options.held_names", options.held_names, options.held_values, options.held_count) }?;
    request.held = held;
    // SAFETY: the caller promises arrays of what it counts.
    let metric = unsafe { array("options.weights", options.weights, options.weight_count) }?;
    request.metric = metric.to_vec();
    // SAFETY: the caller promises arrays of what it counts.
    let joint_weights = unsafe { named("options.joint_weight_names", options.joint_weight_names, options.joint_weights, options.joint_weight_count) }?;
    request.joint_weights = joint_weights;
    // SAFETY: the caller promises arrays of what it counts.
    let fixed_waypoints = unsafe { array("options.fixed_waypoints", options.fixed_waypoints, options.fixed_count) }?;
    request.fixed_waypoints = fixed_waypoints.to_vec();
    // SAFETY: the caller promises arrays of what it counts.
    let group = unsafe { maybe_text("options.group", options.group) }?;
    request.group = group;
    // SAFETY: the caller promises arrays of what it counts.
    let constraints = unsafe { maybe_text("options.constraints", options.constraints) }?;
    request.constraints = constraints.unwrap_or_default();
    // SAFETY: the caller promises arrays of what it counts.
    let timing = unsafe { maybe_text("options.timing", options.timing) }?;
    request.timing = timing.unwrap_or_default();
    Ok(())
}
