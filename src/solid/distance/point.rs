//! Points against cores.

use crate::math::Vec3;
use crate::solid::core::Core;

/// Point of the (solid) core closest to `p`; `p` itself where it is inside.
pub fn closest_on(core: &Core, p: Vec3) -> Vec3 {
    match *core {
        Core::Point(a) => a,
        Core::Segment(a, b) => on_segment(a, b, p),
        Core::Triangle(a, b, c) => on_triangle(a, b, c, p),
        Core::Box { center, axes, half } => {
            let local = axes.transpose() * (p - center);
            let inside = local.clamp(-half, half);
            if inside == local {
                p
            } else {
                center + axes * inside
            }
        }
        Core::Cylinder {
            center,
            axes,
            half_height,
            radius,
        } => {
            let local = axes.transpose() * (p - center);
            let inside = in_upright_cylinder(half_height, radius, local);
            if inside == local {
                p
            } else {
                center + axes * inside
            }
        }
    }
}

/// Closest point of the cylinder about the z axis, in its own frame.
pub(super) fn in_upright_cylinder(half_height: f64, radius: f64, p: Vec3) -> Vec3 {
    let across = p.truncate().length();
    let height = p.z.clamp(-half_height, half_height);
    if across <= radius {
        return Vec3::new(p.x, p.y, height);
    }
    let shrink = radius / across;
    Vec3::new(p.x * shrink, p.y * shrink, height)
}

/// Closest point of a segment.
pub(super) fn on_segment(a: Vec3, b: Vec3, p: Vec3) -> Vec3 {
    let along = b - a;
    let square = along.length_squared();
    if square <= 0.0 {
        a
    } else {
        a + along * ((p - a).dot(along) / square).clamp(0.0, 1.0)
    }
}

/// Closest point of a triangle by its Voronoi regions (Ericson, Real-Time Collision Detection,
/// 5.1.5).
pub(super) fn on_triangle(a: Vec3, b: Vec3, c: Vec3, p: Vec3) -> Vec3 {
    let ab = b - a;
    let ac = c - a;
    let ap = p - a;
    let d1 = ab.dot(ap);
    let d2 = ac.dot(ap);
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let d3 = ab.dot(bp);
    let d4 = ac.dot(bp);
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let d5 = ab.dot(cp);
    let d6 = ac.dot(cp);
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    let vb = d5 * d2 - d1 * d6;
    let va = d3 * d6 - d5 * d4;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_segment(a, b, p);
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_segment(a, c, p);
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return on_segment(b, c, p);
    }
    let scale = 1.0 / (va + vb + vc);
    if !scale.is_finite() {
        // A sliver without area: its longest edge is the triangle.
        let nearest = [
            on_segment(a, b, p),
            on_segment(a, c, p),
            on_segment(b, c, p),
        ];
        return nearest
            .into_iter()
            .min_by(|x, y| x.distance(p).total_cmp(&y.distance(p)))
            .unwrap_or(a);
    }
    a + ab * (vb * scale) + ac * (vc * scale)
}
