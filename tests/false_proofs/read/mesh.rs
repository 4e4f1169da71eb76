//! Mesh files as polygons, and what solid these enclose: that the files say what the gate takes
//! them to say.

use std::f64::consts::TAU;

use fastrand::Rng;
use roxmltree::{Document, Node};

use crate::make::mesh::{Format, Mesh, rotated};
use crate::make::vector;
use crate::pose::{Vector, add, cross, dot, length, scaled, sub};

/// Corners of each polygon, in metres.
type Polygons = Vec<Vec<Vector>>;

/// Whether a written file says the solid that it was made of.
///
/// # Errors
/// How it differs.
pub fn verify(mesh: &Mesh, bytes: &[u8], rng: &mut Rng) -> Result<(), String> {
    let read = match mesh.format {
        Format::StlText => stl_text(&String::from_utf8_lossy(bytes)),
        Format::StlBinary => stl_binary(bytes),
        Format::Obj => obj(&String::from_utf8_lossy(bytes)),
        Format::Dae => dae(&String::from_utf8_lossy(bytes)),
        Format::Inline => return Ok(()),
    };
    let own = |p: &Vector| std::array::from_fn(|i| p[i] * mesh.scale[i] - mesh.offset[i]);
    let polygons: Polygons = read
        .iter()
        .map(|polygon| polygon.iter().map(own).collect())
        .collect();
    let volume = volume(&polygons).abs();
    let expected = mesh.column.volume();
    if (volume - expected).abs() > 1e-6 * expected {
        return Err(format!("its volume is {volume}, it should be {expected}"));
    }
    for _ in 0..12 {
        let point = vector(rng, 0.15);
        let winding = winding(&polygons, point).abs();
        let is_inside = mesh.column.contains(point);
        // Near the surface the sum is neither.
        if (winding - 1.0).abs() < 1e-3 && !is_inside || winding < 1e-3 && is_inside {
            return Err(format!(
                "{point:?} is wound {winding} times, inside: {is_inside}"
            ));
        }
    }
    Ok(())
}

/// Triangles of a fan; of a flat polygon that is not convex some count negative, and the sums are
/// right all the same.
fn fan(polygon: &[Vector]) -> impl Iterator<Item = [Vector; 3]> {
    polygon[1..]
        .windows(2)
        .map(|pair| [polygon[0], pair[0], pair[1]])
}

fn volume(polygons: &Polygons) -> f64 {
    let six_fold = |[a, b, c]: [Vector; 3]| dot(a, cross(b, c));
    polygons
        .iter()
        .flat_map(|polygon| fan(polygon))
        .map(six_fold)
        .sum::<f64>()
        / 6.0
}

/// How often the surface winds about a point: the solid angle of its triangles, by van Oosterom and
/// Strackee.
fn winding(polygons: &Polygons, point: Vector) -> f64 {
    let angle = |triangle: [Vector; 3]| {
        let [a, b, c] = triangle.map(|corner| sub(corner, point));
        let x = length(a);
        let y = length(b);
        let z = length(c);
        let below = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
        2.0 * dot(a, cross(b, c)).atan2(below)
    };
    polygons
        .iter()
        .flat_map(|polygon| fan(polygon))
        .map(angle)
        .sum::<f64>()
        / (2.0 * TAU)
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect()
}

fn three(numbers: &[f64]) -> Vector {
    [numbers[0], numbers[1], numbers[2]]
}

fn stl_text(text: &str) -> Polygons {
    let corners: Vec<Vector> = text
        .lines()
        .filter_map(|line| Some(three(&numbers(line.trim().strip_prefix("vertex")?))))
        .collect();
    corners
        .chunks(3)
        .map(<[Vector]>::to_vec)
        .collect()
}

fn stl_binary(bytes: &[u8]) -> Polygons {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corner = |b: &[u8]| [number(b), number(&b[4..]), number(&b[8..])];
    bytes[84..]
        .chunks(50)
        .map(|facet| facet[12..48].chunks(12).map(corner).collect())
        .collect()
}

fn obj(text: &str) -> Polygons {
    let mut vertices = Vec::new();
    let mut polygons = Vec::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("v ") {
            vertices.push(three(&numbers(rest)));
        } else if let Some(rest) = line.strip_prefix("f ") {
            let place = |word: &str| match word
                .split('/')
                .next()
                .and_then(|index| index.parse::<i64>().ok())
            {
                Some(index) if index < 0 => (vertices.len() as i64 + index) as usize,
                index => index.expect("a face names vertices") as usize - 1,
            };
            polygons.push(
                rest.split_whitespace()
                    .map(|word| vertices[place(word)])
                    .collect(),
            );
        }
    }
    polygons
}

fn dae(text: &str) -> Polygons {
    let document = Document::parse(text).expect("the test writes XML");
    let first = |name: &str| {
        document
            .descendants()
            .find(|node| node.has_tag_name(name))
    };
    let unit: f64 = first("unit")
        .and_then(|node| node.attribute("meter")?.parse().ok())
        .unwrap_or(1.0);
    let positions: Vec<Vector> = first("float_array")
        .map_or(Vec::new(), |node| numbers(node.text().unwrap_or("")))
        .chunks(3)
        .map(three)
        .collect();
    let instance = first("instance_geometry").expect("a node shows the geometry");
    let above: Vec<Node> = instance
        .ancestors()
        .filter(|node| node.has_tag_name("node"))
        .collect();
    let placed = |p: Vector| {
        scaled(
            above
                .iter()
                .fold(p, |p, node| by_node(*node, p)),
            unit,
        )
    };
    let holder = document
        .descendants()
        .find(|node| ["triangles", "polylist", "polygons"].contains(&node.tag_name().name()));
    let holder = holder.expect("the geometry has polygons");
    let inputs = holder
        .children()
        .filter(|node| node.has_tag_name("input"))
        .count();
    let list = |node: Node| -> Vec<Vector> {
        let indices = numbers(node.text().unwrap_or(""))
            .into_iter()
            .step_by(inputs);
        indices
            .map(|index| placed(positions[index as usize]))
            .collect()
    };
    let lists: Polygons = holder
        .children()
        .filter(|node| node.has_tag_name("p"))
        .map(list)
        .collect();
    let sizes = holder
        .children()
        .find(|node| node.has_tag_name("vcount"))
        .map(|node| numbers(node.text().unwrap_or("")));
    match (holder.tag_name().name(), sizes) {
        ("polylist", Some(sizes)) => {
            let mut corners = lists.concat().into_iter();
            sizes
                .iter()
                .map(|size| corners.by_ref().take(*size as usize).collect())
                .collect()
        }
        ("triangles", _) => lists
            .concat()
            .chunks(3)
            .map(<[Vector]>::to_vec)
            .collect(),
        _ => lists,
    }
}

/// Where a node puts a point of what it holds.
fn by_node(node: Node, point: Vector) -> Vector {
    let steps: Vec<Node> = node
        .children()
        .filter(Node::is_element)
        .collect();
    steps.iter().rev().fold(point, |p, step| {
        let by = numbers(step.text().unwrap_or(""));
        match step.tag_name().name() {
            "translate" => add(p, three(&by)),
            "rotate" => rotated(three(&by), by[3], p),
            "scale" => std::array::from_fn(|i| p[i] * by[i]),
            "matrix" => std::array::from_fn(|i| dot(three(&by[4 * i..]), p) + by[4 * i + 3]),
            _ => p,
        }
    })
}
