//! Lengths that go with improvements.

use crate::optimize::{Settings, lower_bound};
use crate::path::{Metric, Path};
use crate::robot::ConfigurationSpace;
use crate::store::Snapshot;

/// Lengths of the input for the headers of improvements, worked out with the first of them.
pub struct Lengths<'a> {
    snapshot: &'a Snapshot,
    settings: &'a Settings,
    path: &'a Path,
    known: Option<[f64; 2]>,
}

impl<'a> Lengths<'a> {
    /// Of a request whose settings have weights.
    pub fn new(snapshot: &'a Snapshot, settings: &'a Settings, path: &'a Path) -> Self {
        Self {
            snapshot,
            settings,
            path,
            known: None,
        }
    }

    /// Length before, this length, and the lower bound.
    pub fn of(&mut self, length: f64) -> [f64; 3] {
        let [before, bound] = *self.known.get_or_insert_with(|| {
            input_lengths(self.snapshot, self.settings, self.path).unwrap_or_default()
        });
        [before, length, bound]
    }
}

fn input_lengths(snapshot: &Snapshot, settings: &Settings, path: &Path) -> Option<[f64; 2]> {
    let space = space(snapshot.robot.space(), settings.unwrapped);
    let metric = Metric::new(&space, settings.weights.clone()?).ok()?;
    let mut scratch = vec![0.0; space.nv()];
    let bound = lower_bound(&space, &metric, path, settings.keep_goal);
    Some([metric.length(&space, path.as_flat(), &mut scratch), bound])
}

/// The space of the robot as a request takes it.
fn space(space: &ConfigurationSpace, unwrapped: bool) -> ConfigurationSpace {
    match unwrapped {
        true => space.unwrapped(),
        false => space.clone(),
    }
}
