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
//! A pair is claimed to keep c, the larger of its floor and of what the segment's claim says. It
//! must be proved to keep c − [`slack`], and must nowhere be seen closer than c. Proved at the
//! least two thirds of its floor, that is; and since it keeps c if the claim is true, the search
//! ends at the latest where V h is the slack. A claim that is too high by more than the slack is
//! always refused, one that is too high by less if a place is met where the pair is closer.

use std::f64::consts::PI;

mod cover;
mod objection;
mod segment;
#[cfg(test)]
mod tests;
mod travel;

pub use objection::{Closeness, Objection};

use super::Certificate;
use super::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS, FIRST_WITH_DIGEST};
use super::interval::ROUNDING_M;
use super::path_proof::LEAST_FLOOR_M;
use crate::collision::CollisionModel;
use crate::path::Path;
use crate::robot::configuration::{LONGEST_STEP_RAD, ROUNDED_RAD};
use crate::robot::{Component, ConfigurationSpace, Kinematics};
use crate::solid::query;
use cover::Cover;
use segment::Segment;

/// What is not resolved of a claim (m): more than the distance of two smooth solids is uncertain
/// by.
pub const RESOLUTION_M: f64 = 5e-5;

/// What verifying a certificate took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Intervals looked at.
    pub intervals: u64,
    /// Distances of two bodies asked for.
    pub distances: u64,
}

/// How far below its claim a pair may be proved (m): three tenths of its floor, and no more than
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
    if let Some(why) = model.uncheckable() {
        return Err(Objection::NoGeometry(why));
    }
    let floors = floors(model, certificate)?;
    let held = held(model, certificate)?;
    let path = unit_quaternions(model, path);
    check_start(model, path.waypoint(0), &held)?;

    let space = model.robot().space();
    let space = if certificate.unwrapped {
        space.unwrapped()
    } else {
        space.clone()
    };
    check_steps(model, &path, &space, certificate.checker_version)?;
    let covers: Vec<Cover> = model
        .bodies()
        .iter()
        .map(|body| Cover::new(body.solid.tree.pieces(), &body.place))
        .collect();
    let mut effort = Effort::default();
    for (index, claim) in certificate.segments.iter().enumerate() {
        let ends = [index, (index + 1).min(path.len() - 1)].map(|waypoint| path.waypoint(waypoint));
        let claim = claim.clearance_m.unwrap_or(f64::INFINITY);
        let mut segment = Segment::new(model, &covers, &space, &held, index, ends);
        segment.verify(&floors, claim, &mut effort, stop)?;
        progress(index + 1);
    }
    Ok(effort)
}

/// Whether the certificate is whole, of a known kind, and about this robot, scene and path.
fn check_origin(
    model: &CollisionModel,
    path: &Path,
    certificate: &Certificate,
) -> Result<(), Objection> {
    let version = certificate.checker_version;
    if version > CHECKER_VERSION || version == 0 {
        return Err(Objection::Version(version));
    }
    match certificate.digest {
        None if version >= FIRST_WITH_DIGEST => return Err(Objection::NoDigest(version)),
        Some(digest) if digest != certificate.content() => {
            return Err(Objection::Edited {
                digest,
                content: certificate.content(),
            });
        }
        _ => {}
    }
    let scene = model.scene();
    let is_former = scene.former_hash() == Some(certificate.scene_hash);
    let scene_hash = if is_former {
        certificate.scene_hash
    } else {
        scene.hash()
    };
    for (kind, claimed, given) in [
        ("robot", certificate.robot_hash, model.robot().hash()),
        ("scene", certificate.scene_hash, scene_hash),
        ("path", certificate.path_hash, path.hash()),
    ] {
        if claimed != given {
            return Err(Objection::Other {
                kind,
                claimed,
                given,
            });
        }
    }
    let columns = ("columns", path.nq(), model.robot().space().nq());
    let claims = (
        "claims",
        certificate.segments.len(),
        (path.len() - 1).max(1),
    );
    for (what, got, expected) in [columns, claims] {
        if got != expected {
            return Err(Objection::Count {
                what,
                got,
                expected,
            });
        }
    }
    Ok(())
}

/// Every step says by its numbers how it moves.
fn check_steps(
    model: &CollisionModel,
    path: &Path,
    space: &ConfigurationSpace,
    version: u32,
) -> Result<(), Objection> {
    let name = |column: usize| model.robot().variables()[column].name.clone();
    // Before, half a turn could be meant the other way.
    let longest = if version < FIRST_BY_NUMBERS {
        PI - ROUNDED_RAD
    } else {
        LONGEST_STEP_RAD
    };
    for (segment, [from, to]) in path.segments().enumerate() {
        if let Some(q) = space.circles().find(|&q| (to[q] - from[q]).abs() > longest) {
            return Err(Objection::LongStep {
                segment,
                variable: name(q),
                from: from[q],
                to: to[q],
                version,
            });
        }
        if let Some(q) = space.half_turn(from, to) {
            return Err(Objection::HalfTurn {
                segment,
                variable: name(q),
            });
        }
    }
    Ok(())
}

/// The floor of every pair (m), by the certificate.
fn floors(model: &CollisionModel, certificate: &Certificate) -> Result<Vec<f64>, Objection> {
    let highest = certificate.clearance_m;
    let check = |what: String, floor: f64, range: std::ops::RangeInclusive<f64>| match range
        .contains(&floor)
    {
        true => Ok(floor),
        false => Err(Objection::Number {
            what,
            value: floor,
            least: *range.start(),
            most: *range.end(),
        }),
    };
    check("clearance_m".to_owned(), highest, LEAST_FLOOR_M..=f64::MAX)?;
    let names: Vec<[String; 2]> = (0..model.pairs().len())
        .map(|pair| model.pair_names(pair))
        .collect();
    let mut floors = vec![highest; names.len()];
    for (a, b, floor) in &certificate.lowered {
        check(
            format!("the floor of {a} × {b}"),
            *floor,
            LEAST_FLOOR_M..=highest,
        )?;
        let mut known = false;
        for (pair, _) in names
            .iter()
            .enumerate()
            .filter(|(_, [x, y])| (x, y) == (a, b))
        {
            floors[pair] = *floor;
            known = true;
        }
        if !known {
            return Err(Objection::UnknownPair {
                a: a.clone(),
                b: b.clone(),
            });
        }
    }
    for (index, claim) in certificate.segments.iter().enumerate() {
        let Some(clearance) = claim.clearance_m else {
            continue;
        };
        check(
            format!("the clearance of segment {}", index + 1),
            clearance,
            certificate.floor_m()..=f64::MAX,
        )?;
    }
    Ok(floors)
}

/// Values of the held variables.
fn held(model: &CollisionModel, certificate: &Certificate) -> Result<Vec<f64>, Objection> {
    let variables = model.robot().held();
    match &certificate.held {
        None => Ok(variables.iter().map(|variable| variable.default).collect()),
        Some(held) if held.len() == variables.len() => Ok(held.clone()),
        Some(held) => Err(Objection::Count {
            what: "values of held variables",
            got: held.len(),
            expected: variables.len(),
        }),
    }
}

/// The path with quaternions of unit length: a path may have them a little off.
fn unit_quaternions(model: &CollisionModel, path: &Path) -> Path {
    let mut path = path.clone();
    for waypoint in 0..path.len() {
        for component in model.robot().space().components() {
            if let Component::Rotation { q, .. } = *component {
                let quaternion = &mut path.waypoint_mut(waypoint)[q..q + 4];
                let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
                quaternion.iter_mut().for_each(|x| *x /= norm);
            }
        }
    }
    path
}

/// What intervals do not see: links that no joint moves, and bodies wholly inside a mesh. Nothing
/// gets inside later without coming near its surface.
fn check_start(model: &CollisionModel, start: &[f64], held: &[f64]) -> Result<(), Objection> {
    let mut kinematics = Kinematics::default();
    kinematics.update(model.robot(), start, held);
    if let Some((bodies, _)) = model.static_contact(&kinematics) {
        return Err(Objection::StandsIn { bodies });
    }
    for (index, pair) in model.pairs().iter().enumerate() {
        let a = &model.bodies()[pair.a];
        let b = &model.bodies()[pair.b];
        if (a.solid.hollow || b.solid.hollow)
            && query::enclosed(
                &a.solid,
                &a.placed(&kinematics),
                &b.solid,
                &b.placed(&kinematics),
            )
            .is_some()
        {
            return Err(Objection::StandsIn {
                bodies: model.pair_names(index),
            });
        }
    }
    Ok(())
}
