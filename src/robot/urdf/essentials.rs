//! What is read of a URDF, written anew for urdf-rs, so that nothing else in the file can fail the
//! robot or be taken for what it is not: other programs' elements, prefixes, document types, a
//! second `<origin>`.

use roxmltree::Node;

use super::super::xml::children;

/// Attributes and child elements of each element that is read; of the children in `FIRST` the
/// first.
const READ: [(&str, &[&str], &[&str]); 14] = [
    ("robot", &["name"], &["link", "joint"]),
    ("link", &["name"], &["collision"]),
    // A rotation as a quaternion is read from the document itself: urdf-rs makes angles of it.
    ("collision", &[], &["origin", "geometry"]),
    ("origin", &["xyz", "rpy"], &[]),
    (
        "geometry",
        &[],
        &["box", "cylinder", "capsule", "sphere", "mesh"],
    ),
    ("box", &["size"], &[]),
    ("cylinder", &["radius", "length"], &[]),
    ("capsule", &["radius", "length"], &[]),
    ("sphere", &["radius"], &[]),
    ("mesh", &["filename", "scale"], &[]),
    // Limits are read from the document itself: urdf-rs hides which are missing.
    (
        "joint",
        &["name", "type"],
        &["origin", "parent", "child", "axis", "mimic"],
    ),
    ("axis", &["xyz"], &[]),
    ("mimic", &["joint", "multiplier", "offset"], &[]),
    ("parent", &["link"], &[]),
];

/// Child elements that may be there once: as for urdfdom, the first counts.
const FIRST: [&str; 6] = ["origin", "geometry", "parent", "child", "axis", "mimic"];

/// The robot with nothing but what is read.
pub(super) fn of_robot(root: Node) -> String {
    let mut out = String::new();
    write(root, "robot", &mut out);
    out
}

/// A robot of one link with one collision shape, which is this visual's.
pub(super) fn of_visual(visual: Node) -> String {
    let mut out = String::from("<robot name=\"r\"><link name=\"l\">");
    write(visual, "collision", &mut out);
    out + "</link></robot>"
}

fn write(node: Node, name: &'static str, out: &mut String) {
    // A child is written as its parent.
    let row = if name == "child" { "parent" } else { name };
    let Some((_, attributes, elements)) = READ.iter().find(|(known, ..)| *known == row) else {
        return;
    };
    *out += &format!("<{name}");
    for attribute in *attributes {
        if let Some(value) = node.attribute(*attribute) {
            *out += &format!(" {attribute}=\"{}\"", escaped(value));
        }
    }
    *out += ">";
    for element in *elements {
        let most = if FIRST.contains(element) {
            1
        } else {
            usize::MAX
        };
        // urdf-rs wants the numbers of an axis, which a joint that has none need not give.
        let is_whole = |child: &Node| *element != "axis" || child.has_attribute("xyz");
        children(node, element)
            .take(most)
            .filter(is_whole)
            .for_each(|child| write(child, element, out));
    }
    *out += &format!("</{name}>");
}

fn escaped(value: &str) -> String {
    let references = [
        ('&', "&amp;"),
        ('<', "&lt;"),
        ('>', "&gt;"),
        ('"', "&quot;"),
        ('\n', "&#10;"),
        ('\t', "&#9;"),
    ];
    let written = |c: char| {
        references
            .iter()
            .find(|(plain, _)| *plain == c)
            .map_or(c.to_string(), |(_, text)| (*text).to_owned())
    };
    value.chars().map(written).collect()
}
