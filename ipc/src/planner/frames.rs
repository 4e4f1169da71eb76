//! Frames of sensors, by name.

use super::PlannerError;
use super::connection::Planner;
use super::daemon::PATIENCE;
use crate::client::LoanedFrame;
use crate::control::{CloudFrame, ControlReply, ControlRequest, FrameSummary};
use crate::wire::Code;

impl Planner {
    /// Makes points the shape of a sensed object of a scene, which thereby has its next version, and
    /// waits for that. A sensor has a connection of its own: one frame is under way at a time.
    ///
    /// # Errors
    /// [`PlannerError::Refused`]: an object that is not sensed, a frame that is not newer than its
    /// last ([`Code::Preempted`]), a layout that is none; what cannot be sent.
    pub fn set_cloud(
        &self,
        scene: &str,
        object: &str,
        frame: CloudFrame,
        points: &[u8],
    ) -> Result<FrameSummary, PlannerError> {
        let mut loan = self.loan_frame(scene, object, frame, points.len())?;
        loan.body_mut().copy_from_slice(points);
        self.send_frame(loan)
    }

    /// Takes shared memory for a frame, whose points are then written in place.
    ///
    /// # Errors
    /// What cannot be taken; a connection that leads to no daemon of this machine.
    pub fn loan_frame(
        &self,
        scene: &str,
        object: &str,
        frame: CloudFrame,
        bytes: usize,
    ) -> Result<LoanedFrame, PlannerError> {
        let Some(client) = self.client() else {
            let text = "frames go to a daemon of this machine, over shared memory; connect to one (taut daemon)";
            return Err(PlannerError::invalid(Code::MalformedRequest, text));
        };
        let message = ControlRequest::Frame {
            label: scene.to_owned(),
            object: object.to_owned(),
            frame: Box::new(frame),
        };
        Ok(client.frame(&message, bytes)?)
    }

    /// Sends a frame that was written in place, and waits until its scene has it.
    ///
    /// # Errors
    /// As [`Self::set_cloud`].
    pub fn send_frame(&self, loan: LoanedFrame) -> Result<FrameSummary, PlannerError> {
        match loan.send(PATIENCE)? {
            ControlReply::Framed(summary) => Ok(*summary),
            ControlReply::Refused(refusal) => Err(PlannerError::of_refusal(refusal)),
            other => Err(PlannerError::unexpected(&other)),
        }
    }
}
