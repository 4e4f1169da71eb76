//! `taut scene`: the scenes of a daemon, how they changed, and changes to them.

mod cloud;
mod common;
mod events;
mod own;
mod table;
mod values;

use std::path::{Path, PathBuf};

use taut::files::{FileError, diff_text};
use taut_ipc::control::{SceneSummary, SceneText};
use taut_ipc::planner::words;

use super::error::CliError;
use super::format::{Format, print_line};
use super::models::print;
use super::source::folder_of;
use common::{Common, change, versions_line};
use values::{Pose, version};

/// Scenes of the daemon: list, show, compare and change them
///
/// Every change makes a new version. Exit code: 0 done, 64 usage, 65 a bad diff or an unknown
/// object or link, 66 an unknown scene or version, or another base, 69 no daemon.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// List the scenes with their versions
    List {
        #[command(flatten)]
        common: Common,
    },
    /// Show what is in a scene; as JSON, the text that load-scene takes
    Show {
        /// Its label
        label: String,
        /// Version, such as v12; the newest where it is missing
        #[arg(long, value_name = "VERSION", value_parser = version)]
        version: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
    /// Show what leads from one version to another; as JSON, the diff that apply takes
    Diff {
        /// Its label
        label: String,
        /// Version to start from, such as v12
        #[arg(value_parser = version)]
        from: u64,
        /// Version to end at; the newest where it is missing
        #[arg(value_parser = version)]
        to: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
    /// Make a diff's changes, all or none
    Apply {
        /// Its label
        label: String,
        /// The diff (JSON or YAML, `is_diff` set); - reads standard input
        file: PathBuf,
        /// Version that the scene has to have
        #[arg(long, value_name = "VERSION", value_parser = version)]
        base: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
    /// Move an object: its position in the world (m), and its orientation as a quaternion
    Move {
        /// Its label
        label: String,
        /// The object
        object: String,
        #[command(flatten)]
        pose: Pose,
        /// Link that carries the object: the pose is in the link's frame
        #[arg(long)]
        link: Option<String>,
        #[command(flatten)]
        common: Common,
    },
    /// Let a link carry an object: its pose in the link's frame
    Attach {
        /// Its label
        label: String,
        /// The object, which stands in the world
        object: String,
        /// The link; the two may touch
        link: String,
        #[command(flatten)]
        pose: Pose,
        /// Links and objects that the object may touch besides
        #[arg(long, value_name = "NAMES", value_delimiter = ',')]
        touch: Vec<String>,
        #[command(flatten)]
        common: Common,
    },
    /// Put an attached object down: its pose in the world
    Detach {
        /// Its label
        label: String,
        /// The object
        object: String,
        #[command(flatten)]
        pose: Pose,
        #[command(flatten)]
        common: Common,
    },
    /// Add what a sensor saw as an object: a cloud of points, or an octomap
    Cloud(Box<cloud::Arguments>),
    /// Keep a version until it is unpinned; as long as there is one, the scene cannot be unloaded
    Pin {
        /// Its label
        label: String,
        /// Version; the newest where it is missing
        #[arg(value_parser = version)]
        version: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
    /// Let a pinned version go
    Unpin {
        /// Its label
        label: String,
        /// Version; the newest where it is missing
        #[arg(value_parser = version)]
        version: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
    /// Print changes as they happen, and watched paths that become unsafe
    Watch {
        /// Its label; all scenes where it is missing
        label: Option<String>,
        /// End after so many
        #[arg(long)]
        count: Option<u64>,
        #[command(flatten)]
        common: Common,
    },
}

/// Runs a subcommand.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    match &arguments.command {
        Command::List { common } => list(common),
        Command::Show {
            label,
            version,
            common,
        } => show(common, label, *version),
        Command::Diff {
            label,
            from,
            to,
            common,
        } => diff(common, label, *from, *to),
        Command::Apply {
            label,
            file,
            base,
            common,
        } => apply(common, label, file, *base),
        Command::Move {
            label,
            object,
            pose,
            link,
            common,
        } => {
            let diff = words::moved(object, link.as_deref(), &pose.given()?);
            edit(common, label, diff)
        }
        Command::Attach {
            label,
            object,
            link,
            pose,
            touch,
            common,
        } => {
            let diff = words::attached(object, link, &pose.given()?, touch);
            edit(common, label, diff)
        }
        Command::Detach {
            label,
            object,
            pose,
            common,
        } => edit(common, label, words::detached(object, &pose.given()?)),
        Command::Cloud(arguments) => cloud::run(arguments),
        Command::Pin {
            label,
            version,
            common,
        } => pin(common, label, *version, true),
        Command::Unpin {
            label,
            version,
            common,
        } => pin(common, label, *version, false),
        Command::Watch {
            label,
            count,
            common,
        } => events::watch(&common.instance, label.as_deref(), *count, common.format),
    }
}

fn show(common: &Common, label: &str, version: Option<u64>) -> Result<u8, CliError> {
    let planner = common.instance.connect()?;
    let text = planner.show_scene(label, version.unwrap_or(0), 0)?;
    print_text(common, &text, || content(label, &text))
}

fn content(label: &str, text: &SceneText) -> String {
    format!(
        "scene {label} v{}   hash {:016x}{}",
        text.version,
        text.scene_hash,
        table::scene(&text.json)
    )
}

fn diff(common: &Common, label: &str, from: u64, to: Option<u64>) -> Result<u8, CliError> {
    let planner = common.instance.connect()?;
    let text = planner.show_scene(label, to.unwrap_or(0), from)?;
    print_text(common, &text, || changes(label, from, &text))
}

fn changes(label: &str, from: u64, text: &SceneText) -> String {
    format!(
        "scene {label} v{from} → v{}{}",
        text.version,
        table::diff(&text.json)
    )
}

fn apply(common: &Common, label: &str, file: &Path, base: Option<u64>) -> Result<u8, CliError> {
    let (json, base_dir) = read(file)?;
    change(common, label, json, base_dir, base.unwrap_or(0))
}

/// Makes a change to whatever version is the newest.
fn edit(common: &Common, label: &str, diff: String) -> Result<u8, CliError> {
    change(common, label, diff, None, 0)
}

fn list(common: &Common) -> Result<u8, CliError> {
    let scenes = common.instance.connect()?.list()?.scenes;
    print(common.format, &scenes, || lines(&scenes))
}

fn lines(scenes: &[SceneSummary]) -> String {
    let lines: Vec<String> = scenes.iter().map(versions_line).collect();
    lines.join("\n")
}

fn print_text(
    common: &Common,
    text: &SceneText,
    table: impl Fn() -> String,
) -> Result<u8, CliError> {
    match common.format {
        Format::Json => print_line(&text.json)?,
        Format::Table => print_line(&table())?,
    }
    Ok(0)
}

/// The text of a file or of standard input, and the folder that its meshes are found from.
fn read(file: &Path) -> Result<(String, Option<PathBuf>), CliError> {
    let is_standard_input = file.as_os_str() == "-";
    let (text, folder) = match is_standard_input {
        true => (
            std::io::read_to_string(std::io::stdin()),
            std::env::current_dir().ok(),
        ),
        false => (std::fs::read_to_string(file), folder_of(file)),
    };
    let text = text.map_err(|error| FileError::Unreadable {
        file: file.to_owned(),
        reason: error.to_string(),
    })?;
    Ok((diff_text(text, file)?, folder))
}

fn pin(common: &Common, label: &str, version: Option<u64>, pinned: bool) -> Result<u8, CliError> {
    let planner = common.instance.connect()?;
    let scene = planner.pin_scene(label, version.unwrap_or(0), pinned)?;
    print(common.format, &scene, || versions_line(&scene))
}
