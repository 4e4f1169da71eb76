//! Which pairs are checked, and what a new scene leaves as it is.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::*;
use crate::math::{Pose, Vec3};
use crate::robot::{Kinematics, RobotModel};
use crate::scene::{Obstacle, Scene, SceneChange};
use crate::shape::{PlacedShape, Shape};
use crate::solid::{Solid, TOUCHING_M, query};
use crate::testing;
use crate::validation::soundness::cases;

type Names = BTreeSet<(String, String)>;

fn names(model: &CollisionModel, pairs: &[BodyPair]) -> Names {
    let name = |body: usize| model.bodies()[body].name.to_string();
    pairs
        .iter()
        .map(|pair| ordered(name(pair.a), name(pair.b)))
        .collect()
}

fn ordered(a: String, b: String) -> (String, String) {
    if a <= b { (a, b) } else { (b, a) }
}

/// Whether two carriers move against each other: whether they do from one random configuration to
/// the next.
fn part(
    model: &CollisionModel,
    a: Option<usize>,
    b: Option<usize>,
    rng: &mut fastrand::Rng,
) -> bool {
    let mut seen: Option<nalgebra::Isometry3<f64>> = None;
    (0..3).any(|_| {
        let q = testing::configuration(rng, model.robot());
        let poses = testing::link_poses(model.robot(), &q);
        let pose =
            |link: Option<usize>| link.map_or(nalgebra::Isometry3::identity(), |link| poses[link]);
        let relative = pose(a).inverse() * pose(b);
        let before = *seen.get_or_insert(relative);
        let turn = before.rotation.angle_to(&relative.rotation);
        (before.translation.vector - relative.translation.vector).norm() > 1e-9 || turn > 1e-6
    })
}

/// The rules by names: what the description of the scene says, and whether two carriers are seen to
/// move.
fn expected(model: &CollisionModel, rng: &mut fastrand::Rng) -> (Names, Names) {
    let robot = model.robot();
    let scene = model.scene();
    let mut all = Vec::new();
    for (index, link) in robot
        .links()
        .iter()
        .enumerate()
        .filter(|(_, link)| !link.shapes.is_empty())
    {
        all.push((link.name.clone(), Some(index), None));
    }
    for attached in scene.attached() {
        all.push((
            attached.object.id.clone(),
            robot.link_index(&attached.link_name),
            Some(attached),
        ));
    }
    all.extend(
        scene
            .obstacles()
            .iter()
            .map(|obstacle| (obstacle.id.clone(), None, None)),
    );
    let mut moving = Names::new();
    let mut standing = Names::new();
    for (i, (a, link_a, carried_a)) in all.iter().enumerate() {
        for (b, link_b, carried_b) in &all[i + 1..] {
            let is_named = |(x, y): (&str, &str)| (x == a && y == b) || (x == b && y == a);
            let is_allowed = scene.allowed().any(is_named);
            let is_forbidden = scene.forbidden().any(is_named);
            let are_links =
                carried_a.is_none() && carried_b.is_none() && link_a.is_some() && link_b.is_some();
            let touch = |carried: &Option<&crate::scene::AttachedObject>, other: &String| {
                carried.is_some_and(|carried| {
                    carried.link_name == *other || carried.touch_links.contains(other)
                })
            };
            let by_robot = are_links && robot.is_allowed(link_a.unwrap(), link_b.unwrap());
            let allowed = by_robot || is_allowed || touch(carried_a, b) || touch(carried_b, a);
            if (link_a.is_none() && link_b.is_none()) || (allowed && !is_forbidden) {
                continue;
            }
            if part(model, *link_a, *link_b, rng) {
                moving.insert(ordered(a.clone(), b.clone()));
            } else if !are_links || is_forbidden {
                standing.insert(ordered(a.clone(), b.clone()));
            }
        }
    }
    (moving, standing)
}

#[test]
fn the_pairs_are_those_that_robot_and_scene_say() {
    let (count, mut rng) = cases(300);
    let mut moving = 0;
    let mut standing = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let expected = expected(&model, &mut rng);
        let found = (
            names(&model, model.pairs()),
            names(&model, model.static_pairs()),
        );
        assert_eq!(found, expected);
        assert_eq!(
            model.pairs().len() + model.static_pairs().len(),
            found.0.len() + found.1.len(),
            "a pair twice"
        );
        moving += found.0.len();
        standing += found.1.len();
    }
    assert!(
        moving > 10 * count / 2 && standing > count / 4,
        "{moving} moving, {standing} standing"
    );
}

/// A robot and a scene of meshes, each in a place of its own.
fn cell() -> CollisionModel {
    let mut rng = fastrand::Rng::with_seed(5);
    let with_shapes = |robot: &RobotModel| {
        robot
            .links()
            .iter()
            .filter(|link| !link.shapes.is_empty())
            .count()
            > 1
    };
    let robot = std::iter::repeat_with(|| testing::robot(&mut rng))
        .find(with_shapes)
        .unwrap();
    let obstacles = (0..5).map(|i| {
        let mesh = testing::wedge(Vec3::new(0.1, 0.2, 0.3 + 0.01 * f64::from(i)));
        let shape = PlacedShape {
            pose: Pose::identity(),
            shape: Shape::Mesh(Arc::new(mesh)),
        };
        Obstacle::new(format!("part{i}"), vec![shape])
            .at(Pose::from_translation(Vec3::X * 3.0 * f64::from(i)))
    });
    let scene = Scene::new("cell", obstacles.collect(), Vec::new(), Vec::new()).unwrap();
    CollisionModel::new(Arc::new(robot), Arc::new(scene)).unwrap()
}

/// Counts the solids of a model that no model had before it.
fn count_new(seen: &mut Vec<Arc<Solid>>, model: &CollisionModel) -> usize {
    let before = seen.len();
    for body in model.bodies() {
        if !seen
            .iter()
            .any(|solid| Arc::ptr_eq(solid, &body.solid))
        {
            seen.push(body.solid.clone());
        }
    }
    seen.len() - before
}

#[test]
fn a_change_makes_nothing_anew_but_what_it_brings() {
    let mut model = cell();
    let link = model.bodies()[0].name.to_string();
    let place = Pose::from_translation(Vec3::new(0.0, 1.0, 2.0));
    let id = |i: usize| format!("part{i}");
    let pad = |name: &str, padding| SceneChange::Pad {
        name: name.to_owned(),
        padding,
    };
    let sphere = PlacedShape {
        pose: place,
        shape: Shape::sphere(0.1).unwrap(),
    };
    // The same shapes, read once more.
    let twin = model.scene().obstacles()[4].shapes.to_vec();
    let steps = [
        (
            SceneChange::Move {
                id: id(0),
                pose: place,
            },
            0,
        ),
        (
            SceneChange::Attach {
                id: id(1),
                link_name: link.clone(),
                touch_links: Vec::new(),
                pose: place,
            },
            0,
        ),
        (
            SceneChange::Move {
                id: id(1),
                pose: Pose::identity(),
            },
            0,
        ),
        (SceneChange::Allow(id(1), id(2)), 0),
        (SceneChange::Forbid(link.clone(), id(2)), 0),
        (SceneChange::Remove { id: id(3) }, 0),
        (SceneChange::Add(Obstacle::new("other", vec![sphere])), 1),
        (SceneChange::Add(Obstacle::new("twin", twin)), 0),
        (pad("part2", 0.01), 1),
        (pad(&link, 0.02), 1),
        (
            SceneChange::Move {
                id: id(2),
                pose: Pose::identity(),
            },
            0,
        ),
        (
            SceneChange::Detach {
                id: id(1),
                pose: place,
            },
            0,
        ),
        (pad("part2", 0.0), 0),
    ];
    let mut seen = Vec::new();
    assert_eq!(count_new(&mut seen, &model), model.bodies().len());
    for (change, brings) in steps {
        let scene = Arc::new(model.scene().with([change.clone()]).unwrap());
        model = model.with_scene(scene).unwrap();
        assert_eq!(count_new(&mut seen, &model), brings, "{change:?}");
    }
}

/// Whatever a model was made from, it is the same: bodies, pairs and what the filter sees of them.
#[test]
fn a_changed_model_is_the_one_that_its_scene_makes_from_nothing() {
    let (count, mut rng) = cases(60);
    for _ in 0..count {
        let (robot, first, second) = testing::two_scenes(&mut rng);
        let made = CollisionModel::new(robot.clone(), second.clone()).unwrap();
        let changed = CollisionModel::new(robot, first)
            .unwrap()
            .with_scene(second)
            .unwrap();
        assert!(show(&made) == show(&changed));
    }
}

/// All that a check looks at.
fn show(model: &CollisionModel) -> String {
    let pairs = (
        model.pairs(),
        model.static_pairs(),
        model.hollow_pairs(),
        model.close_pairs(),
    );
    format!("{:?}{pairs:?}{:?}", model.bodies(), model.filter())
}

/// The same after each of many changes to one scene, most of which leave most of the model.
#[test]
fn a_model_that_was_changed_again_and_again_is_the_one_that_its_scene_makes_from_nothing() {
    let (count, mut rng) = cases(20);
    let mut moved = 0;
    for _ in 0..count {
        let robot = Arc::new(testing::robot(&mut rng));
        let obstacle = |rng: &mut fastrand::Rng, i: usize| {
            let shapes = (0..rng.usize(0..3)).map(|_| PlacedShape {
                pose: testing::pose(rng, 0.1),
                shape: testing::shape(rng),
            });
            Obstacle::new(format!("object{i}"), shapes.collect()).at(testing::pose(rng, 1.5))
        };
        let obstacles = (0..30).map(|i| obstacle(&mut rng, i)).collect();
        let scene = Scene::new("many", obstacles, Vec::new(), Vec::new()).unwrap();
        let mut model = CollisionModel::new(robot.clone(), Arc::new(scene)).unwrap();
        for step in 0..30 {
            let id = format!("object{}", rng.usize(0..32));
            let link_name = robot.links()[rng.usize(0..robot.links().len())]
                .name
                .clone();
            let far = if rng.bool() { 1.5 } else { 20.0 };
            let pose = testing::pose(&mut rng, far);
            let change = match rng.u8(0..14) {
                0 => SceneChange::Add(obstacle(&mut rng, 100 + step)),
                1 => SceneChange::Remove { id },
                2 => SceneChange::Attach {
                    id,
                    link_name,
                    touch_links: Vec::new(),
                    pose,
                },
                3 => SceneChange::Detach { id, pose },
                4 => SceneChange::Append {
                    id,
                    shapes: obstacle(&mut rng, 0).shapes.to_vec(),
                },
                5 => SceneChange::Pad {
                    name: id,
                    padding: 0.01,
                },
                6 => SceneChange::Scale {
                    name: if rng.bool() { id } else { link_name },
                    scale: 1.1,
                },
                7 => SceneChange::Allow(id, link_name),
                _ => SceneChange::Move { id, pose },
            };
            moved += usize::from(matches!(change, SceneChange::Move { .. }));
            // What names nothing is refused by the scene or by the model.
            let Ok(scene) = model.scene().with([change]) else {
                continue;
            };
            let Ok(next) = model.with_scene(Arc::new(scene)) else {
                continue;
            };
            let made = CollisionModel::new(robot.clone(), next.scene().clone()).unwrap();
            assert!(show(&next) == show(&made));
            model = next;
        }
    }
    assert!(moved > 5 * count);
}

/// A scale counts where robot and obstacles meet, as padding does, and padding comes on top.
#[test]
fn what_is_scaled_faces_obstacles_as_large_as_it_is_said() {
    let model = cell();
    let link = model.bodies()[0].name.to_string();
    let size = |name: &str, scale, padding| {
        let name = name.to_owned();
        [
            SceneChange::Scale {
                name: name.clone(),
                scale,
            },
            SceneChange::Pad { name, padding },
        ]
    };
    let changes = [size(&link, 2.0, 0.01), size("part0", 0.5, 0.0)].concat();
    let changed = model
        .with_scene(Arc::new(model.scene().with(changes).unwrap()))
        .unwrap();
    let radius =
        |model: &CollisionModel, body: usize| model.bodies()[body].solid.tree.ball(0).radius;
    let plain = 0;
    let facing = model.carried_bodies().len();
    assert_eq!(
        radius(&changed, plain),
        radius(&model, plain),
        "among its own links it is as it is"
    );
    assert_eq!(&*changed.bodies()[facing].name, link);
    let grown = radius(&changed, facing) / radius(&model, plain);
    assert!(grown > 1.5, "{grown}");
    let part = |model: &CollisionModel| {
        model
            .bodies()
            .iter()
            .position(|body| &*body.name == "part0")
            .unwrap()
    };
    let shrunk = radius(&changed, part(&changed)) / radius(&model, part(&model));
    assert!((shrunk - 0.5).abs() < 1e-9, "{shrunk}");
    let weights =
        |model: &CollisionModel| crate::collision::reach_weights(model.robot(), model.bodies());
    assert_eq!(
        weights(&changed),
        weights(&model),
        "lengths stay comparable"
    );
}

#[test]
fn names_that_are_not_there_are_refused_with_those_that_are() {
    let model = cell();
    let link = model.bodies()[0].name.to_string();
    let attach = |link_name: &str, touch_links: &[&str]| SceneChange::Attach {
        id: "part1".into(),
        link_name: link_name.into(),
        touch_links: touch_links
            .iter()
            .map(|name| (*name).to_owned())
            .collect(),
        pose: Pose::identity(),
    };
    for (change, parts) in [
        (
            attach("claw", &[]),
            ["part1", "\"claw\", which is no link", "links: link0"],
        ),
        (
            attach(&link, &["claw"]),
            [
                "lets part1 touch claw",
                "\"claw\" is neither",
                "objects: part0",
            ],
        ),
        (
            SceneChange::Scale {
                name: "claw".into(),
                scale: 2.0,
            },
            ["scales claw", "\"claw\" is neither", "links: link0"],
        ),
        (
            SceneChange::Pad {
                name: "claw".into(),
                padding: 0.1,
            },
            ["pads claw", "\"claw\" is neither", "links: link0"],
        ),
        (
            SceneChange::Allow("claw".into(), link.clone()),
            ["allows claw", "\"claw\" is neither", "objects: part0"],
        ),
        (
            SceneChange::Forbid("part0".into(), "claw".into()),
            ["forbids part0 × claw", "\"claw\"", "links: link0"],
        ),
    ] {
        let scene = model.scene().with([change]).unwrap();
        let text = model
            .with_scene(Arc::new(scene))
            .unwrap_err()
            .to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)) && !text.contains('\n'),
            "{text}"
        );
    }
    let kinematics = Kinematics::default();
    let text = model
        .detach("part1", &kinematics)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("part1") && text.contains("attached objects: none"),
        "{text}"
    );
    let text = model
        .attach("part1", "claw", Vec::new(), &kinematics)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("claw") && text.contains("links: link0"),
        "{text}"
    );
}

#[test]
fn nearly_closest_points_are_nearly_closest() {
    let (count, mut rng) = cases(400);
    let mut apart = 0;
    let mut touching = 0;
    let mut off = 0;
    for _ in 0..count {
        let model = testing::model(&mut rng);
        let held: Vec<f64> = model
            .robot()
            .held()
            .iter()
            .map(|held| held.default)
            .collect();
        let mut kinematics = Kinematics::default();
        kinematics.update(
            model.robot(),
            &testing::configuration(&mut rng, model.robot()),
            &held,
        );
        for pair in model.pairs() {
            let a = &model.bodies()[pair.a];
            let b = &model.bodies()[pair.b];
            let at_a = a.placed(&kinematics);
            let at_b = b.placed(&kinematics);
            let exact = query::between_surfaces(&a.solid, &at_a, &b.solid, &at_b);
            let nearly = query::nearly_closest(&a.solid, &at_a, &b.solid, &at_b);
            assert!((nearly.normal.length() - 1.0).abs() < 1e-9, "{nearly:?}");
            if exact.distance <= TOUCHING_M {
                assert!(
                    (0.0..=TOUCHING_M).contains(&nearly.distance),
                    "{nearly:?} of {exact:?}"
                );
                touching += 1;
                continue;
            }
            let most = (1.0 + query::NEARLY) * exact.distance + 1e-9;
            assert!(
                (exact.distance - 1e-9..=most).contains(&nearly.distance),
                "{nearly:?} of {exact:?}"
            );
            // The points are that far apart, along the normal.
            let offset = nearly.point_a - nearly.point_b - nearly.normal * nearly.distance;
            assert!(offset.length() < 1e-6, "{nearly:?} is off by {offset:?}");
            apart += 1;
            off += usize::from(nearly.distance > exact.distance + 1e-6);
        }
    }
    println!("{apart} pairs apart, {off} of them not quite the closest, {touching} touch");
    assert!(
        apart > count && touching > count / 10,
        "{apart} apart, {touching} touch"
    );
}
