//! Writing a run: each robot, scene and mesh once, before the first request that needs it.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use taut::robot::RobotModel;
use taut::scene::Scene;
use taut::shape::{Cloud, Mesh, PlacedShape};

use super::record::{AnswerRecord, RequestRecord, RunRecord};
use super::{Answer, Question};
use crate::daemon::durability::persisted::{
    CloudRecord, MeshRecord, PoseRecord, RUN, RobotRecord, SceneRecord, SettingsRecord,
    TimingRecord, moves_between,
};
use crate::daemon::durability::record_log;

/// A file that is being written.
pub(super) struct RunWriter {
    file: File,
    /// Bytes so far.
    pub bytes: u64,
    written: HashSet<u64>,
    /// The last scene of each label.
    scenes: HashMap<u64, Arc<Scene>>,
}

impl RunWriter {
    /// Begins a file; one that is there is replaced.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn create(path: &Path) -> Result<Self, String> {
        let mut file = File::create(path).map_err(|error| error.to_string())?;
        let start = RUN.start();
        file.write_all(&start)
            .map_err(|error| error.to_string())?;
        let mut writer = Self {
            file,
            bytes: start.len() as u64,
            written: HashSet::new(),
            scenes: HashMap::new(),
        };
        writer.write(&RunRecord::Written(facts()))?;
        Ok(writer)
    }

    /// Writes a record in one piece.
    pub(super) fn write(&mut self, record: &RunRecord) -> Result<(), String> {
        let mut bytes = Vec::new();
        record_log::encode(record, &mut bytes)?;
        self.file
            .write_all(&bytes)
            .map_err(|error| error.to_string())?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Writes a request, and what it needs first.
    pub(super) fn request(&mut self, question: &Question) -> Result<(), String> {
        let robot = &question.robot;
        let scene = &question.scene;
        if self.written.insert(robot.hash()) {
            self.robot(robot)?;
        }
        if self.written.insert(scene.hash()) {
            self.large(
                scene
                    .objects()
                    .flat_map(|object| object.shapes.iter()),
            )?;
            self.scene(question.scene_id, scene)?;
        }
        self.scenes
            .insert(question.scene_id, scene.clone());
        self.write(&RunRecord::Request(Box::new(question.into())))
    }

    fn robot(&mut self, robot: &RobotModel) -> Result<(), String> {
        self.large(
            robot
                .links()
                .iter()
                .flat_map(|link| &link.shapes),
        )?;
        self.write(&RunRecord::Robot {
            hash: robot.hash(),
            robot: RobotRecord::from(robot),
        })
    }

    /// A scene of which only something moved is written as that.
    fn scene(&mut self, scene_id: u64, scene: &Arc<Scene>) -> Result<(), String> {
        let hash = scene.hash();
        let moved = self
            .scenes
            .get(&scene_id)
            .and_then(|base| Some((base.hash(), moved_between(base, scene)?)));
        match moved {
            Some((base, moved)) => self.write(&RunRecord::Moved { hash, base, moved }),
            None => self.write(&RunRecord::Scene {
                hash,
                scene: SceneRecord::from(&**scene),
            }),
        }
    }

    /// Writes what shapes name by its hash.
    fn large<'a>(&mut self, shapes: impl Iterator<Item = &'a PlacedShape>) -> Result<(), String> {
        for placed in shapes {
            if let Some(mesh) = placed.shape.mesh()
                && self.written.insert(mesh.hash())
            {
                self.mesh(mesh)?;
            }
            if let Some(cloud) = placed.shape.cloud()
                && self.written.insert(cloud.hash())
            {
                self.cloud(cloud)?;
            }
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &Mesh) -> Result<(), String> {
        self.write(&RunRecord::Mesh {
            hash: mesh.hash(),
            mesh: MeshRecord::from(mesh),
        })
    }

    fn cloud(&mut self, cloud: &Cloud) -> Result<(), String> {
        self.write(&RunRecord::Cloud {
            hash: cloud.hash(),
            cloud: CloudRecord::from(cloud),
        })
    }

    /// Writes an answer.
    pub(super) fn answer(&mut self, number: u64, answer: &Answer) -> Result<(), String> {
        let (header, payload) = answer.encoded();
        let record = AnswerRecord {
            number,
            way: answer.way.into(),
            header: bytemuck::bytes_of(&header).to_vec(),
            payload,
        };
        self.write(&RunRecord::Answer(Box::new(record)))
    }
}

/// Who writes.
fn facts() -> BTreeMap<String, String> {
    let facts = [
        ("taut", env!("CARGO_PKG_VERSION")),
        ("machine", std::env::consts::ARCH),
    ];
    BTreeMap::from(facts.map(|(name, value)| (name.to_owned(), value.to_owned())))
}

impl From<&Question> for RequestRecord {
    fn from(question: &Question) -> Self {
        Self {
            number: question.number,
            request_id: question.request_id,
            client: question.client,
            received_ns: question.received_ns,
            deadline_ns: question.deadline_ns.unwrap_or(0),
            priority: question.priority,
            robot_hash: question.robot.hash(),
            scene_hash: question.scene.hash(),
            scene_id: question.scene_id,
            scene_version: question.scene_version,
            settings: SettingsRecord::from(&*question.settings),
            timing: question
                .timing
                .as_deref()
                .map(TimingRecord::from),
            columns: question.path.nq(),
            path: question.path.as_flat().to_vec(),
        }
    }
}

/// Objects of the world that are elsewhere in `after`, if nothing else differs.
fn moved_between(before: &Scene, after: &Scene) -> Option<Vec<(String, PoseRecord)>> {
    let moves = moves_between(before, after)?;
    let ids: Vec<&String> = after
        .obstacles()
        .iter()
        .map(|object| &object.id)
        .collect();
    let moved = moves.into_iter().map(|(index, pose)| {
        let id = *ids.get(index as usize)?;
        Some((id.clone(), pose))
    });
    moved.collect()
}
