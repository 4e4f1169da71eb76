//! What is sent, as the optimizer in this process takes it.

use std::path::Path as File;
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::files::{self, Geometry, Reader};
use taut::path::Path;
use taut::robot::{ConfigurationSpace, RobotModel};

use crate::error::Error;

/// A problem of a file.
pub(super) struct Problem {
    /// Robot and scene.
    pub model: CollisionModel,
    /// The path that is sent.
    pub path: Path,
    /// Weights of the metric.
    pub weights: Option<Vec<f64>>,
}

impl Problem {
    /// Reads it, and cuts its path's segments into equal parts until it has so many waypoints.
    pub(super) fn read(reader: &mut Reader, file: &File, waypoints: usize) -> Result<Self, Error> {
        let problem = reader.problem(file, Geometry::Given)?;
        if !problem.constraints.is_empty() {
            let text = "has path_constraints, which this load does not send; take one without";
            return Err(Error::Usage(format!("{} {text}", file.display())));
        }
        let robot = problem.model()?;
        Ok(Self {
            path: subdivided(robot.space(), &problem.path, waypoints),
            weights: problem.weights.clone(),
            model: model(robot, problem)?,
        })
    }
}

fn model(robot: RobotModel, problem: files::Problem) -> Result<CollisionModel, Error> {
    let scene = Arc::new(problem.scene);
    CollisionModel::new(Arc::new(robot), scene).map_err(|source| Error::Model {
        name: problem.name,
        source: Box::new(source),
    })
}

/// The same motion with at least so many waypoints.
fn subdivided(space: &ConfigurationSpace, path: &Path, waypoints: usize) -> Path {
    let segments = path.len().saturating_sub(1);
    let parts = waypoints
        .saturating_sub(1)
        .div_ceil(segments.max(1))
        .max(1);
    let mut rows = path.waypoint(0).to_vec();
    for [from, to] in path.segments() {
        for part in 1..parts {
            rows.extend(space.between(from, to, part as f64 / parts as f64));
        }
        rows.extend_from_slice(to);
    }
    Path::from_rows(path.nq(), rows).expect("whole rows were added to a whole row")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_cut_into_parts_keeps_its_waypoints() {
        let file = File::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../config/problems/rooms.json"
        ));
        let read = |waypoints| {
            Problem::read(&mut Reader::default(), file, waypoints)
                .unwrap()
                .path
        };
        let given = read(0);
        let cut = read(100);
        assert!(given.len() < 100 && cut.len() >= 100 && cut.len() < 100 + given.len());
        let parts = (cut.len() - 1) / (given.len() - 1);
        for (index, waypoint) in given.waypoints().enumerate() {
            assert_eq!(cut.waypoint(index * parts), waypoint);
        }
    }
}
