//! Attached objects, touch links, padding and pairs, against an oracle that shares nothing with the
//! checker: it has its own kinematics, distances and rules, and looks at thousands of places on the
//! way.

use std::sync::Arc;

use fastrand::Rng;
use taut::collision::CollisionModel;
use taut::math::{Pose, Quat, Vec3, quat_exp};
use taut::optimize::{Mode, Outcome, Settings, Workspace, run};
use taut::path::Path;
use taut::robot::{
    JointDescription, JointKind, Kinematics, LinkDescription, RobotDescription, RobotModel,
    Semantics,
};
use taut::scene::{Obstacle, Scene, SceneChange};
use taut::shape::{Mesh, PlacedShape, Shape};

const CLEARANCE_M: f64 = 1e-3;
/// Places that the oracle looks at; between two of them nothing here comes nearer than [`BLIND_M`].
const SAMPLES: usize = 3000;
const BLIND_M: f64 = 4e-4;

/// Links of the robot, each with a ball: a name, the ball's centre in the link's frame and its
/// radius.
const LINKS: [(&str, f64, f64); 5] = [
    ("base", 0.0, 0.08),
    ("arm", 0.42, 0.05),
    ("hand", 0.0, 0.05),
    ("finger_left", 0.0, 0.015),
    ("finger_right", 0.0, 0.015),
];
/// What the robot's semantics allow to touch.
const DISABLED: [(&str, &str); 6] = [
    ("base", "arm"),
    ("arm", "hand"),
    ("hand", "finger_left"),
    ("hand", "finger_right"),
    ("arm", "finger_left"),
    ("arm", "finger_right"),
];

fn robot() -> Arc<RobotModel> {
    let link = |(name, along, radius): (&str, f64, f64)| LinkDescription {
        name: name.into(),
        collision: vec![PlacedShape {
            pose: at(along, 0.0, 0.0),
            shape: Shape::sphere(radius).unwrap(),
        }],
    };
    let joint =
        |name: &str, kind, [parent, child]: [&str; 2], x: f64, axis, limits| JointDescription {
            name: name.into(),
            kind,
            parent: parent.into(),
            child: child.into(),
            origin: at(x, 0.0, 0.0),
            axis,
            limits: Some(limits),
            soft_limits: None,
            mimic: None,
        };
    let turn = JointKind::Revolute;
    let slide = JointKind::Prismatic;
    let disabled_collisions = DISABLED
        .map(|(a, b)| (a.min(b).to_owned(), a.max(b).to_owned()))
        .to_vec();
    let description = RobotDescription {
        name: "gripper".into(),
        links: LINKS.map(link).to_vec(),
        joints: vec![
            joint("shoulder", turn, ["base", "arm"], 0.0, Vec3::Z, (-3.1, 3.1)),
            joint("wrist", turn, ["arm", "hand"], 0.5, Vec3::Z, (-3.1, 3.1)),
            joint(
                "left",
                slide,
                ["hand", "finger_left"],
                0.08,
                Vec3::Y,
                (0.02, 0.1),
            ),
            joint(
                "right",
                slide,
                ["hand", "finger_right"],
                0.08,
                -Vec3::Y,
                (0.02, 0.1),
            ),
        ],
        semantics: Some(Semantics {
            disabled_collisions,
            ..Semantics::default()
        }),
        ..RobotDescription::default()
    };
    Arc::new(RobotModel::new(description).unwrap())
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(Vec3::new(x, y, z))
}

/// Where the links are, by hand.
fn frame(link: &str, q: &[f64]) -> Pose {
    let turned = |x: f64, angle: f64| Pose::from_parts(Vec3::X * x, Quat::from_rotation_z(angle));
    let arm = turned(0.0, q[0]);
    let hand = turned(0.5, q[1]);
    match link {
        "base" => Pose::identity(),
        "arm" => arm,
        "hand" => arm * hand,
        "finger_left" => arm * hand * at(0.08, q[2], 0.0),
        "finger_right" => arm * hand * at(0.08, -q[3], 0.0),
        other => panic!("no link {other}"),
    }
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Ball(f64),
    /// Half sizes, and whether it is given as a mesh.
    Brick(Vec3, bool),
}

/// An object as the oracle knows it.
#[derive(Clone, Debug)]
struct Thing {
    name: String,
    carrier: Option<&'static str>,
    pose: Pose,
    form: Form,
    touches: Vec<String>,
    padding: f64,
}

impl Thing {
    fn new(name: &str, pose: Pose, form: Form) -> Self {
        Self {
            name: name.into(),
            carrier: None,
            pose,
            form,
            touches: Vec::new(),
            padding: 0.0,
        }
    }

    fn on(self, link: &'static str, touches: &[&str]) -> Self {
        Self {
            carrier: Some(link),
            touches: touches
                .iter()
                .map(|name| (*name).to_owned())
                .collect(),
            ..self
        }
    }

    fn obstacle(&self) -> Obstacle {
        let shape = match self.form {
            Form::Ball(radius) => Shape::sphere(radius).unwrap(),
            Form::Brick(half, false) => Shape::cuboid(half * 2.0).unwrap(),
            Form::Brick(half, true) => Shape::Mesh(Arc::new(brick_mesh(half))),
        };
        Obstacle::new(
            self.name.clone(),
            vec![PlacedShape {
                pose: Pose::identity(),
                shape,
            }],
        )
        .at(self.pose)
    }

    fn placed(&self, q: &[f64]) -> Pose {
        self.carrier
            .map_or(self.pose, |link| frame(link, q) * self.pose)
    }
}

fn brick_mesh(half: Vec3) -> Mesh {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(sign(0) * half.x, sign(1) * half.y, sign(2) * half.z)
    };
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Mesh::new("brick", (0..8).map(corner).collect(), triangles).unwrap()
}

/// Objects, and pairs that the scene allows or forbids.
#[derive(Clone, Debug, Default)]
struct World {
    things: Vec<Thing>,
    allowed: Vec<(String, String)>,
    forbidden: Vec<(String, String)>,
    /// Padding of links.
    padding: Vec<(&'static str, f64)>,
}

fn pair(a: &str, b: &str) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

fn has(pairs: &[(String, String)], a: &str, b: &str) -> bool {
    pairs
        .iter()
        .any(|(c, d)| (c == a && d == b) || (c == b && d == a))
}

impl World {
    fn of(things: &[Thing]) -> Self {
        Self {
            things: things.to_vec(),
            ..Self::default()
        }
    }

    /// Made by changes, one at a time, from a scene without anything.
    fn scene(&self) -> Scene {
        let mut scene = Scene::default();
        for thing in &self.things {
            scene = scene
                .with([SceneChange::Add(thing.obstacle())])
                .unwrap();
            if let Some(link) = thing.carrier {
                let id = thing.name.clone();
                let link_name = link.to_owned();
                let touch_links = thing.touches.clone();
                // Names of objects that come later are known at the end.
                scene = scene
                    .with([SceneChange::Attach {
                        id,
                        link_name,
                        touch_links,
                        pose: thing.pose,
                    }])
                    .unwrap();
            }
            scene = scene
                .with([SceneChange::Pad {
                    name: thing.name.clone(),
                    padding: thing.padding,
                }])
                .unwrap();
        }
        let allowed = self
            .allowed
            .iter()
            .map(|(a, b)| SceneChange::Allow(a.clone(), b.clone()));
        let forbidden = self
            .forbidden
            .iter()
            .map(|(a, b)| SceneChange::Forbid(a.clone(), b.clone()));
        let padded = self
            .padding
            .iter()
            .map(|&(name, padding)| SceneChange::Pad {
                name: name.into(),
                padding,
            });
        scene
            .with(allowed.chain(forbidden).chain(padded))
            .unwrap()
    }

    /// Links and objects.
    fn all(&self) -> Vec<Thing> {
        let link = |(name, along, radius): (&'static str, f64, f64)| {
            let padding = self
                .padding
                .iter()
                .find(|(link, _)| *link == name)
                .map_or(0.0, |(_, padding)| *padding);
            Thing {
                padding,
                ..Thing::new(name, at(along, 0.0, 0.0), Form::Ball(radius)).on(name, &[])
            }
        };
        LINKS
            .into_iter()
            .map(link)
            .chain(self.things.iter().cloned())
            .collect()
    }

    fn may_touch(&self, a: &Thing, b: &Thing) -> bool {
        let is_link = |thing: &Thing| thing.carrier == Some(thing.name.as_str());
        let disabled = DISABLED
            .iter()
            .any(|&(x, y)| (x == a.name && y == b.name) || (x == b.name && y == a.name));
        let lets = |thing: &Thing, other: &Thing| {
            !is_link(thing)
                && thing
                    .carrier
                    .is_some_and(|link| link == other.name)
                || thing.touches.contains(&other.name)
        };
        (a.carrier.is_none() && b.carrier.is_none())
            || !has(&self.forbidden, &a.name, &b.name)
                && (disabled || has(&self.allowed, &a.name, &b.name) || lets(a, b) || lets(b, a))
    }

    /// The least distance on the way, and between whom.
    fn least(&self, from: &[f64], to: &[f64]) -> (f64, [String; 2]) {
        let all = self.all();
        let mut least = (f64::INFINITY, [String::new(), String::new()]);
        for (i, a) in all.iter().enumerate() {
            for b in all[i + 1..]
                .iter()
                .filter(|b| !self.may_touch(a, b))
            {
                for sample in 0..=SAMPLES {
                    let t = sample as f64 / SAMPLES as f64;
                    let q: Vec<f64> = from
                        .iter()
                        .zip(to)
                        .map(|(x, y)| x + t * (y - x))
                        .collect();
                    let mut distance = distance(a, b, &q);
                    if a.carrier.is_none() || b.carrier.is_none() {
                        distance -= a.padding + b.padding;
                    }
                    if distance < least.0 {
                        least = (distance, [a.name.clone(), b.name.clone()]);
                    }
                }
            }
        }
        least
    }
}

/// Distance of two things, of which at least one is a ball.
fn distance(a: &Thing, b: &Thing, q: &[f64]) -> f64 {
    let at_a = a.placed(q);
    let at_b = b.placed(q);
    match (a.form, b.form) {
        (Form::Ball(r), Form::Ball(s)) => at_a.translation.distance(at_b.translation) - r - s,
        (Form::Ball(radius), Form::Brick(half, _)) => {
            let local = at_b.rotation.inverse() * (at_a.translation - at_b.translation);
            (local.abs() - half).max(Vec3::ZERO).length() - radius
        }
        (Form::Brick(..), Form::Ball(_)) => distance(b, a, q),
        (Form::Brick(..), Form::Brick(..)) => panic!("the oracle has no distance of two bricks"),
    }
}

fn model(world: &World) -> CollisionModel {
    CollisionModel::new(robot(), Arc::new(world.scene())).unwrap()
}

fn check(model: &CollisionModel, from: &[f64], to: &[f64]) -> Outcome {
    let path = Path::from_rows(4, [from, to].concat()).unwrap();
    let settings = Settings {
        mode: Mode::Check,
        strict: true,
        clearance_m: CLEARANCE_M,
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
    .unwrap()
}

/// Checker and oracle must agree; true for proved.
fn agreed(world: &World, from: &[f64], to: &[f64]) -> bool {
    let outcome = check(&model(world), from, to);
    let (least, whom) = world.least(from, to);
    if outcome.proved {
        assert!(
            least >= CLEARANCE_M,
            "proved, but {whom:?} come as near as {least}: {world:?}"
        );
    } else {
        let refused = outcome.refusal.unwrap();
        let near = 1.5 * CLEARANCE_M + BLIND_M;
        assert!(
            least < near,
            "{:?} refused, but nothing is nearer than {least}: {world:?}",
            refused.requirement
        );
    }
    outcome.proved
}

fn refused(world: &World, from: &[f64], to: &[f64]) -> Vec<String> {
    assert!(!agreed(world, from, to), "it should be refused");
    let mut bodies = check(&model(world), from, to)
        .refusal
        .unwrap()
        .requirement
        .names;
    bodies.sort();
    bodies
}

const FROM: [f64; 4] = [0.0, 0.0, 0.03, 0.03];
const TO: [f64; 4] = [1.5, 0.3, 0.03, 0.03];

/// A post between both ends, out of the robot's own reach by some centimetres.
fn post() -> Thing {
    Thing::new("post", at(0.5, 0.6, 0.0), Form::Ball(0.1))
}

fn rod(as_mesh: bool) -> Thing {
    Thing::new(
        "rod",
        at(0.15, 0.0, 0.0),
        Form::Brick(Vec3::new(0.14, 0.01, 0.01), as_mesh),
    )
}

#[test]
fn what_is_attached_moves_with_its_link() {
    for as_mesh in [false, true] {
        assert!(agreed(&World::of(&[post()]), &FROM, &TO));
        let carried = rod(as_mesh).on("hand", &[]);
        let world = World::of(&[post(), carried.clone()]);
        assert_eq!(refused(&world, &FROM, &TO), ["post", "rod"]);
        // Beside the world's origin, where its pose would put it if it stood there, it is nobody's.
        let far = World::of(&[
            Thing::new("post", at(0.15, 0.0, 0.3), Form::Ball(0.1)),
            carried,
        ]);
        assert!(agreed(&far, &FROM, &TO));
    }
}

#[test]
fn touch_links_allow_a_finger_and_no_other_link() {
    let held = Thing::new(
        "cube",
        at(0.08, 0.0, 0.0),
        Form::Brick(Vec3::splat(0.02), false),
    );
    assert!(agreed(
        &World::of(&[held
            .clone()
            .on("hand", &["finger_left", "finger_right"])]),
        &FROM,
        &TO
    ));
    assert_eq!(
        refused(
            &World::of(&[held.clone().on("hand", &["finger_left"])]),
            &FROM,
            &TO
        ),
        ["cube", "finger_right"]
    );
    // The wrist folds the cube against the arm.
    let world = World::of(&[held.on("hand", &["finger_left", "finger_right"])]);
    assert_eq!(
        refused(&world, &FROM, &[0.0, 3.0, 0.03, 0.03]),
        ["arm", "cube"]
    );
}

#[test]
fn two_attached_objects_collide_unless_one_may_touch_the_other() {
    let carried = Thing::new("cup", at(0.05, 0.0, 0.0), Form::Ball(0.03));
    let bar = Thing::new(
        "bar",
        at(0.0, 0.0, 0.0),
        Form::Brick(Vec3::new(0.2, 0.01, 0.01), true),
    );
    let pair = |touches: &[&str]| {
        let touched = ["finger_left", "finger_right", "arm"];
        World::of(&[
            bar.clone().on("hand", &touched),
            carried.clone().on("finger_left", touches),
        ])
    };
    // The left finger opens and closes, the cup on it comes to the bar.
    let open = [0.0, 0.0, 0.1, 0.03];
    let closed = [0.0, 0.0, 0.02, 0.03];
    assert!(agreed(&pair(&["hand"]), &open, &open));
    assert_eq!(refused(&pair(&["hand"]), &open, &closed), ["bar", "cup"]);
    assert!(agreed(&pair(&["hand", "bar"]), &open, &closed));
    // On one link no joint parts them: they are looked at where they stand.
    let stacked = |touches: &[&str]| {
        World::of(&[
            rod(false).on("hand", &[]),
            Thing::new("cup", at(0.2, 0.0, 0.03), Form::Ball(0.03)).on("hand", touches),
        ])
    };
    assert_eq!(refused(&stacked(&[]), &FROM, &TO), ["cup", "rod"]);
    assert!(agreed(&stacked(&["rod"]), &FROM, &TO));
}

#[test]
fn padding_refuses_what_is_nearer_and_proves_what_is_farther() {
    // The hand's ball passes the sphere at `gap` in the middle of the way.
    let beside = |gap: f64| {
        Thing::new(
            "post",
            at(0.5 + 0.05 + 0.1 + gap, 0.0, 0.0),
            Form::Ball(0.1),
        )
    };
    let from = [-0.6, 2.6, 0.03, 0.03];
    let to = [0.6, 2.6, 0.03, 0.03];
    for (gap, padded, plain) in [
        (0.015, false, true),
        (0.025, true, true),
        (-0.001, false, false),
    ] {
        for padding in [[0.02, 0.0], [0.0, 0.02], [0.01, 0.01]] {
            let mut world = World::of(&[Thing {
                padding: padding[1],
                ..beside(gap)
            }]);
            assert_eq!(agreed(&World::of(&[beside(gap)]), &from, &to), plain);
            world.padding = vec![("hand", padding[0])];
            assert_eq!(
                agreed(&world, &from, &to),
                padded,
                "gap {gap}, padding {padding:?}"
            );
        }
    }
    // Fingers a centimetre apart stay free whatever their padding: the robot is checked against
    // itself as it is.
    let world = World {
        padding: vec![("finger_left", 0.02), ("finger_right", 0.02)],
        ..World::default()
    };
    assert!(agreed(
        &world,
        &[0.0, 0.0, 0.02, 0.02],
        &[1.0, 0.0, 0.02, 0.02]
    ));
}

#[test]
fn pairs_are_allowed_and_forbidden_one_by_one() {
    let mut world = World::of(&[post(), rod(true).on("hand", &[])]);
    world.allowed = vec![pair("post", "rod")];
    assert!(agreed(&world, &FROM, &TO));
    // The left finger is folded onto the arm, which the robot's semantics allow.
    let open = [0.0, 0.0, 0.03, 0.03];
    let folded = [0.0, 3.0, 0.03, 0.03];
    let mut world = World::default();
    assert!(agreed(&world, &open, &folded));
    world.forbidden = vec![pair("arm", "finger_left")];
    assert_eq!(refused(&world, &open, &folded), ["arm", "finger_left"]);
    // What is forbidden is checked whatever touch links say.
    let mut world = World::of(&[post(), rod(false).on("hand", &["post"])]);
    assert!(agreed(&world, &FROM, &TO));
    world.forbidden = vec![pair("rod", "post")];
    assert_eq!(refused(&world, &FROM, &TO), ["post", "rod"]);
    // Allowing and forbidding take each other back.
    let scene = world
        .scene()
        .with([SceneChange::Allow("post".into(), "rod".into())])
        .unwrap();
    let model = model(&world)
        .with_scene(Arc::new(scene))
        .unwrap();
    assert!(check(&model, &FROM, &TO).proved);
}

#[test]
fn an_object_is_taken_up_and_put_down_where_it_is() {
    let cup = Thing::new("cup", at(0.5, 0.13, 0.02), Form::Ball(0.02));
    let robot = robot();
    let world = World::of(&[cup]);
    let mut model = CollisionModel::new(robot.clone(), Arc::new(world.scene())).unwrap();
    let mut kinematics = Kinematics::default();
    let taken = [0.0, 0.4, 0.03, 0.03];
    let put = [1.1, -0.6, 0.05, 0.05];
    kinematics.update(&robot, &taken, &[]);
    let change = model
        .attach("cup", "hand", vec!["finger_left".into()], &kinematics)
        .unwrap();
    model = model
        .with_scene(Arc::new(model.scene().with([change]).unwrap()))
        .unwrap();
    assert!(model.scene().obstacles().is_empty());
    let hanging = frame("hand", &taken).inverse() * at(0.5, 0.13, 0.02);
    assert!(
        (model.scene().attached()[0]
            .object
            .pose
            .translation
            - hanging.translation)
            .length()
            < 1e-12
    );
    kinematics.update(&robot, &put, &[]);
    let change = model.detach("cup", &kinematics).unwrap();
    let scene = model.scene().with([change]).unwrap();
    let stands = frame("hand", &put) * hanging;
    let pose = scene.obstacles()[0].pose;
    assert!(
        (pose.translation - stands.translation).length() < 1e-12 && scene.attached().is_empty()
    );
    assert!(pose.rotation.angle_between(stands.rotation) < 1e-7);
    // From now on the hand, which carried it, may not touch it.
    let there = World::of(&[Thing::new("cup", pose, Form::Ball(0.02))]);
    assert_eq!(there.scene().hash(), scene.hash());
    let model = model.with_scene(Arc::new(scene)).unwrap();
    assert_eq!(
        check(&model, &taken, &put).proved,
        agreed(&there, &taken, &put)
    );
}

/// Random objects, carriers, touch links, paddings and pairs.
#[test]
fn verdicts_agree_with_the_oracle() {
    let mut rng = Rng::with_seed(20_150_423);
    let mut proved = 0;
    let mut refused = 0;
    for _ in 0..150 {
        let world = random(&mut rng);
        let mut row = || {
            [
                uniform(&mut rng, -1.5, 1.5),
                uniform(&mut rng, -1.5, 1.5),
                0.03,
                0.04,
            ]
        };
        let from = row();
        let to = row();
        let is_proved = agreed(&world, &from, &to);
        *(if is_proved { &mut proved } else { &mut refused }) += 1;
    }
    println!("{proved} proved, {refused} refused");
    assert!(
        proved > 30 && refused > 30,
        "{proved} proved, {refused} refused"
    );
}

fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

fn random(rng: &mut Rng) -> World {
    let place = |rng: &mut Rng, size: f64| {
        let mut v = |size: f64| {
            Vec3::new(
                uniform(rng, -size, size),
                uniform(rng, -size, size),
                uniform(rng, -size, size),
            )
        };
        Pose::from_parts(v(size), quat_exp(v(1.5)))
    };
    let mut world = World::default();
    // One brick, so that every pair has a ball: it hangs on a link or stands.
    let brick = Form::Brick(Vec3::new(uniform(rng, 0.02, 0.15), 0.02, 0.03), rng.bool());
    let links = ["arm", "hand", "finger_left"];
    let touches: Vec<_> = LINKS
        .iter()
        .map(|(name, ..)| *name)
        .chain(["stone", "cup"])
        .filter(|_| rng.u8(0..3) == 0)
        .collect();
    let cup = Thing::new("cup", place(rng, 0.2), Form::Ball(0.03))
        .on(links[rng.usize(0..3)], &["hand", "finger_left"]);
    let stone = Thing::new(
        "stone",
        at(uniform(rng, -0.8, 0.8), uniform(rng, -0.8, 0.8), 0.0),
        Form::Ball(0.1),
    );
    let brick = Thing::new("brick", place(rng, 0.2), brick).on(links[rng.usize(0..3)], &touches);
    for thing in [stone, cup, brick] {
        let padding = if rng.bool() {
            uniform(rng, 0.0, 0.04)
        } else {
            0.0
        };
        world.things.push(Thing { padding, ..thing });
    }
    let names = [
        "stone",
        "cup",
        "brick",
        "arm",
        "hand",
        "finger_left",
        "finger_right",
    ];
    let mut pairs = || pair(names[rng.usize(0..3)], names[rng.usize(0..7)]);
    world.allowed = vec![pairs(), pairs()];
    world.forbidden = vec![pairs()];
    let forbidden = world.forbidden.clone();
    world
        .allowed
        .retain(|(a, b)| !has(&forbidden, a, b));
    if rng.bool() {
        world.padding = vec![("hand", uniform(rng, 0.0, 0.04)), ("finger_left", 0.01)];
    }
    world
}
