//! Trajectories of answers.

use crate::error::plain;
use std::ffi::{CString, c_char};
use std::ptr::null;
use taut_ipc::planner;
use taut_ipc::wire::{Controller, TimingStage};

/// `taut_trajectory.controller`: cubics that have the positions and velocities of both points.
pub const TAUT_CONTROLLER_CUBIC: u32 = 0;
/// `taut_trajectory.controller`: quintics that have their accelerations too.
pub const TAUT_CONTROLLER_QUINTIC: u32 = 1;
/// `taut_trajectory.controller`: straight ways, `rate_hz` points per second.
pub const TAUT_CONTROLLER_LINEAR: u32 = 2;

/// `taut_trajectory.stage`: it stops at every waypoint.
pub const TAUT_TIMING_STOPS: u32 = 0;
/// `taut_trajectory.stage`: it rounds corners.
pub const TAUT_TIMING_ROUNDED: u32 = 1;
/// `taut_trajectory.stage`: parts of it are shortcuts in time.
pub const TAUT_TIMING_SHORTCUTS: u32 = 2;

/// When what is to be where: proved as it is written, at every instant. Tables have a row for each point,
/// in the request's columns; what it points to is valid until the answer is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Trajectory {
    /// When each point is passed, in nanoseconds from the start, where the first one is.
    pub times_ns: *const i64,
    /// How many.
    pub points: usize,
    /// Numbers of a row.
    pub columns: usize,
    /// Positions (rad or m).
    pub positions: *const f64,
    /// Velocities (per s); NULL where the controller goes straight.
    pub velocities: *const f64,
    /// Accelerations (per s^2); NULL where a controller that had them would go another way.
    pub accelerations: *const f64,
    /// For each column the least and greatest velocity, the least and greatest acceleration it was allowed.
    pub limits: *const f64,
    /// For each column the largest part of a limit of velocity that is used and when (s), the same of
    /// acceleration.
    pub used: *const f64,
    /// From the first point to the last, in seconds.
    pub duration_s: f64,
    /// No trajectory between the same ends within the same limits takes less, in seconds.
    pub bound_s: f64,
    /// What the first trajectory that was proved takes, which stops where it must, in seconds.
    pub stops_s: f64,
    /// Clearance that is proved at every instant, in metres; infinite where nothing is near.
    pub clearance_m: f64,
    /// Points per second of TAUT_CONTROLLER_LINEAR; else 0.
    pub rate_hz: f64,
    /// What goes from point to point, TAUT_CONTROLLER_*.
    pub controller: u32,
    /// What it comes of, TAUT_TIMING_*.
    pub stage: u32,
    /// Work that it took.
    pub work: u64,
    /// The column whose motor needs the time of the bound; `columns` where it is none of the request's.
    pub decides: usize,
    /// Where it comes nearest to anything: the two bodies; NULL where nothing was found or looked for.
    pub nearest_names: [*const c_char; 2],
    /// When, in seconds.
    pub nearest_time_s: f64,
    /// Their distance, in metres.
    pub nearest_m: f64,
    /// The closest points, in the world, in metres.
    pub nearest_points: [[f64; 3]; 2],
}

/// A trajectory that stays where it is until its answer is freed.
pub(crate) struct Kept {
    trajectory: planner::Trajectory,
    limits: Vec<f64>,
    used: Vec<f64>,
    names: Vec<CString>,
}

impl Kept {
    pub(crate) fn new(trajectory: planner::Trajectory) -> Self {
        let used = trajectory.used.iter().flat_map(|used| {
            [
                used.velocity,
                used.velocity_time_s,
                used.acceleration,
                used.acceleration_time_s,
            ]
        });
        let names = trajectory.nearest.iter();
        Self {
            limits: trajectory.limits.concat(),
            used: used.collect(),
            names: names
                .flat_map(|nearest| &nearest.names)
                .map(|name| plain(name))
                .collect(),
            trajectory,
        }
    }

    pub(crate) fn shown(&self) -> Trajectory {
        let found = &self.trajectory;
        let nearest = found.nearest.as_ref();
        let name = |index: usize| {
            self.names
                .get(index)
                .map_or(null(), |name| name.as_ptr())
        };
        Trajectory {
            times_ns: found.times_ns.as_ptr(),
            points: found.points(),
            columns: found.columns,
            positions: found.positions.as_ptr(),
            velocities: table(&found.velocities),
            accelerations: table(&found.accelerations),
            limits: self.limits.as_ptr(),
            used: self.used.as_ptr(),
            duration_s: found.duration_s(),
            bound_s: found.bound_s,
            stops_s: found.stops_s,
            clearance_m: found.clearance_m,
            rate_hz: found.rate_hz,
            controller: controller(found.controller),
            stage: stage(found.stage),
            work: found.work,
            decides: found.decides.unwrap_or(found.columns),
            nearest_names: [name(0), name(1)],
            nearest_time_s: nearest.map_or(0.0, |nearest| nearest.time_s),
            nearest_m: nearest.map_or(0.0, |nearest| nearest.distance_m),
            nearest_points: nearest.map_or([[0.0; 3]; 2], |nearest| nearest.points),
        }
    }
}

fn controller(controller: Controller) -> u32 {
    match controller {
        Controller::Cubic => TAUT_CONTROLLER_CUBIC,
        Controller::Quintic => TAUT_CONTROLLER_QUINTIC,
        Controller::Linear => TAUT_CONTROLLER_LINEAR,
    }
}

fn stage(stage: TimingStage) -> u32 {
    match stage {
        TimingStage::Stops => TAUT_TIMING_STOPS,
        TimingStage::Rounded => TAUT_TIMING_ROUNDED,
        TimingStage::Shortcuts => TAUT_TIMING_SHORTCUTS,
    }
}

fn table(numbers: &[f64]) -> *const f64 {
    match numbers.is_empty() {
        true => null(),
        false => numbers.as_ptr(),
    }
}
