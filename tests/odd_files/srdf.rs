//! SRDF files: pairs, groups of every kind, states, and what stands beside them.

use super::case::Case;

/// Robot of all SRDF files of the corpus.
pub const ROBOT: &str = r#"<robot name="six">
  <link name="base"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="l1"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="l2"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="l3"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="f1"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="f2"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
  <joint name="g1" type="prismatic"><parent link="l3"/><child link="f1"/><origin xyz="0 0.1 1"/><axis xyz="0 1 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
  <joint name="g2" type="prismatic"><parent link="l3"/><child link="f2"/><origin xyz="0 -0.1 1"/><axis xyz="0 1 0"/><limit lower="-0.1" upper="0" effort="1" velocity="1"/></joint>
</robot>
"#;

const SRDF: &str = r#"<?xml version="1.0"?>
<robot name="six">
  <group name="arm"><chain base_link="base" tip_link="l3"/></group>
  <group name="hand"><joint name="g1"/><joint name="g2"/></group>
  <group_state name="home" group="arm"><joint name="j1" value="0.5"/><joint name="j2" value="-0.5"/><joint name="j3" value="1"/></group_state>
  <disable_collisions link1="base" link2="l1" reason="Adjacent"/>
  <disable_collisions link1="l1" link2="l2" reason="Adjacent"/>
  <disable_collisions link1="f1" link2="f2" reason="Never"/>
</robot>
"#;
const PAIR: &str = r#"<disable_collisions link1="f1" link2="f2" reason="Never"/>"#;
const CHAIN: &str = r#"<chain base_link="base" tip_link="l3"/>"#;
/// Why one reader is enough.
const ALONE: &str = "tesseract asks for more than SRDF does, and refuses";
const HAND: &str = r#"<group name="hand"><joint name="g1"/><joint name="g2"/></group>"#;

fn case(name: &str, content: impl Into<Vec<u8>>) -> Case {
    Case::new(format!("srdf/{name}.srdf"), content)
}

fn other(name: &str, old: &str, new: &str) -> Case {
    assert!(SRDF.contains(old), "{name}: {old}");
    case(name, SRDF.replace(old, new))
}

fn with(name: &str, more: &str) -> Case {
    other(name, "</robot>", &format!("{more}\n</robot>"))
}

pub fn cases() -> Vec<Case> {
    let mut cases = documents();
    cases.extend(pairs());
    cases.extend(groups());
    cases.extend(states());
    cases.extend(refused());
    cases
}

fn documents() -> Vec<Case> {
    let latin = SRDF.replace("?>", " encoding=\"ISO-8859-1\"?>\n<!-- Träger -->");
    let latin = latin
        .chars()
        .map(|c| c as u8)
        .collect::<Vec<u8>>();
    vec![
        case("plain", SRDF),
        case("latin1", latin).read_as("tesseract", "the encoding is said"),
        case("bom", format!("\u{feff}{SRDF}")),
        case("crlf", SRDF.replace('\n', "\r\n")),
        case("blank_line_first", format!("\n{SRDF}"))
            .read_as("tesseract", "the blank line says nothing"),
        case(
            "no_declaration",
            SRDF.lines()
                .skip(1)
                .collect::<Vec<_>>()
                .join("\n"),
        ),
        case("comments", SRDF.replace("><", "><!-- - --><")),
        case(
            "doctype",
            SRDF.replace("<robot", "<!DOCTYPE robot>\n<robot"),
        ),
        case("one_line", SRDF.replace('\n', "")),
        case("other_robot_name", SRDF.replace("\"six\"", "\"seven\""))
            .read_as("pinocchio", "a renamed robot keeps its SRDF"),
        case("empty", "<robot name=\"six\"/>").read_as("tesseract", "it says nothing"),
        with(
            "unknown_elements",
            "<link_sphere_approximation link=\"l1\"><sphere center=\"0 0 0\" radius=\"1\"/></link_sphere_approximation><note>text</note>",
        ),
        with(
            "joint_property",
            "<joint_property joint_name=\"j1\" property_name=\"angular_distance_weight\" value=\"1\"/>",
        ),
    ]
}

fn pairs() -> Vec<Case> {
    let pair = |name: &str, pair: &str| other(name, PAIR, pair);
    let default = "<disable_default_collisions link=\"f1\"/>";
    vec![
        pair(
            "pair_other_way",
            "<disable_collisions link1=\"f2\" link2=\"f1\" reason=\"Never\"/>",
        ),
        pair("pair_twice", &format!("{PAIR}{PAIR}")),
        pair(
            "pair_without_reason",
            "<disable_collisions link1=\"f1\" link2=\"f2\"/>",
        ),
        pair(
            "pair_attributes_turned",
            "<disable_collisions reason=\"Never\" link2=\"f2\" link1=\"f1\"/>",
        ),
        pair(
            "pair_of_itself",
            &format!("{PAIR}<disable_collisions link1=\"f1\" link2=\"f1\" reason=\"Never\"/>"),
        ),
        pair(
            "pair_unknown",
            &format!("{PAIR}<disable_collisions link1=\"f1\" link2=\"gone\" reason=\"Never\"/>"),
        ),
        pair(
            "pair_default_reason",
            "<disable_collisions link1=\"f1\" link2=\"f2\" reason=\"Default\"/>",
        ),
        pair(
            "pair_user_reason",
            "<disable_collisions link1=\"f1\" link2=\"f2\" reason=\"User: &lt;checked&gt;\"/>",
        ),
        pair("default_off", default).read_as("ours", "as MoveIt: a link with every other"),
        pair(
            "default_off_but_one",
            &format!("{default}<enable_collisions link1=\"f1\" link2=\"base\"/>"),
        )
        .read_as("ours", "as MoveIt: but for what is enabled"),
        other(
            "pairs_before_groups",
            "<group name=\"arm\">",
            "<disable_collisions link1=\"l2\" link2=\"l3\" reason=\"Adjacent\"/><group name=\"arm\">",
        ),
    ]
}

fn groups() -> Vec<Case> {
    let arm = |name: &str, members: &str| other(name, CHAIN, members);
    vec![
        arm("group_of_joints", "<joint name=\"j1\"/><joint name=\"j2\"/><joint name=\"j3\"/>"),
        arm("group_of_links", "<link name=\"l1\"/><link name=\"l2\"/><link name=\"l3\"/>")
            .read_as("ours", "as MoveIt: a link stands for the joint that carries it"),
        arm("group_of_joints_turned", "<joint name=\"j3\"/><joint name=\"j1\"/><joint name=\"j2\"/>"),
        arm("group_mixed", "<joint name=\"j1\"/><chain base_link=\"l1\" tip_link=\"l3\"/>").read_as("compas", ALONE),
        arm("group_joint_twice", "<joint name=\"j1\"/><joint name=\"j2\"/><joint name=\"j3\"/><joint name=\"j1\"/>"),
        with("group_of_groups", "<group name=\"all\"><group name=\"arm\"/><group name=\"hand\"/></group>")
            .read_as("compas", ALONE),
        other(
            "group_of_later_groups",
            "<group name=\"arm\">",
            "<group name=\"all\"><group name=\"arm\"/><group name=\"hand\"/></group><group name=\"arm\">",
        )
        .read_as("compas", ALONE),
        with("empty_group", "<group name=\"none\"/>").read_as("compas", ALONE),
        with("end_effector", "<end_effector name=\"tool\" parent_link=\"l3\" group=\"hand\" parent_group=\"arm\"/>"),
        with("passive_joint", "<passive_joint name=\"g2\"/>"),
        with(
            "virtual_joint_fixed",
            "<virtual_joint name=\"root\" type=\"fixed\" parent_frame=\"world\" child_link=\"base\"/>",
        ),
        other(
            "group_unknown_joint",
            HAND,
            "<group name=\"hand\"><joint name=\"g1\"/><joint name=\"g2\"/><joint name=\"gone\"/></group>",
        )
        .read_as("compas", ALONE),
        with("group_unknown_subgroup", "<group name=\"both\"><group name=\"arm\"/><group name=\"gone\"/></group>")
            .read_as("pinocchio-srdf", "what a check does not need refuses no robot"),
        with("group_repeats_name", HAND),
    ]
}

fn states() -> Vec<Case> {
    let state = |name: &str, state: &str| with(name, state);
    vec![
        state("state_of_hand", "<group_state name=\"open\" group=\"hand\"><joint name=\"g1\" value=\"0.05\"/><joint name=\"g2\" value=\"-0.05\"/></group_state>"),
        state("state_partial", "<group_state name=\"half\" group=\"arm\"><joint name=\"j2\" value=\"0.25\"/></group_state>"),
        state("state_numbers", "<group_state name=\"odd\" group=\"arm\"><joint name=\"j1\" value=\"+5.0e-1\"/><joint name=\"j2\" value=\".25\"/><joint name=\"j3\" value=\" 1. \"/></group_state>"),
        state("state_beyond_limits", "<group_state name=\"far\" group=\"arm\"><joint name=\"j1\" value=\"3\"/><joint name=\"j2\" value=\"0\"/><joint name=\"j3\" value=\"0\"/></group_state>"),
        state("state_unknown_joint", "<group_state name=\"lost\" group=\"arm\"><joint name=\"j1\" value=\"0.1\"/><joint name=\"gone\" value=\"1\"/></group_state>").read_as("compas", ALONE),
        state("state_unknown_group", "<group_state name=\"lost\" group=\"gone\"><joint name=\"j1\" value=\"0.1\"/></group_state>").read_as("ours", "as MoveIt: a state of no group is left out"),
        state("state_without_group", "<group_state name=\"lost\"><joint name=\"j1\" value=\"0.1\"/></group_state>").read_as("pinocchio-srdf", "what a check does not need refuses no robot"),
        state("state_empty", "<group_state name=\"nothing\" group=\"arm\"/>").read_as("compas", ALONE),
    ]
}

fn refused() -> Vec<Case> {
    let broken = "the file is broken, whoever reads it";
    vec![
        other(
            "pair_without_link2",
            PAIR,
            "<disable_collisions link1=\"f1\" reason=\"Never\"/>",
        )
        .read_as("ours", "as MoveIt: such a pair is left out"),
        other("cut_short", "</robot>\n", "").refused(&["not an XML file"], broken),
        other("no_robot", "robot", "model").refused(&["<model>", "<robot>"], broken),
    ]
}
