//! What the URDF and SRDF readers share: attributes with the line and the element they stand in.

mod tidy;

use roxmltree::{Document, Node, ParsingOptions};

use super::RobotError;

/// The text as XML, however the readers of robots would have let it pass; and what is odd about it,
/// a line each.
pub(super) fn tidy(text: &str) -> (String, Vec<String>) {
    tidy::tidy(text)
}

/// Parses a tidy document whose root is `<robot>`.
pub(super) fn document<'a>(text: &'a str, format: &str) -> Result<Document<'a>, RobotError> {
    // Entities of a document type are expanded to a depth that the parser bounds.
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| RobotError::Syntax(format!("not an XML file: {error}")))?;
    let root = document.root_element();
    if let Some(node) = document.descendants().find(is_xacro) {
        return Err(syntax(
            node,
            format!("{} is an xacro element; {XACRO_ADVICE}", tag(node)),
        ));
    }
    if !is_plain(root) || root.tag_name().name() != "robot" {
        return Err(syntax(
            root,
            format!(
                "the root element is {}; a {format} starts with <robot>",
                tag(root)
            ),
        ));
    }
    Ok(document)
}

/// The name that a document gives its robot, if it is one.
pub(crate) fn name(text: &str) -> Option<String> {
    let (text, _) = tidy(text);
    let document = document(&text, "URDF").ok()?;
    Some(
        document
            .root_element()
            .attribute("name")?
            .to_owned(),
    )
}

/// What to do about what only xacro understands.
const XACRO_ADVICE: &str = "expand the file first: xacro FILE.xacro > FILE.urdf";

fn is_xacro(node: &Node) -> bool {
    node.is_element()
        && node
            .tag_name()
            .namespace()
            .is_some_and(|space| space.contains("xacro"))
}

/// Whether an element has no prefix: those with one are other programs' own.
pub(super) fn is_plain(node: Node) -> bool {
    node.is_element() && node.tag_name().namespace() == node.default_namespace()
}

/// The element as a message names it: `<limit>`, `<drake:joint>`.
pub(super) fn tag(node: Node) -> String {
    let name = node.tag_name();
    let prefix = name
        .namespace()
        .and_then(|space| node.lookup_prefix(space))
        .filter(|prefix| !prefix.is_empty());
    prefix.map_or_else(
        || format!("<{}>", name.name()),
        |prefix| format!("<{prefix}:{}>", name.name()),
    )
}

/// An error at the line of an element.
pub(super) fn syntax(node: Node, text: impl std::fmt::Display) -> RobotError {
    RobotError::Syntax(format!("line {}: {text}", line(node)))
}

/// Line of an element, from 1.
pub(super) fn line(node: Node) -> u32 {
    node.document()
        .text_pos_at(node.range().start)
        .row
}

/// Child elements of one name, without a prefix.
pub(super) fn children<'a, 'i>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children()
        .filter(move |child| is_plain(*child) && child.tag_name().name() == name)
}

/// An attribute that must be there and not be empty.
pub(super) fn required<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, RobotError> {
    match node.attribute(name) {
        Some(value) if is_unexpanded(value) => Err(unexpanded(node, name, value)),
        Some(value) if !value.trim().is_empty() => Ok(value),
        Some(_) => Err(syntax(node, format!("{} has an empty {name:?}", tag(node)))),
        None => Err(syntax(
            node,
            format!("{} has no attribute {name:?}", tag(node)),
        )),
    }
}

/// Numbers of an attribute, separated by blanks; `None` where the attribute is missing.
pub(super) fn numbers(node: Node, name: &str, of: &str) -> Result<Option<Vec<f64>>, RobotError> {
    let Some(text) = node.attribute(name) else {
        return Ok(None);
    };
    if is_unexpanded(text) {
        return Err(unexpanded(node, name, text));
    }
    let parse = |word: &str| {
        let place = format!("{of}: {} {name:?} is {text:?}", tag(node));
        word.parse::<f64>()
            .map_err(|_| syntax(node, format!("{place}; {word:?} is not a number")))
    };
    text.split_whitespace()
        .map(parse)
        .collect::<Result<Vec<_>, _>>()
        .map(Some)
}

/// Whether a value holds what xacro would have replaced: `$(find package)`, `${length}`.
fn is_unexpanded(value: &str) -> bool {
    value.contains("$(") || value.contains("${")
}

fn unexpanded(node: Node, name: &str, value: &str) -> RobotError {
    syntax(
        node,
        format!(
            "{} {name:?} is {value:?}, which xacro has not expanded; {XACRO_ADVICE}",
            tag(node)
        ),
    )
}
