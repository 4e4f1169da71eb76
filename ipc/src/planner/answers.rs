//! The stream of answers to a request.

use super::{Columns, Planner, PlannerError, Refused, Request};
use crate::client::{ClientError, Pending, Response};
use crate::control::RobotDescription;
use crate::wire::Code;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Answers to a request, each a shorter proved path than the one before; the last is final. Dropping it cancels the
/// request.
#[derive(Debug)]
pub struct Answers {
    planner: Planner,
    request: Request,
    robot: Arc<RobotDescription>,
    columns: Arc<Columns>,
    pending: Pending,
    /// When it was sent.
    start: Instant,
    asked_again: bool,
}

impl Answers {
    pub(super) fn ask(planner: &Planner, request: &Request, path: &[f64]) -> Result<Self, PlannerError> {
        let robot = planner.robot(&request.robot)?;
        let columns = request.columns_of(&robot)?;
        let waypoints = request.waypoints(&columns, path.len())?;
        let start = Instant::now();
        let pending = send(planner, request, &robot, &columns, waypoints, path)?;
        let (planner, request, columns) = (planner.clone(), request.clone(), Arc::new(columns));
        Ok(Self { planner, request, robot, columns, pending, start, asked_again: false })
    }

    /// The id under which the daemon tells of the request.
    pub fn request_id(&self) -> u64 {
        self.pending.request_id()
    }

    /// The robot as the request knows it.
    pub fn robot(&self) -> &RobotDescription {
        &self.robot
    }

    /// What was asked for.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The next answer, in place in shared memory; `None` after the final one. A final one that is no success is an
    /// answer too: [`Best::check`] makes an error of it.
    ///
    /// At most two answers can be held at once.
    ///
    /// # Errors
    /// [`ClientError::Timeout`] if nothing came within `timeout` (call again); [`ClientError::DaemonLost`].
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Best>, PlannerError> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Some(response) = self.pending.next(left).map_err(|error| of_whole(error, timeout))? else {
                return Ok(None);
            };
            if !self.is_of_another_layout(&response)? {
                return Ok(Some(Best { response, columns: self.columns.clone() }));
            }
        }
    }

    /// The final answer; improvements before it are skipped.
    ///
    /// # Errors
    /// As [`Self::next`]; the timeout is for all of it. [`PlannerError::Refused`] where it is no success.
    pub fn result(mut self, timeout: Duration) -> Result<Best, PlannerError> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.next(left).map_err(|error| whole(error, timeout))? {
                Some(best) if best.is_final() => return best.check(),
                Some(_) => (),
                None => return Err(ClientError::NoAnswer.into()),
            }
        }
    }

    /// Asks for the best so far, now.
    pub fn finish_early(&self) {
        self.pending.finish_early();
    }

    /// Whether the robot's label names another robot by now, whose variables are others; the request is then sent
    /// again, once, with its columns in their order.
    fn is_of_another_layout(&mut self, response: &Response) -> Result<bool, PlannerError> {
        let may_be = response.is_final() && response.code() == Code::InvalidRobotState && response.path().is_empty();
        if !may_be || self.asked_again {
            return Ok(false);
        }
        self.asked_again = true;
        let robot = self.planner.describe(&self.request.robot)?;
        if robot.layout_hash == self.robot.layout_hash {
            return Ok(false);
        }
        let columns = self.request.columns_of(&robot)?;
        if columns.width() != self.columns.width() {
            // The caller named no columns and means others than the robot has now.
            return Ok(false);
        }
        let mut path = Vec::new();
        self.pending.sent_path(|sent| {
            path.resize(sent.len() / self.columns.robot_width() * self.columns.width(), 0.0);
            self.columns.read(sent, &mut path);
        });
        let waypoints = self.request.waypoints(&columns, path.len())?;
        let mut request = self.request.clone();
        request.deadline = request.deadline.map(|deadline| deadline.saturating_sub(self.start.elapsed()));
        self.pending = send(&self.planner, &request, &robot, &columns, waypoints, &path)?;
        (self.robot, self.columns) = (robot, Arc::new(columns));
        Ok(true)
    }
}

fn send(
    planner: &Planner,
    request: &Request,
    robot: &RobotDescription,
    columns: &Columns,
    waypoints: u32,
    path: &[f64],
) -> Result<Pending, PlannerError> {
    let scene = match &request.scene {
        Some(scene) => scene,
        None => planner.empty_scene()?,
    };
    let sections = request.sections(robot, columns, waypoints)?;
    let mut builder = planner.client().request(waypoints, robot.nq);
    let header = request.header(robot, scene)?;
    builder.header = crate::wire::RequestHeader {
        waypoints: builder.header.waypoints,
        variables: builder.header.variables,
        group: builder.header.group,
        ..header
    };
    let mut loan = sections.of(builder).loan()?;
    columns.write(path, loan.path_mut());
    Ok(loan.send()?)
}

fn of_whole(error: ClientError, timeout: Duration) -> ClientError {
    if matches!(error, ClientError::Timeout(_)) { ClientError::Timeout(timeout) } else { error }
}

fn whole(error: PlannerError, timeout: Duration) -> PlannerError {
    match error {
        PlannerError::Client(error) => of_whole(error, timeout).into(),
        error => error,
    }
}

/// An answer in shared memory; its memory goes back when it is dropped.
#[derive(Debug)]
pub struct Best {
    response: Response,
    columns: Arc<Columns>,
}

impl Best {
    /// Rows of the path; 0 where there is none.
    pub fn waypoints(&self) -> usize {
        self.response.path().len() / self.columns.robot_width().max(1)
    }

    /// How the caller's columns lie in [`Response::path`].
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The path in the caller's columns, row by row, as a copy.
    pub fn to_rows(&self) -> Vec<f64> {
        let mut rows = vec![0.0; self.waypoints() * self.columns.width()];
        self.columns.read(self.response.path(), &mut rows);
        rows
    }

    /// Itself if it is a success or an improvement.
    ///
    /// # Errors
    /// [`PlannerError::Refused`] otherwise, with bodies and place where the path is what is wrong.
    pub fn check(self) -> Result<Self, PlannerError> {
        match self.refused()? {
            None => Ok(self),
            Some(refused) => Err(PlannerError::Refused(Box::new(refused))),
        }
    }

    /// What it says against the path or the request, if it is no success.
    ///
    /// # Errors
    /// [`PlannerError::Client`] only if the daemon changed it after sending.
    pub fn refused(&self) -> Result<Option<Refused>, PlannerError> {
        if self.response.code() == Code::Success {
            return Ok(None);
        }
        Ok(Some(Refused::of_response(&self.response)?))
    }
}

impl std::ops::Deref for Best {
    type Target = Response;

    fn deref(&self) -> &Response {
        &self.response
    }
}

