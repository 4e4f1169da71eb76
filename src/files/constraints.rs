//! What planning requests, trajectories and problems say besides a path: nothing that a path would
//! have to keep to, or could meet, is left out unseen.

use crate::scene::Filled;
use crate::scene::scene_file::refuse_constraints;

/// Refuses what a path would have to keep to, by the names of the fields.
///
/// # Errors
/// There is such a thing.
pub(super) fn check_constraints<const N: usize>(fields: [(&str, Filled); N]) -> Result<(), String> {
    let check = |(field, constraints)| {
        refuse_constraints(field, constraints).map_err(|error| error.to_string())
    };
    fields.into_iter().try_for_each(check)
}

/// Refuses a goal that says more than where joints are.
///
/// # Errors
/// It has one of these constraints.
pub(super) fn check_goal<const N: usize>(fields: [(&str, Filled); N]) -> Result<(), String> {
    match fields
        .iter()
        .find(|(_, constraints)| !constraints.is_empty())
    {
        None => Ok(()),
        Some((field, _)) => Err(format!(
            "its goal_constraints have {field}; only goals in joint space are read"
        )),
    }
}
