//! The check that others make: configurations along the path, none in between. It proves nothing;
//! it is here to be compared with, on the same kernels.

use super::continuous::Validator;
use super::filter::Sampling;
use crate::lanes::LANES;
use crate::path::Path;
use crate::robot::lane_kinematics::LaneInterval;

impl Validator<'_> {
    /// Whether the filter sees every configuration free that lies `step` (rad of joint-space
    /// motion; translations are divided by the robot's reach) or less after the one before; eight
    /// at a time, and no further than the first eight of which one is not free.
    ///
    /// For robots and scenes of balls, boxes and capsules that is the whole of a sampled check.
    pub fn samples_are_free(&mut self, path: &Path, step: f64) -> bool {
        self.begin();
        let mut intervals = [LaneInterval::default(); LANES];
        let mut count = 0;
        for segment in 1..path.len() {
            let motion = self.add(path.waypoint(segment - 1), path.waypoint(segment));
            let samples = (motion / step).ceil().max(1.0);
            for sample in 0..samples as usize {
                let middle = (sample + 1) as f64 / samples;
                intervals[count] = LaneInterval {
                    segment: segment - 1,
                    middle,
                    half: 0.0,
                };
                count += 1;
                if count == LANES {
                    if !self.batch_is_free(intervals) {
                        return false;
                    }
                    count = 0;
                }
            }
        }
        intervals[count..].fill(LaneInterval::default());
        self.batch_is_free(intervals)
    }

    fn batch_is_free(&mut self, intervals: [LaneInterval; LANES]) -> bool {
        self.run(Sampling, intervals, u8::MAX, true);
        self.scratch.filter.unproved.is_empty()
    }
}
