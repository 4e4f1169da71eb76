//! One request from end to end: check, prove the input, optimize.

use super::answer::Answer;
use super::best::Best;
use super::input::Input;
use super::mode::Mode;
use super::outcome::{Outcome, Termination};
use super::progress::Progress;
use super::question::Question;
use super::refused;
use super::request_error::RequestError;
use super::restorer::Restorer;
use super::settings::Settings;
use super::task::{Improvement, Task};
use crate::collision::{CollisionModel, reach_weights};
use crate::path::Path;
use crate::robot::Kinematics;
use crate::validation::path_proof::{self, PathVerdict};
use crate::validation::{HitReason, Proved, Scratch, Validator};

/// Reusable memory of a worker; every request starts from the same state whatever ran before.
#[derive(Debug, Default)]
pub struct Workspace {
    scratch: Scratch,
    kinematics: Kinematics,
}

/// Work that a request gets which names no budget.
pub const DEFAULT_WORK_BUDGET: u64 = 200_000_000;

/// Runs a request.
///
/// `stop` is asked often and ends the run with the best path so far; `publish` gets every strictly
/// shorter proved path as it is found, each with the ends of the input, bit for bit. Same model,
/// path and settings give the same answer, bit for bit, as long as `stop` keeps still.
///
/// # Errors
/// A request that cannot be computed as it stands. A path that collides is no error but an answer.
pub fn run(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    workspace: &mut Workspace,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> Result<Outcome, RequestError> {
    let robot = model.robot();
    let input = Input::new(model, path, settings, &reach_weights(robot, model.bodies()))?;
    let mut question = Question {
        model,
        path,
        settings,
        input: &input,
    };
    let kinematics = &mut workspace.kinematics;
    kinematics.update(robot, path.waypoint(0), &input.held);
    if let Some((bodies, contact)) = model.static_contact(kinematics) {
        let refusal = refused::standing_overlap(bodies, contact, settings.clearance_m);
        return Ok(Answer::refused(&question, refusal).into_outcome(&question));
    }
    let scratch = &mut workspace.scratch;
    let mut validator = Validator::new(
        model,
        &input.space,
        &input.held,
        settings.clearance_m,
        scratch,
    )
    .with_layers(settings.layers)
    .with_constraints(&input.constraints);
    if model.uncheckable().is_none() {
        let answer = answer(&question, &mut validator, stop, publish);
        return Ok(answer.into_outcome(&question));
    }
    let checked = Settings {
        mode: Mode::Check,
        contacts: false,
        ..settings.clone()
    };
    question.settings = &checked;
    let answer = answer(&question, &mut validator, stop, publish).unproved_still();
    question.settings = settings;
    Ok(answer.into_outcome(&question))
}

fn answer(
    question: &Question,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> Answer {
    let Question {
        path,
        settings,
        input,
        ..
    } = *question;
    let restorer = Restorer::new(path, input);
    let mut restored = input.path.clone();
    let mut publish = |improvement: Improvement| {
        restored.clone_from(improvement.path);
        restorer.restore(&mut restored);
        publish(Improvement {
            path: &restored,
            ..improvement
        });
    };
    let mut answer = Answer::unproved(question);
    let stays = (0..input.path.len()).filter(|waypoint| input.fixed[*waypoint]);
    if let Some(outside) = validator.outside_at(&input.path, stays, settings.strict) {
        answer.refusal = Some(refused::outside(validator, input, outside));
        answer.look_around(question, validator, stop);
        return answer;
    }
    match path_proof::prove_input(validator, &input.path, !settings.strict, stop) {
        PathVerdict::Stopped => answer.termination = Termination::Stopped,
        PathVerdict::Proved(proved) => {
            optimize(
                &mut answer,
                question,
                Some(proved),
                validator,
                stop,
                &mut publish,
            );
        }
        PathVerdict::Refused {
            segment,
            hit,
            proved_prefix,
        } => {
            answer.refusal = Some(refused::refusal(
                validator,
                input,
                segment,
                &hit,
                proved_prefix,
            ));
            let is_broken = matches!(hit.reason, HitReason::Collision | HitReason::Outside);
            let is_hopeless = is_broken || settings.strict;
            if !is_hopeless && settings.mode != Mode::Check {
                // Not provable, but nowhere found colliding: optimized all the same. The result
                // counts only if all of it is proved.
                optimize(&mut answer, question, None, validator, stop, &mut publish);
                match answer.proofs {
                    Some(_) => answer.refusal = None,
                    None => answer.reset(question),
                }
            }
        }
    }
    answer.look_around(question, validator, stop);
    answer
}

/// Betters the input, which is proved or not, and puts what came of it into the answer.
fn optimize(
    answer: &mut Answer,
    question: &Question,
    proved: Option<Proved>,
    validator: &mut Validator,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) {
    let task = task(question, validator);
    let input = &question.input.path;
    let best = match proved {
        Some(proved) => Best::proved(&task, input, proved),
        None => Best::unproved(&task, input),
    };
    let mut progress = Progress::new(best, validator, stop, publish);
    if let Some(optimizer) = question.settings.mode.optimizer() {
        answer.termination = optimizer(&mut progress);
        progress.prove_rest();
    }
    answer.take(progress);
}

/// What an optimizer is given, after this proof of the input.
fn task<'q>(question: &Question<'q>, validator: &Validator) -> Task<'q> {
    let Question {
        model,
        settings,
        input,
        ..
    } = *question;
    let budget = match settings.work_budget {
        0 => DEFAULT_WORK_BUDGET,
        budget => budget,
    };
    Task {
        model,
        space: &input.space,
        metric: &input.metric,
        held: &input.held,
        constraints: validator.allowed().to_vec(),
        fixed: &input.fixed,
        fixed_rows: &input.fixed_rows,
        moving: &input.moving,
        keep_goal: settings.keep_goal,
        seed: settings.seed,
        work_budget: validator.work().saturating_add(budget),
    }
}
