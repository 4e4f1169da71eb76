//! A request, as what makes its answer sees it.

use super::input::Input;
use super::settings::Settings;
use crate::collision::CollisionModel;
use crate::path::Path;

/// What the caller gave, and the form of it that optimizers work on.
#[derive(Clone, Copy)]
pub(super) struct Question<'q> {
    pub model: &'q CollisionModel,
    /// The caller's waypoints.
    pub path: &'q Path,
    pub settings: &'q Settings,
    pub input: &'q Input,
}
