//! What a request says about joints and waypoints, by name and number, and its translation to
//! settings.

use taut::optimize::Settings;

use super::error::CliError;
use super::layout::Layout;
use super::quantity;

/// Which joints may move, what that costs, and which waypoints stay.
#[derive(clap::Args, Clone, Debug, Default)]
pub(super) struct Choices {
    /// Group of the SRDF: only its joints may move otherwise than on the path given
    #[arg(long, value_name = "NAME")]
    group: Option<String>,
    /// Waypoints that stay as they are to the last bit, counted from 0: 0,3,7-9
    #[arg(long, value_name = "LIST", value_parser = quantity::numbers)]
    fix: Option<quantity::Numbers>,
    /// Weight of one joint in the metric, instead of the one that --weights gives it; repeatable
    #[arg(long = "joint-weight", value_name = "NAME=WEIGHT", value_parser = quantity::weight)]
    joint_weights: Vec<(String, f64)>,
    /// Most work to spend on a shorter path, in the units of the answer's `work`: the same on every
    /// machine
    #[arg(long, value_name = "WORK", value_parser = clap::value_parser!(u64).range(1..))]
    budget: Option<u64>,
    #[command(flatten)]
    reported: Reported,
}

/// Choices that a check has too.
#[derive(clap::Args, Clone, Debug, Default)]
pub(super) struct Reported {
    /// Where a joint stands that is no column of the path (rad or m), instead of at 0; repeatable
    #[arg(long = "hold", value_name = "NAME=VALUE", value_parser = quantity::value)]
    held: Vec<(String, f64)>,
    /// Do not look for what is nearest along the path: the answer comes sooner
    #[arg(long)]
    no_contacts: bool,
    /// Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell how far
    /// what is executed may stray from the path
    #[arg(long)]
    corridor: bool,
}

impl From<&Reported> for Choices {
    fn from(reported: &Reported) -> Self {
        Self {
            reported: reported.clone(),
            ..Self::default()
        }
    }
}

impl Choices {
    /// Values of the joints that are no columns, by name.
    pub(super) fn held(&self) -> &[(String, f64)] {
        &self.reported.held
    }

    /// Names of the joints whose weights are given, each with its weight.
    pub(super) fn joint_weights(&self) -> &[(String, f64)] {
        &self.joint_weights
    }

    /// Enters the choices into the settings of a request about a path of so many waypoints.
    ///
    /// # Errors
    /// A name or number that does not exist, with the valid ones.
    pub(super) fn enter(
        &self,
        layout: &Layout,
        waypoints: usize,
        settings: &mut Settings,
    ) -> Result<(), CliError> {
        if let Some(name) = &self.group {
            settings.moving = Some(layout.group(name)?.to_vec());
        }
        if let Some(numbers) = &self.fix {
            settings.fixed_waypoints = Some(fixed(numbers, waypoints)?);
        }
        for (name, weight) in &self.joint_weights {
            let weights = settings
                .weights
                .get_or_insert_with(|| layout.weights.clone());
            for coordinate in layout.coordinates_of(name)? {
                weights[coordinate] = *weight;
            }
        }
        settings.corridor = self.reported.corridor;
        settings.contacts = !self.reported.no_contacts;
        for (name, value) in &self.reported.held {
            let index = layout.held_index(name)?;
            settings
                .held
                .get_or_insert_with(|| layout.held.iter().map(|(_, value)| *value).collect())
                [index] = *value;
        }
        settings.work_budget = self.budget.unwrap_or(settings.work_budget);
        Ok(())
    }
}

fn fixed(numbers: &quantity::Numbers, waypoints: usize) -> Result<Vec<bool>, CliError> {
    let mut fixed = vec![false; waypoints];
    for range in numbers {
        match fixed.get_mut(range.clone()) {
            Some(stay) => stay.fill(true),
            None => {
                let last = range.end();
                let valid = waypoints - 1;
                return Err(CliError::Choice(format!(
                    "--fix names waypoint {last}; the path has waypoints 0 to {valid}"
                )));
            }
        }
    }
    Ok(fixed)
}
