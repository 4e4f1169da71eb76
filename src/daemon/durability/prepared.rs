//! Link solids of robots with meshes, made once and kept on disk: they are most of what a large
//! robot takes to warm up. A file is used only if it was written by this very program for this very
//! robot and is whole; else the solids are made anew.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};
use taut::collision::CollisionModel;
use taut::robot::RobotModel;
use taut::solid::Solid;

/// Bytes of a checksum.
const CHECKSUM: usize = 32;
/// Bytes that are written at once.
const BUFFER: usize = 1 << 16;

/// The folder of such files.
#[derive(Clone)]
pub(crate) struct Prepared {
    folder: PathBuf,
    /// Changes with every build of this program: another one may make other solids of the same
    /// robot.
    build: String,
}

impl Prepared {
    /// The files in a state folder.
    pub(crate) fn new(state: &Path) -> Self {
        Self {
            folder: state.join("prepared"),
            build: format!("{}-{}", env!("CARGO_PKG_VERSION"), this_file()),
        }
    }

    /// Whether it is worth a file.
    fn has_meshes(robot: &RobotModel) -> bool {
        let mut shapes = robot
            .links()
            .iter()
            .flat_map(|link| &link.shapes);
        shapes.any(|placed| placed.shape.mesh().is_some())
    }

    /// Robots of the same shapes, of which other joints are variables, share one.
    fn file(&self, robot: &RobotModel) -> PathBuf {
        let shapes = robot.shapes_hash();
        self.folder
            .join(format!("{shapes:016x}-{}", self.build))
    }

    /// The model of a robot with nothing around it, of solids that were kept; `None` where there
    /// are none to trust.
    pub(crate) fn find(&self, robot: &Arc<RobotModel>) -> Option<Arc<CollisionModel>> {
        if !Self::has_meshes(robot) {
            return None;
        }
        let bytes = std::fs::read(self.file(robot)).ok()?;
        let payload = whole(&bytes).or_else(|| {
            let name = robot.name();
            tracing::warn!("solids kept for robot {name} are damaged and made anew");
            None
        })?;
        let links = decoded(payload)?;
        CollisionModel::of_links(robot.clone(), links).map(Arc::new)
    }

    /// Makes the file of a robot with nothing around it, unless it is there.
    pub(crate) fn keep(&self, alone: &CollisionModel) {
        let robot = alone.robot();
        let file = self.file(robot);
        if !Self::has_meshes(robot) || file.exists() {
            return;
        }
        if let Err(error) = self.write(&file, alone) {
            let name = robot.name();
            tracing::warn!(
                "the solids of robot {name} are not kept, it warms up as slowly again: {error}"
            );
        }
    }

    fn write(&self, file: &Path, alone: &CollisionModel) -> std::io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        // Its name is its own: robots may be kept at once.
        let new = file.with_extension("new");
        encode(alone, File::create(&new)?)?;
        std::fs::rename(&new, file)
    }

    /// Removes the files of all but these robots, and of other builds.
    pub(crate) fn retain(&self, robots: &[&Arc<RobotModel>]) {
        let used: BTreeSet<PathBuf> = robots
            .iter()
            .map(|robot| self.file(robot))
            .collect();
        let entries = std::fs::read_dir(&self.folder);
        let paths = entries.into_iter().flatten().flatten();
        for path in paths.map(|entry| entry.path()) {
            if !used.contains(&path) {
                // One that stays takes room and does no harm.
                let _ = std::fs::remove_file(path);
            }
        }
    }
}

/// Size and time of this program's file; nothing where the system does not tell.
fn this_file() -> String {
    let meta = std::env::current_exe().and_then(std::fs::metadata);
    meta.map_or_else(
        |_| String::new(),
        |m| format!("{:x}-{:x}-{:x}", m.len(), m.mtime(), m.mtime_nsec()),
    )
}

/// What stands before a checksum that is right.
fn whole(bytes: &[u8]) -> Option<&[u8]> {
    let (payload, checksum) = bytes.split_last_chunk::<CHECKSUM>()?;
    (Sha256::digest(payload)[..] == checksum[..]).then_some(payload)
}

/// What is written, and its checksum.
struct Summed {
    file: File,
    sum: Sha256,
}

impl Write for Summed {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// Writes the solids of links, then their checksum.
fn encode(alone: &CollisionModel, file: File) -> std::io::Result<()> {
    let links: Vec<Option<&Solid>> = alone.link_solids().collect();
    let sum = Sha256::new();
    let mut writer = BufWriter::with_capacity(BUFFER, Summed { file, sum });
    bincode::serde::encode_into_std_write(&links, &mut writer, config())
        .map_err(std::io::Error::other)?;
    let Summed { mut file, sum } = writer
        .into_inner()
        .map_err(|error| error.into_error())?;
    file.write_all(&sum.finalize())
}

fn decoded(payload: &[u8]) -> Option<Vec<Option<Solid>>> {
    let decoded = bincode::serde::decode_from_slice(payload, config());
    decoded.ok().map(|(links, _)| links)
}

fn config() -> impl bincode::config::Config {
    bincode::config::standard().with_fixed_int_encoding()
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut::math::{Pose, Vec3};
    use taut::robot::{LinkDescription, RobotDescription};
    use taut::scene::Scene;
    use taut::shape::{Mesh, PlacedShape, Shape};

    fn robot() -> Arc<RobotModel> {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let mesh = Mesh::new(
            "part",
            corners,
            vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        )
        .unwrap();
        let collision = vec![PlacedShape {
            pose: Pose::identity(),
            shape: Shape::Mesh(Arc::new(mesh)),
        }];
        let links = vec![LinkDescription {
            name: "base".into(),
            collision,
        }];
        Arc::new(
            RobotModel::new(RobotDescription {
                links,
                ..RobotDescription::default()
            })
            .unwrap(),
        )
    }

    #[test]
    fn solids_come_back_as_they_were_made_and_nothing_else_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let prepared = Prepared::new(folder.path());
        let robot = robot();
        assert!(prepared.find(&robot).is_none());
        let made = CollisionModel::new(robot.clone(), Arc::new(Scene::default())).unwrap();
        prepared.keep(&made);
        let found = prepared.find(&robot).unwrap();
        assert_eq!(format!("{found:?}"), format!("{made:?}"));

        let file = prepared.file(&robot);
        let whole = std::fs::read(&file).unwrap();
        for at in [0, whole.len() - CHECKSUM - 5, whole.len() - 1] {
            let mut wrong = whole.clone();
            wrong[at] ^= 1;
            std::fs::write(&file, wrong).unwrap();
            assert!(prepared.find(&robot).is_none(), "byte {at}");
        }
        std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
        assert!(prepared.find(&robot).is_none());
        std::fs::write(&file, &whole).unwrap();
        assert!(prepared.find(&robot).is_some());
        let other = Prepared {
            build: "another".into(),
            ..prepared.clone()
        };
        assert!(other.find(&robot).is_none());
        prepared.retain(&[]);
        assert!(!file.exists());
    }
}
