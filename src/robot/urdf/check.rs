//! What urdf-rs lets through or reports without a name or a line is refused here, before it reads.

use roxmltree::Node;

use super::super::xml::{children, is_plain, numbers, required, syntax, tag};
use super::RobotError;

/// Joint types of URDF that a robot here can have.
const JOINT_TYPES: &str = "fixed, revolute, continuous, prismatic, planar, floating";
/// Shapes of a collision geometry.
const SHAPES: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];
/// Numbers by element and attribute: how many, and whether they must be there.
const NUMBERS: [(&str, &str, usize, bool); 16] = [
    ("origin", "xyz", 3, false),
    ("origin", "rpy", 3, false),
    ("origin", "quat_xyzw", 4, false),
    ("axis", "xyz", 3, true),
    ("limit", "lower", 1, false),
    ("limit", "upper", 1, false),
    ("safety_controller", "soft_lower_limit", 1, false),
    ("safety_controller", "soft_upper_limit", 1, false),
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
pub(super) fn link(node: Node, version: (u32, u32)) -> Result<(), RobotError> {
    let name = format!("link {:?}", required(node, "name")?);
    children(node, "collision").try_for_each(|collision| placed(collision, &name, version))
}

/// Refuses a collision or visual shape whose place or geometry cannot be read.
pub(super) fn placed(node: Node, of: &str, version: (u32, u32)) -> Result<(), RobotError> {
    single(node, "geometry", of, true)?;
    if let Some(origin) = children(node, "origin").next() {
        all_numbers(origin, of)?;
        one_rotation(origin, of, version)?;
    }
    geometry(
        children(node, "geometry")
            .next()
            .unwrap_or(node),
        of,
    )
}

/// Refuses a joint whose name, type, ends or numbers cannot be read. Of parts that stand there
/// twice the first counts.
pub(super) fn joint(node: Node, version: (u32, u32)) -> Result<(), RobotError> {
    let name = format!("joint {:?}", required(node, "name")?);
    let kind = required(node, "type")?;
    if kind == "spherical" {
        let advice = "spherical joints are not supported; use three revolute joints, or floating";
        return Err(syntax(node, format!("{name}: {advice}")));
    }
    if !JOINT_TYPES
        .split(", ")
        .any(|known| known == kind)
    {
        return Err(syntax(
            node,
            format!("{name} has the type {kind:?}; valid types: {JOINT_TYPES}"),
        ));
    }
    for element in ["parent", "child"] {
        single(node, element, &name, true)?;
        children(node, element).try_for_each(|end| required(end, "link").map(drop))?;
    }
    for element in ["origin", "axis", "limit", "mimic", "safety_controller"] {
        let Some(part) = children(node, element).next() else {
            continue;
        };
        match element {
            // A joint that has no axis may have any element of that name.
            "axis" if matches!(kind, "fixed" | "floating" | "planar") => continue,
            "mimic" => drop(required(part, "joint")?),
            "origin" => one_rotation(part, &name, version)?,
            _ => {}
        }
        all_numbers(part, &name)?;
    }
    Ok(())
}

/// Since URDF 1.1 a rotation is a quaternion or angles, not both.
fn one_rotation(origin: Node, of: &str, version: (u32, u32)) -> Result<(), RobotError> {
    let has = |name: &str| origin.attribute(name).is_some();
    if version >= super::QUATERNIONS && has("rpy") && has("quat_xyzw") {
        let text = format!("{of}: <origin> has both \"rpy\" and \"quat_xyzw\"; give one of them");
        return Err(syntax(origin, text));
    }
    Ok(())
}

fn geometry(node: Node, of: &str) -> Result<(), RobotError> {
    // Elements with a prefix count: other programs' shapes are shapes.
    let shapes: Vec<Node> = node
        .children()
        .filter(Node::is_element)
        .collect();
    let &[shape] = shapes.as_slice() else {
        let text = format!(
            "{of}: {} holds {} shapes, it must hold one",
            tag(node),
            shapes.len()
        );
        return Err(syntax(
            node,
            format!("{text}; valid shapes: {}", SHAPES.join(", ")),
        ));
    };
    let kind = shape.tag_name().name();
    if !is_plain(shape) || !SHAPES.contains(&kind) {
        return Err(syntax(
            shape,
            format!(
                "{of}: {} is no shape; valid shapes: {}",
                tag(shape),
                SHAPES.join(", ")
            ),
        ));
    }
    if kind == "mesh" {
        required(shape, "filename")?;
        counted(shape, "scale", 3, false, of)?;
    }
    all_numbers(shape, of)
}

fn all_numbers(node: Node, of: &str) -> Result<(), RobotError> {
    let kind = node.tag_name().name();
    for (_, attribute, count, needed) in NUMBERS
        .into_iter()
        .filter(|(element, ..)| *element == kind)
    {
        counted(node, attribute, count, needed, of)?;
    }
    Ok(())
}

fn counted(
    node: Node,
    attribute: &str,
    count: usize,
    needed: bool,
    of: &str,
) -> Result<(), RobotError> {
    match numbers(node, attribute, of)? {
        Some(values) if values.len() != count => {
            let text = format!(
                "{of}: {} {attribute:?} has {} numbers",
                tag(node),
                values.len()
            );
            Err(syntax(node, format!("{text}, it must have {count}")))
        }
        None if needed => Err(syntax(
            node,
            format!("{of}: {} has no attribute {attribute:?}", tag(node)),
        )),
        _ => Ok(()),
    }
}

fn single(node: Node, element: &'static str, of: &str, needed: bool) -> Result<(), RobotError> {
    match children(node, element).count() {
        0 if needed => Err(syntax(
            node,
            format!("{of}: {} has no <{element}>", tag(node)),
        )),
        0 | 1 => Ok(()),
        count => Err(syntax(
            node,
            format!(
                "{of}: {} has {count} <{element}>, only one is allowed",
                tag(node)
            ),
        )),
    }
}
