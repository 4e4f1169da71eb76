//! URDF files: the document, joints and their defaults, limits, mimic chains, shapes and names of
//! meshes.

use super::case::Case;

pub const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="odd">
  <link name="base"><collision><geometry><box size="0.2 0.3 0.4"/></geometry></collision></link>
  <link name="arm"><collision><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision></link>
  <link name="fore"><collision><origin xyz="0 0 0.25"/><geometry><sphere radius="0.07"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0.1 0.2" rpy="0 0 0.5"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="10" velocity="3"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="fore"/><origin xyz="0.3 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="10" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="fore"/><child link="tip"/><origin xyz="0 0 0.1"/></joint>
</robot>
"#;
const AXIS: &str = r#"<axis xyz="0 0 1"/>"#;
const LIMIT: &str = r#"<limit lower="-1" upper="2" effort="10" velocity="3"/>"#;
const BOX: &str = r#"<box size="0.2 0.3 0.4"/>"#;
const CYLINDER: &str = r#"<cylinder radius="0.05" length="0.5"/>"#;
const SLIDE: &str = r#"<joint name="slide" type="prismatic">"#;

fn case(name: &str, content: impl Into<Vec<u8>>) -> Case {
    Case::new(format!("urdf/{name}.urdf"), content)
}

/// The robot with one thing written otherwise.
fn other(name: &str, old: &str, new: &str) -> Case {
    assert!(ROBOT.contains(old), "{name}: {old}");
    case(name, ROBOT.replace(old, new))
}

/// The robot with more before its end.
fn with(name: &str, more: &str) -> Case {
    other(name, "</robot>", &format!("{more}\n</robot>"))
}

pub fn cases() -> Vec<Case> {
    let mut cases = documents();
    cases.extend(elements());
    cases.extend(numbers());
    cases.extend(joints());
    cases.extend(limits());
    cases.extend(mimics());
    cases.extend(shapes());
    cases.extend(meshes());
    cases.extend(refused());
    cases
}

fn documents() -> Vec<Case> {
    let latin = ROBOT.replace(
        "?>",
        " encoding=\"ISO-8859-1\"?>\n<!-- Entwurf: Jörg Träger -->",
    );
    let bytes = latin
        .chars()
        .map(|c| c as u8)
        .collect::<Vec<u8>>();
    let head = "<?xml version=\"1.0\"?>";
    vec![
        case("plain", ROBOT),
        other("no_declaration", &format!("{head}\n"), ""),
        other(
            "encoding_utf8",
            head,
            "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>",
        ),
        other("single_quotes", "xyz=\"0 0 1\"", "xyz='0 0 1'"),
        case("latin1", bytes.clone()),
        case("latin1_names", [bytes.as_slice(), b"\n"].concat()),
        case(
            "utf8_comment",
            ROBOT.replace(head, &format!("{head}\n<!-- Träger ✓ -->")),
        ),
        case("utf8_names", ROBOT.replace("\"arm\"", "\"Träger\"")),
        case("bom", format!("\u{feff}{ROBOT}")),
        case("crlf", ROBOT.replace('\n', "\r\n")),
        case("one_line", ROBOT.replace('\n', "")),
        case("blank_line_first", format!("\n{ROBOT}")),
        case(
            "blank_line_before_root",
            ROBOT.replace("<robot", "\n\n<robot"),
        ),
        case(
            "comment_before_declaration",
            format!("<!-- made by hand -->\n{ROBOT}"),
        )
        .read_as("yourdfpy", "the comment says nothing"),
        case(
            "doctype",
            ROBOT.replace("<robot", "<!DOCTYPE robot>\n<robot"),
        ),
        case("comment_after_root", format!("{ROBOT}<!-- the end -->\n")),
        case(
            "stylesheet",
            ROBOT.replace("<robot", "<?xml-stylesheet href=\"x.xsl\"?>\n<robot"),
        ),
        case("comments_everywhere", ROBOT.replace("><", "><!-- - --><")),
        case(
            "xmlns_declared",
            ROBOT.replace("<robot", "<robot xmlns:drake=\"http://drake.mit.edu\""),
        ),
        case(
            "xacro_declared",
            ROBOT.replace(
                "<robot",
                "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"",
            ),
        ),
        case(
            "default_namespace",
            ROBOT.replace("<robot", "<robot xmlns=\"http://www.ros.org\""),
        ),
    ]
}

fn elements() -> Vec<Case> {
    let plugin = "<gazebo><controller:gazebo_plugin name=\"p\"><on>1</on></controller:gazebo_plugin></gazebo>";
    let actuator = "<transmission name=\"t\"><type>transmission_interface/SimpleTransmission</type><joint name=\"turn\"><hardwareInterface>x</hardwareInterface></joint><actuator name=\"m\"/></transmission>";
    let visual = "<visual><geometry><mesh filename=\"package://nowhere/part.dae\"/></geometry><material name=\"\"><texture/></material></visual>";
    let version = |name: &str, version: &str| {
        other(
            name,
            "name=\"odd\"",
            &format!("name=\"odd\" version=\"{version}\""),
        )
    };
    vec![
        with("prefix_undeclared", plugin),
        other(
            "attribute_prefix_undeclared",
            "<limit lower=\"-1\"",
            "<limit drake:acceleration=\"2.5\" lower=\"-1\"",
        ),
        with("transmission", actuator),
        with(
            "gazebo_reference",
            "<gazebo reference=\"arm\"><material>Gazebo/Red</material><mu1>0.2</mu1></gazebo>",
        ),
        with(
            "ros2_control",
            "<ros2_control name=\"r\" type=\"system\"><joint name=\"turn\"><command_interface name=\"position\"/></joint></ros2_control>",
        ),
        with(
            "material_at_end",
            "<material name=\"steel\"><color rgba=\"0.5 0.5 0.5 1\"/></material>",
        ),
        with(
            "sensor",
            "<sensor name=\"s\" update_rate=\"10\"><parent link=\"arm\"/></sensor>",
        ),
        other(
            "visual_missing_mesh",
            "<link name=\"tip\"/>",
            &format!("<link name=\"tip\">{visual}</link>"),
        ),
        other(
            "inertial",
            "<link name=\"tip\"/>",
            "<link name=\"tip\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>",
        ),
        version("version_1_0", "1.0"),
        version("version_1", "1"),
        other("robot_without_name", " name=\"odd\"", "")
            .read_as("urchin", "its name moves nothing"),
        other(
            "link_type_attribute",
            "<link name=\"base\">",
            "<link name=\"base\" type=\"laser\">",
        ),
        other(
            "collision_name",
            "<collision><geometry><box",
            "<collision name=\"trunk\"><geometry><box",
        ),
        other(
            "two_collisions",
            "</geometry></collision></link>\n  <link name=\"tip\"/>",
            "</geometry></collision><collision><origin xyz=\"0 0.5 0\"/><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision></link>\n  <link name=\"tip\"/>",
        ),
        other(
            "geometry_comment",
            BOX,
            &format!("<!-- <sphere radius=\"1\"/> -->{BOX}"),
        ),
        other(
            "text_between",
            "<link name=\"tip\"/>",
            "lies here <link name=\"tip\"/> and there",
        ),
        other(
            "blanks_in_tags",
            "<parent link=\"base\"/>",
            "<parent\n   link = \"base\"\n  />",
        ),
        other("entity_in_name", "name=\"turn\"", "name=\"turn&amp;lift\""),
        other(
            "character_reference",
            "xyz=\"0 0 1\"",
            "xyz=\"0&#32;0&#x20;1\"",
        ),
        other("names_with_blanks", "\"turn\"", "\"turn left\""),
        other("names_with_slashes", "\"fore\"", "\"left/fore\""),
    ]
}

fn numbers() -> Vec<Case> {
    let axis = |name: &str, axis: &str| other(name, "xyz=\"0 0 1\"", &format!("xyz=\"{axis}\""));
    let place = |name: &str, place: &str| other(name, "xyz=\"0 0.1 0.2\" rpy=\"0 0 0.5\"", place);
    vec![
        axis("plus_signs", "+0 +0 +1"),
        axis("exponents", "0e0 0.0E+00 1.0e0"),
        axis("bare_points", "0. .0 1."),
        axis("wide_blanks", "  0   0  1 "),
        axis("tabs_and_lines", "0\t0\n1"),
        axis("axis_long", "0 0 3"),
        axis("axis_tilted", "1 1 1"),
        axis("axis_short", "0 0 1e-3"),
        axis("axis_negative", "0 0 -1"),
        axis("axis_off_unit", "0 0.6 0.79"),
        place("rpy_only", "rpy=\"0.3 -0.2 0.1\""),
        place("xyz_only", "xyz=\"0 0.1 0.2\""),
        place("origin_empty", ""),
        place("rpy_before_xyz", "rpy=\"0 0 0.5\" xyz=\"0 0.1 0.2\""),
        place(
            "pitch_quarter_turn",
            "xyz=\"0 0 0\" rpy=\"0.3 1.5707963267948966 0.2\"",
        ),
        place("rpy_beyond_turn", "xyz=\"0 0 0\" rpy=\"7 -8 9\""),
        place(
            "rpy_many_digits",
            "xyz=\"0 0 0.20000000000000001110223\" rpy=\"0 0 3.14159265358979323846\"",
        ),
        place("minus_zero", "xyz=\"-0 -0.0 0.2\" rpy=\"-0 0 0\""),
        place("tiny_exponent", "xyz=\"1e-320 0 0.2\" rpy=\"0 0 1e-17\""),
        place("comma_free_integers", "xyz=\"0 1 2\" rpy=\"0 0 1\""),
    ]
}

fn joints() -> Vec<Case> {
    let kind =
        |name: &str, kind: &str| other(name, "type=\"revolute\"", &format!("type=\"{kind}\""));
    let moves_freely = |name: &str, kind: &str, axis: &str| {
        case(
            name,
            ROBOT
                .replace("type=\"revolute\"", &format!("type=\"{kind}\""))
                .replace(AXIS, axis)
                .replace(LIMIT, ""),
        )
    };
    vec![
        kind("continuous_with_limits", "continuous"),
        moves_freely("continuous", "continuous", AXIS),
        moves_freely("continuous_without_axis", "continuous", ""),
        moves_freely("planar", "planar", AXIS)
            .read_as("pinocchio", "its three numbers have no limits of one joint"),
        moves_freely("planar_without_axis", "planar", "").read_as(
            "pinocchio",
            "x and y are the joint's own, as MoveIt moves it",
        ),
        moves_freely("planar_axis_x", "planar", "<axis xyz=\"1 0 0\"/>").read_as(
            "pinocchio",
            "x and y are the joint's own, as MoveIt moves it",
        ),
        moves_freely("floating", "floating", "")
            .read_as("pinocchio", "others leave it where it is"),
        kind("fixed_with_limits", "fixed"),
        other("axis_missing", AXIS, ""),
        other("axis_of_prismatic_missing", "<axis xyz=\"1 0 0\"/>", ""),
        other("origin_missing", "<origin xyz=\"0 0 0.1\"/>", ""),
        other(
            "dynamics",
            AXIS,
            &format!(
                "{AXIS}<dynamics damping=\"0.1\" friction=\"0.2\"/><calibration rising=\"0\"/>"
            ),
        ),
        other(
            "fixed_with_axis",
            "<child link=\"tip\"/>",
            "<child link=\"tip\"/><axis xyz=\"0 0 0\"/>",
        ),
        with(
            "branch",
            "<link name=\"side\"/><joint name=\"a_branch\" type=\"revolute\"><parent link=\"base\"/><child link=\"side\"/><origin xyz=\"0 -0.5 0\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>",
        ),
        other(
            "child_before_parent",
            "<parent link=\"base\"/><child link=\"arm\"/>",
            "<child link=\"arm\"/><parent link=\"base\"/>",
        ),
        case(
            "link_and_joint_share_name",
            ROBOT.replace("name=\"turn\"", "name=\"arm\""),
        ),
        case(
            "upper_case_type",
            ROBOT.replace("type=\"fixed\"", "type=\"FIXED\""),
        )
        .refused(
            &["line", "FIXED", "valid types"],
            "types are written in small letters",
        ),
    ]
}

fn limits() -> Vec<Case> {
    let limit = |name: &str, limit: &str| other(name, LIMIT, limit);
    let safe = |name: &str, soft: &str| {
        other(
            name,
            LIMIT,
            &format!("{LIMIT}<safety_controller {soft} k_position=\"10\" k_velocity=\"10\"/>"),
        )
        .read_as(
            "yourdfpy",
            "soft limits bound the joint, as in MoveIt's robot model",
        )
    };
    let version = |name: &str, limit: &str| {
        case(
            name,
            ROBOT
                .replace(LIMIT, limit)
                .replace("name=\"odd\"", "name=\"odd\" version=\"1.2\""),
        )
    };
    vec![
        limit(
            "limit_without_lower",
            "<limit upper=\"2\" effort=\"10\" velocity=\"3\"/>",
        )
        .read_as("pinocchio", "an end that is not given is 0 before URDF 1.2"),
        limit(
            "limit_without_upper",
            "<limit lower=\"-1\" effort=\"10\" velocity=\"3\"/>",
        )
        .read_as("pinocchio", "an end that is not given is 0 before URDF 1.2"),
        limit(
            "limit_of_effort_only",
            "<limit effort=\"10\" velocity=\"3\"/>",
        )
        .read_as("pinocchio", "an end that is not given is 0 before URDF 1.2"),
        limit(
            "limit_without_effort",
            "<limit lower=\"-1\" upper=\"2\" velocity=\"3\"/>",
        ),
        limit(
            "limit_without_velocity",
            "<limit lower=\"-1\" upper=\"2\" effort=\"10\"/>",
        ),
        limit(
            "limit_equal",
            "<limit lower=\"0.5\" upper=\"0.5\" effort=\"10\" velocity=\"3\"/>",
        ),
        limit(
            "limit_wide",
            "<limit lower=\"-1e9\" upper=\"1e9\" effort=\"10\" velocity=\"3\"/>",
        ),
        limit(
            "limit_zero_effort",
            "<limit lower=\"-1\" upper=\"2\" effort=\"0\" velocity=\"0\"/>",
        ),
        limit(
            "limit_beyond_zero",
            "<limit lower=\"0.5\" upper=\"2\" effort=\"10\" velocity=\"3\"/>",
        ),
        safe(
            "soft_limits",
            "soft_lower_limit=\"-0.5\" soft_upper_limit=\"1\"",
        ),
        safe(
            "soft_limits_wider",
            "soft_lower_limit=\"-5\" soft_upper_limit=\"5\"",
        ),
        other(
            "soft_limit_lower_only",
            LIMIT,
            &format!("{LIMIT}<safety_controller soft_lower_limit=\"-0.5\" k_velocity=\"10\"/>"),
        )
        .read_as(
            "urchin",
            "URDF's default is 0, and MoveIt holds the joint below it",
        ),
        other(
            "safety_without_soft_limits",
            LIMIT,
            &format!("{LIMIT}<safety_controller k_velocity=\"10\"/>"),
        )
        .read_as(
            "urchin",
            "URDF's default is 0, and MoveIt holds the joint there",
        ),
        version("version_1_2", LIMIT),
        limit("limit_missing", "").refused(&["turn", "limit"], "how far it may turn is not said"),
        limit(
            "limit_crossed",
            "<limit lower=\"2\" upper=\"-1\" effort=\"10\" velocity=\"3\"/>",
        )
        .refused(&["turn", "2", "-1"], "nothing lies between"),
    ]
}

fn mimics() -> Vec<Case> {
    let mimic = |name: &str, mimic: &str| other(name, SLIDE, &format!("{SLIDE}{mimic}"));
    let chain = ROBOT.replace(SLIDE, &format!("{SLIDE}<mimic joint=\"turn\" multiplier=\"0.5\" offset=\"0.1\"/>")).replace(
        "</robot>",
        "<link name=\"end\"/><joint name=\"last\" type=\"revolute\"><parent link=\"tip\"/><child link=\"end\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"1\"/><mimic joint=\"slide\" multiplier=\"-2\" offset=\"0.3\"/></joint></robot>",
    );
    let before = ROBOT.replace(
        AXIS,
        &format!("{AXIS}<mimic joint=\"slide\" multiplier=\"2\"/>"),
    );
    let why = "a mimic joint moves with its leader";
    vec![
        mimic(
            "mimic",
            "<mimic joint=\"turn\" multiplier=\"0.5\" offset=\"0.1\"/>",
        ),
        mimic("mimic_without_numbers", "<mimic joint=\"turn\"/>"),
        mimic(
            "mimic_without_offset",
            "<mimic joint=\"turn\" multiplier=\"-0.25\"/>",
        ),
        mimic(
            "mimic_without_multiplier",
            "<mimic joint=\"turn\" offset=\"0.2\"/>",
        ),
        mimic(
            "mimic_multiplier_0",
            "<mimic joint=\"turn\" multiplier=\"0\" offset=\"0.2\"/>",
        ),
        case("mimic_chain", chain).read_as("urchin", why),
        case("mimic_of_a_later_joint", before).read_as("yourdfpy", why),
        other("mimic_of_continuous", LIMIT, "").with(|text| {
            text.replace("type=\"revolute\"", "type=\"continuous\"")
                .replace(
                    SLIDE,
                    &format!("{SLIDE}<mimic joint=\"turn\" multiplier=\"0.01\"/>"),
                )
        }),
        mimic("mimic_of_itself", "<mimic joint=\"slide\"/>")
            .refused(&["slide", "mimic"], "it has no leader"),
        mimic("mimic_of_nothing", "<mimic joint=\"gone\"/>")
            .refused(&["slide", "gone"], "it has no leader"),
    ]
}

fn shapes() -> Vec<Case> {
    let shape = |name: &str, shape: &str| other(name, BOX, shape);
    let place = |name: &str, place: &str| {
        other(
            name,
            "<collision><geometry><box",
            &format!("<collision>{place}<geometry><box"),
        )
    };
    let out = "a shape without an inside bounds nothing; it is left out with a warning";
    vec![
        shape("sphere", "<sphere radius=\"0.3\"/>"),
        shape("capsule", "<capsule radius=\"0.1\" length=\"0.4\"/>"),
        shape("mesh_stl", "<mesh filename=\"part.stl\"/>"),
        shape("box_thin", "<box size=\"0.2 0.3 1e-6\"/>"),
        shape("box_large", "<box size=\"200 300 400\"/>"),
        place("origin_xyz", "<origin xyz=\"0.1 0.2 0.3\"/>"),
        place("origin_rpy", "<origin rpy=\"0.1 0.2 0.3\"/>"),
        place("origin_none", "<origin/>"),
        place(
            "origin_quaternion",
            "<origin xyz=\"0.1 0.2 0.3\" quat_xyzw=\"0 0 0.6 0.8\"/>",
        )
        .read_as("pinocchio", "URDF 1.1's quaternion turns the shape"),
        shape("zero_box", "<box size=\"0 0 0\"/>").read_as("ours", out),
        shape("flat_box", "<box size=\"0.2 0.3 0\"/>"),
        shape("zero_sphere", "<sphere radius=\"0\"/>").read_as("ours", out),
        shape("zero_cylinder", "<cylinder radius=\"0\" length=\"0.5\"/>"),
        shape("negative_box", "<box size=\"-0.2 0.3 0.4\"/>")
            .refused(&["base", "-0.2"], "no solid is of negative size"),
        other(
            "negative_cylinder",
            CYLINDER,
            "<cylinder radius=\"-0.05\" length=\"0.5\"/>",
        )
        .refused(&["arm", "-0.05"], "no solid is of negative size"),
    ]
}

fn meshes() -> Vec<Case> {
    let mesh = |name: &str, mesh: &str| other(name, BOX, &format!("<mesh {mesh}/>"));
    vec![
        mesh(
            "mesh_scaled",
            "filename=\"part.stl\" scale=\"0.001 0.002 0.003\"",
        ),
        mesh("mesh_mirrored", "filename=\"part.stl\" scale=\"1 -1 1\""),
        mesh(
            "mesh_scale_exponent",
            "filename=\"part.stl\" scale=\"1e-3 1e-3 1e-3\"",
        ),
        mesh("mesh_obj", "filename=\"part.obj\""),
        mesh("mesh_dae", "filename=\"part.dae\""),
        mesh("mesh_upper_case", "filename=\"PART.STL\""),
        mesh("mesh_in_folder", "filename=\"meshes/part.stl\""),
        mesh("mesh_dot_folder", "filename=\"./meshes/../part.stl\""),
        mesh("mesh_name_with_blank", "filename=\"my part.stl\""),
        mesh("mesh_package", "filename=\"package://urdf/part.stl\""),
        mesh(
            "mesh_package_folder",
            "filename=\"package://urdf/meshes/part.stl\"",
        ),
        mesh(
            "mesh_package_two_slashes",
            "filename=\"package://urdf//meshes/part.stl\"",
        ),
        mesh("mesh_model", "filename=\"model://urdf/part.stl\""),
        mesh("mesh_percent", "filename=\"package://urdf/my%20part.stl\"")
            .read_as("ours", "a URI writes a blank so, and MoveIt reads it so"),
        mesh("mesh_missing", "filename=\"gone.stl\"")
            .refused(&["base", "gone.stl"], "it is not there"),
        mesh("mesh_no_format", "filename=\"part.xyz\"")
            .refused(&["base", "part.xyz"], "it is no mesh"),
        mesh("mesh_scale_0", "filename=\"part.stl\" scale=\"0 0 0\"")
            .refused(&["base", "part.stl", "scale"], "nothing is left of it"),
        mesh(
            "mesh_scale_one_number",
            "filename=\"part.stl\" scale=\"0.001\"",
        )
        .refused(
            &["line", "base", "scale", "3"],
            "readers do not agree what it means",
        ),
        mesh("mesh_web", "filename=\"https://example.org/part.stl\"").refused(
            &["base", "https://example.org/part.stl"],
            "files are not fetched",
        ),
    ]
}

fn refused() -> Vec<Case> {
    let bad = |name: &str, old: &str, new: &str, parts: &'static [&'static str]| {
        other(name, old, new).refused(parts, "the file is broken, whoever reads it")
    };
    vec![
        bad(
            "number_comma",
            "radius=\"0.05\"",
            "radius=\"0,05\"",
            &["line 4", "arm", "0,05"],
        ),
        bad(
            "number_word",
            "upper=\"2\"",
            "upper=\"pi\"",
            &["line 7", "turn", "pi"],
        ),
        bad(
            "number_unexpanded",
            "upper=\"2\"",
            "upper=\"${pi}\"",
            &["line 7", "${pi}", "xacro"],
        ),
        bad(
            "number_nan",
            "radius=\"0.05\"",
            "radius=\"nan\"",
            &["arm", "nan"],
        ),
        bad(
            "axis_zero",
            "xyz=\"0 0 1\"",
            "xyz=\"0 0 0\"",
            &["turn", "axis"],
        ),
        bad(
            "axis_two_numbers",
            "xyz=\"0 0 1\"",
            "xyz=\"0 1\"",
            &["line 7", "turn", "2 numbers"],
        ),
        bad(
            "child_missing",
            "<child link=\"arm\"/>",
            "",
            &["line 7", "turn", "child"],
        ),
        bad(
            "child_unknown",
            "<child link=\"arm\"/>",
            "<child link=\"hand\"/>",
            &["turn", "hand"],
        ),
        bad(
            "link_twice",
            "<link name=\"tip\"/>",
            "<link name=\"tip\"/><link name=\"tip\"/>",
            &["tip", "twice"],
        ),
        bad("cut_short", "</robot>", "", &["not an XML file"]),
        bad("no_robot", "robot", "model", &["<model>", "<robot>"]),
        bad(
            "xacro_property",
            "<link name=\"tip\"/>",
            "<xacro:property name=\"a\" value=\"1\"/><link name=\"tip\"/>",
            &["xacro"],
        ),
        bad(
            "unexpanded_find",
            BOX,
            "<mesh filename=\"$(find arm)/part.stl\"/>",
            &["line 3", "$(find arm)", "xacro"],
        ),
    ]
}
