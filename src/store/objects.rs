//! The solids of a scene's objects, which every robot in it shares.

use std::sync::{Arc, OnceLock};

use crate::collision::{Count, Solids};
use crate::scene::Scene;

/// A scene and the solids of its objects, made when somebody first needs them.
#[derive(Debug)]
pub struct PreparedScene {
    scene: Arc<Scene>,
    solids: OnceLock<Arc<Solids>>,
    /// Those of the version before, of which what stays is taken over.
    earlier: Option<Arc<Solids>>,
}

impl PreparedScene {
    /// A scene that nothing is made of yet.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self {
            scene,
            solids: OnceLock::new(),
            earlier: None,
        }
    }

    /// A later version of a scene. It holds the solids of one earlier version at most, however many
    /// versions follow each other.
    pub fn after(previous: &Self, scene: Arc<Scene>) -> Self {
        let ready = previous.solids.get();
        Self {
            earlier: ready.or(previous.earlier.as_ref()).cloned(),
            ..Self::new(scene)
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The solids.
    pub fn solids(&self) -> &Arc<Solids> {
        self.solids.get_or_init(|| {
            let earlier = self.earlier.as_deref();
            Arc::new(Solids::of_objects(&self.scene, earlier))
        })
    }

    /// Whether the solids are made.
    pub fn is_ready(&self) -> bool {
        self.solids.get().is_some()
    }

    /// Whether neither its solids nor those of an earlier version are made.
    pub fn is_bare(&self) -> bool {
        !self.is_ready() && self.earlier.is_none()
    }

    /// What the solids are made of.
    pub fn count(&self) -> Count {
        Count::of(
            self.scene
                .objects()
                .map(|object| &*object.shapes),
        )
    }

    /// What the solids are made of that neither this version nor an earlier one has.
    pub fn missing(&self) -> Count {
        let made = self.made();
        let objects = self
            .scene
            .objects()
            .map(|object| &object.shapes);
        let missing = objects.filter(|shapes| !made.is_some_and(|made| made.has(shapes)));
        Count::of(missing.map(|shapes| &**shapes))
    }

    fn made(&self) -> Option<&Arc<Solids>> {
        self.solids.get().or(self.earlier.as_ref())
    }

    /// Memory of meshes and solids as far as they are made (bytes).
    pub fn bytes(&self) -> usize {
        let solids = self.made().map_or(0, |made| made.bytes());
        self.count().mesh_bytes + solids
    }
}
