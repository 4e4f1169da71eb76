//! Computing a run again: each request from the same bits, told to end where it was told to end
//! then.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use taut::answer::{self, Part};
use taut::optimize::Workspace;
use taut::store::{PreparedModel, PreparedScene, Snapshot};
use taut_ipc::wire::{ResponseFlags, ResponseHeader, ResponseView};

use super::read::{Recorded, RecordedAnswer, Recording};
use super::{Answer, Question};
use crate::daemon::service::event::Way;
use crate::daemon::service::job::{StopCause, Stopped};

/// What an answer is beside the recorded one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The same to the last bit.
    Equal,
    /// Another; the first difference by name.
    Differs(String),
    /// There is nothing to compare; why.
    NotCompared(&'static str),
}

/// A request that was computed again.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Beside the recorded answer.
    pub verdict: Verdict,
    /// The header of the answer of now; `None` where nothing was computed.
    pub header: Option<ResponseHeader>,
}

/// Computes a run again, from several threads if wanted.
pub struct Replay<'a> {
    run: &'a Recording,
    /// The last model of each robot and scene label, from which the next version's is made.
    models: Mutex<HashMap<(u64, u64), Arc<PreparedModel>>>,
}

impl<'a> Replay<'a> {
    /// Of this run.
    pub fn new(run: &'a Recording) -> Self {
        Self {
            run,
            models: Mutex::default(),
        }
    }

    /// Computes the request of this index again.
    pub fn run(&self, index: usize, workspace: &mut Workspace) -> Replayed {
        let recorded = &self.run.requests[index];
        let without = |why| Replayed {
            verdict: Verdict::NotCompared(why),
            header: None,
        };
        let Some(answer) = &recorded.answer else {
            return without(if recorded.abandoned {
                "its client dropped it"
            } else {
                "no answer is recorded"
            });
        };
        let Way::Computed(stops) = answer.way else {
            return without("it was over before it was begun");
        };
        let question = &recorded.question;
        let snapshot = self.snapshot(question);
        let job = answer::Job {
            snapshot: &snapshot,
            path: &question.path,
            settings: &question.settings,
            timing: question.timing.as_deref(),
        };
        let mut path = again(stops.path);
        let mut times = again(stops.times);
        let mut stop = |part| match part {
            Part::Path => path(),
            Part::Times => times(),
        };
        let computed = answer::answer(job, workspace, &mut stop, &mut |_| {});
        let (header, payload) = Answer {
            reply: computed.reply,
            way: answer.way,
        }
        .encoded();
        let verdict = match difference(answer, header, &payload) {
            None => Verdict::Equal,
            Some(difference) => Verdict::Differs(difference),
        };
        Replayed {
            verdict,
            header: Some(header),
        }
    }

    fn snapshot(&self, question: &Question) -> Snapshot {
        let Question {
            robot,
            scene,
            settings,
            ..
        } = question;
        Snapshot {
            robot: robot.clone(),
            weights: settings
                .weights
                .clone()
                .unwrap_or_default()
                .into(),
            scene: scene.clone(),
            model: self.model(question),
            scene_id: question.scene_id,
            scene_hash: scene.hash(),
            scene_version: question.scene_version,
        }
    }

    fn model(&self, question: &Question) -> Arc<PreparedModel> {
        let Question { robot, scene, .. } = question;
        let mut models = self
            .models
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let key = (robot.hash(), question.scene_id);
        let model = match models.get(&key) {
            Some(model) if model.scene().hash() == scene.hash() => return model.clone(),
            Some(before) => {
                let scene = PreparedScene::after(before.prepared_scene(), scene.clone());
                PreparedModel::after(before, scene.into())
            }
            None => PreparedModel::new(robot.clone(), scene.clone()),
        };
        let model = Arc::new(model);
        models.insert(key, model.clone());
        model
    }
}

/// Tells a part of a job to end when it was told so then.
fn again(stopped: Option<Stopped>) -> impl FnMut() -> Option<StopCause> {
    let mut asked = 0;
    move || {
        asked += 1;
        stopped
            .filter(|stopped| asked >= stopped.asked)
            .map(|stopped| stopped.cause)
    }
}

/// The first difference of two answers in what does not depend on when and where they were
/// computed.
fn difference(recorded: &RecordedAnswer, header: ResponseHeader, payload: &[u8]) -> Option<String> {
    let then = ResponseView::parse(recorded.header, &recorded.payload);
    let now = ResponseView::parse(header, payload);
    let [Ok(then), Ok(now)] = [then, now] else {
        return Some("an answer that is none".to_owned());
    };
    of_verdicts(&then, &now)
        .or_else(|| of_numbers(&then.header, &now.header))
        .or_else(|| of_paths(&then, &now))
        .or_else(|| of_measures(&then.header, &now.header))
        .or_else(|| of_sections(&then, &now))
}

fn differs(name: &str, then: impl std::fmt::Display, now: impl std::fmt::Display) -> String {
    format!("{name} was {then}, is {now}")
}

fn of_verdicts(then: &ResponseView, now: &ResponseView) -> Option<String> {
    if then.code != now.code {
        return Some(differs("code", then.code.name(), now.code.name()));
    }
    (then.termination != now.termination).then(|| {
        let then = format!("{:?}", then.termination);
        differs("termination", then, format!("{:?}", now.termination))
    })
}

fn of_numbers(then: &ResponseHeader, now: &ResponseHeader) -> Option<String> {
    let proved = |header: &ResponseHeader| u64::from(header.flags & ResponseFlags::PROVED);
    let numbers = [
        ("proved", proved(then), proved(now)),
        ("waypoints", then.waypoints.into(), now.waypoints.into()),
        ("iterations", then.iterations, now.iterations),
        ("work", then.work, now.work),
        ("pairs", then.pairs, now.pairs),
        ("robot_hash", then.robot_hash, now.robot_hash),
        ("scene_hash", then.scene_hash, now.scene_hash),
        ("times", then.times.into(), now.times.into()),
    ];
    let (name, then, now) = numbers
        .into_iter()
        .find(|(_, then, now)| then != now)?;
    Some(differs(name, then, now))
}

fn of_paths(then: &ResponseView, now: &ResponseView) -> Option<String> {
    let mut numbers = then.path.iter().zip(now.path);
    let place = numbers.position(|(a, b)| a.to_bits() != b.to_bits())?;
    let variables = then.header.variables.max(1) as usize;
    let name = format!(
        "waypoint {}, column {}",
        place / variables,
        place % variables
    );
    Some(differs(&name, then.path[place], now.path[place]))
}

fn of_measures(then: &ResponseHeader, now: &ResponseHeader) -> Option<String> {
    let measures = [
        ("length_before", then.length_before, now.length_before),
        ("length_after", then.length_after, now.length_after),
        ("lower_bound", then.lower_bound, now.lower_bound),
        ("clearance_m", then.clearance_m, now.clearance_m),
        ("floor_m", then.floor_m, now.floor_m),
        ("searched_m", then.searched_m, now.searched_m),
    ];
    let is_other = |(_, then, now): &(&str, f64, f64)| then.to_bits() != now.to_bits();
    let (name, then, now) = measures.into_iter().find(is_other)?;
    Some(differs(name, then, now))
}

fn of_sections(then: &ResponseView, now: &ResponseView) -> Option<String> {
    let sections = sections(then).into_iter().zip(sections(now));
    let ((name, then), (_, now)) = sections
        .into_iter()
        .find(|(then, now)| then != now)?;
    Some(format!(
        "section {name} of {} bytes is another, of {} bytes",
        then.len(),
        now.len()
    ))
}

/// The bytes of every section but the path.
fn sections<'a>(view: &ResponseView<'a>) -> [(&'static str, &'a [u8]); 24] {
    use bytemuck::cast_slice as bytes;
    let trajectory = &view.trajectory;
    [
        ("certificate", bytes(view.certificate)),
        ("certificate_head", bytes_of(view.certificate_head)),
        ("lowered_floors", bytes(view.lowered_floors)),
        ("holds", bytes(view.holds)),
        ("reach", bytes(view.reach)),
        ("stages", bytes(view.stages)),
        ("turned_columns", bytes(view.turned_columns)),
        ("pinched", bytes(view.pinched)),
        ("keeps", bytes(view.keeps)),
        ("constraints", view.constraints.as_bytes()),
        ("constraint_claims", bytes(view.constraint_claims)),
        ("trajectory", bytes_of(trajectory.head)),
        ("trajectory_times", bytes(trajectory.times_ns)),
        ("trajectory_positions", bytes(trajectory.positions)),
        ("trajectory_velocities", bytes(trajectory.velocities)),
        ("trajectory_accelerations", bytes(trajectory.accelerations)),
        ("trajectory_limits", bytes(trajectory.limits)),
        ("trajectory_used", bytes(trajectory.used)),
        ("trajectory_floors", bytes(trajectory.lowered_floors)),
        ("trajectory_nearest", bytes_of(trajectory.nearest)),
        ("refusal", bytes_of(view.refusal)),
        ("warnings", bytes(view.warnings)),
        ("names", view.names.as_bytes()),
        ("message", view.message.as_bytes()),
    ]
}

fn bytes_of<T: bytemuck::NoUninit>(record: Option<&T>) -> &[u8] {
    record.map_or(&[], bytemuck::bytes_of)
}

/// What tells one request of a run from the others, for lists.
impl std::fmt::Display for Recorded {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (scene, version) = self.scene();
        let id = self.request_id();
        let mode = self.mode();
        let robot = self.robot();
        let waypoints = self.waypoints();
        write!(
            f,
            "{id:016x}   {mode} {robot} in {scene} v{version}   {waypoints} waypoints"
        )
    }
}
