//! Scenes: dumps of MoveIt's messages as YAML and JSON, our own scene files, and MoveIt's `.scene`
//! text.

use super::case::Case;

/// Robot that the scenes are about; its root link is their world.
pub const ROBOT: &str = r#"<robot name="two"><link name="base"/><link name="arm"/><link name="hand"/>
<joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>
<joint name="k" type="fixed"><parent link="arm"/><child link="hand"/></joint></robot>"#;

/// A planning scene as `ros2 topic echo` prints it.
const DUMP: &str = r#"name: kitchen
robot_state:
  joint_state:
    header:
      stamp:
        sec: 0
        nanosec: 0
      frame_id: ''
    name: []
    position: []
    velocity: []
    effort: []
  attached_collision_objects: []
  is_diff: false
robot_model_name: two
fixed_frame_transforms:
- header:
    stamp:
      sec: 0
      nanosec: 0
    frame_id: base
  child_frame_id: base
  transform:
    translation:
      x: 0.0
      y: 0.0
      z: 0.0
    rotation:
      x: 0.0
      y: 0.0
      z: 0.0
      w: 1.0
allowed_collision_matrix:
  entry_names: []
  entry_values: []
  default_entry_names: []
  default_entry_values: []
link_padding: []
link_scale: []
object_colors: []
world:
  collision_objects:
  - header:
      stamp:
        sec: 12
        nanosec: 5
      frame_id: base
    pose:
      position:
        x: 0.5
        y: 0.25
        z: 0.125
      orientation:
        x: 0.0
        y: 0.0
        z: 0.6
        w: 0.8
    id: table
    type:
      key: ''
      db: ''
    primitives:
    - type: 1
      dimensions:
      - 1.0
      - 0.5
      - 0.25
      polygon:
        points: []
    primitive_poses:
    - position:
        x: 0.1
        y: 0.2
        z: 0.3
      orientation:
        x: 0.0
        y: 0.0
        z: 0.0
        w: 1.0
    meshes: []
    mesh_poses: []
    planes: []
    plane_poses: []
    subframe_names: []
    subframe_poses: []
    operation: 0
  octomap:
    header:
      stamp:
        sec: 0
        nanosec: 0
      frame_id: ''
    origin:
      position:
        x: 0.0
        y: 0.0
        z: 0.0
      orientation:
        x: 0.0
        y: 0.0
        z: 0.0
        w: 1.0
    octomap:
      header:
        stamp:
          sec: 0
          nanosec: 0
        frame_id: ''
      binary: false
      id: ''
      resolution: 0.0
      data: []
is_diff: false
"#;

fn case(name: &str, content: impl Into<Vec<u8>>) -> Case {
    Case::new(format!("scene/{name}"), content)
}

fn dump(name: &str, old: &str, new: &str) -> Case {
    assert!(DUMP.contains(old), "{name}: {old}");
    case(&format!("{name}.yaml"), DUMP.replace(old, new))
}

pub fn cases() -> Vec<Case> {
    let mut cases = dumps();
    cases.extend(shapes());
    cases.extend(poses());
    cases.extend(matrices());
    cases.extend(attached());
    cases.extend(own());
    cases.extend(texts());
    cases.extend(refused());
    cases
}

fn dumps() -> Vec<Case> {
    let empty = DUMP
        .split("  collision_objects:")
        .next()
        .unwrap_or_default()
        .to_owned();
    vec![
        case("dump.yaml", DUMP),
        case("dump_end.yaml", format!("{DUMP}---\n")),
        case("dump_start.yaml", format!("---\n{DUMP}")),
        case("dump_crlf.yaml", DUMP.replace('\n', "\r\n")),
        case(
            "dump_comments.yaml",
            DUMP.replace("world:", "# what stands there\nworld:"),
        ),
        case("dump.yml", DUMP),
        dump("operation_escaped", "operation: 0", "operation: \"\\0\""),
        dump("operation_missing", "    operation: 0\n", ""),
        dump("name_empty", "name: kitchen", "name: ''"),
        dump("name_unicode", "id: table", "id: Küchentisch"),
        dump("id_with_blanks", "id: table", "id: 'big table'"),
        dump("id_number", "id: table", "id: '7'"),
        dump("whole_numbers", "- 1.0\n", "- 1\n"),
        dump("exponents", "z: 0.125", "z: 1.25e-01"),
        dump(
            "flow_lists",
            "      - 1.0\n      - 0.5\n      - 0.25\n",
            "      - 1.0\n      - 5.0e-1\n      - 0.25\n",
        ),
        dump(
            "dimensions_flow",
            "dimensions:\n      - 1.0\n      - 0.5\n      - 0.25",
            "dimensions: [1.0, 0.5, 0.25]",
        ),
        dump(
            "padding",
            "link_padding: []",
            "link_padding:\n- link_name: arm\n  padding: 0.02",
        ),
        dump(
            "scale",
            "link_scale: []",
            "link_scale:\n- link_name: arm\n  scale: 1.5",
        ),
        dump(
            "colours",
            "object_colors: []",
            "object_colors:\n- id: table\n  color:\n    r: 1.0\n    g: 0.0\n    b: 0.0\n    a: 1.0",
        ),
        dump(
            "frame_without_identity",
            "z: 0.0\n    rotation:\n      x: 0.0\n      y: 0.0\n      z: 0.0\n      w: 1.0\n",
            "z: 0.0\n",
        ),
        case(
            "no_objects.yaml",
            format!("{empty}  collision_objects: []\nis_diff: false\n"),
        ),
        case("dump.json", as_json()),
    ]
}

/// The same message as JSON.
fn as_json() -> String {
    r#"{"name": "kitchen", "robot_model_name": "two", "is_diff": false,
 "fixed_frame_transforms": [{"child_frame_id": "base", "transform": {"translation": {"x": 0, "y": 0, "z": 0}, "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}}], "link_padding": [], "link_scale": [],
 "robot_state": {"joint_state": {"name": [], "position": []}, "attached_collision_objects": [], "is_diff": false},
 "allowed_collision_matrix": {"entry_names": [], "entry_values": [], "default_entry_names": [], "default_entry_values": []},
 "world": {"collision_objects": [{"header": {"frame_id": "base"}, "id": "table",
  "pose": {"position": {"x": 0.5, "y": 0.25, "z": 0.125}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}},
  "primitives": [{"type": 1, "dimensions": [1.0, 0.5, 0.25]}],
  "primitive_poses": [{"position": {"x": 0.1, "y": 0.2, "z": 0.3}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}],
  "meshes": [], "mesh_poses": [], "planes": [], "plane_poses": [], "operation": 0}]}}
"#.to_owned()
}

fn shapes() -> Vec<Case> {
    let size = "    - type: 1\n      dimensions:\n      - 1.0\n      - 0.5\n      - 0.25\n";
    let shape = |name: &str, kind: u8, sizes: &str| {
        dump(
            name,
            size,
            &format!("    - type: {kind}\n      dimensions: {sizes}\n"),
        )
    };
    let mesh = "    meshes:\n    - triangles:\n      - vertex_indices: [0, 2, 1]\n      - vertex_indices: [0, 1, 3]\n      - vertex_indices: [0, 3, 2]\n      - vertex_indices: [1, 2, 3]\n      vertices:\n      - {x: 0.0, y: 0.0, z: 0.0}\n      - {x: 1.0, y: 0.0, z: 0.0}\n      - {x: 0.0, y: 0.5, z: 0.0}\n      - {x: 0.0, y: 0.0, z: 0.25}\n    mesh_poses:\n    - position: {x: 1.0, y: 2.0, z: 3.0}\n      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}\n";
    let plane = "    planes:\n    - coef: [0.0, 0.0, 1.0, 0.0]\n    plane_poses:\n    - position: {x: 0.0, y: 0.0, z: 0.0}\n      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}\n";
    let prism = "    - type: 5\n      dimensions: [0.5]\n      polygon:\n        points:\n        - {x: 0.0, y: 0.0, z: 0.0}\n        - {x: 1.0, y: 0.0, z: 0.0}\n        - {x: 0.0, y: 1.0, z: 0.0}\n";
    vec![
        shape("sphere", 2, "[0.3]"),
        shape("cylinder", 3, "[0.5, 0.1]"),
        dump("mesh", "    meshes: []\n    mesh_poses: []\n", mesh),
        dump(
            "subframes",
            "    subframe_names: []\n    subframe_poses: []\n",
            "    subframe_names: [top]\n    subframe_poses:\n    - position: {x: 0.0, y: 0.0, z: 0.5}\n      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}\n",
        ),
        shape("cone", 4, "[0.5, 0.1]").refused(&["table", "cone"], "no such shape is proved here"),
        dump("prism", size, prism).refused(&["table", "prism"], "no such shape is proved here"),
        dump("plane", "    planes: []\n    plane_poses: []\n", plane)
            .refused(&["table", "plane"], "no such shape is proved here"),
        shape("type_0", 0, "[0.5]").refused(&["line 63", "0"], "there is no such type"),
        shape("type_9", 9, "[0.5]").refused(&["line 63", "9"], "there is no such type"),
        shape("box_of_two", 1, "[0.5, 0.1]").refused(&["table", "2"], "a size is missing"),
        shape("negative_box", 1, "[0.5, -0.1, 0.1]")
            .refused(&["table", "-0.1"], "no solid is of negative size"),
    ]
}

fn poses() -> Vec<Case> {
    let frames = |frame: &str| {
        DUMP
        .replace("fixed_frame_transforms:", "fixed_frame_transforms:\n- header:\n    frame_id: shelf\n  child_frame_id: base\n  transform:\n    translation:\n      x: 1.0\n      y: 2.0\n      z: 3.0\n    rotation:\n      x: 0.0\n      y: 0.0\n      z: 1.0\n      w: 0.0")
        .replace("nanosec: 5\n      frame_id: base", &format!("nanosec: 5\n      frame_id: {frame}"))
    };
    let turn = "        z: 0.6\n        w: 0.8\n";
    let second = "  - header:\n      frame_id: OTHER\n    id: cup\n    pose:\n      position: {x: 0.1, y: 0.0, z: 0.0}\n      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}\n    primitives:\n    - {type: 2, dimensions: [0.1]}\n    primitive_poses:\n    - {position: {x: 0.0, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}\n    operation: 0\n  octomap:";
    let two = |frame: &str| DUMP.replacen("  octomap:", &second.replace("OTHER", frame), 1);
    vec![
        dump("pose_not_set", turn, "        z: 0.0\n        w: 0.0\n"),
        dump(
            "quaternion_of_six_digits",
            turn,
            "        z: 0.707107\n        w: 0.707107\n",
        ),
        dump(
            "quaternion_negative",
            turn,
            "        z: -0.6\n        w: -0.8\n",
        ),
        dump(
            "pose_missing",
            "    pose:\n      position:\n        x: 0.5\n        y: 0.25\n        z: 0.125\n      orientation:\n        x: 0.0\n        y: 0.0\n        z: 0.6\n        w: 0.8\n",
            "",
        ),
        case("frame_of_scene.yaml", frames("shelf")),
        case("frame_empty.yaml", frames("''")),
        case("frame_of_object.yaml", two("table")),
        case("frame_of_world.yaml", two("base")),
        case("frame_slash.yaml", two("/base")),
        case("frame_unknown.yaml", two("nowhere"))
            .refused(&["cup", "nowhere"], "nobody knows where that is"),
        dump("quaternion_2", turn, "        z: 0.0\n        w: 2.0\n")
            .refused(&["table", "norm 2"], "it is no rotation"),
        dump("position_nan", "x: 0.5", "x: .nan")
            .refused(&["line 50", "NaN"], "nobody knows where that is"),
    ]
}

fn matrices() -> Vec<Case> {
    let matrix =
        |name: &str, rows: &str| dump(name, "  entry_names: []\n  entry_values: []\n", rows);
    vec![
        matrix(
            "allowed",
            "  entry_names: [arm, base, table]\n  entry_values:\n  - enabled: [false, true, false]\n  - enabled: [true, false, true]\n  - enabled: [false, true, false]\n",
        ),
        matrix(
            "allowed_bare_rows",
            "  entry_names: [arm, table]\n  entry_values:\n  - [false, true]\n  - [true, false]\n",
        ),
        matrix(
            "allowed_diagonal",
            "  entry_names: [arm, table]\n  entry_values:\n  - enabled: [true, false]\n  - enabled: [false, true]\n",
        ),
        dump(
            "default_entries_false",
            "  default_entry_names: []\n  default_entry_values: []\n",
            "  default_entry_names: [<octomap>]\n  default_entry_values: [false]\n",
        ),
        matrix(
            "allowed_short_row",
            "  entry_names: [arm, table]\n  entry_values:\n  - enabled: [false]\n  - enabled: [true, false]\n",
        )
        .refused(&["allowed_collision_matrix", "arm"], "the matrix is not square"),
    ]
}

fn attached() -> Vec<Case> {
    let object = "  attached_collision_objects:\n  - link_name: arm\n    object:\n      header:\n        frame_id: arm\n      id: cup\n      pose:\n        position: {x: 0.0, y: 0.0, z: 0.25}\n        orientation: {x: 0.0, y: 0.0, z: 0.6, w: 0.8}\n      primitives:\n      - {type: 3, dimensions: [0.2, 0.05]}\n      primitive_poses:\n      - {position: {x: 0.1, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}\n      operation: 0\n    touch_links: [arm, hand]\n    detach_posture:\n      joint_names: []\n      points: []\n    weight: 0.0\n";
    let none = "  attached_collision_objects: []\n";
    vec![
        dump("attached", none, object),
        dump(
            "attached_without_frame",
            none,
            &object.replace("      header:\n        frame_id: arm\n", ""),
        ),
        dump(
            "attached_no_touch",
            none,
            &object.replace("[arm, hand]", "[]"),
        ),
        dump(
            "attached_elsewhere",
            none,
            &object.replace("frame_id: arm", "frame_id: hand"),
        )
        .refused(
            &["cup", "arm", "hand"],
            "where it is held is not said in the link's frame",
        ),
    ]
}

/// Files in our own words.
fn own() -> Vec<Case> {
    let text = r#"{ "name": "kitchen", "objects": [ { "id": "table",
  "primitives": [ { "type": "box", "dimensions": [1.0, 0.5, 0.25] } ],
  "primitive_poses": [ { "position": [0.1, 0.2, 0.3], "orientation": { "x": 0, "y": 0, "z": 0.6, "w": 0.8 } } ] } ] }
"#;
    vec![
        case("own.json", text),
        case("own_bom.json", format!("\u{feff}{text}")),
        case("own_as.yaml", text),
        case("own_capital_type.json", text.replace("\"box\"", "\"BOX\"")),
        case("own_exponents.json", text.replace("0.25]", "2.5E-1]")),
        case(
            "own_empty_pose.json",
            text.replace(
                "{ \"position\": [0.1, 0.2, 0.3], \"orientation\": { \"x\": 0, \"y\": 0, \"z\": 0.6, \"w\": 0.8 } }",
                "{}",
            ),
        ),
    ]
}

const TEXT: &str = "our kitchen\n* big table\n0.5 0 0.4\n0 0 0.6 0.8\n2\nbox\n1.2 0.8 0.05\n1 0 0\n0 0 0 1\n0 0 0 0\n\
    cylinder\n0.03 0.7\n0 0 -0.35\n0 0 0 1\n0 0 0 0\n1\nhandle\n0 0 1\n0 0 0 1\n* ball\n0 1 0\n0 0 0 1\n1\nsphere\n0.1\n0 0 0\n\
    0 0 0 1\n0 0 0 0\n0\n.\n";

fn texts() -> Vec<Case> {
    let case = |name: &str, text: String| case(&format!("{name}.scene"), text);
    let old = "(noname)\n* cup\n1\ncylinder\n0.04 0.1\n0.5 0 1\n0 0 0 1\n0 0 0 0\n.\n".to_owned();
    let mesh = "tents\n* tent\n0 0 0\n0 0 0 1\n1\nmesh\n4 4\n0 0 0\n1 0 0\n0 0.5 0\n0 0 0.25\n0 2 1\n0 1 3\n0 3 2\n1 2 3\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n".to_owned();
    vec![
        case("text", TEXT.to_owned()),
        case("text_old", old),
        case("text_mesh", mesh),
        case("text_crlf", TEXT.replace('\n', "\r\n")),
        case("text_no_last_newline", TEXT.trim_end().to_owned()),
        case("text_exponents", TEXT.replace("0.35", "3.5e-01")),
        case("text_empty", "nothing\n.\n".to_owned()),
        case("text_more_behind", format!("{TEXT}\n# saved by hand\n")),
    ]
}

fn refused() -> Vec<Case> {
    let octomap = "binary: true\n      id: OcTree\n      resolution: 0.05\n      data: [0, -128]";
    vec![
        dump("octomap", "binary: false\n      id: ''\n      resolution: 0.0\n      data: []", octomap).refused(&["octomap"], "what it holds would not be looked at"),
        dump("is_diff", "object_colors: []\n", "object_colors: []\n").with(|text| text.replace("is_diff: false\n", "is_diff: true\n")).refused(&["diff"], "it is no whole scene"),
        dump("misspelt", "    primitives:\n", "    primitves:\n").refused(&["primitves"], "what it holds would not be looked at"),
        dump("poses_too_few", "    primitive_poses:\n    - position:\n        x: 0.1\n        y: 0.2\n        z: 0.3\n      orientation:\n        x: 0.0\n        y: 0.0\n        z: 0.0\n        w: 1.0\n", "    primitive_poses: []\n").refused(&["table", "1 primitives", "0 poses"], "MoveIt leaves such an object out"),
        dump("cut_lists", "      - 1.0\n      - 0.5\n      - 0.25\n", "      - 1.0\n      - '...'\n").refused(&["--full-length"], "`ros2 topic echo` has cut it short"),
        case("text_cut.scene", TEXT[..60].to_owned()).refused(&["line", "cut short"], "a part is lost"),
    ]
}
