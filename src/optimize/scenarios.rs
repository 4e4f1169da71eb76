//! A disc in the plane around the corners of boxes, where the shortest path is known.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::Arc;

use super::active_set::ActiveSet;
use super::cost::Cost;
use super::holds::{HeldModel, Holds, Ray};
use super::task::Task;
use super::testing;
use super::{Mode, Outcome, Settings, Workspace, run};
use crate::collision::CollisionModel;
use crate::math::{Pose, Vec3};
use crate::path::{Metric, Path};
use crate::scene::{Obstacle, Scene};
use crate::shape::{Cloud, PlacedShape, Shape, Voxel};
use crate::validation::{HitReason, Requirement, Scratch, SegmentRefusal, Validator};

/// Discs, and how much longer than the shortest their paths may be.
const DISCS: [(f64, f64); 3] = [
    // Distances are aimed at two floors, and the last steps gain less than is worth going on for.
    (0.01, 2e-3),
    // The direction of a corner turns within millimetres: half-spaces hardly say what comes, and
    // the steps get short.
    (2e-3, 1e-2),
    // The way round a corner is an arc, and no segment is split that is shorter than 0.04 of the
    // path.
    (0.2, 5e-3),
];
const CLEARANCE_M: f64 = 1e-4;

/// A disc among boxes that are given by their corners in the plane.
fn disc_among(radius: f64, boxes: &[[f64; 4]]) -> CollisionModel {
    let obstacle = |(index, &[left, low, right, high]): (usize, &[f64; 4])| {
        let shape = Shape::cuboid(Vec3::new(right - left, high - low, 1.0)).expect("a size");
        let middle = Vec3::new(0.5 * (left + right), 0.5 * (low + high), 0.0);
        Obstacle::new(
            format!("box{index}"),
            vec![PlacedShape {
                pose: Pose::from_translation(middle),
                shape,
            }],
        )
    };
    let scene = Scene::new(
        "plane",
        boxes.iter().enumerate().map(obstacle).collect(),
        Vec::new(),
        Vec::new(),
    );
    CollisionModel::new(
        Arc::new(testing::disc(radius)),
        Arc::new(scene.expect("boxes")),
    )
    .expect("a model")
}

/// The same with all boxes as one cloud, a layer of voxels of a decimetre.
fn disc_among_voxels(radius: f64, boxes: &[[f64; 4]]) -> CollisionModel {
    const SIZE: f64 = 0.1;
    let middles = |low: f64, high: f64| {
        let count = ((high - low) / SIZE).round() as usize;
        (0..count).map(move |i| low + SIZE * (i as f64 + 0.5))
    };
    let voxels_of = |&[left, low, right, high]: &[f64; 4]| {
        let columns = middles(left, right);
        columns.flat_map(move |x| {
            middles(low, high).map(move |y| Voxel {
                center: [x, y, 0.0],
                size: SIZE,
            })
        })
    };
    let voxels: Vec<_> = boxes.iter().flat_map(voxels_of).collect();
    let cloud = Cloud::of_voxels(&voxels).expect("voxels");
    let map = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Cloud(Arc::new(cloud)),
    };
    let map = Obstacle::new("map", vec![map]);
    let scene = Scene::new("plane", vec![map], Vec::new(), Vec::new());
    CollisionModel::new(
        Arc::new(testing::disc(radius)),
        Arc::new(scene.expect("a map")),
    )
    .expect("a model")
}

fn shorten(model: &CollisionModel, rows: &[[f64; 2]], mode: Mode) -> Outcome {
    let path = Path::from_rows(2, rows.concat()).expect("whole rows");
    let settings = Settings {
        mode,
        clearance_m: CLEARANCE_M,
        weights: Some(vec![1.0; 2]),
        ..Settings::default()
    };
    run(
        model,
        &path,
        &settings,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    )
    .expect("a valid request")
}

/// Shortens in both modes that know contacts, and compares with the shortest path that keeps the
/// clearance.
fn is_pulled_taut(model: &CollisionModel, rows: &[[f64; 2]], shortest: f64, tolerance: f64) {
    for mode in [Mode::Contact, Mode::Hybrid] {
        let Outcome {
            path,
            proved,
            length_after,
            ..
        } = shorten(model, rows, mode);
        let longer = length_after / shortest - 1.0;
        println!(
            "{}: {longer:.6} longer than {shortest}, {} waypoints",
            mode.name(),
            path.len()
        );
        assert!(
            proved && (0.0..tolerance).contains(&longer),
            "{}: {longer} longer than {shortest}",
            mode.name()
        );
    }
}

/// Tangent from a place to a circle around a corner, and the arc from the direction `top` on it to
/// where the tangent touches; the place is seen from the corner under the angle `seen`.
fn tangent_and_arc(away: f64, seen: f64, top: f64, radius: f64) -> f64 {
    (away * away - radius * radius).sqrt() + radius * (seen - top - (radius / away).acos())
}

#[test]
fn a_path_is_pulled_taut_around_a_corner() {
    for (radius, tolerance) in DISCS {
        // The corner is at the origin, the box below and left of it.
        let model = disc_among(radius, &[[-2.0, -2.0, 0.0, 0.0]]);
        let from: [f64; 2] = [-1.0, 0.3];
        let away = from[0].hypot(from[1]);
        let seen = from[1].atan2(from[0]);
        // The ends mirror each other.
        let shortest = 2.0 * tangent_and_arc(away, seen, FRAC_PI_4, radius + CLEARANCE_M);
        let rows = [from, [-0.5, 0.9], [0.8, 0.9], [0.9, -0.4], [0.3, -1.0]];
        is_pulled_taut(&model, &rows, shortest, tolerance);
    }
}

#[test]
fn a_path_is_pulled_taut_around_two_corners() {
    for (radius, tolerance) in DISCS {
        let model = disc_among(radius, &[[-0.5, -2.0, 0.5, 0.0]]);
        let away = 0.5_f64.hypot(1.0);
        // From the corner at the left the path's end is seen below; over the top the path is
        // straight for a metre.
        let seen = PI + 1.0_f64.atan2(0.5);
        let shortest = 2.0 * tangent_and_arc(away, seen, FRAC_PI_2, radius + CLEARANCE_M) + 1.0;
        let rows = [
            [-1.0, -1.0],
            [-1.1, 0.6],
            [0.0, 1.0],
            [1.2, 0.7],
            [1.0, -1.0],
        ];
        is_pulled_taut(&model, &rows, shortest, tolerance);
    }
}

/// A map is one body: what holds the path there on one side must not hide what holds it on the other.
#[test]
fn a_path_is_pulled_taut_between_the_voxels_of_a_map() {
    for (radius, tolerance) in DISCS {
        let rows = [
            [-1.0, -1.0],
            [-1.1, 0.6],
            [0.0, 1.0],
            [1.2, 0.7],
            [1.0, -1.0],
        ];
        let post = [-0.5, -2.0, 0.5, 0.0];
        // A lintel that leaves a corridor to the path.
        let lintel = [-0.5, 0.5, 0.5, 1.5];
        let around = |rows: &[[f64; 2]], boxes: &[[f64; 4]]| {
            let exact = shorten(&disc_among(radius, boxes), rows, Mode::Contact);
            let map = disc_among_voxels(radius, boxes);
            for mode in [Mode::Contact, Mode::Hybrid] {
                let Outcome {
                    proved,
                    length_after,
                    ..
                } = shorten(&map, rows, mode);
                let longer = length_after / exact.length_after - 1.0;
                println!("{}: {longer:.6} longer than among boxes", mode.name());
                assert!(
                    proved && longer < tolerance,
                    "{}: {longer} longer",
                    mode.name()
                );
            }
        };
        around(&rows, &[post]);
        let through = [[-1.0, -1.0], [-1.0, 0.25], [1.0, 0.25], [1.0, 1.5]];
        around(&through, &[post, lintel]);
    }
}

#[test]
fn a_refusal_names_the_voxel_that_is_met() {
    let map = disc_among_voxels(0.01, &[[0.0, -0.1, 0.1, 0.2]]);
    let Outcome { refusal, .. } = shorten(&map, &[[-1.0, 0.07], [1.0, 0.07]], Mode::Check);
    let hint = refusal.expect("it goes through the map").hint;
    let expected = "it is an occupied cell of 0.1 m of map at (0.0500, 0.0500, 0.0000)";
    assert_eq!(hint, expected);
    let Outcome { refusal, .. } = shorten(&map, &[[0.05, 0.07], [1.0, 0.07]], Mode::Check);
    let hint = refusal.expect("it begins in the map").hint;
    assert!(
        hint.starts_with(expected) && hint.contains("(at)"),
        "{hint}"
    );
}

/// A path of two segments over a box, and what is refused of one that is pulled down onto it.
#[test]
fn a_split_puts_contacts_where_they_are() {
    let model = disc_among(0.2, &[[-0.5, -2.0, 0.5, 0.0]]);
    let space = model.robot().space();
    let held = [];
    let metric = Metric::new(space, vec![1.0; 2]).expect("positive weights");
    let fixed = [true, false, true];
    let moving = [true; 2];
    let task = Task {
        model: &model,
        space,
        metric: &metric,
        held: &held,
        constraints: Vec::new(),
        fixed: &fixed,
        fixed_rows: &[],
        moving: &moving,
        keep_goal: false,
        seed: 0,
        work_budget: u64::MAX,
    };
    let mut path =
        Path::from_rows(2, [[-1.0, 0.5], [0.0, 0.5], [1.0, 0.5]].concat()).expect("whole rows");
    let mut scratch = Scratch::default();
    let validator = Validator::new(&model, space, &held, CLEARANCE_M, &mut scratch);
    let floors = validator.floors();
    let cost = Cost::new(space, &metric, path.as_flat(), &fixed, &moving);
    let mut set = ActiveSet::new(2);
    let down = [0.0, 0.0, 0.0, -1.0, 0.0, 0.0];
    set.begin(&cost, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let mut holds = Holds::new(&task);
    let places = [(0, 0.6), (0, 0.85), (1, 0.3)];
    for (segment, t) in places {
        let refusal = SegmentRefusal {
            segment,
            t,
            requirement: Requirement::Clearance(0),
            reason: HitReason::Collision,
        };
        holds.learn(
            &refusal,
            Ray {
                path: &path,
                step: &down,
                part: 1.0,
            },
            &mut HeldModel {
                floors,
                cost: &cost,
                set: &mut set,
            },
        );
    }
    assert_eq!(
        set.rows().len(),
        places.len(),
        "each half-space excludes the trial"
    );
    let at = |path: &Path, set: &ActiveSet| -> Vec<Vec<f64>> {
        let place = |row: super::rows::Row| {
            space.between(
                path.waypoint(row.segment),
                path.waypoint(row.segment + 1),
                row.ratio,
            )
        };
        set.rows().iter().map(place).collect()
    };
    let before = at(&path, &set);
    // Between the two of the first segment, then at one.
    for (segment, ratio) in [(0, 0.7), (2, 0.3)] {
        let middle = space.between(path.waypoint(segment), path.waypoint(segment + 1), ratio);
        path.splice(segment + 1..segment + 1, &middle);
        holds.split(segment, ratio);
        let fixed: Vec<bool> = (0..path.len())
            .map(|i| i == 0 || i + 1 == path.len())
            .collect();
        let cost = Cost::new(space, &metric, path.as_flat(), &fixed, &moving);
        set.begin(&cost, &vec![0.0; path.len() * 2]);
        let mut model = HeldModel {
            floors,
            cost: &cost,
            set: &mut set,
        };
        holds.linearise(&path, &mut model);
        let after = at(&path, &set);
        assert_eq!(before.len(), after.len());
        for (before, after) in before.iter().zip(&after) {
            assert!(
                (before[0] - after[0]).hypot(before[1] - after[1]) < 1e-12,
                "{before:?} went to {after:?}"
            );
        }
    }
}
