//! What a request may say beyond robot, scene and path.

use crate::borrow::{array, give_sized, maybe_text, sized, texts};
use crate::code::TAUT_MODE_HYBRID;
use crate::handle::wrong;
use std::ffi::c_char;
use std::ptr::null;
use std::time::Duration;
use taut_ipc::planner::{PlannerError, Request};
use taut_ipc::wire::Mode;

/// Options of a request; `taut_options_default` fills them in. Arrays and strings are read during
/// the call that they are given to, and not kept.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Options {
    /// sizeof(taut_options).
    pub size: usize,
    /// Time that the request may take, in seconds from the call; 0 = no limit.
    pub deadline_s: f64,
    /// Distance that every pair of bodies must keep, in metres; 0 = the daemon's default, 1 mm.
    pub clearance_m: f64,
    /// Counted work to spend, the same on every machine; 0 = the default.
    pub work_budget: u64,
    /// Seed of every random choice.
    pub seed: u64,
    /// Version of the scene; 0 = the newest.
    pub scene_version: u64,
    /// One of TAUT_MODE_*.
    pub mode: u32,
    /// Higher is served first.
    pub priority: u32,
    /// Refuse a path that keeps less clearance, instead of lowering it for the pairs that come
    /// closer: 0 or 1.
    pub strict: u8,
    /// Columns of continuous joints are real numbers, not angles on the circle: 0 or 1.
    pub unwrapped: u8,
    /// Only the proof, sooner; do not look for what is nearest along the answer: 0 or 1.
    pub without_contacts: u8,
    /// TAUT_MODE_CHECK of `taut_shorten` only: tell again when a change of the scene makes the path
    /// unsafe or safe: 0 or 1.
    pub watch: u8,
    /// Keep the goal's numbers: a path whose angles lead there only by a step of more than half a
    /// turn is refused: 0 or 1.
    pub keep_goal: u8,
    /// 0; keeps what follows aligned.
    pub reserved: [u8; 3],
    /// Names of the path's columns, in the path's order; NULL = all of the robot's variables, in
    /// its order.
    pub columns: *const *const c_char,
    /// How many.
    pub column_count: usize,
    /// Names of variables and held joints without a column.
    pub held_names: *const *const c_char,
    /// Where each stands (rad or m).
    pub held_values: *const f64,
    /// How many.
    pub held_count: usize,
    /// Weights of the metric, one per velocity coordinate of the robot; NULL = metres of reach.
    pub weights: *const f64,
    /// How many.
    pub weight_count: usize,
    /// Names of joints that get a weight of their own.
    pub joint_weight_names: *const *const c_char,
    /// The weight of each.
    pub joint_weights: *const f64,
    /// How many.
    pub joint_weight_count: usize,
    /// Waypoints that stay as they are to the last bit, from 0; the ends always do.
    pub fixed_waypoints: *const usize,
    /// How many.
    pub fixed_count: usize,
    /// Group of the robot whose joints alone may leave their motion; NULL = all may.
    pub group: *const c_char,
}

const DEFAULT: Options = Options {
    size: size_of::<Options>(),
    deadline_s: 0.0,
    clearance_m: 0.0,
    work_budget: 0,
    seed: 0,
    scene_version: 0,
    mode: TAUT_MODE_HYBRID,
    priority: 0,
    strict: 0,
    unwrapped: 0,
    without_contacts: 0,
    watch: 0,
    keep_goal: 0,
    reserved: [0; 3],
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
};

/// Fills in options with what a request means that says nothing more. `size` is sizeof *options.
///
/// # Safety
/// `options` points to `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_options_default(options: *mut Options, size: usize) {
    // SAFETY: the caller promises that it is NULL or its own, and so large.
    unsafe { give_sized(options, size, Options { size, ..DEFAULT }) };
}

/// The request that options mean.
///
/// # Safety
/// NULL, or options whose pointers lead where the header says.
pub(crate) unsafe fn request(
    robot: String,
    scene: Option<String>,
    options: *const Options,
) -> Result<Request, PlannerError> {
    // SAFETY: the caller promises that its size is right.
    let options = unsafe { sized("options", options, DEFAULT) }?;
    for (name, flag) in [
        ("strict", options.strict),
        ("unwrapped", options.unwrapped),
        ("keep_goal", options.keep_goal),
        ("without_contacts", options.without_contacts),
        ("watch", options.watch),
    ] {
        if flag > 1 {
            return Err(wrong(format!(
                "options.{name} is {flag}; valid: 0, 1 (start from taut_options_default)"
            )));
        }
    }
    let mode = Mode::try_from(options.mode).map_err(|_| {
        wrong(format!(
            "options.mode is {}; valid: TAUT_MODE_CHECK 0 to TAUT_MODE_HYBRID 5",
            options.mode
        ))
    })?;
    // SAFETY: the caller promises arrays of what it counts.
    let (columns, held_names, held_values, weights, weight_names, joint_weights, fixed, group) = unsafe {
        (
            texts("options.columns", options.columns, options.column_count)?,
            texts("options.held_names", options.held_names, options.held_count)?,
            array(
                "options.held_values",
                options.held_values,
                options.held_count,
            )?,
            array("options.weights", options.weights, options.weight_count)?,
            texts(
                "options.joint_weight_names",
                options.joint_weight_names,
                options.joint_weight_count,
            )?,
            array(
                "options.joint_weights",
                options.joint_weights,
                options.joint_weight_count,
            )?,
            array(
                "options.fixed_waypoints",
                options.fixed_waypoints,
                options.fixed_count,
            )?,
            maybe_text("options.group", options.group)?,
        )
    };
    Ok(Request {
        scene,
        scene_version: options.scene_version,
        columns,
        held: held_names
            .into_iter()
            .zip(held_values.iter().copied())
            .collect(),
        mode,
        deadline: match options.deadline_s {
            0.0 => None,
            seconds => Some(duration("options.deadline_s", seconds)?),
        },
        work_budget: options.work_budget,
        seed: options.seed,
        clearance_m: if options.clearance_m == 0.0 {
            None
        } else {
            Some(options.clearance_m)
        },
        strict: options.strict == 1,
        unwrapped: options.unwrapped == 1,
        keep_goal: options.keep_goal == 1,
        contacts: options.without_contacts == 0,
        watch: options.watch == 1,
        metric: weights.to_vec(),
        joint_weights: weight_names
            .into_iter()
            .zip(joint_weights.iter().copied())
            .collect(),
        fixed_waypoints: fixed.to_vec(),
        group,
        priority: options.priority,
        ..Request::new(&robot, None)
    })
}

/// Seconds as a time; so many that nobody lives to see their end are a year.
pub(crate) fn duration(what: &str, seconds: f64) -> Result<Duration, PlannerError> {
    const YEAR: f64 = 365.0 * 86_400.0;
    if seconds.is_nan() || seconds < 0.0 {
        return Err(wrong(format!("{what} is {seconds} s; valid: 0 or more")));
    }
    Ok(Duration::from_secs_f64(seconds.min(YEAR)))
}
