//! Where robots and scenes come from, where the problems do not bring them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use taut::files::{Packages, Reader};

use crate::values;

/// Where the robot and the scene come from.
#[derive(Clone, clap::Args)]
pub(super) struct Source {
    /// URDF of a bare path's robot; an SRDF of the same name beside the URDF is read too
    #[arg(long, value_name = "URDF", conflicts_with = "problem")]
    pub robot: Option<PathBuf>,
    /// SRDF of the robot, where it is not beside the URDF
    #[arg(long, value_name = "SRDF", requires = "robot")]
    pub srdf: Option<PathBuf>,
    /// Scene of a bare path (JSON, YAML or MoveIt's .scene text), or a problem file whose scene to
    /// take; without it there is no obstacle
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
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = values::package)]
    packages: Vec<(String, PathBuf)>,
    /// Model of the robot: its own shapes, or the spheres of a problem that has them
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryChoice,
}

/// Which of a problem's models of the robot to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum GeometryChoice {
    /// Spheres where the problem has them; else the given shapes
    #[default]
    Auto,
    /// The robot's own shapes
    Given,
    /// The sphere model
    Spheres,
}

impl Source {
    /// Folders of packages by name; a later one of the same name wins.
    pub(super) fn packages(&self) -> BTreeMap<String, PathBuf> {
        self.packages.iter().cloned().collect()
    }

    /// The same with another choice of the robot's model.
    pub(super) fn with(&self, geometry: GeometryChoice) -> Self {
        Self {
            geometry,
            ..self.clone()
        }
    }

    /// A reader that knows these packages and those of the environment.
    pub(super) fn reader(&self) -> Reader {
        Reader::new(Packages::with_environment(self.packages()))
    }
}
