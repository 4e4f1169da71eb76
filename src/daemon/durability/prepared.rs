//! Link solids of robots with meshes, made once and kept on disk: they are most of what a large
//! robot takes to warm up. A file is used only if it was written by this very program for this very
//! robot and is whole; else the solids are made anew.

use std::collections::BTreeSet;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use sha2::{Digest, Sha256};
use taut::collision::CollisionModel;
use taut::robot::RobotModel;
use taut::solid::Solid;
use taut::store::PreparedModel;

use crate::daemon::threads::spawn;

/// Bytes of a checksum.
const CHECKSUM: usize = 32;

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

    fn file(&self, robot: u64) -> PathBuf {
        self.folder
            .join(format!("{robot:016x}-{}", self.build))
    }

    /// The model of a robot with nothing around it, of solids that were kept; `None` where there
    /// are none to trust.
    pub(crate) fn find(&self, robot: &Arc<RobotModel>) -> Option<Arc<CollisionModel>> {
        if !Self::has_meshes(robot) {
            return None;
        }
        let bytes = std::fs::read(self.file(robot.hash())).ok()?;
        let payload = whole(&bytes).or_else(|| {
            let name = robot.name();
            tracing::warn!("solids kept for robot {name} are damaged and made anew");
            None
        })?;
        let links = decoded(payload)?;
        CollisionModel::of_links(robot.clone(), links).map(Arc::new)
    }

    /// Makes the file of a robot with nothing around it, unless it is there.
    fn keep(&self, alone: &PreparedModel) -> std::io::Result<()> {
        let robot = alone.robot();
        let file = self.file(robot.hash());
        if !Self::has_meshes(robot) || file.exists() {
            return Ok(());
        }
        // Requests that need it wait for it as this does.
        match alone.get() {
            Ok(alone) => self.write(&file, &encoded(alone)?),
            Err(_) => Ok(()),
        }
    }

    fn write(&self, file: &Path, payload: &[u8]) -> std::io::Result<()> {
        let new = self.folder.join("new");
        std::fs::create_dir_all(&self.folder)?;
        std::fs::write(&new, [&Sha256::digest(payload)[..], payload].concat())?;
        std::fs::rename(&new, file)
    }

    /// Removes the files of other robots and other builds.
    fn retain(&self, robots: &BTreeSet<u64>) {
        let used: BTreeSet<PathBuf> = robots
            .iter()
            .map(|robot| self.file(*robot))
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

    /// Starts the thread that makes files: of `robots` first, and removes all others. It ends when
    /// the sender is dropped.
    pub(crate) fn start(
        self,
        robots: Vec<Arc<PreparedModel>>,
    ) -> std::io::Result<(Sender<Arc<PreparedModel>>, JoinHandle<()>)> {
        let (sender, receiver) = unbounded();
        let thread = spawn("taut-prepared", move || self.work(robots, &receiver))?;
        Ok((sender, thread))
    }

    fn work(self, robots: Vec<Arc<PreparedModel>>, more: &Receiver<Arc<PreparedModel>>) {
        self.retain(
            &robots
                .iter()
                .map(|alone| alone.robot().hash())
                .collect(),
        );
        for alone in robots.into_iter().chain(more) {
            if let Err(error) = self.keep(&alone) {
                tracing::warn!(
                    "the solids of robot {} are not kept, it warms up as slowly again: {error}",
                    alone.robot().name()
                );
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

/// What stands after a checksum that is right.
fn whole(bytes: &[u8]) -> Option<&[u8]> {
    let (checksum, payload) = bytes.split_first_chunk::<CHECKSUM>()?;
    (Sha256::digest(payload)[..] == checksum[..]).then_some(payload)
}

fn decoded(payload: &[u8]) -> Option<Vec<Option<Solid>>> {
    let decoded = bincode::serde::decode_from_slice(payload, config());
    decoded.ok().map(|(links, _)| links)
}

fn encoded(alone: &CollisionModel) -> std::io::Result<Vec<u8>> {
    let links: Vec<Option<&Solid>> = alone.link_solids().collect();
    bincode::serde::encode_to_vec(&links, config()).map_err(std::io::Error::other)
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
        prepared
            .keep(&PreparedModel::alone(robot.clone(), Arc::default()))
            .unwrap();
        let made = CollisionModel::new(robot.clone(), Arc::new(Scene::default())).unwrap();
        let found = prepared.find(&robot).unwrap();
        assert_eq!(format!("{found:?}"), format!("{made:?}"));

        let file = prepared.file(robot.hash());
        let whole = std::fs::read(&file).unwrap();
        for at in [0, CHECKSUM + 5, whole.len() - 1] {
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
        prepared.retain(&BTreeSet::new());
        assert!(!file.exists());
    }
}
