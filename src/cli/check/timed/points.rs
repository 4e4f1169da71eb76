//! The points of a trajectory, each with its time.

use std::path::Path;

use taut::files::{FileError, Trajectory, TrajectoryPoint};
use taut::validation::timed::Point;

/// The point as the core takes it; `None` where it has no time.
fn point(point: TrajectoryPoint) -> Option<Point> {
    let TrajectoryPoint {
        positions,
        velocities,
        accelerations,
        time_s,
    } = point;
    Some(Point {
        time_s: time_s?,
        positions,
        velocities,
        accelerations,
    })
}

/// The points of a trajectory, each with its time.
///
/// # Errors
/// A point without a time, or columns that the robot does not have.
pub(in crate::cli::check) fn timed_points(
    trajectory: &Trajectory,
    points: Vec<TrajectoryPoint>,
) -> Result<Vec<Point>, FileError> {
    let all: Option<Vec<Point>> = points.into_iter().map(point).collect();
    all.ok_or_else(|| without_time(&trajectory.file))
}

fn without_time(file: &Path) -> FileError {
    let text = "a point has no time_from_start; without times it is a path: leave out --timed";
    FileError::content(file, text.to_owned())
}
