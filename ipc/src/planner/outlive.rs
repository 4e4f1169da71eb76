//! An answer that is waited for whatever happens to the daemon.

use super::connection::Planner;
use super::link::RECOVERY;
use super::{Best, PlannerError, Request};
use crate::wire::ResponseHeader;

impl Planner {
    /// The same, and waits for the final answer, whatever happens to the daemon meanwhile: if it
    /// dies, or has no room now, the request is sent again under the same id, until its deadline,
    /// or for 5 s where it has none. `improved` gets the header of every improvement; after a loss
    /// they begin anew.
    ///
    /// # Errors
    /// As [`Self::ask`]; the last loss. An answer that is no success is no error here.
    pub fn answer(
        &self,
        request: &Request,
        path: &[f64],
        improved: &mut dyn FnMut(&ResponseHeader),
    ) -> Result<Best, PlannerError> {
        let robot = self.robot(&request.robot)?;
        let prepared = self.prepared(request, robot, path.len())?;
        let patience = request.deadline.unwrap_or(RECOVERY);
        self.link
            .answer(&prepared, path, patience, improved)
    }
}
