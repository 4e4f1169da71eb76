//! What a store begins with: contents whose versions were counted before.

use std::sync::Arc;

use super::{ModelStore, SceneEntry, StoreError};
use crate::scene::Scene;

impl ModelStore {
    /// Takes a scene under a label as it was before: as this version, from which the next changes count on.
    ///
    /// # Errors
    /// [`StoreError::LabelTaken`] if the label names other content already; [`StoreError::SameId`] if another
    /// label has the same id.
    pub fn restore_scene(&mut self, label: &str, version: u64, scene: Arc<Scene>) -> Result<(), StoreError> {
        let id = self.take_id(label)?;
        if let Some(held) = self.scenes.get(label)
            && held.scene.hash() != scene.hash()
        {
            return Err(StoreError::taken("scene", label, held.scene.hash(), scene.hash()));
        }
        self.scenes.insert(label.to_owned(), SceneEntry { id, version, scene });
        Ok(())
    }
}
