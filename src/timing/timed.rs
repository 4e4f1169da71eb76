//! What comes of a path: points with times, and what is known of them.

use super::bound::Bound;
use super::controller::{Controller, TimedPoint};
use super::limits::Usage;
use super::trajectory::NS;
use crate::robot::RobotModel;
use crate::validation::timed::{Curve, CurveError, Point, TimedProof};

/// What a trajectory comes of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It stops at every waypoint.
    Stops,
    /// It rounds corners.
    Rounded,
    /// Parts of it are shortcuts in time.
    Shortcuts,
}

impl Stage {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stops => "stops",
            Self::Rounded => "rounded",
            Self::Shortcuts => "shortcuts",
        }
    }
}

/// A trajectory with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// As they are written; of what stands still one.
    pub points: Vec<TimedPoint>,
    /// Who makes a curve of them.
    pub controller: Controller,
    /// That this curve keeps every requirement at every instant; `None` of one that stands still.
    pub proof: Option<TimedProof>,
    /// What it comes of.
    pub stage: Stage,
    /// The largest part of each limit that each column uses, and when.
    pub usage: Vec<Usage>,
    /// The least time that the motors need.
    pub bound: Bound,
}

impl Timed {
    /// From the first point to the last (ns).
    pub fn duration_ns(&self) -> i64 {
        let ends = self.points.first().zip(self.points.last());
        ends.map_or(0, |(first, last)| last.time_ns - first.time_ns)
    }

    /// The same in seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_ns() as f64 / NS
    }

    /// By what part of the least time there can be it takes longer; 0 where it stands still.
    pub fn gap(&self) -> f64 {
        match self.bound.time_s > 0.0 {
            true => self.duration_s() / self.bound.time_s - 1.0,
            false => 0.0,
        }
    }

    /// The largest part of each limit that any column uses.
    pub fn most_used(&self) -> Usage {
        let columns = self.usage.iter().copied();
        columns.fold(Usage::default(), Usage::most)
    }

    /// What the controller makes of the points.
    ///
    /// # Errors
    /// Of what stands still: one point is no curve.
    pub fn curve(&self, robot: &RobotModel) -> Result<Curve, CurveError> {
        let points: Vec<Point> = self
            .points
            .iter()
            .map(TimedPoint::point)
            .collect();
        Curve::new(robot, &points)
    }
}

/// What came of a path.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The fastest trajectory that was found.
    Timed(Timed),
    /// `stop` said so before there was any.
    Stopped,
}
