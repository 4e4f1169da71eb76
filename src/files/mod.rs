//! The only reader of robot, scene and problem files. The core gets what it reads, never a path.
//!
//! Everything that cannot be read gives one line: the file, the line where it is known, the value,
//! the valid values and the next step.

mod columns;
mod constraints;
mod door;
mod limits;
mod planning_scene;
mod problem;
pub mod result;
mod robot_files;
mod srdf_of;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod timing;
mod trajectory;
mod vamp;
mod yaml;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use constraints::constraints_of;
pub use door::GivenFiles;
use door::{Door, stand_in};
pub use limits::{Acceleration, LimitsFile, limits_text};
pub use problem::{Geometry, Kind, Peer, Problem};
pub use result::ResultFile;
pub use robot_files::{RobotFiles, RootJoint};
pub use srdf_of::srdf_of;
pub use table::PathTable;
pub use taut_packages::Packages;
use text::read as read_text;
pub use timing::{TIMING_WORDS, Timing};
pub use trajectory::{Trajectory, TrajectoryPoint};

use crate::math::Vec3;
use crate::robot::{RobotDescription, RobotError, srdf, urdf};
use crate::scene::diff_file::{DiffFile, SceneDiff};
use crate::scene::scene_file::SceneFile;
use crate::scene::{Scene, SceneError, moveit_scene, with_nearest};
use crate::shape::{Mesh, MeshError, mesh_file};
use crate::warning::Warning;

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file is not there or cannot be read.
    #[error("{}: {reason}", file.display())]
    Unreadable {
        /// File.
        file: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// It is not among the files that were given.
    #[error("{}: it is not among the files that were given", .0.display())]
    NotGiven(PathBuf),
    /// A URDF or SRDF, or the robot that they make.
    #[error("{}: {source}", file.display())]
    Robot {
        /// File.
        file: PathBuf,
        /// What is wrong.
        source: RobotError,
    },
    /// A scene.
    #[error("{}: {source}", file.display())]
    Scene {
        /// File.
        file: PathBuf,
        /// What is wrong.
        source: SceneError,
    },
    /// Anything else that a file says wrongly.
    #[error("{}: {text}", file.display())]
    Content {
        /// File.
        file: PathBuf,
        /// What is wrong, with line and valid values where known.
        text: String,
    },
}

impl FileError {
    /// What a file says wrongly.
    pub fn content(file: &Path, text: String) -> Self {
        let file = file.to_owned();
        Self::Content { file, text }
    }
}

/// Reads files; keeps every mesh that it has read, since problems share robots.
#[derive(Debug, Default)]
pub struct Reader {
    packages: Packages,
    door: Door,
    meshes: HashMap<(PathBuf, [u64; 3]), Arc<Mesh>>,
}

impl Reader {
    /// A reader that finds `package://` names with `packages`.
    pub fn new(packages: Packages) -> Self {
        Self {
            packages,
            ..Self::default()
        }
    }

    /// A reader that reads nothing but these files.
    pub fn given(files: GivenFiles) -> Self {
        Self {
            door: Door::Given(files, BTreeSet::new()),
            ..Self::default()
        }
    }

    /// Names of files that were asked for and not given: what was read without them is not what it
    /// should be.
    pub fn wanted(&self) -> Vec<String> {
        self.door.wanted()
    }

    /// Reads a robot. Its virtual joint is the SRDF's; without an SRDF its root is fixed.
    ///
    /// # Errors
    /// A file that cannot be read, or is no URDF or SRDF.
    pub fn robot(
        &mut self,
        urdf: &Path,
        srdf: Option<&Path>,
    ) -> Result<RobotDescription, FileError> {
        self.robot_with(urdf, srdf, &BTreeMap::new())
    }

    /// The same with packages that go before the reader's own.
    fn robot_with(
        &mut self,
        urdf: &Path,
        srdf: Option<&Path>,
        packages: &BTreeMap<String, PathBuf>,
    ) -> Result<RobotDescription, FileError> {
        let (text, odd) = self.xml(urdf)?;
        let packages = self.packages.with(packages);
        let folder = folder_of(urdf);
        let mut meshes = |name: &str, scale| self.mesh(name, scale, &packages, folder);
        let mut robot = urdf::parse(&text, &mut meshes).map_err(|source| FileError::Robot {
            file: urdf.to_owned(),
            source,
        })?;
        robot.warnings.extend(
            odd.into_iter()
                .map(|text| Warning::cosmetic("text", text)),
        );
        if let Some(srdf) = srdf {
            let (text, odd) = self.xml(srdf)?;
            let (semantics, warnings) =
                srdf::parse(&text, &robot).map_err(|source| FileError::Robot {
                    file: srdf.to_owned(),
                    source,
                })?;
            let odd = odd
                .into_iter()
                .map(|text| Warning::cosmetic("text", text));
            let warnings = odd
                .chain(warnings)
                .map(|warning| warning.reworded(format!("SRDF: {warning}")));
            robot.warnings.extend(warnings);
            robot.virtual_joint = semantics.virtual_joint.clone();
            robot.semantics = Some(semantics);
        }
        Ok(robot)
    }

    /// The text of an XML file, and what is odd about it.
    fn xml(&mut self, file: &Path) -> Result<(String, Option<String>), FileError> {
        let bytes = self.door.bytes(file)?;
        text::xml(&bytes).map_err(|text| FileError::content(file, text))
    }

    /// Reads a scene file (JSON, YAML or MoveIt's `.scene` text), or the scene of a problem file.
    /// Meshes are found beside it.
    ///
    /// # Errors
    /// A file that cannot be read or holds no scene.
    pub fn scene(&mut self, file: &Path) -> Result<Scene, FileError> {
        self.selected_scene(file, None)
    }

    /// The same; of several problems of VAMP's, the scene of the one that is `selected` as
    /// `SET:INDEX`.
    ///
    /// # Errors
    /// As [`Self::scene`], and a file that does not have what is selected.
    pub fn selected_scene(
        &mut self,
        file: &Path,
        selected: Option<&str>,
    ) -> Result<Scene, FileError> {
        let text = read_text(file)?;
        let text = translated(&text, file, selected)?.unwrap_or(text);
        self.scene_of_text(&text, file)
    }

    /// The same from a text; `file` is what messages call it, and meshes are found beside it.
    ///
    /// # Errors
    /// A text that holds no scene, or meshes that cannot be used.
    pub fn scene_of_text(&mut self, text: &str, file: &Path) -> Result<Scene, FileError> {
        #[derive(serde::Deserialize)]
        struct Probe {
            scene: Option<serde::de::IgnoredAny>,
        }
        #[derive(serde::Deserialize)]
        struct Holder {
            scene: SceneFile,
        }
        if is_moveit_scene(text, file) {
            return moveit_scene::parse(text).map_err(|source| FileError::Scene {
                file: file.to_owned(),
                source,
            });
        }
        // A first look tells the two apart, so that what is then wrong is said of the right one.
        let is_problem =
            serde_json::from_str::<Probe>(text).is_ok_and(|probe| probe.scene.is_some());
        let scene = match is_problem {
            true => serde_json::from_str::<Holder>(text).map(|holder| holder.scene),
            false => serde_json::from_str(text),
        };
        let scene = scene.map_err(|error| FileError::Scene {
            file: file.to_owned(),
            source: SceneError::Syntax(with_nearest(&format!("not a scene: {error}"))),
        })?;
        self.build_scene(scene, file, &BTreeMap::new())
    }

    /// Reads a diff from its text; `file` is what messages call it, and meshes are found beside it.
    ///
    /// # Errors
    /// A text that holds no diff, or meshes that cannot be used.
    pub fn diff_of_text(&mut self, text: &str, file: &Path) -> Result<SceneDiff, FileError> {
        let packages = self.packages.clone();
        let folder = folder_of(file);
        let diff = DiffFile::parse(text).and_then(|mut diff| {
            diff.read_clouds(&mut |name| self.bytes_of(name, &packages, folder))?;
            diff.build(&mut |name, scale| self.mesh(name, scale, &packages, folder))
        });
        diff.map_err(|source| FileError::Scene {
            file: file.to_owned(),
            source,
        })
    }

    fn build_scene(
        &mut self,
        mut scene: SceneFile,
        file: &Path,
        packages: &BTreeMap<String, PathBuf>,
    ) -> Result<Scene, FileError> {
        let packages = self.packages.with(packages);
        let folder = folder_of(file);
        let read = scene.read_clouds(&mut |name| self.bytes_of(name, &packages, folder));
        let mut meshes = |name: &str, scale| self.mesh(name, scale, &packages, folder);
        read.and_then(|()| scene.build(&mut meshes))
            .map_err(|source| FileError::Scene {
                file: file.to_owned(),
                source,
            })
    }

    /// The bytes of a file that the robot or scene in `folder` calls so; none where nobody gave it
    /// yet.
    fn bytes_of(
        &mut self,
        name: &str,
        packages: &Packages,
        folder: &Path,
    ) -> Result<Option<Vec<u8>>, String> {
        let file = self.door.find(name, packages, folder)?;
        let bytes = self.door.found(name, &file)?;
        Ok(bytes.map(std::borrow::Cow::into_owned))
    }

    /// Reads a mesh once per scale. `name` is the file as the robot or scene in `folder` calls it.
    fn mesh(
        &mut self,
        name: &str,
        scale: Vec3,
        packages: &Packages,
        folder: &Path,
    ) -> Result<Arc<Mesh>, MeshError> {
        let refuse = |reason: String| MeshError::Unreadable {
            name: name.to_owned(),
            reason,
        };
        let file = self
            .door
            .find(name, packages, folder)
            .map_err(refuse)?;
        let key = (file, scale.to_array().map(f64::to_bits));
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let bytes = self.door.found(name, &key.0).map_err(refuse)?;
        let Some(bytes) = bytes else {
            return stand_in(name);
        };
        let mesh = Arc::new(mesh_file::read(name, &bytes, scale)?);
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }
}

/// Whether a text is JSON's object, or an object's beginning.
fn begins_an_object(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}');
    text.trim_start().starts_with('{')
}

/// Whether a scene is MoveIt's text: its file says so, or it has objects as only that has. A text
/// that was sent to another process has lost its file's name.
fn is_moveit_scene(text: &str, file: &Path) -> bool {
    let named = file
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("scene"));
    !begins_an_object(text) && (named || text.lines().any(|line| line.starts_with('*')))
}

/// The text of a scene file, or the JSON of the scene in a problem file, as it stands: unchecked.
///
/// # Errors
/// A file that cannot be read.
pub fn scene_text(file: &Path) -> Result<String, FileError> {
    selected_scene_text(file, None)
}

/// The JSON of a scene in another form: YAML, or the problem of VAMP's that is selected; `None`
/// where it is in none.
fn translated(
    text: &str,
    file: &Path,
    selected: Option<&str>,
) -> Result<Option<String>, FileError> {
    let translated = if yaml::is_yaml(file) {
        Some(planning_scene::json(text))
    } else if vamp::is_problems(text) {
        Some(vamp::Problem::select(text, selected).and_then(|problem| problem.scene()))
    } else {
        None
    };
    translated
        .transpose()
        .map_err(|text| FileError::content(file, text))
}

/// The same as [`scene_text`]; of several problems of VAMP's, the scene of the one that is
/// `selected` as `SET:INDEX`.
///
/// # Errors
/// As [`scene_text`], and a file that does not have what is selected.
pub fn selected_scene_text(file: &Path, selected: Option<&str>) -> Result<String, FileError> {
    let text = read_text(file)?;
    if let Some(translated) = translated(&text, file, selected)? {
        return Ok(translated);
    }
    let scene = serde_json::from_str::<serde_json::Value>(&text)
        .ok()
        .and_then(|value| value.get("scene").cloned());
    // Floats keep their bits on the way through a value.
    Ok(scene.map_or(text, |scene| scene.to_string()))
}

/// The JSON of a diff from the text of a file, which is YAML by its name or its first letter.
///
/// # Errors
/// YAML that is no diff.
pub fn diff_text(text: String, file: &Path) -> Result<String, FileError> {
    let is_json = text
        .trim_start_matches('\u{feff}')
        .trim_start()
        .starts_with(['{', '[']);
    if !yaml::is_yaml(file) && (is_json || text.trim().is_empty()) {
        return Ok(text);
    }
    planning_scene::diff_json(&text).map_err(|text| FileError::content(file, text))
}

/// Folder that the relative names in a file start from.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
