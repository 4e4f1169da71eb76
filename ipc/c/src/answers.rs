//! Requests in flight.

use crate::answer::{Answer, Held, Info, info_of};
use crate::borrow::{array, give, give_sized, maybe_text, needed, text};
use crate::code::{TAUT_END, TAUT_PENDING, TAUT_SUCCESS};
use crate::daemon::Daemon;
use crate::error::{Error, run};
use crate::handle::{Handle, Table, wrong};
use crate::options::request;
use crate::options_table::Options;
use crate::values::duration;
use std::ffi::c_char;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use taut_ipc::ClientError;
use taut_ipc::limits::BORROWED_RESPONSES;
use taut_ipc::planner::{Best, Planner, PlannerError, Request};
use taut_ipc::wire::{Code, Mode};

/// How long a waiting call may not notice that another thread cancels or wants the best so far.
const NOTICE: Duration = Duration::from_millis(10);

/// Answers of one request that may be unfreed when the next is taken, as the header says.
const HELD: usize = 2;
const _: () = assert!(
    HELD < BORROWED_RESPONSES,
    "one more is received while they are held"
);

/// A request in flight: the stream of its answers. Freed, and so cancelled, by `taut_answers_free`.
pub struct Answers {
    _opaque: [u8; 0],
}

/// A request and what other threads want of the one that waits for it.
pub(crate) struct Flight {
    answers: Mutex<taut_ipc::planner::Answers>,
    cancelled: AtomicBool,
    finish: AtomicBool,
    /// Its answers that are not freed.
    held: Arc<AtomicUsize>,
}

impl Handle for Answers {
    type Value = Flight;
    const NAME: &'static str = "taut_answers";

    fn table() -> &'static Table<Flight> {
        static FLIGHTS: Table<Flight> = Table::new();
        &FLIGHTS
    }
}

impl Flight {
    /// Waits for one answer; `None` after the final one. Other threads get a word in between.
    fn next(&self, patience: Duration) -> Result<Option<Best>, PlannerError> {
        let end = Instant::now() + patience;
        loop {
            if self.cancelled.load(Ordering::Acquire) {
                let message = "the request was cancelled".to_owned();
                return Err(PlannerError::Invalid {
                    code: Code::Preempted,
                    message,
                });
            }
            let mut answers = self
                .answers
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            if self.finish.swap(false, Ordering::AcqRel) {
                answers.finish_early();
            }
            let left = end.saturating_duration_since(Instant::now());
            match answers.next(left.min(NOTICE)) {
                Err(PlannerError::Client(ClientError::Timeout(_))) if left > NOTICE => (),
                outcome => return outcome,
            }
        }
    }
}

/// Sends a path.
///
/// # Safety
/// Pointers lead where the header says.
unsafe fn ask(
    planner: &Planner,
    request: &Request,
    path: *const f64,
    waypoints: usize,
    columns: usize,
) -> Result<taut_ipc::planner::Answers, PlannerError> {
    let robot = planner.robot(&request.robot)?;
    let width = request.columns_of(&robot)?.width();
    if columns != width {
        let names: Vec<&str> = robot
            .variables
            .iter()
            .map(|variable| variable.name.as_str())
            .collect();
        let message = format!(
            "a path of {columns} columns; {width} are expected; the robot's variables are {}: name other columns in the options",
            names.join(", ")
        );
        return Err(PlannerError::Invalid {
            code: Code::InvalidRobotState,
            message,
        });
    }
    let count = waypoints.checked_mul(columns);
    let count = count.ok_or_else(|| {
        wrong(format!(
            "{waypoints} waypoints x {columns} columns; no memory holds them"
        ))
    })?;
    // SAFETY: the caller promises so many numbers.
    planner.ask(request, unsafe { array("path", path, count) }?)
}

/// Sends a path to be shortened. `path` is `waypoints` rows of `columns` numbers (rad, m, unit
/// quaternions), which are copied into shared memory once. `scene` may be NULL: nothing around the
/// robot. `options` may be NULL.
///
/// Codes, before anything is sent: TAUT_UNKNOWN_ROBOT, TAUT_UNKNOWN_SCENE, TAUT_INVALID_ROBOT_STATE
/// for columns, TAUT_INVALID_GROUP_NAME, TAUT_QUOTA, TAUT_RESOURCE_EXHAUSTED, TAUT_DAEMON_LOST.
///
/// # Safety
/// Strings are strings, `path` has so many numbers, `options` is NULL or filled in; `answers` and
/// `error` are places for handles, `error` may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_shorten(
    daemon: *const Daemon,
    robot: *const c_char,
    scene: *const c_char,
    path: *const f64,
    waypoints: usize,
    columns: usize,
    options: *const Options,
    answers: *mut *mut Answers,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let place = needed("answers", answers)?;
        let planner = Daemon::get(daemon)?;
        // SAFETY: the caller's promises are the same.
        let sent = unsafe {
            let request = request(text("robot", robot)?, maybe_text("scene", scene)?, options)?;
            ask(&planner, &request, path, waypoints, columns)?
        };
        let flight = Flight {
            answers: Mutex::new(sent),
            cancelled: AtomicBool::new(false),
            finish: AtomicBool::new(false),
            held: Arc::default(),
        };
        // SAFETY: not null, and the caller's own.
        unsafe { place.write(Answers::of(flight)) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Proves a path as it is, and waits for the verdict: TAUT_SUCCESS if it is proved, otherwise the
/// code of what is wrong with it, with what is not kept and where in the error. The options' mode is not
/// looked at. `info` may be NULL; `size` is sizeof *info.
///
/// # Safety
/// As `taut_shorten`; `info` is NULL or `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_check(
    daemon: *const Daemon,
    robot: *const c_char,
    scene: *const c_char,
    path: *const f64,
    waypoints: usize,
    columns: usize,
    options: *const Options,
    info: *mut Info,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let planner = Daemon::get(daemon)?;
        // SAFETY: the caller's promises are the same.
        let sent = unsafe {
            let request = request(text("robot", robot)?, maybe_text("scene", scene)?, options)?;
            let request = Request {
                mode: Mode::Check,
                watch: false,
                ..request
            };
            ask(&planner, &request, path, waypoints, columns)?
        };
        let best = sent.result(duration("the wait", f64::INFINITY)?)?;
        // SAFETY: the caller promises that it is NULL or its own, and so large.
        unsafe { give_sized(info, size, info_of(&best)) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// The next answer: each is shorter than the one before and proved, the last is final. Waits at
/// most `timeout_s` seconds (infinity is allowed).
///
/// Codes: TAUT_SUCCESS with `*answer`; TAUT_PENDING if nothing came in time (call again); TAUT_END
/// after the final one; what the daemon says against the path, with what is not kept and where;
/// TAUT_PREEMPTED after `taut_cancel`; TAUT_DAEMON_LOST within 100 ms of the daemon's death;
/// TAUT_QUOTA if two answers of this request are not freed.
///
/// # Safety
/// `answer` is a place for a handle, `error` too or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_next(
    answers: *const Answers,
    timeout_s: f64,
    answer: *mut *mut Answer,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, || receive(answers, timeout_s, answer, false)) }
}

/// The final answer; those before it are skipped. Codes as `taut_next`, the timeout is for all of
/// it.
///
/// # Safety
/// As `taut_next`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_result(
    answers: *const Answers,
    timeout_s: f64,
    answer: *mut *mut Answer,
    error: *mut *mut Error,
) -> i32 {
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, || receive(answers, timeout_s, answer, true)) }
}

/// # Safety
/// `answer` is NULL or the caller's.
unsafe fn receive(
    answers: *const Answers,
    timeout_s: f64,
    answer: *mut *mut Answer,
    only_final: bool,
) -> Result<i32, PlannerError> {
    let place = needed("answer", answer)?;
    // SAFETY: not null, and the caller's own.
    unsafe { give(place, std::ptr::null_mut()) };
    let flight = Answers::get(answers)?;
    let patience = duration("timeout_s", timeout_s)?;
    let end = Instant::now() + patience;
    if flight.held.load(Ordering::Acquire) >= HELD {
        let message = format!(
            "{HELD} answers of this request are not freed; free one (taut_answer_free), or keep a copy (taut_answer_copy)"
        );
        return Err(PlannerError::Invalid {
            code: Code::Quota,
            message,
        });
    }
    loop {
        let best = match flight.next(end.saturating_duration_since(Instant::now())) {
            Ok(Some(best)) => best.check()?,
            Ok(None) => return Ok(TAUT_END),
            Err(PlannerError::Client(ClientError::Timeout(_))) => return Ok(TAUT_PENDING),
            Err(error) => return Err(error),
        };
        if best.is_final() || !only_final {
            let handle = Answer::of(Held::new(best, &flight.held));
            // SAFETY: not null, and the caller's own.
            unsafe { give(place, handle) };
            return Ok(TAUT_SUCCESS);
        }
    }
}

/// Asks for the best so far, now: the final answer comes soon. May come from any thread.
///
/// # Safety
/// `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_finish_early(answers: *const Answers, error: *mut *mut Error) -> i32 {
    let work = || {
        let flight = Answers::get(answers)?;
        flight.finish.store(true, Ordering::Release);
        // Where another thread waits, it sees the flag.
        if let Ok(answers) = flight.answers.try_lock()
            && flight.finish.swap(false, Ordering::AcqRel)
        {
            answers.finish_early();
        }
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Cancels a request: a thread that waits for it gets TAUT_PREEMPTED within 10 ms. It stays to be
/// freed. May come from any thread.
///
/// # Safety
/// `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_cancel(answers: *const Answers, error: *mut *mut Error) -> i32 {
    let work = || {
        Answers::get(answers)?
            .cancelled
            .store(true, Ordering::Release);
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Frees a request, which cancels it if it runs; a thread that waits for it gets TAUT_PREEMPTED.
/// Answers that it gave stay. NULL and requests that are freed are let be.
#[unsafe(no_mangle)]
pub extern "C" fn taut_answers_free(answers: *mut Answers) {
    if let Some(flight) = Answers::end(answers) {
        flight.cancelled.store(true, Ordering::Release);
    }
}
