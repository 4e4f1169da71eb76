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
        if self
            .carried_bodies()
            .iter()
            .any(|body| body.kind == BodyKind::Link)
        {
            return None;
        }
        let checked = match self.checked_pairs() {
            0 => "nothing is checked".to_owned(),
            1 => "only what it carries is checked (1 pair)".to_owned(),
            pairs => format!("only what it carries is checked ({pairs} pairs)"),
        };
        let next = "give its links <collision> shapes";
        Some(format!(
            "no link of robot {} has collision geometry: {checked}; {next}",
            self.robot().name()
        ))
    }

    /// What a proof about this robot and scene does not cover, besides what their files already
    /// told.
    pub fn uncovered(&self) -> Vec<Warning> {
        let moves = self.carried_bodies().iter().any(|body| {
            body.chain
                .iter()
                .any(|motion| motion.coordinate.is_some())
        });
        if moves || self.uncheckable().is_some() || self.robot().variables().is_empty() {
            return Vec::new();
        }
        let text = "no link that a joint of the path moves has collision geometry: only what stands still is checked";
        vec![Warning::uncovered(text)]
    }
}
