//! A connection that knows the robots it has been asked for.

use super::here::Here;
use super::link::Link;
use super::service::Threads;
use super::{Carrier, PlannerError, Service};
#[cfg(feature = "iceoryx2")]
use crate::Client;
use crate::control::{ControlReply, ControlRequest, RobotDescription};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A connection that knows the robots it has been asked for. Cheap to clone; all clones are one
/// connection.
#[derive(Clone, Debug)]
pub struct Planner {
    pub(super) link: Arc<dyn Link>,
    #[cfg(feature = "iceoryx2")]
    pub(super) client: Option<Client>,
    robots: Arc<Mutex<BTreeMap<String, Arc<RobotDescription>>>>,
    /// Start of the daemon that has the scene with nothing in it.
    pub(super) empty_scene: Arc<Mutex<Option<u64>>>,
}

impl Planner {
    /// The same interface where a service of this process answers.
    pub fn in_process(service: impl Service + 'static) -> Self {
        Self::through(Threads::new(service))
    }

    /// The same interface where a carrier brings requests to who answers.
    pub fn through(carrier: impl Carrier + 'static) -> Self {
        Self::over(Arc::new(Here(carrier)))
    }

    pub(super) fn over(link: Arc<dyn Link>) -> Self {
        Self {
            link,
            #[cfg(feature = "iceoryx2")]
            client: None,
            robots: Arc::default(),
            empty_scene: Arc::default(),
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
        self.replied(self.link.control(message, stop)?)
    }

    /// Sends a control message to the daemon that is there: one that makes it stop, or is about it.
    ///
    /// # Errors
    /// As [`Self::control`].
    pub fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, PlannerError> {
        self.replied(self.link.control_once(message)?)
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
