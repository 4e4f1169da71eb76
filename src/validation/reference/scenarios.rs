//! Every certificate of a trajectory is verified, every forged one refused, by its name.

use fastrand::Rng;

use super::*;
use crate::testing::{self, Oracle};
use crate::timing::{ColumnLimits, Limits, Range};
use crate::validation::certificate::LimitClaim;
use crate::validation::soundness::cases;
use crate::validation::timed::tests::{points, sampled};
use crate::validation::timed::{self, Claims, Curve, TimedVerdict};
use crate::validation::{Interpolation, Scratch, Validator};

/// Parry over-estimates the distance of smooth shapes by up to 1.7e-5 m.
const SMOOTH_M: f64 = 2e-5;

type Proved = (CollisionModel, Vec<Point>, Certificate);

/// A random model, a trajectory and its certificate; `None` where the trajectory is refused.
fn proved(rng: &mut Rng) -> Option<Proved> {
    let model = testing::model(rng);
    let robot = model.robot();
    if robot.space().nq() == 0 || model.uncheckable().is_some() {
        return None;
    }
    let points = points(rng, robot);
    let curve = Curve::new(robot, &points).unwrap();
    let held: Vec<f64> = robot
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    // What no joint moves is no matter of the curve's proof; whoever asks for that looks first.
    let mut kinematics = Kinematics::default();
    kinematics.update(robot, &points[0].positions, &held);
    if model.static_contact(&kinematics).is_some() {
        return None;
    }
    let space = robot.space().unwrapped();
    let mut scratch = Scratch::default();
    let clearance_m = [1e-3, 1e-4, 2e-2][rng.usize(0..3)];
    let mut validator = Validator::new(&model, &space, &held, clearance_m, &mut scratch);
    if rng.bool() {
        validator = validator.closely();
    }
    let TimedVerdict::Proved(proof) = timed::prove(&mut validator, &curve, false, &mut || false)
    else {
        return None;
    };
    let claims = Claims {
        limits: limits(&model, &curve),
        ..Claims::default()
    };
    let certificate = timed::certificate(&validator, &points, &proof, claims);
    Some((model, points, certificate))
}

/// What a curve just keeps, of each column that moves.
fn limits(model: &CollisionModel, curve: &Curve) -> Vec<LimitClaim> {
    let unit = ColumnLimits {
        velocity: Range::symmetric(1.0),
        acceleration: Range::symmetric(1.0),
    };
    let used = Limits::new(vec![unit; curve.columns()]).usage_by_column(curve);
    let variables = model
        .robot()
        .variables()
        .iter()
        .zip(used)
        .enumerate();
    let moving = variables.filter(|(column, _)| curve.moves(*column));
    moving
        .map(|(_, (variable, used))| {
            let [velocity, acceleration] =
                [used.velocity, used.acceleration].map(|most| [-most.part, most.part]);
            LimitClaim {
                variable: variable.name.clone(),
                velocity,
                acceleration,
            }
        })
        .collect()
}

fn verified(
    model: &CollisionModel,
    points: &[Point],
    certificate: &Certificate,
) -> Result<Effort, Objection> {
    verify_trajectory(model, points, certificate, &mut || false, &mut |_| {})
}

/// The same after a change by someone who computes the digest anew.
fn forged(
    (model, points, certificate): &Proved,
    change: impl FnOnce(&mut Certificate),
) -> Result<Effort, Objection> {
    let mut forged = certificate.clone();
    change(&mut forged);
    verified(model, points, &forged.sealed())
}

#[test]
fn what_is_proved_of_trajectories_is_verified() {
    let (count, mut rng) = cases(400);
    let mut met = 0;
    let mut lowered = 0;
    let mut effort = Effort::default();
    for case in 0..count {
        let Some((model, points, certificate)) = proved(&mut rng) else {
            continue;
        };
        let found = verified(&model, &points, &certificate);
        let found = found.unwrap_or_else(|objection| panic!("case {case}: {objection}"));
        met += 1;
        lowered += usize::from(!certificate.lowered.is_empty());
        effort.intervals += found.intervals;
        effort.distances += found.distances;
    }
    println!("{met} certificates, {lowered} with lowered floors, {effort:?}");
    assert!(met > count / 6 && lowered > 0);
}

/// The least distance of each piece that parry finds at this many places, ends included.
fn least_distances((model, points, _): &Proved, places: u32) -> Vec<f64> {
    let oracle = Oracle::new(model);
    let pieces = points.windows(2);
    pieces
        .map(|ends| {
            let mut least = f64::INFINITY;
            for place in 0..=places {
                let q = sampled(&ends[0], &ends[1], f64::from(place) / f64::from(places));
                for pair in 0..model.pairs().len() {
                    least = least.min(oracle.pair_distance(model, pair, &q));
                }
            }
            least
        })
        .collect()
}

/// Parry, which shares only the description with the checker, finds no distance below a claim that
/// is verified, and a claim above what parry finds is refused.
#[test]
fn a_clearance_above_the_distance_of_a_curve_is_refused() {
    let (count, mut rng) = cases(200);
    let mut met = 0;
    for case in 0..count {
        let Some(proved) = proved(&mut rng) else {
            continue;
        };
        let least = least_distances(&proved, 40);
        for (claim, least) in proved.2.segments.iter().zip(&least) {
            let claimed = claim.clearance_m.unwrap_or(1e9);
            assert!(
                claimed <= least + SMOOTH_M,
                "case {case}: {claimed}, {least}"
            );
        }
        let segment = rng.usize(0..least.len());
        if !least[segment].is_finite() {
            continue;
        }
        met += 1;
        for above in [2.0 * RESOLUTION_M, 1e-3, 1.0, f64::INFINITY] {
            let claim = Some(least[segment] + SMOOTH_M + above).filter(|claim| claim.is_finite());
            let refused = forged(&proved, |forged| {
                forged.segments[segment].clearance_m = claim
            });
            assert!(
                matches!(&refused, Err(Objection::Less(place) | Objection::NotProved(place)) if place.segment == segment),
                "case {case}, {above}: {refused:?}"
            );
        }
    }
    assert!(met > count / 10, "{met}");
}

fn another(interpolation: Interpolation) -> Interpolation {
    match interpolation {
        Interpolation::Cubic => Interpolation::Quintic,
        Interpolation::Linear | Interpolation::Quintic => Interpolation::Cubic,
    }
}

#[test]
fn a_forged_certificate_of_a_trajectory_is_refused_by_name() {
    let (count, mut rng) = cases(60);
    let mut met = 0;
    let mut limited = 0;
    for _ in 0..count {
        let Some(proved) = proved(&mut rng) else {
            continue;
        };
        let (model, points, certificate) = &proved;
        let of_other = |change: &dyn Fn(&mut Point)| {
            let mut other = points.clone();
            change(&mut other[1]);
            match verified(model, &other, certificate) {
                Err(Objection::Other { kind, .. }) => kind,
                found => panic!("{found:?}"),
            }
        };
        met += 1;
        // What it is about.
        assert_eq!(of_other(&|point| point.positions[0] += 1e-9), "trajectory");
        assert_eq!(of_other(&|point| point.time_s += 1e-9), "trajectory");
        assert_eq!(
            of_other(&|point| match point.velocities.is_empty() {
                true => point.velocities = vec![0.0; point.positions.len()],
                false => point.velocities.clear(),
            }),
            "trajectory"
        );
        for (kind, change) in [
            ("robot", (|c| c.robot_hash += 1) as fn(&mut Certificate)),
            ("scene", |c| c.scene_hash += 1),
        ] {
            let refused = forged(&proved, change);
            assert!(
                matches!(&refused, Err(Objection::Other { kind: found, .. }) if *found == kind),
                "{refused:?}"
            );
        }
        // What it claims.
        let refused = forged(&proved, |forged| {
            let interpolation = &mut forged.timed.as_mut().unwrap().interpolation[0];
            *interpolation = another(*interpolation);
        });
        assert!(
            matches!(refused, Err(Objection::Interpolation { segment: 0, .. })),
            "{refused:?}"
        );
        let refused = forged(&proved, |forged| {
            forged
                .segments
                .truncate(forged.segments.len() - 1)
        });
        assert!(
            matches!(refused, Err(Objection::Count { what: "claims", .. })),
            "{refused:?}"
        );
        let refused = forged(&proved, |forged| forged.timed = None);
        assert!(
            matches!(refused, Err(Objection::Kind { .. })),
            "{refused:?}"
        );
        for order in 0..2 {
            let limits = &certificate.timed.as_ref().unwrap().limits;
            let kept = |limit: &LimitClaim| [limit.velocity, limit.acceleration][order][1];
            let Some(index) = limits
                .iter()
                .position(|limit| kept(limit) > 2e-3)
            else {
                continue;
            };
            let refused = forged(&proved, |forged| {
                let limit = &mut forged.timed.as_mut().unwrap().limits[index];
                let range = [&mut limit.velocity, &mut limit.acceleration];
                for end in &mut *range[order] {
                    *end *= 1.0 - 1e-5;
                }
            });
            let what = ["velocity", "acceleration"][order];
            assert!(
                matches!(&refused, Err(Objection::Limit(exceeded)) if exceeded.what == what),
                "{refused:?}"
            );
            limited += 1;
        }
        // Without a new digest.
        let mut changed = certificate.clone();
        changed.segments[0].intervals += 1;
        let refused = verified(model, points, &changed);
        assert!(
            matches!(refused, Err(Objection::Edited { .. })),
            "{refused:?}"
        );
        // Paths and trajectories are no matter of each other's.
        let rows: Vec<f64> = points
            .iter()
            .flat_map(|point| point.positions.clone())
            .collect();
        let path = Path::from_rows(points[0].positions.len(), rows).unwrap();
        let refused = verify(model, &path, certificate, &mut || false, &mut |_| {});
        assert!(
            matches!(refused, Err(Objection::Kind { .. })),
            "{refused:?}"
        );
    }
    assert!(met > count / 10 && limited > met, "{met} {limited}");
}
