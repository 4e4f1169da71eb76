//! Where the robot and the scene come from.

use std::path::{Path, PathBuf};

use super::quantity;

/// The choice on the command line.
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

/// The absolute folder of a file, for a daemon that was started elsewhere.
pub(super) fn folder_of(file: &Path) -> Option<PathBuf> {
    std::path::absolute(file)
        .ok()?
        .parent()
        .map(Path::to_owned)
}
