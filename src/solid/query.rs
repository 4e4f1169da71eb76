//! Closest points of two bodies at one configuration: exact, for messages, rows and oracles.

use super::Solid;
use super::contact::{Contact, TOUCHING_M};
use super::cover;
use super::distance;
use super::inside::{contains, hidden_cell};
use super::piece::Piece;
use super::transform::Transform;
use super::tree::{Ball, Content, Nodes, by_kind};
use crate::math::Vec3;

/// Closest points of two bodies, in the world; a body wholly inside a mesh counts as overlapping.
pub fn closest(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Contact {
    // Surfaces first: whether a point is inside a mesh takes all of its triangles.
    let surfaces = between_surfaces(a, at_a, b, at_b);
    if surfaces.distance <= TOUCHING_M {
        surfaces
    } else {
        enclosed(a, at_a, b, at_b).unwrap_or(surfaces)
    }
}

/// The same where neither body is inside of the other, as along a proved path.
pub fn between_surfaces(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Contact {
    surface_contact(a, at_a, b, at_b, f64::INFINITY)
}

/// Points of two surfaces no farther apart than 1 + [`NEARLY`] times the closest, much cheaper for
/// meshes: for directions, where a proof decides afterwards.
pub fn nearly_closest(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Contact {
    search(a, at_a, b, at_b, f64::INFINITY, NEARLY_CLOSEST)
}

/// The same of the pieces of B that are in a ball (in B's frame) or touch it, so that several
/// neighbourhoods of a large body are told apart; `None` where there are none.
pub fn nearly_closest_in(
    a: &Solid,
    at_a: &Transform,
    b: &Solid,
    at_b: &Transform,
    part: cover::Ball,
) -> Option<Contact> {
    let contact = search_in(a, at_a, b, at_b, f64::INFINITY, NEARLY_CLOSEST, Some(part));
    contact.distance.is_finite().then_some(contact)
}

/// What [`nearly_closest`] may be off by, as a part of the distance.
pub const NEARLY: f64 = 0.05;

/// The contact of two bodies that touch or overlap; `None` where they are apart.
pub fn overlap(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Option<Contact> {
    let contact = surface_contact(a, at_a, b, at_b, 2.0 * TOUCHING_M);
    if contact.distance <= TOUCHING_M {
        Some(contact)
    } else {
        enclosed(a, at_a, b, at_b)
    }
}

/// Closest points of two surfaces, if they are closer than `within`; else a contact at that
/// distance.
fn surface_contact(
    a: &Solid,
    at_a: &Transform,
    b: &Solid,
    at_b: &Transform,
    within: f64,
) -> Contact {
    // Among the overlapping triangles of two meshes none is the deepest in a useful sense.
    let any_overlap_will_do = a.hollow && b.hollow;
    search(
        a,
        at_a,
        b,
        at_b,
        within,
        Rules {
            share: 1.0,
            any_overlap_will_do,
            measure: distance::contact_within,
        },
    )
}

/// Nearly the closest, and no depth.
const NEARLY_CLOSEST: Rules = Rules {
    share: 1.0 / (1.0 + NEARLY),
    any_overlap_will_do: true,
    measure: distance::approach_within,
};

/// What a search is content with.
#[derive(Clone, Copy)]
struct Rules {
    /// Part of the best distance so far below which another is worth finding.
    share: f64,
    /// The first overlap ends the search.
    any_overlap_will_do: bool,
    /// Contact of two pieces in one frame, unless they are not closer than this.
    measure: fn(&Piece, &Piece, f64) -> Option<Contact>,
}

fn search(
    a: &Solid,
    at_a: &Transform,
    b: &Solid,
    at_b: &Transform,
    within: f64,
    rules: Rules,
) -> Contact {
    search_in(a, at_a, b, at_b, within, rules, None)
}

fn search_in(
    a: &Solid,
    at_a: &Transform,
    b: &Solid,
    at_b: &Transform,
    within: f64,
    rules: Rules,
    part: Option<cover::Ball>,
) -> Contact {
    let relative = at_b.inverse_of(at_a);
    let far = Contact {
        point_a: Vec3::ZERO,
        point_b: Vec3::ZERO,
        normal: Vec3::Z,
        distance: within,
    };
    let best = by_kind!(&a.tree, &b.tree, |a, b| {
        let mut search = Search {
            a,
            b,
            relative,
            best: far,
            rules,
            part,
        };
        search.descend(0, 0);
        search.best
    });
    Contact {
        point_a: at_b.point(best.point_a),
        point_b: at_b.point(best.point_b),
        normal: at_b.rotation * best.normal,
        distance: best.distance,
    }
}

/// Branch and bound over pairs of balls, in B's frame.
struct Search<'a, A, B> {
    a: &'a A,
    b: &'a B,
    relative: Transform,
    best: Contact,
    rules: Rules,
    /// The part of B that is looked at, if it is not all.
    part: Option<cover::Ball>,
}

impl<A: Nodes, B: Nodes> Search<'_, A, B> {
    fn ball_gap(&self, a: u32, b: u32) -> f64 {
        let a = self.a.ball(a);
        let b = self.b.ball(b);
        self.relative.point(a.center).distance(b.center) - a.radius - b.radius
    }

    /// At most the distance of a ball and a piece, where one of the two has a convex piece around
    /// what it is over: around a long thin triangle a ball is all air.
    fn piece_gap(&self, (i, a): (u32, &Ball), (j, b): (u32, &Ball)) -> f64 {
        if let Some(piece) = self.b.convex(j, b) {
            let center = self.relative.point(a.center);
            return distance::closest_on(&piece.core, center).distance(center)
                - piece.radius
                - a.radius;
        }
        let Some(piece) = self.a.convex(i, a) else {
            return f64::NEG_INFINITY;
        };
        let center = self.relative.inverse_point(b.center);
        distance::closest_on(&piece.core, center).distance(center) - piece.radius - b.radius
    }

    /// The gap of two balls along the direction of the deepest overlap so far; B's
    /// is the convex piece that it has. No overlap is deeper than minus its gap along any direction.
    fn shallow_gap(&self, a: u32, b: u32) -> f64 {
        let normal = self.best.normal;
        let ball_a = self.a.ball(a);
        let ball_b = self.b.ball(b);
        let nearest_a = normal.dot(self.relative.point(ball_a.center)) - ball_a.radius;
        let farthest_b = match self.b.convex(b, &ball_b) {
            Some(piece) => normal.dot(piece.core.support(normal)) + piece.radius,
            None => normal.dot(ball_b.center) + ball_b.radius,
        };
        nearest_a - farthest_b
    }

    fn descend(&mut self, a: u32, b: u32) {
        if self.ball_gap(a, b) >= self.rules.share * self.best.distance
            || (self.rules.any_overlap_will_do && self.best.distance <= 0.0)
        {
            return;
        }
        if self.best.distance < 0.0 && self.shallow_gap(a, b) >= self.best.distance {
            return;
        }
        let ball_a = self.a.ball(a);
        let ball_b = self.b.ball(b);
        if self
            .part
            .is_some_and(|part| part.center.distance(ball_b.center) > part.radius + ball_b.radius)
        {
            return;
        }
        let nearer_than = self.rules.share * self.best.distance;
        if nearer_than > 0.0
            && nearer_than.is_finite()
            && self.piece_gap((a, &ball_a), (b, &ball_b)) >= nearer_than
        {
            return;
        }
        match children(&ball_a, &ball_b) {
            Split::Neither(i, j) => {
                let piece_a = self.a.piece(i).transformed(&self.relative);
                let piece_b = &*self.b.piece(j);
                let is_overlap = self.best.distance < 0.0;
                if is_overlap
                    && distance::gap_along(&piece_a, piece_b, self.best.normal)
                        >= self.best.distance
                {
                    return;
                }
                let contact = (self.rules.measure)(&piece_a, piece_b, self.best.distance);
                if let Some(contact) =
                    contact.filter(|contact| contact.distance < self.best.distance)
                {
                    self.best = contact;
                }
            }
            Split::A(left, right) => {
                let (near, far) = if self.ball_gap(left, b) <= self.ball_gap(right, b) {
                    (left, right)
                } else {
                    (right, left)
                };
                self.descend(near, b);
                self.descend(far, b);
            }
            Split::B(left, right) => {
                let (near, far) = if self.ball_gap(a, left) <= self.ball_gap(a, right) {
                    (left, right)
                } else {
                    (right, left)
                };
                self.descend(a, near);
                self.descend(a, far);
            }
        }
    }
}

/// Which of two balls to open: the larger one that can be.
pub enum Split {
    /// Both are single pieces, given by index.
    Neither(u32, u32),
    /// A's two balls.
    A(u32, u32),
    /// B's two balls.
    B(u32, u32),
}

/// Decides which of two balls to open.
pub fn children(a: &Ball, b: &Ball) -> Split {
    match (a.content, b.content) {
        (Content::Piece(i), Content::Piece(j)) => Split::Neither(i, j),
        (Content::Balls(left, right), Content::Piece(_)) => Split::A(left, right),
        (Content::Piece(_), Content::Balls(left, right)) => Split::B(left, right),
        (Content::Balls(left, right), Content::Balls(..)) if a.radius >= b.radius => {
            Split::A(left, right)
        }
        (_, Content::Balls(left, right)) => Split::B(left, right),
    }
}

/// A part of one body that lies wholly inside a mesh of the other.
pub fn enclosed(a: &Solid, at_a: &Transform, b: &Solid, at_b: &Transform) -> Option<Contact> {
    let inside = |outer: &Solid, at_outer: &Transform, inner: &Solid, at_inner: &Transform| {
        if let Some(cells) = inner.tree.cells() {
            let relative = at_outer.inverse_of(at_inner);
            return hidden_cell(outer, cells, &relative).map(|point| at_outer.point(point));
        }
        let anchors = inner
            .anchors
            .iter()
            .map(|anchor| at_inner.point(*anchor));
        let mut hits =
            anchors.filter(|p| outer.hollow && contains(outer, at_outer.inverse_point(*p)));
        hits.next()
    };
    let point = inside(b, at_b, a, at_a).or_else(|| inside(a, at_a, b, at_b))?;
    let surface = surface_contact(a, at_a, b, at_b, f64::INFINITY);
    let depth = surface.distance.abs().max(TOUCHING_M);
    Some(Contact {
        point_a: point,
        point_b: point,
        normal: surface.normal,
        distance: -depth,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Pose, Quat};
    use crate::scene::{Obstacle, Scene};
    use crate::shape::{PlacedShape, Shape};
    use crate::testing::wedge;

    fn solid(shape: Shape, at: Vec3) -> Solid {
        let shapes = [PlacedShape {
            pose: Pose::from_parts(at, Quat::IDENTITY),
            shape,
        }];
        Solid::new(&shapes)
    }

    fn cuboid(size: f64, at: Vec3) -> Solid {
        solid(Shape::cuboid(Vec3::splat(size)).unwrap(), at)
    }

    const HERE: Transform = Transform::IDENTITY;

    /// Parry sees surfaces only: a box inside a closed mesh was 0.8 m away and not intersecting.
    #[test]
    fn a_body_wholly_inside_a_closed_mesh_collides() {
        let hall = solid(Shape::Mesh(Arc::new(wedge(Vec3::ONE))), Vec3::ZERO);
        let inside = cuboid(0.1, Vec3::new(0.0, 0.0, -0.6));
        for (a, b) in [(&hall, &inside), (&inside, &hall)] {
            let contact = overlap(a, &HERE, b, &HERE).expect("a box in the hall");
            assert!(contact.distance < -0.2, "{contact:?}");
            assert!(closest(a, &HERE, b, &HERE).distance < -0.2);
        }
        // A scan of what is in the hall, and of what is around it.
        let scan = |at: Vec3| {
            let grid =
                (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|k| 0.02 * f64::from(k)));
            let points = grid.map(|[x, y, z]| (at + Vec3::new(x, y, z)).to_array());
            let cloud = crate::shape::Cloud::of_points(points, 0.001).unwrap();
            solid(Shape::Cloud(Arc::new(cloud)), Vec3::ZERO)
        };
        let hidden = scan(Vec3::new(-0.1, -0.1, -0.8));
        for (a, b) in [(&hall, &hidden), (&hidden, &hall)] {
            let [at_a, at_b] = [a, b].map(|solid| solid.placed(HERE));
            let contact = overlap(a, &at_a, b, &at_b).expect("points in the hall");
            assert!(contact.distance < -0.1, "{contact:?}");
        }
        let outside = scan(Vec3::new(-0.1, -0.1, 0.7));
        let at = outside.placed(HERE);
        assert!(overlap(&hall, &HERE, &outside, &at).is_none());
        // In the hollow of the roof it is outside, 0.35 m above the middle that is pressed in.
        let above = cuboid(0.1, Vec3::Z * 0.9);
        assert!(overlap(&hall, &HERE, &above, &HERE).is_none());
        assert!(closest(&hall, &HERE, &above, &HERE).distance > 0.4);
    }

    /// Parry's distance and its intersection test can disagree where solids touch.
    #[test]
    fn less_than_a_nanometre_is_contact_and_more_is_not() {
        let shapes = [
            Shape::cuboid(Vec3::splat(0.2)).unwrap(),
            Shape::cylinder(0.2, 0.1).unwrap(),
            Shape::sphere(0.1).unwrap(),
            Shape::capsule(0.1, 0.05).unwrap(),
            Shape::Mesh(Arc::new(wedge(Vec3::splat(0.1)))),
        ];
        for upper in &shapes {
            for lower in &shapes {
                let lower = solid(lower.clone(), Vec3::ZERO);
                let at = |gap: f64| solid(upper.clone(), Vec3::Z * (0.2 + gap));
                // Balls hang free above the roof, whose middle is pressed in.
                for (gap, touches) in [(-1e-6, true), (5e-10, true), (5e-9, false)] {
                    let seen = overlap(&at(gap), &HERE, &lower, &HERE).is_some();
                    let rim_only = lower.hollow
                        && matches!(upper, Shape::Sphere { .. } | Shape::Capsule { .. });
                    assert_eq!(
                        seen,
                        touches && !rim_only,
                        "{upper:?}, {gap} m above {lower:?}"
                    );
                }
            }
        }
    }

    /// A pose that is not a number once gave distance 0 and "not intersecting": it must not get
    /// this far.
    #[test]
    fn a_pose_that_is_not_finite_is_refused_before_any_query() {
        for bad in [f64::NAN, f64::INFINITY] {
            let here = Quat::IDENTITY;
            let turned = Quat::from_xyzw(bad, 0.0, 0.0, 1.0);
            for pose in [
                Pose::from_parts(Vec3::X * bad, here),
                Pose::from_parts(Vec3::ZERO, turned),
            ] {
                let shapes = Arc::new([PlacedShape {
                    pose,
                    shape: Shape::sphere(0.1).unwrap(),
                }]);
                let obstacle = Obstacle {
                    id: "crate".into(),
                    pose: Pose::identity(),
                    shapes,
                    sensed: None,
                };
                let refused = Scene::new("scene", vec![obstacle], vec![], vec![]);
                assert!(
                    refused
                        .unwrap_err()
                        .to_string()
                        .starts_with("object \"crate\": pose is ")
                );
            }
        }
    }
}
