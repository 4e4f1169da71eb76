//! The stream of answers to a request.

use super::connection::Planner;
use super::link::Stream;
use super::prepared::Prepared;
use super::{Best, Columns, PlannerError, Request};
use crate::client_error::ClientError;
use crate::control::RobotDescription;
use crate::wire::Code;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Answers to a request, each a shorter proved path than the one before; the last is final.
/// Dropping it cancels the request.
#[derive(Debug)]
pub struct Answers {
    planner: Planner,
    request: Request,
    robot: Arc<RobotDescription>,
    columns: Arc<Columns>,
    stream: Box<dyn Stream>,
    /// When it was sent.
    start: Instant,
    asked_again: bool,
}

impl Planner {
    /// Sends a path, row by row in the order of [`Request::columns`], and gives the stream of its
    /// answers.
    ///
    /// The numbers are written into shared memory once, whatever their order.
    ///
    /// # Errors
    /// [`PlannerError::Invalid`] for names and sizes that are none, with the valid ones; what
    /// cannot be sent.
    pub fn ask(&self, request: &Request, path: &[f64]) -> Result<Answers, PlannerError> {
        Answers::ask(self, request, path)
    }

    /// A request about a path of so many numbers, ready to be sent.
    pub(super) fn prepared(
        &self,
        request: &Request,
        robot: Arc<RobotDescription>,
        numbers: usize,
    ) -> Result<Prepared, PlannerError> {
        let scene = match &request.scene {
            Some(scene) => scene,
            None => self.empty_scene()?,
        };
        Prepared::new(request, robot, scene, numbers)
    }
}

impl Answers {
    pub(super) fn ask(
        planner: &Planner,
        request: &Request,
        path: &[f64],
    ) -> Result<Self, PlannerError> {
        let start = Instant::now();
        let robot = planner.robot(&request.robot)?;
        let prepared = planner.prepared(request, robot, path.len())?;
        let stream = planner.link.send(&prepared, path)?;
        Ok(Self {
            planner: planner.clone(),
            request: request.clone(),
            robot: prepared.robot,
            columns: prepared.columns,
            stream,
            start,
            asked_again: false,
        })
    }

    /// The id under which the daemon tells of the request.
    pub fn request_id(&self) -> u64 {
        self.stream.request_id()
    }

    /// The robot as the request knows it.
    pub fn robot(&self) -> &RobotDescription {
        &self.robot
    }

    /// What was asked for.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The next answer, in place in shared memory; `None` after the final one. A final one that is
    /// no success is an answer too: [`Best::check`] makes an error of it.
    ///
    /// At most three answers of a request can lie in shared memory at once: keep others by
    /// [`Best::into_own`].
    ///
    /// # Errors
    /// [`ClientError::Timeout`] if nothing came within `timeout` (call again);
    /// [`ClientError::DaemonLost`].
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Best>, PlannerError> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let next = self.stream.next(left, &self.columns);
            let Some(best) = next.map_err(|error| of_whole(error, timeout))? else {
                return Ok(None);
            };
            if !self.is_for_another_layout(&best)? {
                return Ok(Some(best));
            }
        }
    }

    /// The final answer; improvements before it are skipped.
    ///
    /// # Errors
    /// As [`Self::next`]; the timeout is for all of it. [`PlannerError::Refused`] where it is no
    /// success.
    pub fn result(mut self, timeout: Duration) -> Result<Best, PlannerError> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self
                .next(left)
                .map_err(|error| whole(error, timeout))?
            {
                Some(best) if best.is_final() => return best.check(),
                Some(_) => (),
                None => return Err(ClientError::NoAnswer.into()),
            }
        }
    }

    /// Asks for the best so far, now.
    pub fn finish_early(&self) {
        self.stream.finish_early();
    }

    /// Whether the robot's label names another robot by now, whose variables are others; the
    /// request is then sent again, once, with its columns in their order.
    fn is_for_another_layout(&mut self, best: &Best) -> Result<bool, PlannerError> {
        let may_be =
            best.is_final() && best.code() == Code::InvalidRobotState && best.path().is_empty();
        if !may_be || self.asked_again {
            return Ok(false);
        }
        let Some(path) = self.stream.sent(&self.columns) else {
            return Ok(false);
        };
        self.asked_again = true;
        let robot = self.planner.describe(&self.request.robot)?;
        if robot.layout_hash == self.robot.layout_hash {
            return Ok(false);
        }
        if self.request.columns_of(&robot)?.width() != self.columns.width() {
            // The caller named no columns and means others than the robot has now.
            return Ok(false);
        }
        let mut request = self.request.clone();
        request.deadline = request
            .deadline
            .map(|deadline| deadline.saturating_sub(self.start.elapsed()));
        let prepared = self
            .planner
            .prepared(&request, robot, path.len())?;
        self.stream = self.planner.link.send(&prepared, &path)?;
        self.robot = prepared.robot;
        self.columns = prepared.columns;
        Ok(true)
    }
}

fn of_whole(error: ClientError, timeout: Duration) -> ClientError {
    if matches!(error, ClientError::Timeout(_)) {
        ClientError::Timeout(timeout)
    } else {
        error
    }
}

fn whole(error: PlannerError, timeout: Duration) -> PlannerError {
    match error {
        PlannerError::Client(error) => of_whole(error, timeout).into(),
        error => error,
    }
}
