//! Single answers, in shared memory.

use crate::borrow::{give, give_sized, needed};
use crate::code::TAUT_SUCCESS;
use crate::error::{Error, plain, run};
use crate::handle::{Handle, Table, wrong};
use crate::trajectory::{self, Trajectory};
use std::ffi::{CString, c_char};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use taut_ipc::planner::{self, Best, PlannerError};
use taut_ipc::wire::{Code, ResponseFlags};

/// One answer, in shared memory. Freed by `taut_answer_free`; it outlives its request and its
/// connection.
pub struct Answer {
    _opaque: [u8; 0],
}

/// An answer that counts as held until it is freed.
pub(crate) struct Held {
    // Threads may look at it in turns only.
    best: Mutex<Best>,
    /// Made when first asked for; texts stay where they are until the answer is freed.
    warnings: OnceLock<Vec<(CString, bool)>>,
    /// The same of its corridor, where it has one.
    corridor: OnceLock<Option<planner::Corridor>>,
    /// The same of what it keeps, each with its name.
    keeps: OnceLock<Vec<(CString, planner::Kept)>>,
    /// The same of its trajectory, where it has one.
    trajectory: OnceLock<trajectory::Kept>,
    count: Arc<AtomicUsize>,
}

impl Held {
    pub(crate) fn new(best: Best, count: &Arc<AtomicUsize>) -> Self {
        count.fetch_add(1, Ordering::AcqRel);
        Self {
            best: Mutex::new(best),
            warnings: OnceLock::new(),
            corridor: OnceLock::new(),
            keeps: OnceLock::new(),
            trajectory: OnceLock::new(),
            count: count.clone(),
        }
    }

    fn best(&self) -> MutexGuard<'_, Best> {
        self.best
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn corridor(&self) -> Option<&planner::Corridor> {
        self.corridor
            .get_or_init(|| self.best().corridor().unwrap_or_default())
            .as_ref()
    }

    fn keeps(&self) -> &[(CString, planner::Kept)] {
        self.keeps.get_or_init(|| {
            let keeps = self.best().keeps().unwrap_or_default();
            keeps
                .into_iter()
                .map(|kept| (plain(&kept.name), kept))
                .collect()
        })
    }

    /// Its trajectory.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn trajectory(&self) -> Result<&trajectory::Kept, PlannerError> {
        if let Some(known) = self.trajectory.get() {
            return Ok(known);
        }
        let found = self.best().timed()?;
        Ok(self
            .trajectory
            .get_or_init(|| trajectory::Kept::new(found)))
    }

    fn warnings(&self) -> &[(CString, bool)] {
        self.warnings.get_or_init(|| {
            let told = self.best().warnings().unwrap_or_default();
            told.iter()
                .map(|warning| (plain(&warning.text), warning.is_uncovered))
                .collect()
        })
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.count.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Handle for Answer {
    type Value = Held;
    const NAME: &'static str = "taut_answer";

    fn table() -> &'static Table<Held> {
        static ANSWERS: Table<Held> = Table::new();
        &ANSWERS
    }
}

/// Figures of an answer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Info {
    /// Length of the path that was sent, in the request's metric.
    pub length_before: f64,
    /// Length of this path.
    pub length_after: f64,
    /// No path between the same ends is shorter.
    pub lower_bound: f64,
    /// The distance that is proved for every pair without a floor of its own, in metres.
    pub clearance_m: f64,
    /// The lowest floor of any clearance, in metres.
    pub floor_m: f64,
    /// Version of the scene that it is proved against; 0 where none is kept.
    pub scene_version: u64,
    /// Hash of that scene's content.
    pub scene_hash: u64,
    /// Hash of the robot's content.
    pub robot_hash: u64,
    /// Iterations of the method.
    pub iterations: u64,
    /// Counted work.
    pub work: u64,
    /// Time that the request waited, in nanoseconds.
    pub queue_ns: u64,
    /// Time that it was worked on, in nanoseconds.
    pub compute_ns: u64,
    /// Waypoints.
    pub waypoints: usize,
    /// Columns, as many as the request had.
    pub columns: usize,
    /// Counts the answers of a request from 0; a gap means that newer ones took the place of some.
    pub sequence: u32,
    /// Whether the path is proved.
    pub proved: bool,
    /// Whether it is the last.
    pub is_final: bool,
    /// Whether the scene has a newer version by now.
    pub superseded: bool,
    /// Pairs of bodies that were checked; 0 of a final answer: there is nothing to check.
    pub pairs: u64,
    /// Age of the oldest frame among those that the scene is seen by, when the answer was sent, in
    /// nanoseconds; 0 = no sensor sees it.
    pub world_age_ns: u64,
}

/// What a person should know beside a verdict.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Warning {
    /// One line; valid until the answer is freed.
    pub text: *const c_char,
    /// Whether it says what the verdict does not cover, or rests on; else it takes nothing from the
    /// verdict.
    pub uncovered: bool,
}

/// What a proved path keeps of one constraint, of its tolerance as it is asked.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Kept {
    /// What messages call it; valid until the answer is freed.
    pub name: *const c_char,
    /// What kind of thing it is, TAUT_KIND_*; newer versions have more kinds.
    pub kind: u32,
    /// What the numbers are counted in, TAUT_UNIT_*.
    pub unit: u32,
    /// The tolerance, where one number says it: then what is read of the path, such as an angle, is
    /// proved to be asked - left at most. Else 0.
    pub asked: f64,
    /// What is proved to be left everywhere along the path; below 0 where the tolerance is raised and
    /// that is needed.
    pub left: f64,
    /// The least that was found to be left: a look, no proof.
    pub found: f64,
    /// Where on the segment that was found, 0 to 1.
    pub t: f64,
    /// The segment, from 0.
    pub segment: u32,
    /// 0; keeps what follows aligned.
    pub reserved: u32,
}

/// A path in shared memory: number `column` of waypoint `i` is `first[i * stride + column]`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Rows {
    /// The first number.
    pub first: *const f64,
    /// How many rows.
    pub waypoints: usize,
    /// Numbers of a row, in the order of the request's columns.
    pub columns: usize,
    /// Numbers from one row to the next.
    pub stride: usize,
}

/// How far what is executed may stray from a proved path: around every configuration p of a
/// segment, every q with the sum of reach x |q - p| at most the segment's slack keeps the floor.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Corridor {
    /// Distance that every pair keeps within the corridor, in metres.
    pub floor_m: f64,
    /// How far bodies move at most against each other, per unit of each velocity coordinate of the
    /// robot (m per rad or m); valid until the answer is freed.
    pub reach: *const f64,
    /// How many.
    pub reach_count: usize,
    /// Slack of each segment, in metres; valid until the answer is freed.
    pub slack_m: *const f64,
    /// How many.
    pub slack_count: usize,
}

pub(crate) fn info_of(best: &Best) -> Info {
    let header = best.header();
    let is_set = |flag| header.flags & flag != 0;
    Info {
        length_before: header.length_before,
        length_after: header.length_after,
        lower_bound: header.lower_bound,
        clearance_m: header.clearance_m,
        floor_m: header.floor_m,
        scene_version: header.scene_version,
        scene_hash: header.scene_hash,
        robot_hash: header.robot_hash,
        iterations: header.iterations,
        work: header.work,
        queue_ns: header.queue_ns,
        compute_ns: header.compute_ns,
        waypoints: best.waypoints(),
        columns: best.columns().width(),
        sequence: header.seq,
        proved: is_set(ResponseFlags::PROVED),
        is_final: best.is_final(),
        superseded: is_set(ResponseFlags::SUPERSEDED),
        pairs: header.pairs,
        world_age_ns: header.world_age_ns,
    }
}

/// Figures of an answer. `size` is sizeof *info.
///
/// # Safety
/// `info` points to `size` bytes; `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_info(
    answer: *const Answer,
    info: *mut Info,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let held = Answer::get(answer)?;
        // SAFETY: the caller promises that it is its own, and so large.
        unsafe { give_sized(needed("info", info)?, size, info_of(&held.best())) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Shows an answer's path where it lies, in shared memory: read-only, valid until the answer is
/// freed. `size` is sizeof *rows.
///
/// TAUT_INVALID_ROBOT_STATE if the request's columns are not a stretch of the robot's variables in
/// its order: then `taut_answer_copy` puts them in the request's order.
///
/// # Safety
/// `rows` points to `size` bytes; `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_rows(
    answer: *const Answer,
    rows: *mut Rows,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let held = Answer::get(answer)?;
        let best = held.best();
        let columns = best.columns();
        let path = best.path();
        let Some(start) = columns.stretch() else {
            let message =
                "the request's columns are in another order than the robot's; take taut_answer_copy".to_owned();
            return Err(PlannerError::Invalid {
                code: Code::InvalidRobotState,
                message,
            });
        };
        let first = path.get(start..).unwrap_or_default().as_ptr();
        let waypoints = best.waypoints();
        let stride = columns.robot_width();
        let found = Rows {
            first,
            waypoints,
            columns: columns.width(),
            stride,
        };
        // SAFETY: the caller promises that it is its own, and so large.
        unsafe { give_sized(needed("rows", rows)?, size, found) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Copies an answer's path, row by row, in the request's columns, into the `capacity` numbers at
/// `numbers`. It has `waypoints` x `columns` of them (`taut_answer_info`).
///
/// # Safety
/// `numbers` points to `capacity` numbers; `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_copy(
    answer: *const Answer,
    numbers: *mut f64,
    capacity: usize,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let held = Answer::get(answer)?;
        let place = needed("numbers", numbers)?;
        let best = held.best();
        let rows = best.rows();
        if capacity < rows.len() {
            return Err(wrong(format!(
                "room for {capacity} numbers; the path has {}",
                rows.len()
            )));
        }
        // SAFETY: the caller gives room for `capacity` numbers, and there are no more.
        unsafe { std::ptr::copy_nonoverlapping(rows.as_ptr(), place, rows.len()) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// How many warnings come with an answer, first those that say what the verdict does not cover; 0
/// for one that is freed.
#[unsafe(no_mangle)]
pub extern "C" fn taut_answer_warnings(answer: *const Answer) -> usize {
    Answer::get(answer).map_or(0, |held| held.warnings().len())
}

/// One warning of an answer: true and `*warning` filled in, or false for an index beyond the last.
///
/// # Safety
/// `warning` points to a `taut_warning`, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_warning(
    answer: *const Answer,
    index: usize,
    warning: *mut Warning,
) -> bool {
    let Ok(held) = Answer::get(answer) else {
        return false;
    };
    let Some((text, uncovered)) = held.warnings().get(index) else {
        return false;
    };
    // SAFETY: the caller promises that it is NULL or its own.
    unsafe {
        give(
            warning,
            Warning {
                text: text.as_ptr(),
                uncovered: *uncovered,
            },
        )
    };
    true
}

/// Of how many constraints a final answer tells what it keeps: all that the request had, where the
/// path is proved; 0 for one that is freed.
#[unsafe(no_mangle)]
pub extern "C" fn taut_answer_keeps(answer: *const Answer) -> usize {
    Answer::get(answer).map_or(0, |held| held.keeps().len())
}

/// What an answer keeps of one constraint: true and `*kept` filled in, or false for an index beyond the
/// last. `size` is sizeof *kept.
///
/// # Safety
/// `kept` points to `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_kept(
    answer: *const Answer,
    index: usize,
    kept: *mut Kept,
    size: usize,
) -> bool {
    let Ok(held) = Answer::get(answer) else {
        return false;
    };
    let Some((name, found)) = held.keeps().get(index) else {
        return false;
    };
    let shown = Kept {
        name: name.as_ptr(),
        kind: found.kind.into(),
        unit: found.unit.into(),
        asked: found.asked.unwrap_or(0.0),
        left: found.left,
        found: found.found,
        t: found.t,
        segment: found.segment,
        reserved: 0,
    };
    // SAFETY: the caller promises that it is NULL or its own, and so large.
    unsafe { give_sized(kept, size, shown) };
    true
}

/// The corridor of a final answer whose request had `corridor`: true and `*corridor` filled in, or
/// false where there is none. `size` is sizeof *corridor.
///
/// # Safety
/// `corridor` points to `size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_corridor(
    answer: *const Answer,
    corridor: *mut Corridor,
    size: usize,
) -> bool {
    let Ok(held) = Answer::get(answer) else {
        return false;
    };
    let Some(found) = held.corridor() else {
        return false;
    };
    let shown = Corridor {
        floor_m: found.floor_m,
        reach: found.reach.as_ptr(),
        reach_count: found.reach.len(),
        slack_m: found.slack_m.as_ptr(),
        slack_count: found.slack_m.len(),
    };
    // SAFETY: the caller promises that it is NULL or its own, and so large.
    unsafe { give_sized(corridor, size, shown) };
    true
}

/// The trajectory of an answer whose request had `timing`; on the way, the one so far. `size` is
/// sizeof *trajectory.
///
/// TAUT_UNTIMED where there is none, with why: the deadline came first, none is proved, or none was asked
/// for. The path is there all the same.
///
/// # Safety
/// `trajectory` points to `size` bytes; `error` is NULL or a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_answer_trajectory(
    answer: *const Answer,
    trajectory: *mut Trajectory,
    size: usize,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let held = Answer::get(answer)?;
        let place = needed("trajectory", trajectory)?;
        let shown = held.trajectory()?.shown();
        // SAFETY: the caller promises that it is its own, and so large.
        unsafe { give_sized(place, size, shown) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Frees an answer; its memory goes back. NULL and answers that are freed are let be.
#[unsafe(no_mangle)]
pub extern "C" fn taut_answer_free(answer: *mut Answer) {
    drop(Answer::end(answer));
}
