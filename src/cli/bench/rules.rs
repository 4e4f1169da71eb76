//! What an answer must keep, and what its length means.

use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taut::optimize::{Mode, Settings};

use crate::cli::quantity;
use crate::cli::weights::{self, Weights};

/// What the answer must keep, and what its length means.
#[derive(clap::Args)]
pub(in crate::cli) struct Rules {
    /// Distance that every pair of bodies must keep: 0.1mm, 1cm, or metres
    #[arg(long, default_value = "1mm", value_parser = quantity::metres)]
    pub clearance: f64,
    /// Refuse a path that keeps less, instead of lowering the clearance of the pairs that come
    /// closer
    #[arg(long)]
    pub strict: bool,
    /// Take the columns of continuous joints as they stand, not as angles on the circle
    #[arg(long)]
    pub unwrapped: bool,
    /// Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than
    /// half a turn, and take no path that ends whole turns away
    #[arg(long, conflicts_with = "unwrapped")]
    pub keep_goal: bool,
    /// Weights of the metric; the default is the problem's own, or reach where it has none
    #[arg(long, value_enum)]
    pub weights: Option<Weights>,
    /// Time that a request may take: 20ms, 1.5s
    #[arg(long, value_parser = quantity::duration)]
    pub deadline: Option<Duration>,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

impl Rules {
    /// Settings of a request in `mode` for a robot of `nv` velocity coordinates.
    ///
    /// `metric` are the problem's weights. The error is a usage error.
    pub(super) fn settings(
        &self,
        mode: Mode,
        metric: Option<&Vec<f64>>,
        nv: usize,
    ) -> Result<Settings, String> {
        let weights = weights::weights(self.weights, metric, nv)?;
        Ok(Settings {
            mode,
            seed: self.seed,
            clearance_m: self.clearance,
            strict: self.strict,
            unwrapped: self.unwrapped,
            keep_goal: self.keep_goal,
            weights,
            ..Settings::default()
        })
    }
}

/// Parses a mode by its name.
pub(in crate::cli) fn mode() -> impl TypedValueParser<Value = Mode> {
    let by_name = |name: String| {
        Mode::ALL
            .into_iter()
            .find(|mode| mode.name() == name)
            .unwrap_or_default()
    };
    PossibleValuesParser::new(Mode::ALL.map(Mode::name)).map(by_name)
}
