use super::*;
use crate::robot::{RobotModel, urdf};

const ROBOT: &str = "<robot name='r'>
    <link name='base'/><link name='left'/><link name='left_hand'/><link name='right'/><link name='right_hand'/>
    <joint name='l1' type='continuous'><parent link='base'/><child link='left'/></joint>
    <joint name='l2' type='continuous'><parent link='left'/><child link='left_hand'/></joint>
    <joint name='r1' type='continuous'><parent link='base'/><child link='right'/></joint>
    <joint name='r2' type='fixed'><parent link='right'/><child link='right_hand'/></joint></robot>";

fn robot() -> RobotDescription {
    urdf::parse(ROBOT, &mut |_, _| unreachable!("no meshes")).unwrap()
}

fn read(body: &str) -> Result<(Semantics, Vec<crate::warning::Warning>), RobotError> {
    parse(&format!("<robot name='r'>\n{body}</robot>"), &robot())
}

fn assert_refused(body: &str, parts: &[&str]) {
    let text = read(body)
        .expect_err("must be refused")
        .to_string();
    assert!(
        parts.iter().all(|part| text.contains(part)),
        "{text:?} lacks one of {parts:?}"
    );
}

#[test]
fn groups_resolve_to_joints() {
    let body = "<virtual_joint name='world' type='planar' parent_frame='odom' child_link='base'/>
        <group name='both'><group name='left'/><group name='right'/><joint name='l1'/></group>
        <group name='left'><chain base_link='base' tip_link='left_hand'/></group>
        <group name='right'><link name='right'/><link name='base'/></group>
        <group name='across'><chain base_link='left_hand' tip_link='right_hand'/></group>
        <group name='odd'><joint name='gone'/></group>
        <group_state name='home' group='left'><joint name='l1' value='0.5'/><joint name='l2' value='1 2'/></group_state>";
    let (semantics, warnings) = read(body).unwrap();
    let joints = |name: &str| {
        semantics
            .groups
            .iter()
            .find(|g| g.name == name)
            .unwrap()
            .joints
            .join(" ")
    };
    assert_eq!(joints("left"), "l1 l2");
    assert_eq!(
        joints("right"),
        "r1 world",
        "the root link is carried by the virtual joint"
    );
    assert_eq!(joints("both"), "l1 l2 r1 world");
    assert_eq!(joints("across"), "l2 l1 r1 r2");
    assert_eq!(joints("odd"), "");
    assert!(
        warnings[0].contains("line 7") && warnings[0].contains("gone"),
        "{warnings:?}"
    );
    assert_eq!(
        semantics.group_states[0].values[1],
        ("l2".to_owned(), vec![1.0, 2.0])
    );

    let mut description = robot();
    description.virtual_joint = semantics.virtual_joint.clone();
    description.semantics = Some(semantics);
    let model = RobotModel::new(description).unwrap();
    assert_eq!(model.space().nv(), 6);
    assert_eq!(model.groups()[2].1, [true, true, true, false, false, true]);
}

#[test]
fn pairs_are_disabled_by_name_by_default_and_enabled_again() {
    let body = "<disable_collisions link1='right' link2='left' reason='Never'/>
        <disable_default_collisions link='left_hand'/><enable_collisions link1='left_hand' link2='right'/>";
    let (semantics, _) = read(body).unwrap();
    let pairs: Vec<String> = semantics
        .disabled_collisions
        .iter()
        .map(|(a, b)| format!("{a}-{b}"))
        .collect();
    assert_eq!(
        pairs,
        [
            "base-left_hand",
            "left-left_hand",
            "left-right",
            "left_hand-right_hand"
        ]
    );
}

#[test]
fn a_virtual_joint_must_carry_the_root() {
    let (semantics, warnings) =
        read("<virtual_joint name='v' type='floating' parent_frame='w' child_link='left'/>")
            .unwrap();
    assert!(semantics.virtual_joint.is_none());
    assert!(
        warnings[0].contains("\"left\"") && warnings[0].contains("root"),
        "{warnings:?}"
    );
    assert_refused(
        "<virtual_joint name='v' type='ball' child_link='base'/>",
        &["line 2", "ball", "floating"],
    );
}

#[test]
fn what_a_check_does_not_need_is_warned_about_and_never_refuses_a_robot() {
    for (body, parts) in [
        (
            "<group name='a'><group name='b'/></group>\n<group name='b'><group name='a'/></group>",
            &["itself", "a → b → a"][..],
        ),
        (
            "<group name='a'>\n<group name='b'/></group>",
            &["line 3", "\"b\"", "known: a"],
        ),
        (
            "<group name='a'/><group name='a'/>",
            &["line 2", "second group", "\"a\""],
        ),
        ("<group/>", &["line 2", "<group>", "name"]),
        (
            "<group name='a'><chain base_link='base'/></group>",
            &["line 2", "tip_link"],
        ),
        (
            "<disable_collisions link1='left'/>",
            &["line 2", "link2", "disables nothing"],
        ),
        (
            "<disable_default_collisions link='gone'/>",
            &["line 2", "gone"],
        ),
        (
            "<enable_collisions link1='left' link2='gone'/>",
            &["line 2", "gone"],
        ),
        (
            "<group name='a'/><group_state name='s'/>",
            &["line 2", "group"],
        ),
        (
            "<group_state name='s' group='b'/>",
            &["line 2", "\"s\"", "\"b\""],
        ),
        (
            "<group name='a'/><group_state name='s' group='a'><joint name='l1' value='x'/></group_state>",
            &["\"s\"", "x"],
        ),
        (
            "<group name='a'/><group_state name='s' group='a'><joint name='l1'/></group_state>",
            &["\"s\"", "value"],
        ),
    ] {
        let (semantics, warnings) = read(body).unwrap();
        let named = |text: &Warning| parts.iter().all(|part| text.contains(part));
        assert!(
            warnings.iter().any(named),
            "{warnings:?} has none of {parts:?}"
        );
        assert!(semantics.group_states.is_empty());
        let mut description = robot();
        description.semantics = Some(semantics);
        RobotModel::new(description).unwrap();
    }
}

#[test]
fn what_is_right_in_a_group_with_errors_stays() {
    let body = "<group name='a'><joint name='l1'/></group>
        <group name='both'><group name='a'/><group name='missing'/><link name='gone'/><joint name='r1'/></group>
        <group_state name='bad'><joint name='l1' value='0'/></group_state>
        <group_state name='home' group='a'><joint name='l1' value='0'/></group_state>";
    let (semantics, warnings) = read(body).unwrap();
    assert_eq!(semantics.groups[1].joints, ["l1", "r1"]);
    assert_eq!(
        semantics
            .group_states
            .iter()
            .map(|state| state.name.as_str())
            .collect::<Vec<_>>(),
        ["home"]
    );
    assert_eq!(warnings.len(), 3, "{warnings:?}");
}

#[test]
fn what_would_add_columns_or_a_pair_is_refused_with_its_line() {
    let two = "<virtual_joint name='v' type='planar' child_link='base'/>\n";
    assert_refused(
        &two.replace("name='v' ", ""),
        &["line 2", "<virtual_joint>", "name"],
    );
    assert_refused(&(two.to_owned() + two), &["line 3", "second"]);
    assert_refused("<enable_collisions link1='left'/>", &["line 2", "link2"]);
    // One for another variant of the robot is none.
    let (semantics, _) = read(&(two.to_owned() + &two.replace("base", "stand"))).unwrap();
    assert_eq!(semantics.virtual_joint.unwrap().name, "v");
}
