//! The promises of the checker where clouds stand and are carried, against an oracle that sees their
//! points and voxels one by one, as they were given.

use crate::collision::CollisionModel;
use crate::lanes::LANES;
use crate::robot::lane_kinematics::LaneInterval;
use crate::testing::{self, Oracle};
use crate::validation::soundness::cases;
use crate::validation::{Hit, Layers, Scratch, SegmentVerdict, Validator};

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
        let [model, singly] = testing::among_clouds(&mut rng);
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
        let [model, singly] = testing::among_clouds(&mut rng);
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
