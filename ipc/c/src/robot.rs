//! Robots: load, and look at their variables.

use crate::borrow::{give, maybe_text, sized, text, texts};
use crate::code::TAUT_SUCCESS;
use crate::daemon::Daemon;
use crate::error::{Error, plain, run};
use crate::handle::{Handle, Table, wrong};
use std::ffi::{CString, c_char};
use std::path::PathBuf;
use std::sync::Arc;
use taut_ipc::control::{RobotDescription, RobotSource};
use taut_ipc::planner::PlannerError;

/// A robot's variables, as they were when asked for. Freed by `taut_robot_free`.
pub struct Robot {
    _opaque: [u8; 0],
}

/// A description with its names as C has them.
pub(crate) struct Known {
    description: Arc<RobotDescription>,
    names: Vec<CString>,
}

impl Handle for Robot {
    type Value = Known;
    const NAME: &'static str = "taut_robot";

    fn table() -> &'static Table<Known> {
        static ROBOTS: Table<Known> = Table::new();
        &ROBOTS
    }
}

/// Files of a robot. Set `size` to sizeof(taut_robot_files), all that is not needed to 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RobotFiles {
    /// sizeof(taut_robot_files).
    pub size: usize,
    /// The URDF file.
    pub urdf: *const c_char,
    /// The SRDF file; NULL = none. Without it links joined by one joint may touch, nothing else.
    pub srdf: *const c_char,
    /// Names of packages that the URDF's meshes name as package://NAME/.
    pub package_names: *const *const c_char,
    /// The folder of each.
    pub package_folders: *const *const c_char,
    /// How many.
    pub package_count: usize,
}

/// One variable of a robot.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Variable {
    /// Its name, as columns are named; valid until the robot is freed.
    pub name: *const c_char,
    /// Lowest value (rad or m); -infinity = none.
    pub lower: f64,
    /// Highest value; infinity = none.
    pub upper: f64,
    /// Whether it is an angle on the circle.
    pub continuous: bool,
}

/// # Safety
/// Its pointers are NULL or lead where the header says.
unsafe fn source(files: &RobotFiles) -> Result<RobotSource, PlannerError> {
    let whole = |file: String| {
        std::path::absolute(&file).map_err(|error| wrong(format!("{file:?}: {error}")))
    };
    // SAFETY: the caller promises strings, and as many as it counts.
    let (urdf, srdf, names, folders) = unsafe {
        (
            text("files.urdf", files.urdf)?,
            maybe_text("files.srdf", files.srdf)?,
            texts(
                "files.package_names",
                files.package_names,
                files.package_count,
            )?,
            texts(
                "files.package_folders",
                files.package_folders,
                files.package_count,
            )?,
        )
    };
    let folders = folders
        .into_iter()
        .map(whole)
        .collect::<Result<Vec<PathBuf>, _>>()?;
    Ok(RobotSource {
        urdf: whole(urdf)?,
        srdf: srdf.map(whole).transpose()?,
        packages: names.into_iter().zip(folders).collect(),
        ..RobotSource::default()
    })
}

/// # Safety
/// `place` is NULL or the caller's.
unsafe fn hand_out(description: Arc<RobotDescription>, place: *mut *mut Robot) -> i32 {
    if !place.is_null() {
        let names = description
            .variables
            .iter()
            .map(|variable| plain(&variable.name))
            .collect();
        // SAFETY: the caller promises that it is its own.
        unsafe { give(place, Robot::of(Known { description, names })) };
    }
    TAUT_SUCCESS
}

/// Loads a robot under a label; with `replace`, even if the label names another one. `robot` may be
/// NULL.
///
/// Codes: TAUT_INVALID_MODEL, TAUT_UNREADABLE_FILE, TAUT_LABEL_TAKEN.
///
/// # Safety
/// Strings and arrays are what `taut_robot_files` says; `robot` and `error` are NULL or places for
/// handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_load_robot(
    daemon: *const Daemon,
    label: *const c_char,
    files: *const RobotFiles,
    replace: bool,
    robot: *mut *mut Robot,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let planner = Daemon::get(daemon)?;
        let null = std::ptr::null();
        let none = RobotFiles {
            size: size_of::<RobotFiles>(),
            urdf: null,
            srdf: null,
            package_names: std::ptr::null(),
            package_folders: std::ptr::null(),
            package_count: 0,
        };
        // SAFETY: the caller's promises are the same.
        unsafe {
            let files = sized("files", files, none)?;
            let description =
                planner.load_robot(&text("label", label)?, &source(&files)?, replace)?;
            Ok(hand_out(description, robot))
        }
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Variables of a robot that is loaded.
///
/// Codes: TAUT_UNKNOWN_ROBOT; the message has the labels that are loaded.
///
/// # Safety
/// `label` is a string; `robot` and `error` are NULL or places for handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_describe_robot(
    daemon: *const Daemon,
    label: *const c_char,
    robot: *mut *mut Robot,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let planner = Daemon::get(daemon)?;
        // SAFETY: the caller's promises are the same.
        unsafe { Ok(hand_out(planner.robot(&text("label", label)?)?, robot)) }
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// How many variables a robot has; 0 for one that is freed.
#[unsafe(no_mangle)]
pub extern "C" fn taut_robot_variables(robot: *const Robot) -> usize {
    Robot::get(robot).map_or(0, |known| known.names.len())
}

/// One variable, in the robot's order: true and `*variable` filled in, or false for an index beyond
/// the last.
///
/// # Safety
/// `variable` points to a `taut_variable`, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_robot_variable(
    robot: *const Robot,
    index: usize,
    variable: *mut Variable,
) -> bool {
    let Ok(known) = Robot::get(robot) else {
        return false;
    };
    let Some((found, name)) = known
        .description
        .variables
        .get(index)
        .zip(known.names.get(index))
    else {
        return false;
    };
    let value = Variable {
        name: name.as_ptr(),
        lower: found.lower,
        upper: found.upper,
        continuous: found.continuous,
    };
    // SAFETY: the caller promises that it is NULL or its own.
    unsafe { give(variable, value) };
    true
}

/// Frees a description; the robot stays loaded. NULL and descriptions that are freed are let be.
#[unsafe(no_mangle)]
pub extern "C" fn taut_robot_free(robot: *mut Robot) {
    drop(Robot::end(robot));
}
