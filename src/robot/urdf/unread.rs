//! Nothing is left out in silence: what stands in a URDF and is not read is named, and refused
//! where it would add a shape or a constraint.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::super::xml::{children, is_plain, line, required, syntax, tag};
use super::RobotError;
use crate::warning::Warning;

/// Child elements that are read, or that say nothing of where a link can be or what shape it has.
const KNOWN: [(&str, &[&str]); 4] = [
    (
        "robot",
        &[
            "link",
            "joint",
            "material",
            "transmission",
            "gazebo",
            "ros2_control",
            "sensor",
        ],
    ),
    (
        "link",
        &[
            "collision",
            "visual",
            "inertial",
            "sensor",
            "contact",
            "self_collision_checking",
        ],
    ),
    (
        "collision",
        &[
            "origin",
            "geometry",
            "material",
            "verbose",
            "name",
            "contact_coefficients",
            "surface",
        ],
    ),
    (
        "joint",
        &[
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "mimic",
            "safety_controller",
            "dynamics",
            "calibration",
        ],
    ),
];
/// Attributes of the elements whose numbers say where things are and how large.
const ATTRIBUTES: [(&str, &[&str]); 9] = [
    ("origin", &["xyz", "rpy", "quat_xyzw"]),
    ("axis", &["xyz"]),
    (
        "limit",
        &[
            "lower",
            "upper",
            "effort",
            "velocity",
            "acceleration",
            "deceleration",
            "jerk",
        ],
    ),
    ("mimic", &["joint", "multiplier", "offset"]),
    ("box", &["size"]),
    ("cylinder", &["radius", "length"]),
    ("capsule", &["radius", "length"]),
    ("sphere", &["radius"]),
    ("mesh", &["filename", "scale"]),
];
/// Elements of a joint of which the first counts.
const ONCE: [&str; 5] = ["origin", "axis", "limit", "mimic", "safety_controller"];

/// What of the document is not read, a line for each kind.
///
/// # Errors
/// An element that is not read and would add a shape or join links.
pub(super) fn warnings(root: Node) -> Result<Vec<Warning>, RobotError> {
    let mut unread = Unread::default();
    unread.elements(root, "robot", "the robot")?;
    for link in children(root, "link") {
        let name = format!("link {:?}", required(link, "name")?);
        unread.elements(link, "link", &name)?;
        for collision in children(link, "collision") {
            unread.elements(collision, "collision", &name)?;
            unread.repeated(collision, &name);
            let shapes = children(collision, "geometry").flat_map(|geometry| geometry.children());
            shapes
                .chain(children(collision, "origin"))
                .for_each(|node| unread.attributes(node, &name));
        }
    }
    for joint in children(root, "joint") {
        let name = format!("joint {:?}", required(joint, "name")?);
        unread.elements(joint, "joint", &name)?;
        unread.repeated(joint, &name);
        joint
            .children()
            .for_each(|node| unread.attributes(node, &name));
    }
    Ok(unread.warnings)
}

#[derive(Default)]
struct Unread {
    warnings: Vec<Warning>,
    /// What has been named: files repeat themselves.
    seen: BTreeSet<String>,
}

impl Unread {
    fn elements(&mut self, node: Node, kind: &str, of: &str) -> Result<(), RobotError> {
        let known = KNOWN
            .iter()
            .find(|(name, _)| *name == kind)
            .map_or(&[][..], |(_, known)| known);
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if is_plain(child) && known.contains(&name) {
                continue;
            }
            if let Some(adds) = adds(child, kind) {
                let advice = "take it out of the file if the proof may do without it";
                return Err(syntax(
                    child,
                    format!(
                        "{of}: {} {adds}, and is not read here; {advice}",
                        tag(child)
                    ),
                ));
            }
            let effect = if name == "collision_filter_group" {
                ": the pairs that it switches off are checked"
            } else {
                ""
            };
            self.warn(
                child,
                format!("{} in <{kind}>", tag(child)),
                format!("{of}: {} is not read{effect}", tag(child)),
            );
        }
        Ok(())
    }

    fn attributes(&mut self, node: Node, of: &str) {
        let Some((kind, known)) = ATTRIBUTES
            .iter()
            .find(|(name, _)| is_plain(node) && node.has_tag_name(*name))
        else {
            return;
        };
        for attribute in node
            .attributes()
            .filter(|a| a.namespace().is_none() && !known.contains(&a.name()))
        {
            let text = format!(
                "{of}: {:?} of <{kind}> is not read; read are {}",
                attribute.name(),
                known.join(", ")
            );
            self.warn(node, format!("{kind} {}", attribute.name()), text);
        }
    }

    fn repeated(&mut self, node: Node, of: &str) {
        for element in ONCE {
            if let Some(second) = children(node, element).nth(1) {
                let text = format!("{of}: a second <{element}>; the first counts");
                self.warn(second, format!("{of} {element}"), text);
            }
        }
    }

    fn warn(&mut self, node: Node, key: String, text: String) {
        if self.seen.insert(key) {
            self.warnings.push(Warning::cosmetic(
                "unread",
                format!("line {}: {text}", line(node)),
            ));
        }
    }
}

/// What an element that is not read would add, where it would.
fn adds(node: Node, parent: &str) -> Option<&'static str> {
    let name = node.tag_name().name();
    if has_geometry(node) && !matches!(name, "visual" | "sensor") {
        return Some("has a shape");
    }
    let joins = name.contains("joint") || name.contains("constraint");
    (parent == "robot" && joins).then_some("joins links")
}

fn has_geometry(node: Node) -> bool {
    let mut inner = node.descendants();
    inner.any(|inner| inner.has_tag_name("geometry"))
}
