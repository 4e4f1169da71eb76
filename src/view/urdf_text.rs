//! A URDF of a robot as it was read, for the page's loader: the world and the joint that carries
//! the root are in it, a joint that is a column of its own copies none, and meshes are numbers of
//! the picture's.

use std::fmt::Write;

use taut::math::{Pose, Quat};
use taut::robot::urdf::Visual;
use taut::robot::{Drive, RobotModel};
use taut::shape::{Drawn, PlacedShape};

use super::shapes::Meshes;

/// Link that stands for the world; no link of a file has an empty name.
const WORLD: &str = "";
/// What a link looks like that has no visual of its own.
const PLAIN: [f64; 4] = [0.72, 0.74, 0.78, 1.0];

/// The text. A link without a visual shape shows its collision shapes.
pub(super) fn urdf_text(robot: &RobotModel, visuals: &[Visual], meshes: &mut Meshes) -> String {
    let mut text = format!(
        "<robot name=\"{}\"><link name=\"{WORLD}\"/>",
        escaped(robot.name())
    );
    for (link, joint) in robot.links().iter().zip(robot.joints()) {
        let _ = write!(text, "<link name=\"{}\">", escaped(&link.name));
        let mut own = visuals
            .iter()
            .filter(|visual| visual.link == link.name)
            .peekable();
        if own.peek().is_none() {
            link.shapes
                .iter()
                .for_each(|shape| visual(&mut text, shape, PLAIN, meshes));
        }
        own.for_each(|own| visual(&mut text, &own.shape, own.color.unwrap_or(PLAIN), meshes));
        for shape in &link.shapes {
            let _ = write!(text, "<collision>{}</collision>", geometry(shape, meshes));
        }
        let parent = joint
            .parent
            .map_or(WORLD, |parent| &robot.links()[parent].name);
        let _ = write!(
            text,
            "</link><joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}",
            escaped(&joint.name),
            joint.kind.name(),
            escaped(parent),
            escaped(&link.name),
            origin(&joint.origin)
        );
        let [x, y, z] = joint.axis.to_array();
        let _ = write!(text, "<axis xyz=\"{x} {y} {z}\"/>");
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
        text.push_str("</joint>");
    }
    text + "</robot>"
}

fn visual(text: &mut String, shape: &PlacedShape, [r, g, b, a]: [f64; 4], meshes: &mut Meshes) {
    let geometry = geometry(shape, meshes);
    let color = format!("<material name=\"\"><color rgba=\"{r} {g} {b} {a}\"/></material>");
    let _ = write!(text, "<visual>{geometry}{color}</visual>");
}

fn geometry(placed: &PlacedShape, meshes: &mut Meshes) -> String {
    let shape = match placed.shape.drawn() {
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
    };
    format!("{}<geometry>{shape}</geometry>", origin(&placed.pose))
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
        return [
            0.0,
            std::f64::consts::FRAC_PI_2.copysign(sine),
            -2.0 * q.x.atan2(q.w) * sine.signum(),
        ];
    }
    let roll = (2.0 * (q.w * q.x + q.y * q.z)).atan2(1.0 - 2.0 * (q.x * q.x + q.y * q.y));
    let yaw = (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z));
    [roll, sine.asin(), yaw]
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
