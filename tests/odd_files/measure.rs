//! What this project reads in a file, in the words of the table.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Map, Value, json};
use taut::collision::check_frames;
use taut::files::{Packages, Reader};
use taut::math::{Pose, Vec3};
use taut::robot::joint::{Drive, Joint, JointKind};
use taut::robot::kinematics::Kinematics;
use taut::robot::{RobotDescription, RobotModel};
use taut::scene::{Obstacle, Scene};
use taut::shape::{Mesh, PlacedShape, Shape};

/// What is read in a file, by aspect; or the line that refuses it.
pub fn read(file: &Path, kind: &str) -> Result<Value, String> {
    let mut reader = Reader::default();
    match kind {
        "stl" | "obj" | "dae" => surface(&mut reader, file),
        "urdf" => robot(&mut reader, file),
        "srdf" => semantics(&mut reader, file),
        _ => scene(&mut reader, file),
    }
}

/// What is read in a robot whose packages the environment names.
pub fn packaged_robot(file: &Path) -> Result<Value, String> {
    robot(
        &mut Reader::new(Packages::with_environment(Default::default())),
        file,
    )
}

/// A mesh, as a robot's only link has it.
fn surface(reader: &mut Reader, file: &Path) -> Result<Value, String> {
    let name = file
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default();
    let wrapped = file.with_file_name(format!("{name}.urdf"));
    let text = format!(
        "<robot name='r'><link name='a'><collision><geometry><mesh filename='{name}'/></geometry></collision></link></robot>"
    );
    std::fs::write(&wrapped, text).map_err(|error| error.to_string())?;
    let robot = reader
        .robot(&wrapped, None)
        .map_err(|error| error.to_string())?;
    let [
        PlacedShape {
            shape: Shape::Mesh(mesh),
            ..
        },
    ] = robot.links[0].collision.as_slice()
    else {
        return Err("the link has no mesh".to_owned());
    };
    Ok(json!({ "surface": surface_of(mesh) }))
}

fn surface_of(mesh: &Mesh) -> Value {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices()[i as usize]);
    // A triangle that comes twice in the same order is there once.
    let from_least = |&[a, b, c]: &[u32; 3]| {
        [[a, b, c], [b, c, a], [c, a, b]]
            .into_iter()
            .min()
            .unwrap_or_default()
    };
    let triangles: BTreeSet<[u32; 3]> = mesh
        .triangles()
        .iter()
        .map(from_least)
        .collect();
    let used: Vec<Vec3> = triangles.iter().flat_map(corners).collect();
    let lo = used
        .iter()
        .copied()
        .reduce(Vec3::min)
        .unwrap_or_default();
    let hi = used
        .iter()
        .copied()
        .reduce(Vec3::max)
        .unwrap_or_default();
    let mut area = 0.0;
    let mut volume = 0.0;
    let mut centre = Vec3::ZERO;
    for [a, b, c] in triangles.iter().map(corners) {
        let of_one = (b - a).cross(c - a).length() / 2.0;
        area += of_one;
        centre += (a + b + c - 3.0 * lo) / 3.0 * of_one;
        volume += (a - lo).dot((b - lo).cross(c - lo)) / 6.0;
    }
    json!({ "lo": lo.to_array(), "hi": hi.to_array(), "area": area, "volume": volume,
        "centre": (centre / area + lo).to_array() })
}

fn robot(reader: &mut Reader, file: &Path) -> Result<Value, String> {
    let description = reader
        .robot(file, None)
        .map_err(|error| error.to_string())?;
    let shapes: Map<String, Value> = description
        .links
        .iter()
        .map(|link| {
            (
                link.name.clone(),
                link.collision.iter().map(placed).collect(),
            )
        })
        .filter(|(_, shapes): &(String, Value)| shapes != &json!([]))
        .collect();
    let model =
        RobotModel::new(description).map_err(|error| format!("{}: {error}", file.display()))?;
    let limits: Map<String, Value> = model
        .joints()
        .iter()
        .filter(|joint| joint.kind.nq() == 1)
        .filter_map(|joint| {
            model
                .variables()
                .iter()
                .find(|variable| variable.name == joint.name)
        })
        .map(|variable| {
            let end = |end: f64| {
                if end.is_finite() {
                    json!(end)
                } else {
                    Value::Null
                }
            };
            (
                variable.name.clone(),
                json!([end(variable.lower), end(variable.upper)]),
            )
        })
        .collect();
    Ok(json!({ "shapes": shapes, "limits": limits, "poses": poses(&model) }))
}

/// Where the links are when the joints, in the order of their names, stand at 0.1, 0.2 …
fn poses(model: &RobotModel) -> Value {
    let moves = |joint: &&Joint| matches!(joint.drive, Drive::Variable { .. });
    let mut moving: Vec<&Joint> = model.joints().iter().filter(moves).collect();
    moving.sort_by(|a, b| a.name.cmp(&b.name));
    let mut q = vec![0.0; model.space().nq()];
    for (index, joint) in moving.iter().enumerate() {
        let Drive::Variable { q: first, .. } = joint.drive else {
            continue;
        };
        let values: &[f64] = match joint.kind {
            JointKind::Planar => &[0.1, 0.2, 0.3],
            JointKind::Floating => &[0.1, 0.2, 0.3, 0.0, 0.0, 0.6, 0.8],
            _ => &[0.1 * (index + 1) as f64],
        };
        q[first..first + values.len()].copy_from_slice(values);
    }
    let mut kinematics = Kinematics::default();
    kinematics.update(model, &q, &[]);
    let named = model.links().iter().zip(kinematics.poses());
    let of_root = kinematics.poses()[0].inverse();
    named
        .map(|(link, pose)| (link.name.clone(), pose_of(&(of_root * *pose))))
        .collect::<Map<_, _>>()
        .into()
}

fn semantics(reader: &mut Reader, file: &Path) -> Result<Value, String> {
    let urdf = file.with_file_name("robot.urdf");
    let RobotDescription {
        semantics, links, ..
    } = reader
        .robot(&urdf, Some(file))
        .map_err(|error| error.to_string())?;
    let semantics = semantics.unwrap_or_default();
    let sorted = |a: &str, b: &str| if a < b { json!([a, b]) } else { json!([b, a]) };
    let mut pairs: Vec<Value> = semantics
        .disabled_collisions
        .iter()
        // Links that the robot does not have cannot touch.
        .filter(|(a, b)| {
            [a, b]
                .iter()
                .all(|name| links.iter().any(|link| link.name == **name))
        })
        .map(|(a, b)| sorted(a, b))
        .collect();
    pairs.sort_by_key(Value::to_string);
    let groups = semantics.groups.iter().map(|group| {
        let mut joints = group.joints.clone();
        joints.sort();
        (group.name.clone(), json!(joints))
    });
    let groups: Map<String, Value> = groups
        .filter(|(_, joints)| joints != &json!([]))
        .collect();
    let states = semantics.group_states.iter().map(|state| {
        let values: Map<String, Value> = state
            .values
            .iter()
            .map(|(joint, values)| (joint.clone(), json!(values[0])))
            .collect();
        (state.name.clone(), Value::Object(values))
    });
    Ok(json!({ "pairs": pairs, "groups": groups, "states": states.collect::<Map<_, _>>() }))
}

/// A scene, and whether its frames are those of a robot.
fn scene(reader: &mut Reader, file: &Path) -> Result<Value, String> {
    let robot = reader
        .robot(&file.with_file_name("robot.urdf"), None)
        .map_err(|error| error.to_string())?;
    let robot = RobotModel::new(robot).map_err(|error| error.to_string())?;
    let scene = reader
        .scene(file)
        .map_err(|error| error.to_string())?;
    check_frames(&robot, &scene).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(world(&scene))
}

fn world(scene: &Scene) -> Value {
    let of = |object: &Obstacle| {
        object
            .placed_shapes()
            .map(|shape| placed(&shape))
            .collect::<Value>()
    };
    let objects: Map<String, Value> = scene
        .obstacles()
        .iter()
        .map(|object| (object.id.clone(), of(object)))
        .collect();
    let attached: Map<String, Value> = scene
        .attached()
        .iter()
        .map(|held| {
            let mut touch = held.touch_links.clone();
            touch.sort();
            (
                held.object.id.clone(),
                json!({ "link": held.link_name, "touch": touch, "shapes": of(&held.object) }),
            )
        })
        .collect();
    let mut allowed: Vec<[&str; 2]> = scene
        .allowed()
        .map(|(a, b)| [a.min(b), a.max(b)])
        .collect();
    allowed.sort_unstable();
    let numbers = |numbers: &mut dyn Iterator<Item = (&str, f64)>| {
        numbers
            .map(|(name, number)| (name.to_owned(), json!(number)))
            .collect::<Map<_, _>>()
    };
    json!({ "objects": objects, "attached": attached, "allowed": allowed,
        "padding": numbers(&mut scene.padded()), "scale": numbers(&mut scene.scaled()) })
}

fn placed(shape: &PlacedShape) -> Value {
    let (kind, sizes) = match &shape.shape {
        Shape::Box { half_extents } => ("box", (*half_extents * 2.0).to_array().to_vec()),
        Shape::Sphere { radius } => ("sphere", vec![*radius]),
        Shape::Cylinder {
            radius,
            half_height,
        } => ("cylinder", vec![*radius, half_height * 2.0]),
        Shape::Capsule {
            radius,
            half_length,
        } => ("capsule", vec![*radius, half_length * 2.0]),
        Shape::Mesh(mesh) => {
            let surface = surface_of(mesh);
            let mut sizes: Vec<f64> = ["lo", "hi"]
                .iter()
                .flat_map(|end| {
                    surface[end]
                        .as_array()
                        .into_iter()
                        .flatten()
                        .filter_map(Value::as_f64)
                })
                .collect();
            sizes.push(1e6 * surface["volume"].as_f64().unwrap_or_default());
            ("mesh", sizes)
        }
        Shape::Cloud(cloud) => ("cloud", vec![cloud.len() as f64, cloud.radius()]),
    };
    json!([kind, sizes, pose_of(&shape.pose)])
}

/// Position, then the quaternion x y z w of which w, or the first that is not 0, is positive.
fn pose_of(pose: &Pose) -> Value {
    let [x, y, z, w] = pose.rotation.to_array();
    let first = [w, x, y, z]
        .into_iter()
        .find(|c| c.abs() > 1e-9)
        .unwrap_or(1.0);
    let turned = [x, y, z, w].map(|c| c * first.signum());
    let all: Vec<f64> = pose
        .translation
        .to_array()
        .into_iter()
        .chain(turned)
        .collect();
    json!(all)
}
