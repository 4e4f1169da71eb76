//! What the answers must keep, and what their lengths mean.

use std::time::Duration;

use taut::optimize::{Mode, Settings};

use crate::error::Error;
use crate::values;

/// What the answer must keep, and what its length means.
#[derive(clap::Args)]
pub(super) struct Rules {
    /// Distance that every pair of bodies must keep: 0.1mm, 1cm, or metres
    #[arg(long, default_value = "1mm", value_parser = values::metres)]
    pub clearance: f64,
    /// Refuse a path that keeps less, instead of lowering the clearance of the pairs that come
    /// closer
    #[arg(long)]
    strict: bool,
    /// Take the columns of continuous joints as they stand, not as angles on the circle
    #[arg(long)]
    pub unwrapped: bool,
    /// Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than
    /// half a turn, and take no path that ends whole turns away
    #[arg(long, conflicts_with = "unwrapped")]
    keep_goal: bool,
    /// Weights of the metric; the default is the problem's own, or reach where it has none
    #[arg(long, value_enum)]
    weights: Option<Weights>,
    /// Time that a request may take: 20ms, 1.5s
    #[arg(long, value_parser = values::duration)]
    pub deadline: Option<Duration>,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Where the weights of the metric come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Weights {
    /// The problem's own
    Metric,
    /// Metres that a body can move per radian or metre of a joint
    Reach,
    /// 1 for every coordinate
    Ones,
}

impl Rules {
    /// Settings of a run in `mode` for a robot of `nv` velocity coordinates; `metric` are the
    /// problem's weights.
    ///
    /// # Errors
    /// The problem's weights asked for where it has none.
    pub(super) fn settings(
        &self,
        mode: Mode,
        metric: Option<&Vec<f64>>,
        nv: usize,
    ) -> Result<Settings, Error> {
        Ok(Settings {
            mode,
            seed: self.seed,
            clearance_m: self.clearance,
            strict: self.strict,
            unwrapped: self.unwrapped,
            keep_goal: self.keep_goal,
            weights: self.weights(metric, nv)?,
            ..Settings::default()
        })
    }

    fn weights(&self, metric: Option<&Vec<f64>>, nv: usize) -> Result<Option<Vec<f64>>, Error> {
        let weights = match self.weights {
            None => metric.cloned(),
            Some(Weights::Reach) => None,
            Some(Weights::Ones) => Some(vec![1.0; nv]),
            Some(Weights::Metric) => Some(metric.cloned().ok_or_else(no_metric)?),
        };
        Ok(weights)
    }
}

fn no_metric() -> Error {
    Error::Usage("--weights metric needs a problem with a metric; use reach or ones".to_owned())
}
