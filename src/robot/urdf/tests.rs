use super::*;
use crate::robot::{Drive, RobotModel};
use crate::shape::Shape;

/// A source without meshes.
fn no_mesh(name: &str, _: Vec3) -> Result<Arc<Mesh>, MeshError> {
    Err(MeshError::Unreadable {
        name: name.to_owned(),
        reason: "there is no such file".to_owned(),
    })
}

fn read(body: &str) -> Result<RobotDescription, RobotError> {
    parse(
        &format!("<robot name=\"r\">\n{body}\n</robot>"),
        &mut no_mesh,
    )
}

/// What the reader or the model says against a robot.
fn refusal(body: &str) -> String {
    match read(body) {
        Err(error) => error.to_string(),
        Ok(description) => RobotModel::new(description)
            .expect_err("must be refused")
            .to_string(),
    }
}

fn assert_refused(body: &str, parts: &[&str]) {
    let text = refusal(body);
    assert!(
        parts.iter().all(|part| text.contains(part)),
        "{text:?} lacks one of {parts:?}"
    );
    assert!(!text.contains('\n'), "one line: {text:?}");
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, inside: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>\n"
    )
}

fn links(names: &[&str]) -> String {
    names
        .iter()
        .map(|name| format!("<link name='{name}'/>\n"))
        .collect()
}

/// Two links and one revolute joint that has `inside`.
fn arm(inside: &str) -> String {
    links(&["a", "b"]) + &joint("j", "revolute", "a", "b", inside)
}

const LIMIT: &str = "<limit lower='-1' upper='2'/>";

#[test]
fn every_joint_kind_is_read() {
    let body = links(&["a", "b", "c", "d", "e", "f", "g"])
        + &joint(
            "fixed",
            "fixed",
            "a",
            "b",
            "<origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>",
        )
        + &joint(
            "turn",
            "revolute",
            "b",
            "c",
            &format!("<axis xyz='0 0 2'/>{LIMIT}"),
        )
        + &joint(
            "wheel",
            "continuous",
            "c",
            "d",
            "<axis xyz='0 1 0'/><limit lower='-1' upper='1' velocity='1'/>",
        )
        + &joint("slide", "prismatic", "d", "e", LIMIT)
        + &joint("plane", "planar", "e", "f", "<axis xyz='0 0 1'/>")
        + &joint("free", "floating", "f", "g", "");
    let model = RobotModel::new(read(&body).unwrap()).unwrap();
    let names: Vec<&str> = model
        .variables()
        .iter()
        .map(|v| v.name.as_str())
        .collect();
    assert_eq!(
        names[..6],
        [
            "turn",
            "wheel",
            "slide",
            "plane/x",
            "plane/y",
            "plane/theta"
        ]
    );
    assert_eq!((model.space().nq(), model.space().nv()), (13, 12));
    assert_eq!(
        (model.variables()[0].lower, model.variables()[0].upper),
        (-1.0, 2.0)
    );
    assert_eq!(
        model.variables()[1].upper,
        f64::INFINITY,
        "a continuous joint has no limits"
    );
    assert_eq!(model.joints()[2].axis, Vec3::Z);
    assert_eq!(model.joints()[4].axis, Vec3::X, "URDF's default axis");
    let turned = model.joints()[1]
        .origin
        .transform_point(Vec3::X);
    assert!((turned - Vec3::new(1.0, 3.0, 3.0)).length() < 1e-12);
}

#[test]
fn every_shape_is_read_with_its_pose() {
    let collision = |shape: &str| {
        format!("<collision><origin xyz='0 0 1'/><geometry>{shape}</geometry></collision>")
    };
    let shapes = [
        "<box size='1 2 3'/>",
        "<sphere radius='2'/>",
        "<cylinder radius='1' length='4'/>",
    ];
    let body = format!(
        "<link name='a'>{}{}<collision><geometry><mesh filename='m.stl' scale='1 -2 1'/></geometry></collision></link>",
        shapes.map(collision).concat(),
        collision("<capsule radius='1' length='4'/>")
    );
    let mut asked = Vec::new();
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Arc::new(Mesh::new("m.stl", corners, vec![[0, 1, 2]]).unwrap());
    let mut source = |name: &str, scale: Vec3| {
        asked.push((name.to_owned(), scale));
        Ok(mesh.clone())
    };
    let robot = parse(&format!("<robot name='r'>{body}</robot>"), &mut source).unwrap();
    let [cuboid, sphere, cylinder, capsule, meshed] = robot.links[0].collision.as_slice() else {
        panic!("five shapes")
    };
    assert_eq!(
        cuboid.shape,
        Shape::Box {
            half_extents: Vec3::new(0.5, 1.0, 1.5)
        }
    );
    assert_eq!(cuboid.pose.translation, Vec3::Z);
    assert_eq!(sphere.shape, Shape::Sphere { radius: 2.0 });
    assert_eq!(
        cylinder.shape,
        Shape::Cylinder {
            radius: 1.0,
            half_height: 2.0
        }
    );
    assert_eq!(
        capsule.shape,
        Shape::Capsule {
            radius: 1.0,
            half_length: 2.0
        }
    );
    assert!(matches!(meshed.shape, Shape::Mesh(_)));
    assert_eq!(asked, [("m.stl".to_owned(), Vec3::new(1.0, -2.0, 1.0))]);
    assert!(
        robot.warnings[1].contains("m.stl is not closed: 3 of 3 edges"),
        "{:?}",
        robot.warnings
    );
}

#[test]
fn what_is_not_collision_geometry_cannot_fail_the_robot() {
    let body = "<link name='a'>
        <inertial><mass value='heavy'/></inertial>
        <visual><geometry><mesh filename='nowhere.dae'/></geometry><material><texture/></material></visual>
        <collision><geometry><sphere radius='1'/></geometry><verbose value='x'/></collision></link>
        <material name='m'><texture/></material><gazebo><link/></gazebo><transmission name='t'/>";
    assert_eq!(read(body).unwrap().links[0].collision.len(), 1);
}

#[test]
fn a_tree_that_is_none_is_refused() {
    let two = links(&["a", "b"]);
    let both = joint("j", "fixed", "a", "b", "") + &joint("k", "fixed", "b", "a", "");
    assert_refused(&format!("{two}{both}"), &["loop"]);
    let apart = links(&["r", "a", "b"]) + &both;
    assert_refused(&apart, &["loop", "a, b"]);
    assert_refused(
        &(two.clone() + &joint("j", "fixed", "nowhere", "b", "")),
        &["\"j\"", "nowhere", "a, b"],
    );
    assert_refused(&links(&["a", "a"]), &["link", "\"a\"", "twice"]);
    let twice = joint("j", "fixed", "a", "b", "") + &joint("j", "fixed", "a", "c", "");
    assert_refused(
        &(links(&["a", "b", "c"]) + &twice),
        &["joint", "\"j\"", "twice"],
    );
    assert_refused(&two, &["2 links are no joint's child", "a, b"]);
    assert_refused("", &["no link"]);
}

#[test]
fn numbers_that_cannot_be_are_refused_with_their_place() {
    assert_refused(
        &arm("<limit lower='nan' upper='1'/>"),
        &["limits", "\"j\"", "NaN"],
    );
    assert_refused(
        &arm("<limit lower='2' upper='1'/>"),
        &["limits", "\"j\"", "[2, 1]"],
    );
    assert_refused(&arm(""), &["limits", "\"j\"", "missing", "continuous"]);
    assert_refused(
        &arm(&format!("<axis xyz='0 0 0'/>{LIMIT}")),
        &["axis", "\"j\"", "zero"],
    );
    assert_refused(
        &arm(&format!("<axis xyz='0 0'/>{LIMIT}")),
        &["line 4", "\"j\"", "2 numbers", "3"],
    );
    assert_refused(
        &arm(&format!("<axis xyz='0 0 up 1'/>{LIMIT}")),
        &["line 4", "\"j\"", "up"],
    );
    assert_refused(
        &arm(&format!("<origin xyz='0 0 inf'/>{LIMIT}")),
        &["origin", "\"j\""],
    );
    let sphere = |radius: &str| {
        format!(
            "<link name='a'><collision><geometry><sphere radius='{radius}'/></geometry></collision></link>"
        )
    };
    assert_refused(&sphere("-1"), &["link \"a\"", "radius", "-1"]);
    assert_refused(&sphere("nan"), &["link \"a\"", "radius", "NaN"]);
    assert_refused(&sphere("1m"), &["line 2", "link \"a\"", "1m"]);
}

#[test]
fn elements_that_cannot_be_read_are_refused_with_their_line() {
    let geometry =
        |inside: &str| format!("<link name='a'>\n<collision>{inside}</collision></link>");
    assert_refused("<link/>", &["line 2", "<link>", "name"]);
    assert_refused(&geometry(""), &["line 3", "link \"a\"", "<geometry>"]);
    assert_refused(&geometry("<geometry/>"), &["line 3", "0 shapes", "sphere"]);
    assert_refused(
        &geometry("<geometry><cone/></geometry>"),
        &["line 3", "<cone>", "cylinder"],
    );
    assert_refused(
        &geometry("<geometry><sphere/></geometry>"),
        &["line 3", "<sphere>", "radius"],
    );
    assert_refused(
        &geometry("<geometry><mesh/></geometry>"),
        &["line 3", "<mesh>", "filename"],
    );
    assert_refused(
        &geometry("<geometry><mesh filename='m.stl'/></geometry>"),
        &["link a", "m.stl", "no such file"],
    );
    let two = links(&["a", "b"]);
    assert_refused(
        &(two.clone() + &joint("j", "spherical", "a", "b", "")),
        &["line 4", "\"j\"", "spherical"],
    );
    assert_refused(
        &(two.clone() + &joint("j", "hinge", "a", "b", "")),
        &["line 4", "hinge", "revolute"],
    );
    assert_refused(
        &(two + "<joint name='j' type='fixed'><parent link='a'/></joint>"),
        &["line 4", "<child>"],
    );
    assert_refused("<link name='a'>", &["XML", "3:1"]);
    let other = parse("<sdf/>", &mut no_mesh)
        .unwrap_err()
        .to_string();
    assert!(
        other.contains("<sdf>") && other.contains("<robot>"),
        "{other}"
    );
    let xacro = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>\n<xacro:macro name='m'/></robot>";
    let text = parse(xacro, &mut no_mesh)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("line 2") && text.contains("xacro FILE"),
        "{text}"
    );
}

#[test]
fn a_missing_end_of_the_limits_is_zero_before_urdf_1_2_and_unbounded_since() {
    let robot = read(&arm("<limit upper='1' effort='3'/>")).unwrap();
    assert_eq!(robot.joints[0].limits, Some((0.0, 1.0)));
    assert!(
        robot.warnings[0].contains("line 4") && robot.warnings[0].contains("no lower"),
        "{:?}",
        robot.warnings
    );
    assert!(
        read(&arm("<limit velocity='1'/>"))
            .unwrap()
            .warnings[0]
            .contains("cannot move")
    );
    let since = format!(
        "<robot name='r' version='1.2'>{}</robot>",
        arm("<limit upper='1'/>")
    );
    assert_eq!(
        parse(&since, &mut no_mesh).unwrap().joints[0].limits,
        Some((f64::NEG_INFINITY, 1.0))
    );
}

#[test]
fn mimics_follow_their_masters_through_chains() {
    let mimic = |of: &str, more: &str| format!("{LIMIT}<mimic joint='{of}' {more}/>");
    let body = links(&["a", "b", "c", "d"])
        + &joint("j", "revolute", "a", "b", LIMIT)
        + &joint(
            "k",
            "revolute",
            "b",
            "c",
            &mimic("j", "multiplier='2' offset='1'"),
        )
        + &joint("l", "revolute", "c", "d", &mimic("k", "multiplier='-3'"));
    let model = RobotModel::new(read(&body).unwrap()).unwrap();
    assert_eq!(model.variables().len(), 1);
    assert_eq!(
        model.joints()[2].drive,
        Drive::Mimic {
            master: 1,
            multiplier: 2.0,
            offset: 1.0
        }
    );
    assert_eq!(
        model.joints()[3].drive,
        Drive::Mimic {
            master: 1,
            multiplier: -6.0,
            offset: -3.0
        }
    );

    assert_refused(&arm(&mimic("nobody", "")), &["\"j\"", "nobody", "known: j"]);
    assert_refused(&arm(&mimic("j", "")), &["\"j\"", "itself"]);
    let ring = links(&["a", "b", "c"])
        + &joint("j", "revolute", "a", "b", &mimic("k", ""))
        + &joint("k", "revolute", "b", "c", &mimic("j", ""));
    assert_refused(&ring, &["itself"]);
    let tail = ring.replace("<link name='a'/>", "<link name='a'/><link name='d'/>")
        + &joint("l", "revolute", "c", "d", &mimic("j", ""));
    assert_refused(&tail, &["mimic"]);
}
