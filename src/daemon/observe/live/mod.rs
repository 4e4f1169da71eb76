//! What the daemon's own page shows: what runs, and the last answers with all that is needed to
//! look at them.
//!
//! Workers enter what they compute, the service its figures with each status message; the page's
//! thread reads and makes pictures of it. Each holds the lock for a few copies only.

mod http;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use taut::constraint::ConstraintsFile;
use taut::files::ResultFile;
use taut::files::result::{ResultSubject, RobotSource, SceneSource, rows};
use taut::optimize::Outcome;
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::Scene;
use taut_ipc::control::ClientSummary;
use taut_ipc::monotonic_ns;
use taut_ipc::wire::Code;

use crate::daemon::service::job::{Asked, Job};
use crate::view::{Picture, Sight};

pub(crate) use http::answer;
pub use http::check_address;

/// Answers that are kept.
const ANSWERS: usize = 40;
/// Numbers in the paths of the answers that are kept (8 bytes each): 32 MB.
const NUMBERS: usize = 4 << 20;
/// Times and lengths of one answer that are kept; of more every second is left out.
const LENGTHS: usize = 512;

/// Everything that is shown; any thread may use it.
pub(crate) struct Live {
    instance: String,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    stats: BTreeMap<String, f64>,
    clients: Vec<ClientSummary>,
    running: BTreeMap<u64, Run>,
    /// The oldest first.
    answers: VecDeque<Arc<Answer>>,
}

/// A request that is being computed.
struct Run {
    asked: Asked,
    mode: &'static str,
    received_ns: u64,
    length_before: f64,
    lengths: Vec<(f64, f64)>,
}

/// An answer, as it came from the core.
struct Answer {
    number: u64,
    request_id: u64,
    asked: Asked,
    mode: &'static str,
    code: Code,
    time_s: f64,
    lengths: Vec<(f64, f64)>,
    input: Path,
    outcome: Outcome,
    robot: Arc<RobotModel>,
    scene: Arc<Scene>,
    scene_version: u64,
    unwrapped: bool,
    held: Option<Vec<f64>>,
    constraints: ConstraintsFile,
}

#[derive(Serialize)]
struct Shown<'a> {
    instance: &'a str,
    stats: &'a BTreeMap<String, f64>,
    clients: &'a [ClientSummary],
    running: Vec<ShownRun<'a>>,
    answers: Vec<ShownAnswer<'a>>,
}

#[derive(Serialize)]
struct ShownRun<'a> {
    #[serde(flatten)]
    asked: &'a Asked,
    mode: &'static str,
    age_s: f64,
    length_before: f64,
    length: Option<f64>,
}

#[derive(Serialize)]
struct ShownAnswer<'a> {
    #[serde(flatten)]
    asked: &'a Asked,
    number: u64,
    mode: &'static str,
    code: &'static str,
    proved: bool,
    length_before: f64,
    length_after: f64,
    clearance_m: Option<f64>,
}

impl Live {
    /// Nothing yet, of the instance of this name.
    pub(crate) fn new(instance: &str) -> Self {
        Self {
            instance: instance.to_owned(),
            state: Mutex::default(),
        }
    }

    /// The service's figures.
    pub(crate) fn counted(&self, stats: BTreeMap<String, f64>, clients: Vec<ClientSummary>) {
        let mut state = self.lock();
        state.stats = stats;
        state.clients = clients;
    }

    /// A worker begins with a job.
    pub(crate) fn begin(&self, job: &Job) {
        self.lock().running.insert(job.id, Run::of(job));
    }

    /// It found a shorter path.
    pub(crate) fn improved(&self, job: u64, length_before: f64, length: f64) {
        if let Some(run) = self.lock().running.get_mut(&job) {
            run.length_before = length_before;
            run.improved(monotonic_ns(), length);
        }
    }

    /// It has an answer.
    pub(crate) fn answered(&self, job: &Job, outcome: &Outcome, code: Code) {
        if let Ok(model) = job.snapshot.model.get() {
            let lengths = self.take_lengths(job.id);
            let mut answer = Answer::of(job, model.scene().clone(), outcome, code);
            answer.lengths = lengths;
            self.lock().keep(Arc::new(answer));
        }
    }

    /// Times and lengths of a run that ends.
    fn take_lengths(&self, job: u64) -> Vec<(f64, f64)> {
        match self.lock().running.get_mut(&job) {
            Some(run) => std::mem::take(&mut run.lengths),
            None => Vec::new(),
        }
    }

    /// A worker has done with a job, however it ended.
    pub(crate) fn ended(&self, job: u64) {
        self.lock().running.remove(&job);
    }

    /// What is shown of everything, as JSON.
    fn json(&self) -> String {
        let state = self.lock();
        let shown = state.shown(&self.instance, monotonic_ns());
        serde_json::to_string(&shown).expect("only strings and numbers")
    }

    /// The picture of an answer, as JSON; `None` where it is not kept any more.
    fn picture(&self, number: u64) -> Option<String> {
        let answer = self.answer(number)?;
        Some(serde_json::to_string(&answer.picture()).expect("only strings and numbers"))
    }

    fn answer(&self, number: u64) -> Option<Arc<Answer>> {
        let state = self.lock();
        let mut answers = state.answers.iter();
        answers
            .find(|answer| answer.number == number)
            .cloned()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Keeps an answer; the oldest make room.
    fn keep(&mut self, answer: Arc<Answer>) {
        self.answers.push_back(answer);
        while self.is_overfull() {
            self.answers.pop_front();
        }
    }

    fn is_overfull(&self) -> bool {
        let count = self.answers.len();
        count > ANSWERS || (count > 1 && self.numbers() > NUMBERS)
    }

    /// Numbers in the paths of all answers.
    fn numbers(&self) -> usize {
        let answers = self.answers.iter();
        answers.map(|answer| answer.numbers()).sum()
    }

    fn shown<'a>(&'a self, instance: &'a str, now_ns: u64) -> Shown<'a> {
        let running = self.running.values();
        let answers = self.answers.iter().rev();
        Shown {
            instance,
            stats: &self.stats,
            clients: &self.clients,
            running: running.map(|run| run.shown(now_ns)).collect(),
            answers: answers.map(|answer| answer.shown()).collect(),
        }
    }
}

impl Run {
    /// Of many lengths every second is left out.
    fn improved(&mut self, now_ns: u64, length: f64) {
        let time_s = seconds(self.received_ns, now_ns);
        self.lengths.push((time_s, length));
        if self.lengths.len() > LENGTHS {
            self.thin_out();
        }
    }

    fn thin_out(&mut self) {
        let mut index = 0;
        self.lengths
            .retain(|_| (index % 2 == 0, index += 1).0);
    }

    fn of(job: &Job) -> Self {
        Self {
            asked: job.asked.clone(),
            mode: job.settings.mode.name(),
            received_ns: job.received_ns,
            length_before: 0.0,
            lengths: Vec::new(),
        }
    }

    fn shown(&self, now_ns: u64) -> ShownRun<'_> {
        ShownRun {
            asked: &self.asked,
            mode: self.mode,
            age_s: seconds(self.received_ns, now_ns),
            length_before: self.length_before,
            length: self.lengths.last().map(|(_, length)| *length),
        }
    }
}

impl Answer {
    fn of(job: &Job, scene: Arc<Scene>, outcome: &Outcome, code: Code) -> Self {
        Self {
            number: job.id,
            request_id: job.request_id,
            asked: job.asked.clone(),
            mode: job.settings.mode.name(),
            code,
            time_s: seconds(job.received_ns, monotonic_ns()),
            lengths: Vec::new(),
            input: Path::clone(&job.path),
            outcome: outcome.clone(),
            robot: job.snapshot.robot.clone(),
            scene,
            scene_version: job.snapshot.scene_version,
            unwrapped: job.settings.unwrapped,
            held: job.settings.held.clone(),
            constraints: job.settings.constraints.clone(),
        }
    }

    /// Numbers in its paths.
    fn numbers(&self) -> usize {
        self.input.as_flat().len() + self.outcome.path.as_flat().len()
    }

    fn shown(&self) -> ShownAnswer<'_> {
        let outcome = &self.outcome;
        let certificate = outcome.certificate.as_ref();
        ShownAnswer {
            asked: &self.asked,
            number: self.number,
            mode: self.mode,
            code: self.code.name(),
            proved: outcome.proved,
            length_before: outcome.length_before,
            length_after: outcome.length_after,
            clearance_m: certificate.and_then(|certificate| certificate.clearance_m()),
        }
    }

    fn picture(&self) -> Picture {
        Picture::of(Sight {
            result: self.result(),
            robot: &self.robot,
            scene: &self.scene,
            visuals: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn result(&self) -> ResultFile {
        let variables = self.robot.variables().iter();
        ResultFile {
            name: format!("{} in {}", self.asked.robot, self.asked.scene),
            mode: self.mode.to_owned(),
            geometry: "loaded".to_owned(),
            code: self.code.into(),
            code_name: self.code.name().to_owned(),
            request_id: Some(format!("{:016x}", self.request_id)),
            time_s: self.time_s,
            lengths_over_time: self.lengths.clone(),
            variables: variables
                .map(|variable| variable.name.clone())
                .collect(),
            path_before: rows(&self.input),
            path_constraints: self.constraints.clone(),
            subject: self.subject(),
            ..ResultFile::of(&self.outcome)
        }
    }

    fn subject(&self) -> ResultSubject {
        ResultSubject {
            robot: self.robot_source(),
            scene: self.scene_source(),
            unwrapped: self.unwrapped,
            held: self.held_by_name(),
        }
    }

    fn robot_source(&self) -> RobotSource {
        RobotSource {
            label: Some(self.asked.robot.clone()),
            hash: format!("{:016x}", self.robot.hash()),
            files: None,
        }
    }

    fn scene_source(&self) -> SceneSource {
        SceneSource {
            label: Some(self.asked.scene.clone()),
            version: Some(self.scene_version),
            hash: format!("{:016x}", self.scene.hash()),
            ..SceneSource::default()
        }
    }

    fn held_by_name(&self) -> BTreeMap<String, f64> {
        let values = self.held.iter().flatten();
        let held = values.zip(self.robot.held());
        held.map(|(value, of)| (of.name.clone(), *value))
            .collect()
    }
}

/// Seconds from one time to another.
fn seconds(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}
