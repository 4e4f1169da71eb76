//! Random robots and scenes for the tests, and an oracle that shares nothing with the checker but
//! the description: nalgebra poses and parry's shapes and distances.

use std::collections::BTreeMap;
use std::sync::Arc;

use fastrand::Rng;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::query;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, SharedShape, TriMesh};

use crate::collision::CollisionModel;
use crate::math::{Pose, Quat, Vec3, quat_exp};
use crate::robot::{
    Drive, JointDescription, JointKind, LinkDescription, Mimic, RobotDescription, RobotModel,
};
use crate::robot::{VirtualJoint, configuration};
use crate::scene::{Obstacle, Scene, SceneChange};
use crate::shape::{Drawn, Mesh, PlacedShape, Shape};
use crate::validation::Requirement;

pub fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

pub fn vector(rng: &mut Rng, size: f64) -> Vec3 {
    Vec3::new(
        uniform(rng, -size, size),
        uniform(rng, -size, size),
        uniform(rng, -size, size),
    )
}

pub fn pose(rng: &mut Rng, size: f64) -> Pose {
    Pose::from_parts(vector(rng, size), quat_exp(vector(rng, 1.8)))
}

pub fn shape(rng: &mut Rng) -> Shape {
    let kind = rng.u8(0..6);
    let mut size = || uniform(rng, 0.03, 0.25);
    match kind {
        0 => Shape::sphere(size()).unwrap(),
        1 => Shape::cuboid(Vec3::new(size(), size(), size()) * 2.0).unwrap(),
        2 => Shape::cylinder(2.0 * size(), size()).unwrap(),
        3 => Shape::capsule(2.0 * size(), size()).unwrap(),
        // A wall of a millimetre.
        4 => Shape::cuboid(Vec3::new(4.0 * size(), 4.0 * size(), 1e-3)).unwrap(),
        _ => Shape::Mesh(Arc::new(wedge(Vec3::new(size(), size(), size())))),
    }
}

/// A closed mesh that is not convex: a box whose top is pressed in to its middle.
pub fn wedge(half: Vec3) -> Mesh {
    let corner = |x: f64, y: f64, z: f64| Vec3::new(x * half.x, y * half.y, z * half.z);
    let mut vertices = vec![corner(0.0, 0.0, 0.0)];
    for z in [-1.0, 1.0] {
        vertices.extend([
            corner(-1.0, -1.0, z),
            corner(1.0, -1.0, z),
            corner(1.0, 1.0, z),
            corner(-1.0, 1.0, z),
        ]);
    }
    let mut triangles = vec![[1, 3, 2], [1, 4, 3]];
    for i in 0..4u32 {
        let j = (i + 1) % 4;
        triangles.extend([
            [1 + i, 1 + j, 5 + j],
            [1 + i, 5 + j, 5 + i],
            [5 + i, 5 + j, 0],
        ]);
    }
    Mesh::new("wedge", vertices, triangles).unwrap()
}

/// A random tree of all joint kinds: chains, branches, mimics, a root that may move.
pub fn robot(rng: &mut Rng) -> RobotModel {
    let count = rng.usize(2..7);
    let mut description = RobotDescription {
        name: "random".into(),
        ..RobotDescription::default()
    };
    let kind = [JointKind::Fixed, JointKind::Planar, JointKind::Floating][rng.usize(0..3)];
    if kind != JointKind::Fixed {
        description.virtual_joint = Some(VirtualJoint {
            name: "root".into(),
            kind,
            position_bounds: Vec::new(),
            parent_frame: String::new(),
        });
    }
    for i in 0..count {
        let bodies = rng.usize(0..3);
        let collision = (0..bodies)
            .map(|_| PlacedShape {
                pose: pose(rng, 0.15),
                shape: shape(rng),
            })
            .collect();
        description.links.push(LinkDescription {
            name: format!("link{i}"),
            collision,
        });
        if i == 0 {
            continue;
        }
        let parent = if rng.f64() < 0.75 {
            i - 1
        } else {
            rng.usize(0..i)
        };
        let kind = match rng.u8(0..10) {
            0 => JointKind::Fixed,
            1 | 2 => JointKind::Prismatic,
            3 => JointKind::Continuous,
            4 => JointKind::Planar,
            5 => JointKind::Floating,
            _ => JointKind::Revolute,
        };
        let master = description
            .joints
            .iter()
            .filter(|j| j.mimic.is_none() && j.kind == kind && kind.nq() == 1);
        let master = master
            .map(|j| j.name.clone())
            .next_back()
            .filter(|_| rng.f64() < 0.25);
        description.joints.push(JointDescription {
            name: format!("joint{i}"),
            kind,
            parent: format!("link{parent}"),
            child: format!("link{i}"),
            origin: pose(rng, 0.4),
            axis: vector(rng, 1.0) + Vec3::new(0.0, 0.0, 1e-3),
            limits: Some(if kind == JointKind::Prismatic {
                (-0.4, 0.5)
            } else {
                (-3.0, 3.0)
            }),
            soft_limits: None,
            mimic: master.map(|joint| Mimic {
                joint,
                multiplier: uniform(rng, -2.0, 2.0),
                offset: 0.1,
            }),
        });
    }
    RobotModel::new(description).unwrap()
}

pub fn scene(rng: &mut Rng) -> Scene {
    let obstacle = |rng: &mut Rng, i: usize| {
        Obstacle::new(
            format!("obstacle{i}"),
            vec![PlacedShape {
                pose: pose(rng, 0.9),
                shape: shape(rng),
            }],
        )
    };
    let obstacles = (0..rng.usize(0..9))
        .map(|i| obstacle(rng, i))
        .collect();
    Scene::new("random", obstacles, Vec::new(), Vec::new()).unwrap()
}

pub fn configuration(rng: &mut Rng, robot: &RobotModel) -> Vec<f64> {
    let mut q: Vec<f64> = robot
        .variables()
        .iter()
        .map(|v| uniform(rng, v.lower.max(-1.0), v.upper.min(1.0)))
        .collect();
    for component in robot.space().components() {
        if let configuration::Component::Rotation { q: first, .. } = *component {
            q[first..first + 4].copy_from_slice(&quat_exp(vector(rng, 1.5)).to_array());
        }
    }
    q
}

/// A second configuration, near or far.
pub fn neighbour(rng: &mut Rng, robot: &RobotModel, from: &[f64]) -> Vec<f64> {
    let scale = [0.02, 0.2, 1.0][rng.usize(0..3)];
    let velocity: Vec<f64> = (0..robot.space().nv())
        .map(|_| uniform(rng, -scale, scale))
        .collect();
    let mut to = vec![0.0; from.len()];
    robot
        .space()
        .integrate(from, &velocity, 1.0, &mut to);
    to
}

/// What every other scene has besides obstacles: objects that links carry, padding of anything,
/// pairs that are allowed or forbidden.
fn living(rng: &mut Rng, robot: &RobotModel, scene: &Scene) -> Scene {
    let link = |rng: &mut Rng| {
        robot.links()[rng.usize(0..robot.links().len())]
            .name
            .clone()
    };
    let mut changes = Vec::new();
    for i in 0..rng.usize(0..3) {
        let id = format!("carried{i}");
        let shape = PlacedShape {
            pose: pose(rng, 0.1),
            shape: shape(rng),
        };
        let link_name = link(rng);
        let touch_links = (0..rng.usize(0..2))
            .map(|_| link(rng))
            .collect();
        changes.push(SceneChange::Add(Obstacle::new(id.clone(), vec![shape])));
        changes.push(SceneChange::Attach {
            id,
            link_name,
            touch_links,
            pose: pose(rng, 0.2),
        });
        let padding = uniform(rng, 0.0, 0.03);
        changes.push(SceneChange::Pad {
            name: if rng.bool() {
                link(rng)
            } else {
                format!("carried{i}")
            },
            padding,
        });
    }
    if let Some(obstacle) = scene.obstacles().first() {
        changes.push(SceneChange::Pad {
            name: obstacle.id.clone(),
            padding: uniform(rng, 0.0, 0.03),
        });
        changes.push(SceneChange::Move {
            id: obstacle.id.clone(),
            pose: pose(rng, 0.2),
        });
    }
    // Its own numbers: what tests have seen of the others stays.
    let mut own = rng.clone();
    let sized: Vec<_> = [robot.links()[0].name.clone()]
        .into_iter()
        .chain(scene.objects().map(|o| o.id.clone()))
        .collect();
    for name in sized {
        let scale = uniform(&mut own, 0.7, 1.4);
        changes.extend((own.u8(0..4) == 0).then_some(SceneChange::Scale { name, scale }));
    }
    let scene = scene.with(changes).unwrap();
    let names: Vec<_> = scene
        .attached()
        .iter()
        .map(|a| &a.object)
        .chain(scene.obstacles())
        .map(|o| &o.id)
        .collect();
    let changes = (0..names.len() / 2).map(|_| {
        let a = names[rng.usize(0..names.len())].clone();
        let b = link(rng);
        let c = if rng.bool() { link(rng) } else { a };
        if rng.bool() {
            SceneChange::Allow(b, c)
        } else {
            SceneChange::Forbid(b, c)
        }
    });
    scene.with(changes.collect::<Vec<_>>()).unwrap()
}

/// A robot and two scenes that share some of their objects.
pub fn two_scenes(rng: &mut Rng) -> (Arc<RobotModel>, Arc<Scene>, Arc<Scene>) {
    let robot = robot(rng);
    let scene = scene(rng);
    let first = living(rng, &robot, &scene);
    let second = living(rng, &robot, &scene);
    (Arc::new(robot), Arc::new(first), Arc::new(second))
}

/// A robot among obstacles.
pub fn plain_model(rng: &mut Rng) -> CollisionModel {
    CollisionModel::new(Arc::new(robot(rng)), Arc::new(scene(rng))).unwrap()
}

/// The same, and in every other scene links carry objects and some things are padded.
pub fn model(rng: &mut Rng) -> CollisionModel {
    let robot = robot(rng);
    let mut scene = scene(rng);
    if rng.bool() {
        scene = living(rng, &robot, &scene);
    }
    CollisionModel::new(Arc::new(robot), Arc::new(scene)).unwrap()
}

/// A ball of 5 cm that moves in the plane, and walls: each a place and half extents.
pub fn slider(walls: &[(Vec3, Vec3)]) -> CollisionModel {
    let joint = |index: usize, axis: Vec3| JointDescription {
        name: format!("joint{index}"),
        kind: JointKind::Prismatic,
        parent: format!("link{index}"),
        child: format!("link{}", index + 1),
        origin: Pose::identity(),
        axis,
        limits: Some((-2.0, 2.0)),
        soft_limits: None,
        mimic: None,
    };
    let ball = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Sphere { radius: 0.05 },
    };
    let link = |index: usize| LinkDescription {
        name: format!("link{index}"),
        collision: match index {
            2 => vec![ball.clone()],
            _ => Vec::new(),
        },
    };
    let description = RobotDescription {
        name: "slider".into(),
        links: (0..3).map(link).collect(),
        joints: vec![joint(0, Vec3::X), joint(1, Vec3::Y)],
        ..RobotDescription::default()
    };
    let wall = |(index, (at, half_extents)): (usize, &(Vec3, Vec3))| {
        Obstacle::new(
            format!("wall{index}"),
            vec![PlacedShape {
                pose: Pose::from_translation(*at),
                shape: Shape::Box {
                    half_extents: *half_extents,
                },
            }],
        )
    };
    let walls = walls.iter().enumerate().map(wall);
    let scene = Scene::new("walls", walls.collect(), Vec::new(), Vec::new()).unwrap();
    CollisionModel::new(
        Arc::new(RobotModel::new(description).unwrap()),
        Arc::new(scene),
    )
    .unwrap()
}

/// World poses of the links by nalgebra, straight from the joints' definitions.
pub fn link_poses(robot: &RobotModel, q: &[f64]) -> Vec<Isometry3<f64>> {
    let held: Vec<f64> = robot.held().iter().map(|h| h.default).collect();
    let mut poses: Vec<Isometry3<f64>> = Vec::new();
    for joint in robot.joints() {
        let x: Vec<f64> = match joint.drive {
            Drive::Fixed => Vec::new(),
            Drive::Variable { q: first, .. } => q[first..first + joint.kind.nq()].to_vec(),
            Drive::Held { first } => held[first..first + joint.kind.nq()].to_vec(),
            Drive::Mimic {
                master,
                multiplier,
                offset,
            } => match robot.joints()[master].drive {
                Drive::Variable { q: first, .. } => vec![multiplier * q[first] + offset],
                Drive::Held { first } => vec![multiplier * held[first] + offset],
                _ => unreachable!(),
            },
        };
        let axis = Vector3::new(joint.axis.x, joint.axis.y, joint.axis.z);
        let own = match joint.kind {
            JointKind::Fixed => Isometry3::identity(),
            JointKind::Revolute | JointKind::Continuous => Isometry3::rotation(axis * x[0]),
            JointKind::Prismatic => {
                Isometry3::translation(axis.x * x[0], axis.y * x[0], axis.z * x[0])
            }
            JointKind::Planar => Isometry3::new(Vector3::new(x[0], x[1], 0.0), Vector3::z() * x[2]),
            JointKind::Floating => Isometry3::from_parts(
                Translation3::new(x[0], x[1], x[2]),
                UnitQuaternion::new_normalize(nalgebra::Quaternion::new(x[6], x[3], x[4], x[5])),
            ),
        };
        let parent = joint
            .parent
            .map_or(Isometry3::identity(), |p| poses[p]);
        poses.push(parent * isometry(&joint.origin) * own);
    }
    poses
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let t = pose.translation;
    let r = pose.rotation;
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z));
    Isometry3::from_parts(Translation3::new(t.x, t.y, t.z), rotation)
}

fn parry_pose(i: &Isometry3<f64>) -> Pose {
    let r = i.rotation.coords;
    Pose::from_parts(
        Vec3::new(i.translation.x, i.translation.y, i.translation.z),
        Quat::from_xyzw(r.x, r.y, r.z, r.w),
    )
}

/// A shape as parry has it; a mesh is its surface, and so is a shape that parry does not know.
fn parry_shape(shape: &Shape) -> (Pose, SharedShape) {
    // Parry's capsules and cylinders stand along y.
    let upright = Pose::from_rotation(Quat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    match shape.drawn() {
        Drawn::Sphere { radius } => (Pose::identity(), SharedShape::new(Ball::new(radius))),
        Drawn::Box { size } => (Pose::identity(), SharedShape::new(Cuboid::new(size / 2.0))),
        Drawn::Cylinder { radius, length } => (
            upright,
            SharedShape::new(Cylinder::new(length / 2.0, radius)),
        ),
        Drawn::Capsule { radius, length } => (
            upright,
            SharedShape::new(Capsule::new_y(length / 2.0, radius)),
        ),
        Drawn::Mesh(mesh) => {
            let mesh = TriMesh::new(mesh.vertices().to_vec(), mesh.triangles().to_vec()).unwrap();
            (Pose::identity(), SharedShape::new(mesh))
        }
    }
}

/// Distances of links and objects by name, by parry, straight from the descriptions of robot and
/// scene; overlap is 0.
pub struct Oracle {
    solids: BTreeMap<String, Carried>,
}

/// Shapes in the frame of a link or of the world, as they are and as they are scaled.
struct Carried {
    link: Option<usize>,
    shapes: Vec<(Pose, SharedShape)>,
    scaled: Vec<(Pose, SharedShape)>,
}

impl Oracle {
    pub fn new(model: &CollisionModel) -> Self {
        let carried = |name: &str, link: Option<usize>, own: Pose, shapes: &[PlacedShape]| {
            let place = |placed: &PlacedShape| {
                let (upright, shape) = parry_shape(&placed.shape);
                (own * placed.pose * upright, shape)
            };
            let scale = |placed: &PlacedShape| {
                placed
                    .scaled(model.scene().scale(name))
                    .unwrap()
            };
            let scaled = shapes
                .iter()
                .map(|placed| place(&scale(placed)))
                .collect();
            Carried {
                link,
                shapes: shapes.iter().map(place).collect(),
                scaled,
            }
        };
        let mut solids = BTreeMap::new();
        for (index, link) in model.robot().links().iter().enumerate() {
            solids.insert(
                link.name.clone(),
                carried(&link.name, Some(index), Pose::identity(), &link.shapes),
            );
        }
        for attached in model.scene().attached() {
            let link = model.robot().link_index(&attached.link_name);
            let object = &attached.object;
            solids.insert(
                object.id.clone(),
                carried(&object.id, link, object.pose, &object.shapes),
            );
        }
        for object in model.scene().obstacles() {
            solids.insert(
                object.id.clone(),
                carried(&object.id, None, object.pose, &object.shapes),
            );
        }
        Self { solids }
    }

    /// Distance of the two bodies of a pair, scaled and less their padding where one of them is an
    /// obstacle.
    pub fn pair_distance(&self, model: &CollisionModel, pair: usize, q: &[f64]) -> f64 {
        let [a, b] = model.pair_names(pair);
        self.distance(model, &a, &b, q)
    }

    /// How much of a requirement is kept.
    pub fn kept(&self, model: &CollisionModel, requirement: Requirement, q: &[f64]) -> f64 {
        let pair = requirement.pair();
        self.pair_distance(model, pair, q)
    }

    /// How deep the two bodies of a pair are in each other by parry, less what padding adds; 0
    /// where they are apart.
    pub fn pair_depth(&self, model: &CollisionModel, pair: usize, q: &[f64]) -> f64 {
        let [a, b] = model.pair_names(pair);
        let depth = |at_a: &Pose, a: &SharedShape, at_b: &Pose, b: &SharedShape| {
            query::contact(at_a, &**a, at_b, &**b, 0.0)
                .unwrap()
                .map_or(0.0, |contact| -contact.dist)
        };
        self.parts(model, [&a, &b], q, depth)
            .fold(0.0, f64::max)
    }

    /// The same of any two links or objects.
    pub fn distance(&self, model: &CollisionModel, a: &str, b: &str, q: &[f64]) -> f64 {
        let distance = |at_a: &Pose, a: &SharedShape, at_b: &Pose, b: &SharedShape| {
            query::distance(at_a, &**a, at_b, &**b)
                .unwrap()
                .distance
        };
        let least = self
            .parts(model, [a, b], q, distance)
            .fold(f64::INFINITY, f64::min);
        let faces_obstacle = [a, b]
            .iter()
            .any(|name| self.solids[*name].link.is_none());
        if faces_obstacle {
            least - model.scene().padding(a) - model.scene().padding(b)
        } else {
            least
        }
    }

    /// Least distance of points of the world from these links.
    pub fn least_to_points(
        &self,
        model: &CollisionModel,
        links: &[usize],
        points: &[Vec3],
        q: &[f64],
    ) -> f64 {
        let poses = link_poses(model.robot(), q);
        let mut least = f64::INFINITY;
        for link in links {
            let solid = &self.solids[&model.robot().links()[*link].name];
            for (pose, shape) in &solid.scaled {
                let at = parry_pose(&poses[*link]) * *pose;
                let ball = shape.compute_local_bounding_sphere();
                let middle = at.transform_point(ball.center());
                for point in points {
                    // Without the ball, every place would cost a distance for each point.
                    if (*point - middle).length() - ball.radius() < least {
                        least = least.min(shape.distance_to_point(&at, *point, true));
                    }
                }
            }
        }
        least
    }

    /// A measure of each two shapes of two bodies.
    fn parts<'a>(
        &'a self,
        model: &CollisionModel,
        names: [&str; 2],
        q: &[f64],
        measure: impl Fn(&Pose, &SharedShape, &Pose, &SharedShape) -> f64 + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        let poses = link_poses(model.robot(), q);
        let [a, b] = names.map(|name| &self.solids[name]);
        let [at_a, at_b] = [a, b].map(|solid| {
            solid
                .link
                .map_or(Pose::identity(), |link| parry_pose(&poses[link]))
        });
        let faces_obstacle = a.link.is_none() || b.link.is_none();
        let [shapes_a, shapes_b] = [a, b].map(|solid| {
            if faces_obstacle {
                &solid.scaled
            } else {
                &solid.shapes
            }
        });
        let both = shapes_a
            .iter()
            .flat_map(move |a| shapes_b.iter().map(move |b| (a, b)));
        both.map(move |((pose_a, a), (pose_b, b))| {
            measure(&(at_a * *pose_a), a, &(at_b * *pose_b), b)
        })
    }
}
