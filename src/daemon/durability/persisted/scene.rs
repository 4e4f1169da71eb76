//! Scenes.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use taut::math::Pose;
use taut::scene::{AttachedObject, Obstacle, Scene, SceneDescription, SensedFrame, Sensing};

use super::apart::Find;
use super::moves::Moves;
use super::plain::{PoseRecord, WarningRecord};
use super::shape::{ShapeRecord, records, restored};

#[derive(Clone, Debug, Serialize, Deserialize)]
struct ObjectRecord {
    id: String,
    pose: PoseRecord,
    shapes: Vec<ShapeRecord>,
    sensed: Option<SensingRecord>,
}

/// Where a shape comes from a sensor; the shape is kept by who needs it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SensingRecord {
    radius_m: f64,
    thin_m: f64,
    self_padding_m: f64,
    frame: Option<FrameRecord>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct FrameRecord {
    taken_ns: u64,
    came: u32,
    not_finite: u32,
    on_robot: u32,
    in_padding: u32,
    thinned: u32,
    points: u32,
}

impl From<&Obstacle> for ObjectRecord {
    fn from(object: &Obstacle) -> Self {
        Self {
            id: object.id.clone(),
            pose: object.pose.into(),
            shapes: records(object.shapes.iter()),
            sensed: object
                .sensed
                .as_deref()
                .map(SensingRecord::from),
        }
    }
}

impl ObjectRecord {
    fn restore(self, find: &mut dyn Find) -> Result<Obstacle, String> {
        Ok(Obstacle {
            id: self.id,
            pose: self.pose.into(),
            shapes: restored(&self.shapes, find)?.into(),
            sensed: self
                .sensed
                .map(|record| Arc::new(record.into())),
        })
    }
}

impl From<&Sensing> for SensingRecord {
    fn from(sensing: &Sensing) -> Self {
        let Sensing {
            radius_m,
            thin_m,
            self_padding_m,
            frame,
            period_ns: _,
        } = sensing;
        Self {
            radius_m: *radius_m,
            thin_m: *thin_m,
            self_padding_m: *self_padding_m,
            frame: frame.map(FrameRecord::from),
        }
    }
}

impl From<SensingRecord> for Sensing {
    fn from(record: SensingRecord) -> Self {
        Self {
            radius_m: record.radius_m,
            thin_m: record.thin_m,
            self_padding_m: record.self_padding_m,
            frame: record.frame.map(SensedFrame::from),
            period_ns: 0,
        }
    }
}

/// Both have the same fields.
macro_rules! frames {
    ($from:ident, $to:ident) => {
        impl From<$from> for $to {
            fn from(frame: $from) -> Self {
                let $from {
                    taken_ns,
                    came,
                    not_finite,
                    on_robot,
                    in_padding,
                    thinned,
                    points,
                } = frame;
                Self {
                    taken_ns,
                    came,
                    not_finite,
                    on_robot,
                    in_padding,
                    thinned,
                    points,
                }
            }
        }
    };
}

frames!(SensedFrame, FrameRecord);
frames!(FrameRecord, SensedFrame);

#[derive(Clone, Debug, Serialize, Deserialize)]
struct AttachedRecord {
    link_name: String,
    object: ObjectRecord,
    touch_links: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SceneRecord {
    name: String,
    obstacles: Vec<ObjectRecord>,
    attached: Vec<AttachedRecord>,
    padding: BTreeMap<String, f64>,
    scale: BTreeMap<String, f64>,
    frames: BTreeMap<String, PoseRecord>,
    subframes: BTreeMap<(String, String), PoseRecord>,
    worlds: BTreeMap<String, String>,
    allowed: Vec<(String, String)>,
    forbidden: Vec<(String, String)>,
    /// All warnings of the scene.
    found: Vec<WarningRecord>,
}

impl From<&Scene> for SceneRecord {
    fn from(scene: &Scene) -> Self {
        Self {
            name: scene.name().to_owned(),
            obstacles: scene
                .obstacles()
                .iter()
                .map(ObjectRecord::from)
                .collect(),
            attached: scene
                .attached()
                .iter()
                .map(AttachedRecord::from)
                .collect(),
            padding: scene.padded().map(named).collect(),
            scale: scene.scaled().map(named).collect(),
            frames: scene.frames().map(framed).collect(),
            subframes: scene.subframes().map(subframed).collect(),
            worlds: scene.worlds().map(pair).collect(),
            allowed: scene.allowed().map(pair).collect(),
            forbidden: scene.forbidden().map(pair).collect(),
            found: WarningRecord::all(scene.warnings()),
        }
    }
}

impl From<&AttachedObject> for AttachedRecord {
    fn from(attached: &AttachedObject) -> Self {
        let AttachedObject {
            link_name,
            object,
            touch_links,
        } = attached;
        Self {
            link_name: link_name.clone(),
            object: ObjectRecord::from(object),
            touch_links: touch_links.clone(),
        }
    }
}

impl AttachedRecord {
    fn restore(self, find: &mut dyn Find) -> Result<AttachedObject, String> {
        Ok(AttachedObject {
            link_name: self.link_name,
            object: self.object.restore(find)?,
            touch_links: self.touch_links,
        })
    }
}

impl SceneRecord {
    /// Puts objects elsewhere.
    ///
    /// # Errors
    /// An object that is not there.
    pub fn apply(&mut self, moves: &Moves) -> Result<(), String> {
        let mut objects = self.objects();
        for &(index, pose) in moves {
            let object = objects.get_mut(index as usize);
            object.ok_or_else(|| no_object(index))?.pose = pose;
        }
        Ok(())
    }

    /// All objects, those that stand first.
    fn objects(&mut self) -> Vec<&mut ObjectRecord> {
        let attached = self.attached.iter_mut();
        let attached = attached.map(|attached| &mut attached.object);
        self.obstacles
            .iter_mut()
            .chain(attached)
            .collect()
    }

    /// The scene, checked as when it was first made.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn restore(mut self, find: &mut dyn Find) -> Result<Scene, String> {
        let found = WarningRecord::restored(std::mem::take(&mut self.found));
        let mut description = self.description(find)?;
        let scene = made(description.clone())?;
        let known = scene.warnings();
        let more = found
            .into_iter()
            .filter(|found| !known.contains(found));
        description.warnings = more.collect();
        match description.warnings.is_empty() {
            true => Ok(scene),
            false => made(description),
        }
    }

    fn description(self, find: &mut dyn Find) -> Result<SceneDescription, String> {
        let obstacles = self.obstacles.into_iter();
        let obstacles = obstacles.map(|object| object.restore(find));
        let obstacles = obstacles.collect::<Result<_, String>>()?;
        let attached = self.attached.into_iter();
        let attached = attached.map(|attached| attached.restore(find));
        Ok(SceneDescription {
            name: self.name,
            obstacles,
            attached: attached.collect::<Result<_, String>>()?,
            padding: self.padding,
            scale: self.scale,
            frames: placed(self.frames),
            subframes: placed(self.subframes),
            worlds: self.worlds,
            allowed: self.allowed,
            forbidden: self.forbidden,
            warnings: Vec::new(),
        })
    }
}

fn made(description: SceneDescription) -> Result<Scene, String> {
    Scene::of(description).map_err(|error| error.to_string())
}

fn placed<K: Ord>(records: BTreeMap<K, PoseRecord>) -> BTreeMap<K, Pose> {
    let poses = records.into_iter();
    poses
        .map(|(key, record)| (key, record.into()))
        .collect()
}

fn named<T>((name, value): (&str, T)) -> (String, T) {
    (name.to_owned(), value)
}

fn pair((a, b): (&str, &str)) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

fn framed((name, pose): (&str, &Pose)) -> (String, PoseRecord) {
    (name.to_owned(), PoseRecord::from(*pose))
}

fn subframed((object, name, pose): (&str, &str, &Pose)) -> ((String, String), PoseRecord) {
    (pair((object, name)), PoseRecord::from(*pose))
}

fn no_object(index: u32) -> String {
    format!("object number {index} moves, there is none")
}
