//! What a verdict about a robot in a scene can say at all.

use super::body::BodyKind;
use super::model::CollisionModel;
use crate::warning::Warning;

impl CollisionModel {
    /// Pairs of bodies that are checked: those that joints move against each other, and those that
    /// stand still.
    pub fn checked_pairs(&self) -> usize {
        self.pairs().len() + self.static_pairs().len()
    }

    /// Why nothing is proved, whatever the path: no link of the robot has a shape. What such a
    /// robot carries may still be found colliding, but that it is not says nothing of the robot.
    pub fn uncheckable(&self) -> Option<String> {
        if self.has_link_geometry() {
            return None;
        }
        Some(format!(
            "no link of robot {} has collision geometry: {}; give its links <collision> shapes",
            self.robot().name(),
            self.what_is_checked()
        ))
    }

    fn has_link_geometry(&self) -> bool {
        let bodies = self.carried_bodies();
        bodies
            .iter()
            .any(|body| body.kind == BodyKind::Link)
    }

    fn what_is_checked(&self) -> String {
        match self.checked_pairs() {
            0 => "nothing is checked".to_owned(),
            1 => "only what it carries is checked (1 pair)".to_owned(),
            pairs => format!("only what it carries is checked ({pairs} pairs)"),
        }
    }

    /// What a proof about this robot and scene does not cover, besides what their files already
    /// told.
    pub fn uncovered(&self) -> Vec<Warning> {
        if self.moves_geometry()
            || self.uncheckable().is_some()
            || self.robot().variables().is_empty()
        {
            return Vec::new();
        }
        let text = "no link that a joint of the path moves has collision geometry: only what stands still is checked";
        vec![Warning::uncovered(text)]
    }

    /// Whether a joint of the path moves any body.
    fn moves_geometry(&self) -> bool {
        let bodies = self.carried_bodies().iter();
        let mut motions = bodies.flat_map(|body| &body.chain);
        motions.any(|motion| motion.coordinate.is_some())
    }
}
