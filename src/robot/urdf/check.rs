//! What urdf-rs lets through or reports without a name or a line is refused here, before it reads.

use roxmltree::Node;

use super::super::xml::{children, numbers, required, syntax, tag};
use super::RobotError;

/// Joint types of URDF that a robot here can have.
const JOINT_TYPES: &str = "fixed, revolute, continuous, prismatic, planar, floating";
/// Shapes of a collision geometry.
const SHAPES: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];
/// Numbers by element and attribute: how many, and whether they must be there.
const NUMBERS: [(&str, &str, usize, bool); 13] = [
    ("origin", "xyz", 3, false),
    ("origin", "rpy", 3, false),
    ("axis", "xyz", 3, true),
    ("limit", "lower", 1, false),
    ("limit", "upper", 1, false),
    ("mimic", "multiplier", 1, false),
    ("mimic", "offset", 1, false),
    ("box", "size", 3, true),
    ("cylinder", "radius", 1, true),
    ("cylinder", "length", 1, true),
    ("capsule", "radius", 1, true),
    ("capsule", "length", 1, true),
    ("sphere", "radius", 1, true),
];

/// Refuses a link whose name or collision geometry cannot be read.
pub(super) fn link(node: Node) -> Result<(), RobotError> {
    let name = format!("link {:?}", required(node, "name")?);
    for collision in children(node, "collision") {
        single(collision, "origin", &name, false)?;
        single(collision, "geometry", &name, true)?;
        for child in collision.children().filter(Node::is_element) {
            all_numbers(child, &name)?;
        }
        geometry(children(collision, "geometry").next().unwrap_or(collision), &name)?;
    }
    Ok(())
}

/// Refuses a joint whose name, type, ends or numbers cannot be read.
pub(super) fn joint(node: Node) -> Result<(), RobotError> {
    let name = format!("joint {:?}", required(node, "name")?);
    let kind = required(node, "type")?;
    if kind == "spherical" {
        let advice = "spherical joints are not supported; use three revolute joints, or floating";
        return Err(syntax(node, format!("{name}: {advice}")));
    }
    if !JOINT_TYPES.split(", ").any(|known| known == kind) {
        return Err(syntax(node, format!("{name} has the type {kind:?}; valid types: {JOINT_TYPES}")));
    }
    for (element, needed) in
        [("parent", true), ("child", true), ("origin", false), ("axis", false), ("limit", false), ("mimic", false)]
    {
        single(node, element, &name, needed)?;
    }
    for child in node.children().filter(Node::is_element) {
        match child.tag_name().name() {
            "parent" | "child" => drop(required(child, "link")?),
            "mimic" => drop(required(child, "joint")?),
            _ => {}
        }
        all_numbers(child, &name)?;
    }
    Ok(())
}

fn geometry(node: Node, of: &str) -> Result<(), RobotError> {
    let shapes: Vec<Node> = node.children().filter(Node::is_element).collect();
    let &[shape] = shapes.as_slice() else {
        let text = format!("{of}: {} holds {} shapes, it must hold one", tag(node), shapes.len());
        return Err(syntax(node, format!("{text}; valid shapes: {}", SHAPES.join(", "))));
    };
    let kind = shape.tag_name().name();
    if !SHAPES.contains(&kind) {
        return Err(syntax(shape, format!("{of}: {} is no shape; valid shapes: {}", tag(shape), SHAPES.join(", "))));
    }
    if kind == "mesh" {
        required(shape, "filename")?;
        counted(shape, "scale", 3, false, of)?;
    }
    all_numbers(shape, of)
}

fn all_numbers(node: Node, of: &str) -> Result<(), RobotError> {
    let kind = node.tag_name().name();
    for (_, attribute, count, needed) in NUMBERS.into_iter().filter(|(element, ..)| *element == kind) {
        counted(node, attribute, count, needed, of)?;
    }
    Ok(())
}

fn counted(node: Node, attribute: &str, count: usize, needed: bool, of: &str) -> Result<(), RobotError> {
    match numbers(node, attribute, of)? {
        Some(values) if values.len() != count => {
            let text = format!("{of}: {} {attribute:?} has {} numbers", tag(node), values.len());
            Err(syntax(node, format!("{text}, it must have {count}")))
        }
        None if needed => Err(syntax(node, format!("{of}: {} has no attribute {attribute:?}", tag(node)))),
        _ => Ok(()),
    }
}

fn single(node: Node, element: &'static str, of: &str, needed: bool) -> Result<(), RobotError> {
    match children(node, element).count() {
        0 if needed => Err(syntax(node, format!("{of}: {} has no <{element}>", tag(node)))),
        0 | 1 => Ok(()),
        count => Err(syntax(node, format!("{of}: {} has {count} <{element}>, only one is allowed", tag(node)))),
    }
}
