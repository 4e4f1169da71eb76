//! MoveIt's `.scene` text, as its planning scene writes it and RViz saves it.
//!
//! ```text
//! kitchen                      name of the scene
//! * table                      an object
//! 0.5 0 0.4                    its position      (newer files only)
//! 0 0 0 1                      and orientation x y z w
//! 1                            number of its shapes
//! box                          a shape, its dimensions, its pose in the object's frame, its colour
//! 1.2 0.8 0.05
//! 0 0 0
//! 0 0 0 1
//! 0 0 0 0
//! 0                            number of its subframes (newer files only): name and pose of each
//! .                            the end
//! ```
//! Lengths in metres. Dimensions: box x y z; sphere radius; cylinder radius, length (the other way
//! round than in messages); mesh its numbers of vertices and of triangles, then the vertices, then
//! the triangles. Words may be broken into lines anywhere, but the name of a scene or an object has
//! the rest of its line. As in MoveIt, a file is a newer one if the line after the first object's
//! name holds more than a number.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::pose_file::{checked_pose, is_unturned, not_set};
use super::{Obstacle, Scene, SceneDescription, SceneError};
use crate::math::{Pose, Vec3};
use crate::shape::{Mesh, PlacedShape, Shape};
use crate::warning::Warning;

/// A frame on an object: whose it is, its name and its pose.
type Subframe = ((String, String), Pose);

const SHAPES: &str = "box, sphere, cylinder, mesh";

/// Reads a scene.
///
/// # Errors
/// A text that is cut short or says something else than is expected, a shape that is no solid, two
/// objects of one name; each with its line.
pub fn parse(text: &str) -> Result<Scene, SceneError> {
    let text = text.trim_start_matches('\u{feff}');
    let mut words = Words {
        rest: text,
        line: 1,
        warnings: Vec::new(),
    };
    let name = words.rest_of_line();
    if name.starts_with('*') {
        return Err(words.refuse(
            1,
            format!("the name of the scene must stand here, before {name:?}"),
        ));
    }
    let is_new = is_new_format(text);
    let mut obstacles: Vec<Obstacle> = Vec::new();
    let mut subframes = BTreeMap::new();
    loop {
        let (marker, line) = words.next("\"*\" and an object, or \".\" at the end")?;
        match marker {
            "." => break,
            "*" => {
                let (obstacle, on_it) = object(&mut words, is_new)?;
                if obstacles
                    .iter()
                    .any(|other| other.id == obstacle.id)
                {
                    let text = format!(
                        "object {:?} is defined twice; object ids must be unique",
                        obstacle.id
                    );
                    return Err(words.refuse(line, text));
                }
                obstacles.push(obstacle);
                subframes.extend(on_it);
            }
            other => {
                let text =
                    format!("{other:?} is neither \"*\", before an object, nor \".\", at the end");
                return Err(words.refuse(line, text));
            }
        }
    }
    let mut warnings = words.warnings;
    if !words.rest.trim().is_empty() {
        let text = format!("what follows the \".\" of line {} is ignored", words.line);
        warnings.push(Warning::uncovered(text));
    }
    Scene::of(SceneDescription {
        name: name.to_owned(),
        obstacles,
        subframes,
        warnings,
        ..Default::default()
    })
}

/// Whether objects have poses of their own, and subframes: newer files.
fn is_new_format(text: &str) -> bool {
    let mut lines = text
        .lines()
        .skip(1)
        .skip_while(|line| !line.starts_with('*'))
        .skip(1);
    lines
        .next()
        .is_some_and(|line| line.split_whitespace().count() > 1)
}

/// An object, and the frames on it.
fn object(words: &mut Words, is_new: bool) -> Result<(Obstacle, Vec<Subframe>), SceneError> {
    let line = words.line;
    let id = words.rest_of_line().to_owned();
    if id.is_empty() {
        return Err(words.refuse(
            line,
            "an object without a name; write \"* NAME\"".to_owned(),
        ));
    }
    let pose = if is_new {
        words.pose(&id)?
    } else {
        Pose::identity()
    };
    let count = words.whole(&format!("the number of shapes of object {id:?}"))?;
    let mut shapes = Vec::new();
    for _ in 0..count {
        let shape = shape(words, &id)?;
        let placed = words.pose(&id)?;
        let _colour: [f64; 4] =
            words.numbers(&format!("the colour of a shape of object {id:?}"))?;
        shapes.push(PlacedShape {
            pose: placed,
            shape,
        });
    }
    let mut subframes = Vec::new();
    if is_new {
        for _ in 0..words.whole(&format!("the number of subframes of object {id:?}"))? {
            let (name, _) = words.next(&format!("the name of a subframe of object {id:?}"))?;
            subframes.push(((id.clone(), name.to_owned()), words.pose(&id)?));
        }
    }
    // The text says each pose, that of the object too.
    Ok((Obstacle::new(id, shapes).set_at(pose), subframes))
}

fn shape(words: &mut Words, id: &str) -> Result<Shape, SceneError> {
    let (kind, line) = words.next(&format!("a shape of object {id:?}"))?;
    let what = format!("the dimensions of a {kind} of object {id:?}");
    let shape = match kind {
        "box" => Shape::cuboid(Vec3::from_array(words.numbers(&what)?)),
        "sphere" => words
            .numbers(&what)
            .map(|[radius]| Shape::sphere(radius))?,
        "cylinder" => words
            .numbers(&what)
            .map(|[radius, length]| Shape::cylinder(length, radius))?,
        "mesh" => return mesh(words, id, line),
        "cone" | "plane" | "octree" => {
            let instead = if kind == "cone" {
                "a cylinder or a mesh"
            } else {
                "a thick box or a mesh"
            };
            let text = format!(
                "object {id:?} has a {kind}, which is not read; use {instead} (valid: {SHAPES})"
            );
            return Err(words.refuse(line, text));
        }
        other => {
            let text = format!("object {id:?} has a shape {other:?}; valid shapes: {SHAPES}");
            return Err(words.refuse(line, text));
        }
    };
    shape.map_err(|error| words.refuse(line, format!("object {id:?}: {error}")))
}

fn mesh(words: &mut Words, id: &str, line: usize) -> Result<Shape, SceneError> {
    let what = format!("a mesh of object {id:?}");
    let vertices = words.whole(&format!("the number of vertices of {what}"))?;
    let triangles = words.whole(&format!("the number of triangles of {what}"))?;
    let vertex = |_| {
        Ok(Vec3::from_array(
            words.numbers(&format!("a vertex of {what}"))?,
        ))
    };
    let vertices: Vec<Vec3> = (0..vertices)
        .map(vertex)
        .collect::<Result<_, SceneError>>()?;
    let expected = format!("a triangle of {what}");
    let mut triangle = |_| {
        Ok([
            words.whole(&expected)?,
            words.whole(&expected)?,
            words.whole(&expected)?,
        ])
    };
    let triangles: Vec<[u32; 3]> = (0..triangles)
        .map(&mut triangle)
        .collect::<Result<_, SceneError>>()?;
    let mesh = Mesh::new(format!("of line {line}"), vertices, triangles);
    let mesh = mesh.map_err(|error| words.refuse(line, format!("object {id:?}: {error}")))?;
    Ok(Shape::Mesh(Arc::new(mesh)))
}

/// The words of a text, with the line that each stands in.
struct Words<'a> {
    rest: &'a str,
    /// Line where `rest` begins, from 1.
    line: usize,
    /// What is odd about the text so far.
    warnings: Vec<Warning>,
}

impl<'a> Words<'a> {
    /// The next word and its line; `expected` says what it should be.
    fn next(&mut self, expected: &str) -> Result<(&'a str, usize), SceneError> {
        let start = self.rest.trim_start();
        if start.is_empty() {
            let text = format!(
                "the text ends after this line, where {expected} must follow; is it cut short?"
            );
            return Err(self.refuse(self.line, text));
        }
        self.line += self.rest[..self.rest.len() - start.len()]
            .matches('\n')
            .count();
        let end = start
            .find(char::is_whitespace)
            .unwrap_or(start.len());
        self.rest = &start[end..];
        Ok((&start[..end], self.line))
    }

    /// What is left of the line, without spaces around it.
    fn rest_of_line(&mut self) -> &'a str {
        let (line, rest) = self
            .rest
            .split_once('\n')
            .unwrap_or((self.rest, ""));
        self.line += usize::from(line.len() < self.rest.len());
        self.rest = rest;
        line.trim()
    }

    fn numbers<const N: usize>(&mut self, expected: &str) -> Result<[f64; N], SceneError> {
        let mut values = [0.0; N];
        for value in &mut values {
            let (word, line) = self.next(expected)?;
            let text =
                || format!("{word:?} stands where {expected} must stand: {N} finite numbers");
            let number = word
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite());
            *value = number.ok_or_else(|| self.refuse(line, text()))?;
        }
        Ok(values)
    }

    fn whole(&mut self, expected: &str) -> Result<u32, SceneError> {
        let (word, line) = self.next(expected)?;
        word.parse()
            .map_err(|_| self.refuse(line, format!("{word:?} stands where {expected} must stand")))
    }

    fn pose(&mut self, id: &str) -> Result<Pose, SceneError> {
        let position = self.numbers(&format!("a position of object {id:?}"))?;
        let orientation = self.numbers(&format!("an orientation (x y z w) of object {id:?}"))?;
        if is_unturned(orientation) {
            let text = format!("line {}: object {id:?}: {}", self.line, not_set("pose"));
            self.warnings.push(Warning::uncovered(text));
        }
        checked_pose(id, "pose", position, orientation)
            .map_err(|error| self.refuse(self.line, error.to_string()))
    }

    fn refuse(&self, line: usize, text: String) -> SceneError {
        SceneError::Syntax(format!("line {line}: {text}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quat_exp;

    /// Every shape, with a pose of the object and a subframe.
    const NEW: &str = "our kitchen\n* big table\n0.5 0 0.4\n0 0 0.707107 0.707107\n3\nbox\n1.2 0.8 0.05\n1 0 0\n\
        0 0 0 1\n0.1 0.2 0.3 1\ncylinder\n0.03 0.7\n0 0 -0.35\n0 0 0 1\n0 0 0 0\nsphere\n0.1\n0 0 0\n0 0 0 1\n\
        0 0 0 0\n1\nhandle 0 0 1\n0 0 0 1\n* tent\n0 0 0\n0 0 0 1\n1\nmesh\n4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
        0 2 1\n0 1 3\n0 3 2\n1 2 3\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n";
    const OLD: &str = "(noname)\n* cup\n1\ncylinder\n0.04 0.1\n0.5 0 1\n0 0 0 1\n0 0 0 0\n.\n";

    fn refusal(text: &str) -> String {
        parse(text)
            .expect_err("must be refused")
            .to_string()
    }

    #[test]
    fn the_newer_format_has_poses_of_objects_and_subframes() {
        let scene = parse(NEW).unwrap();
        assert_eq!(
            (scene.name(), scene.warnings()),
            ("our kitchen", &[] as &[Warning])
        );
        let objects: Vec<_> = scene.obstacles().iter().collect();
        let [table, tent] = objects[..] else {
            panic!("two objects")
        };
        assert_eq!((table.id.as_str(), tent.id.as_str()), ("big table", "tent"));
        let [lid, leg, ball] = &*table.shapes else {
            panic!("three shapes")
        };
        assert_eq!(lid.shape, Shape::cuboid(Vec3::new(1.2, 0.8, 0.05)).unwrap());
        assert_eq!(
            leg.shape,
            Shape::cylinder(0.7, 0.03).unwrap(),
            "the text has the radius first"
        );
        assert_eq!(ball.shape, Shape::sphere(0.1).unwrap());
        // A quarter turn of the object takes the shape's x to y; six digits are what MoveIt writes.
        let lid = table.placed_shapes().next().unwrap();
        assert!(
            (lid.pose.translation - Vec3::new(0.5, 1.0, 0.4)).length() < 1e-6,
            "{}",
            lid.pose.translation
        );
        let quarter = quat_exp(Vec3::Z * std::f64::consts::FRAC_PI_2);
        assert!((lid.pose.rotation * Vec3::X - quarter * Vec3::X).length() < 1e-6);
        let Shape::Mesh(mesh) = &tent.shapes[0].shape else {
            panic!("a mesh")
        };
        assert!((mesh.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn the_older_format_has_neither() {
        for text in [
            OLD.to_owned(),
            OLD.replace('\n', "\r\n"),
            OLD.replace("0.5 0 1\n0 0 0 1", "0.5 0\n1 0 0 0\n1"),
        ] {
            let scene = parse(&text).unwrap();
            let shape = &scene.obstacles()[0].shapes[0];
            assert_eq!(
                (scene.name(), scene.obstacles()[0].id.as_str()),
                ("(noname)", "cup")
            );
            assert_eq!(shape.shape, Shape::cylinder(0.1, 0.04).unwrap());
            assert_eq!(shape.pose.translation, Vec3::new(0.5, 0.0, 1.0));
        }
        assert!(
            parse("empty\n.\n")
                .unwrap()
                .obstacles()
                .is_empty()
        );
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_its_line() {
        for (text, old, new, parts) in [
            (
                OLD,
                "cylinder\n0.04 0.1",
                "cone\n0.04 0.1",
                ["line 4", "\"cup\" has a cone", "cylinder or a mesh"],
            ),
            (
                OLD,
                "cylinder\n0.04 0.1",
                "plane\n0 0 1 0",
                ["line 4", "\"cup\" has a plane", "thick box"],
            ),
            (
                OLD,
                "cylinder\n0.04 0.1",
                "torus\n1 1",
                ["line 4", "\"torus\"", "valid shapes: box, sphere"],
            ),
            (
                OLD,
                "0.04 0.1",
                "0.04 -1",
                ["line 4", "\"cup\"", "height is -1"],
            ),
            (
                OLD,
                "0.04 0.1",
                "0.04 wide",
                [
                    "line 5",
                    "\"wide\"",
                    "dimensions of a cylinder of object \"cup\"",
                ],
            ),
            (
                OLD,
                "0.5 0 1\n",
                "0.5 nan 1\n",
                ["line 6", "\"nan\"", "position of object \"cup\""],
            ),
            (
                OLD,
                "0 0 0 1",
                "0 0 0 2",
                ["line 7", "norm 2", "unit quaternion"],
            ),
            (OLD, "\n.\n", "\n", ["line 8", "ends after", "cut short"]),
            (
                OLD,
                "0 0 0 0\n.\n",
                "0 0",
                ["line 8", "colour", "cut short"],
            ),
            (
                OLD,
                "* cup\n1",
                "* cup\n2",
                ["line 9", "\".\"", "valid shapes"],
            ),
            (
                OLD,
                "* cup\n1",
                "* cup\n0",
                ["line 4", "\"cylinder\" is neither", "\"*\""],
            ),
            (OLD, "* cup", "*", ["line 2", "without a name", "* NAME"]),
            (
                OLD,
                "(noname)\n",
                "",
                ["line 1", "name of the scene", "* cup"],
            ),
            (
                NEW,
                "* tent",
                "* big table",
                ["line 24", "\"big table\" is defined twice", "unique"],
            ),
            (
                NEW,
                "1 2 3\n",
                "1 2 4\n",
                ["line 28", "\"tent\": mesh of line 28", "beyond the 4"],
            ),
            (NEW, "4 4\n", "5 4\n", ["line 42", "\".\"", "colour"]),
        ] {
            assert!(text.contains(old), "{old} is not in the text");
            let text = refusal(&text.replace(old, new));
            assert!(
                parts.iter().all(|part| text.contains(part)),
                "{text:?} lacks one of {parts:?}"
            );
        }
    }

    #[test]
    fn oddities_are_told() {
        let open = NEW
            .replace("4 4\n", "4 3\n")
            .replace("0 2 1\n", "")
            + "* more";
        let warnings = parse(&open).unwrap().warnings().to_vec();
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(
            warnings[0].contains("object \"tent\": mesh of line 28 is not closed: 3 of 6"),
            "{warnings:?}"
        );
        assert!(
            warnings[1].contains("line 41") && warnings[1].contains("ignored"),
            "{warnings:?}"
        );
    }
}
