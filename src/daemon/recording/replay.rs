//! Computing a run again: each request from the same bits, told to end where it was told to end
//! then.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use taut::answer;
use taut::optimize::Workspace;
use taut::store::{PreparedModel, Snapshot};
use taut_ipc::wire::{Code, ResponseFlags, ResponseHeader, ResponseView};

use super::read::{Recorded, RecordedAnswer, Recording};
use super::{Answer, Question};
use crate::daemon::event::Way;

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
        let Way::Computed(stopped) = answer.way else {
            return without("it was over before it was begun");
        };
        let question = &recorded.question;
        let snapshot = self.snapshot(question);
        let job = answer::Job {
            snapshot: &snapshot,
            path: &question.path,
            settings: &question.settings,
        };
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            stopped
                .filter(|stopped| asked >= stopped.asked)
                .map(|stopped| stopped.cause)
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
            weights: settings.weights.clone().unwrap_or_default().into(),
            scene: scene.clone(),
            model: self.model(question),
            scene_id: question.scene_id,
            scene_hash: scene.hash(),
            scene_version: question.scene_version,
        }
    }

    fn model(&self, question: &Question) -> Arc<PreparedModel> {
        let Question { robot, scene, .. } = question;
        let mut models = self.models.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (robot.hash(), question.scene_id);
        let model = match models.get(&key) {
            Some(model) if model.scene().hash() == scene.hash() => return model.clone(),
            Some(before) => PreparedModel::after(before, scene.clone()),
            None => PreparedModel::new(robot.clone(), scene.clone()),
        };
        let model = Arc::new(model);
        models.insert(key, model.clone());
        model
    }
}

/// The first difference of two answers in what does not depend on when and where they were
/// computed.
fn difference(recorded: &RecordedAnswer, header: ResponseHeader, payload: &[u8]) -> Option<String> {
    let views = [(recorded.header, &*recorded.payload), (header, payload)]
        .map(|(h, p)| ResponseView::parse(h, p));
    let [Ok(then), Ok(now)] = views else {
        return Some("an answer that is none".to_owned());
    };
    let code = |view: &ResponseView| Code::name(view.code);
    let proved = |header: &ResponseHeader| u64::from(header.flags & ResponseFlags::PROVED);
    let a = &then.header;
    let b = &now.header;
    let numbers = [
        ("proved", proved(a), proved(b)),
        ("waypoints", a.waypoints.into(), b.waypoints.into()),
        ("iterations", a.iterations, b.iterations),
        ("work", a.work, b.work),
        ("pairs", a.pairs, b.pairs),
        ("robot_hash", a.robot_hash, b.robot_hash),
        ("scene_hash", a.scene_hash, b.scene_hash),
    ];
    let measures = [
        ("length_before", a.length_before, b.length_before),
        ("length_after", a.length_after, b.length_after),
        ("lower_bound", a.lower_bound, b.lower_bound),
        ("clearance_m", a.clearance_m, b.clearance_m),
        ("floor_m", a.floor_m, b.floor_m),
        ("searched_m", a.searched_m, b.searched_m),
    ];
    let sections = [
        (
            "certificate",
            bytemuck::cast_slice(then.certificate),
            bytemuck::cast_slice(now.certificate),
        ),
        (
            "certificate_head",
            bytes_of(then.certificate_head),
            bytes_of(now.certificate_head),
        ),
        (
            "lowered_pairs",
            bytemuck::cast_slice(then.lowered_pairs),
            bytemuck::cast_slice(now.lowered_pairs),
        ),
        (
            "active_contacts",
            bytemuck::cast_slice(then.active_contacts),
            bytemuck::cast_slice(now.active_contacts),
        ),
        (
            "reach",
            bytemuck::cast_slice(then.reach),
            bytemuck::cast_slice(now.reach),
        ),
        (
            "stages",
            bytemuck::cast_slice(then.stages),
            bytemuck::cast_slice(now.stages),
        ),
        (
            "turned_columns",
            bytemuck::cast_slice(then.turned_columns),
            bytemuck::cast_slice(now.turned_columns),
        ),
        (
            "pinched_pairs",
            bytemuck::cast_slice(then.pinched_pairs),
            bytemuck::cast_slice(now.pinched_pairs),
        ),
        ("refusal", bytes_of(then.refusal), bytes_of(now.refusal)),
        (
            "warnings",
            bytemuck::cast_slice(then.warnings),
            bytemuck::cast_slice(now.warnings),
        ),
        ("names", then.names.as_bytes(), now.names.as_bytes()),
        ("message", then.message.as_bytes(), now.message.as_bytes()),
    ];
    let differs = |name: &str, then: &dyn std::fmt::Display, now: &dyn std::fmt::Display| {
        Some(format!("{name} was {then}, is {now}"))
    };
    if then.code != now.code {
        return differs("code", &code(&then), &code(&now));
    }
    if then.termination != now.termination {
        return differs(
            "termination",
            &format!("{:?}", then.termination),
            &format!("{:?}", now.termination),
        );
    }
    let unequal = numbers.iter().find(|(_, then, now)| then != now);
    let unequal = unequal.and_then(|(name, then, now)| differs(name, then, now));
    let path = || {
        let place = then
            .path
            .iter()
            .zip(now.path)
            .position(|(a, b)| a.to_bits() != b.to_bits())?;
        let row = place / a.variables.max(1) as usize;
        let column = place % a.variables.max(1) as usize;
        differs(
            &format!("waypoint {row}, column {column}"),
            &then.path[place],
            &now.path[place],
        )
    };
    let measured = || {
        let unequal = measures
            .iter()
            .find(|(_, then, now)| then.to_bits() != now.to_bits());
        unequal.and_then(|(name, then, now)| differs(name, then, now))
    };
    let section = || {
        let (name, then, now) = sections.iter().find(|(_, then, now)| then != now)?;
        Some(format!(
            "section {name} of {} bytes is another, of {} bytes",
            then.len(),
            now.len()
        ))
    };
    unequal.or_else(path).or_else(measured).or_else(section)
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
