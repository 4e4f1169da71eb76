//! Scenes: load, and change.

use crate::borrow::{give_sized, maybe_text, needed, text, texts};
use crate::code::TAUT_SUCCESS;
use crate::daemon::Daemon;
use crate::error::{Error, run};
use crate::handle::Handle;
use std::ffi::c_char;
use std::path::PathBuf;
use taut_ipc::control::SceneSummary;
use taut_ipc::planner::{Planner, PlannerError, words};

/// Where something stands.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Pose {
    /// x y z, in metres.
    pub position: [f64; 3],
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
}

/// A version of a scene.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SceneInfo {
    /// Its number.
    pub version: u64,
    /// Hash of its content.
    pub hash: u64,
    /// Objects in it.
    pub objects: u32,
    /// 0.
    pub reserved: u32,
}

/// Where the outcome of a call goes.
struct Outcome {
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
}

/// Does a call on a scene of a daemon.
///
/// # Safety
/// Handle, label and places are what the header says.
unsafe fn on_scene(
    daemon: *const Daemon,
    label: *const c_char,
    outcome: &Outcome,
    work: impl FnOnce(&Planner, &str) -> Result<SceneSummary, PlannerError>,
) -> i32 {
    let whole = || {
        let planner = Daemon::get(daemon)?;
        // SAFETY: the caller promises a string.
        let label = unsafe { text("label", label) }?;
        let scene = work(&planner, &label)?;
        let info = SceneInfo {
            version: scene.version,
            hash: scene.scene_hash,
            objects: scene.objects,
            reserved: 0,
        };
        // SAFETY: the caller promises that it is NULL or its own, and so large.
        unsafe { give_sized(outcome.info, outcome.size, info) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(outcome.error, whole) }
}

/// # Safety
/// NULL or a pose of the caller's.
unsafe fn pose_of(pose: *const Pose) -> Result<words::Pose, PlannerError> {
    let pose = needed("pose", pose.cast_mut())?;
    // SAFETY: not null, and the caller promises a pose.
    let Pose {
        position,
        orientation,
    } = unsafe { pose.read() };
    Ok(words::Pose {
        position,
        orientation,
    })
}

/// Loads a scene (JSON text, as scene files are) under a label; with `replace`, even if the label
/// names another one. Mesh files in it start from `folder`, which may be NULL. `info` may be NULL;
/// `size` is sizeof *info.
///
/// # Safety
/// Strings are strings; places are NULL or the caller's, `info` of `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_load_scene(
    daemon: *const Daemon,
    label: *const c_char,
    json: *const c_char,
    folder: *const c_char,
    replace: bool,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                let folder = maybe_text("folder", folder)?.map(PathBuf::from);
                planner.load_scene(label, &text("json", json)?, folder.as_deref(), replace)
            },
        )
    }
}

/// Makes the changes of a diff (JSON with "is_diff": true), all or none: the scene's next version.
/// The scene has to have the version `base`; 0 = any.
///
/// Codes: TAUT_VERSION_CONFLICT, TAUT_INVALID_OBJECT_NAME, TAUT_INVALID_LINK_NAME.
///
/// # Safety
/// As `taut_load_scene`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_change_scene(
    daemon: *const Daemon,
    label: *const c_char,
    json: *const c_char,
    folder: *const c_char,
    base: u64,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                let folder = maybe_text("folder", folder)?.map(PathBuf::from);
                planner.change_scene(label, &text("json", json)?, folder.as_deref(), base)
            },
        )
    }
}

/// Moves an object of the world, or, with a `link`, one that the link carries, `pose` then being in
/// the link's frame.
///
/// # Safety
/// As `taut_load_scene`; `link` is NULL or a string, `pose` points to a pose.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_move_object(
    daemon: *const Daemon,
    label: *const c_char,
    object: *const c_char,
    link: *const c_char,
    pose: *const Pose,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                let object = text("object", object)?;
                let link = maybe_text("link", link)?;
                planner.change_scene(
                    label,
                    &words::moved(&object, link.as_deref(), &pose_of(pose)?),
                    None,
                    0,
                )
            },
        )
    }
}

/// Lets a link carry an object of the world, its pose in the link's frame. It may touch the link
/// and the `touch_links`.
///
/// # Safety
/// As `taut_move_object`; `touch_links` are `touch_count` strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_attach_object(
    daemon: *const Daemon,
    label: *const c_char,
    object: *const c_char,
    link: *const c_char,
    pose: *const Pose,
    touch_links: *const *const c_char,
    touch_count: usize,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                let object = text("object", object)?;
                let link = text("link", link)?;
                let touch_links = texts("touch_links", touch_links, touch_count)?;
                planner.change_scene(
                    label,
                    &words::attached(&object, &link, &pose_of(pose)?, &touch_links),
                    None,
                    0,
                )
            },
        )
    }
}

/// Puts an attached object down, its pose in the world.
///
/// # Safety
/// As `taut_move_object`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_detach_object(
    daemon: *const Daemon,
    label: *const c_char,
    object: *const c_char,
    pose: *const Pose,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                planner.change_scene(
                    label,
                    &words::detached(&text("object", object)?, &pose_of(pose)?),
                    None,
                    0,
                )
            },
        )
    }
}

/// Takes an object out of the world.
///
/// # Safety
/// As `taut_load_scene`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_remove_object(
    daemon: *const Daemon,
    label: *const c_char,
    object: *const c_char,
    info: *mut SceneInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promises are the same.
    unsafe {
        on_scene(
            daemon,
            label,
            &Outcome { info, size, error },
            |planner, label| {
                planner.change_scene(label, &words::removed(&text("object", object)?), None, 0)
            },
        )
    }
}
