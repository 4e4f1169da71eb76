//! What a request asks for, before it is known about which robot.

use taut::files::result::ResultSubject;
use taut_ipc::planner::Request;
use taut_ipc::wire::Mode;

use super::error::CliError;
use super::options::Options;
use super::weights::Weights;

/// What a request asks for.
pub(super) struct Asked {
    /// The options; robot and scene are not named yet.
    pub request: Request,
    /// Where the weights of its metric come from.
    pub weights: Option<Weights>,
}

impl Asked {
    /// What the flags say.
    ///
    /// # Errors
    /// A value that the table of options does not have.
    pub(super) fn new<const CHECK: bool>(
        options: &Options<CHECK>,
        weights: Option<Weights>,
    ) -> Result<Self, CliError> {
        let mut request = Request::new("", None);
        options.enter(&mut request)?;
        if CHECK {
            request.mode = Mode::Check;
        }
        Ok(Self { request, weights })
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
        let base = match self.weights {
            None if is_given => "the problem's weights",
            None | Some(Weights::Reach) => "metres of reach",
            Some(Weights::Metric) => "the problem's weights",
            Some(Weights::Ones) => "weights of one",
        };
        let joints = self.request.joint_weights.iter();
        let joints = joints.map(|(name, weight)| format!(", {name} {weight}"));
        joints.fold(base.to_owned(), |text, joint| text + &joint)
    }
}
