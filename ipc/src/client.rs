//! A planner's side: send a path, iterate over better ones in place.

mod connection;
mod feed;
mod frame;
mod link;
mod pending;
mod recover;
mod refused;
mod relay;
mod request;
mod response;

pub use crate::client_error::{ClientError, Loss};
pub use feed::{SceneEventFeed, StatusFeed};
pub use frame::LoanedFrame;
pub use pending::Pending;
pub use recover::retry;
pub use relay::{Relay, Relayed};
pub use request::{LoanedRequest, RequestBuilder};
pub use response::Response;

use crate::control::{ControlReply, ControlRequest};
use crate::instance::Instance;
use crate::lock::DaemonState;
use connection::Connection;
use std::sync::Arc;
use std::time::Duration;

/// A connection to the daemon of one instance. Opens services, never creates them.
///
/// Four requests can be in flight at once, also from several threads; cheap to clone (one
/// connection). After [`ClientError::DaemonLost`] the same client can send again, to a daemon that
/// was restarted: its ports survive that, and where the daemon started anew because its files were
/// removed they are opened anew.
#[derive(Clone, Debug)]
pub struct Client {
    connection: Arc<Connection>,
}

impl Client {
    /// Connects to the daemon of `instance`.
    ///
    /// # Errors
    /// [`ClientError::DaemonLost`] if there is none, [`ClientError::TooManyClients`] if it is full.
    pub fn connect(instance: &Instance) -> Result<Self, ClientError> {
        Ok(Self {
            connection: Arc::new(Connection::open(instance)?),
        })
    }

    /// Starts a request with a path of this size; nothing is sent yet.
    ///
    /// ```no_run
    /// # use std::time::Duration;
    /// # use taut_ipc::{Client, Instance, wire::label_id};
    /// # fn main() -> Result<(), taut_ipc::ClientError> {
    /// let client = Client::connect(&Instance::from_environment()?)?;
    /// let mut request = client.request(2, 7);
    /// request.header.robot_id = label_id("panda");
    /// request.header.deadline_ns = taut_ipc::deadline_after(Duration::from_millis(20));
    /// let mut loan = request.loan()?;
    /// loan.path_mut().fill(0.0);
    /// let mut pending = loan.send()?;
    /// while let Some(best) = pending.next(Duration::from_secs(1))? {
    ///     println!("{} {:?}", best.header().length_after, best.path());
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn request(&self, waypoints: u32, variables: u32) -> RequestBuilder<'static> {
        RequestBuilder::new(self.connection.clone(), waypoints, variables)
    }

    /// Sends a control message and waits for its reply.
    ///
    /// # Errors
    /// [`ClientError::Timeout`] after `timeout`, [`ClientError::DaemonLost`], or what could not be
    /// sent. A refusal is a reply, not an error.
    pub fn control(
        &self,
        message: &ControlRequest,
        timeout: Duration,
    ) -> Result<ControlReply, ClientError> {
        self.control_until(message, timeout, &|| false)
    }

    /// The same, given up with [`ClientError::GivenUp`] once `stop`, asked every 100 ms, says so;
    /// what was asked for may still be done.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn control_until(
        &self,
        message: &ControlRequest,
        timeout: Duration,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        let link = self.connection.link()?;
        link.control(message, self.connection.next_id(), timeout, stop)
    }

    /// Takes shared memory for a control message with a body of so many bytes, which is written in
    /// place. A client has one control message at a time: a sensor has a client of its own.
    ///
    /// # Errors
    /// [`ClientError::Control`] over [`crate::limits::CONTROL_MAX`], [`ClientError::NoMemory`],
    /// [`ClientError::TooManyRequests`] while another control message is under way.
    pub fn frame(
        &self,
        message: &ControlRequest,
        bytes: usize,
    ) -> Result<LoanedFrame, ClientError> {
        let link = self.connection.link()?;
        LoanedFrame::new(link, message, bytes, self.connection.next_id())
    }

    /// What the daemon is doing, newest first seen when next published.
    ///
    /// # Errors
    /// [`ClientError::Setup`] if the subscription cannot be made.
    pub fn status_feed(&self) -> Result<StatusFeed, ClientError> {
        StatusFeed::open(&self.connection.link()?)
    }

    /// Changes of scenes from now on.
    ///
    /// # Errors
    /// [`ClientError::Setup`] if the subscription cannot be made.
    pub fn scene_event_feed(&self) -> Result<SceneEventFeed, ClientError> {
        SceneEventFeed::open(&self.connection.link()?)
    }

    /// Whether the daemon lives, and which start of it.
    pub fn daemon_state(&self) -> DaemonState {
        match self.connection.link() {
            Ok(link) => link.daemon_state(),
            Err(_) => DaemonState::Absent,
        }
    }
}
