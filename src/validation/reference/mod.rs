//! The reference checker: finds out whether a certificate is true, by the plainest means there are.
//!
//! It shares with the [validator](super::continuous) what a robot and a scene are, where their
//! bodies stand at one configuration, and how far apart two convex pieces are. It shares no filter,
//! no lanes, no ball tree and no bound that depends on a direction or on an acceleration.
//!
//! On a segment `q(t) = q₀ ⊕ t v` no point of a body is faster than V (`travel.rs`) as seen from
//! the link that carries both bodies of a pair. So if they are d apart in the middle of an interval
//! of half width h, they are at least d − V h apart on all of it. Where that is not enough, both
//! halves are looked at.
//!
//! A requirement is claimed to keep c, the larger of its floor and of what the segment's claim says. It
//! must be proved to keep c − [`slack`], and must nowhere be seen closer than c. Proved at the
//! least two thirds of its floor, that is; and since it keeps c if the claim is true, the search
//! ends at the latest where V h is the slack. A claim that is too high by more than the slack is
//! always refused, one that is too high by less if a place is met where the pair is closer.
//!
//! The curve of a trajectory (`trajectory.rs`) is looked at in the same way: V is that of each interval,
//! by the greatest speeds there, which control points bound (`column.rs`). Limits of velocity and
//! acceleration are judged by the same control points.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

mod column;
mod constrained;
mod course;
mod cover;
#[cfg(test)]
mod forged {
    mod tests;
}
mod objection;
#[cfg(test)]
mod scenarios;
mod segment;
#[cfg(test)]
mod tests;
mod trajectory;
mod travel;

pub use objection::{Exceeded, Objection, Shortfall};

use super::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS, FIRST_WITH_DIGEST, TimedClaims};
use super::interval::ROUNDING_M;
use super::path_proof::{LEAST_FLOOR_M, ends};
use super::timed::Point;
use super::timed::certified::hash_of;
use super::{Certificate, LoweredFloor, NamedRequirement, Requirement, RequirementKind};
use crate::collision::{BodyPair, CollisionModel};
use crate::path::Path;
use crate::robot::configuration::{LONGEST_STEP_RAD, ROUNDED_RAD};
use crate::robot::{Component, ConfigurationSpace, Kinematics};
use crate::solid::query;
use constrained::Constrained;
use course::Course;
use cover::Cover;
use segment::Segment;

/// What is not resolved of a claim (m): more than the distance of two smooth solids is uncertain
/// by.
pub const RESOLUTION_M: f64 = 5e-5;

/// A requirement and its floor.
#[derive(Clone, Copy, Debug)]
struct Required {
    requirement: Requirement,
    floor: f64,
}

/// What verifying a certificate took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Intervals looked at.
    pub intervals: u64,
    /// Distances of two bodies asked for.
    pub distances: u64,
}

/// How far below its claim a requirement may be proved (m): three tenths of its floor, and no more than
/// [`RESOLUTION_M`].
pub fn slack(floor: f64) -> f64 {
    (0.3 * floor).min(RESOLUTION_M)
}

/// Verifies that `certificate` is about this model and this path and that all it claims of them is
/// true.
///
/// `progress` hears the number of segments that are verified, `stop` is asked at every interval.
///
/// # Errors
/// The first objection found, in one line.
pub fn verify(
    model: &CollisionModel,
    path: &Path,
    certificate: &Certificate,
    stop: &mut dyn FnMut() -> bool,
    progress: &mut dyn FnMut(usize),
) -> Result<Effort, Objection> {
    check_origin(model, path, certificate)?;
    let path = unit_quaternions(model, path);
    let space = space(model, certificate);
    let given = Given::new(model, certificate, path.waypoint(0))?;
    check_steps(model, &path, &space, certificate.checker_version)?;
    let courses = 0..certificate.segments.len();
    let courses = courses.map(|index| Course::straight(&space, ends(&path, index)));
    given.verify(courses, stop, progress)
}

/// The same of the certificate of a trajectory: what a controller makes of these points.
///
/// # Errors
/// The first objection found, in one line.
pub fn verify_trajectory(
    model: &CollisionModel,
    points: &[Point],
    certificate: &Certificate,
    stop: &mut dyn FnMut() -> bool,
    progress: &mut dyn FnMut(usize),
) -> Result<Effort, Objection> {
    let robot = model.robot();
    let claims = check_trajectory(model, points, certificate)?;
    let pieces = trajectory::pieces(robot, points)?;
    trajectory::check_interpolation(&pieces, claims)?;
    let given = Given::new(model, certificate, &pieces[0].start())?;
    trajectory::check_limits(robot, &pieces, &points[0].velocities, &claims.limits)?;
    let space = robot.space().unwrapped();
    let courses = pieces.iter().map(|piece| piece.course(&space));
    given.verify(courses, stop, progress)
}

/// What a certificate is about, with what it claims.
struct Given<'a> {
    model: &'a CollisionModel,
    certificate: &'a Certificate,
    held: Vec<f64>,
    required: Vec<Required>,
    covers: Vec<Cover>,
}

impl<'a> Given<'a> {
    /// Objects to what no interval shows: claims that mean nothing, and what is not kept where it starts.
    fn new(
        model: &'a CollisionModel,
        certificate: &'a Certificate,
        start: &[f64],
    ) -> Result<Self, Objection> {
        if let Some(why) = model.uncheckable() {
            return Err(Objection::NoGeometry(why));
        }
        let required = floors(model, certificate)?;
        let held = held(model, certificate)?;
        check_start(model, start, &held)?;
        Ok(Self {
            model,
            certificate,
            held,
            required,
            covers: covers(model),
        })
    }

    /// Shows that each segment keeps what is claimed of it.
    fn verify<'c>(
        &self,
        courses: impl Iterator<Item = Course<'c>>,
        stop: &mut dyn FnMut() -> bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Effort, Objection> {
        let mut constrained = Constrained::new(self.model, &self.held, self.certificate)?;
        let mut effort = Effort::default();
        let claims = self.certificate.segments.iter();
        for (index, (claim, course)) in claims.zip(courses).enumerate() {
            let claim = claim.clearance_m.unwrap_or(f64::INFINITY);
            let mut segment =
                Segment::new(self.model, &self.covers, &self.held, index, course.clone());
            segment.verify(&self.required, claim, &mut effort, stop)?;
            constrained.verify(index, course, &mut effort, stop)?;
            progress(index + 1);
        }
        Ok(effort)
    }
}

/// The space whose steps the certificate is about.
fn space(model: &CollisionModel, certificate: &Certificate) -> ConfigurationSpace {
    let space = model.robot().space();
    match certificate.unwrapped {
        true => space.unwrapped(),
        false => space.clone(),
    }
}

fn covers(model: &CollisionModel) -> Vec<Cover> {
    let bodies = model.bodies().iter();
    bodies
        .map(|body| Cover::new(&body.solid.tree.pieces(), &body.place))
        .collect()
}

/// Whether the certificate is whole, of a known kind, and about this robot, scene and path.
fn check_origin(
    model: &CollisionModel,
    path: &Path,
    certificate: &Certificate,
) -> Result<(), Objection> {
    check_whole(certificate)?;
    if certificate.timed.is_some() {
        return Err(Objection::Kind {
            about: "a trajectory",
            given: "a path",
        });
    }
    check_hashes(model, "path", path.hash(), certificate)?;
    let claims = (path.len() - 1).max(1);
    check_count("columns", path.nq(), model.robot().space().nq())?;
    check_count("claims", certificate.segments.len(), claims)
}

/// Whether it is about this robot, scene and trajectory; what it claims of times.
fn check_trajectory<'c>(
    model: &CollisionModel,
    points: &[Point],
    certificate: &'c Certificate,
) -> Result<&'c TimedClaims, Objection> {
    check_whole(certificate)?;
    let claims = certificate.timed.as_ref();
    let claims = claims.ok_or(Objection::Kind {
        about: "a path",
        given: "a trajectory",
    })?;
    check_hashes(model, "trajectory", hash_of(points), certificate)?;
    check_count("claims", certificate.segments.len(), points.len() - 1)?;
    Ok(claims)
}

/// Whether it is of a known kind, and nothing was changed in it.
fn check_whole(certificate: &Certificate) -> Result<(), Objection> {
    let version = certificate.checker_version;
    if version > CHECKER_VERSION || version == 0 {
        return Err(Objection::Version(version));
    }
    let content = certificate.content();
    match certificate.digest {
        None if version >= FIRST_WITH_DIGEST => Err(Objection::NoDigest(version)),
        Some(digest) if digest != content => Err(Objection::Edited { digest, content }),
        _ => Ok(()),
    }
}

fn check_hashes(
    model: &CollisionModel,
    what: &'static str,
    hash: u64,
    certificate: &Certificate,
) -> Result<(), Objection> {
    for (kind, claimed, given) in [
        ("robot", certificate.robot_hash, model.robot().hash()),
        (
            "scene",
            certificate.scene_hash,
            scene_hash(model, certificate.scene_hash),
        ),
        (what, certificate.path_hash, hash),
    ] {
        if claimed != given {
            return Err(Objection::Other {
                kind,
                claimed,
                given,
            });
        }
    }
    Ok(())
}

/// The scene's hash, or the one that it had in an older form of the same, where that is claimed.
fn scene_hash(model: &CollisionModel, claimed: u64) -> u64 {
    let scene = model.scene();
    match scene.former_hash() == Some(claimed) {
        true => claimed,
        false => scene.hash(),
    }
}

fn check_count(what: &'static str, got: usize, expected: usize) -> Result<(), Objection> {
    match got == expected {
        true => Ok(()),
        false => Err(Objection::Count {
            what,
            got,
            expected,
        }),
    }
}

/// Every step says by its numbers how it moves.
fn check_steps(
    model: &CollisionModel,
    path: &Path,
    space: &ConfigurationSpace,
    version: u32,
) -> Result<(), Objection> {
    let name = |column: usize| model.robot().variables()[column].name.clone();
    for (segment, [from, to]) in path.segments().enumerate() {
        if let Some(q) = long_step(space, version, [from, to]) {
            return Err(Objection::LongStep {
                segment,
                variable: name(q),
                from: from[q],
                to: to[q],
                version,
            });
        }
        if let Some(q) = space.half_turn(from, to) {
            let variable = name(q);
            return Err(Objection::HalfTurn { segment, variable });
        }
    }
    Ok(())
}

/// A column of a circle that steps farther than a step may mean.
fn long_step(space: &ConfigurationSpace, version: u32, [from, to]: [&[f64]; 2]) -> Option<usize> {
    let longest = longest_step(version);
    space
        .circles()
        .find(|&q| (to[q] - from[q]).abs() > longest)
}

fn longest_step(version: u32) -> f64 {
    match version < FIRST_BY_NUMBERS {
        // Before, half a turn could be meant the other way.
        true => PI - ROUNDED_RAD,
        false => LONGEST_STEP_RAD,
    }
}

/// What every requirement must keep, by the certificate.
fn floors(model: &CollisionModel, certificate: &Certificate) -> Result<Vec<Required>, Objection> {
    let highest = certificate.clearance_m;
    check_range("clearance_m".to_owned(), highest, LEAST_FLOOR_M..=f64::MAX)?;
    let mut required: Vec<Required> = requirements(model)
        .map(|requirement| Required {
            requirement,
            floor: highest,
        })
        .collect();
    let names = names(model, &required);
    let clearances = certificate
        .lowered
        .iter()
        .filter(|lowered| lowered.requirement.kind == RequirementKind::Clearance);
    for lowered in clearances {
        let what = format!("the floor of {}", lowered.requirement);
        check_range(what, lowered.floor, LEAST_FLOOR_M..=highest)?;
        lower(&mut required, &names, lowered)?;
    }
    check_clearances(certificate)?;
    Ok(required)
}

/// All that the model requires.
fn requirements(model: &CollisionModel) -> impl Iterator<Item = Requirement> + use<> {
    (0..model.pairs().len()).map(Requirement::Clearance)
}

fn names(model: &CollisionModel, required: &[Required]) -> Vec<NamedRequirement> {
    let required = required.iter();
    required
        .map(|required| required.requirement.named(model, &[]))
        .collect()
}

/// Gives the requirements of this name a floor.
fn lower(
    required: &mut [Required],
    names: &[NamedRequirement],
    lowered: &LoweredFloor,
) -> Result<(), Objection> {
    let mut known = false;
    let all = required.iter_mut().zip(names);
    for (own, _) in all.filter(|(_, name)| **name == lowered.requirement) {
        own.floor = lowered.floor;
        known = true;
    }
    let unknown = || Objection::NotRequired(lowered.requirement.clone());
    known.then_some(()).ok_or_else(unknown)
}

/// A claim below the lowest floor says nothing.
fn check_clearances(certificate: &Certificate) -> Result<(), Objection> {
    for (index, claim) in certificate.segments.iter().enumerate() {
        if let Some(clearance) = claim.clearance_m {
            let what = format!("the clearance of segment {}", index + 1);
            check_range(what, clearance, certificate.floor_m()..=f64::MAX)?;
        }
    }
    Ok(())
}

fn check_range(what: String, value: f64, range: RangeInclusive<f64>) -> Result<(), Objection> {
    match range.contains(&value) {
        true => Ok(()),
        false => Err(Objection::Number {
            what,
            value,
            least: *range.start(),
            most: *range.end(),
        }),
    }
}

/// Values of the held variables.
fn held(model: &CollisionModel, certificate: &Certificate) -> Result<Vec<f64>, Objection> {
    let variables = model.robot().held();
    let defaults = || {
        variables
            .iter()
            .map(|variable| variable.default)
            .collect()
    };
    let held = certificate
        .held
        .clone()
        .unwrap_or_else(defaults);
    check_count("values of held variables", held.len(), variables.len())?;
    Ok(held)
}

/// The path with quaternions of unit length: a path may have them a little off.
fn unit_quaternions(model: &CollisionModel, path: &Path) -> Path {
    let mut path = path.clone();
    for waypoint in 0..path.len() {
        normalise_rotations(model.robot().space(), path.waypoint_mut(waypoint));
    }
    path
}

fn normalise_rotations(space: &ConfigurationSpace, waypoint: &mut [f64]) {
    for component in space.components() {
        if let Component::Rotation { q, .. } = *component {
            normalise(&mut waypoint[q..q + 4]);
        }
    }
}

fn normalise(quaternion: &mut [f64]) {
    let norm = quaternion
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    quaternion.iter_mut().for_each(|x| *x /= norm);
}

/// What intervals do not see: links that no joint moves, and bodies wholly inside a mesh. Nothing
/// gets inside later without coming near its surface.
fn check_start(model: &CollisionModel, start: &[f64], held: &[f64]) -> Result<(), Objection> {
    let mut kinematics = Kinematics::default();
    kinematics.update(model.robot(), start, held);
    if let Some((bodies, _)) = model.static_contact(&kinematics) {
        return Err(stands_in(bodies));
    }
    for (index, pair) in model.pairs().iter().enumerate() {
        if is_enclosed(model, pair, &kinematics) {
            return Err(stands_in(model.pair_names(index)));
        }
    }
    Ok(())
}

fn stands_in(bodies: [String; 2]) -> Objection {
    Objection::Broken(NamedRequirement::clearance(bodies))
}

/// Whether a body of a pair has a part wholly inside a mesh of the other.
fn is_enclosed(model: &CollisionModel, pair: &BodyPair, kinematics: &Kinematics) -> bool {
    let a = &model.bodies()[pair.a];
    let b = &model.bodies()[pair.b];
    let enclosed = || {
        query::enclosed(
            &a.solid,
            &a.placed(kinematics),
            &b.solid,
            &b.placed(kinematics),
        )
    };
    (a.solid.hollow || b.solid.hollow) && enclosed().is_some()
}
