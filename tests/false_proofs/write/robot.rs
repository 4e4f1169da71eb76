//! URDF and SRDF.

use std::fmt::Write;

use super::words;
use crate::make::robot::{Made, Shape};
use crate::robot::{Joint, Kind, Origin, Turn};
use crate::shape::Geometry;

/// A robot's texts and meshes.
pub struct Written {
    pub urdf: String,
    pub srdf: Option<String>,
    /// Name and bytes.
    pub meshes: Vec<(String, Vec<u8>)>,
}

pub fn robot(made: &Made) -> Written {
    let mut meshes = Vec::new();
    let quaternions = |origin: &Origin| matches!(origin.turn, Turn::Quaternion(_));
    let has_quaternions = made
        .robot
        .joints
        .iter()
        .any(|joint| quaternions(&joint.origin))
        || made
            .shapes
            .iter()
            .flatten()
            .any(|shape| quaternions(&shape.origin));
    let version = if has_quaternions {
        " version=\"1.1\""
    } else {
        ""
    };
    let mut urdf = format!("<?xml version=\"1.0\"?>\n<robot name=\"random\"{version}>\n");
    for (link, shapes) in made.robot.links.iter().zip(&made.shapes) {
        let tag = if made.is_visual_only {
            "visual"
        } else {
            "collision"
        };
        let text: String = shapes
            .iter()
            .map(|shape| collision(shape, tag, &mut meshes))
            .collect();
        let _ = writeln!(urdf, "  <link name=\"{link}\">{text}</link>");
    }
    // The first joint is the SRDF's, or none.
    for (index, _) in made.robot.joints.iter().enumerate().skip(1) {
        urdf += &joint(made, index);
    }
    Written {
        urdf: urdf + "</robot>\n",
        srdf: srdf(made),
        meshes,
    }
}

fn origin(origin: &Origin) -> String {
    let turn = match &origin.turn {
        Turn::Rpy(rpy) => format!("rpy=\"{}\"", words(rpy)),
        Turn::Quaternion(q) => format!("quat_xyzw=\"{}\"", words(q)),
    };
    format!("<origin xyz=\"{}\" {turn}/>", words(&origin.at))
}

fn collision(shape: &Shape, tag: &str, meshes: &mut Vec<(String, Vec<u8>)>) -> String {
    let geometry = match &shape.geometry {
        Geometry::Box(size) => format!("<box size=\"{}\"/>", words(size)),
        Geometry::Sphere { radius } => format!("<sphere radius=\"{radius}\"/>"),
        Geometry::Cylinder { length, radius } => {
            format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
        }
        Geometry::Capsule { length, radius } => {
            format!("<capsule radius=\"{radius}\" length=\"{length}\"/>")
        }
        Geometry::Mesh(mesh) => {
            let name = format!("link{}.{}", meshes.len(), mesh.format.ending());
            meshes.push((name.clone(), super::mesh::bytes(mesh)));
            format!(
                "<mesh filename=\"{name}\" scale=\"{}\"/>",
                words(&mesh.scale)
            )
        }
    };
    format!(
        "<{tag}>{}<geometry>{geometry}</geometry></{tag}>",
        origin(&shape.origin)
    )
}

fn joint(made: &Made, index: usize) -> String {
    let Joint {
        name,
        kind,
        parent,
        axis,
        limits,
        soft_limits,
        mimic,
        ..
    } = &made.robot.joints[index];
    let links = &made.robot.links;
    let parent = &links[parent.expect("only the first joint hangs on the world")];
    let mut inner = format!(
        "<parent link=\"{parent}\"/><child link=\"{}\"/>",
        links[index]
    );
    inner += &origin(&made.robot.joints[index].origin);
    if matches!(kind, Kind::Revolute | Kind::Continuous | Kind::Prismatic) {
        inner += &format!("<axis xyz=\"{}\"/>", words(axis));
    }
    if let Some((lower, upper)) = limits {
        inner +=
            &format!("<limit lower=\"{lower}\" upper=\"{upper}\" effort=\"1\" velocity=\"1\"/>");
    }
    if let Some((lower, upper)) = soft_limits {
        let attributes = format!("soft_lower_limit=\"{lower}\" soft_upper_limit=\"{upper}\"");
        inner += &format!("<safety_controller {attributes} k_position=\"1\" k_velocity=\"1\"/>");
    }
    if let Some(mimic) = mimic {
        let leader = &made.robot.joints[mimic.leader].name;
        let multiplier = mimic.multiplier;
        let offset = mimic.offset;
        inner +=
            &format!("<mimic joint=\"{leader}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>");
    }
    format!(
        "  <joint name=\"{name}\" type=\"{}\">{inner}</joint>\n",
        kind.word()
    )
}

fn srdf(made: &Made) -> Option<String> {
    let robot = &made.robot;
    let pairs = made.robot.disabled.as_ref()?;
    let mut text = "<robot name=\"random\">\n".to_owned();
    let root = &robot.joints[0];
    if root.kind != Kind::Fixed {
        let name = &root.name;
        let kind = root.kind.word();
        let frame = made.world_frame;
        let child = &robot.links[0];
        let attributes = format!(
            "name=\"{name}\" type=\"{kind}\" parent_frame=\"{frame}\" child_link=\"{child}\""
        );
        let _ = writeln!(text, "  <virtual_joint {attributes}/>");
    }
    for (a, b) in pairs {
        let a = &robot.links[*a];
        let b = &robot.links[*b];
        let _ = writeln!(text, "  {}", disabling(a, b));
    }
    Some(text + "</robot>\n")
}

/// The line of an SRDF that leaves out a pair.
pub fn disabling(a: &str, b: &str) -> String {
    format!("<disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"Adjacent\"/>")
}
