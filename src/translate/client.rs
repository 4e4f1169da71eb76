//! The client's side: from a response back to an outcome.

use crate::files::result::{ResultCoordinate, ResultCorridor};
use crate::optimize::{Outcome, Settings, Termination};
use crate::path::Path;
use crate::validation::{Corridor, LoweredFloor};
use taut_ipc::control::{RobotDescription, VariableDescription};
use taut_ipc::planner::Request;
use taut_ipc::wire::{self, Code, ResponseView, WireError};

use super::error::AnswerError;
use super::{number, sections};

/// The outcome that a final response to a request about a path of `robot` tells of.
///
/// # Errors
/// A refusal, or a response that contradicts itself.
pub fn outcome(
    view: &ResponseView,
    request: &Request,
    robot: &RobotDescription,
) -> Result<(Outcome, Code), AnswerError> {
    let header = &view.header;
    let path = Path::from_rows((header.variables as usize).max(1), view.path.to_vec());
    let path = path.ok_or_else(|| refusal(view))?;
    let lowered = lowered(view)?;
    let turned = sections::turned(view, robot)?;
    let certificate = sections::certificate(view, request, robot, &path, &lowered)?;
    let corridor = certificate
        .as_ref()
        .and_then(|certificate| sections::corridor(view, certificate));
    let outcome = Outcome {
        path,
        proved: view.is_proved(),
        uncheckable: sections::uncheckable(view)?,
        pairs: header.pairs as usize,
        refusal: sections::refusal(view, view.message.to_owned())?,
        length_before: header.length_before,
        length_after: header.length_after,
        lower_bound: header.lower_bound,
        weights: weights(request, robot)?,
        clearance_m: request
            .clearance_m
            .unwrap_or(Settings::DEFAULT_CLEARANCE_M),
        floor_m: header.floor_m,
        floors_lowered: lowered,
        turned,
        pinched: sections::pinched(view)?,
        nearest: sections::nearest(view)?,
        keeps: sections::keeps(view)?,
        iterations: header.iterations,
        work: header.work,
        stage: number::stage(view.stage),
        stages: sections::stages(view)?,
        termination: termination(view.termination),
        warnings: sections::warnings(view)?,
        corridor,
        certificate,
    };
    Ok((outcome, view.code))
}

/// A response without a path.
fn refusal(view: &ResponseView) -> AnswerError {
    AnswerError::Refused {
        code: view.code,
        message: view.message.to_owned(),
        retry_after_ms: view.header.retry_after_ms,
    }
}

fn lowered(view: &ResponseView) -> Result<Vec<LoweredFloor>, WireError> {
    let floors = view.lowered_floors.iter();
    floors
        .map(|floor| sections::lowered(floor, view))
        .collect()
}

/// Weights of the request's metric.
fn weights(request: &Request, robot: &RobotDescription) -> Result<Vec<f64>, AnswerError> {
    let weights = request.weights(robot)?;
    Ok(if weights.is_empty() {
        robot.weights.clone()
    } else {
        weights
    })
}

/// A corridor as result files have it, with the velocity coordinates of a robot.
pub fn result_corridor(
    corridor: &Corridor,
    robot: &RobotDescription,
    unwrapped: bool,
) -> ResultCorridor {
    let coordinates = coordinates(robot, unwrapped).into_iter();
    ResultCorridor {
        floor_m: corridor.floor_m,
        coordinates: coordinates
            .zip(&corridor.reach)
            .map(|((variable, kind), reach_m)| ResultCoordinate {
                variable,
                kind: kind.to_owned(),
                reach_m: *reach_m,
            })
            .collect(),
        slack_m: corridor.slack_m.clone(),
    }
}

/// The velocity coordinates of a robot, each with its variable and what it is: `line`, `circle`, or
/// one of the three of a `rotation`, which are the first three variables of the quaternion.
fn coordinates(robot: &RobotDescription, unwrapped: bool) -> Vec<(String, &'static str)> {
    let mut coordinates = Vec::new();
    for variable in &robot.variables {
        // The fourth variable of a quaternion has none of its own.
        if coordinates.len() < (variable.coordinate + variable.coordinates) as usize {
            coordinates.push((variable.name.clone(), kind(variable, unwrapped)));
        }
    }
    coordinates
}

fn kind(variable: &VariableDescription, unwrapped: bool) -> &'static str {
    match variable.coordinates {
        3 => "rotation",
        _ if variable.continuous && !unwrapped => "circle",
        _ => "line",
    }
}

fn termination(termination: wire::Termination) -> Termination {
    use wire::Termination as Wire;
    match termination {
        Wire::Checked | Wire::Refused => Termination::Done,
        Wire::Converged => Termination::Converged,
        Wire::WorkBudget => Termination::WorkBudget,
        Wire::IterationLimit => Termination::IterationLimit,
        Wire::Running | Wire::Deadline | Wire::Cancelled | Wire::FinishedEarly => {
            Termination::Stopped
        }
    }
}
