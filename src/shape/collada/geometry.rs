//! The polygons of a `<geometry>`, as triangles.

use roxmltree::Node;

use super::super::surface::Surface;
use super::{at, children, numbers, tag, words};
use crate::math::Vec3;

/// Finds the element of a kind that an attribute of a node names.
pub(super) type Target<'f, 'a, 'input> =
    dyn Fn(Node<'a, 'input>, &str, &str) -> Result<Node<'a, 'input>, String> + 'f;

/// Elements that hold polygons.
const POLYGONS: [&str; 5] = ["triangles", "polylist", "polygons", "tristrips", "trifans"];

/// Elements of a mesh that show lines.
const LINES: [&str; 2] = ["lines", "linestrips"];
/// Elements of a mesh that show nothing.
const OTHERS: [&str; 3] = ["source", "vertices", "extra"];

/// The polygons of a geometry, in its own frame and unit: one entry for each element that holds
/// some.
pub(super) fn polygons<'a, 'input>(
    geometry: Node<'a, 'input>,
    target: &Target<'_, 'a, 'input>,
) -> Result<Vec<Surface>, String> {
    let id = geometry.attribute("id").unwrap_or_default();
    let Some(mesh) = children(geometry, "mesh").next() else {
        let shape = geometry
            .children()
            .find(|node| node.is_element() && node.tag_name().name() != "asset");
        return match shape {
            Some(shape) if shape.tag_name().name() == "spline" => {
                Ok(vec![without_surface("splines")])
            }
            Some(shape) => {
                let text = format!(
                    "geometry {id:?} is a {}, which is not read; export it as triangles",
                    tag(shape)
                );
                Err(at(shape, text))
            }
            None => Err(at(
                geometry,
                format!("geometry {id:?} is empty; it must have a <mesh>"),
            )),
        };
    };
    let mut parts = Vec::new();
    for element in mesh.children().filter(Node::is_element) {
        match element.tag_name().name() {
            name if POLYGONS.contains(&name) => parts.push(polygons_of(element, target)?),
            name if LINES.contains(&name) => parts.push(without_surface("elements of lines")),
            name if OTHERS.contains(&name) => {}
            _ => {
                let text = format!(
                    "{} of geometry {id:?} is no part of a <mesh>; valid: {}",
                    tag(element),
                    POLYGONS.join(", ")
                );
                return Err(at(element, text));
            }
        }
    }
    Ok(parts)
}

fn without_surface(what: &'static str) -> Surface {
    let mut surface = Surface::default();
    surface.leave_out(what);
    surface
}

fn polygons_of<'a, 'input>(
    element: Node<'a, 'input>,
    target: &Target<'_, 'a, 'input>,
) -> Result<Surface, String> {
    let (source, offset, stride) = corners(element, target)?;
    let mut surface = Surface {
        vertices: positions(source)?,
        ..Surface::default()
    };
    let count = surface.vertices.len();
    let lists: Vec<Vec<u32>> = children(element, "p")
        .map(|p| indices(p, offset, stride, count))
        .collect::<Result<_, _>>()?;
    if let Some(holed) = children(element, "ph").next() {
        return Err(at(
            holed,
            "polygons with holes (<ph>) are not read; export the mesh as triangles",
        ));
    }
    let polygon = |surface: &mut Surface, list: &[u32]| {
        surface
            .add_polygon(list)
            .map_err(|text| at(element, text))
    };
    match element.tag_name().name() {
        "triangles" => surface.triangles = of_triangles(&lists),
        "polylist" => of_polylist(element, &lists, |list| polygon(&mut surface, list))?,
        "polygons" => lists
            .iter()
            .try_for_each(|list| polygon(&mut surface, list))?,
        "tristrips" => {
            surface.triangles = lists
                .iter()
                .flat_map(|list| of_strip(list))
                .collect()
        }
        _ => {
            surface.triangles = lists
                .iter()
                .flat_map(|list| of_fan(list))
                .collect()
        }
    }
    check_count(element, &lists, surface.triangles.len())?;
    Ok(surface)
}

/// Where the positions are, at which place of a corner's indices theirs stands, and how many
/// indices a corner has.
fn corners<'a, 'input>(
    element: Node<'a, 'input>,
    target: &Target<'_, 'a, 'input>,
) -> Result<(Source<'a, 'input>, usize, usize), String> {
    let mut vertex = None;
    let mut stride = 1;
    for input in children(element, "input") {
        let offset = match input.attribute("offset") {
            None => 0,
            Some(text) => text.trim().parse::<u16>().map_err(|_| {
                at(
                    input,
                    format!("<input offset={text:?}> must be a small whole number"),
                )
            })?,
        };
        stride = stride.max(usize::from(offset) + 1);
        if input.attribute("semantic") == Some("VERTEX") {
            vertex = Some((input, usize::from(offset)));
        }
    }
    let missing = || {
        at(
            element,
            format!("{} has no <input semantic=\"VERTEX\">", tag(element)),
        )
    };
    let (input, offset) = vertex.ok_or_else(missing)?;
    let vertices = target(input, "source", "vertices")?;
    let position =
        children(vertices, "input").find(|input| input.attribute("semantic") == Some("POSITION"));
    let position =
        position.ok_or_else(|| at(vertices, "<vertices> has no <input semantic=\"POSITION\">"))?;
    let source = target(position, "source", "source")?;
    let accessor = children(source, "technique_common")
        .flat_map(|node| children(node, "accessor"))
        .next();
    let array = match accessor {
        Some(accessor) => target(accessor, "source", "float_array")?,
        None => children(source, "float_array")
            .next()
            .ok_or_else(|| at(source, "<source> has no <float_array>"))?,
    };
    Ok((Source { accessor, array }, offset, stride))
}

/// An array of numbers and how positions stand in it.
struct Source<'a, 'input> {
    accessor: Option<Node<'a, 'input>>,
    array: Node<'a, 'input>,
}

fn positions(source: Source) -> Result<Vec<Vec3>, String> {
    let Source { accessor, array } = source;
    let values = numbers(array)?;
    if let Some(count) = whole(array, "count")?.filter(|count| *count != values.len()) {
        return Err(at(
            array,
            format!(
                "<float_array> has {} numbers, it says {count}; is it cut short?",
                values.len()
            ),
        ));
    }
    let field = |name| accessor.map_or(Ok(None), |accessor| whole(accessor, name));
    let stride = field("stride")?.unwrap_or(3);
    let offset = field("offset")?.unwrap_or(0);
    if stride < 3 {
        return Err(at(
            array,
            format!("positions of {stride} numbers; they must have x, y and z"),
        ));
    }
    let [x, y, z] = accessor.map_or([0, 1, 2], axes);
    let rows = values
        .get(offset..)
        .unwrap_or_default()
        .chunks(stride)
        .filter(|row| row.len() >= 3.max(1 + x.max(y).max(z)));
    let positions: Vec<Vec3> = rows
        .map(|row| Vec3::new(row[x], row[y], row[z]))
        .collect();
    match field("count")? {
        Some(count) if count > positions.len() => Err(at(
            array,
            format!(
                "<float_array> holds {} positions, its accessor says {count}",
                positions.len()
            ),
        )),
        Some(count) => Ok(positions[..count].to_vec()),
        None => Ok(positions),
    }
}

/// Where x, y and z stand among the numbers of a position: where their names do, if all three are
/// there.
fn axes(accessor: Node) -> [usize; 3] {
    let names: Vec<_> = children(accessor, "param")
        .map(|param| param.attribute("name"))
        .collect();
    let place = |axis: &str| {
        names
            .iter()
            .position(|name| *name == Some(axis))
    };
    match ["X", "Y", "Z"].map(place) {
        [Some(x), Some(y), Some(z)] => [x, y, z],
        _ => [0, 1, 2],
    }
}

/// The position indices of a `<p>`.
fn indices(p: Node, offset: usize, stride: usize, positions: usize) -> Result<Vec<u32>, String> {
    let all: Vec<&str> = words(p).collect();
    if !all.len().is_multiple_of(stride) {
        return Err(at(
            p,
            format!(
                "<p> has {} indices, {stride} a corner; is it cut short?",
                all.len()
            ),
        ));
    }
    let index = |word: &&str| {
        let index = word
            .parse::<u32>()
            .map_err(|_| at(p, format!("<p> holds {word:?}, which is no index")))?;
        match (index as usize) < positions {
            true => Ok(index),
            false => Err(at(
                p,
                format!("<p> names position {index}; there are {positions}, from 0"),
            )),
        }
    };
    all.iter()
        .skip(offset)
        .step_by(stride)
        .map(index)
        .collect()
}

/// Refuses an element that says it holds more or fewer polygons than it does.
fn check_count(element: Node, lists: &[Vec<u32>], triangles: usize) -> Result<(), String> {
    let (what, held) = match element.tag_name().name() {
        "triangles" => {
            if let Some(odd) = lists.iter().find(|list| list.len() % 3 != 0) {
                return Err(at(
                    element,
                    format!("<triangles> has {} corners, no multiple of 3", odd.len()),
                ));
            }
            ("triangles", triangles)
        }
        "polylist" => return Ok(()),
        _ => ("<p> elements", lists.len()),
    };
    match whole(element, "count")? {
        Some(count) if count != held => Err(at(
            element,
            format!(
                "{} has {held} {what}, it says {count}; is it cut short?",
                tag(element)
            ),
        )),
        _ => Ok(()),
    }
}

fn whole(node: Node, attribute: &str) -> Result<Option<usize>, String> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(None);
    };
    let value = text.trim().parse().map_err(|_| {
        at(
            node,
            format!("{} {attribute}={text:?} is no count", tag(node)),
        )
    });
    value.map(Some)
}

fn of_triangles(lists: &[Vec<u32>]) -> Vec<[u32; 3]> {
    lists
        .iter()
        .flat_map(|list| list.chunks_exact(3))
        .map(|c| [c[0], c[1], c[2]])
        .collect()
}

fn of_polylist(
    element: Node,
    lists: &[Vec<u32>],
    mut polygon: impl FnMut(&[u32]) -> Result<(), String>,
) -> Result<(), String> {
    let counts = children(element, "vcount").next();
    let mut corners = lists.iter().flatten().copied();
    let mut polygons = 0;
    let mut list = Vec::new();
    for word in counts.into_iter().flat_map(words) {
        let short = |text: String| at(element, format!("<polylist> {text}; is it cut short?"));
        let count: usize = word
            .parse()
            .map_err(|_| short(format!("has a polygon of {word:?} corners")))?;
        list.clear();
        list.extend(corners.by_ref().take(count));
        if list.len() != count {
            return Err(short(format!(
                "has too few corners for its <vcount>, from polygon {polygons} on"
            )));
        }
        polygon(&list)?;
        polygons += 1;
    }
    let left = corners.count();
    let says = whole(element, "count")?.unwrap_or(polygons);
    if left > 0 || says != polygons {
        let text = format!(
            "<polylist> has {polygons} polygons in <vcount> and {left} more corners, it says {says}"
        );
        return Err(at(element, format!("{text}; is it cut short?")));
    }
    Ok(())
}

/// A strip: each corner makes a triangle with the two before it, every second one turned over.
fn of_strip(list: &[u32]) -> Vec<[u32; 3]> {
    let turned = |(i, w): (usize, &[u32])| {
        if i % 2 == 0 {
            [w[0], w[1], w[2]]
        } else {
            [w[1], w[0], w[2]]
        }
    };
    list.windows(3)
        .enumerate()
        .map(turned)
        .collect()
}

/// A fan: each corner makes a triangle with the one before it and the first.
fn of_fan(list: &[u32]) -> Vec<[u32; 3]> {
    list.get(1..)
        .unwrap_or_default()
        .windows(2)
        .map(|w| [list[0], w[0], w[1]])
        .collect()
}
