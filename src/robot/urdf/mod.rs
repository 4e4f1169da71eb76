//! URDF: the tree of links and joints, their limits and collision shapes.
//!
//! urdf-rs reads the elements. It hides or lets through much that a proof must know (a missing
//! limit is [0, 0], a broken number is dropped, a texture without a file fails the whole robot), so
//! `check` looks at the XML first and only what is used is handed on.

mod check;
#[cfg(test)]
mod tests;
mod visual;

use std::sync::Arc;

use roxmltree::{Document, Node};

pub use visual::{Visual, visuals};

use super::joint::JointKind;
use super::xml::{self, children, line};
use super::{JointDescription, LinkDescription, Mimic, RobotDescription, RobotError};
use crate::math::{Pose, Vec3, quat_from_rpy};
use crate::shape::{Mesh, MeshError, PlacedShape, Shape, ShapeError};
use crate::warning::Warning;

/// Gives the mesh of a file name (as written in the URDF) at a scale (negative factors mirror).
pub type MeshSource<'a> = dyn FnMut(&str, Vec3) -> Result<Arc<Mesh>, MeshError> + 'a;

/// Reads a URDF. Only collision geometry is resolved; visuals (see [`visuals`]), inertias and extensions are skipped.
///
/// Names, loops and numbers are checked once more by [`RobotModel::new`](super::RobotModel::new).
///
/// # Errors
/// A file that is no URDF, an element that cannot be read (with its line), a shape or mesh that is
/// none (with its link).
pub fn parse(text: &str, meshes: &mut MeshSource<'_>) -> Result<RobotDescription, RobotError> {
    let document = xml::document(text, "URDF")?;
    let root = document.root_element();
    let joint_nodes: Vec<Node> = children(root, "joint").collect();
    children(root, "link").try_for_each(check::link)?;
    joint_nodes.iter().copied().try_for_each(check::joint)?;
    let robot = urdf_rs::read_from_string(&essentials(&document))
        .map_err(|error| RobotError::Syntax(format!("not a URDF: {error}")))?;

    let mut warnings = Vec::new();
    let links: Vec<LinkDescription> = robot.links.iter().map(|l| link(l, meshes)).collect::<Result<_, _>>()?;
    mesh_warnings(&links, &mut warnings);
    let version = version(root);
    let joints = robot.joints.iter().zip(joint_nodes).map(|(j, node)| joint(j, node, version, &mut warnings)).collect();
    Ok(RobotDescription { name: robot.name, links, joints, warnings, ..RobotDescription::default() })
}

/// What is odd about the meshes, each mesh once.
fn mesh_warnings(links: &[LinkDescription], warnings: &mut Vec<Warning>) {
    for shape in links.iter().flat_map(|link| &link.collision) {
        let Shape::Mesh(mesh) = &shape.shape else { continue };
        for warning in mesh.warnings() {
            if !warnings.contains(warning) {
                warnings.push(warning.clone());
            }
        }
    }
}

/// The document without what is not used, so that nothing in it can fail the robot.
fn essentials(document: &Document) -> String {
    let text = document.input_text();
    let (mut kept, mut from) = (String::with_capacity(text.len()), 0);
    for cut in unused(document.root_element()) {
        kept.push_str(&text[from..cut.start]);
        from = cut.end;
    }
    kept.push_str(&text[from..]);
    kept
}

/// Byte ranges of the elements that are not read, in order.
fn unused(node: Node) -> Vec<std::ops::Range<usize>> {
    let used: &[&str] = match node.tag_name().name() {
        "robot" => &["link", "joint"],
        "link" => &["collision"],
        "collision" => &["origin", "geometry"],
        // Limits are read from the document itself: urdf-rs hides which are missing.
        "joint" => &["origin", "parent", "child", "axis", "mimic"],
        _ => return Vec::new(),
    };
    let elements = node.children().filter(Node::is_element);
    let cuts = |child: Node| match used.contains(&child.tag_name().name()) {
        true => unused(child),
        false => vec![child.range()],
    };
    elements.flat_map(cuts).collect()
}

/// `version` of `<robot>`; 1.0 where there is none or it cannot be read, as urdfdom does.
fn version(root: Node) -> (u32, u32) {
    let parsed = || {
        let (major, minor) = root.attribute("version")?.trim().split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    parsed().unwrap_or((1, 0))
}

fn link(link: &urdf_rs::Link, meshes: &mut MeshSource<'_>) -> Result<LinkDescription, RobotError> {
    let place = |(index, collision): (usize, &urdf_rs::Collision)| {
        let shape = shape(&collision.geometry, &link.name, index, meshes)?;
        let pose = pose(&collision.origin);
        if !pose.is_finite() {
            return Err(RobotError::BadValue {
                what: format!("link {:?}: the origin of collision {}", link.name, index + 1),
                value: format!("xyz {:?}, rpy {:?}", *collision.origin.xyz, *collision.origin.rpy),
                rule: "it must be finite",
            });
        }
        Ok(PlacedShape { pose, shape })
    };
    let collision = link.collision.iter().enumerate().map(place).collect::<Result<_, _>>()?;
    Ok(LinkDescription { name: link.name.clone(), collision })
}

fn shape(
    geometry: &urdf_rs::Geometry,
    link: &str,
    index: usize,
    meshes: &mut MeshSource<'_>,
) -> Result<Shape, RobotError> {
    use urdf_rs::Geometry;
    let bad_size = |error: ShapeError| RobotError::BadValue {
        what: format!("link {link:?}: the {} of {} (collision {})", error.size, error.shape, index + 1),
        value: error.value.to_string(),
        rule: "it must be finite and greater than 0",
    };
    match geometry {
        Geometry::Box { size } => Shape::cuboid(Vec3::from_array(**size)),
        Geometry::Cylinder { radius, length } => Shape::cylinder(*length, *radius),
        // `length` is the straight part, without the round ends.
        Geometry::Capsule { radius, length } => Shape::capsule(*length, *radius),
        Geometry::Sphere { radius } => Shape::sphere(*radius),
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or(Vec3::ONE, |scale| Vec3::from_array(*scale));
            let mesh = meshes(filename, scale).map_err(|source| RobotError::Mesh { link: link.to_owned(), source })?;
            Ok(Shape::Mesh(mesh))
        }
    }
    .map_err(bad_size)
}

fn joint(joint: &urdf_rs::Joint, node: Node, version: (u32, u32), warnings: &mut Vec<Warning>) -> JointDescription {
    let kind = match joint.joint_type {
        urdf_rs::JointType::Revolute => JointKind::Revolute,
        urdf_rs::JointType::Continuous => JointKind::Continuous,
        urdf_rs::JointType::Prismatic => JointKind::Prismatic,
        urdf_rs::JointType::Planar => JointKind::Planar,
        urdf_rs::JointType::Floating => JointKind::Floating,
        // `check` has refused spherical joints.
        urdf_rs::JointType::Fixed | urdf_rs::JointType::Spherical => JointKind::Fixed,
    };
    let axis = Vec3::from_array(*joint.axis.xyz);
    if kind == JointKind::Planar && children(node, "axis").next().is_some() && axis.cross(Vec3::Z) != Vec3::ZERO {
        let text = "moves in its x-y plane, as in MoveIt; the axis given is ignored";
        let text = format!("line {}: planar joint {:?} {text}", line(node), joint.name);
        warnings.push(Warning::cosmetic("planar axis", text));
    }
    JointDescription {
        name: joint.name.clone(),
        kind,
        parent: joint.parent.link.clone(),
        child: joint.child.link.clone(),
        origin: pose(&joint.origin),
        axis,
        limits: limits(kind, node, version, warnings),
        mimic: joint.mimic.as_ref().map(|mimic| Mimic {
            joint: mimic.joint.clone(),
            multiplier: mimic.multiplier.unwrap_or(1.0),
            offset: mimic.offset.unwrap_or(0.0),
        }),
    }
}

/// Limits of a bounded joint. A missing end is 0 before URDF 1.2, unbounded since; no `<limit>` is no limits.
fn limits(kind: JointKind, joint: Node, version: (u32, u32), warnings: &mut Vec<Warning>) -> Option<(f64, f64)> {
    if !matches!(kind, JointKind::Revolute | JointKind::Prismatic) {
        return None;
    }
    let limit = children(joint, "limit").next()?;
    let value = |name: &str| limit.attribute(name).and_then(|text| text.trim().parse::<f64>().ok());
    let (lower, upper) = (value("lower"), value("upper"));
    if version >= (1, 2) {
        return Some((lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)));
    }
    if lower.is_none() || upper.is_none() {
        let which = match (lower, upper) {
            (None, None) => "neither lower nor upper, so it cannot move: both are",
            (None, _) => "no lower, which is",
            _ => "no upper, which is",
        };
        let name = joint.attribute("name").unwrap_or_default();
        let text = format!("line {}: <limit> of joint {name:?} gives {which} 0 by default", line(limit));
        warnings.push(Warning::cosmetic("default limit", text));
    }
    Some((lower.unwrap_or(0.0), upper.unwrap_or(0.0)))
}

fn pose(origin: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = *origin.rpy;
    Pose::from_parts(Vec3::from_array(*origin.xyz), quat_from_rpy(roll, pitch, yaw))
}
