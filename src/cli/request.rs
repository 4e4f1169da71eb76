//! The options that `check`, `shorten` and `bench` share.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taut::files::result::ResultSubject;
use taut::optimize::{Mode, Settings};

use super::choices::Choices;
use super::error::CliError;
use super::layout::Layout;
use super::quantity;

/// Where the robot and the scene come from.
#[derive(clap::Args)]
pub(super) struct Source {
    /// URDF of a bare path's robot, or the label of a robot that the daemon has loaded; an SRDF of
    /// the same name beside the URDF is read too
    #[arg(long, value_name = "URDF", conflicts_with = "problem")]
    pub robot: Option<PathBuf>,
    /// SRDF of the robot, where it is not beside the URDF
    #[arg(long, value_name = "SRDF", requires = "robot")]
    pub srdf: Option<PathBuf>,
    /// Scene of a bare path (JSON, YAML or MoveIt's .scene text), a problem file whose scene to
    /// take, or the label of a scene that the daemon has loaded; without it there is no obstacle
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub scene: Option<PathBuf>,
    /// Problem file whose robot, scene and weights a bare path is for
    #[arg(long, value_name = "FILE")]
    pub problem: Option<PathBuf>,
    /// Which of the problems in a file of VAMP's to take, by set and index: its scene, and where it
    /// is given as a path, the straight line from its start to its goal
    #[arg(long, value_name = "SET:INDEX", conflicts_with = "problem")]
    pub select: Option<String>,
    /// Folder of a package that a robot names as package://NAME/
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = quantity::package)]
    pub packages: Vec<(String, PathBuf)>,
    /// Model of the robot: its own shapes, or the spheres of a problem that has them
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryChoice,
}

/// Which of a problem's models of the robot to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum GeometryChoice {
    /// `bench`: spheres where the problem has them; else the given shapes
    #[default]
    Auto,
    /// The robot's own shapes
    Given,
    /// The sphere model
    Spheres,
}

/// What the answer must keep, and what its length means.
#[derive(clap::Args)]
pub(super) struct Rules {
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

/// Where the weights of the metric come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Weights {
    /// The problem's own
    Metric,
    /// Metres that a body can move per radian or metre of a joint
    Reach,
    /// 1 for every coordinate
    Ones,
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
        let weights = match self.weights {
            None => metric.cloned(),
            Some(Weights::Reach) => None,
            Some(Weights::Ones) => Some(vec![1.0; nv]),
            Some(Weights::Metric) => {
                let none = "--weights metric needs a problem with a metric; use reach or ones";
                Some(metric.cloned().ok_or(none)?)
            }
        };
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

/// Everything that a request asks for.
pub(super) struct Asked<'a> {
    /// Optimizer.
    pub mode: Mode,
    /// What the answer must keep.
    pub rules: &'a Rules,
    /// Joints and waypoints.
    pub choices: &'a Choices,
}

impl Asked<'_> {
    /// Settings of the request, for a path of so many waypoints. `metric` are the problem's
    /// weights.
    ///
    /// # Errors
    /// What does not go together, and names that do not exist.
    pub(super) fn settings(
        &self,
        metric: Option<&Vec<f64>>,
        layout: &Layout,
        waypoints: usize,
    ) -> Result<Settings, CliError> {
        let settings = self.rules.settings(self.mode, metric, layout.weights.len());
        let mut settings = settings.map_err(CliError::Usage)?;
        self.choices.enter(layout, waypoints, &mut settings)?;
        Ok(settings)
    }

    /// Where robot and scene come from, with what the request says about them.
    pub(super) fn source(&self, source: ResultSubject) -> ResultSubject {
        ResultSubject {
            unwrapped: self.rules.unwrapped,
            held: self.choices.held().iter().cloned().collect(),
            ..source
        }
    }

    /// What lengths are measured in, for people.
    pub(super) fn metric(&self, is_given: bool) -> String {
        let base = match self.rules.weights {
            None if is_given => "the problem's weights",
            None | Some(Weights::Reach) => "metres of reach",
            Some(Weights::Metric) => "the problem's weights",
            Some(Weights::Ones) => "weights of one",
        };
        let joints = self
            .choices
            .joint_weights()
            .iter()
            .map(|(name, weight)| format!(", {name} {weight}"));
        joints.fold(base.to_owned(), |text, joint| text + &joint)
    }
}

/// Parses a mode by its name.
pub(super) fn mode() -> impl TypedValueParser<Value = Mode> {
    let by_name = |name: String| {
        Mode::ALL
            .into_iter()
            .find(|mode| mode.name() == name)
            .unwrap_or_default()
    };
    PossibleValuesParser::new(Mode::ALL.map(Mode::name)).map(by_name)
}
