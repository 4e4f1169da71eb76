//! The bytes of records: what a release wrote, the next one reads.

use std::fmt::Write;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taut::math::{Pose, Quat, Vec3};
use taut::robot::{
    Group, GroupState, JointDescription, JointKind, LinkDescription, Mimic, Motor,
    RobotDescription, RobotModel, Semantics, VirtualJoint,
};
use taut::scene::{AttachedObject, Obstacle, Scene, SceneDescription, SensedFrame, Sensing};
use taut::shape::cloud::{Making, Provenance, Source, Unknown, Voxel};
use taut::shape::{Cloud, Mesh, PlacedShape, Shape};
use taut::warning::Warning;

use super::*;

fn placed(x: f64, shape: Shape) -> PlacedShape {
    PlacedShape {
        pose: Pose::from_parts(Vec3::new(x, 0.5, -1.0), Quat::from_xyzw(0.0, 0.6, 0.0, 0.8)),
        shape,
    }
}

fn joint(name: &str, kind: JointKind, ends: [&str; 2]) -> JointDescription {
    JointDescription {
        name: name.to_owned(),
        kind,
        parent: ends[0].to_owned(),
        child: ends[1].to_owned(),
        origin: Pose::from_translation(Vec3::X),
        axis: Vec3::Z,
        limits: Some((-1.0, 2.0)),
        soft_limits: None,
        mimic: None,
    }
}

/// Something of everything that a robot may have.
fn robot() -> RobotModel {
    let link = |name: &str, collision: Vec<PlacedShape>| LinkDescription {
        name: name.to_owned(),
        collision,
    };
    let shapes = vec![
        placed(0.0, Shape::sphere(0.25).unwrap()),
        placed(1.0, Shape::cuboid(Vec3::new(1.0, 2.0, 3.0)).unwrap()),
    ];
    let mut follower = joint("b", JointKind::Prismatic, ["l1", "l2"]);
    follower.soft_limits = Some((0.0, 1.0));
    follower.mimic = Some(Mimic {
        joint: "a".into(),
        multiplier: 2.0,
        offset: 0.5,
    });
    let mount = VirtualJoint {
        name: "base".into(),
        kind: JointKind::Planar,
        position_bounds: vec![(-1.0, 1.0)],
        parent_frame: "map".into(),
    };
    let semantics = Semantics {
        disabled_collisions: vec![("l0".into(), "l1".into())],
        groups: vec![Group {
            name: "arm".into(),
            joints: vec!["a".into()],
        }],
        group_states: vec![GroupState {
            name: "home".into(),
            group: "arm".into(),
            values: vec![("a".into(), vec![0.0])],
        }],
        virtual_joint: Some(mount.clone()),
    };
    RobotModel::new(RobotDescription {
        name: "r".into(),
        links: vec![link("l0", shapes), link("l1", vec![]), link("l2", vec![])],
        joints: vec![joint("a", JointKind::Revolute, ["l0", "l1"]), follower],
        virtual_joint: Some(mount),
        variables: None,
        semantics: Some(semantics),
        allowed_collisions: vec![("l1".into(), "l2".into())],
        motors: vec![Motor {
            joint: "a".into(),
            velocity: Some(0.5),
            effort: None,
        }],
        warnings: vec![Warning::uncovered("u"), Warning::cosmetic("t", "c")],
    })
    .unwrap()
}

fn seen() -> Sensing {
    Sensing {
        thin_m: 0.25,
        self_padding_m: 0.125,
        frame: Some(SensedFrame {
            taken_ns: 1,
            came: 21,
            not_finite: 2,
            on_robot: 3,
            in_padding: 4,
            thinned: 5,
            points: 6,
        }),
        ..Sensing::new(0.5)
    }
}

/// Something of everything that a scene may have.
fn scene() -> Scene {
    let object = |id: &str, shape: Shape| Obstacle {
        id: id.to_owned(),
        pose: Pose::from_translation(Vec3::Y),
        shapes: Arc::new([placed(0.0, shape)]),
        sensed: Some(Arc::new(seen())),
    };
    let one = |name: &str, value: f64| [(name.to_owned(), value)].into();
    Scene::of(SceneDescription {
        name: "s".into(),
        obstacles: vec![object("pole", Shape::cylinder(2.0, 0.25).unwrap())],
        attached: vec![AttachedObject {
            link_name: "l2".into(),
            object: object("tool", Shape::capsule(0.5, 0.125).unwrap()),
            touch_links: vec!["l1".into()],
        }],
        padding: one("l0", 0.5),
        scale: one("l1", 2.0),
        frames: [("shelf".to_owned(), Pose::from_translation(Vec3::Z))].into(),
        subframes: [(("pole".to_owned(), "top".to_owned()), Pose::identity())].into(),
        worlds: [("pole".to_owned(), "map".to_owned())].into(),
        allowed: vec![("pole".into(), "l0".into())],
        forbidden: vec![("pole".into(), "l1".into())],
        warnings: vec![Warning::uncovered("w")],
    })
    .unwrap()
}

pub(super) fn hex(record: &impl Serialize) -> String {
    let bytes = bincode::serde::encode_to_vec(record, bincode::config::standard()).unwrap();
    bytes
        .iter()
        .fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

pub(super) fn read<T: DeserializeOwned>(hex: &str) -> T {
    let byte = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
    let bytes: Vec<u8> = (0..hex.len()).step_by(2).map(byte).collect();
    bincode::serde::decode_from_slice(&bytes, bincode::config::standard())
        .unwrap()
        .0
}

/// [`robot`] as the first journals of version 3 have it.
const ROBOT: &str = "\
    017203026c30020000000000000000333333333333e33f00000000000000009a9999999999e93f000000\
    0000000000000000000000e03f000000000000f0bf00000000000000d03f000000000000000033333333\
    3333e33f00000000000000009a9999999999e93f000000000000f03f000000000000e03f000000000000\
    f0bf01000000000000e03f000000000000f03f000000000000f83f026c3100026c320002016101026c30\
    026c31000000000000000000000000000000000000000000000000000000000000f03f000000000000f0\
    3f0000000000000000000000000000000000000000000000000000000000000000000000000000f03f01\
    000000000000f0bf00000000000000400000016203026c31026c32000000000000000000000000000000\
    000000000000000000000000000000f03f000000000000f03f0000000000000000000000000000000000\
    000000000000000000000000000000000000000000f03f01000000000000f0bf00000000000000400100\
    00000000000000000000000000f03f0101610000000000000040000000000000e03f0104626173650401\
    000000000000f0bf000000000000f03f036d6170000101026c30026c31010361726d0101610104686f6d\
    650361726d0101610100000000000000000104626173650401000000000000f0bf000000000000f03f03\
    6d617001026c31026c3202000175010174016302000175010174016301016101000000000000e03f00";
/// [`scene`] the same.
const SCENE: &str = "\
    01730104706f6c65000000000000000000000000000000000000000000000000000000000000f03f0000\
    000000000000000000000000f03f0000000000000000010000000000000000333333333333e33f000000\
    00000000009a9999999999e93f0000000000000000000000000000e03f000000000000f0bf0200000000\
    0000d03f000000000000f03f01000000000000e03f000000000000d03f000000000000c03f0101150203\
    04050601026c3204746f6f6c000000000000000000000000000000000000000000000000000000000000\
    f03f0000000000000000000000000000f03f0000000000000000010000000000000000333333333333e3\
    3f00000000000000009a9999999999e93f0000000000000000000000000000e03f000000000000f0bf03\
    000000000000c03f000000000000d03f01000000000000e03f000000000000d03f000000000000c03f01\
    0115020304050601026c3101026c30000000000000e03f01026c31000000000000004001057368656c66\
    000000000000000000000000000000000000000000000000000000000000f03f00000000000000000000\
    000000000000000000000000f03f0104706f6c6503746f70000000000000000000000000000000000000\
    000000000000000000000000f03f0000000000000000000000000000000000000000000000000104706f\
    6c65036d61700104706f6c65026c300104706f6c65026c3101000177";

#[test]
fn bytes_are_those_of_the_version() {
    let advice = "readers of this version's files would not understand these: raise the version";
    assert_eq!(hex(&RobotRecord::from(&robot())), ROBOT, "{advice}");
    assert_eq!(hex(&SceneRecord::from(&scene())), SCENE, "{advice}");
}

/// The hashes are literals: no renaming in a dependency may move them.
#[test]
fn records_give_back_what_has_its_hash() {
    let robot = read::<RobotRecord>(ROBOT);
    let scene = read::<SceneRecord>(SCENE);
    let robot = robot.restore(&mut Nothing).unwrap();
    let scene = scene.restore(&mut Nothing).unwrap();
    assert_eq!(
        robot.description().motors,
        self::robot().description().motors
    );
    assert_eq!(robot.hash(), 0x7ea9_3551_1bee_9bb3);
    assert_eq!(scene.hash(), 0xb845_f32b_6a39_2d36);
    assert_eq!(hex(&RobotRecord::from(&robot)), ROBOT);
    assert_eq!(hex(&SceneRecord::from(&scene)), SCENE);
}

/// Where nothing stands apart.
struct Nothing;

impl Find for Nothing {
    fn mesh(&mut self, _: u64) -> Result<Arc<Mesh>, String> {
        unreachable!("there are none")
    }

    fn cloud(&mut self, _: u64) -> Result<Arc<Cloud>, String> {
        unreachable!("there are none")
    }
}

/// A cloud comes back with all that is known of it.
#[test]
fn a_cloud_is_restored_with_where_it_comes_from() {
    let made = |making| Provenance {
        source: Some(Source {
            file: "hall.bt".into(),
            making,
        }),
        unknown_from: Some(1),
        warnings: vec![Warning::uncovered("taken as free")],
    };
    let points = [[0.0; 3], [1.0, 0.25, 3.0]];
    let voxels = points.map(|center| Voxel { center, size: 0.5 });
    for (cloud, making) in [
        (
            Cloud::of_points(points, 0.01).unwrap(),
            Making::Points {
                radius: 0.005,
                thin: Some(0.02),
            },
        ),
        (
            Cloud::of_voxels(&voxels).unwrap(),
            Making::Map {
                unknown: Unknown::Obstacle,
            },
        ),
    ] {
        let cloud = cloud.with_provenance(made(making));
        let bytes = bincode::serde::encode_to_vec(cloud.record(), bincode::config::standard());
        let bytes = bytes.unwrap();
        let read = || {
            let record = bincode::serde::decode_from_slice(&bytes, bincode::config::standard());
            record.unwrap().0
        };
        assert_eq!(Cloud::restored(read(), cloud.hash()).unwrap(), cloud);
        let other = Cloud::restored(read(), 7).unwrap_err();
        assert!(other.contains("not 0000000000000007"), "{other}");
    }
}
