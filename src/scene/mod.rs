//! Scenes: obstacles in the world, objects that links carry, padding, and the pairs that may touch. Knows no robot.

mod change;
mod error;
pub mod moveit_scene;
mod object;
pub mod scene_file;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use crate::hash::ContentHasher;
use crate::math::Pose;
use crate::shape::Shape;
pub use change::SceneChange;
pub use error::SceneError;
pub use object::{AttachedObject, Obstacle};

/// A scene, checked once when built and never changed: [`Scene::with`] makes another one.
#[derive(Clone, Debug)]
pub struct Scene {
    description: SceneDescription,
    warnings: Vec<String>,
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
    /// Links and objects that count as thicker by this much (m) wherever robot and obstacles meet. The robot, with
    /// what it carries, is checked against itself as it is (so does MoveIt).
    pub padding: BTreeMap<String, f64>,
    /// Pairs of names (links or objects) that may touch.
    pub allowed: Vec<(String, String)>,
    /// Pairs of names that are checked whatever allows them to touch.
    pub forbidden: Vec<(String, String)>,
    /// What is odd about the file that it was read from, a line each.
    pub warnings: Vec<String>,
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
        warnings: Vec<String>,
    ) -> Result<Self, SceneError> {
        Self::of(SceneDescription { name: name.into(), obstacles, allowed, warnings, ..SceneDescription::default() })
    }

    /// Checks and takes a whole scene. Names of links are checked where scene and robot meet.
    ///
    /// # Errors
    /// A duplicate id, a pose that is not finite or not unit, a padding that is no length.
    pub fn of(mut description: SceneDescription) -> Result<Self, SceneError> {
        let mut seen = BTreeSet::new();
        for object in description.objects() {
            if !seen.insert(object.id.as_str()) {
                return Err(SceneError::Duplicate(object.id.clone()));
            }
            object.check()?;
        }
        if let Some((name, &value)) = description.padding.iter().find(|(_, value)| !value.is_finite() || **value < 0.0)
        {
            return Err(SceneError::BadPadding { name: name.clone(), value });
        }
        description.padding.retain(|_, value| *value != 0.0);
        let hash = description.content_hash();
        let warnings = [oddities(description.objects()), description.warnings.clone()].concat();
        Ok(Self { description, warnings, hash })
    }

    /// Label of the scene.
    pub fn name(&self) -> &str {
        &self.description.name
    }
    /// Objects that stand in the world.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.description.obstacles
    }
    /// All objects, those that stand first.
    pub fn objects(&self) -> impl Iterator<Item = &Obstacle> {
        self.description.objects()
    }
    /// Objects that links carry.
    pub fn attached(&self) -> &[AttachedObject] {
        &self.description.attached
    }
    /// By how much (m) a link or object counts as thicker wherever robot and obstacles meet.
    pub fn padding(&self, name: &str) -> f64 {
        self.description.padding.get(name).copied().unwrap_or(0.0)
    }
    /// Links and objects that are padded, with their padding (m).
    pub fn padded(&self) -> &BTreeMap<String, f64> {
        &self.description.padding
    }
    /// Pairs of names (links or objects) that may touch.
    pub fn allowed(&self) -> &[(String, String)] {
        &self.description.allowed
    }
    /// Pairs of names that are checked whatever allows them to touch.
    pub fn forbidden(&self) -> &[(String, String)] {
        &self.description.forbidden
    }
    /// What is odd about its objects and its file, a line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Content hash: equal scenes have equal hashes whatever their label.
    pub fn hash(&self) -> u64 {
        self.hash
    }
}

/// What is odd about obstacles, a line each; each mesh once, however many objects it is used in.
fn oddities<'a>(objects: impl Iterator<Item = &'a Obstacle>) -> Vec<String> {
    let mut found = Vec::new();
    // Users of a warning in the order in which it first came up.
    let mut of_meshes: Vec<(&str, Vec<&str>)> = Vec::new();
    for obstacle in objects {
        if obstacle.shapes.is_empty() {
            found.push(format!("object {:?} has no shapes; nothing can collide with it", obstacle.id));
        }
        let meshes = obstacle.shapes.iter().filter_map(|placed| match &placed.shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        });
        for warning in meshes.flat_map(|mesh| mesh.warnings()) {
            match of_meshes.iter_mut().find(|(text, _)| text == warning) {
                Some((_, users)) if users.contains(&obstacle.id.as_str()) => {}
                Some((_, users)) => users.push(&obstacle.id),
                None => of_meshes.push((warning, vec![&obstacle.id])),
            }
        }
    }
    found.extend(of_meshes.into_iter().map(|(text, users)| match users.as_slice() {
        [user] => format!("object {user:?}: {text}"),
        users => format!("object {:?} and {} more: {text}", users[0], users.len() - 1),
    }));
    found
}

impl SceneDescription {
    /// All objects, those that stand first.
    pub fn objects(&self) -> impl Iterator<Item = &Obstacle> {
        self.obstacles.iter().chain(self.attached.iter().map(|attached| &attached.object))
    }

    /// What a scene does not have adds nothing, so that its hash does not depend on what others have.
    fn content_hash(&self) -> u64 {
        let mut hasher = ContentHasher::default();
        for obstacle in &self.obstacles {
            hash_object(&mut hasher, obstacle);
        }
        hash_pairs(&mut hasher, &self.allowed);
        if !self.attached.is_empty() {
            hasher.text("attached").count(self.attached.len());
        }
        for AttachedObject { link_name, object, touch_links } in &self.attached {
            hasher.text(link_name).count(touch_links.len());
            touch_links.iter().for_each(|name| {
                hasher.text(name);
            });
            hash_object(&mut hasher, object);
        }
        if !self.padding.is_empty() {
            hasher.text("padding").count(self.padding.len());
        }
        for (name, padding) in &self.padding {
            hasher.text(name).floats(&[*padding]);
        }
        if !self.forbidden.is_empty() {
            hasher.text("forbidden").count(self.forbidden.len());
        }
        hash_pairs(&mut hasher, &self.forbidden);
        hasher.finish()
    }
}

fn hash_object(hasher: &mut ContentHasher, object: &Obstacle) {
    hasher.text(&object.id);
    if object.pose != Pose::identity() {
        hasher.text("pose").pose(&object.pose);
    }
    for shape in object.shapes.iter() {
        hasher.shape(shape);
    }
}

fn hash_pairs(hasher: &mut ContentHasher, pairs: &[(String, String)]) {
    for (a, b) in pairs {
        hasher.text(a).text(b);
    }
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
