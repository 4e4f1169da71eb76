//! Scenes: obstacles in the world, and the pairs that may touch. Knows no robot.

pub mod moveit_scene;
pub mod scene_file;

use std::collections::BTreeSet;

use crate::hash::ContentHasher;
use crate::shape::{PlacedShape, Shape};

/// Obstacles and allowed pairs, checked once when built.
#[derive(Clone, Debug)]
pub struct Scene {
    name: String,
    obstacles: Vec<Obstacle>,
    allowed: Vec<(String, String)>,
    warnings: Vec<String>,
    // Kept: every certificate names it, and large meshes take milliseconds.
    hash: u64,
}

impl Default for Scene {
    /// No obstacle at all.
    fn default() -> Self {
        Self::new("", Vec::new(), Vec::new(), Vec::new()).expect("nothing can be wrong with no obstacle")
    }
}

/// A solid object of the scene, made of one shape or several (MoveIt's collision object).
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name, unique in the scene.
    pub id: String,
    /// Its shapes, in the world's frame.
    pub shapes: Vec<PlacedShape>,
}

/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Two objects of one name.
    #[error("object {0:?} is defined twice; object ids must be unique")]
    Duplicate(String),
    /// A pose that is no pose.
    #[error("object {id:?}: {what} is {value}; {rule}")]
    BadPose {
        /// Object.
        id: String,
        /// Position or orientation.
        what: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// A size that no solid has.
    #[error("object {id:?}: {source}")]
    Shape {
        /// Object.
        id: String,
        /// What is wrong.
        source: crate::shape::ShapeError,
    },
    /// A mesh that cannot be used.
    #[error("object {id:?}: {source}")]
    Mesh {
        /// Object.
        id: String,
        /// What is wrong.
        source: crate::shape::MeshError,
    },
    /// A text that is not the format it should be, with line and column where known.
    #[error("{0}")]
    Syntax(String),
}

impl Scene {
    /// Checks and takes obstacles. `allowed` names pairs (links or objects) that may touch.
    ///
    /// # Errors
    /// A duplicate id or a pose that is not finite.
    pub fn new(
        name: impl Into<String>,
        obstacles: Vec<Obstacle>,
        allowed: Vec<(String, String)>,
        warnings: Vec<String>,
    ) -> Result<Self, SceneError> {
        let mut seen = BTreeSet::new();
        for obstacle in &obstacles {
            if !seen.insert(obstacle.id.as_str()) {
                return Err(SceneError::Duplicate(obstacle.id.clone()));
            }
            if let Some(bad) = obstacle.shapes.iter().find(|s| !s.pose.is_finite()) {
                return Err(SceneError::BadPose {
                    id: obstacle.id.clone(),
                    what: "pose",
                    value: format!("{:?}", bad.pose),
                    rule: "it must be finite",
                });
            }
        }
        let hash = content_hash(&obstacles, &allowed);
        Ok(Self { name: name.into(), obstacles, allowed, warnings, hash })
    }

    /// Label of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// The obstacles.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }
    /// Pairs of names (links or objects) that may touch.
    pub fn allowed(&self) -> &[(String, String)] {
        &self.allowed
    }
    /// What is odd about the file, a line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Content hash: equal scenes have equal hashes whatever their label.
    pub fn hash(&self) -> u64 {
        self.hash
    }
}

/// What is odd about obstacles, a line each; each mesh once, however many objects it is used in.
fn oddities(obstacles: &[Obstacle]) -> Vec<String> {
    let mut found = Vec::new();
    // Users of a warning in the order in which it first came up.
    let mut of_meshes: Vec<(&str, Vec<&str>)> = Vec::new();
    for obstacle in obstacles {
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

fn content_hash(obstacles: &[Obstacle], allowed: &[(String, String)]) -> u64 {
    let mut hasher = ContentHasher::default();
    for obstacle in obstacles {
        hasher.text(&obstacle.id);
        for shape in &obstacle.shapes {
            hasher.shape(shape);
        }
    }
    for (a, b) in allowed {
        hasher.text(a).text(b);
    }
    hasher.finish()
}
