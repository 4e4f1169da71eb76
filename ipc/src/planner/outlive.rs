//! An answer that is waited for whatever happens to the daemon.

use super::answers::Prepared;
use super::connection::{Link, Planner, RECOVERY};
use super::{Best, PlannerError, Request};
use crate::Client;
use crate::client::ClientError;
use crate::wire::ResponseHeader;
use std::borrow::Cow;
use std::time::Duration;

/// How often a wait for an answer of this process looks up.
const LOOK_UP: Duration = Duration::from_secs(1);

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
        match &self.link {
            Link::Daemon(client) => of_daemon(self, client, request, path, improved),
            Link::Here(_) => of_process(self, request, path, improved),
        }
    }
}

fn of_daemon(
    planner: &Planner,
    client: &Client,
    request: &Request,
    path: &[f64],
    improved: &mut dyn FnMut(&ResponseHeader),
) -> Result<Best, PlannerError> {
    let robot = planner.robot(&request.robot)?;
    let prepared = Prepared::new(planner, request, robot, path.len())?;
    let patience = request.deadline.unwrap_or(RECOVERY);
    let response = prepared.builder(client).answer(
        &in_robots_order(&prepared, path),
        patience,
        &mut |response| improved(response.header()),
    )?;
    Ok(Best::new(response, prepared.columns))
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

fn of_process(
    planner: &Planner,
    request: &Request,
    path: &[f64],
    improved: &mut dyn FnMut(&ResponseHeader),
) -> Result<Best, PlannerError> {
    let mut answers = planner.ask(request, path)?;
    loop {
        match answers.next(LOOK_UP) {
            Ok(Some(best)) if best.is_final() => return Ok(best),
            Ok(Some(best)) => improved(best.header()),
            Err(PlannerError::Client(ClientError::Timeout(_))) => {}
            Ok(None) => return Err(ClientError::NoAnswer.into()),
            Err(error) => return Err(error),
        }
    }
}
