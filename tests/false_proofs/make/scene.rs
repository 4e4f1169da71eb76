//! Random scenes: objects by frames, attached objects, pairs that may touch, octomaps.

use fastrand::Rng;

use super::mesh::Format;
use super::robot::{Made, geometry};
use super::{direction, one_in, pick, quaternion, uniform, vector};
use crate::pose::{Pose, Vector, add, scaled};
use crate::shape::{Geometry, Placement};
use crate::solid::{Convex, Part};
use crate::theme::Theme;

/// The text that a scene is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Text {
    /// taut's scene file.
    Own,
    /// A whole scene, and a diff that adds the last objects.
    Diff,
    /// A dump of MoveIt's planning scene message, as YAML.
    Message,
    /// MoveIt's `.scene`.
    Lines,
}

#[derive(Clone, Debug)]
pub struct Object {
    pub id: String,
    /// Frame of its pose; empty is the world.
    pub frame: String,
    pub pose: Placement,
    /// Poses in the object's own frame.
    pub shapes: Vec<(Geometry, Placement)>,
    pub subframes: Vec<(String, Placement)>,
    /// Where its frame stands: in the world, or in that of the link that carries it.
    pub stands: Pose,
}

impl Object {
    pub fn parts(&self) -> Vec<Part> {
        let shapes = self.shapes.iter();
        shapes
            .flat_map(|(geometry, pose)| geometry.parts(&self.stands.then(&pose.pose())))
            .collect()
    }
}

#[derive(Clone, Debug)]
pub struct Attached {
    pub link: usize,
    pub touch_links: Vec<usize>,
    pub object: Object,
}

/// A cell of an octree that is occupied, and nothing else of it.
#[derive(Clone, Debug)]
pub struct Octomap {
    pub resolution: f64,
    /// Child that each level goes down to, from the root.
    pub path: Vec<usize>,
    pub origin: Placement,
}

impl Octomap {
    /// Levels of an octree.
    const DEPTH: usize = 16;

    fn at(rng: &mut Rng, wanted: Vector) -> Self {
        let resolution = pick(rng, &[0.05, 0.04, 0.025]);
        let origin = Placement {
            at: vector(rng, 0.3),
            turn: if rng.bool() {
                [0.0, 0.0, 0.0, 1.0]
            } else {
                quaternion(rng)
            },
        };
        let pose = origin.pose();
        let inside = pose.direction_inside(crate::pose::sub(wanted, pose.at));
        let keys = inside.map(|x| (x / resolution).floor() as i64 + (1 << (Self::DEPTH - 1)));
        let levels = Self::DEPTH - rng.usize(1..3);
        let child = |level: usize| {
            let bit = |axis: usize| (keys[axis] >> (Self::DEPTH - 1 - level) & 1) as usize;
            bit(0) | bit(1) << 1 | bit(2) << 2
        };
        Self {
            resolution,
            path: (0..levels).map(child).collect(),
            origin,
        }
    }

    /// The cell as a box.
    pub fn part(&self) -> Part {
        let mut low = [-self.resolution * f64::from(1 << (Self::DEPTH - 1)); 3];
        let mut size = self.resolution * f64::from(1 << Self::DEPTH);
        for child in &self.path {
            size /= 2.0;
            low = std::array::from_fn(|axis| low[axis] + size * (child >> axis & 1) as f64);
        }
        let middle = add(low, [size / 2.0; 3]);
        Part::new(
            self.origin.pose().then(&Pose::shift(middle)),
            Convex::cuboid([size; 3]),
        )
    }
}

#[derive(Clone, Debug)]
pub struct Scene {
    pub text: Text,
    pub frames: Vec<(String, Placement)>,
    pub objects: Vec<Object>,
    pub attached: Vec<Attached>,
    pub allowed: Vec<(String, String)>,
    pub octomap: Option<Octomap>,
    /// Kinds of primitives are numbers, as in messages.
    pub has_numbers: bool,
    /// Which of its words has a wrong letter: a choice for the writer.
    pub wrong_letter: Option<u64>,
}

/// A scene for a robot and a theme.
pub fn scene(rng: &mut Rng, theme: Theme, made: &Made) -> Scene {
    let text = match (theme, rng.usize(0..8)) {
        (Theme::Octomap, _) => Text::Message,
        (Theme::Misspelt, at) => [Text::Own, Text::Message][at % 2],
        (_, 0) => Text::Message,
        (_, 1) => Text::Lines,
        (_, 2) => Text::Diff,
        _ => Text::Own,
    };
    let has_frames = text != Text::Lines;
    let count = if has_frames { rng.usize(0..3) } else { 0 };
    let frames = (0..count)
        .map(|i| (format!("frame{i}"), placement(rng, 0.4)))
        .collect();
    let mut scene = Scene {
        text,
        frames,
        objects: Vec::new(),
        attached: Vec::new(),
        allowed: Vec::new(),
        octomap: None,
        has_numbers: false,
        wrong_letter: None,
    };
    for index in 0..rng.usize(2..7) {
        let object = object(rng, theme, made, &scene, index);
        scene.objects.push(object);
    }
    if theme == Theme::RestContacts {
        scene.objects.clear();
    }
    if text != Text::Lines && theme != Theme::RestContacts && one_in(rng, 3) {
        attach(rng, theme, made, &mut scene);
    }
    if matches!(text, Text::Own | Text::Diff) && one_in(rng, 4) && !scene.objects.is_empty() {
        let link = rng.usize(0..made.robot.links.len());
        let object = rng.usize(0..scene.objects.len());
        scene.allowed.push((
            made.robot.links[link].clone(),
            scene.objects[object].id.clone(),
        ));
    }
    if theme == Theme::Octomap {
        let wanted = nearby(rng);
        scene.octomap = Some(Octomap::at(rng, wanted));
    }
    scene.has_numbers = text == Text::Message && theme != Theme::Octomap && one_in(rng, 4);
    scene.wrong_letter = (theme == Theme::Misspelt).then(|| rng.u64(..));
    scene
}

/// A place within the robot's reach, not quite at its foot.
fn nearby(rng: &mut Rng) -> Vector {
    scaled(direction(rng), uniform(rng, 0.2, 0.8))
}

fn placement(rng: &mut Rng, most: f64) -> Placement {
    let turn = if rng.bool() {
        quaternion(rng)
    } else {
        [0.0, 0.0, 0.0, 1.0]
    };
    Placement {
        at: vector(rng, most),
        turn,
    }
}

/// Frames that a next object may name, with where they stand.
fn known_frames(scene: &Scene, theme: Theme) -> Vec<(String, Pose)> {
    let mut known: Vec<(String, Pose)> = scene
        .frames
        .iter()
        .map(|(name, pose)| (name.clone(), pose.pose()))
        .collect();
    if theme.has(Theme::Frames) {
        for object in &scene.objects {
            known.push((object.id.clone(), object.stands));
            let inner = object.subframes.iter();
            known.extend(inner.map(|(name, pose)| {
                (
                    format!("{}/{name}", object.id),
                    object.stands.then(&pose.pose()),
                )
            }));
        }
    }
    known
}

fn object(rng: &mut Rng, theme: Theme, made: &Made, scene: &Scene, index: usize) -> Object {
    let known = known_frames(scene, theme);
    let is_framed = scene.text != Text::Lines
        && !known.is_empty()
        && (theme.has(Theme::Frames) || one_in(rng, 3));
    let (frame, outer) = if is_framed {
        known[rng.usize(0..known.len())].clone()
    } else if scene.text != Text::Lines
        && one_in(rng, 6)
        && made.robot.joints[0].kind != crate::robot::Kind::Fixed
    {
        (made.world_frame.to_owned(), Pose::IDENTITY)
    } else {
        (String::new(), Pose::IDENTITY)
    };
    // Where it should stand, seen from its frame.
    let wanted = nearby(rng);
    let at = outer.direction_inside(crate::pose::sub(wanted, outer.at));
    let pose = Placement {
        at,
        ..placement(rng, 0.0)
    };
    let formats: &[Format] = match scene.text {
        Text::Lines => &[Format::Inline],
        Text::Own | Text::Diff | Text::Message => &[
            Format::Obj,
            Format::Dae,
            Format::StlText,
            Format::StlBinary,
            Format::Inline,
        ],
    };
    let (shapes, subframes) = contents(rng, theme, scene.text, formats);
    Object {
        id: format!("o{index}"),
        frame,
        pose,
        shapes,
        subframes,
        stands: outer.then(&pose.pose()),
    }
}

type Contents = (Vec<(Geometry, Placement)>, Vec<(String, Placement)>);

fn contents(rng: &mut Rng, theme: Theme, text: Text, formats: &[Format]) -> Contents {
    let count = if one_in(rng, 4) { 2 } else { 1 };
    let shapes = (0..count).map(|_| {
        let mut shape = geometry(rng, theme, formats, 0.04, 0.16);
        if text == Text::Lines || text == Text::Message {
            // Neither has capsules.
            if let Geometry::Capsule { length, radius } = shape {
                shape = Geometry::Cylinder { length, radius };
            }
        }
        if let Geometry::Mesh(mesh) = &mut shape
            && mesh.format == Format::Inline
        {
            mesh.scale = [1.0; 3];
            mesh.has_polygons = false;
        }
        let wanted = placement(rng, 0.05);
        let at = shape.origin_for(&wanted.pose());
        (
            shape,
            Placement {
                at,
                turn: wanted.turn,
            },
        )
    });
    let shapes = shapes.collect();
    let count = if theme.has(Theme::Frames) {
        rng.usize(0..3)
    } else {
        0
    };
    (
        shapes,
        (0..count)
            .map(|i| (format!("sub{i}"), placement(rng, 0.3)))
            .collect(),
    )
}

/// Hangs an object on a link; it may touch the neighbours.
fn attach(rng: &mut Rng, theme: Theme, made: &Made, scene: &mut Scene) {
    let link = rng.usize(0..made.robot.links.len());
    let pose = Placement {
        at: scaled(direction(rng), 0.15),
        ..placement(rng, 0.0)
    };
    let formats = [Format::Obj, Format::Dae, Format::StlText, Format::Inline];
    let (shapes, _) = contents(rng, theme, scene.text, &formats);
    let object = Object {
        id: "held".to_owned(),
        frame: if rng.bool() {
            made.robot.links[link].clone()
        } else {
            String::new()
        },
        pose,
        shapes,
        subframes: Vec::new(),
        stands: pose.pose(),
    };
    let is_next = |other: &usize| {
        made.robot.joints[*other].parent == Some(link)
            || made.robot.joints[link].parent == Some(*other)
    };
    let touch_links = (0..made.robot.links.len())
        .filter(is_next)
        .collect();
    scene.attached.push(Attached {
        link,
        touch_links,
        object,
    });
}
