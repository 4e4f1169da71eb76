//! A connection that knows the robots it has been asked for.

use super::{PlannerError, Service};
use crate::control::{ControlReply, ControlRequest, RobotDescription};
use crate::instance::Instance;
use crate::{Client, client::retry};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long a control message may take: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long a control message goes on after its daemon died, or had no room for it.
pub(super) const RECOVERY: Duration = Duration::from_secs(5);

/// A connection that knows the robots it has been asked for. Cheap to clone; all clones are one
/// connection.
#[derive(Clone, Debug)]
pub struct Planner {
    pub(super) link: Link,
    robots: Arc<Mutex<BTreeMap<String, Arc<RobotDescription>>>>,
    /// Start of the daemon that has the scene with nothing in it.
    pub(super) empty_scene: Arc<Mutex<Option<u64>>>,
}

/// Who answers.
#[derive(Clone, Debug)]
pub(super) enum Link {
    Daemon(Client),
    Here(Arc<dyn Service>),
}

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
        Self {
            link: Link::Daemon(client),
            robots: Arc::default(),
            empty_scene: Arc::default(),
        }
    }

    /// The same interface where a service of this process answers.
    pub fn in_process(service: impl Service + 'static) -> Self {
        Self {
            link: Link::Here(Arc::new(service)),
            robots: Arc::default(),
            empty_scene: Arc::default(),
        }
    }

    /// The connection, if there is a daemon at its other end.
    pub fn client(&self) -> Option<&Client> {
        match &self.link {
            Link::Daemon(client) => Some(client),
            Link::Here(_) => None,
        }
    }

    /// Variables, groups and weights of a loaded robot; the daemon is asked once.
    ///
    /// # Errors
    /// [`PlannerError::Refused`] for an unknown label, with those that are loaded.
    pub fn robot(&self, label: &str) -> Result<Arc<RobotDescription>, PlannerError> {
        if let Some(robot) = self.known().get(label) {
            return Ok(robot.clone());
        }
        self.describe(label)
    }

    /// The same, asked anew.
    pub(super) fn describe(&self, label: &str) -> Result<Arc<RobotDescription>, PlannerError> {
        match self.control(&ControlRequest::Describe {
            label: label.to_owned(),
        })? {
            ControlReply::Robot(robot) => Ok(Arc::new(*robot)),
            other => Err(PlannerError::unexpected(&other)),
        }
    }

    /// Sends a control message, to the next daemon if the first dies. What it tells of a robot is
    /// known from then on.
    ///
    /// # Errors
    /// [`PlannerError::Refused`]; what cannot be sent.
    pub fn control(&self, message: &ControlRequest) -> Result<ControlReply, PlannerError> {
        self.control_until(message, &|| false)
    }

    /// The same, given up with [`crate::ClientError::GivenUp`] once `stop`, asked every 100 ms,
    /// says so.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn control_until(
        &self,
        message: &ControlRequest,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, PlannerError> {
        let reply = match &self.link {
            Link::Daemon(client) => {
                retry(RECOVERY, || client.control_until(message, PATIENCE, stop))?
            }
            Link::Here(service) => service.control(message.clone()),
        };
        self.replied(reply)
    }

    /// Sends a control message to the daemon that is there: one that makes it stop, or is about it.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, PlannerError> {
        let reply = match &self.link {
            Link::Daemon(client) => client.control(message, PATIENCE)?,
            Link::Here(service) => service.control(message.clone()),
        };
        self.replied(reply)
    }

    fn replied(&self, reply: ControlReply) -> Result<ControlReply, PlannerError> {
        match reply {
            ControlReply::Refused(refusal) => Err(PlannerError::of_refusal(refusal)),
            ControlReply::Robot(robot) => {
                self.known().insert(
                    robot.label.clone(),
                    Arc::new(RobotDescription::clone(&robot)),
                );
                Ok(ControlReply::Robot(robot))
            }
            reply => Ok(reply),
        }
    }

    pub(super) fn known(&self) -> MutexGuard<'_, BTreeMap<String, Arc<RobotDescription>>> {
        self.robots
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
