//! Answers of a daemon, over shared memory.

use super::connection::Planner;
use super::link::{Link, RECOVERY, Stream};
use super::prepared::Prepared;
use super::{Best, Columns, PlannerError};
use crate::client::{Client, Pending, RequestBuilder, retry};
use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::instance::Instance;
use crate::lock::DaemonState;
use crate::wire::ResponseHeader;
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Duration;

/// How long a control message may take: large meshes on a busy machine.
pub(super) const PATIENCE: Duration = Duration::from_secs(600);

impl Planner {
    /// Connects to the daemon of `instance`.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub fn connect(instance: &Instance) -> Result<Self, PlannerError> {
        Ok(Self::new(Client::connect(instance)?))
    }

    /// The same on a connection that is there.
    pub fn new(client: Client) -> Self {
        let mut planner = Self::over(Arc::new(client.clone()));
        planner.client = Some(client);
        planner
    }

    /// The connection, if there is a daemon at its other end.
    pub fn client(&self) -> Option<&Client> {
        self.client.as_ref()
    }
}

impl Link for Client {
    fn control(
        &self,
        message: &ControlRequest,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        retry(RECOVERY, || self.control_until(message, PATIENCE, stop))
    }

    fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, ClientError> {
        self.control_until(message, PATIENCE, &|| false)
    }

    fn boot_id(&self) -> Option<u64> {
        match self.daemon_state() {
            DaemonState::Running { boot_id, .. } => Some(boot_id),
            DaemonState::Absent | DaemonState::Starting => None,
        }
    }

    fn send(&self, prepared: &Prepared, path: &[f64]) -> Result<Box<dyn Stream>, PlannerError> {
        let mut loan = builder(self, prepared).loan()?;
        prepared.columns.write(path, loan.path_mut());
        Ok(Box::new(loan.send()?))
    }

    fn answer(
        &self,
        prepared: &Prepared,
        path: &[f64],
        patience: Duration,
        improved: &mut dyn FnMut(&ResponseHeader),
    ) -> Result<Best, PlannerError> {
        let response = builder(self, prepared).answer(
            &in_robots_order(prepared, path),
            patience,
            &mut |response| improved(response.header()),
        )?;
        Ok(Best::new(response, prepared.columns.clone()))
    }
}

impl Stream for Pending {
    fn request_id(&self) -> u64 {
        Pending::request_id(self)
    }

    fn next(
        &mut self,
        timeout: Duration,
        columns: &Arc<Columns>,
    ) -> Result<Option<Best>, ClientError> {
        let response = Pending::next(self, timeout)?;
        Ok(response.map(|response| Best::new(response, columns.clone())))
    }

    fn finish_early(&self) {
        Pending::finish_early(self);
    }

    fn sent(&self, columns: &Columns) -> Option<Vec<f64>> {
        let mut path = Vec::new();
        self.sent_path(|sent| {
            path.resize(sent.len() / columns.robot_width() * columns.width(), 0.0);
            columns.read(sent, &mut path);
        });
        Some(path)
    }
}

/// The request, without its path.
fn builder<'a>(client: &Client, prepared: &'a Prepared) -> RequestBuilder<'a> {
    let header = prepared.header;
    let mut builder = client
        .request(header.waypoints, header.variables)
        .with_body(prepared.sections.body());
    builder.header = header;
    builder
}

fn in_robots_order<'a>(prepared: &Prepared, path: &'a [f64]) -> Cow<'a, [f64]> {
    if prepared.columns.are_the_robots() {
        return Cow::Borrowed(path);
    }
    let header = &prepared.header;
    let mut ordered = vec![0.0; header.waypoints as usize * header.variables as usize];
    prepared.columns.write(path, &mut ordered);
    Cow::Owned(ordered)
}
