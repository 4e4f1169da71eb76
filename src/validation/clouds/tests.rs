//! The promises of the checker where clouds stand and are carried, against an oracle that sees their
//! points and voxels one by one, as they were given.

use std::sync::Arc;

use fastrand::Rng;

use crate::collision::CollisionModel;
use crate::lanes::LANES;
use crate::math::{Pose, Vec3};
use crate::robot::lane_kinematics::LaneInterval;
use crate::scene::{Obstacle, SceneChange};
use crate::shape::{Cloud, PlacedShape, Shape, Voxel};
use crate::testing::{self, Oracle};
use crate::validation::soundness::cases;
use crate::validation::{Hit, Layers, Scratch, SegmentVerdict, Validator};

/// Points or voxels as a cloud, and the same as shapes one by one.
fn crowd(rng: &mut Rng, corner: Vec3) -> (Shape, Vec<PlacedShape>) {
    let count = [1, 7, 30, 90][rng.usize(0..4)];
    let size = testing::vector(rng, 0.5);
    // In clusters, on lines and on planes.
    let middles: Vec<_> = (0..3)
        .map(|_| testing::vector(rng, 0.6))
        .collect();
    let flat = Vec3::new(rng.u8(0..2).into(), rng.u8(0..2).into(), 1.0);
    let points: Vec<_> = (0..count)
        .map(|_| corner + middles[rng.usize(0..3)] + size * testing::vector(rng, 1.0) * flat)
        .collect();
    let place = |point: &Vec3, shape| PlacedShape {
        pose: Pose::from_translation(*point),
        shape,
    };
    let radius = testing::uniform(rng, 0.002, 0.03);
    if rng.bool() {
        let ball = Shape::Sphere { radius };
        let singly = points
            .iter()
            .map(|point| place(point, ball.clone()));
        let cloud = Cloud::of_points(points.iter().map(Vec3::to_array), radius).unwrap();
        return (Shape::Cloud(Arc::new(cloud)), singly.collect());
    }
    let voxels: Vec<_> = points
        .iter()
        .map(|point| Voxel {
            center: point.to_array(),
            size: radius * f64::from(1 << rng.u8(0..4)),
        })
        .collect();
    let cube = |(point, voxel): (&Vec3, &Voxel)| {
        place(point, Shape::cuboid(Vec3::splat(voxel.size)).unwrap())
    };
    let cloud = Cloud::of_voxels(&voxels).unwrap();
    let singly = points.iter().zip(&voxels).map(cube);
    (Shape::Cloud(Arc::new(cloud)), singly.collect())
}

/// A robot among clouds and carrying some, between other objects; and the same with the cells of
/// clouds as shapes, one by one. Some clouds have coordinates of a map's grid, and stand where the robot is.
pub(crate) fn among_clouds(rng: &mut Rng) -> [CollisionModel; 2] {
    let robot = Arc::new(testing::robot(rng));
    let mut clouds = testing::scene(rng);
    let mut singly = clouds.clone();
    for i in 0..rng.usize(1..4) {
        let corner = match rng.u8(0..3) {
            0 => Vec3::new(5.1e5, 5.4e6, 130.0) + testing::vector(rng, 100.0),
            _ => Vec3::ZERO,
        };
        let back = testing::pose(rng, 0.3) * Pose::from_translation(-corner);
        let (cloud, shapes) = crowd(rng, corner);
        let id = format!("cloud{i}");
        let placed = PlacedShape {
            pose: Pose::identity(),
            shape: cloud,
        };
        let mut changes = [vec![placed], shapes]
            .map(|shapes| vec![SceneChange::Add(Obstacle::new(id.clone(), shapes).at(back))]);
        if rng.u8(0..3) == 0 {
            let link = robot.links()[rng.usize(0..robot.links().len())]
                .name
                .clone();
            let attach = SceneChange::Attach {
                id: id.clone(),
                link_name: link,
                touch_links: Vec::new(),
                pose: back,
            };
            changes
                .iter_mut()
                .for_each(|changes| changes.push(attach.clone()));
        }
        let padding = testing::uniform(rng, 0.0, 0.02);
        if rng.u8(0..4) == 0 {
            let pad = SceneChange::Pad { name: id, padding };
            changes
                .iter_mut()
                .for_each(|changes| changes.push(pad.clone()));
        }
        let [with_cloud, one_by_one] = changes;
        clouds = clouds.with(with_cloud).unwrap();
        singly = singly.with(one_by_one).unwrap();
    }
    [clouds, singly].map(|scene| CollisionModel::new(robot.clone(), Arc::new(scene)).unwrap())
}

/// Whether a body of the pair is a cloud.
fn has_cloud(model: &CollisionModel, pair: usize) -> bool {
    let pair = model.pairs()[pair];
    let bodies = [pair.a, pair.b].map(|body| &model.bodies()[body]);
    bodies
        .iter()
        .any(|body| body.solid.tree.cells().is_some())
}

/// Least distance that the oracle sees of a pair, this far into the segment.
struct Seen<'a> {
    model: &'a CollisionModel,
    oracle: Oracle,
    from: Vec<f64>,
    velocity: Vec<f64>,
    held: Vec<f64>,
}

impl<'a> Seen<'a> {
    fn new(model: &'a CollisionModel, from: &[f64], to: &[f64]) -> Self {
        let space = model.robot().space();
        let mut velocity = vec![0.0; space.nv()];
        space.difference(to, from, &mut velocity);
        let held = model.robot().held().iter();
        Self {
            model,
            oracle: Oracle::new(model),
            from: from.to_vec(),
            velocity,
            held: held.map(|held| held.default).collect(),
        }
    }

    fn at(&self, pair: usize, t: f64) -> f64 {
        let space = self.model.robot().space();
        let mut q = vec![0.0; space.nq()];
        space.integrate(&self.from, &self.velocity, t, &mut q);
        self.oracle.pair_distance(self.model, pair, &q)
    }

    fn least(&self, pair: usize, middle: f64, half: f64) -> f64 {
        let at = |i| self.at(pair, middle + half * f64::from(i) / 8.0);
        (-8..=8).map(at).fold(f64::INFINITY, f64::min)
    }
}

/// What is proved of an interval with a cloud in it, by the filter and exactly, the oracle finds
/// kept; bounds cut by a fifth would not be.
#[test]
fn what_is_proved_of_clouds_is_kept_and_the_bound_has_teeth() {
    let (count, mut rng) = cases(600);
    let mut checked = [0, 0];
    let mut refuted = 0;
    for _ in 0..count {
        let [model, singly] = among_clouds(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let seen = Seen::new(&singly, &from, &to);
        let mut scratch = Scratch::default();
        let mut validator = Validator::new(&model, robot.space(), &seen.held, 1e-3, &mut scratch);
        let half = [0.5, 0.1, 0.02][rng.usize(0..3)];
        let lanes = std::array::from_fn(|_| LaneInterval {
            segment: 0,
            middle: testing::uniform(&mut rng, half, 1.0 - half),
            half,
        });
        let (unproved, kept) = validator.filtered(&from, &to, lanes);
        let lane = rng.usize(0..LANES);
        let middle = lanes[lane].middle;
        for pair in (0..model.pairs().len()).filter(|pair| has_cloud(&model, *pair)) {
            let least = seen.least(pair, middle, half);
            let left =
                |(other, lanes): &(u32, u8)| *other as usize == pair && lanes >> lane & 1 == 1;
            if !unproved.iter().any(left) {
                let claimed = f64::from(kept[lane]).max(1e-3);
                assert!(
                    least >= claimed - 1e-6,
                    "{least} where the filter says {claimed}"
                );
                checked[0] += 1;
            }
            let bound = validator.closest_bound(&from, &to, middle, half, pair);
            let Some((gap, displacement, _)) = bound else {
                continue;
            };
            let kept = gap - displacement;
            assert!(least > kept - 1e-7, "{least} where {kept} is promised");
            checked[1] += 1;
            refuted += usize::from(least < gap - 0.8 * displacement - 2e-5);
        }
    }
    println!("{checked:?} intervals, × 0.8 refuted {refuted}");
    assert!(checked[0] > count / 2 && checked[1] > count / 2);
    assert!(refuted * 100 > checked[1], "only {refuted} of {checked:?}");
}

/// No proved segment on which the oracle finds a pair closer than is proved, and what is refused is
/// too close by the oracle. A cloud and its cells one by one come to the same verdict, but between one floor and
/// one and a half.
#[test]
fn segments_among_clouds_are_proved_where_they_are_among_their_cells() {
    let (count, mut rng) = cases(300);
    let mut proved = 0;
    let mut refused = 0;
    for _ in 0..count {
        let [model, singly] = among_clouds(&mut rng);
        let robot = model.robot();
        let from = testing::configuration(&mut rng, robot);
        let to = testing::neighbour(&mut rng, robot, &from);
        let seen = Seen::new(&singly, &from, &to);
        let verdict = |model: &CollisionModel, layers: Layers| {
            let mut scratch = Scratch::default();
            let space = model.robot().space();
            let validator = Validator::new(model, space, &seen.held, 1e-3, &mut scratch);
            let mut validator = validator.with_layers(layers);
            validator.segment(&from, &to, &mut || false)
        };
        let portable = Layers {
            portable_lanes: true,
            ..Layers::default()
        };
        let own = verdict(&model, Layers::default());
        assert_eq!(own, verdict(&model, portable));
        let others = verdict(&singly, Layers::default());
        match own {
            SegmentVerdict::Proved(proof) => {
                proved += 1;
                let claimed = proof.clearance_m.max(1e-3) - 1e-6;
                for pair in (0..model.pairs().len()).filter(|pair| has_cloud(&model, *pair)) {
                    let least = seen.least(pair, 0.5, 0.5);
                    assert!(least >= claimed, "{least} where {claimed} is proved");
                }
                let between = |hit: &Hit| hit.measure.amount > 1e-3 - 1e-6;
                assert!(!matches!(others, SegmentVerdict::Refused(hit) if !between(&hit)));
            }
            SegmentVerdict::Refused(hit) => {
                refused += 1;
                let distance = seen.at(hit.requirement.pair(), hit.t);
                assert!(distance < 1.5e-3 + 4e-5, "refused at {distance}: {hit:?}");
            }
            SegmentVerdict::Stopped => panic!("nothing stops it"),
        }
    }
    println!("{proved} proved, {refused} refused");
    assert!(proved > count / 10 && refused > count / 25);
}
