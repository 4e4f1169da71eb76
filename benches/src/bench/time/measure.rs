//! Shortens one problem, times it, and measures both.

use std::path::Path as File;

use taut::collision::CollisionModel;
use taut::constraint::{self, Constraint};
use taut::files::LimitsFile;
use taut::optimize::{self, Mode, Settings as Shortening, Workspace};
use taut::path::Path;
use taut::robot::{ConfigurationSpace, RobotModel};
use taut::timing::{self, ColumnLimits, Limits, Outcome, Range, Settings, Timed};
use taut::validation::timed::{self, Claims, Point};
use taut::validation::{
    Certificate, LoweredFloor, Requirement, Scratch, Validator, path_proof, reference,
};

use super::super::arguments::Arguments;
use super::super::loaded::Loaded;
use super::executed::{Executed, executed, is_at_rest_at};
use super::row::Figures;
use crate::clock::thread_cpu;
use crate::error::Error;
use crate::statistics::median;

/// Runs of a proof, of which the median counts.
const PROOFS: usize = 9;
/// Velocity limit of what has none, as of a virtual joint (m/s or rad/s).
const USUAL_VELOCITY: f64 = 1.0;

/// Measures one problem.
pub(super) fn measure(arguments: &Arguments, loaded: &Loaded) -> Result<Figures, Error> {
    let model = loaded.model()?;
    let path = shortened(arguments, loaded, &model)?;
    let constraints = constraint::constraints(&loaded.constraints, &loaded.robot, model.scene());
    let subject = Subject {
        arguments,
        loaded,
        space: loaded.robot.space().unwrapped(),
        held: vec![0.0; loaded.robot.held().len()],
        constraints: constraints.map_err(|error| no_time(loaded, &error.to_string()))?,
        limits: limits(arguments, loaded, &path)?,
        model: &model,
        path: &path,
    };
    subject.figures()
}

fn no_time(loaded: &Loaded, reason: &str) -> Error {
    Error::NoTime {
        name: loaded.name.clone(),
        reason: reason.to_owned(),
    }
}

/// The shortest path that a budget of work finds.
fn shortened(
    arguments: &Arguments,
    loaded: &Loaded,
    model: &CollisionModel,
) -> Result<Path, Error> {
    let nv = loaded.robot.space().nv();
    let settings = Shortening {
        work_budget: arguments.work,
        constraints: loaded.constraints.clone(),
        ..arguments
            .rules
            .settings(Mode::default(), loaded.weights.as_ref(), nv)?
    };
    let mut workspace = Workspace::default();
    let outcome = optimize::run(
        model,
        &loaded.path,
        &settings,
        &mut workspace,
        &mut || false,
        &mut |_| {},
    );
    match outcome {
        Ok(outcome) if outcome.proved => Ok(outcome.path),
        Ok(_) => Err(no_time(loaded, "its path is not proved")),
        Err(source) => Err(Error::Request {
            name: loaded.name.clone(),
            source,
        }),
    }
}

/// The limits of a file, else the robot's own velocities and so many times of them per second.
fn limits(arguments: &Arguments, loaded: &Loaded, path: &Path) -> Result<Limits, Error> {
    match &arguments.limits {
        Some(file) => of_file(file, loaded, path),
        None => Ok(own_limits(&loaded.robot, arguments.acceleration)),
    }
}

fn of_file(file: &File, loaded: &Loaded, path: &Path) -> Result<Limits, Error> {
    let limits =
        LimitsFile::read(file)?.limits(&loaded.robot, |column| timing::moves(path, column), None);
    limits.map_err(|reason| no_time(loaded, &reason))
}

fn own_limits(robot: &RobotModel, times: f64) -> Limits {
    let motors = &robot.description().motors;
    let velocity = |name: &str| {
        let mut named = motors
            .iter()
            .filter(|motor| motor.joint == name);
        let own = named.find_map(|motor| motor.velocity);
        own.filter(|most| *most > 0.0)
            .unwrap_or(USUAL_VELOCITY)
    };
    let variables = robot.variables().iter();
    let columns = variables.map(|variable| {
        let most = velocity(&variable.name);
        ColumnLimits {
            velocity: Range::symmetric(most),
            acceleration: Range::symmetric(times * most),
        }
    });
    Limits::new(columns.collect())
}

/// A shortened path and what its trajectory must keep.
struct Subject<'a> {
    arguments: &'a Arguments,
    loaded: &'a Loaded,
    model: &'a CollisionModel,
    path: &'a Path,
    space: ConfigurationSpace,
    held: Vec<f64>,
    constraints: Vec<Constraint>,
    limits: Limits,
}

/// A trajectory, and what it took.
struct Run {
    stages: Vec<(Timed, f64)>,
    cpu_s: f64,
    lowered: Vec<(Requirement, f64)>,
    named: Vec<LoweredFloor>,
    certificate: Option<Certificate>,
}

impl Subject<'_> {
    fn figures(&self) -> Result<Figures, Error> {
        let runs: Vec<Run> = (0..self.arguments.repeat)
            .map(|_| self.run())
            .collect::<Result<_, Error>>()?;
        let of_all = |what: fn(&Run) -> f64| median(runs.iter().map(what)).unwrap_or_default();
        let run = &runs[0];
        let ends = run.stages.first().zip(run.stages.last());
        let Some(((stops, _), (best, _))) = ends else {
            return Err(self.no_time("nothing is to be done: it stands still"));
        };
        let is_same = |other: &Run| other.stages.last().map(|(timed, _)| timed) == Some(best);
        if !runs.iter().all(is_same) {
            return Err(self.no_time("two runs of the same request have other answers"));
        }
        let seen = self.executed(best);
        let [path_proof_s, proof_s] = self.proofs(best, run)?;
        Ok(Figures {
            geometry: self.loaded.geometry_name(),
            columns: self.path.nq(),
            waypoints: self.path.len(),
            points: best.points.len(),
            duration_s: best.duration_s(),
            bound_s: best.bound.time_s,
            ratio: best.duration_s() / best.bound.time_s,
            stops_ratio: stops.duration_s() / best.bound.time_s,
            stage: best.stage.name(),
            first_cpu_s: of_all(|run| run.stages[0].1),
            cpu_s: of_all(|run| run.cpu_s),
            path_proof_s,
            proof_s,
            clearance_m: best
                .proof
                .as_ref()
                .map(|proof| proof.clearance_m())
                .filter(|metres| metres.is_finite()),
            floors_lowered: run.named.clone(),
            velocity_part: seen.velocity,
            acceleration_part: seen.acceleration,
            outside: seen.outside,
            rests_at_ends: is_at_rest_at(&best.points, self.ends()),
            verified: self.is_verified(best, run),
        })
    }

    fn no_time(&self, reason: &str) -> Error {
        no_time(self.loaded, reason)
    }

    fn ends(&self) -> [&[f64]; 2] {
        [0, self.path.len() - 1].map(|waypoint| self.path.waypoint(waypoint))
    }

    fn validator<'s>(&'s self, scratch: &'s mut Scratch) -> Validator<'s> {
        let clearance = self.arguments.rules.clearance;
        Validator::new(self.model, &self.space, &self.held, clearance, scratch)
            .with_constraints(&self.constraints)
    }

    /// Times the path.
    fn run(&self) -> Result<Run, Error> {
        let mut scratch = Scratch::default();
        let cpu = thread_cpu();
        let mut validator = self.validator(&mut scratch).closely();
        let mut stages = Vec::new();
        let outcome = timing::run(
            &self.loaded.robot,
            &mut validator,
            self.path,
            &Settings::new(self.limits.clone()),
            &mut || false,
            &mut |timed| stages.push((timed.clone(), thread_cpu() - cpu)),
        );
        let cpu_s = thread_cpu() - cpu;
        let timed = match outcome {
            Ok(Outcome::Timed(timed)) => timed,
            Ok(Outcome::Stopped) => unreachable!("nothing stops it"),
            Err(error) => return Err(self.no_time(&error.to_string())),
        };
        let claims = Claims {
            constraints: self.loaded.constraints.clone(),
            limits: self.limits.claims(&self.loaded.robot),
        };
        let lowered: Vec<(Requirement, f64)> = timed
            .proof
            .iter()
            .flat_map(|proof| proof.lowered.clone())
            .collect();
        let certificate = timed.certificate(&validator, claims);
        Ok(Run {
            stages,
            cpu_s,
            lowered,
            named: certificate
                .iter()
                .flat_map(|certificate| certificate.lowered.clone())
                .collect(),
            certificate,
        })
    }

    /// What the controller does.
    fn executed(&self, timed: &Timed) -> Executed {
        let variables = self.loaded.robot.variables().iter().enumerate();
        // A path that is outside may stay so.
        let positions: Vec<[f64; 2]> = variables
            .map(|(column, variable)| {
                let rows =
                    (0..self.path.len()).map(|waypoint| self.path.waypoint(waypoint)[column]);
                rows.fold([variable.lower, variable.upper], |[low, high], value| {
                    [low.min(value), high.max(value)]
                })
            })
            .collect();
        executed(&timed.points, &self.limits, &positions)
    }

    fn is_verified(&self, timed: &Timed, run: &Run) -> bool {
        let points: Vec<Point> = timed
            .points
            .iter()
            .map(|point| point.point())
            .collect();
        run.certificate
            .as_ref()
            .is_some_and(|certificate| {
                let verified = reference::verify_trajectory(
                    self.model,
                    &points,
                    certificate,
                    &mut || false,
                    &mut |_| {},
                );
                verified.is_ok()
            })
    }

    /// CPU of a proof of the path and of one of the trajectory, each at its floors; turn by turn.
    fn proofs(&self, timed: &Timed, run: &Run) -> Result<[f64; 2], Error> {
        let curve = timed
            .curve(&self.loaded.robot)
            .map_err(|error| self.no_time(&error.to_string()))?;
        let mut scratch = Scratch::default();
        let own = self.lowered_by_path(&mut scratch);
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..PROOFS {
            times[0].push(cpu_of(&mut self.at(&own, &mut scratch), |validator| {
                let verdict = path_proof::prove(validator, self.path, &mut || false);
                matches!(verdict, path_proof::PathVerdict::Proved(_))
            }));
            let validator = &mut self.at(&run.lowered, &mut scratch).closely();
            times[1].push(cpu_of(validator, |validator| {
                matches!(
                    timed::proof(validator, &curve, &mut || false),
                    Some(Some(_))
                )
            }));
        }
        let medians = times.map(|times| {
            let proved: Option<Vec<f64>> = times.into_iter().collect();
            proved.and_then(|times| median(times.into_iter()))
        });
        match medians {
            [Some(path), Some(trajectory)] => Ok([path, trajectory]),
            _ => Err(self.no_time("what was proved is not proved again")),
        }
    }

    /// The floors that the path needs lowered.
    fn lowered_by_path(&self, scratch: &mut Scratch) -> Vec<(Requirement, f64)> {
        let mut validator = self.validator(scratch);
        let _ = path_proof::prove_input(&mut validator, self.path, true, &mut || false);
        validator.floors().lowered().collect()
    }

    /// A validator that has proved nothing yet, at these floors.
    fn at<'s>(&'s self, floors: &[(Requirement, f64)], scratch: &'s mut Scratch) -> Validator<'s> {
        let mut validator = self.validator(scratch);
        for (requirement, floor) in floors {
            validator.set_floor(*requirement, *floor);
        }
        validator
    }
}

/// CPU of what is true.
fn cpu_of<'v>(
    validator: &mut Validator<'v>,
    proof: impl FnOnce(&mut Validator<'v>) -> bool,
) -> Option<f64> {
    let cpu = thread_cpu();
    let is_proved = proof(validator);
    is_proved.then(|| thread_cpu() - cpu)
}
