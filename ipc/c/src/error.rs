//! Errors as objects, and the guard around every call.

use crate::borrow::{give, give_sized};
use crate::code::{TAUT_CRASH, TAUT_SUCCESS};
use crate::handle::{Handle, Table};
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::{RequirementKind, Unit};

/// Why a call failed: a code, a line for people, and, where a path is at fault, what it does not keep
/// and where.
/// Made by calls that take a `taut_error **`; freed by `taut_error_free`.
pub struct Error {
    _opaque: [u8; 0],
}

/// What an error says, in C's words.
pub(crate) struct Failure {
    code: i32,
    message: CString,
    retry_after_ms: u32,
    names: [CString; 2],
    place: Option<Place>,
}

/// Kind of what a path must keep: the distance of two bodies, at least the floor. Below 0 they
/// overlap: the penetration depth, from below unless both are convex.
pub const TAUT_KIND_CLEARANCE: u32 = 0;
/// What is left of how far something may turn; below 0 it is outside by so much.
pub const TAUT_KIND_ORIENTATION: u32 = 1;
/// What is left of where a point may be; below 0 it is outside by so much.
pub const TAUT_KIND_POSITION: u32 = 2;
/// What is left of where a joint may be; below 0 it is outside by so much.
pub const TAUT_KIND_JOINT: u32 = 3;

/// Unit of amounts and floors: metres.
pub const TAUT_UNIT_METRE: u32 = 0;
/// Unit of amounts and floors: radians.
pub const TAUT_UNIT_RADIAN: u32 = 1;

const _: () = assert!(TAUT_KIND_CLEARANCE == RequirementKind::Clearance as u32);
const _: () = assert!(TAUT_KIND_ORIENTATION == RequirementKind::Orientation as u32);
const _: () = assert!(TAUT_KIND_POSITION == RequirementKind::Position as u32);
const _: () = assert!(TAUT_KIND_JOINT == RequirementKind::Joint as u32);
const _: () = assert!(TAUT_UNIT_METRE == Unit::Metre as u32);
const _: () = assert!(TAUT_UNIT_RADIAN == Unit::Radian as u32);

/// Where a path does not keep what it must, or is not proved to.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Place {
    /// What is not kept is about these: of a clearance the two bodies. One that is empty is no name.
    /// Valid until the error is freed.
    pub names: [*const c_char; 2],
    /// What kind of thing it is, TAUT_KIND_*; newer versions have more kinds.
    pub kind: u32,
    /// What `amount` and `allowed` are counted in, TAUT_UNIT_*.
    pub unit: u32,
    /// Segment of the path, from 0.
    pub segment: u32,
    /// 0; keeps what follows aligned.
    pub reserved: u32,
    /// Ratio on the segment, 0 to 1.
    pub t: f64,
    /// How much is kept there.
    pub amount: f64,
    /// The floor: how much must be kept.
    pub allowed: f64,
    /// Where that is seen, world frame, in metres: of a clearance a point on each body.
    pub points: [[f64; 3]; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body to the first.
    pub normal: [f64; 3],
}

// SAFETY: its pointers lead into the failure that it is part of; nothing is written through them.
unsafe impl Send for Place {}
// SAFETY: as above.
unsafe impl Sync for Place {}

impl Handle for Error {
    type Value = Failure;
    const NAME: &'static str = "taut_error";

    fn table() -> &'static Table<Failure> {
        static ERRORS: Table<Failure> = Table::new();
        &ERRORS
    }
}

impl Failure {
    fn new(code: i32, message: &str) -> Self {
        Self {
            code,
            message: plain(message),
            retry_after_ms: 0,
            names: Default::default(),
            place: None,
        }
    }

    fn of(error: &PlannerError) -> Self {
        let mut failure = Self::new(error.code().into(), &error.to_string());
        failure.retry_after_ms = error.retry_after_ms();
        if let Some(place) = error.place() {
            for (text, name) in failure.names.iter_mut().zip(&place.names) {
                *text = plain(name);
            }
            failure.place = Some(Place {
                names: failure
                    .names
                    .each_ref()
                    .map(|name| name.as_ptr()),
                kind: place.kind.into(),
                unit: place.unit.into(),
                segment: place.segment,
                reserved: 0,
                t: place.t,
                amount: place.amount,
                allowed: place.allowed,
                points: place.points,
                normal: place.normal,
            });
        }
        failure
    }
}

/// A text without zeros, which C would take for its end.
pub(crate) fn plain(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Does a call's work; a panic stops here. The error goes to `place`, NULL where there is none.
///
/// # Safety
/// `place` is NULL or the caller's.
pub(crate) unsafe fn run(
    place: *mut *mut Error,
    work: impl FnOnce() -> Result<i32, PlannerError>,
) -> i32 {
    let (code, failure) = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(code)) => (code, None),
        Ok(Err(error)) => (error.code().into(), Some(Failure::of(&error))),
        Err(panic) => {
            let text = panic
                .downcast_ref::<&str>()
                .copied()
                .map(str::to_owned);
            let text = text
                .or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_default();
            (
                TAUT_CRASH,
                Some(Failure::new(
                    TAUT_CRASH,
                    &format!("taut's library panicked: {text}; please report it"),
                )),
            )
        }
    };
    let error = if place.is_null() {
        ptr::null_mut()
    } else {
        failure.map_or(ptr::null_mut(), Error::of)
    };
    // SAFETY: the caller promises that it is NULL or its own.
    unsafe { give(place, error) };
    code
}

/// The code of an error; TAUT_SUCCESS for NULL, TAUT_MALFORMED_REQUEST for one that is freed.
#[unsafe(no_mangle)]
pub extern "C" fn taut_error_code(error: *const Error) -> i32 {
    if error.is_null() {
        return TAUT_SUCCESS;
    }
    Error::get(error).map_or_else(|wrong| wrong.code().into(), |failure| failure.code)
}

/// What happened, in one line: the bad value, the valid ones and the next step. Valid until the
/// error is freed.
#[unsafe(no_mangle)]
pub extern "C" fn taut_error_message(error: *const Error) -> *const c_char {
    const NONE: &CStr = c"";
    Error::get(error).map_or(NONE.as_ptr(), |failure| failure.message.as_ptr())
}

/// When the same call may succeed, in milliseconds; 0 = never.
#[unsafe(no_mangle)]
pub extern "C" fn taut_error_retry_after_ms(error: *const Error) -> u32 {
    Error::get(error).map_or(0, |failure| failure.retry_after_ms)
}

/// Where on the path, if that is what is wrong: true and `*place` filled in, or false. `size` is
/// sizeof *place.
///
/// # Safety
/// `place` points to `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_error_place(
    error: *const Error,
    place: *mut Place,
    size: usize,
) -> bool {
    let Some(found) = Error::get(error)
        .ok()
        .and_then(|failure| failure.place)
    else {
        return false;
    };
    // SAFETY: the caller promises that it is NULL or its own, and so large.
    unsafe { give_sized(place, size, found) };
    true
}

/// Frees an error and its texts. NULL and errors that are freed are let be.
#[unsafe(no_mangle)]
pub extern "C" fn taut_error_free(error: *mut Error) {
    drop(Error::end(error));
}
