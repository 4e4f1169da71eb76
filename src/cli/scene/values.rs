//! Values on the command line of `taut scene`.

use taut::math::{Quat, Vec3};
use taut_ipc::planner::words;

use crate::cli::error::CliError;

/// A pose on the command line.
#[derive(clap::Args)]
pub(super) struct Pose {
    /// x y z (m), or x y z qx qy qz qw
    #[arg(required = true, num_args = 3..=7, allow_negative_numbers = true, value_name = "NUMBER")]
    pose: Vec<f64>,
}

impl Pose {
    /// The pose that was given.
    pub(super) fn given(&self) -> Result<words::Pose, CliError> {
        match self.pose[..] {
            [x, y, z] => Ok(words::Pose::at([x, y, z])),
            [x, y, z, qx, qy, qz, qw] => Ok(words::Pose {
                position: [x, y, z],
                orientation: [qx, qy, qz, qw],
            }),
            _ => Err(CliError::Usage(format!(
                "{} numbers given for a pose; give x y z, or x y z qx qy qz qw",
                self.pose.len()
            ))),
        }
    }
}

/// The pose of seven numbers, of three (no turn) or of none (the identity).
pub(super) fn pose(numbers: &[f64]) -> Result<taut::math::Pose, CliError> {
    let given = match numbers {
        [] => words::Pose::at([0.0; 3]),
        numbers => Pose {
            pose: numbers.to_vec(),
        }
        .given()?,
    };
    let [x, y, z, w] = given.orientation;
    let turn = Quat::from_xyzw(x, y, z, w);
    if (turn.length() - 1.0).abs() > 1e-3 {
        return Err(CliError::Usage(format!(
            "{:?} is no unit quaternion qx qy qz qw",
            given.orientation
        )));
    }
    let place = Vec3::from_array(given.position);
    Ok(taut::math::Pose::from_parts(place, turn.normalize()))
}

/// `v12` or `12`.
pub(super) fn version(text: &str) -> Result<u64, String> {
    let number = text
        .strip_prefix('v')
        .unwrap_or(text)
        .parse()
        .ok();
    number
        .filter(|version| *version > 0)
        .ok_or_else(|| "give a version such as v12".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_read_with_and_without_their_letter() {
        assert_eq!((version("v12"), version("12")), (Ok(12), Ok(12)));
        assert!(
            ["", "v", "0", "v0", "-1", "vv1", "newest"]
                .iter()
                .all(|text| version(text).is_err())
        );
    }
}
