//! Texts of constraints: what they come to, and what is said of those that cannot be kept.

use super::*;
use crate::math::{Pose, Quat};
use crate::robot::{JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel};
use crate::scene::Scene;
use crate::scene::scene_file::SceneFile;

/// A column that turns and slides, with a hand that turns: base, slide, hand.
pub(super) fn robot() -> RobotModel {
    let link = |name: &str| LinkDescription {
        name: name.into(),
        collision: Vec::new(),
    };
    let joint = |name: &str, kind, parent: &str, child: &str, axis| JointDescription {
        name: name.into(),
        kind,
        parent: parent.into(),
        child: child.into(),
        origin: Pose::identity(),
        axis,
        limits: Some((-3.0, 3.0)),
        soft_limits: None,
        mimic: None,
    };
    RobotModel::new(RobotDescription {
        name: "column".into(),
        links: ["base", "turned", "slid", "hand"]
            .map(link)
            .into(),
        joints: vec![
            joint("turn", JointKind::Continuous, "base", "turned", Vec3::Z),
            joint("slide", JointKind::Prismatic, "turned", "slid", Vec3::Z),
            joint("wrist", JointKind::Revolute, "slid", "hand", Vec3::X),
        ],
        ..RobotDescription::default()
    })
    .unwrap()
}

pub(super) fn scene() -> Scene {
    let text = r#"{"objects": [{"id": "table", "pose": {"position": [1, 0, 0]},
        "primitives": [{"type": "box", "dimensions": [1, 1, 1]}], "primitive_poses": [{}]}],
        "robot_state": {"attached_collision_objects": [{"link_name": "hand", "object": {"id": "cup",
        "pose": {"position": [0, 0, 0.1]},
        "primitives": [{"type": "sphere", "dimensions": [0.1]}], "primitive_poses": [{}]}}]}}"#;
    let file: SceneFile = serde_json::from_str(text).unwrap();
    file.build(&mut |_, _| unreachable!("no meshes"))
        .unwrap()
}

fn built(text: &str) -> Result<Vec<Constraint>, String> {
    let file: ConstraintsFile = serde_json::from_str(text).map_err(|error| error.to_string())?;
    constraints(&file, &robot(), &scene()).map_err(|error| error.to_string())
}

/// What is left of each constraint at a configuration (turn, slide, wrist).
fn left(text: &str, configuration: [f64; 3]) -> Vec<f64> {
    let robot = robot();
    let mut kinematics = crate::robot::Kinematics::default();
    kinematics.update(&robot, &configuration, &[]);
    let stand = Stand {
        kinematics: &kinematics,
        configuration: &configuration,
        velocity: &[0.0; 3],
    };
    let all = built(text).unwrap();
    let left = all.iter().map(|constraint| {
        constraint
            .held
            .left(constraint.held.watched.at(&stand))
    });
    left.collect()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    let is_near = found.len() == expected.len()
        && found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(is_near, "{found:?}, not {expected:?}");
}

#[test]
fn a_tilt_is_the_angle_to_a_direction_whatever_turns_about_it() {
    let text = r#"{"name": "upright", "orientation_constraints": [
        {"link_name": "hand", "axis": [0, 0, 2], "reference": [0, 0, 1], "tolerance_rad": 0.1}]}"#;
    for turn in [0.0, 2.0] {
        assert_near(&left(text, [turn, 0.3, 0.04]), &[0.06]);
        assert_near(&left(text, [turn, 0.3, -0.3]), &[-0.2]);
    }
    let all = built(text).unwrap();
    assert_eq!(all[0].name, "upright: hand");
    // Neither the turn nor the slide counts.
    assert_eq!(all[0].held.watched.chain().len(), 1);
}

#[test]
fn euler_angles_are_moveits() {
    let text = r#"{"orientation_constraints": [{"header": {"frame_id": "world"}, "link_name": "hand",
        "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}, "absolute_x_axis_tolerance": 0.5,
        "absolute_y_axis_tolerance": 0.2, "absolute_z_axis_tolerance": 3.2, "weight": 1.0}]}"#;
    // Turned about z, then about x, is about x and y as the reference sees it.
    assert_near(&left(text, [0.0, 0.0, 0.4]), &[0.1]);
    let turned = Quat::from_rotation_z(0.3) * Quat::from_rotation_x(0.4) * Vec3::Z;
    let alpha = (-turned.y).atan2(turned.z).abs();
    let beta = turned.x.asin().abs();
    assert_near(
        &left(text, [0.3, 0.0, 0.4]),
        &[(0.5 - alpha).min(0.2 - beta)],
    );
    let text = text.replace("3.2", "0.7");
    assert_near(&left(&text, [0.0, 0.1, 0.0]), &[0.2, 0.7]);
    assert_near(&left(&text, [0.6, 0.1, 0.0]), &[0.2, 0.1]);
    assert_near(&left(&text, [-0.8, 0.1, 0.0]), &[0.2, -0.1]);
}

#[test]
fn a_position_is_in_one_of_the_regions_of_a_frame() {
    let text = r#"{"position_constraints": [{"header": {"frame_id": "table"}, "link_name": "cup",
        "target_point_offset": [0, 0, 0.1], "constraint_region": {
        "primitives": [{"type": "box", "dimensions": [0.2, 0.4, 0.6]}, {"type": 2, "dimensions": [0.5]}],
        "primitive_poses": [{"position": [-1, 0, 0.2]}, {"position": [-1, 0, 1.2]}]}}]}"#;
    // The cup's point is 0.2 above the hand.
    assert_near(&left(text, [1.0, 0.05, 0.0]), &[0.1]);
    assert_near(&left(text, [1.0, 0.9, 0.0]), &[0.4]);
    assert_near(
        &left(text, [0.0, 0.0, 0.5]),
        &[0.1 - (0.2 * 0.5_f64.sin() - 0.1).max(0.0)],
    );
}

#[test]
fn a_pose_may_be_seen_from_another_link() {
    let text = r#"{"position_constraints": [{"header": {"frame_id": "hand"}, "link_name": "base",
        "constraint_region": {"primitives": [{"type": "sphere", "dimensions": [0.5]}],
        "primitive_poses": [{"position": [0, 0, -0.25]}]}}]}"#;
    assert_near(&left(text, [0.7, 0.5, 0.0]), &[0.25]);
    assert_near(&left(text, [0.7, 0.0, 0.5]), &[0.25]);
}

#[test]
fn a_joint_is_near_a_value_on_the_circle_the_shorter_way() {
    let text = r#"{"joint_constraints": [
        {"joint_name": "turn", "position": 3.1, "tolerance_above": 0.2, "tolerance_below": 0.1},
        {"joint_name": "slide", "position": 0.5, "tolerance_above": 0.0, "tolerance_below": 0.1}]}"#;
    assert_near(
        &left(text, [-3.1, 0.45, 0.0]),
        &[0.2 - (std::f64::consts::TAU - 6.2), 0.05],
    );
    let kinds = built(text).unwrap();
    assert_eq!(
        kinds.iter().map(|c| c.kind).collect::<Vec<_>>(),
        [ConstraintKind::Angle, ConstraintKind::Slide]
    );
}

#[test]
fn what_cannot_be_kept_is_refused_by_name_with_the_next_step() {
    let tilt = |rest: &str| {
        format!(
            r#"{{"name": "n", "orientation_constraints": [{{"link_name": "hand", "axis": [1, 0, 0],
            "reference": [0, 0, 1], {rest}}}]}}"#
        )
    };
    let euler = |rest: &str| {
        format!(
            r#"{{"orientation_constraints": [{{"link_name": "hand", "absolute_x_axis_tolerance": 0.1,
            "absolute_y_axis_tolerance": 0.1, {rest}}}]}}"#
        )
    };
    let region = |rest: &str| {
        format!(
            r#"{{"position_constraints": [{{"link_name": "hand", "constraint_region": {rest}}}]}}"#
        )
    };
    for (text, words) in [
        (
            tilt(r#""tolerance_rad": 0.0"#),
            ["tolerance_rad is 0", "such as 0.001"],
        ),
        (
            tilt(r#""tolerance_rad": 1.6"#),
            ["tolerance_rad is 1.6", "π/2"],
        ),
        (
            tilt(r#""tolerance_rad": 0.1, "frame": 1"#),
            ["frame", "unknown field"],
        ),
        (
            euler(r#""absolute_z_axis_tolerance": 2.0"#),
            ["absolute_z_axis_tolerance is 2", "from π on"],
        ),
        (
            euler(r#""absolute_z_axis_tolerance": 0"#),
            ["absolute_z_axis_tolerance is 0", "0.001"],
        ),
        (
            euler(r#""absolute_z_axis_tolerance": 4, "parameterization": 1"#),
            ["parameterization 1", "XYZ_EULER_ANGLES"],
        ),
        (
            euler(r#""absolute_z_axis_tolerance": 4, "orientation": [1, 1, 0, 0]"#),
            ["orientation", "unit quaternion"],
        ),
        (
            r#"{"visibility_constraints": [{}]}"#.into(),
            ["visibility_constraints", "cone"],
        ),
        (
            r#"{"joint_constraints": [{"joint_name": "turm", "position": 0, "tolerance_above": 1,
            "tolerance_below": 1}]}"#
                .into(),
            ["\"turm\"", "turn, slide, wrist"],
        ),
        (
            r#"{"joint_constraints": [{"joint_name": "wrist", "position": 0, "tolerance_above": 0,
            "tolerance_below": 0}]}"#
                .into(),
            ["is 0", "0.001"],
        ),
        (
            region(r#"{"meshes": [{}]}"#),
            ["a mesh as a region", "boxes"],
        ),
        (region("{}"), ["primitive_poses is 0", "a pose for each"]),
        (
            tilt(r#""tolerance_rad": 0.1"#).replace("\"hand\"", "\"\""),
            ["\"\" is no link", "base, turned, slid, hand; attached: cup"],
        ),
        (
            region(
                r#"{"primitives": [{"type": "sphere", "dimensions": [1e-12]}], "primitive_poses": [{}]}"#,
            ),
            ["half width is 0.000000000001", "0.001"],
        ),
        (
            region(
                r#"{"primitives": [{"type": "sphere", "dimensions": [1]}],
                "primitive_poses": [{"position": [1e200, 1e200, 0]}]}"#,
            ),
            ["region is", "1e6 at most"],
        ),
        (
            region(
                r#"{"primitives": [{"type": "cone", "dimensions": [1, 1]}], "primitive_poses": [{}]}"#,
            ),
            ["cone", "a region is a box"],
        ),
        (
            tilt(r#""tolerance_rad": 0.1"#).replace("\"hand\"", "\"hant\""),
            ["\"hant\"", "base, turned, slid, hand"],
        ),
    ] {
        let error = built(&text).unwrap_err();
        assert!(!error.contains('\n'), "{error}");
        for word in words {
            assert!(error.contains(word), "{word:?} not in: {error}");
        }
    }
}

/// What overflows is no number, and what is no number is nowhere inside.
#[test]
fn what_is_no_number_is_kept_nowhere() {
    let nowhere = Vec3::splat(f64::NAN);
    for text in [
        r#"{"position_constraints": [{"link_name": "hand", "constraint_region": {
            "primitives": [{"type": "box", "dimensions": [1, 1, 1]}], "primitive_poses": [{}]}}]}"#,
        r#"{"position_constraints": [{"link_name": "hand", "constraint_region": {
            "primitives": [{"type": "cylinder", "dimensions": [1, 1]}, {"type": "sphere", "dimensions": [1]}],
            "primitive_poses": [{}, {}]}}]}"#,
        r#"{"orientation_constraints": [{"link_name": "hand", "axis": [1, 0, 0], "reference": [0, 0, 1],
            "tolerance_rad": 1}, {"link_name": "hand", "absolute_x_axis_tolerance": 0.1,
            "absolute_y_axis_tolerance": 0.1, "absolute_z_axis_tolerance": 0.1}]}"#,
        r#"{"joint_constraints": [{"joint_name": "turn", "position": 0, "tolerance_above": 1, "tolerance_below": 1}]}"#,
    ] {
        for Constraint { held, name, .. } in built(text).unwrap() {
            for ends in [
                [nowhere, nowhere],
                [nowhere, Vec3::ZERO],
                [Vec3::ZERO, nowhere],
            ] {
                let kept = held.kept(ends, 0.0);
                assert!(
                    !matches!(kept.partial_cmp(&0.0), Some(std::cmp::Ordering::Greater)),
                    "{name}: {kept}"
                );
            }
        }
    }
}

/// A name is the link's own before it is one with a slash of older ROS before it.
#[test]
fn a_slash_may_begin_a_name_or_stand_before_one() {
    let text = |link: &str| {
        format!(
            r#"{{"joint_constraints": [], "orientation_constraints": [{{"link_name": "{link}", "axis": [0, 0, 1],
            "reference": [0, 0, 1], "tolerance_rad": 0.1}}]}}"#
        )
    };
    for link in ["/hand", "hand", "/cup", "cup"] {
        assert_near(&left(&text(link), [0.0, 0.0, 0.04]), &[0.06]);
    }
}
