//! A case: a robot and a scene as files, what they mean, and paths for them.

use std::fs;
use std::path::{Path, PathBuf};

use fastrand::Rng;

use super::execute;
use super::make::mesh::{Form, Format, Mesh};
use super::make::path::{self, Made};
use super::make::{one_in, pick, robot, scene, uniform};
use super::read;
use super::robot::Kind;
use super::shape::Geometry;
use super::theme::Theme;
use super::world::{Body, World};
use super::write;

/// Where the files of a case are.
#[derive(Debug)]
pub struct Files {
    pub folder: PathBuf,
    pub urdf: PathBuf,
    pub srdf: Option<PathBuf>,
    pub scene: PathBuf,
    /// A diff that the scene needs, too.
    pub diff: Option<String>,
}

pub struct Case {
    pub theme: Theme,
    pub scene: scene::Scene,
    pub world: World,
    pub files: Files,
    /// Columns by name.
    pub names: Vec<String>,
    /// A path that fills the soft limits, where there are some.
    within_soft_limits: Option<Made>,
    /// Formats of the meshes, and their forms.
    pub meshes: Vec<(Format, Form)>,
}

impl Case {
    /// Makes a case and writes its files into a folder.
    pub fn new(rng: &mut Rng, theme: Theme, folder: &Path) -> Self {
        let mut made = robot::robot(rng, theme);
        let scene = scene::scene(rng, theme, &made);
        let within_soft_limits = if theme == Theme::SoftLimits {
            fill_soft_limits(rng, &mut made, &scene)
        } else {
            None
        };
        let written = write::robot::robot(&made);
        let surroundings = write::scene::scene(&made, &scene);
        let write = |name: String, bytes: &[u8]| {
            let file = folder.join(name);
            fs::write(&file, bytes).expect("the scratch folder can be written");
            file
        };
        for (name, bytes) in written
            .meshes
            .iter()
            .chain(&surroundings.meshes)
        {
            write(name.clone(), bytes);
        }
        let meshes: Vec<&Mesh> = geometries(&made, &scene)
            .filter_map(Geometry::mesh)
            .collect();
        for mesh in meshes
            .iter()
            .filter(|mesh| mesh.format != Format::Inline)
        {
            read::mesh::verify(mesh, &write::mesh::bytes(mesh), rng).unwrap_or_else(|error| {
                panic!("a written {:?} is not what was meant: {error}", mesh.format)
            });
        }
        let files = Files {
            folder: folder.to_owned(),
            urdf: write("robot.urdf".into(), written.urdf.as_bytes()),
            srdf: written
                .srdf
                .map(|text| write("robot.srdf".into(), text.as_bytes())),
            scene: write(
                format!("scene.{}", surroundings.ending),
                surroundings.text.as_bytes(),
            ),
            diff: surroundings.diff,
        };
        let world = world(&made, &scene);
        let names = made
            .robot
            .columns
            .iter()
            .map(|column| made.robot.name_of(*column))
            .collect();
        let meshes = meshes
            .iter()
            .map(|mesh| (mesh.format, mesh.column.form))
            .collect();
        Self {
            theme,
            scene,
            world,
            files,
            names,
            within_soft_limits,
            meshes,
        }
    }

    /// A path of those that the case is about, or another.
    pub fn path(&self, rng: &mut Rng) -> Option<Made> {
        let world = &self.world;
        let theme = self.theme;
        let is_special = rng.usize(0..3) < 2;
        let wants = |rng: &mut Rng, own: Theme| {
            theme == own && is_special || theme == Theme::Mixed && one_in(rng, 8)
        };
        let mut made = if wants(rng, Theme::HalfTurns) {
            path::half_turn(rng, world)
        } else if wants(rng, Theme::Leaders) {
            path::long(rng, world, true)
        } else if wants(rng, Theme::LongSteps) {
            path::long(rng, world, false)
        } else if wants(rng, Theme::Quaternions) {
            path::half_quaternion(rng, world)
        } else {
            self.any_path(rng)
        }?;
        let robot = &world.robot;
        if theme.has(Theme::LongSteps) && one_in(rng, 2) {
            made.rewind(rng, robot);
        }
        if one_in(rng, 4) {
            made.round(rng, robot);
        }
        if theme.has(Theme::Quaternions) {
            made.flip(rng, robot);
        }
        if theme == Theme::Constraint {
            made.constrain(rng);
        }
        Some(made)
    }

    fn any_path(&self, rng: &mut Rng) -> Option<Made> {
        // Where shapes are in doubt, places where they just touch tell more than ways between them.
        let shapes = [
            Theme::Misspelt,
            Theme::FarMeshes,
            Theme::Concave,
            Theme::Warped,
            Theme::QuaternionOrigins,
        ];
        let kinds = if shapes.contains(&self.theme) { 6 } else { 10 };
        match rng.usize(0..kinds) {
            0..2 => path::into(rng, &self.world),
            2..4 => path::graze(rng, &self.world),
            4 => path::blind(rng, &self.world),
            _ => {
                let waypoints = pick(rng, &[4, 12, 40]);
                let winds = self.theme.has(Theme::Winding) && one_in(rng, 2);
                path::walk(rng, &self.world, waypoints, winds)
            }
        }
    }

    /// A path for `shorten`: one that wanders.
    pub fn long_path(&self, rng: &mut Rng) -> Option<Made> {
        let winds = self.theme.has(Theme::Winding);
        let waypoints = pick(rng, &[6, 10, 16]);
        let mut made = match &self.within_soft_limits {
            Some(made) => made.clone(),
            None => path::walk(rng, &self.world, waypoints, winds)?,
        };
        if self.theme.has(Theme::LongSteps) {
            made.rewind(rng, &self.world.robot);
        }
        if self.theme == Theme::Constraint {
            made.constrain(rng);
        }
        Some(made)
    }

    /// Joint kinds that a segment moves.
    pub fn kinds_moved(&self, from: &[f64], to: &[f64]) -> impl Iterator<Item = Kind> {
        let moved = self
            .world
            .robot
            .columns
            .iter()
            .enumerate()
            .filter(move |(q, _)| from[*q] != to[*q]);
        moved.map(|(_, column)| self.world.robot.joints[column.joint].kind)
    }
}

/// Makes a path that moves some joints hardly at all, and its ranges the soft limits: what pushes a
/// path away from an obstacle likes to move those that stood still.
fn fill_soft_limits(rng: &mut Rng, made: &mut robot::Made, scene: &scene::Scene) -> Option<Made> {
    let mut narrow = made.clone();
    for joint in &mut narrow.robot.joints {
        if let Some((lower, upper)) = joint.limits.filter(|_| rng.bool()) {
            let middle = uniform(rng, lower, upper);
            joint.limits = Some(((middle - 0.01).max(lower), (middle + 0.01).min(upper)));
        }
    }
    let narrow = world(&narrow, scene);
    // One that something keeps from being straight.
    let held = |path: &Made| {
        !execute::is_free(&narrow, &path.rows[0], &path.rows[path.rows.len() - 1], 0.0)
    };
    let walks: Vec<Made> = (0..8)
        .filter_map(|_| path::walk(rng, &narrow, 16, false))
        .collect();
    let path = walks
        .iter()
        .find(|path| held(path))
        .or(walks.first())?
        .clone();
    for (q, column) in made.robot.columns.iter().enumerate() {
        let joint = &mut made.robot.joints[column.joint];
        if joint.limits.is_some() {
            let numbers = path.rows.iter().map(|row| row[q]);
            let range = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            joint.soft_limits = Some(range);
        }
    }
    Some(path)
}

fn geometries<'a>(
    made: &'a robot::Made,
    scene: &'a scene::Scene,
) -> impl Iterator<Item = &'a Geometry> {
    let links = made
        .shapes
        .iter()
        .flatten()
        .map(|shape| &shape.geometry);
    let objects = scene
        .objects
        .iter()
        .chain(scene.attached.iter().map(|held| &held.object));
    links.chain(objects.flat_map(|object| {
        object
            .shapes
            .iter()
            .map(|(geometry, _)| geometry)
    }))
}

/// What robot and scene mean.
fn world(made: &robot::Made, scene: &scene::Scene) -> World {
    let mut bodies = Vec::new();
    for (link, shapes) in made
        .shapes
        .iter()
        .enumerate()
        .filter(|(_, shapes)| !shapes.is_empty())
    {
        let parts = shapes
            .iter()
            .flat_map(|shape| shape.geometry.parts(&shape.origin.pose()))
            .collect();
        bodies.push(Body::new(&made.robot.links[link], Some(link), true, parts));
    }
    for held in &scene.attached {
        bodies.push(Body::new(
            &held.object.id,
            Some(held.link),
            false,
            held.object.parts(),
        ));
    }
    for object in &scene.objects {
        bodies.push(Body::new(&object.id, None, false, object.parts()));
    }
    if let Some(octomap) = &scene.octomap {
        bodies.push(Body::new("<octomap>", None, false, vec![octomap.part()]));
    }
    let mut touching = scene.allowed.clone();
    for held in &scene.attached {
        let names = held
            .touch_links
            .iter()
            .map(|link| made.robot.links[*link].clone());
        touching.extend(names.map(|link| (held.object.id.clone(), link)));
    }
    let pairs = World::pair_up(&made.robot, &bodies, &touching);
    World {
        robot: made.robot.clone(),
        bodies,
        pairs,
    }
}
