//! A request in the order of its robot's variables.

use super::request::Sections;
use super::{Columns, PlannerError, Request};
use crate::control::RobotDescription;
use crate::wire::RequestHeader;
use std::sync::Arc;

/// A request in the order of its robot's variables, ready to be sent.
pub(super) struct Prepared {
    pub robot: Arc<RobotDescription>,
    pub columns: Arc<Columns>,
    pub header: RequestHeader,
    pub sections: Sections,
}

impl Prepared {
    /// About a path of so many numbers, in a scene.
    pub(super) fn new(
        request: &Request,
        robot: Arc<RobotDescription>,
        scene: &str,
        numbers: usize,
    ) -> Result<Self, PlannerError> {
        let columns = Arc::new(request.columns_of(&robot)?);
        let waypoints = request.waypoints(&columns, numbers)?;
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
}
