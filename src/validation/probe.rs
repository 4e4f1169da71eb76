//! What the tests of the bound ask a validator: what the filter sees of a segment, and what one
//! pair keeps.

use super::Validator;
use super::filter::{Proving, ProvingCurves};
use super::polynomial::Polynomial;
use super::undecided::{Interval, List};
use super::way::Way;
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
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        examiner.add([from, to].into());
        examiner.run(&demand, Proving, intervals, u8::MAX, true);
        self.seen_by_filter()
    }

    /// The same of eight intervals of a curve.
    pub(crate) fn filtered_curve(
        &mut self,
        columns: &[Polynomial],
        intervals: [LaneInterval; LANES],
    ) -> (Vec<(u32, u8)>, [f32; LANES]) {
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        examiner.add(Way::Curved(columns));
        examiner.fill_with_curves(&intervals.map(|lane| on_curve((lane.middle, lane.half))));
        examiner.run(&demand, ProvingCurves, intervals, u8::MAX, true);
        self.seen_by_filter()
    }

    fn seen_by_filter(&self) -> (Vec<(u32, u8)>, [f32; LANES]) {
        let filter = &self.examiner.scratch.filter;
        let unproved = filter.unproved.iter();
        (
            unproved
                .map(|unproved| (unproved.pair, unproved.lanes))
                .collect(),
            filter.kept,
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
        self.examiner.scratch.filter.frames().to_vec()
    }

    /// Margin for the size of the values of the last segment (m).
    pub(crate) fn rounding_of_values(&self) -> f32 {
        self.examiner.scratch.segments.lanes.rounding(0)
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
        self.examiner.stand(from, to, middle);
        self.bound_where_placed(half, pair)
    }

    /// The same on an interval of a curve.
    pub(crate) fn closest_bound_on_curve(
        &mut self,
        columns: &[Polynomial],
        (middle, half): (f64, f64),
        pair: usize,
    ) -> Option<(f64, f64, f64)> {
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        examiner.add(Way::Curved(columns));
        examiner.place(&on_curve((middle, half)));
        self.bound_where_placed(half, pair)
    }

    fn bound_where_placed(&self, half: f64, pair: usize) -> Option<(f64, f64, f64)> {
        let floor = self.floors.clearances()[pair];
        let model = self.model();
        let interval =
            self.examiner
                .scratch
                .motion
                .pair_interval(model, &model.pairs()[pair], half, floor);
        let (gap, displacement) = interval.weakest_pieces()?;
        let wholes = interval
            .direction_of_wholes()
            .map(|normal| interval.kept_by_wholes(normal));
        Some((gap, displacement, wholes.unwrap_or(f64::NEG_INFINITY)))
    }
}

/// An interval of the only segment.
fn on_curve((middle, half): (f64, f64)) -> Interval {
    Interval {
        segment: 0,
        middle,
        half,
        pairs: List::All,
    }
}
