//! The service: robots and scenes of this process, and the work on paths.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::planner::{Ending, Service, Tell};
use taut_ipc::wire::{Code, RequestHeader, RequestView, ResponseBody, label_id};

use super::models::Models;
use crate::answer::{self, Found, Job, Part};
use crate::optimize::{Improvement, Settings, Workspace};
use crate::robot::RobotModel;
use crate::scene::Scene;
use crate::store::ModelStore;
use crate::translate::{self, Lengths, Reply, StopCause};

/// Robots and scenes of this process, and the work on paths.
#[derive(Debug)]
pub struct LocalService {
    models: Models,
    /// One request's memory, for the next.
    workspace: Mutex<Option<Workspace>>,
}

impl Default for LocalService {
    fn default() -> Self {
        Self {
            models: Models::new(ModelStore::new(label_id)),
            workspace: Mutex::default(),
        }
    }
}

impl LocalService {
    /// Takes a robot and a scene that are made already and need not be read again, and puts them
    /// together, so that no request has to wait for it.
    ///
    /// # Errors
    /// Labels that are taken, a robot and a scene that do not go together.
    pub fn insert(
        &self,
        (robot_label, robot): (&str, &Arc<RobotModel>),
        (scene_label, scene): (&str, &Arc<Scene>),
    ) -> Result<(), Refusal> {
        let read = translate::read_robot(robot.clone())?;
        self.models
            .take_robot(robot_label, read, false)?;
        self.models
            .take_scene(scene_label, scene.clone(), false)?;
        let snapshot = self
            .models
            .snapshot(&translate::wanted_newest(robot_label, scene_label))?;
        let model = snapshot.model.get();
        let model = model.map_err(|error| translate::model_refusal(error, robot));
        model.map(drop)
    }

    /// Works on a request and tells of its improvements.
    fn compute(
        &self,
        request: &RequestView<'_>,
        ending: &Ending,
        tell: &Tell<'_>,
    ) -> Result<Reply, Refusal> {
        let header = &request.header;
        check_watch(header)?;
        let snapshot = self
            .models
            .snapshot(&translate::wanted(header))?;
        translate::check_layout(header, &snapshot)?;
        translate::check_seen(&snapshot, header, monotonic_ns())?;
        let question = translate::question(request, &snapshot, Settings::DEFAULT_CLEARANCE_M)?;
        let job = Job {
            snapshot: &snapshot,
            path: &question.path,
            settings: &question.settings,
            timing: question.timing.as_deref(),
        };
        Ok(self.answered(job, header, ending, tell))
    }

    fn answered(
        &self,
        job: Job,
        header: &RequestHeader,
        ending: &Ending,
        tell: &Tell<'_>,
    ) -> Reply {
        let mut lengths = Lengths::new(job.snapshot, job.settings, job.path);
        let mut publish = |found: Found| match found {
            Found::Path(improvement) => improved(job, &mut lengths, &improvement, tell),
            Found::Times(reply) => tell(&reply.header, &reply.body()),
        };
        let mut workspace = self.workspace().take().unwrap_or_default();
        let end_of_path_ns = match job.timing {
            Some(_) => answer::end_of_path_ns(monotonic_ns(), header.deadline_ns),
            None => header.deadline_ns,
        };
        let mut stop = |part| match part {
            Part::Path => over(end_of_path_ns, ending),
            Part::Times => over(header.deadline_ns, ending),
        };
        let answered = answer::answer(job, &mut workspace, &mut stop, &mut publish);
        *self.workspace() = Some(workspace);
        let mut reply = answered.reply;
        let seen = job.snapshot.scene.oldest_frame();
        reply.header.world_age_ns = seen.map_or(0, |(_, frame)| frame.age_ns(monotonic_ns()));
        reply
    }

    fn workspace(&self) -> MutexGuard<'_, Option<Workspace>> {
        self.workspace
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Service for LocalService {
    fn control(&self, message: ControlRequest) -> ControlReply {
        self.models
            .answer(message)
            .unwrap_or_else(ControlReply::Refused)
    }

    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>) {
        let received_ns = monotonic_ns();
        let reply = self.compute(request, ending, tell);
        let mut reply = reply.unwrap_or_else(translate::refused);
        reply.header.compute_ns = monotonic_ns().saturating_sub(received_ns);
        tell(&reply.header, &reply.body());
    }
}

fn check_watch(header: &RequestHeader) -> Result<(), Refusal> {
    if !header.watch() {
        return Ok(());
    }
    let text = "a path is watched by a daemon only; check it again after each change";
    Err(Refusal::new(Code::MalformedRequest, text))
}

fn is_late(deadline_ns: u64) -> bool {
    deadline_ns != 0 && monotonic_ns() >= deadline_ns
}

fn over(deadline_ns: u64, ending: &Ending) -> Option<StopCause> {
    match ending.asked() {
        Some(true) => Some(StopCause::FinishedEarly),
        Some(false) => Some(StopCause::Cancelled),
        None => is_late(deadline_ns).then_some(StopCause::Deadline),
    }
}

fn improved(job: Job, lengths: &mut Lengths<'_>, improvement: &Improvement<'_>, tell: &Tell<'_>) {
    let lengths = lengths.of(improvement.length);
    let asks_times = job.timing.is_some();
    let header = translate::progress(job.snapshot, improvement, lengths, asks_times);
    let body = ResponseBody {
        path: improvement.path.as_flat(),
        ..ResponseBody::default()
    };
    tell(&header, &body);
}
