//! What an answer keeps besides clearance.

use crate::wire::{KeptRecord, RequirementKind, ResponseView, Unit, WireError};

/// What a proved path keeps of one constraint, of its tolerance as it is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// What kind of thing it is.
    pub kind: RequirementKind,
    /// What messages call it.
    pub name: String,
    /// The tolerance, where one number says it: then what is read of the path, such as an angle, is
    /// proved to be `asked − left` at most.
    pub asked: Option<f64>,
    /// What is proved to be left everywhere along the path; below 0 where the tolerance is raised and
    /// that is needed.
    pub left: f64,
    /// The least that was found to be left: a look, no proof.
    pub found: f64,
    /// What these are counted in.
    pub unit: Unit,
    /// Segment on which it was found, from 0.
    pub segment: u32,
    /// Ratio on the segment, 0 to 1.
    pub t: f64,
}

impl Kept {
    /// Those of a response, in the order of the constraints.
    pub(super) fn of_view(view: &ResponseView<'_>) -> Result<Vec<Self>, WireError> {
        let records = view.keeps.iter();
        records
            .map(|record| Self::of(record, view))
            .collect()
    }

    fn of(record: &KeptRecord, view: &ResponseView<'_>) -> Result<Self, WireError> {
        let tightest = &record.tightest;
        let requirement = &tightest.requirement;
        Ok(Self {
            kind: RequirementKind::try_from(requirement.kind)?,
            name: requirement.names(view.names)?.concat(),
            asked: Some(record.asked).filter(|asked| *asked > 0.0),
            left: record.left,
            found: tightest.amount,
            unit: Unit::try_from(requirement.unit)?,
            segment: tightest.segment,
            t: tightest.t,
        })
    }
}
