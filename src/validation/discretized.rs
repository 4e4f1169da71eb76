//! The check that others make: configurations along the path, none in between. It proves nothing;
//! it is here to be compared with, on the same kernels.

use super::demand::Demand;
use super::examiner::Examiner;
use super::filter::Sampling;
use super::validator::Validator;
use crate::lanes::LANES;
use crate::path::Path;
use crate::robot::lane_kinematics::LaneInterval;

/// Evenly spaced instants of a segment with this motion, no two farther apart than `step`, up to
/// its end.
fn samples(segment: usize, motion: f64, step: f64) -> impl Iterator<Item = LaneInterval> {
    let count = (motion / step).ceil().max(1.0);
    (0..count as usize).map(move |sample| LaneInterval {
        segment,
        middle: (sample + 1) as f64 / count,
        half: 0.0,
    })
}

impl Validator<'_> {
    /// Whether the filter sees every configuration free that lies `step` (rad of joint-space
    /// motion; translations are divided by the robot's reach) or less after the one before; eight
    /// at a time, and no further than the first eight of which one is not free.
    ///
    /// For robots and scenes of balls, boxes and capsules that is the whole of a sampled check.
    pub fn samples_are_free(&mut self, path: &Path, step: f64) -> bool {
        let (examiner, mut demand) = self.at_floors();
        examiner.begin(&mut demand);
        let mut batch = Vec::with_capacity(LANES);
        for segment in 1..path.len() {
            let motion = examiner.add([path.waypoint(segment - 1), path.waypoint(segment)].into());
            for sample in samples(segment - 1, motion, step) {
                batch.push(sample);
                if batch.len() == LANES && !examiner.batch_is_free(&demand, &mut batch) {
                    return false;
                }
            }
        }
        examiner.batch_is_free(&demand, &mut batch)
    }
}

impl Examiner<'_> {
    /// Looks at up to eight samples, and takes them out.
    fn batch_is_free(&mut self, demand: &Demand, batch: &mut Vec<LaneInterval>) -> bool {
        // Lanes that are left look at the start of the path once more.
        batch.resize(LANES, LaneInterval::default());
        let intervals = std::array::from_fn(|lane| batch[lane]);
        batch.clear();
        self.run(demand, Sampling, intervals, u8::MAX, true);
        self.scratch.filter.unproved.is_empty()
    }
}
