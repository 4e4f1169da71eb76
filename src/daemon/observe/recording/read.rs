//! Reading a run, and checking that what it holds is what it says.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::robot::RobotModel;
use taut::scene::{Scene, SceneChange};
use taut::shape::{Cloud, Mesh};
use taut_ipc::wire::{Code, ResponseHeader, ResponseView};

use super::Question;
use super::record::{AnswerRecord, RequestRecord, RunRecord};
use crate::daemon::durability::persisted::{Apart, Find, PoseRecord, RUN, RobotRecord};
use crate::daemon::service::event::Way;

/// Why a run cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The system.
    #[error("{}: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Its bytes.
    #[error("{}: {text}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        text: String,
    },
}

impl RecordingError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::Unreadable { .. } => Code::UnreadableFile,
            Self::Content { .. } => Code::InvalidModel,
        }
    }
}

/// A run.
pub struct Recording {
    /// Facts about who wrote it: release, machine.
    pub written: BTreeMap<String, String>,
    /// What the daemon told of its requests, where it is a bundle.
    pub story: String,
    /// Requests in the order in which they came.
    pub requests: Vec<Recorded>,
    /// Requests and answers that were left out; `None` where the recording did not end in order.
    pub missed: Option<u64>,
    /// Bytes of a record that was not finished.
    pub torn: usize,
}

/// A request, and what became of it.
pub struct Recorded {
    pub(super) question: Question,
    pub(super) answer: Option<RecordedAnswer>,
    /// Whether its client dropped it.
    pub abandoned: bool,
}

/// An answer as its client got it.
pub(super) struct RecordedAnswer {
    pub way: Way,
    pub header: ResponseHeader,
    pub payload: Vec<u8>,
}

impl Recorded {
    /// Its client's id of it.
    pub fn request_id(&self) -> u64 {
        self.question.request_id
    }
    /// Name of the robot.
    pub fn robot(&self) -> &str {
        self.question.robot.name()
    }
    /// Name of the scene, and its version then.
    pub fn scene(&self) -> (&str, u64) {
        (self.question.scene.name(), self.question.scene_version)
    }
    /// Name of the mode.
    pub fn mode(&self) -> &'static str {
        self.question.settings.mode.name()
    }
    /// Waypoints of the input.
    pub fn waypoints(&self) -> usize {
        self.question.path.len()
    }
    /// The header of its answer, where it had one.
    pub fn header(&self) -> Option<&ResponseHeader> {
        self.answer
            .as_ref()
            .map(|answer| &answer.header)
    }
}

impl Recording {
    /// Reads a file that `taut record` or `taut why --bundle` wrote. One that was not finished is
    /// read as far as it goes.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another version.
    pub fn read(file: &Path) -> Result<Self, RecordingError> {
        let name = || file.to_owned();
        let bytes = std::fs::read(file).map_err(|source| RecordingError::Unreadable {
            file: name(),
            source,
        })?;
        parse(&bytes).map_err(|text| RecordingError::Content { file: name(), text })
    }

    fn new(torn: usize) -> Self {
        Self {
            written: BTreeMap::new(),
            story: String::new(),
            requests: Vec::new(),
            missed: None,
            torn,
        }
    }
}

/// A run from the bytes of its file.
pub(super) fn parse(bytes: &[u8]) -> Result<Recording, String> {
    let contents = RUN.parse(bytes)?;
    let mut reading = Reading::new(Recording::new(contents.torn));
    for record in contents.records {
        reading.take(record)?;
    }
    Ok(reading.run)
}

/// What stands before the records that name it.
#[derive(Default)]
struct Large {
    meshes: HashMap<u64, Arc<Mesh>>,
    clouds: HashMap<u64, Arc<Cloud>>,
}

impl Find for Large {
    fn mesh(&mut self, hash: u64) -> Result<Arc<Mesh>, String> {
        found(&self.meshes, "mesh", hash)
    }

    fn cloud(&mut self, hash: u64) -> Result<Arc<Cloud>, String> {
        found(&self.clouds, "cloud", hash)
    }
}

struct Reading {
    large: Large,
    robots: HashMap<u64, Arc<RobotModel>>,
    scenes: HashMap<u64, Arc<Scene>>,
    /// The last request of each number: a watch is checked again and again under one.
    newest: HashMap<u64, usize>,
    run: Recording,
}

impl Reading {
    fn new(run: Recording) -> Self {
        Self {
            large: Large::default(),
            robots: HashMap::new(),
            scenes: HashMap::new(),
            newest: HashMap::new(),
            run,
        }
    }

    fn take(&mut self, record: RunRecord) -> Result<(), String> {
        match record {
            RunRecord::Written(facts) => self.run.written = facts,
            RunRecord::Story(text) => self.run.story = text,
            RunRecord::Mesh { hash, mesh } => {
                let mesh = Arc::new(mesh.restore(hash)?);
                self.large.meshes.insert(hash, mesh);
            }
            RunRecord::Cloud { hash, cloud } => {
                let cloud = Arc::new(Cloud::restored(cloud, hash)?);
                self.large.clouds.insert(hash, cloud);
            }
            RunRecord::Robot { hash, robot } => self.robot(hash, robot)?,
            RunRecord::Scene { hash, scene } => {
                let scene = scene.restore(&mut self.large)?;
                self.scene(hash, scene)?;
            }
            RunRecord::Moved { hash, base, moved } => self.scene(hash, self.moved(base, moved)?)?,
            RunRecord::Request(request) => self.request(*request)?,
            RunRecord::Answer(answer) => self.answer(*answer)?,
            RunRecord::Abandoned { number } => self.asked(number)?.abandoned = true,
            RunRecord::Ended { missed } => self.run.missed = Some(missed),
        }
        Ok(())
    }

    fn robot(&mut self, hash: u64, robot: RobotRecord) -> Result<(), String> {
        let model = robot.restore(&mut self.large)?;
        same("robot", hash, model.hash())?;
        self.robots.insert(hash, Arc::new(model));
        Ok(())
    }

    fn scene(&mut self, hash: u64, scene: Scene) -> Result<(), String> {
        same("scene", hash, scene.hash())?;
        self.scenes.insert(hash, Arc::new(scene));
        Ok(())
    }

    /// The scene that is another one but for where some objects are.
    fn moved(&self, base: u64, moved: Vec<(String, PoseRecord)>) -> Result<Scene, String> {
        let moves = moved
            .into_iter()
            .map(|(id, pose)| SceneChange::Move {
                id,
                pose: pose.into(),
            });
        let base = found(&self.scenes, "scene", base)?;
        base.with(moves)
            .map_err(|error| error.to_string())
    }

    fn request(&mut self, request: RequestRecord) -> Result<(), String> {
        let question = self.question(request)?;
        self.newest
            .insert(question.number, self.run.requests.len());
        self.run.requests.push(Recorded {
            question,
            answer: None,
            abandoned: false,
        });
        Ok(())
    }

    fn question(&self, request: RequestRecord) -> Result<Question, String> {
        let number = request.number;
        let path = taut::path::Path::from_rows(request.columns, request.path);
        let path = path.ok_or_else(|| format!("request {number} has no whole rows"));
        Ok(Question {
            number,
            request_id: request.request_id,
            client: request.client,
            received_ns: request.received_ns,
            deadline_ns: (request.deadline_ns != 0).then_some(request.deadline_ns),
            priority: request.priority,
            robot: found(&self.robots, "robot", request.robot_hash)?,
            scene: found(&self.scenes, "scene", request.scene_hash)?,
            scene_id: request.scene_id,
            scene_version: request.scene_version,
            settings: Arc::new(request.settings.into()),
            timing: request
                .timing
                .map(|timing| Arc::new(timing.into())),
            path: Arc::new(path?),
            is_recorded: true,
        })
    }

    fn answer(&mut self, answer: AnswerRecord) -> Result<(), String> {
        let number = answer.number;
        let header: ResponseHeader = bytemuck::try_pod_read_unaligned(&answer.header)
            .map_err(|error| format!("the answer to request {number} has no header: {error}"))?;
        // Sections are read in place; they start at multiples of their alignment.
        ResponseView::parse(header, &answer.payload)
            .map_err(|error| format!("the answer to request {number}: {error}"))?;
        self.asked(number)?.answer = Some(RecordedAnswer {
            way: answer.way.into(),
            header,
            payload: answer.payload,
        });
        Ok(())
    }

    fn asked(&mut self, number: u64) -> Result<&mut Recorded, String> {
        let index = self
            .newest
            .get(&number)
            .ok_or_else(|| format!("an answer to request {number}, which is not there"))?;
        Ok(&mut self.run.requests[*index])
    }
}

fn found<T>(known: &HashMap<u64, Arc<T>>, what: &str, hash: u64) -> Result<Arc<T>, String> {
    known
        .get(&hash)
        .cloned()
        .ok_or_else(|| format!("the {what} {hash:016x} is named before it stands there"))
}

fn same(what: &str, named: u64, is: u64) -> Result<(), String> {
    if named == is {
        Ok(())
    } else {
        Err(format!(
            "a {what} that should have hash {named:016x} has {is:016x}"
        ))
    }
}
