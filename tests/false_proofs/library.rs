//! The bulk of the proofs: taut's own readers of files and its `run`, in this process.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

use taut::collision::{CollisionModel, neutral_warnings};
use taut::files::{PathTable, Reader, RobotFiles};
use taut::optimize::{Mode, Settings, Workspace, run};
use taut::path::Path;
use taut::robot::RobotModel;
use taut::validation::{HitReason, NamedRequirement, RequirementKind};

use super::case::Case;
use super::theme::Theme;
use super::verdict::Proved;
use super::write;

/// What a warning of orientations half a turn apart says.
pub const HALF_A_TURN: &str = "half a turn";

/// Robot and scene of a case, as taut reads them.
pub struct Loaded {
    model: CollisionModel,
    workspace: Workspace,
}

/// A path that is not proved.
pub struct Refused {
    /// Why.
    pub reason: String,
    /// Segment, ratio on it and bodies, where it is said to collide.
    pub collision: Option<(usize, f64, [String; 2])>,
}

/// What taut says to a path.
pub enum Answer {
    Proved(Box<Proved>),
    Refused(Refused),
    /// It cannot be read.
    Unread(String),
}

/// Reads a case.
///
/// # Errors
/// Why it is not read.
pub fn load(case: &Case) -> Result<Loaded, String> {
    let mut reader = Reader::default();
    let mut model = model(case, &mut reader)?;
    if case.theme == Theme::RestContacts {
        // What is offered for the links that touch is done, as people do.
        let lines: Vec<String> = neutral_warnings(&model)
            .iter()
            .filter_map(|warning| offered(warning))
            .collect();
        if !lines.is_empty() {
            let robot = &case.world.robot;
            let neighbours =
                (1..robot.links.len()).filter_map(|link| Some((robot.joints[link].parent?, link)));
            let known =
                neighbours.map(|(a, b)| write::robot::disabling(&robot.links[a], &robot.links[b]));
            let lines: String = known.chain(lines).collect();
            let file = case.files.folder.join("pasted.srdf");
            fs::write(&file, format!("<robot name=\"random\">{lines}</robot>"))
                .map_err(|error| error.to_string())?;
            let files = RobotFiles {
                srdf: Some(file),
                ..robot_files(case)
            };
            model = of_files(case, &files, &mut reader)?;
        }
    }
    Ok(Loaded {
        model,
        workspace: Workspace::default(),
    })
}

/// The SRDF line at the end of a warning.
fn offered(warning: &str) -> Option<String> {
    warning
        .find("<disable_collisions")
        .map(|at| warning[at..].to_owned())
}

fn robot_files(case: &Case) -> RobotFiles {
    RobotFiles {
        urdf: case.files.urdf.clone(),
        srdf: case.files.srdf.clone(),
        variables: Some(case.names.clone()),
        ..RobotFiles::default()
    }
}

fn model(case: &Case, reader: &mut Reader) -> Result<CollisionModel, String> {
    of_files(case, &robot_files(case), reader)
}

fn of_files(
    case: &Case,
    files: &RobotFiles,
    reader: &mut Reader,
) -> Result<CollisionModel, String> {
    let robot = reader
        .robot_of(files)
        .map_err(|error| error.to_string())?;
    let robot = RobotModel::new(robot).map_err(|error| error.to_string())?;
    let mut scene = reader
        .scene(&case.files.scene)
        .map_err(|error| error.to_string())?;
    if let Some(diff) = &case.files.diff {
        let diff = reader
            .diff_of_text(diff, &case.files.scene)
            .map_err(|error| error.to_string())?;
        scene = diff
            .apply_among(&scene, &robot.worlds())
            .map_err(|error| error.to_string())?;
    }
    CollisionModel::new(Arc::new(robot), Arc::new(scene)).map_err(|error| error.to_string())
}

impl Loaded {
    /// Reads a path from its file and asks about it.
    pub fn ask(&mut self, case: &Case, file: &std::path::Path, settings: &Settings) -> Answer {
        let variables = self.model.robot().variables();
        let read = PathTable::read(file).and_then(|table| table.into_path(variables));
        let (path, constraints) = match read {
            Ok(read) => read,
            Err(error) => return Answer::Unread(error.to_string()),
        };
        let settings = Settings {
            constraints,
            ..settings.clone()
        };
        self.run(case, &path, &settings)
    }

    fn run(&mut self, case: &Case, path: &Path, settings: &Settings) -> Answer {
        let outcome = run(
            &self.model,
            path,
            settings,
            &mut self.workspace,
            &mut || false,
            &mut |_| {},
        );
        let outcome = match outcome {
            Ok(outcome) => outcome,
            Err(error) => return Answer::Unread(error.to_string()),
        };
        if !outcome.proved {
            let reason = outcome
                .refusal
                .as_ref()
                .map_or("UNCERTIFIED", |refusal| refusal.reason.name())
                .to_owned();
            let collision = outcome
                .refusal
                .filter(|refusal| refusal.reason == HitReason::Collision);
            let collision =
                collision.map(|refusal| (refusal.segment, refusal.t, bodies(&refusal.requirement)));
            return Answer::Refused(Refused { reason, collision });
        }
        let names: Vec<String> = self
            .model
            .robot()
            .variables()
            .iter()
            .map(|variable| variable.name.clone())
            .collect();
        let rows = outcome
            .path
            .waypoints()
            .map(<[f64]>::to_vec)
            .collect();
        let lowered = outcome
            .floors_lowered
            .iter()
            .filter(|lowered| lowered.requirement.kind == RequirementKind::Clearance)
            .map(|lowered| (bodies(&lowered.requirement), lowered.floor));
        Answer::Proved(Box::new(Proved {
            rows: super::read::path::ordered(&case.names, (names, rows)),
            clearance_m: outcome.clearance_m,
            lowered: lowered.collect::<BTreeMap<_, _>>(),
            is_shortened: settings.mode != Mode::Check,
            is_said: outcome
                .warnings
                .iter()
                .any(|warning| warning.contains(HALF_A_TURN)),
        }))
    }
}

/// The two bodies whose clearance is meant.
fn bodies(requirement: &NamedRequirement) -> [String; 2] {
    let names = requirement.names.clone();
    names.try_into().expect("two bodies")
}
