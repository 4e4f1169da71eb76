//! Every certificate of the validator is verified, every forged one refused, for the right reason.

use fastrand::Rng;

use super::*;
use crate::optimize::{self, Mode, Settings, Workspace};
use crate::testing::{self, Oracle};
use crate::validation::clouds::tests::among_clouds;
use crate::validation::soundness::{cases, sampled_motion, surface_points};

/// Parry over-estimates the distance of smooth shapes by up to 1.7e-5 m.
const SMOOTH_M: f64 = 2e-5;

/// A random model, a path and its certificate; `None` where the path is refused.
fn proved(rng: &mut Rng) -> Option<(CollisionModel, Path, Certificate)> {
    let model = testing::model(rng);
    proved_in(model, rng)
}

/// The same in this model.
fn proved_in(model: CollisionModel, rng: &mut Rng) -> Option<(CollisionModel, Path, Certificate)> {
    let robot = model.robot();
    if robot.space().nq() == 0 {
        return None;
    }
    let mut rows = testing::configuration(rng, robot);
    let mut at = rows.clone();
    for _ in 0..rng.usize(0..4) {
        // Some neighbours are equal: segments that do not move.
        at = if rng.f64() < 0.2 {
            at
        } else {
            testing::neighbour(rng, robot, &at)
        };
        rows.extend_from_slice(&at);
    }
    let path = Path::from_rows(robot.space().nq(), rows)?;
    let clearance_m = [1e-3, 1e-4, 2e-2][rng.usize(0..3)];
    let settings = Settings {
        mode: Mode::Check,
        clearance_m,
        unwrapped: rng.bool(),
        ..Settings::default()
    };
    let mut asked = 0;
    let mut stop = || {
        asked += 1;
        asked > 200_000
    };
    let answer = optimize::run(
        &model,
        &path,
        &settings,
        &mut Workspace::default(),
        &mut stop,
        &mut |_| {},
    );
    let answer = answer.ok()?;
    assert!(
        answer.termination != optimize::Termination::Stopped,
        "no end at clearance {clearance_m}"
    );
    let certificate = answer.certificate?;
    assert_eq!(certificate.segments.len(), (path.len() - 1).max(1));
    Some((model, path, certificate))
}

fn verified(
    model: &CollisionModel,
    path: &Path,
    certificate: &Certificate,
) -> Result<Effort, Objection> {
    verify(model, path, certificate, &mut || false, &mut |_| {})
}

/// The same after a change by someone who computes the digest anew.
fn forged(
    (model, path, certificate): &(CollisionModel, Path, Certificate),
    change: impl FnOnce(&mut Certificate),
) -> Result<Effort, Objection> {
    let mut forged = certificate.clone();
    change(&mut forged);
    verified(model, path, &forged.sealed())
}

/// The least distance of each segment that parry finds at this many places, ends included.
fn least_distances(
    model: &CollisionModel,
    path: &Path,
    certificate: &Certificate,
    places: u32,
) -> Vec<f64> {
    let oracle = Oracle::new(model);
    let robot = model.robot();
    let space = if certificate.unwrapped {
        robot.space().unwrapped()
    } else {
        robot.space().clone()
    };
    let mut velocity = vec![0.0; space.nv()];
    let mut q = vec![0.0; space.nq()];
    let mut least = vec![f64::INFINITY; certificate.segments.len()];
    for (segment, least) in least.iter_mut().enumerate() {
        let from = path.waypoint(segment);
        let to = path.waypoint((segment + 1).min(path.len() - 1));
        space.difference(to, from, &mut velocity);
        for place in 0..=places {
            space.integrate(
                from,
                &velocity,
                f64::from(place) / f64::from(places),
                &mut q,
            );
            for pair in 0..model.pairs().len() {
                *least = least.min(oracle.pair_distance(model, pair, &q));
            }
        }
    }
    least
}

/// The checker halves the cells of a cloud as it does any pieces: it knows no tree of boxes. Parry
/// sees the cells one by one.
#[test]
fn what_is_proved_among_clouds_is_verified_and_no_more() {
    let (count, mut rng) = cases(150);
    let mut met = 0;
    let mut raised = 0;
    for case in 0..count {
        let [model, singly] = among_clouds(&mut rng);
        let Some(proved) = proved_in(model, &mut rng) else {
            continue;
        };
        met += 1;
        verified(&proved.0, &proved.1, &proved.2).unwrap();
        raised += usize::from(is_refused_when_raised(case, &singly, &proved, &mut rng));
    }
    assert!(met > count / 10 && raised > count / 20, "{met}, {raised}");
}

#[test]
fn what_the_validator_proves_is_verified() {
    let (count, mut rng) = cases(1500);
    let mut met = 0;
    let mut lowered = 0;
    let mut effort = Effort::default();
    for case in 0..count {
        let Some((model, path, certificate)) = proved(&mut rng) else {
            continue;
        };
        let found = verified(&model, &path, &certificate);
        let found = found.unwrap_or_else(|objection| panic!("case {case}: {objection}"));
        met += 1;
        lowered += usize::from(!certificate.lowered.is_empty());
        effort.intervals += found.intervals;
        effort.distances += found.distances;
    }
    println!("{met} certificates, {lowered} with lowered floors, {effort:?}");
    assert!(met > count / 6 && lowered > count / 200);
}

/// Parry, which shares only the description with the checker, finds no distance below a claim that
/// is verified, and a claim above what parry finds is refused.
#[test]
fn a_clearance_above_the_distance_is_refused() {
    let (count, mut rng) = cases(400);
    let mut met = 0;
    for case in 0..count {
        let Some(proved) = proved(&mut rng) else {
            continue;
        };
        met += usize::from(is_refused_when_raised(case, &proved.0, &proved, &mut rng));
    }
    assert!(met > count / 8, "{met} met");
}

/// Checks it of a segment, in a model that parry can read; false where it finds nothing near.
fn is_refused_when_raised(
    case: usize,
    seen: &CollisionModel,
    proved: &(CollisionModel, Path, Certificate),
    rng: &mut Rng,
) -> bool {
    let least = least_distances(seen, &proved.1, &proved.2, 40);
    let segment = rng.usize(0..least.len());
    let least = least[segment];
    if !least.is_finite() {
        return false;
    }
    let claim = proved.2.segments[segment].clearance_m.unwrap();
    assert!(
        claim <= least + 1e-7,
        "case {case}: {claim} is verified, {least} found"
    );
    for raised in [least + RESOLUTION_M, 2.0 * least + 1e-3] {
        let found = forged(proved, |certificate| {
            certificate.segments[segment].clearance_m = Some(raised)
        });
        let place = match found {
            Err(Objection::Less(place)) if place.amount < raised => place,
            // Where the distance itself is uncertain.
            Err(Objection::NotProved(place)) if place.amount < raised + SMOOTH_M => place,
            found => panic!("case {case}: {raised} is verified, {least} found: {found:?}"),
        };
        assert!(
            place.segment == segment && place.claimed == raised,
            "{place:?}"
        );
    }
    let found = forged(proved, |certificate| {
        certificate.segments[segment].clearance_m = None
    });
    assert!(
        matches!(found, Err(Objection::Less(_))),
        "case {case}: {found:?}"
    );
    true
}

#[test]
fn a_raised_floor_and_a_lowered_pair_that_is_left_out_are_refused() {
    let (count, mut rng) = cases(1500);
    let mut raised = 0;
    let mut removed = 0;
    for case in 0..count {
        let Some(proved) = proved(&mut rng) else {
            continue;
        };
        let least = least_distances(&proved.0, &proved.1, &proved.2, 8)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        if proved.2.lowered.is_empty() && least.is_finite() {
            let found = forged(&proved, |certificate| {
                certificate.clearance_m = least + RESOLUTION_M;
                certificate
                    .segments
                    .iter_mut()
                    .for_each(|claim| claim.clearance_m = Some(least + RESOLUTION_M));
            });
            assert!(
                matches!(found, Err(Objection::Less(_) | Objection::NotProved(_))),
                "case {case}: {found:?}"
            );
            // Two thirds of it would still be true.
            let found = forged(&proved, |certificate| {
                certificate.clearance_m = 1.4 * least + RESOLUTION_M
            });
            assert!(
                matches!(found, Err(Objection::Number { .. } | Objection::Less(_))),
                "case {case}: {found:?}"
            );
            raised += 1;
        } else if least < proved.2.clearance_m - RESOLUTION_M {
            let found = forged(&proved, |certificate| {
                certificate.lowered.clear();
                let floor = certificate.clearance_m;
                certificate
                    .segments
                    .iter_mut()
                    .for_each(|claim| claim.clearance_m = Some(floor));
            });
            assert!(
                matches!(found, Err(Objection::Less(_))),
                "case {case}: {found:?}"
            );
            let found = forged(&proved, |certificate| {
                certificate.lowered[0].requirement.names[0].push('?')
            });
            assert!(
                matches!(found, Err(Objection::NotRequired(_))),
                "case {case}: {found:?}"
            );
            removed += 1;
        }
    }
    assert!(
        raised > count / 8 && removed > count / 300,
        "{raised} raised, {removed} removed"
    );
}

#[test]
fn another_path_robot_or_scene_is_refused() {
    let (count, mut rng) = cases(200);
    let mut met = 0;
    for _ in 0..count {
        let (Some(one), Some(other)) = (proved(&mut rng), proved(&mut rng)) else {
            continue;
        };
        let (model, path, certificate) = &one;
        let other_kind = |found: Result<Effort, Objection>| match found {
            Err(Objection::Other { kind, .. }) => kind,
            found => panic!("{found:?}"),
        };
        let mut moved = path.clone();
        let waypoint = rng.usize(0..path.len());
        moved.waypoint_mut(waypoint)[0] += 1e-6;
        assert_eq!(other_kind(verified(model, &moved, certificate)), "path");
        assert_eq!(other_kind(verified(&other.0, path, certificate)), "robot");
        let scene = testing::scene(&mut rng);
        if scene.hash() != model.scene().hash() {
            let elsewhere =
                CollisionModel::new(model.robot().clone(), std::sync::Arc::new(scene)).unwrap();
            assert_eq!(other_kind(verified(&elsewhere, path, certificate)), "scene");
        }
        met += 1;
    }
    assert!(met > count / 10, "{met} met");
}

/// Also where what it says after the change would still be true.
#[test]
fn whatever_is_changed_after_the_proof_shows_in_the_digest() {
    let mut rng = Rng::with_seed(11);
    let (model, path, certificate) = std::iter::repeat_with(|| proved(&mut rng))
        .flatten()
        .find(|(_, _, certificate)| {
            let claims = &certificate.segments;
            !certificate.lowered.is_empty() && claims.len() > 1 && claims[0] != claims[1]
        })
        .unwrap();
    assert!(verified(&model, &path, &certificate).is_ok());
    let changes: [fn(&mut Certificate); 9] = [
        |c| c.checker_version -= 1,
        |c| c.clearance_m = c.clearance_m.next_down(),
        |c| c.lowered[0].floor = c.lowered[0].floor.next_down(),
        |c| c.lowered.clear(),
        |c| c.segments.swap(0, 1),
        |c| c.segments[0].clearance_m = c.segments[0].clearance_m.map(f64::next_down),
        |c| c.segments[0].intervals += 1,
        |c| c.segments.truncate(1),
        |c| c.unwrapped = !c.unwrapped,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let mut changed = certificate.clone();
        change(&mut changed);
        let found = verified(&model, &path, &changed);
        assert!(
            matches!(found, Err(Objection::Edited { .. })),
            "change {index}: {found:?}"
        );
    }
    let whole = (model, path, certificate);
    let dropped = forged(&whole, |certificate| certificate.segments.truncate(1));
    assert!(
        matches!(dropped, Err(Objection::Count { what: "claims", .. })),
        "{dropped:?}"
    );
    let held = forged(&whole, |certificate| certificate.held = Some(vec![0.0; 99]));
    assert!(matches!(held, Err(Objection::Count { .. })), "{held:?}");
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        let found = forged(&whole, |certificate| {
            certificate.segments[0].clearance_m = Some(bad)
        });
        assert!(
            matches!(found, Err(Objection::Number { .. } | Objection::Less(_))),
            "{bad}: {found:?}"
        );
        let found = forged(&whole, |certificate| certificate.lowered[0].floor = bad);
        assert!(
            matches!(found, Err(Objection::Number { .. })),
            "{bad}: {found:?}"
        );
    }
}

#[test]
fn older_versions_are_verified_and_newer_ones_are_not() {
    let mut rng = Rng::with_seed(12);
    let (model, path, certificate) = std::iter::repeat_with(|| proved(&mut rng))
        .flatten()
        .next()
        .unwrap();
    let of_version = |checker_version, digest: bool| {
        let certificate = Certificate {
            checker_version,
            digest: None,
            ..certificate.clone()
        };
        verified(
            &model,
            &path,
            &if digest {
                certificate.sealed()
            } else {
                certificate
            },
        )
    };
    assert!(of_version(1, false).is_ok() && of_version(CHECKER_VERSION, true).is_ok());
    assert_eq!(
        of_version(CHECKER_VERSION, false),
        Err(Objection::NoDigest(CHECKER_VERSION))
    );
    for unknown in [0, CHECKER_VERSION + 1] {
        assert_eq!(of_version(unknown, true), Err(Objection::Version(unknown)));
    }
}

/// V is above what any point of a body does, and not so far above that it would be of no use.
#[test]
fn no_point_is_faster_than_the_plain_bound() {
    let (count, mut rng) = cases(300);
    let mut ratios = Vec::new();
    let mut seen = 0.0_f64;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let mut velocity = vec![0.0; robot.space().nv()];
        robot
            .space()
            .difference(&to, &from, &mut velocity);
        let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
        let at = |q: &[f64]| {
            let mut kinematics = Kinematics::default();
            kinematics.update(robot, q, &held);
            kinematics
        };
        let travel = travel::Travel::new(robot, &velocity, [&at(&from), &at(&to)]);
        for pair in model.pairs() {
            let mut bound = 0.0;
            let mut fastest = 0.0;
            for body in [pair.a, pair.b].map(|body| &model.bodies()[body]) {
                let Some(link) = body.link else { continue };
                let pieces = body.solid.tree.pieces();
                let points = pieces.iter().flat_map(surface_points);
                let points: Vec<_> = points
                    .map(|point| body.place.point(point))
                    .collect();
                let reach = Cover::new(&pieces, &body.place).reach;
                let speed = travel.speed(Some(link), pair.ancestor, reach);
                let sampled = sampled_motion(robot, &from, &velocity, link, pair.ancestor, &points);
                assert!(
                    sampled.0 <= speed * (1.0 + 1e-6) + 1e-6,
                    "{} above {speed}",
                    sampled.0
                );
                bound += speed;
                fastest += sampled.0;
            }
            if fastest > 1e-3 {
                ratios.push(bound / fastest);
                seen = seen.max(fastest / bound);
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{} pairs, median of bound over fastest point {:.2}",
        ratios.len(),
        ratios[ratios.len() / 2]
    );
    assert!(
        ratios[ratios.len() / 2] < 4.0 && seen > 0.9,
        "of no use: {seen}"
    );
}

#[test]
fn a_search_of_covers_finds_what_trying_all_pieces_finds() {
    let (count, mut rng) = cases(200);
    let mut met = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let mut kinematics = Kinematics::default();
        let held: Vec<f64> = model
            .robot()
            .held()
            .iter()
            .map(|h| h.default)
            .collect();
        kinematics.update(
            model.robot(),
            &testing::configuration(&mut rng, model.robot()),
            &held,
        );
        for pair in model.pairs() {
            let a = &model.bodies()[pair.a];
            let b = &model.bodies()[pair.b];
            let relative = b
                .placed(&kinematics)
                .inverse_of(&a.placed(&kinematics));
            let [of_a, of_b] = [a, b].map(|body| body.solid.tree.pieces());
            let all = of_a
                .iter()
                .flat_map(|x| of_b.iter().map(move |y| (x, y)));
            let least = all
                .map(|(x, y)| crate::solid::distance::separation(&x.transformed(&relative), y).gap)
                .fold(f64::INFINITY, f64::min);
            let [a, b] = [a, b].map(|body| Cover::new(&body.solid.tree.pieces(), &body.place));
            let found = cover::near(&a, &b, &relative, f64::INFINITY, cover::Until::Closest);
            // A gap is at most the distance, and pieces farther than the least gap are not looked
            // at.
            assert!(
                found.gap >= least && found.gap <= least.max(0.0) + SMOOTH_M,
                "{} {least}",
                found.gap
            );
            if least > 0.0 {
                let any =
                    |within| cover::near(&a, &b, &relative, within, cover::Until::AnyCloser).gap;
                let above = least + SMOOTH_M;
                let below = least - 1e-6;
                assert!(any(above) < above && any(below) >= below, "{least}");
            }
            met += 1;
        }
    }
    assert!(met > count);
}
