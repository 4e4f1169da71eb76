//! Errors as objects, and the guard around every call.

use crate::borrow::{give, give_sized};
use crate::code::{TAUT_CRASH, TAUT_SUCCESS};
use crate::handle::{Handle, Table};
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use taut_ipc::planner::PlannerError;

/// Why a call failed: a code, a line for people, and, where a path is at fault, bodies and place.
/// Made by calls that take a `taut_error **`; freed by `taut_error_free`.
pub struct Error {
    _opaque: [u8; 0],
}

/// What an error says, in C's words.
pub(crate) struct Failure {
    code: i32,
    message: CString,
    retry_after_ms: u32,
    bodies: [CString; 2],
    place: Option<Place>,
}

/// Where a path is not free, or not proved.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Place {
    /// Names of the two bodies; valid until the error is freed.
    pub bodies: [*const c_char; 2],
    /// Segment of the path, from 0.
    pub segment: u32,
    /// 0; keeps what follows aligned.
    pub reserved: u32,
    /// Ratio on the segment, 0 to 1.
    pub t: f64,
    /// Depth in metres; negative is a distance.
    pub depth_m: f64,
    /// A point on each body, world frame, in metres.
    pub points: [[f64; 3]; 2],
    /// Unit vector from the second body to the first.
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
        let bodies = [CString::default(), CString::default()];
        Self {
            code,
            message: plain(message),
            retry_after_ms: 0,
            bodies,
            place: None,
        }
    }

    fn of(error: &PlannerError) -> Self {
        let mut failure = Self::new(error.code().into(), &error.to_string());
        failure.retry_after_ms = error.retry_after_ms();
        if let Some(place) = error.place() {
            failure.bodies = [plain(&place.bodies[0]), plain(&place.bodies[1])];
            failure.place = Some(Place {
                bodies: failure
                    .bodies
                    .each_ref()
                    .map(|body| body.as_ptr()),
                segment: place.segment,
                reserved: 0,
                t: place.t,
                depth_m: place.depth_m,
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
