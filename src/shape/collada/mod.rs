//! Collada (DAE) meshes: every geometry that the file's visual scene shows, where its nodes put it,
//! in metres.
//!
//! `<unit meter>` and the transforms of the nodes are applied. `<up_axis>` is not, as in RViz and
//! MoveIt: a link or an object means the mesh's own x, y and z. A file without a visual scene shows
//! all its geometries.
//!
//! Our own reader: the crates for it read f32, and show each geometry once however often it is
//! placed. What shows no surface (cameras, lights, curves) is passed over, curves with a word; what
//! shows another than polygons is refused.

mod geometry;
#[cfg(test)]
mod tests;
mod transform;

use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

use roxmltree::{Document, Node, NodeId, ParsingOptions};

use super::surface::Surface;
use crate::math::Vec3;
use transform::Affine;

/// Nodes within nodes; deeper is a node that shows itself.
const DEEPEST: usize = 64;
/// Triangles of one file; more come from nodes that multiply each other.
const MOST_TRIANGLES: usize = 4_000_000;

/// Reads a Collada file; its surface is in metres.
///
/// # Errors
/// No Collada, a reference to nothing, numbers that are missing or none, a shape that is no polygon
/// mesh; with the line where it is known.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let text = decoded(bytes)?;
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let document =
        Document::parse_with_options(text, options).map_err(|e| format!("not a DAE file: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!(
            "not a DAE file: its root is <{}>, it must be <COLLADA>",
            root.tag_name().name()
        ));
    }
    let ids = root
        .descendants()
        .filter_map(|node| Some((node.attribute("id")?, node)));
    // Of two elements with one id the first counts.
    let ids = ids.fold(HashMap::new(), |mut ids, (id, node)| {
        ids.entry(id).or_insert(node);
        ids
    });
    let mut file = File {
        ids,
        known: HashMap::new(),
        surface: Surface::default(),
    };
    file.show(root, &Affine::scale(Vec3::splat(unit(root)?)))?;
    if file.surface.triangles.is_empty() {
        let shapes = "<triangles>, <polylist>, <polygons>, <tristrips> or <trifans>";
        return Err(format!(
            "it shows no polygon: no {shapes} in a geometry of its visual scene"
        ));
    }
    Ok(file.surface)
}

/// The text of an XML file: UTF-8, UTF-16 with its mark, or what its first line says, of which
/// Latin-1 is known.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    let wide = |of_pair: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes
            .chunks_exact(2)
            .map(|pair| of_pair([pair[0], pair[1]]))
            .collect();
        String::from_utf16(&units)
            .map(Cow::Owned)
            .map_err(|error| format!("not a DAE file in UTF-16: {error}"))
    };
    match bytes {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => return wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, b'<', ..] => return wide(u16::from_be_bytes),
        _ => {}
    }
    std::str::from_utf8(bytes)
        .map(Cow::Borrowed)
        .or_else(|error| {
            let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_ascii_lowercase();
            match ["iso-8859-1", "latin1", "windows-1252", "us-ascii"]
                .iter()
                .any(|name| head.contains(name))
            {
                // Coordinates are ASCII; only names have other letters.
                true => Ok(Cow::Owned(
                    bytes
                        .iter()
                        .map(|byte| char::from(*byte))
                        .collect(),
                )),
                false => Err(format!(
                    "not a DAE file in UTF-8, UTF-16 or ISO-8859-1: {error}"
                )),
            }
        })
}

/// A file being read.
struct File<'a, 'input> {
    ids: HashMap<&'a str, Node<'a, 'input>>,
    /// Geometries that were read; some are shown many times.
    known: HashMap<NodeId, Rc<[Surface]>>,
    surface: Surface,
}

impl<'a, 'input> File<'a, 'input> {
    /// Shows the visual scene of the document; without one, all geometries.
    fn show(&mut self, root: Node<'a, 'input>, unit: &Affine) -> Result<(), String> {
        let instance = descendants(root, "instance_visual_scene").next();
        let scene = match instance {
            Some(instance) => Some(self.target(instance, "url", "visual_scene")?),
            None => descendants(root, "visual_scene").next(),
        };
        match scene {
            Some(scene) => children(scene, "node").try_for_each(|node| self.node(node, unit, 0)),
            None => {
                descendants(root, "geometry").try_for_each(|geometry| self.geometry(geometry, unit))
            }
        }
    }

    fn node(
        &mut self,
        node: Node<'a, 'input>,
        parent: &Affine,
        depth: usize,
    ) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(at(
                node,
                format!("nodes are nested more than {DEEPEST} deep; does a node show itself?"),
            ));
        }
        if !shows_something(node) {
            return Ok(());
        }
        let here = parent.then(&transform::of_node(node)?);
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "node" => self.node(child, &here, depth + 1)?,
                "instance_node" => {
                    self.node(self.target(child, "url", "node")?, &here, depth + 1)?
                }
                "instance_geometry" => {
                    self.geometry(self.target(child, "url", "geometry")?, &here)?
                }
                "instance_controller" => {
                    let text = "a mesh that bends with a skeleton (<instance_controller>) is no rigid shape";
                    return Err(at(child, format!("{text}; export it without its armature")));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn geometry(&mut self, geometry: Node<'a, 'input>, here: &Affine) -> Result<(), String> {
        let polygons = match self.known.get(&geometry.id()) {
            Some(polygons) => polygons.clone(),
            None => {
                let target = |node, attribute: &str, kind: &str| self.target(node, attribute, kind);
                let polygons: Rc<[Surface]> = geometry::polygons(geometry, &target)?.into();
                self.known
                    .insert(geometry.id(), polygons.clone());
                polygons
            }
        };
        let surface = &mut self.surface;
        for part in &*polygons {
            let first = surface.vertices.len();
            if first + part.vertices.len() > u32::MAX as usize
                || surface.triangles.len() + part.triangles.len() > MOST_TRIANGLES
            {
                return Err(format!(
                    "it shows more than {MOST_TRIANGLES} triangles; do its nodes multiply each other?"
                ));
            }
            surface.crossing += part.crossing;
            for (what, count) in &part.without_surface {
                *surface.without_surface.entry(what).or_default() += count;
            }
            surface.vertices.extend(
                part.vertices
                    .iter()
                    .map(|position| here.point(*position)),
            );
            surface
                .triangles
                .extend(part.triangles.iter().map(|triangle| {
                    let [a, b, c] = triangle.map(|i| first as u32 + i);
                    // A mirror turns triangles over; outside stays outside.
                    if here.mirrors() { [a, c, b] } else { [a, b, c] }
                }));
        }
        Ok(())
    }

    /// The element of a kind that an attribute such as `url="#id"` names.
    fn target(
        &self,
        node: Node<'a, 'input>,
        attribute: &str,
        kind: &str,
    ) -> Result<Node<'a, 'input>, String> {
        let name = tag(node);
        let value = node
            .attribute(attribute)
            .ok_or_else(|| at(node, format!("{name} has no {attribute:?}")))?;
        let Some(id) = value.strip_prefix('#') else {
            return Err(at(
                node,
                format!("{name} names {value:?}; only elements of this file (#id) are read"),
            ));
        };
        let found = self
            .ids
            .get(id)
            .filter(|target| target.tag_name().name() == kind);
        found.copied().ok_or_else(|| {
            at(
                node,
                format!("{name} names {value:?}, but there is no <{kind}> of this id"),
            )
        })
    }
}

/// Whether anything below a node may have a surface; a camera's place is nobody's concern.
fn shows_something(node: Node) -> bool {
    let instances = ["instance_geometry", "instance_node", "instance_controller"];
    node.descendants()
        .any(|child| instances.contains(&child.tag_name().name()))
}

/// Metres per unit of the file; 1 where it says nothing.
fn unit(root: Node) -> Result<f64, String> {
    let asset = children(root, "asset").next();
    let Some(unit) = asset.and_then(|asset| children(asset, "unit").next()) else {
        return Ok(1.0);
    };
    let Some(text) = unit.attribute("meter") else {
        return Ok(1.0);
    };
    // Some exporters write the decimal point of their country.
    let value = text
        .trim()
        .replace(',', ".")
        .parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| {
        at(
            unit,
            format!("<unit meter={text:?}> must be a number greater than 0"),
        )
    })
}

/// A message with the line of an element.
fn at(node: Node, text: impl std::fmt::Display) -> String {
    format!(
        "line {}: {text}",
        node.document()
            .text_pos_at(node.range().start)
            .row
    )
}

fn tag(node: Node) -> String {
    format!("<{}>", node.tag_name().name())
}

fn children<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children()
        .filter(move |child| child.tag_name().name() == name)
}

fn descendants<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.descendants()
        .filter(move |child| child.tag_name().name() == name)
}

/// Words of an element's text, comments left out.
fn words<'a>(node: Node<'a, '_>) -> impl Iterator<Item = &'a str> {
    let texts = node
        .children()
        .filter(Node::is_text)
        .filter_map(|text| text.text());
    texts.flat_map(str::split_ascii_whitespace)
}

/// The numbers of an element's text.
fn numbers(node: Node) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        let value = word.parse::<f64>().ok();
        value.ok_or_else(|| {
            at(
                node,
                format!("{} holds {word:?}, which is no number", tag(node)),
            )
        })
    };
    words(node).map(number).collect()
}
