//! What the tests of the bound ask a validator: what the filter sees of a segment, and what one
//! pair keeps.

use super::Validator;
use super::filter::Proving;
use crate::lanes::LANES;
use crate::robot::lane_kinematics::LaneInterval;

impl Validator<'_> {
    /// What the filter leaves undecided of eight intervals of a segment, and what the rest keeps in
    /// each lane.
    pub(crate) fn filtered(
        &mut self,
        from: &[f64],
        to: &[f64],
        intervals: [LaneInterval; LANES],
    ) -> (Vec<(u32, u8)>, [f32; LANES]) {
        self.begin();
        self.add(from, to);
        self.run(Proving, intervals, u8::MAX, true);
        let unproved = &self.scratch.filter.unproved;
        (
            unproved
                .iter()
                .map(|unproved| (unproved.pair, unproved.lanes))
                .collect(),
            self.scratch.filter.kept,
        )
    }

    /// Where the filter sees the frames on eight intervals of a segment.
    pub(crate) fn filtered_frames(
        &mut self,
        from: &[f64],
        to: &[f64],
        intervals: [LaneInterval; LANES],
    ) -> Vec<crate::robot::lane_kinematics::LaneFrame> {
        self.filtered(from, to, intervals);
        self.scratch.filter.frames().to_vec()
    }

    /// Margin for the size of the values of the last segment (m).
    pub(crate) fn rounding_of_values(&self) -> f32 {
        self.scratch.segments.lanes.rounding(0)
    }

    /// Support gap and displacement bound of the closest pieces of a pair on one interval, and what
    /// its bodies keep as wholes, for the tests of the bound; `None` where the pieces are too close
    /// for a direction.
    pub(crate) fn closest_bound(
        &mut self,
        from: &[f64],
        to: &[f64],
        middle: f64,
        half: f64,
        pair: usize,
    ) -> Option<(f64, f64, f64)> {
        self.stand(from, to, middle);
        let floor = self.floors()[pair];
        let pair = &self.model.pairs()[pair];
        let interval = self
            .scratch
            .motion
            .pair_interval(self.model, pair, half, floor);
        let (gap, displacement) = interval.weakest_pieces()?;
        let wholes = interval
            .direction_of_wholes()
            .map(|normal| interval.kept_by_wholes(normal));
        Some((gap, displacement, wholes.unwrap_or(f64::NEG_INFINITY)))
    }
}
