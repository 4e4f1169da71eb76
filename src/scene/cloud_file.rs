//! Clouds and octomaps as texts have them: a file and what is made of it, or the cells themselves.
//!
//! Their files are read before the scene is built ([`CloudFile::read`]), by whoever has a disk.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::SceneError;
use super::numbers::Finite;
use super::pose_file::PoseFile;
use crate::math::Pose;
use crate::shape::Cloud;
use crate::shape::cloud::{CloudKind, CloudParts, Making, Provenance, Source, Unknown};
use crate::shape::sensed::{Draft, Octomap};
use crate::warning::Warning;

/// Gives the bytes of a file (named as the scene does); none where nobody gave it yet.
pub type ByteSource<'a> = dyn FnMut(&str) -> Result<Option<Vec<u8>>, String> + 'a;

/// A cloud, or an octomap, of an object.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CloudFile {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    file: String,
    /// Where the file's frame is in the object's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pose: Option<PoseFile>,
    /// Of a cloud's points (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<Finite>,
    /// Edge of the cells (m) that keep one point each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    thin: Option<Finite>,
    /// What unknown space of an octomap is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unknown: Option<String>,
    /// Hash of its content in hexadecimal digits; a cloud of another content is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    /// The cells themselves, which are then not read from the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    content: Option<Box<ContentFile>>,
    #[serde(skip)]
    made: Option<Arc<Cloud>>,
}

/// The cells of a cloud, bit for bit.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ContentFile {
    /// Of points (m); cells of a map have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    origin: [f64; 3],
    rounding: f64,
    cells: Vec<[f32; 4]>,
    numbers: Vec<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unknown_from: Option<usize>,
    /// What does not follow from a verdict, a line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    uncovered: Vec<String>,
}

/// Which of an object's words it stands behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Cloud,
    Octomap,
}

impl Word {
    /// The word under which a cloud is written.
    pub(super) fn of(cloud: &Cloud) -> Self {
        match cloud.kind() {
            CloudKind::Points { .. } => Self::Cloud,
            CloudKind::Voxels => Self::Octomap,
        }
    }
}

impl CloudFile {
    /// What makes a cloud again: its file, or with `with_content` (or where there is no such file)
    /// its cells.
    pub(super) fn of(cloud: &Cloud, with_content: bool) -> Self {
        let provenance = cloud.provenance();
        let source = provenance.source.as_ref();
        let mut words = source.map(Self::of_source).unwrap_or_default();
        words.hash = Some(format!("{:016x}", cloud.hash()));
        if with_content || source.is_none() {
            words.content = Some(Box::new(ContentFile::of(cloud)));
        }
        words
    }

    /// The words of a source.
    pub(super) fn of_source(source: &Source) -> Self {
        let mut words = Self {
            file: source.file.clone(),
            ..Self::default()
        };
        match source.making {
            Making::Points { radius, thin } => {
                words.radius = Some(Finite(radius));
                words.thin = thin.map(Finite);
            }
            Making::Map { unknown } => words.unknown = Some(unknown.word().to_owned()),
        }
        words
    }

    /// A cloud that is there already.
    pub(super) fn made(cloud: Cloud) -> Self {
        Self {
            made: Some(Arc::new(cloud)),
            ..Self::default()
        }
    }

    /// The same elsewhere in its object.
    pub(super) fn at(self, pose: &Pose) -> Self {
        let is_set = *pose != Pose::identity();
        Self {
            pose: is_set.then(|| PoseFile::of(pose)),
            ..self
        }
    }

    /// Where it is in its object.
    pub(super) fn pose(&self, id: &str) -> Result<Pose, SceneError> {
        let built = self.pose.map(|pose| pose.build(id, "cloud"));
        built.unwrap_or_else(|| Ok(Pose::identity()))
    }

    /// Whether its file has to be read.
    pub(super) fn names_file(&self) -> bool {
        self.content.is_none() && self.made.is_none()
    }

    /// Reads its file, if that has to be read. One that nobody gave yet stands as a point.
    pub(super) fn read(
        &mut self,
        id: &str,
        word: Word,
        bytes: &mut ByteSource<'_>,
    ) -> Result<(), SceneError> {
        if !self.names_file() || self.file.is_empty() {
            return Ok(());
        }
        let made = match bytes(&self.file) {
            Ok(Some(bytes)) => self.make(word, &bytes),
            Ok(None) => Cloud::of_points([[0.0; 3]], 1.0).map_err(|error| error.to_string()),
            Err(reason) => Err(format!("{}: {reason}", self.file)),
        };
        let cloud = made.map_err(|reason| SceneError::Cloud {
            id: id.to_owned(),
            reason,
        })?;
        self.made = Some(Arc::new(cloud));
        Ok(())
    }

    fn make(&self, word: Word, bytes: &[u8]) -> Result<Cloud, String> {
        self.draft(word, bytes)?.cloud()
    }

    fn draft(&self, word: Word, bytes: &[u8]) -> Result<Draft, String> {
        let file = self.file.clone();
        match word {
            Word::Cloud => {
                self.check_cloud()?;
                let radius = self.radius.map_or(f64::NAN, |radius| radius.0);
                let thin = self.thin.map(|edge| edge.0);
                let making = Making::Points { radius, thin };
                Draft::read(Source { file, making }, bytes)
            }
            Word::Octomap => {
                self.check_map()?;
                let map = Octomap::read(&file, bytes)?;
                let unknown = unknown(self.unknown.as_deref(), &file, &map)?;
                let making = Making::Map { unknown };
                Draft::of_map(Source { file, making }, &map, unknown)
            }
        }
    }

    /// Refuses what only a map can have.
    fn check_cloud(&self) -> Result<(), String> {
        match self.unknown.as_deref() {
            None | Some("free") => Ok(()),
            Some(_) => Err(
                "a cloud of points does not say what was seen, its unknown space can only be \"free\"; give an octomap"
                    .to_owned(),
            ),
        }
    }

    /// Refuses what only points can have.
    fn check_map(&self) -> Result<(), String> {
        match (self.radius, self.thin) {
            (None, None) => Ok(()),
            _ => {
                Err("an octomap's cells have their own size; leave out radius and thin".to_owned())
            }
        }
    }

    /// The cloud, once its file is read.
    pub(super) fn build(&self, id: &str) -> Result<Arc<Cloud>, SceneError> {
        let refuse = |reason| SceneError::Cloud {
            id: id.to_owned(),
            reason,
        };
        let cloud = match (&self.made, &self.content) {
            (Some(made), _) => made.clone(),
            (None, Some(content)) => Arc::new(self.restored(content).map_err(refuse)?),
            (None, None) if self.file.is_empty() => {
                return Err(refuse("a cloud of nothing; give its file".to_owned()));
            }
            (None, None) => {
                let text = format!("{}: files are not read here; give its content", self.file);
                return Err(refuse(text));
            }
        };
        let found = format!("{:016x}", cloud.hash());
        match &self.hash {
            Some(wanted) if *wanted != found => Err(refuse(format!(
                "{}: its content has hash {found}, not {wanted}; give the file that is meant",
                self.file
            ))),
            _ => Ok(cloud),
        }
    }

    /// The cloud of cells that a text has. A file that it names too made all of them.
    fn restored(&self, content: &ContentFile) -> Result<Cloud, String> {
        let unknown = self.unknown.as_deref();
        let making = match (self.radius, unknown.and_then(Unknown::named)) {
            (Some(radius), _) => Some(Making::Points {
                radius: radius.0,
                thin: self.thin.map(|edge| edge.0),
            }),
            (None, Some(unknown)) => Some(Making::Map { unknown }),
            (None, None) => None,
        };
        let source = making
            .filter(|_| !self.file.is_empty())
            .map(|making| Source {
                file: self.file.clone(),
                making,
            });
        content.restored(source)
    }
}

impl ContentFile {
    fn of(cloud: &Cloud) -> Self {
        let CloudParts {
            kind,
            origin,
            rounding,
            cells,
            numbers,
        } = cloud.parts();
        let radius = match kind {
            CloudKind::Points { radius } => Some(radius),
            CloudKind::Voxels => None,
        };
        let Provenance {
            unknown_from,
            warnings,
            ..
        } = cloud.provenance();
        let uncovered = warnings
            .iter()
            .filter(|warning| warning.is_uncovered());
        Self {
            radius,
            origin,
            rounding,
            cells,
            numbers,
            unknown_from: *unknown_from,
            uncovered: uncovered.map(Warning::to_string).collect(),
        }
    }

    fn restored(&self, source: Option<Source>) -> Result<Cloud, String> {
        let kind = self
            .radius
            .map_or(CloudKind::Voxels, |radius| CloudKind::Points { radius });
        let parts = CloudParts {
            kind,
            origin: self.origin,
            rounding: self.rounding,
            cells: self.cells.clone(),
            numbers: self.numbers.clone(),
        };
        let cloud = Cloud::restore(&parts).map_err(|error| error.to_string())?;
        let warnings = self.uncovered.iter().map(Warning::uncovered);
        Ok(cloud.with_provenance(Provenance {
            source,
            unknown_from: self.unknown_from,
            warnings: warnings.collect(),
        }))
    }
}

/// What unknown space of a map is, which has to be said.
pub(super) fn unknown(said: Option<&str>, name: &str, map: &Octomap) -> Result<Unknown, String> {
    let words = "\"unknown\": \"free\" (paths may cross it, as MoveIt lets them) or \"obstacle\" (they may not)";
    match said {
        None => Err(format!(
            "octomap {name} has {} unknown cells of {} m within its bounds, and all space outside them is unknown; say {words}",
            crate::warning::grouped(map.unknown_within() as usize),
            map.resolution()
        )),
        Some(word) => Unknown::named(word)
            .ok_or_else(|| format!("octomap {name}: unknown is {word:?}; valid: {words}")),
    }
}
