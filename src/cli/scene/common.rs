//! What subcommands of `taut scene` have in common: the daemon, and a change that it makes.

use std::path::PathBuf;

use taut_ipc::control::SceneSummary;

use crate::cli::error::CliError;
use crate::cli::format::Format;
use crate::cli::instance::InstanceChoice;
use crate::cli::models::{print, scene_line};
use crate::cli::report::listed;

/// Which daemon, and how it is printed.
#[derive(clap::Args)]
pub(super) struct Common {
    #[command(flatten)]
    pub(super) instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
}

/// Makes a diff's change.
pub(super) fn change(
    common: &Common,
    label: &str,
    json: String,
    base_dir: Option<PathBuf>,
    base_version: u64,
) -> Result<u8, CliError> {
    let planner = common.instance.connect()?;
    let scene = planner.change_scene(label, &json, base_dir.as_deref(), base_version)?;
    print(common.format, &scene, || versions_line(&scene))
}

/// A scene and the versions of it that are kept.
pub(super) fn versions_line(scene: &SceneSummary) -> String {
    format!(
        "{}   kept from v{}{}",
        scene_line(scene),
        scene.kept_from,
        pinned(scene)
    )
}

fn pinned(scene: &SceneSummary) -> String {
    let versions = scene.pinned.iter();
    listed("   pinned ", versions.map(|version| format!("v{version}")))
}
