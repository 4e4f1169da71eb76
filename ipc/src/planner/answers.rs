//! The stream of answers to a request.

use super::connection::{Link, Planner};
use super::request::Sections;
use super::{Best, Columns, PlannerError, Request, service};
use crate::Client;
use crate::client::{ClientError, Pending, RequestBuilder};
use crate::control::RobotDescription;
use crate::wire::{Code, RequestHeader};
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
    stream: Stream,
    /// When it was sent.
    start: Instant,
    asked_again: bool,
}

#[derive(Debug)]
enum Stream {
    Daemon(Box<Pending>),
    Here(service::Stream),
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
}

impl Answers {
    pub(super) fn ask(
        planner: &Planner,
        request: &Request,
        path: &[f64],
    ) -> Result<Self, PlannerError> {
        let start = Instant::now();
        let robot = planner.robot(&request.robot)?;
        let prepared = Prepared::new(planner, request, robot, path.len())?;
        let stream = send(planner, &prepared, path)?;
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
        match &self.stream {
            Stream::Daemon(pending) => pending.request_id(),
            Stream::Here(stream) => stream.request_id(),
        }
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
            let next = match &mut self.stream {
                Stream::Daemon(pending) => {
                    let next = pending.next(left);
                    next.map(|response| {
                        response.map(|response| Best::new(response, self.columns.clone()))
                    })
                }
                Stream::Here(stream) => stream.next(left),
            };
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
        match &self.stream {
            Stream::Daemon(pending) => pending.finish_early(),
            Stream::Here(stream) => stream.finish_early(),
        }
    }

    /// Whether the robot's label names another robot by now, whose variables are others; the
    /// request is then sent again, once, with its columns in their order.
    fn is_for_another_layout(&mut self, best: &Best) -> Result<bool, PlannerError> {
        let may_be =
            best.is_final() && best.code() == Code::InvalidRobotState && best.path().is_empty();
        let Stream::Daemon(pending) = &self.stream else {
            return Ok(false);
        };
        if !may_be || self.asked_again {
            return Ok(false);
        }
        self.asked_again = true;
        let robot = self.planner.describe(&self.request.robot)?;
        if robot.layout_hash == self.robot.layout_hash {
            return Ok(false);
        }
        if self.request.columns_of(&robot)?.width() != self.columns.width() {
            // The caller named no columns and means others than the robot has now.
            return Ok(false);
        }
        let path = self.sent(pending);
        let mut request = self.request.clone();
        request.deadline = request
            .deadline
            .map(|deadline| deadline.saturating_sub(self.start.elapsed()));
        let prepared = Prepared::new(&self.planner, &request, robot, path.len())?;
        self.stream = send(&self.planner, &prepared, &path)?;
        self.robot = prepared.robot;
        self.columns = prepared.columns;
        Ok(true)
    }

    /// The path that was sent, in the caller's columns.
    fn sent(&self, pending: &Pending) -> Vec<f64> {
        let columns = &self.columns;
        let mut path = Vec::new();
        pending.sent_path(|sent| {
            path.resize(sent.len() / columns.robot_width() * columns.width(), 0.0);
            columns.read(sent, &mut path);
        });
        path
    }
}

fn send(planner: &Planner, prepared: &Prepared, path: &[f64]) -> Result<Stream, PlannerError> {
    let columns = &prepared.columns;
    match &planner.link {
        Link::Daemon(client) => {
            let mut loan = prepared.builder(client).loan()?;
            columns.write(path, loan.path_mut());
            Ok(Stream::Daemon(Box::new(loan.send()?)))
        }
        Link::Here(service) => Ok(Stream::Here(service::Stream::start(
            service,
            prepared.header,
            &prepared.sections.body(),
            columns.clone(),
            |slots: &mut [f64]| columns.write(path, slots),
        )?)),
    }
}

/// A request in the order of its robot's variables, ready to be sent.
pub(super) struct Prepared {
    pub robot: Arc<RobotDescription>,
    pub columns: Arc<Columns>,
    pub header: RequestHeader,
    pub sections: Sections,
}

impl Prepared {
    /// About a path of so many numbers.
    pub(super) fn new(
        planner: &Planner,
        request: &Request,
        robot: Arc<RobotDescription>,
        numbers: usize,
    ) -> Result<Self, PlannerError> {
        let columns = Arc::new(request.columns_of(&robot)?);
        let waypoints = request.waypoints(&columns, numbers)?;
        let scene = match &request.scene {
            Some(scene) => scene,
            None => planner.empty_scene()?,
        };
        let sections = request.sections(&robot, &columns, waypoints)?;
        let header = RequestHeader {
            waypoints,
            variables: robot.nq,
            ..request.header(&robot, scene)?
        };
        Ok(Self {
            robot,
            columns,
            header,
            sections,
        })
    }

    /// The request to a daemon, without its path.
    pub(super) fn builder(&self, client: &Client) -> RequestBuilder<'_> {
        let header = self.header;
        let mut builder = client
            .request(header.waypoints, header.variables)
            .with_body(self.sections.body());
        builder.header = header;
        builder
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
