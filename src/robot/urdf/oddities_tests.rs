//! What other readers of URDF read without complaint, and what must not be left out in silence.

use std::sync::Arc;

use super::*;
use crate::robot::RobotModel;
use crate::shape::Shape;

fn no_mesh(name: &str, _: Vec3) -> Result<Arc<Mesh>, MeshError> {
    Err(MeshError::Unreadable {
        name: name.to_owned(),
        reason: "there is no such file".to_owned(),
    })
}

/// Two links and a joint between them, in a file of this version.
fn read(version: &str, link: &str, joint: &str) -> Result<RobotDescription, RobotError> {
    let ends = "<parent link='a'/><child link='b'/>";
    let text = format!(
        "<robot name='r' version='{version}'>\n<link name='a'/>\n<link name='b'>{link}</link>\n{}</robot>",
        match joint.contains("<joint") {
            true => joint.to_owned(),
            false => format!("<joint name='j' type='revolute'>{ends}{joint}</joint>"),
        }
    );
    parse(&text, &mut no_mesh)
}

const LIMIT: &str = "<limit lower='-1' upper='2'/>";

fn collision(shape: &str) -> String {
    format!("<collision><geometry>{shape}</geometry></collision>")
}

fn assert_warned(robot: &RobotDescription, parts: &[&str]) {
    let found = robot
        .warnings
        .iter()
        .any(|text| parts.iter().all(|part| text.contains(part)));
    assert!(found, "{:?} has none of {parts:?}", robot.warnings);
}

fn assert_refused(read: Result<RobotDescription, RobotError>, parts: &[&str]) {
    let text = read
        .map(|robot| robot.warnings)
        .expect_err("must be refused")
        .to_string();
    assert!(
        parts.iter().all(|part| text.contains(part)) && !text.contains('\n'),
        "{text:?} lacks one of {parts:?}"
    );
}

#[test]
fn a_quaternion_turns_by_what_it_says_however_near_the_vertical() {
    for quaternion in [
        // 4.5 mrad beside the vertical: as angles, urdf-rs has it upright.
        [0.0, 0.705_549_436_325_095_4, 0.0, 0.708_660_703_652_559_1],
        [0.1, -0.7, 0.1, 0.7],
        [3.0, 0.0, 4.0, 0.0],
    ] {
        let [x, y, z, w] = quaternion;
        let turn = Quat::from_xyzw(x, y, z, w).normalize();
        let origin = format!("<origin xyz='1 2 3' quat_xyzw='{x} {y} {z} {w}'/>");
        let shape =
            format!("<collision>{origin}<geometry><sphere radius='1'/></geometry></collision>");
        let robot = read("1.1", &shape, &format!("{origin}{LIMIT}")).unwrap();
        for pose in [robot.joints[0].origin, robot.links[1].collision[0].pose] {
            assert_eq!(pose, Pose::from_parts(Vec3::new(1.0, 2.0, 3.0), turn));
        }
        let text = format!(
            "<robot name='r' version='1.1'><link name='a'>{}</link></robot>",
            shape.replace("collision", "visual")
        );
        let (visuals, missing) = visuals(&text, &mut no_mesh).unwrap();
        assert_eq!((visuals[0].shape.pose.rotation, missing.len()), (turn, 0));
    }
}

#[test]
fn quaternions_of_other_files_are_read_as_by_urdfdom() {
    let origin = |more: &str| format!("<origin quat_xyzw='0 0 1 0'{more}/>{LIMIT}");
    let before = read("1.0", "", &origin("")).unwrap();
    assert_eq!(
        before.joints[0].origin,
        Pose::identity(),
        "ignored before 1.1"
    );
    assert_warned(&before, &["line 4", "\"j\"", "quat_xyzw", "1.0", "ignored"]);
    assert_refused(
        read("1.1", "", &origin(" rpy='0 0 0'")),
        &["line 4", "\"j\"", "both", "rpy"],
    );
    assert_refused(
        read("1.1", "", &format!("<origin quat_xyzw='0 0 1'/>{LIMIT}")),
        &["line 4", "3 numbers", "4"],
    );
    let none = read("1.1", "", &format!("<origin quat_xyzw='0 0 0 0'/>{LIMIT}")).unwrap();
    assert_eq!(none.joints[0].origin, Pose::identity());
    assert_warned(&none, &["line 4", "0 0 0 0"]);
}

#[test]
fn a_point_is_left_out_and_a_sheet_or_line_is_thin() {
    for point in [
        "<sphere radius='0'/>",
        "<box size='0 0 0'/>",
        "<cylinder radius='0' length='0.0'/>",
    ] {
        let robot = read("1.0", &collision(point), LIMIT).unwrap();
        assert!(robot.links[1].collision.is_empty());
        assert_warned(&robot, &["line 3", "\"b\"", "left out"]);
    }
    let thin = 0.5e-6;
    for (flat, shape) in [
        (
            "<box size='2 4 0'/>",
            Shape::Box {
                half_extents: Vec3::new(1.0, 2.0, thin),
            },
        ),
        (
            "<cylinder radius='0' length='2'/>",
            Shape::Cylinder {
                radius: 1e-6,
                half_height: 1.0,
            },
        ),
        (
            "<cylinder radius='3' length='0'/>",
            Shape::Cylinder {
                radius: 3.0,
                half_height: thin,
            },
        ),
        (
            "<capsule radius='3' length='0'/>",
            Shape::Sphere { radius: 3.0 },
        ),
    ] {
        let robot = read("1.2", &collision(flat), LIMIT).unwrap();
        assert_eq!(robot.links[1].collision[0].shape, shape);
        assert_warned(
            &robot,
            &["line 3", "\"b\"", "1e-6", "thick"]
                .map(|part| if part == "1e-6" { "0.000001" } else { part }),
        );
    }
    for bad in [
        "<sphere radius='-1'/>",
        "<box size='0 -1 0'/>",
        "<cylinder radius='0' length='-2'/>",
    ] {
        assert_refused(
            read("1.0", &collision(bad), LIMIT),
            &["link \"b\"", "line 3", "-"],
        );
    }
}

#[test]
fn soft_limits_are_read_as_in_moveits_robot_model() {
    let soft = |attributes: &str| {
        read(
            "1.0",
            "",
            &format!("{LIMIT}<safety_controller k_velocity='1'{attributes}/>"),
        )
    };
    for (attributes, bounds, warning) in [
        (
            " soft_lower_limit='-0.5' soft_upper_limit='1'",
            (-0.5, 1.0),
            None,
        ),
        (
            " soft_lower_limit='-3' soft_upper_limit='3'",
            (-1.0, 2.0),
            None,
        ),
        (
            " soft_upper_limit='1'",
            (0.0, 1.0),
            Some("no soft_lower_limit"),
        ),
        (
            " soft_lower_limit='-0.5'",
            (-0.5, 0.0),
            Some("no soft_upper_limit"),
        ),
        (
            "",
            (0.0, 0.0),
            Some("neither soft_lower_limit nor soft_upper_limit"),
        ),
        (
            " soft_lower_limit='3' soft_upper_limit='4'",
            (-1.0, 2.0),
            Some("are ignored"),
        ),
        (
            " soft_lower_limit='1' soft_upper_limit='-1'",
            (-1.0, 2.0),
            Some("are ignored"),
        ),
    ] {
        let robot = soft(attributes).unwrap();
        match warning {
            Some(part) => assert_warned(&robot, &["line 4", "\"j\"", part]),
            None => assert!(robot.warnings.is_empty(), "{:?}", robot.warnings),
        }
        let model = RobotModel::new(robot).unwrap();
        let variable = &model.variables()[0];
        assert_eq!((variable.lower, variable.upper), bounds, "{attributes}");
        assert_eq!((variable.hard_lower, variable.hard_upper), (-1.0, 2.0));
    }
    assert_refused(
        soft(" soft_lower_limit='low'"),
        &["line 4", "\"j\"", "soft_lower_limit", "low"],
    );
    // A continuous joint has no limits, soft or not.
    let ends = "<parent link='a'/><child link='b'/><safety_controller k_velocity='1' soft_upper_limit='1'/>";
    let robot = read(
        "1.0",
        "",
        &format!("<joint name='j' type='continuous'>{ends}</joint>"),
    )
    .unwrap();
    assert_eq!(
        (robot.joints[0].soft_limits, robot.warnings.len()),
        (None, 0)
    );
}

#[test]
fn a_model_with_soft_limits_is_another_one() {
    let hash = |more: &str| {
        RobotModel::new(read("1.0", "", &format!("{LIMIT}{more}")).unwrap())
            .unwrap()
            .hash()
    };
    let wide = "<safety_controller k_velocity='1' soft_lower_limit='-3' soft_upper_limit='3'/>";
    assert_eq!(hash(""), hash(wide), "limits are what they are");
    assert_ne!(hash(""), hash(&wide.replace("'3'", "'1'")));
}

#[test]
fn what_adds_a_shape_or_joins_links_is_refused_by_name_and_the_rest_is_named() {
    let drake = |inside: &str| inside.replace("<robot", "<robot xmlns:drake='d'");
    for (link, joint, parts) in [
        (
            "<colision><geometry><sphere radius='1'/></geometry></colision>",
            LIMIT,
            &["line 3", "<colision>", "shape"][..],
        ),
        (
            &collision("<drake:ellipsoid a='1'/>"),
            LIMIT,
            &["line 3", "<drake:ellipsoid>", "cylinder"],
        ),
        (
            &collision("<drake:box size='1 1 1'/>"),
            LIMIT,
            &["line 3", "<drake:box>"],
        ),
        (
            "",
            "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<loop_joint name='l'/>",
            &["line 5", "<loop_joint>", "joins"],
        ),
        (
            "",
            "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<drake:joint name='l'/>",
            &["line 5", "<drake:joint>", "joins"],
        ),
    ] {
        assert_refused(read("1.0", &drake(link), joint), parts);
    }
    let ends = "<parent link='a'/><child link='b'/>";
    let named = format!(
        "<joint name='j' type='planar'>{ends}<axis/><origin xyz='0 0 1' rot='1'/><origin xyz='0 0 2'/><spring/></joint>
        <drake:collision_filter_group name='g'/><frame name='f'/>"
    );
    let robot = read(
        "1.0",
        "<collision><orgin/><geometry><capsule radius='1' length='1'/></geometry></collision>",
        &named,
    )
    .unwrap();
    for parts in [
        &["line 3", "\"b\"", "<orgin>"][..],
        &["line 3", "\"b\"", "<capsule>", "1.2"],
        &["line 4", "planar", "\"j\"", "x-y"],
        &["line 4", "\"j\"", "\"rot\"", "xyz"],
        &["line 4", "\"j\"", "second <origin>"],
        &["line 4", "\"j\"", "<spring>"],
        &[
            "line 5",
            "<drake:collision_filter_group>",
            "switches off are checked",
        ],
        &["line 5", "<frame>"],
    ] {
        assert_warned(&robot, parts);
    }
    assert_eq!(
        robot.joints[0].origin.translation.z, 1.0,
        "the first counts"
    );
}

#[test]
fn what_xacro_has_not_expanded_gets_its_advice() {
    let advice = "xacro FILE.xacro";
    for (link, joint) in [
        (
            collision("<mesh filename='$(find arm)/a.stl'/>"),
            LIMIT.to_owned(),
        ),
        (collision("<sphere radius='${r}'/>"), LIMIT.to_owned()),
        (
            String::new(),
            "<limit lower='${-pi}' upper='1'/>".to_owned(),
        ),
        (String::new(), format!("{LIMIT}<xacro:if value='1'/>")),
    ] {
        assert_refused(read("1.0", &link, &joint), &["line ", advice]);
    }
}

#[test]
fn a_document_type_and_prefixes_do_not_fail_a_robot() {
    let text = "\n<?xml version='1.0' encoding='ISO-8859-1'?>\n<!DOCTYPE robot [<!ENTITY r '0.5'>]>
        <robot name='r' xmlns='urdf'><link name='a'><!-- -- --><collision><geometry>
        <sphere radius='&r;' drake:hydroelastic='1'/></geometry></collision></link>
        <gazebo><controller:plugin name='p'/></gazebo></robot>";
    let robot = parse(text, &mut no_mesh).unwrap();
    assert_eq!(
        robot.links[0].collision[0].shape,
        Shape::Sphere { radius: 0.5 }
    );
    assert_warned(&robot, &["\"drake\"", "not declared"]);
}

#[test]
fn a_joint_that_mimics_a_fixed_one_moves_independently() {
    let joints = "<joint name='f' type='fixed'><parent link='a'/><child link='b'/></joint><link name='c'/>
        <joint name='m' type='revolute'><parent link='b'/><child link='c'/><limit lower='-1' upper='1'/><mimic joint='f'/></joint>
        <link name='d'/>
        <joint name='n' type='revolute'><parent link='c'/><child link='d'/><limit lower='-1' upper='1'/><mimic joint='m'/></joint>";
    let model = RobotModel::new(read("1.0", "", joints).unwrap()).unwrap();
    assert_eq!(
        model
            .variables()
            .iter()
            .map(|v| v.name.as_str())
            .collect::<Vec<_>>(),
        ["m"]
    );
    assert!(
        model
            .warnings()
            .iter()
            .any(|text| text.contains("\"m\" mimics \"f\"")),
        "{:?}",
        model.warnings()
    );
}
