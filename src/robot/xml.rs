//! What the URDF and SRDF readers share: attributes with the line and the element they stand in.

use roxmltree::{Document, Node};

use super::RobotError;

/// Parses a document whose root is `<robot>`.
pub(super) fn document<'a>(text: &'a str, format: &str) -> Result<Document<'a>, RobotError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = Document::parse(text).map_err(|error| RobotError::Syntax(format!("not an XML file: {error}")))?;
    let root = document.root_element();
    if let Some(node) = document.descendants().find(is_xacro) {
        let advice = "expand the file first: xacro FILE.xacro > FILE.urdf";
        return Err(syntax(node, format!("{} is an xacro element; {advice}", tag(node))));
    }
    if root.tag_name().name() != "robot" {
        return Err(syntax(root, format!("the root element is {}; a {format} starts with <robot>", tag(root))));
    }
    Ok(document)
}

fn is_xacro(node: &Node) -> bool {
    node.is_element() && node.tag_name().namespace().is_some_and(|space| space.contains("xacro"))
}

/// The element as a message names it: `<limit>`.
pub(super) fn tag(node: Node) -> String {
    format!("<{}>", node.tag_name().name())
}

/// An error at the line of an element.
pub(super) fn syntax(node: Node, text: impl std::fmt::Display) -> RobotError {
    RobotError::Syntax(format!("line {}: {text}", line(node)))
}

/// Line of an element, from 1.
pub(super) fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// Child elements of one name.
pub(super) fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// An attribute that must be there and not be empty.
pub(super) fn required<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, RobotError> {
    match node.attribute(name) {
        Some(value) if !value.trim().is_empty() => Ok(value),
        Some(_) => Err(syntax(node, format!("{} has an empty {name:?}", tag(node)))),
        None => Err(syntax(node, format!("{} has no attribute {name:?}", tag(node)))),
    }
}

/// Numbers of an attribute, separated by blanks; `None` where the attribute is missing.
pub(super) fn numbers(node: Node, name: &str, of: &str) -> Result<Option<Vec<f64>>, RobotError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let parse = |word: &str| {
        let place = format!("{of}: {} {name:?} is {text:?}", tag(node));
        word.parse::<f64>().map_err(|_| syntax(node, format!("{place}; {word:?} is not a number")))
    };
    text.split_whitespace().map(parse).collect::<Result<Vec<_>, _>>().map(Some)
}
