//! The only file that names an algebra or geometry library's types.
//!
//! Points and poses are glam's (through parry, whose queries take them); the linear algebra of the
//! quadratic step is nalgebra's. Lengths in metres, angles in radians, quaternions (x, y, z, w).

pub use nalgebra::{DMatrix, DVector};
pub use parry3d_f64::math::{Matrix as Mat3, Pose, Rotation as Quat, Vector as Vec3};

/// Roll, pitch, yaw about the fixed x, y, z axes (URDF's `rpy`) as a unit quaternion.
pub fn quat_from_rpy(roll: f64, pitch: f64, yaw: f64) -> Quat {
    Quat::from_rotation_z(yaw) * Quat::from_rotation_y(pitch) * Quat::from_rotation_x(roll)
}

/// Rotation vector of a unit quaternion: axis times angle, angle in [0, π].
///
/// At exactly π both axes describe the rotation; the one whose first non-zero component is
/// positive is returned, so that both ends of a wire agree.
pub fn quat_log(q: Quat) -> Vec3 {
    let mut v = Vec3::new(q.x, q.y, q.z);
    let mut w = q.w;
    let first = [v.x, v.y, v.z]
        .into_iter()
        .find(|c| *c != 0.0)
        .unwrap_or(0.0);
    if w < 0.0 || (w == 0.0 && first < 0.0) {
        v = -v;
        w = -w;
    }
    let sine = v.length();
    // atan2 keeps full precision at both ends; below 1e-12 the ratio is 2 to rounding.
    if sine < 1e-12 {
        v * 2.0
    } else {
        v * (2.0 * sine.atan2(w) / sine)
    }
}

/// Unit quaternion of a rotation vector; the inverse of [`quat_log`].
pub fn quat_exp(v: Vec3) -> Quat {
    let angle = v.length();
    if angle < 1e-12 {
        return Quat::from_xyzw(v.x / 2.0, v.y / 2.0, v.z / 2.0, 1.0).normalize();
    }
    let (sine, cosine) = (angle / 2.0).sin_cos();
    let axis = v * (sine / angle);
    Quat::from_xyzw(axis.x, axis.y, axis.z, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_and_exp_are_inverse_up_to_half_a_turn() {
        for v in [
            Vec3::new(0.3, -0.2, 0.9),
            Vec3::new(1e-9, 0.0, -1e-9),
            Vec3::new(0.0, 0.0, std::f64::consts::PI - 1e-6),
        ] {
            assert!((quat_log(quat_exp(v)) - v).length() < 1e-12);
        }
    }

    #[test]
    fn half_a_turn_goes_positive_whatever_the_sign_of_the_quaternion() {
        for sign in [1.0, -1.0] {
            let log = quat_log(Quat::from_xyzw(0.0, sign, 0.0, 0.0));
            assert!((log.y - std::f64::consts::PI).abs() < 1e-15);
        }
    }
}
