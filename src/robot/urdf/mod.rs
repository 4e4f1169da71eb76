//! URDF: the tree of links and joints, their limits and collision shapes.
//!
//! urdf-rs reads the elements. It hides or lets through much that a proof must know (a missing
//! limit is [0, 0], a broken number is dropped, a texture without a file fails the whole robot, a
//! quaternion near the vertical is turned by milliradians), so `check` looks at the XML first,
//! limits and quaternions are read from the XML, urdf-rs gets only what is used (`essentials`), and
//! what is not used is named (`unread`).

mod check;
mod essentials;
#[cfg(test)]
mod oddities_tests;
mod shape;
#[cfg(test)]
mod tests;
mod unread;
mod visual;

use std::sync::Arc;

use roxmltree::Node;

pub use visual::{Visual, visuals};

use super::joint::JointKind;
use super::xml::{self, children, line};
use super::{JointDescription, LinkDescription, Mimic, Motor, RobotDescription, RobotError};
use crate::math::{Pose, Quat, Vec3, quat_from_rpy};
use crate::shape::{Mesh, MeshError, PlacedShape};
use crate::warning::Warning;

/// The version of URDF that brought `quat_xyzw`, and the one that brought `<capsule>` and limits
/// without ends.
const QUATERNIONS: (u32, u32) = (1, 1);
const CAPSULES: (u32, u32) = (1, 2);

/// Gives the mesh of a file name (as written in the URDF) at a scale (negative factors mirror).
pub type MeshSource<'a> = dyn FnMut(&str, Vec3) -> Result<Arc<Mesh>, MeshError> + 'a;

/// Reads a URDF. Only collision geometry is resolved; visuals (see [`visuals`]), inertias and
/// extensions are skipped.
///
/// Names, loops and numbers are checked once more by [`RobotModel::new`](super::RobotModel::new).
///
/// # Errors
/// A file that is no URDF, an element that cannot be read (with its line), a shape or mesh that is
/// none (with its link).
pub fn parse(text: &str, meshes: &mut MeshSource<'_>) -> Result<RobotDescription, RobotError> {
    let (text, odd) = xml::tidy(text);
    let document = xml::document(&text, "URDF")?;
    let root = document.root_element();
    let version = version(root);
    children(root, "link").try_for_each(|node| check::link(node, version))?;
    children(root, "joint").try_for_each(|node| check::joint(node, version))?;
    let odd = odd
        .into_iter()
        .map(|text| Warning::cosmetic("text", text));
    let reading = Reading {
        meshes,
        version,
        warnings: odd.chain(unread::warnings(root)?).collect(),
    };
    let robot = urdf_rs::read_from_string(&essentials::of_robot(root))
        .map_err(|error| RobotError::Syntax(format!("not a URDF: {error}")))?;
    reading.robot(robot, root)
}

/// What is odd about the meshes, each mesh once.
fn mesh_warnings(links: &[LinkDescription], warnings: &mut Vec<Warning>) {
    let shapes = links.iter().flat_map(|link| &link.collision);
    let meshes = shapes.filter_map(|placed| placed.shape.mesh());
    meshes
        .flat_map(|mesh| mesh.warnings())
        .for_each(|warning| push_once(warnings, warning));
}

fn push_once(warnings: &mut Vec<Warning>, warning: &Warning) {
    if !warnings.contains(warning) {
        warnings.push(warning.clone());
    }
}

/// `version` of `<robot>`; 1.0 where there is none or it cannot be read, as urdfdom does.
fn version(root: Node) -> (u32, u32) {
    let parsed = || {
        let (major, minor) = root
            .attribute("version")?
            .trim()
            .split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    parsed().unwrap_or((1, 0))
}

/// What is said of each joint's motor. A velocity or effort of 0 or below is what exporters write where they
/// know none: nothing is said then.
fn motors(joints: &[JointDescription], root: Node) -> Vec<Motor> {
    let nodes = joints.iter().zip(children(root, "joint"));
    let motor = |(joint, node): (&JointDescription, Node)| {
        let limit = children(node, "limit").next()?;
        let known = |name: &str| number(limit, name).filter(|size| *size > 0.0 && size.is_finite());
        let motor = Motor {
            joint: joint.name.clone(),
            velocity: known("velocity"),
            effort: known("effort"),
        };
        (motor.velocity.is_some() || motor.effort.is_some()).then_some(motor)
    };
    nodes.filter_map(motor).collect()
}

/// A file that is being read, and what was found odd so far.
struct Reading<'a, 'm> {
    meshes: &'a mut MeshSource<'m>,
    version: (u32, u32),
    warnings: Vec<Warning>,
}

impl Reading<'_, '_> {
    fn link(&mut self, link: &urdf_rs::Link, node: Node) -> Result<LinkDescription, RobotError> {
        let mut collision = Vec::new();
        for (shape, node) in link
            .collision
            .iter()
            .zip(children(node, "collision"))
        {
            let of = format!("link {:?}", link.name);
            let pose = self.pose(&shape.origin, node, &of)?;
            let placed = self.shape(&shape.geometry, node, &link.name)?;
            collision.extend(placed.map(|shape| PlacedShape { pose, shape }));
        }
        Ok(LinkDescription {
            name: link.name.clone(),
            collision,
        })
    }

    fn robot(mut self, robot: urdf_rs::Robot, root: Node) -> Result<RobotDescription, RobotError> {
        let links = self.links(&robot, root)?;
        let joints = self.joints(&robot, root)?;
        mesh_warnings(&links, &mut self.warnings);
        Ok(RobotDescription {
            name: robot.name,
            motors: motors(&joints, root),
            links,
            joints,
            warnings: self.warnings,
            ..RobotDescription::default()
        })
    }

    fn links(
        &mut self,
        robot: &urdf_rs::Robot,
        root: Node,
    ) -> Result<Vec<LinkDescription>, RobotError> {
        let links = robot.links.iter().zip(children(root, "link"));
        links
            .map(|(link, node)| self.link(link, node))
            .collect()
    }

    fn joints(
        &mut self,
        robot: &urdf_rs::Robot,
        root: Node,
    ) -> Result<Vec<JointDescription>, RobotError> {
        let joints = robot.joints.iter().zip(children(root, "joint"));
        joints
            .map(|(joint, node)| self.joint(joint, node))
            .collect()
    }

    fn joint(
        &mut self,
        joint: &urdf_rs::Joint,
        node: Node,
    ) -> Result<JointDescription, RobotError> {
        let kind = kind_of(&joint.joint_type);
        let axis = Vec3::from_array(*joint.axis.xyz);
        if kind == JointKind::Planar && axis.cross(Vec3::Z) != Vec3::ZERO {
            self.warn_of_planar_axis(&joint.name, node);
        }
        let limits = self.limits(kind, node);
        Ok(JointDescription {
            name: joint.name.clone(),
            kind,
            parent: joint.parent.link.clone(),
            child: joint.child.link.clone(),
            origin: self.pose(&joint.origin, node, &format!("joint {:?}", joint.name))?,
            axis,
            limits,
            soft_limits: limits.and_then(|limits| self.soft_limits(limits, node)),
            mimic: joint.mimic.as_ref().map(mimic_of),
        })
    }

    fn warn_of_planar_axis(&mut self, name: &str, node: Node) {
        let given = match children(node, "axis").next() {
            Some(_) => "the axis given is ignored",
            None => "it gives no axis, which URDF takes for x",
        };
        let text = format!("moves in its x-y plane, as in MoveIt; {given}");
        let text = format!("line {}: planar joint {name:?} {text}", line(node));
        self.warnings
            .push(Warning::cosmetic("planar axis", text));
    }

    /// Limits of a bounded joint. A missing end is 0 before URDF 1.2, unbounded since; no `<limit>`
    /// is no limits.
    fn limits(&mut self, kind: JointKind, joint: Node) -> Option<(f64, f64)> {
        if !matches!(kind, JointKind::Revolute | JointKind::Prismatic) {
            return None;
        }
        let limit = children(joint, "limit").next()?;
        let lower = number(limit, "lower");
        let upper = number(limit, "upper");
        if self.version >= (1, 2) {
            let open = f64::INFINITY;
            return Some((lower.unwrap_or(-open), upper.unwrap_or(open)));
        }
        self.warn_of_missing_ends(lower, upper, joint, limit);
        Some((lower.unwrap_or(0.0), upper.unwrap_or(0.0)))
    }

    fn warn_of_missing_ends(
        &mut self,
        lower: Option<f64>,
        upper: Option<f64>,
        joint: Node,
        limit: Node,
    ) {
        let which = match (lower, upper) {
            (Some(_), Some(_)) => return,
            (None, None) => "neither lower nor upper, so it cannot move: both are",
            (None, Some(_)) => "no lower, which is",
            (Some(_), None) => "no upper, which is",
        };
        let name = joint.attribute("name").unwrap_or_default();
        let text = format!("<limit> of joint {name:?} gives {which} 0 by default");
        let text = format!("line {}: {text}", line(limit));
        self.warnings
            .push(Warning::cosmetic("default limit", text));
    }

    /// The soft limits of a bounded joint, whatever its gains are, and 0 where one is missing: as
    /// MoveIt's robot model has them.
    fn soft_limits(&mut self, limits: (f64, f64), joint: Node) -> Option<(f64, f64)> {
        let safety = children(joint, "safety_controller").next()?;
        let lower = number(safety, "soft_lower_limit");
        let upper = number(safety, "soft_upper_limit");
        let soft = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
        let joint = joint.attribute("name").unwrap_or_default();
        let name = || {
            format!(
                "line {}: <safety_controller> of joint {joint:?}",
                line(safety)
            )
        };
        let leaves_some = soft.0.max(limits.0) <= soft.1.min(limits.1);
        if !leaves_some {
            let text = format!(
                "leave nothing of its limits [{}, {}]; they are ignored",
                limits.0, limits.1
            );
            let text = format!(
                "{} has soft limits [{}, {}] that {text}",
                name(),
                soft.0,
                soft.1
            );
            self.warnings.push(Warning::uncovered(text));
            return None;
        }
        let missing = match (lower, upper) {
            (Some(_), Some(_)) => return Some(soft),
            (None, None) => "neither soft_lower_limit nor soft_upper_limit",
            (None, Some(_)) => "no soft_lower_limit",
            (Some(_), None) => "no soft_upper_limit",
        };
        let text = "0 by default, as in MoveIt, and bounds the joint";
        self.warnings.push(Warning::cosmetic(
            "default limit",
            format!("{} gives {missing}, which is {text}", name()),
        ));
        Some(soft)
    }

    /// The pose that the `<origin>` in `node` gives.
    fn pose(&mut self, origin: &urdf_rs::Pose, node: Node, of: &str) -> Result<Pose, RobotError> {
        let [roll, pitch, yaw] = *origin.rpy;
        let node = children(node, "origin").next();
        let turn = match node.filter(|node| node.has_attribute("quat_xyzw")) {
            Some(node) => self.quaternion(node, of)?,
            None => None,
        };
        let turn = turn.unwrap_or_else(|| quat_from_rpy(roll, pitch, yaw));
        let pose = Pose::from_parts(Vec3::from_array(*origin.xyz), turn);
        if pose.is_finite() {
            return Ok(pose);
        }
        let attribute =
            |name: &str| node.and_then(|node| Some(format!("{name} {:?}", node.attribute(name)?)));
        Err(RobotError::BadValue {
            what: format!("{of}: the <origin> in line {}", node.map_or(0, line)),
            value: ["xyz", "rpy", "quat_xyzw"]
                .into_iter()
                .filter_map(attribute)
                .collect::<Vec<_>>()
                .join(", "),
            rule: "it must be finite",
        })
    }

    /// The rotation of an `<origin>` as its quaternion says; `None` before URDF 1.1, which has
    /// none.
    fn quaternion(&mut self, origin: Node, of: &str) -> Result<Option<Quat>, RobotError> {
        let place = || format!("line {}: {of}: quat_xyzw", line(origin));
        if self.version < QUATERNIONS {
            let (major, minor) = self.version;
            let text = format!(
                "is of URDF 1.1 and this file of {major}.{minor}; it is ignored, as by urdfdom"
            );
            self.warnings
                .push(Warning::uncovered(format!("{} {text}", place())));
            return Ok(None);
        }
        let Some(numbers) = xml::numbers(origin, "quat_xyzw", of)? else {
            return Ok(None);
        };
        let &[x, y, z, w] = numbers.as_slice() else {
            return Ok(None);
        };
        if [x, y, z, w] == [0.0; 4] {
            let text = format!(
                "{} is 0 0 0 0, which is no rotation; it is taken for none",
                place()
            );
            self.warnings.push(Warning::uncovered(text));
            return Ok(Some(Quat::IDENTITY));
        }
        Ok(Some(Quat::from_xyzw(x, y, z, w).normalize()))
    }
}

/// A number that `check` has looked at.
fn number(node: Node, name: &str) -> Option<f64> {
    node.attribute(name)
        .and_then(|text| text.trim().parse().ok())
}

fn kind_of(joint_type: &urdf_rs::JointType) -> JointKind {
    match joint_type {
        urdf_rs::JointType::Revolute => JointKind::Revolute,
        urdf_rs::JointType::Continuous => JointKind::Continuous,
        urdf_rs::JointType::Prismatic => JointKind::Prismatic,
        urdf_rs::JointType::Planar => JointKind::Planar,
        urdf_rs::JointType::Floating => JointKind::Floating,
        // `check` has refused spherical joints.
        urdf_rs::JointType::Fixed | urdf_rs::JointType::Spherical => JointKind::Fixed,
    }
}

fn mimic_of(mimic: &urdf_rs::Mimic) -> Mimic {
    Mimic {
        joint: mimic.joint.clone(),
        multiplier: mimic.multiplier.unwrap_or(1.0),
        offset: mimic.offset.unwrap_or(0.0),
    }
}
