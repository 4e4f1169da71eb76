//! Two segments, in closed form.

use super::point::on_segment;
use crate::math::Vec3;

/// Closest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9). The place on the
/// first line comes from cross products: for segments all but parallel the usual determinant is all
/// rounding.
pub(super) fn closest(a0: Vec3, a1: Vec3, b0: Vec3, b1: Vec3) -> (Vec3, Vec3) {
    let da = a1 - a0;
    let db = b1 - b0;
    let r = a0 - b0;
    let aa = da.length_squared();
    let bb = db.length_squared();
    if aa <= 0.0 {
        return (a0, on_segment(b0, b1, a0));
    }
    if bb <= 0.0 {
        return (on_segment(a0, a1, b0), b0);
    }
    let across = da.cross(db);
    let square = across.length_squared();
    let mut s = if square > 0.0 {
        (db.cross(r).dot(across) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let ab = da.dot(db);
    let f = db.dot(r);
    let mut t = (ab * s + f) / bb;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((ab * t - da.dot(r)) / aa).clamp(0.0, 1.0);
    }
    (a0 + da * s, b0 + db * t)
}
