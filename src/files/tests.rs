use std::fs;

use super::*;

/// A folder with a robot in a package, a scene and a problem.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = dir.path().join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    };
    let wedge = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    write("arm_package/meshes/wedge.obj", wedge);
    let link = |name: &str, shape: &str| {
        format!("<link name='{name}'><collision><geometry>{shape}</geometry></collision></link>\n")
    };
    let joints = "<joint name='slide' type='prismatic'><parent link='base'/><child link='tool'/>
        <limit lower='0' upper='1'/></joint></robot>";
    let mesh = "<mesh filename='package://arm_package/meshes/wedge.obj' scale='0.1 0.1 0.1'/>";
    let robot = |shape: &str| {
        format!(
            "<robot name='file'>{}{}{joints}",
            link("base", mesh),
            link("tool", shape)
        )
    };
    write("arm_package/urdf/arm.urdf", &robot("<box size='1 1 1'/>"));
    write(
        "arm_package/urdf/arm_spheres.urdf",
        &robot("<sphere radius='1'/>"),
    );
    let srdf = "<robot name='file'><disable_collisions link1='base' link2='tool'/>
        <virtual_joint name='srdf_root' type='planar' parent_frame='w' child_link='base'/></robot>";
    write("arm_package/arm.srdf", srdf);
    write("problems/p.json", PROBLEM);
    dir
}

const PROBLEM: &str = r#"{ "format": "taut-problem/1", "name": "p",
    "robot": { "name": "arm", "urdf": "../arm_package/urdf/arm.urdf", "srdf": "../arm_package/arm.srdf",
        "spherized_urdf": "../arm_package/urdf/arm_spheres.urdf", "spherized_allowed_collisions": [["base", "tool"]],
        "virtual_joint": { "name": "root", "type": "planar", "position_bounds": [[-1, 1], [-2, 2]] } },
    "variables": ["slide", "root/x", "root/y", "root/theta"],
    "metric": { "weights_per_dof": [1, 1, 1, 0.5] },
    "scene": { "name": "s", "objects": [ { "id": "wedge",
        "meshes": [ { "file": "../arm_package/meshes/wedge.obj", "scale": [1, 1, 1] } ], "mesh_poses": [ {} ] } ] },
    "path": [[0, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 0]], "path_length": 2.0, "lower_bound": 1.4142135623730951,
    "peers": { "other": { "length": 1.5, "cpu_s": 0.001, "honest": true, "more": 1 } },
    "best_honest_peer": { "name": "other", "length": 1.5, "cpu_s": 0.001 }, "unknown": 1 }"#;

fn problem(dir: &Path, text: &str, geometry: Geometry) -> Result<Problem, FileError> {
    let file = dir.join("problems/p.json");
    fs::write(&file, text).unwrap();
    Reader::default().problem(&file, geometry)
}

#[test]
fn a_problem_decides_on_the_virtual_joint_and_the_order_of_columns() {
    let dir = folder();
    let problem = problem(dir.path(), PROBLEM, Geometry::Given).unwrap();
    let model = problem.model().unwrap();
    assert_eq!((problem.name.as_str(), model.name()), ("p", "arm"));
    let names: Vec<&str> = model
        .variables()
        .iter()
        .map(|v| v.name.as_str())
        .collect();
    assert_eq!(names, ["slide", "root/x", "root/y", "root/theta"]);
    assert_eq!(
        (model.variables()[2].lower, model.variables()[2].upper),
        (-2.0, 2.0)
    );
    assert_eq!(problem.path.waypoint(2), [1.0, 1.0, 0.0, 0.0]);
    assert_eq!(problem.weights, Some(vec![1.0, 1.0, 1.0, 0.5]));
    assert!(problem.has_spheres && problem.peers["other"].honest);
    assert_eq!(problem.best_honest_peer.unwrap().0, "other");
    assert_eq!(problem.scene.obstacles().len(), 1);

    let fixed = PROBLEM.replace(
        r#"{ "name": "root", "type": "planar", "position_bounds": [[-1, 1], [-2, 2]] }"#,
        "null",
    );
    let fixed = fixed.replace(r#""slide", "root/x", "root/y", "root/theta""#, r#""slide""#);
    let fixed = fixed.replace("[[0, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 0]]", "[[0], [1]]");
    let problem = self::problem(dir.path(), &fixed, Geometry::Given).unwrap();
    assert_eq!(
        problem.model().unwrap().space().nv(),
        1,
        "null fixes the root, whatever the SRDF says"
    );
}

#[test]
fn spheres_come_with_their_own_allowed_pairs() {
    let dir = folder();
    let problem = problem(dir.path(), PROBLEM, Geometry::Spheres).unwrap();
    assert!(matches!(
        problem.robot.links[1].collision[0].shape,
        crate::shape::Shape::Sphere { .. }
    ));
    assert_eq!(problem.robot.allowed_collisions.len(), 1);
    let none = PROBLEM.replace("spherized_urdf", "other");
    let text = self::problem(dir.path(), &none, Geometry::Spheres)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("p.json") && text.contains("spherized_urdf"),
        "{text}"
    );
}

#[test]
fn a_bad_problem_says_what_and_where() {
    let dir = folder();
    for (old, new, parts) in [
        (
            "taut-problem/1",
            "taut-problem/9",
            ["p.json", "taut-problem/9", "taut-problem/1"],
        ),
        (
            "[0, 1, 0, 0]",
            "[0, 1, 0]",
            ["p.json", "path row 1", "4 columns"],
        ),
        (
            "\"path\": [[0, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 0]]",
            "\"path\": []",
            ["p.json", "path", "empty"],
        ),
        (
            "[0, 1, 0, 0]",
            "[0, \"1\", 0, 0]",
            ["p.json", "line 9", "f64"],
        ),
        ("\"planar\"", "\"ball\"", ["p.json", "ball", "floating"]),
        (
            "[[-1, 1], [-2, 2]]",
            "[[-1, 1]]",
            ["p.json", "1 position_bounds", "2 translations"],
        ),
        ("arm.urdf", "leg.urdf", ["leg.urdf", "No such file", ""]),
        (
            "../arm_package/meshes",
            "../meshes",
            ["p.json", "wedge", "../meshes/wedge.obj"],
        ),
    ] {
        let text = problem(dir.path(), &PROBLEM.replace(old, new), Geometry::Given)
            .unwrap_err()
            .to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)),
            "{text:?} lacks one of {parts:?}"
        );
    }
    let unknown = PROBLEM.replace("\"slide\"", "\"slid\"");
    let text = problem(dir.path(), &unknown, Geometry::Given)
        .unwrap()
        .model()
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("arm.urdf") && text.contains("slid") && text.contains("root/theta"),
        "{text}"
    );
}

#[test]
fn a_package_is_found_by_name_by_environment_and_above_the_robot() {
    let dir = folder();
    let urdf = dir.path().join("arm_package/urdf/arm.urdf");
    let reference = "package://arm_package/meshes/wedge.obj";
    let beside = Packages::default()
        .resolve(reference, urdf.parent().unwrap())
        .unwrap();
    assert!(beside.ends_with("arm_package/meshes/wedge.obj"));

    let elsewhere = tempfile::tempdir().unwrap();
    let named = BTreeMap::from([("arm_package".to_owned(), dir.path().join("arm_package"))]);
    assert!(
        Packages::new(named.clone())
            .resolve(reference, elsewhere.path())
            .is_ok()
    );
    let text = Packages::default()
        .resolve(reference, elsewhere.path())
        .unwrap_err();
    assert!(text.contains("--package arm_package=FOLDER"), "{text}");
    let wrong = Packages::new(named)
        .resolve("package://arm_package/no.obj", elsewhere.path())
        .unwrap_err();
    assert!(
        wrong.contains("no.obj") && wrong.contains("arm_package"),
        "{wrong}"
    );

    let file = format!(
        "file://{}",
        dir.path()
            .join("arm_package/arm.srdf")
            .display()
    );
    assert!(
        Packages::default()
            .resolve(&file, elsewhere.path())
            .is_ok()
    );
    assert!(
        Packages::default()
            .resolve("../arm.srdf", urdf.parent().unwrap())
            .is_ok()
    );
}

#[test]
fn a_robot_without_a_problem_takes_the_srdfs_virtual_joint() {
    let dir = folder();
    let urdf = dir.path().join("arm_package/urdf/arm.urdf");
    let mut reader = Reader::default();
    assert!(
        reader
            .robot(&urdf, None)
            .unwrap()
            .virtual_joint
            .is_none()
    );
    let srdf = dir.path().join("arm_package/arm.srdf");
    assert_eq!(
        reader
            .robot(&urdf, Some(&srdf))
            .unwrap()
            .virtual_joint
            .unwrap()
            .name,
        "srdf_root"
    );
    let text = reader
        .robot(&urdf, Some(&dir.path().join("no.srdf")))
        .unwrap_err()
        .to_string();
    assert!(text.contains("no.srdf"), "{text}");
}

fn variables(names: &[&str]) -> Vec<crate::robot::Variable> {
    let free = |name: &&str| crate::robot::Variable::within(name, -1.0, 1.0);
    names.iter().map(free).collect()
}

fn table(name: &str, text: &str) -> Result<PathTable, FileError> {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join(name);
    fs::write(&file, text).unwrap();
    PathTable::read(&file)
}

#[test]
fn columns_go_to_the_robots_order_by_name() {
    let json = r#"{ "variables": ["b", "a"], "path": [[1, 2], [3, 4]] }"#;
    let csv = "# a comment\nb, a\n1, 2\n3, 4\n";
    for (name, text) in [("p.json", json), ("p.csv", csv)] {
        let (path, kept) = table(name, text)
            .unwrap()
            .into_path(&variables(&["a", "b"]))
            .unwrap();
        assert_eq!(path.as_flat(), [2.0, 1.0, 4.0, 3.0]);
        assert!(kept.is_empty());
    }
}

#[test]
fn a_bad_path_says_what_and_where() {
    for (name, text, parts) in [
        (
            "p.csv",
            "a,b\n1,2\n3,x\n",
            ["p.csv", "line 3", "\"b\"", "\"x\""],
        ),
        ("p.csv", "a,b\n1,NaN\n", ["p.csv", "line 2", "\"b\"", "NaN"]),
        (
            "p.csv",
            "a,b\n1,2\n3\n",
            ["p.csv", "line 3", "1 numbers", "2"],
        ),
        ("p.csv", "a,b\n", ["p.csv", "empty", "", ""]),
        ("p.csv", "a,a\n1,2\n", ["p.csv", "\"a\"", "twice", ""]),
        (
            "p.json",
            "{ \"path\": [[1]] }",
            ["p.json", "variables", "line 1", ".csv"],
        ),
        (
            "p.json",
            "{ \"variables\": [\"a\"], \"path\": [[1, 2]] }",
            ["p.json", "row 0", "2 numbers", "1 columns"],
        ),
    ] {
        let text = table(name, text)
            .expect_err("must be refused")
            .to_string();
        assert!(
            parts.iter().all(|part| text.contains(part)),
            "{text:?} lacks one of {parts:?}"
        );
    }
    // Joints may have such names, so the robot decides.
    let numbers = || table("p.csv", "1,2\n3,4\n").unwrap();
    let text = numbers()
        .into_path(&variables(&["a", "b"]))
        .unwrap_err()
        .to_string();
    assert!(
        ["p.csv", "line 1", "header", "a, b"]
            .iter()
            .all(|part| text.contains(part)),
        "{text}"
    );
    assert_eq!(
        numbers()
            .into_path(&variables(&["2", "1"]))
            .unwrap()
            .0
            .as_flat(),
        [4.0, 3.0]
    );
    let read = || table("p.csv", "a,b\n1,2\n").unwrap();
    let text = read()
        .into_path(&variables(&["a"]))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("\"b\" is no variable") && text.contains("valid: a"),
        "{text}"
    );
    let text = read()
        .into_path(&variables(&["a", "b", "c"]))
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("\"c\" is missing") && text.contains("a, b, c"),
        "{text}"
    );
}

#[test]
fn csv_is_read_as_programs_write_it() {
    for text in [
        "a,b\n1,2.5\n",
        "\u{feff}\"a\",'b'\n1,2.5\n",
        "time,a [rad],b (m)\n0.0,1,2.5\n",
        "stamp;b;a\n12:00;2,5;1\n",
        "a\tb\n1\t2,5\n",
        "a,b,\n1,2.5,\n",
        "# a,b\n1,2.5\n",
        "# recorded today, by hand\n# a, b\n1,2.5\n",
        "a,b\r\n1,2.5\r\n\r\n",
    ] {
        let path = table("p.csv", text).and_then(|table| table.into_path(&variables(&["a", "b"])));
        assert_eq!(
            path.unwrap_or_else(|error| panic!("{text:?}: {error}"))
                .0
                .as_flat(),
            [1.0, 2.5],
            "{text:?}"
        );
    }
    let error = table("p.csv", "t,a\nnow,1\n")
        .unwrap()
        .into_path(&variables(&["a", "t"]))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("p.csv") && error.contains("\"t\"") && error.contains("finite"),
        "{error}"
    );
    let error = table("p.csv", "a [deg]\n90\n")
        .unwrap()
        .into_path(&variables(&["a"]))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("p.csv") && error.contains("in deg"),
        "{error}"
    );
}

#[test]
fn what_a_message_says_beside_its_path_is_not_left_out_in_silence() {
    let points = r#""trajectory": { "joint_trajectory": { "joint_names": ["a"], "points": [{ "positions": [1] }] } }"#;
    let read = |more: &str| {
        table("p.json", &format!("{{ {points}{more} }}")).map_err(|error| error.to_string())
    };
    for fine in [
        "",
        r#", "trajectory_start": { "joint_state": { "name": ["b"], "position": [1] }, "attached_collision_objects": [] }"#,
        r#", "path_constraints": { "name": "", "joint_constraints": [], "orientation_constraints": [] }"#,
        r#", "trajectory_start": { "multi_dof_joint_state": { "joint_names": ["v"], "transforms": [{ "rotation": { "w": 1 } }] } }"#,
    ] {
        assert!(read(fine).is_ok(), "{fine}: {:?}", read(fine));
    }
    for (bad, parts) in [
        (
            r#", "path_constraints": { "orientation_constraints": [{ "link_name": "a" }] }"#,
            ["path_constraints", "missing field"],
        ),
        (
            r#", "trajectory_constraints": { "constraints": [{ "joint_constraints": [{ "joint_name": "a" }] }] }"#,
            ["trajectory_constraints", "not supported"],
        ),
        (
            r#", "trajectory_start": { "attached_collision_objects": [{ "object": { "id": "cup" } }] }"#,
            ["attached_collision_objects", "cup"],
        ),
        (
            r#", "trajectory_start": { "multi_dof_joint_state": { "joint_names": ["v"], "transforms": [{ "translation": { "x": 1 } }] } }"#,
            ["multi_dof_joint_state", "--hold v/x"],
        ),
    ] {
        let error = read(bad).unwrap_err();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    let table = table(
        "p.json",
        r#"{ "variables": ["a"], "path": [[1]], "path_constraints": { "position_constraints": [1] } }"#,
    );
    assert!(
        table
            .unwrap_err()
            .to_string()
            .contains("path_constraints")
    );
}

#[test]
fn a_scene_comes_from_its_own_file_or_from_a_problem() {
    let dir = folder();
    let file = dir.path().join("problems/p.json");
    assert_eq!(
        Reader::default()
            .scene(&file)
            .unwrap()
            .obstacles()[0]
            .id,
        "wedge"
    );
    let own = dir.path().join("scene.json");
    fs::write(&own, r#"{ "objects": [ { "id": "cup" } ] }"#).unwrap();
    let scene = Reader::default().scene(&own).unwrap();
    assert!(
        scene.warnings()[0].contains("\"cup\" has no shapes"),
        "{:?}",
        scene.warnings()
    );
    for (text, part) in [
        (r#"{ "scene": { "objects": [ {} ] } }"#, "`id`"),
        (r#"{ "name": "s" }"#, "`objects`"),
    ] {
        fs::write(&own, text).unwrap();
        let text = Reader::default()
            .scene(&own)
            .unwrap_err()
            .to_string();
        assert!(text.contains("scene.json") && text.contains(part), "{text}");
    }
}

#[test]
fn a_scene_may_be_moveits_text_whatever_became_of_its_files_name() {
    let dir = folder();
    let text = "kitchen\n* cup\n1\nsphere\n0.1\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n";
    let file = dir.path().join("kitchen.scene");
    fs::write(&file, text).unwrap();
    let scene = Reader::default().scene(&file).unwrap();
    assert_eq!(
        (scene.name(), scene.obstacles()[0].id.as_str()),
        ("kitchen", "cup")
    );
    // The daemon gets the text and a label.
    let sent = Reader::default()
        .scene_of_text(&scene_text(&file).unwrap(), &dir.path().join("my kitchen"))
        .unwrap();
    assert_eq!(sent.hash(), scene.hash());
    fs::write(&file, text.replace("sphere", "cone")).unwrap();
    let text = Reader::default()
        .scene(&file)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("kitchen.scene: line 4") && text.contains("\"cup\" has a cone"),
        "{text}"
    );
    // A JSON scene that is broken is still called one.
    let own = dir.path().join("scene.json");
    fs::write(&own, "[1, 2").unwrap();
    assert!(
        Reader::default()
            .scene(&own)
            .unwrap_err()
            .to_string()
            .contains("not a scene")
    );
}

/// An open triangle drawn in millimetres.
const SHEET: &str = "v 0 0 0\nv 80 0 0\nv 0 60 0\nf 1 2 3\n";

#[test]
fn an_odd_mesh_is_told_once_for_a_robot_and_once_for_a_scene() {
    let dir = folder();
    fs::write(dir.path().join("sheet.obj"), SHEET).unwrap();
    let shape = "<collision><geometry><mesh filename='sheet.obj'/></geometry></collision>";
    let robot = format!(
        "<robot name='r'><link name='a'>{}</link></robot>",
        shape.repeat(3)
    );
    fs::write(dir.path().join("r.urdf"), robot).unwrap();
    let robot = Reader::default()
        .robot(&dir.path().join("r.urdf"), None)
        .unwrap();
    let [large, open] = robot.warnings.as_slice() else {
        panic!("two warnings: {:?}", robot.warnings)
    };
    assert!(
        large.contains("sheet.obj is 80.0 × 60.0 × 0.000 m large"),
        "{large}"
    );
    assert!(large.contains(r#"scale="0.001 0.001 0.001""#), "{large}");
    assert!(
        open.contains("sheet.obj is not closed: 3 of 3 edges"),
        "{open}"
    );

    let object = |id: &str| {
        format!(
            r#"{{ "id": "{id}", "meshes": [{{ "file": "sheet.obj" }}, {{ "file": "sheet.obj" }}], "mesh_poses": [{{}}, {{}}] }}"#
        )
    };
    let scene = format!(
        r#"{{ "objects": [{}, {}, {}] }}"#,
        object("cup"),
        object("jug"),
        object("pot")
    );
    fs::write(dir.path().join("s.json"), scene).unwrap();
    let scene = Reader::default()
        .scene(&dir.path().join("s.json"))
        .unwrap();
    assert_eq!(scene.warnings().len(), 2, "{:?}", scene.warnings());
    assert!(scene.warnings()[0].starts_with("object \"cup\" and 2 more: mesh sheet.obj is 80.0"));
}

#[test]
fn collada_meshes_are_read_for_robots_and_scenes() {
    let dir = folder();
    let dae = r##"<COLLADA version="1.4.1"><asset><unit meter="0.01"/></asset><library_geometries><geometry id="g"><mesh>
        <source id="s"><float_array id="f" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
        </mesh></geometry></library_geometries></COLLADA>"##;
    fs::write(dir.path().join("arm_package/meshes/tent.DAE"), dae).unwrap();
    let mesh = "<mesh filename='package://arm_package/meshes/tent.DAE' scale='10 10 10'/>";
    let robot = format!(
        "<robot name='r'><link name='a'><collision><geometry>{mesh}</geometry></collision></link></robot>"
    );
    fs::write(dir.path().join("arm_package/urdf/r.urdf"), robot).unwrap();
    let robot = Reader::default()
        .robot(&dir.path().join("arm_package/urdf/r.urdf"), None)
        .unwrap();
    let crate::shape::Shape::Mesh(mesh) = &robot.links[0].collision[0].shape else {
        panic!("a mesh")
    };
    assert!(
        (mesh.signed_volume() - 0.001 / 6.0).abs() < 1e-12 && robot.warnings.is_empty(),
        "{:?}",
        robot.warnings
    );

    let scene = r#"{ "objects": [{ "id": "tent", "meshes": [{ "file": "arm_package/meshes/tent.DAE" }], "mesh_poses": [{}] }] }"#;
    let file = dir.path().join("s.json");
    fs::write(&file, scene).unwrap();
    assert_eq!(
        Reader::default()
            .scene(&file)
            .unwrap()
            .obstacles()[0]
            .shapes
            .len(),
        1
    );
    fs::write(
        dir.path().join("arm_package/meshes/tent.DAE"),
        dae.replace("<p>0 2 1 ", "<p>0 2 9 "),
    )
    .unwrap();
    let text = Reader::default()
        .scene(&file)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("s.json: object \"tent\": mesh arm_package/meshes/tent.DAE: line 4"),
        "{text}"
    );
    assert!(text.contains("position 9"), "{text}");
}
