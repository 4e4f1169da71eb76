//! What a request asks for, before it is known about which robot.

use taut::constraint::ConstraintsFile;
use taut::files::result::ResultSubject;
use taut_ipc::planner::Request;
use taut_ipc::wire::Mode;

use super::constraints::Constraints;
use super::error::CliError;
use super::options::Options;
use super::weights::Weights;

/// What a request asks for.
pub(super) struct Asked {
    /// The options; robot and scene are not named yet.
    pub request: Request,
    /// What the flags ask the path to keep besides clearance.
    pub constraints: ConstraintsFile,
    /// Where the weights of its metric come from.
    pub weights: Option<Weights>,
}

impl Asked {
    /// What the flags say.
    ///
    /// # Errors
    /// A value that the table of options does not have, a file of constraints that cannot be read.
    pub(super) fn new<const CHECK: bool>(
        options: &Options<CHECK>,
        constraints: &Constraints,
        weights: Option<Weights>,
    ) -> Result<Self, CliError> {
        let mut request = Request::new("", None);
        options.enter(&mut request)?;
        if CHECK {
            request.mode = Mode::Check;
        }
        Ok(Self {
            request,
            constraints: constraints.all()?,
            weights,
        })
    }

    /// The same with times, where the text asks for them.
    pub(super) fn timed(mut self, timing: String) -> Self {
        self.request.timing = timing;
        self
    }

    /// Where robot and scene come from, with what the request says about them.
    pub(super) fn source(&self, source: ResultSubject) -> ResultSubject {
        ResultSubject {
            unwrapped: self.request.unwrapped,
            held: self.request.held.iter().cloned().collect(),
            ..source
        }
    }

    /// What lengths are measured in, for people.
    pub(super) fn metric(&self, is_given: bool) -> String {
        let joints = self.request.joint_weights.iter();
        let joints = joints.map(|(name, weight)| format!(", {name} {weight}"));
        self.base(is_given).to_owned() + &joints.collect::<String>()
    }

    /// What lengths are measured in but for joints with weights of their own.
    fn base(&self, is_given: bool) -> &'static str {
        match self.weights {
            None if is_given => "the problem's weights",
            None | Some(Weights::Reach) => "metres of reach",
            Some(Weights::Metric) => "the problem's weights",
            Some(Weights::Ones) => "weights of one",
        }
    }
}
