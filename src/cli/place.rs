//! Where a request is computed: by the daemon, or in this process. Both give the same report.

use std::path::Path;
use std::time::Duration;

use taut::collision::{neutral_warnings, reach_weights};
use taut::files::Reader;
use taut::optimize::Workspace;
use taut_ipc::{Client, ClientError};

use super::connect::InstanceChoice;
use super::error::CliError;
use super::layout::Layout;
use super::progress::Progress;
use super::report::Subject;
use super::request::{Asked, Source};
use super::run::{self as runner, Timed};
use super::{load, remote};

/// The choice on the command line.
#[derive(clap::Args)]
pub(super) struct Choice {
    /// Work in this process, without a daemon
    #[arg(long, conflicts_with = "instance")]
    local: bool,
    #[command(flatten)]
    instance: InstanceChoice,
}

/// A place.
pub(super) enum Place {
    /// This process.
    Local(Box<Workspace>),
    /// The daemon.
    Daemon(Client),
}

impl Place {
    /// Goes there.
    ///
    /// # Errors
    /// Where there is no daemon.
    pub(super) fn open(choice: &Choice) -> Result<Self, CliError> {
        if choice.local {
            return Ok(Self::Local(Box::default()));
        }
        match choice.instance.connect() {
            Ok(client) => Ok(Self::Daemon(client)),
            Err(CliError::Client(ClientError::DaemonLost { root, reason })) => {
                Err(CliError::NoDaemon { root, reason })
            }
            Err(error) => Err(error),
        }
    }

    /// Answers the request about a file. `watch` gets the length of each improvement and when it
    /// came. Only an answer that is kept as a file says where robot and scene come from.
    ///
    /// # Errors
    /// A file that cannot be used, a request that is refused, a daemon that went away.
    pub(super) fn answer(
        &mut self,
        reader: &mut Reader,
        file: &Path,
        source: &Source,
        asked: &Asked,
        is_kept: bool,
        watch: &mut dyn FnMut(Duration, f64),
    ) -> Result<(Subject, Timed), CliError> {
        match self {
            Self::Local(workspace) => {
                let progress = Progress::start(file);
                let loaded = load::load_holding(reader, file, source, false, asked.choices.held())?;
                progress.preparing(loaded.triangles());
                let model = loaded.model()?;
                let layout =
                    Layout::of_model(&loaded.robot, reach_weights(&loaded.robot, model.bodies()));
                let settings =
                    asked.settings(loaded.weights.as_ref(), &layout, loaded.path.len())?;
                let mut subject = loaded.subject();
                subject.metric = asked.metric(loaded.weights.is_some());
                let of_robot = loaded.robot.warnings().len();
                subject
                    .warnings
                    .splice(of_robot..of_robot, neutral_warnings(&model));
                drop(progress);
                let timed = runner::run(
                    &loaded,
                    &model,
                    &settings,
                    asked.rules.deadline,
                    workspace,
                    watch,
                )?;
                if is_kept {
                    subject.source = asked.source(loaded.source(&source.packages));
                }
                Ok((subject, timed))
            }
            Self::Daemon(client) => {
                let progress = Progress::start(file);
                let mut prepared =
                    remote::prepare(client, reader, file, source, asked.choices.held())?;
                drop(progress);
                let layout = Layout::of_description(&prepared.robot);
                let settings =
                    asked.settings(prepared.weights.as_ref(), &layout, prepared.path.len())?;
                prepared.subject.metric = asked.metric(prepared.weights.is_some());
                let timed = remote::run(
                    client,
                    &prepared,
                    &layout,
                    &settings,
                    asked.rules.deadline,
                    watch,
                )?;
                if is_kept {
                    prepared.subject.source =
                        asked.source(remote::source(client, &prepared, &source.packages));
                }
                Ok((prepared.subject, timed))
            }
        }
    }
}
