//! Scenes: obstacles in the world, objects that links carry, padding and scale, named frames, and
//! the pairs that may touch. Knows no robot.

mod change;
mod cloud_file;
mod diff;
pub mod diff_file;
mod diff_text;
mod difference;
mod error;
mod former_hash;
mod frames;
mod message_file;
pub mod moveit_scene;
mod numbers;
mod numbers_file;
mod object;
mod object_file;
mod objects;
mod octomap_file;
mod pose_file;
#[cfg(test)]
mod properties;
pub mod scene_file;
mod sensing;
mod shape_file;
mod spelling;
mod table;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use crate::hash::ContentHasher;
use crate::math::Pose;
use crate::shape::PlacedShape;
use crate::warning::Warning;
pub use change::SceneChange;
pub use cloud_file::ByteSource;
pub use error::SceneError;
pub use frames::is_world;
pub use message_file::Filled;
pub use object::{AttachedObject, Obstacle};
pub use objects::{Iter, Objects};
pub use sensing::{SensedFrame, Sensing};
pub(crate) use spelling::with_nearest;
use table::{Table, Verdict, Verdicts};

/// Parts of texts that say where something is, for whoever else reads such texts.
pub(crate) mod words {
    pub(crate) use super::numbers::{Finite, Point, Quaternion};
    pub(crate) use super::pose_file::{HeaderFile, PoseFile, checked_pose};
    pub(crate) use super::shape_file::PrimitiveFile;
}

/// A scene, checked once when built and never changed: [`Scene::with`] makes another one, which
/// shares with this one all that the changes leave. Cloning it costs nothing.
#[derive(Clone, Debug)]
pub struct Scene {
    name: Arc<str>,
    obstacles: Objects<Obstacle>,
    attached: Objects<AttachedObject>,
    padding: Table<Arc<str>, f64>,
    scale: Table<Arc<str>, f64>,
    frames: Table<Arc<str>, Pose>,
    subframes: Table<(Arc<str>, Arc<str>), Pose>,
    worlds: Table<Arc<str>, Arc<str>>,
    verdicts: Verdicts,
    of_file: Arc<[Warning]>,
    warnings: OnceLock<Vec<Warning>>,
    /// Ids of what is sensed, for those who ask for each request.
    sensed: OnceLock<Vec<String>>,
    // Kept: every certificate names it.
    hash: u64,
}

/// What a scene is made of, unchecked.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Label.
    pub name: String,
    /// Objects that stand in the world.
    pub obstacles: Vec<Obstacle>,
    /// Objects that links carry.
    pub attached: Vec<AttachedObject>,
    /// Links and objects that count as thicker by this much (m) wherever robot and obstacles meet.
    /// The robot, with what it carries, is checked against itself as it is (so does MoveIt).
    pub padding: BTreeMap<String, f64>,
    /// Links and objects whose shapes count as so many times as large wherever robot and obstacles
    /// meet, each about its own centre; padding comes on top.
    pub scale: BTreeMap<String, f64>,
    /// Poses in the world of named frames, in which poses may be given.
    pub frames: BTreeMap<String, Pose>,
    /// Frames on objects, by the object and their own name, with their poses in the object's frame.
    pub subframes: BTreeMap<(String, String), Pose>,
    /// What the world is called by objects whose poses are given in a frame that the scene does not
    /// know: whatever robot is checked in it has to call the world so.
    pub worlds: BTreeMap<String, String>,
    /// Pairs of names (links or objects) that may touch.
    pub allowed: Vec<(String, String)>,
    /// Pairs of names that are checked whatever allows them to touch.
    pub forbidden: Vec<(String, String)>,
    /// What is odd about the file that it was read from, a line each.
    pub warnings: Vec<Warning>,
}

impl Default for Scene {
    /// No obstacle at all.
    fn default() -> Self {
        Self::of(SceneDescription::default()).expect("nothing can be wrong with no obstacle")
    }
}

impl Scene {
    /// Checks and takes obstacles. `allowed` names pairs (links or objects) that may touch.
    ///
    /// # Errors
    /// As [`Scene::of`].
    pub fn new(
        name: impl Into<String>,
        obstacles: Vec<Obstacle>,
        allowed: Vec<(String, String)>,
        warnings: Vec<Warning>,
    ) -> Result<Self, SceneError> {
        Self::of(SceneDescription {
            name: name.into(),
            obstacles,
            allowed,
            warnings,
            ..SceneDescription::default()
        })
    }

    /// Checks and takes a whole scene. Names of links are checked where scene and robot meet.
    ///
    /// # Errors
    /// A duplicate id, a name of both a frame and an object, a pose that is not finite or not unit,
    /// a padding that is no length, a scale that leaves nothing.
    pub fn of(description: SceneDescription) -> Result<Self, SceneError> {
        let mut scene = Self {
            name: description.name.into(),
            obstacles: Objects::default(),
            attached: Objects::default(),
            padding: Table::default(),
            scale: Table::default(),
            frames: Table::default(),
            subframes: Table::default(),
            worlds: Table::default(),
            verdicts: Verdicts::default(),
            of_file: description.warnings.into(),
            warnings: OnceLock::new(),
            sensed: OnceLock::new(),
            hash: 0,
        };
        for object in description.obstacles {
            scene.add(object)?;
        }
        for object in description.attached {
            scene.add_attached(object)?;
        }
        for (name, padding) in &description.padding {
            scene.pad(name, *padding)?;
        }
        for (name, scale) in &description.scale {
            scene.rescale(name, *scale)?;
        }
        for (name, pose) in &description.frames {
            scene.place_frame(name, Some(*pose))?;
        }
        for ((object, name), pose) in &description.subframes {
            scene.place_subframe(object, name, Some(*pose))?;
        }
        for (id, world) in &description.worlds {
            scene.call_world(id, Some(world))?;
        }
        for (pairs, verdict) in [
            (description.allowed, Verdict::Allowed),
            (description.forbidden, Verdict::Forbidden),
        ] {
            for (a, b) in pairs {
                scene.verdicts.set(&a, &b, Some(verdict));
            }
        }
        Ok(scene.finished())
    }

    /// Label of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Objects that stand in the world.
    pub fn obstacles(&self) -> &Objects<Obstacle> {
        &self.obstacles
    }
    /// All objects, those that stand first.
    pub fn objects(&self) -> impl Iterator<Item = &Obstacle> {
        self.obstacles.iter().chain(
            self.attached
                .iter()
                .map(|attached| &attached.object),
        )
    }
    /// Objects of which nothing is known yet: their sensors have not sent a frame.
    pub fn awaited(&self) -> impl Iterator<Item = &str> {
        let awaited = self
            .sensed()
            .filter(|(_, sensing)| sensing.frame.is_none());
        awaited.map(|(object, _)| object.id.as_str())
    }

    /// Of the frames that it is seen by, the one that was taken first.
    pub fn oldest_frame(&self) -> Option<(&Obstacle, &SensedFrame)> {
        let frames = self
            .sensed()
            .filter_map(|(object, sensing)| Some((object, sensing.frame.as_ref()?)));
        frames.min_by_key(|(_, frame)| frame.taken_ns)
    }

    /// Sensed objects, each with what its sensor saw last.
    pub fn sensed(&self) -> impl Iterator<Item = (&Obstacle, &Sensing)> {
        let ids = self.sensed.get_or_init(|| {
            let sensed = self
                .objects()
                .filter(|object| object.sensed.is_some());
            sensed.map(|object| object.id.clone()).collect()
        });
        let objects = ids.iter().filter_map(|id| self.object(id));
        objects.filter_map(|object| Some((object, object.sensed.as_deref()?)))
    }

    /// Whether a sensor has seen anything of it.
    pub fn has_seen(&self) -> bool {
        self.sensed()
            .any(|(_, sensing)| sensing.frame.is_some())
    }

    /// The scene before any of its sensors has seen anything.
    #[must_use]
    pub fn unseen(&self) -> Self {
        let seen = self
            .sensed()
            .filter(|(_, sensing)| sensing.frame.is_some());
        let blind = seen.map(|(object, _)| SceneChange::Replace(object.unseen()));
        self.with(blind.collect::<Vec<_>>())
            .expect("nothing but sensed shapes goes")
    }

    /// The scene after a frame of a sensed object.
    ///
    /// # Errors
    /// An object that is not sensed.
    pub fn with_frame(
        &self,
        id: &str,
        pose: Pose,
        shapes: Arc<[PlacedShape]>,
        frame: SensedFrame,
    ) -> Result<Self, SceneError> {
        let sensing = self.sensing(id)?;
        let before = sensing.frame.as_ref();
        let seen = Sensing {
            period_ns: before.map_or(0, |before| before.age_ns(frame.taken_ns)),
            frame: Some(frame),
            ..sensing.clone()
        };
        let object = Obstacle {
            shapes,
            ..Obstacle::new(id, Vec::new())
        };
        let object = object.at(pose).sensed_by(seen);
        self.with([SceneChange::Replace(object)])
    }

    /// How an object is sensed.
    ///
    /// # Errors
    /// One that is not.
    pub fn sensing(&self, id: &str) -> Result<&Sensing, SceneError> {
        let object = self.obstacles.get(id);
        let sensing = object.and_then(|object| object.sensed.as_deref());
        sensing.ok_or_else(|| SceneError::NotSensed {
            id: id.to_owned(),
            known: comma_separated(
                self.sensed()
                    .map(|(object, _)| object.id.as_str()),
            ),
        })
    }

    /// An object, wherever it is.
    pub fn object(&self, id: &str) -> Option<&Obstacle> {
        self.obstacles.get(id).or_else(|| {
            self.attached
                .get(id)
                .map(|attached| &attached.object)
        })
    }
    /// Objects that links carry.
    pub fn attached(&self) -> &Objects<AttachedObject> {
        &self.attached
    }
    /// By how much (m) a link or object counts as thicker wherever robot and obstacles meet.
    pub fn padding(&self, name: &str) -> f64 {
        self.padding.get(name).copied().unwrap_or(0.0)
    }
    /// Links and objects that are padded, with their padding (m), by name.
    pub fn padded(&self) -> impl Iterator<Item = (&str, f64)> {
        self.padding
            .iter()
            .map(|(name, padding)| (&**name, *padding))
    }
    /// How many times as large a link's or object's shapes count wherever robot and obstacles meet.
    pub fn scale(&self, name: &str) -> f64 {
        self.scale.get(name).copied().unwrap_or(1.0)
    }
    /// Links and objects that are scaled, with their scale, by name.
    pub fn scaled(&self) -> impl Iterator<Item = (&str, f64)> {
        self.scale
            .iter()
            .map(|(name, scale)| (&**name, *scale))
    }
    /// Named frames with their poses in the world, by name.
    pub fn frames(&self) -> impl Iterator<Item = (&str, &Pose)> {
        self.frames
            .iter()
            .map(|(name, pose)| (&**name, pose))
    }
    /// Frames on objects: the object, their name, and their pose in the object's frame.
    pub fn subframes(&self) -> impl Iterator<Item = (&str, &str, &Pose)> {
        self.subframes
            .iter()
            .map(|((object, name), pose)| (&**object, &**name, pose))
    }
    /// The pose of a frame on an object, in the object's frame.
    pub(crate) fn subframe(&self, object: &str, name: &str) -> Option<&Pose> {
        self.subframes
            .get(&(object.into(), name.into()))
    }
    /// Frames on an object by name, with their poses in its frame.
    pub fn subframes_of(&self, id: &str) -> impl Iterator<Item = (&str, &Pose)> {
        let object = Arc::<str>::from(id);
        let all = self
            .subframes
            .from((object.clone(), "".into()))
            .take_while(move |((held, _), _)| *held == object);
        all.map(|((_, name), pose)| (&**name, pose))
    }
    /// Objects whose poses are given in a frame that the scene does not know, and what that is
    /// called: the robot has to call the world so.
    pub fn worlds(&self) -> impl Iterator<Item = (&str, &str)> {
        self.worlds
            .iter()
            .map(|(id, world)| (&**id, &**world))
    }
    /// What an object's text calls the world, if the scene does not know that name.
    pub fn world_of(&self, id: &str) -> Option<&str> {
        self.worlds.get(id).map(|world| &**world)
    }
    /// Pairs of names (links or objects) that may touch, by name.
    pub fn allowed(&self) -> impl Iterator<Item = (&str, &str)> {
        self.pairs(Verdict::Allowed)
    }
    /// Pairs of names that are checked whatever allows them to touch, by name.
    pub fn forbidden(&self) -> impl Iterator<Item = (&str, &str)> {
        self.pairs(Verdict::Forbidden)
    }

    fn pairs(&self, wanted: Verdict) -> impl Iterator<Item = (&str, &str)> {
        self.verdicts
            .iter()
            .filter(move |(_, _, verdict)| *verdict == wanted)
            .map(|(a, b, _)| (a, b))
    }

    /// The same with more that is odd about the texts that it was made of.
    pub(crate) fn with_warnings(mut self, more: &[Warning]) -> Self {
        let new: Vec<Warning> = more
            .iter()
            .filter(|text| !self.of_file.contains(text))
            .cloned()
            .collect();
        if !new.is_empty() {
            self.of_file = self
                .of_file
                .iter()
                .cloned()
                .chain(new)
                .collect();
            self.warnings = OnceLock::new();
        }
        self
    }

    /// What is odd about its objects and its file, a line each; found when first asked for.
    pub fn warnings(&self) -> &[Warning] {
        self.warnings
            .get_or_init(|| [oddities(self.objects()).as_slice(), &*self.of_file].concat())
    }

    /// The pose in the world of what is given in a frame: the world's (`""` or `world`), a named
    /// one, that of an object which stands, or one on it as `OBJECT/SUBFRAME`. Objects that are
    /// placed by it do not follow when the frame moves later, as in MoveIt.
    ///
    /// # Errors
    /// A frame that is not there; where an attached object is depends on the robot, so it is none.
    pub fn in_world(&self, frame: &str, pose: &Pose) -> Result<Pose, SceneError> {
        match self.known_frame(frame) {
            Some(known) => Ok(frames::product(&known, pose)),
            None if is_world(frame) => Ok(*pose),
            None => Err(self.unknown_frame(frame, &[])),
        }
    }

    /// The refusal of a frame that is not there; the world has `worlds` as its names too.
    pub fn unknown_frame(&self, frame: &str, worlds: &[String]) -> SceneError {
        let worlds: String = worlds
            .iter()
            .map(|world| format!(" or {world:?}"))
            .collect();
        let frames = comma_separated(self.frames().map(|(name, _)| name));
        let objects = comma_separated(
            self.obstacles
                .iter()
                .map(|object| object.id.as_str()),
        );
        let on_objects: Vec<String> = self
            .subframes()
            .map(|(object, name, _)| format!("{object}/{name}"))
            .collect();
        let on_objects = comma_separated(on_objects.iter().map(String::as_str));
        let known = format!("\"\" (the world){worlds}, frames {frames}; objects {objects}");
        let valid = format!("{known}; their sub-frames as OBJECT/SUBFRAME: {on_objects}");
        SceneError::UnknownFrame {
            frame: frame.to_owned(),
            valid,
        }
    }

    /// Whether nothing but poses and shapes of obstacles tells two scenes apart, as far as memory
    /// that they share tells: where it does not, they may still be equal.
    pub(crate) fn lines_up_with(&self, other: &Self) -> bool {
        self.obstacles.lines_up_with(&other.obstacles)
            && self.attached.is(&other.attached)
            && self.padding.is(&other.padding)
            && self.scale.is(&other.scale)
            && self.frames.is(&other.frames)
            && self.worlds.is(&other.worlds)
            && self.verdicts.is(&other.verdicts)
    }

    /// Content hash: equal scenes have equal hashes whatever their label and however they were
    /// made. The order of objects counts, that of anything else does not.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// With its content hash. A scene is a set of facts (an object, which one it follows, a
    /// padding, a pair), and its hash is made of their sums: a change takes its own facts out and
    /// puts its own in.
    fn finished(mut self) -> Self {
        let mut hasher = ContentHasher::default();
        let tables = [
            self.padding.facts(),
            self.scale.facts(),
            self.frames.facts(),
            self.verdicts.facts(),
        ];
        for facts in [self.obstacles.facts(), self.attached.facts()]
            .into_iter()
            .chain(tables)
        {
            hasher.digest(facts.digest());
        }
        // Scenes without them keep the hash that they had before there were any.
        for (name, facts, is_there) in [
            (
                "subframes",
                self.subframes.facts(),
                self.subframes.iter().next().is_some(),
            ),
            (
                "worlds",
                self.worlds.facts(),
                self.worlds.iter().next().is_some(),
            ),
        ] {
            if is_there {
                hasher.name(name).digest(facts.digest());
            }
        }
        self.hash = hasher.finish();
        self
    }
}

/// What is odd about obstacles, a line each; each shape once, however many objects it is used in.
fn oddities<'a>(objects: impl Iterator<Item = &'a Obstacle>) -> Vec<Warning> {
    let mut found = Vec::new();
    // Users of a warning in the order in which it first came up.
    let mut of_shapes: Vec<(&Warning, Vec<&str>)> = Vec::new();
    for obstacle in objects {
        if obstacle.shapes.is_empty() && obstacle.sensed.is_none() {
            let text = format!(
                "object {:?} has no shapes; nothing can collide with it",
                obstacle.id
            );
            found.push(Warning::uncovered(text));
        }
        let shapes = obstacle.shapes.iter();
        for warning in shapes.flat_map(|placed| placed.shape.warnings()) {
            match of_shapes
                .iter_mut()
                .find(|(known, _)| *known == warning)
            {
                Some((_, users)) if users.contains(&obstacle.id.as_str()) => {}
                Some((_, users)) => users.push(&obstacle.id),
                None => of_shapes.push((warning, vec![&obstacle.id])),
            }
        }
    }
    found.extend(
        of_shapes
            .into_iter()
            .map(|(warning, users)| match users.as_slice() {
                [user] => warning.reworded(format!("object {user:?}: {warning}")),
                users => warning.reworded(format!(
                    "object {:?} and {} more: {warning}",
                    users[0],
                    users.len() - 1
                )),
            }),
    );
    found
}

/// Names for a message, cut where there are many.
fn comma_separated<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 20;
    let names: Vec<_> = names.collect();
    match names.len() {
        0 => "none".to_owned(),
        1..=MOST => names.join(", "),
        count => format!("{}, … ({count} in all)", names[..MOST].join(", ")),
    }
}
