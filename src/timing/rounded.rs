//! Corners rounded as wide as is proved, and gone along as fast as that allows.

use super::begun::Begun;
use super::blend::Corners;
use super::keeper::Keeper;
use super::pace::{Course, paced};
use super::trajectory::{Trajectory, curve};

/// Halvings of a radius after which a corner stays one.
const HALVINGS: u32 = 12;
/// Steps of the search between a radius that is proved and one that is not.
const STEPS: u32 = 3;
/// Times that a way whose corners are proved one by one is tried as it is written, each with corners
/// that are refused narrower.
const TRIES: u32 = 6;

/// The fastest way along a path with its corners rounded; `Some(None)` where it is not proved, `None` where
/// stopped.
pub fn rounded(
    keeper: &mut Keeper,
    begun: &Begun,
    stop: &mut dyn FnMut() -> bool,
) -> Option<Option<Trajectory>> {
    let mut corners = begun.corners.clone();
    if corners.rows().len() < 2 {
        return Some(None);
    }
    for waypoint in corners.inner() {
        widen(keeper, &mut corners, waypoint, stop)?;
    }
    for _ in 0..TRIES {
        let Some(way) = gone_along(keeper, &corners) else {
            return Some(None);
        };
        let way = begun.then(&way, &keeper.manner());
        if keeper.keeps(&way, way.whole(), stop)? {
            return Some(Some(way));
        }
        for waypoint in corners.inner() {
            corners.round(waypoint, 0.7 * corners.radius(waypoint));
        }
    }
    Some(None)
}

/// The fastest way along corners as they are.
fn gone_along(keeper: &Keeper, corners: &Corners) -> Option<Trajectory> {
    let rows = corners.rows();
    let course = Course {
        stretches: &corners.stretches(),
        ends: [&rows[0], &rows[rows.len() - 1]].map(|row| row.positions.as_slice()),
        grain_ns: keeper.manner().grain_ns,
    };
    paced(keeper.robot(), &course, keeper.limits()).map(Trajectory::new)
}

/// Rounds a corner as wide as is proved.
fn widen(
    keeper: &mut Keeper,
    corners: &mut Corners,
    waypoint: usize,
    stop: &mut dyn FnMut() -> bool,
) -> Option<()> {
    let mut refused = corners.room(waypoint);
    let mut proved = 0.0;
    // The widest first: then there is nothing to look for.
    let mut radius = refused;
    for _ in 0..HALVINGS {
        if proves(keeper, corners, waypoint, radius, stop)? {
            proved = radius;
            break;
        }
        refused = radius;
        radius *= 0.5;
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (proved + refused);
        let is_worth_it = proved > 0.0 && refused > proved;
        if is_worth_it && proves(keeper, corners, waypoint, middle, stop)? {
            proved = middle;
        } else {
            refused = middle;
        }
    }
    corners.round(waypoint, proved);
    Some(())
}

/// Whether the parabola of this radius is proved.
fn proves(
    keeper: &mut Keeper,
    corners: &mut Corners,
    waypoint: usize,
    radius: f64,
    stop: &mut dyn FnMut() -> bool,
) -> Option<bool> {
    corners.round(waypoint, radius);
    let states = corners.parabola(waypoint).states();
    match curve(keeper.robot(), &states) {
        Ok(curve) => keeper.proves(&curve, stop),
        Err(_) => Some(false),
    }
}
