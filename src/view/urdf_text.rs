//! A URDF of a robot as it was read, for the page's loader: the world and the joint that carries
//! the root are in it, a joint that is a column of its own copies none, and meshes are numbers of
//! the picture's.

use std::fmt::Write;

use taut::math::{Pose, Quat};
use taut::robot::urdf::Visual;
use taut::robot::{Drive, Joint, Link, RobotModel};
use taut::shape::{Drawn, PlacedShape};

use super::shapes::Meshes;

/// Link that stands for the world; no link of a file has an empty name.
const WORLD: &str = "";
/// What a link looks like that has no visual of its own.
const PLAIN: [f64; 4] = [0.72, 0.74, 0.78, 1.0];

/// The text. A link without a visual shape shows its collision shapes.
pub(super) fn urdf_text(robot: &RobotModel, visuals: &[Visual], meshes: &mut Meshes) -> String {
    let name = escaped(robot.name());
    let mut text = format!("<robot name=\"{name}\"><link name=\"{WORLD}\"/>");
    for (link, joint) in robot.links().iter().zip(robot.joints()) {
        write_link(&mut text, link, visuals, meshes);
        write_joint(&mut text, robot, joint, &link.name);
    }
    text + "</robot>"
}

fn write_link(text: &mut String, link: &Link, visuals: &[Visual], meshes: &mut Meshes) {
    let _ = write!(text, "<link name=\"{}\">", escaped(&link.name));
    let own = visuals
        .iter()
        .filter(|visual| visual.link == link.name);
    let own: Vec<&Visual> = own.collect();
    if own.is_empty() {
        let shapes = link.shapes.iter();
        shapes.for_each(|shape| visual(text, shape, PLAIN, meshes));
    }
    for own in own {
        visual(text, &own.shape, own.color.unwrap_or(PLAIN), meshes);
    }
    for shape in &link.shapes {
        let _ = write!(text, "<collision>{}</collision>", geometry(shape, meshes));
    }
    text.push_str("</link>");
}

/// The joint that carries this link.
fn write_joint(text: &mut String, robot: &RobotModel, joint: &Joint, child: &str) {
    let parent = joint
        .parent
        .map_or(WORLD, |parent| &robot.links()[parent].name);
    let [x, y, z] = joint.axis.to_array();
    let _ = write!(
        text,
        "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}<axis xyz=\"{x} {y} {z}\"/>",
        escaped(&joint.name),
        joint.kind.name(),
        escaped(parent),
        escaped(child),
        origin(&joint.origin)
    );
    write_mimic(text, robot, joint);
    text.push_str("</joint>");
}

/// What a joint copies, if it does.
fn write_mimic(text: &mut String, robot: &RobotModel, joint: &Joint) {
    if let Drive::Mimic {
        master,
        multiplier,
        offset,
    } = joint.drive
    {
        let master = escaped(&robot.joints()[master].name);
        let _ = write!(
            text,
            "<mimic joint=\"{master}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>"
        );
    }
}

fn visual(text: &mut String, shape: &PlacedShape, [r, g, b, a]: [f64; 4], meshes: &mut Meshes) {
    let geometry = geometry(shape, meshes);
    let color = format!("<material name=\"\"><color rgba=\"{r} {g} {b} {a}\"/></material>");
    let _ = write!(text, "<visual>{geometry}{color}</visual>");
}

fn geometry(placed: &PlacedShape, meshes: &mut Meshes) -> String {
    let origin = origin(&placed.pose);
    let shape = shape(placed, meshes);
    format!("{origin}<geometry>{shape}</geometry>")
}

fn shape(placed: &PlacedShape, meshes: &mut Meshes) -> String {
    match placed.shape.drawn() {
        Drawn::Box { size } => {
            let [x, y, z] = size.to_array();
            format!("<box size=\"{x} {y} {z}\"/>")
        }
        Drawn::Sphere { radius } => format!("<sphere radius=\"{radius}\"/>"),
        Drawn::Cylinder { radius, length } => {
            format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
        }
        // The loader knows no capsules: the page makes this one.
        Drawn::Capsule { radius, length } => {
            format!("<mesh filename=\"capsule:{radius}:{length}\"/>")
        }
        Drawn::Mesh(mesh) => format!("<mesh filename=\"mesh:{}\"/>", meshes.number(&mesh)),
    }
}

fn origin(pose: &Pose) -> String {
    let [x, y, z] = pose.translation.to_array();
    let [roll, pitch, yaw] = rpy(pose.rotation);
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
}

/// Roll, pitch and yaw of a unit quaternion; where roll and yaw turn about the same axis, yaw has
/// it all.
fn rpy(q: Quat) -> [f64; 3] {
    let sine = 2.0 * (q.w * q.y - q.z * q.x);
    if sine.abs() > 1.0 - 1e-12 {
        return locked(q, sine);
    }
    [roll(q), sine.asin(), yaw(q)]
}

fn locked(q: Quat, sine: f64) -> [f64; 3] {
    let yaw = -2.0 * q.x.atan2(q.w) * sine.signum();
    [0.0, std::f64::consts::FRAC_PI_2.copysign(sine), yaw]
}

fn roll(q: Quat) -> f64 {
    (2.0 * (q.w * q.x + q.y * q.z)).atan2(1.0 - 2.0 * (q.x * q.x + q.y * q.y))
}

fn yaw(q: Quat) -> f64 {
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut::math::quat_from_rpy;

    #[test]
    fn angles_give_their_rotation_back_also_where_they_lock() {
        let right = std::f64::consts::FRAC_PI_2;
        for [roll, pitch, yaw] in [
            [0.3, -0.4, 2.9],
            [0.7, right, -0.2],
            [-1.0, -right, 0.5],
            [0.1, right - 1e-5, 3.0],
            [right, 0.0, -right],
        ] {
            let q = quat_from_rpy(roll, pitch, yaw);
            let [r, p, y] = rpy(q);
            let back = quat_from_rpy(r, p, y);
            assert!(
                q.dot(back).abs() > 1.0 - 1e-11,
                "{roll} {pitch} {yaw}: {q} is not {back}"
            );
        }
    }
}
