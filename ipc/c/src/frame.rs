//! Frames of sensors.

use crate::borrow::{array, give_sized, maybe_text, needed, sized, text, texts};
use crate::code::TAUT_SUCCESS;
use crate::daemon::Daemon;
use crate::error::{Error, run};
use crate::handle::{Handle, wrong};
use crate::scene::Pose;
use std::ffi::c_char;
use taut_ipc::control::{CloudFrame, FrameSummary, PointField, PointLayout};
use taut_ipc::monotonic_ns;
use taut_ipc::planner::PlannerError;

/// A sensor's frame, besides its points. Zeros but for `size`, `points` and `stride` are a frame of
/// f32 points, seen now by a sensor in the world's origin, with no robot in view.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Frame {
    /// sizeof(taut_frame).
    pub size: usize,
    /// When the sensor saw it, in nanoseconds of CLOCK_MONOTONIC; 0 = now.
    pub taken_ns: u64,
    /// Where the points' frame is in the frame of `link`, or in the world; NULL = in its origin.
    pub pose: *const Pose,
    /// Label of the robot that may be in the picture, whose points are left out; NULL = none.
    pub robot: *const c_char,
    /// The robot's link that carries the sensor; NULL = it stands in the world.
    pub link: *const c_char,
    /// Names of the robot's variables.
    pub joint_names: *const *const c_char,
    /// Their values at that moment (m or rad).
    pub joint_values: *const f64,
    /// How many.
    pub joints: usize,
    /// How many points there are.
    pub points: u32,
    /// Bytes from a point to the next.
    pub stride: u32,
    /// Where x begins in a point (bytes); y and z follow.
    pub offset: u32,
    /// Whether coordinates are double, not float.
    pub is_double: u32,
}

/// What came of a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FrameInfo {
    /// The scene's version with it.
    pub version: u64,
    /// Hash of that version's content.
    pub hash: u64,
    /// Points that came.
    pub came: u32,
    /// Points that are none: not finite, or in the sensor's very origin.
    pub not_finite: u32,
    /// Points left out as the robot's own or those of what it carries.
    pub on_robot: u32,
    /// Of these, points that only the padding holds: the world may be there.
    pub in_padding: u32,
    /// Points that others in their cells stand for.
    pub thinned: u32,
    /// Points of the shape.
    pub points: u32,
}

impl From<FrameSummary> for FrameInfo {
    fn from(summary: FrameSummary) -> Self {
        Self {
            version: summary.scene_version,
            hash: summary.scene_hash,
            came: summary.came,
            not_finite: summary.not_finite,
            on_robot: summary.on_robot,
            in_padding: summary.in_padding,
            thinned: summary.thinned,
            points: summary.points,
        }
    }
}

/// # Safety
/// What the frame points to is what its header says.
unsafe fn head(given: *const Frame) -> Result<CloudFrame, PlannerError> {
    let given = needed("frame", given.cast_mut())?;
    let nothing = Frame {
        size: size_of::<Frame>(),
        taken_ns: 0,
        pose: std::ptr::null(),
        robot: std::ptr::null(),
        link: std::ptr::null(),
        joint_names: std::ptr::null(),
        joint_values: std::ptr::null(),
        joints: 0,
        points: 0,
        stride: 0,
        offset: 0,
        is_double: 0,
    };
    // SAFETY: not null; the caller's promises are the same.
    let (frame, names, values, robot, link) = unsafe {
        let frame = sized("frame", given, nothing)?;
        (
            frame,
            texts("joint_names", frame.joint_names, frame.joints)?,
            array("joint_values", frame.joint_values, frame.joints)?,
            maybe_text("robot", frame.robot)?,
            maybe_text("link", frame.link)?,
        )
    };
    // SAFETY: NULL, or a pose of the caller's.
    let pose = unsafe { frame.pose.as_ref() };
    Ok(CloudFrame {
        taken_ns: match frame.taken_ns {
            0 => monotonic_ns(),
            taken_ns => taken_ns,
        },
        pose: pose.map_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], numbers),
        robot: robot.unwrap_or_default(),
        link: link.unwrap_or_default(),
        joints: names
            .into_iter()
            .zip(values.iter().copied())
            .collect(),
        layout: layout(&frame)?,
    })
}

fn numbers(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.position;
    let [qx, qy, qz, qw] = pose.orientation;
    [x, y, z, qx, qy, qz, qw]
}

fn layout(frame: &Frame) -> Result<PointLayout, PlannerError> {
    let (datatype, size) = match frame.is_double {
        0 => (PointField::FLOAT32, 4),
        1 => (PointField::FLOAT64, 8),
        other => return Err(wrong(format!("is_double is {other}; valid: 0, 1"))),
    };
    let too_long = || {
        wrong(format!(
            "{} points of {} bytes are too many",
            frame.points, frame.stride
        ))
    };
    let packed = PointLayout::packed(frame.points.min(1), datatype);
    let mut fields = packed.fields;
    for (index, field) in fields.iter_mut().enumerate() {
        let begins = index as u32 * size;
        field.offset = frame
            .offset
            .checked_add(begins)
            .ok_or_else(too_long)?;
    }
    let row_step = frame
        .points
        .checked_mul(frame.stride)
        .ok_or_else(too_long)?;
    Ok(PointLayout {
        height: 1,
        width: frame.points,
        point_step: frame.stride,
        row_step,
        is_bigendian: false,
        fields,
    })
}

/// A sensor's frame: `points`, `bytes` long, are the shape of a sensed object of a scene from now
/// on, in the scene's next version. An object is sensed whose scene file or diff says
/// "sensed": {"radius": metres}; until its first frame, requests in that scene are answered with
/// TAUT_LOADING. Points are copied once, into shared memory. A sensor has a daemon handle of its own.
/// `info` may be NULL; `size` is sizeof *info.
///
/// Codes: TAUT_PREEMPTED where a newer frame has come, TAUT_INVALID_OBJECT_NAME.
///
/// # Safety
/// Strings are strings, `frame` and what it points to are as its fields say, `points` has so many
/// bytes; places are NULL or the caller's, `info` of `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_set_cloud(
    daemon: *const Daemon,
    scene: *const c_char,
    object: *const c_char,
    frame: *const Frame,
    points: *const u8,
    bytes: usize,
    info: *mut FrameInfo,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    let whole = || {
        let planner = Daemon::get(daemon)?;
        // SAFETY: the caller's promises are the same.
        let (scene, object, frame, points) = unsafe {
            (
                text("scene", scene)?,
                text("object", object)?,
                head(frame)?,
                array("points", points, bytes)?,
            )
        };
        let taken = planner.set_cloud(&scene, &object, frame, points)?;
        // SAFETY: the caller promises that it is NULL or its own, and so large.
        unsafe { give_sized(info, size, FrameInfo::from(taken)) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, whole) }
}
