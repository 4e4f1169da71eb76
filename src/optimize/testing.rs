//! Random instances for the unit tests of this folder.

use std::sync::Arc;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::cost::segment_lengths;
use super::rows::Rows;
use crate::collision::CollisionModel;
use crate::math::{DMatrix, DVector, Pose, Vec3};
use crate::path::Metric;
use crate::robot::{
    Component, ConfigurationSpace, JointDescription, JointKind, LinkDescription, RobotDescription,
    RobotModel,
};
use crate::scene::Scene;
use crate::shape::{PlacedShape, Shape};

/// A space, a metric, a path in it, its fixed waypoints and moving coordinates.
pub struct Instance {
    pub space: ConfigurationSpace,
    pub metric: Metric,
    pub rows: Vec<f64>,
    pub fixed: Vec<bool>,
    pub moving: Vec<bool>,
}

/// A product of `count` lines.
pub fn line_space(count: usize) -> ConfigurationSpace {
    ConfigurationSpace::new(
        (0..count)
            .map(|i| Component::Line { q: i, v: i })
            .collect(),
    )
}

/// Lines, a circle and a rotation; neighbours less than a radian apart; some waypoints fixed, some
/// coordinates still.
pub fn instance(seed: u64, waypoints: usize) -> Instance {
    let space = ConfigurationSpace::new(vec![
        Component::Line { q: 0, v: 0 },
        Component::Line { q: 1, v: 1 },
        Component::Circle { q: 2, v: 2 },
        Component::Rotation { q: 3, v: 3 },
        Component::Line { q: 7, v: 6 },
    ]);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut rows = vec![0.0; 8];
    rows[6] = 1.0;
    for i in 1..waypoints {
        let velocity: Vec<f64> = (0..7).map(|_| random.f64() - 0.5).collect();
        let from = rows[(i - 1) * 8..].to_vec();
        let mut to = vec![0.0; 8];
        space.integrate(&from, &velocity, 1.0, &mut to);
        rows.extend(to);
    }
    let turn = 0.5 + random.f64();
    let weights = (0..7)
        .map(|v| {
            if (3..6).contains(&v) {
                turn
            } else {
                0.5 + random.f64()
            }
        })
        .collect();
    let metric = Metric::new(&space, weights).expect("positive weights");
    let still = random.f64() < 0.5;
    let moving = (0..7).map(|v| !(still && v == 1)).collect();
    Instance {
        metric,
        rows,
        fixed: fixed(&mut random, waypoints),
        moving,
        space,
    }
}

/// The same on `count` lines, where the cost is exactly quadratic.
pub fn lines(seed: u64, waypoints: usize, count: usize) -> Instance {
    let space = line_space(count);
    let mut random = fastrand::Rng::with_seed(seed);
    let rows = (0..waypoints * count)
        .map(|_| random.f64())
        .collect();
    let weights = (0..count).map(|_| 0.5 + random.f64()).collect();
    let metric = Metric::new(&space, weights).expect("positive weights");
    Instance {
        metric,
        rows,
        fixed: fixed(&mut random, waypoints),
        moving: vec![true; count],
        space,
    }
}

fn fixed(random: &mut fastrand::Rng, waypoints: usize) -> Vec<bool> {
    // At least one waypoint in the middle is free.
    let free = random.usize(1..waypoints - 1);
    let is_end = |i: usize| i == 0 || i == waypoints - 1;
    (0..waypoints)
        .map(|i| is_end(i) || (random.f64() < 0.25 && i != free))
        .collect()
}

/// Moves every waypoint a little, fixed ones too.
pub fn shake(space: &ConfigurationSpace, rows: &mut [f64], seed: u64) {
    let mut random = fastrand::Rng::with_seed(!seed);
    for waypoint in rows.chunks_exact_mut(space.nq()) {
        let velocity: Vec<f64> = (0..space.nv())
            .map(|_| 0.4 * (random.f64() - 0.5))
            .collect();
        let from = waypoint.to_vec();
        space.integrate(&from, &velocity, 1.0, waypoint);
    }
}

/// T over the free waypoints, dense, from its definition.
pub fn tridiagonal(lengths: &[f64], fixed: &[bool]) -> DMatrix<f64> {
    let free: Vec<usize> = (0..fixed.len())
        .filter(|&i| !fixed[i])
        .collect();
    DMatrix::from_fn(free.len(), free.len(), |a, b| match (free[a], free[b]) {
        (i, j) if i == j => 1.0 / lengths[i - 1] + 1.0 / lengths[i],
        (i, j) if i + 1 == j || j + 1 == i => -1.0 / lengths[i.min(j)],
        _ => 0.0,
    })
}

/// `min_p gᵀp + ½ pᵀHp` under rows, over the free waypoints and moving coordinates only, dense.
pub struct Dense {
    pub hessian: DMatrix<f64>,
    pub gradient: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    pub right_hand_side: DVector<f64>,
    /// Place of each dense variable in the step of the whole path.
    pub places: Vec<usize>,
}

impl Dense {
    /// `J p = b`, for Clarabel.
    pub const EQUALITIES: fn(usize) -> SupportedConeT<f64> = SupportedConeT::ZeroConeT;
    /// `J p ≥ b`, for Clarabel.
    pub const HALF_SPACES: fn(usize) -> SupportedConeT<f64> = SupportedConeT::NonnegativeConeT;

    pub fn new(instance: &Instance, rows: &Rows, gradient: &[f64]) -> Self {
        let Instance {
            space,
            metric,
            rows: path,
            fixed,
            moving,
        } = instance;
        let nv = space.nv();
        let free: Vec<usize> = (0..fixed.len())
            .filter(|&i| !fixed[i])
            .collect();
        let coordinates: Vec<usize> = (0..nv).filter(|&v| moving[v]).collect();
        let tridiagonal = tridiagonal(&segment_lengths(space, metric, path), fixed);
        let n = coordinates.len();
        let mut hessian = DMatrix::zeros(free.len() * n, free.len() * n);
        for (a, b) in (0..free.len()).flat_map(|a| (0..free.len()).map(move |b| (a, b))) {
            for (c, &v) in coordinates.iter().enumerate() {
                hessian[(a * n + c, b * n + c)] = tridiagonal[(a, b)] * metric.weights()[v].powi(2);
            }
        }
        let places: Vec<usize> = free
            .iter()
            .flat_map(|i| coordinates.iter().map(move |v| i * nv + v))
            .collect();
        let entry = |r: usize, c: usize| {
            let mut unit = vec![0.0; gradient.len()];
            unit[places[c]] = 1.0;
            rows.get(r).of_step(&unit)
        };
        Self {
            hessian,
            gradient: DVector::from_iterator(places.len(), places.iter().map(|&p| gradient[p])),
            jacobian: DMatrix::from_fn(rows.len(), places.len(), entry),
            right_hand_side: DVector::from_iterator(
                rows.len(),
                rows.iter().map(|r| r.right_hand_side),
            ),
            places,
        }
    }

    /// The step of the equalities: solves the KKT system whole.
    pub fn step(&self) -> DVector<f64> {
        let n = self.hessian.nrows();
        let m = self.jacobian.nrows();
        let mut kkt = DMatrix::zeros(n + m, n + m);
        kkt.view_mut((0, 0), (n, n))
            .copy_from(&self.hessian);
        kkt.view_mut((n, 0), (m, n))
            .copy_from(&self.jacobian);
        kkt.view_mut((0, n), (n, m))
            .copy_from(&self.jacobian.transpose());
        let mut right = DVector::zeros(n + m);
        right.rows_mut(0, n).copy_from(&-&self.gradient);
        right
            .rows_mut(n, m)
            .copy_from(&self.right_hand_side);
        kkt.full_piv_lu()
            .solve(&right)
            .expect("independent rows")
            .rows(0, n)
            .into_owned()
    }

    /// Asks Clarabel; `None` where it finds no step.
    pub fn step_of_clarabel(&self, cone: fn(usize) -> SupportedConeT<f64>) -> Option<Vec<f64>> {
        let lines = |m: &DMatrix<f64>| -> Vec<Vec<f64>> {
            m.row_iter()
                .map(|row| row.iter().copied().collect())
                .collect()
        };
        let upper = CscMatrix::from(&lines(&self.hessian)).to_triu();
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-12,
            ..DefaultSettings::default()
        };
        // Clarabel's slack b − A p is in the cone.
        let matrix = CscMatrix::from(&lines(&-&self.jacobian));
        let right = -&self.right_hand_side;
        let (linear, right, cones) = (
            self.gradient.as_slice(),
            right.as_slice(),
            [cone(right.len())],
        );
        let mut solver = DefaultSolver::new(&upper, linear, &matrix, right, &cones, settings)
            .expect("a valid QP");
        solver.solve();
        let is_solved = matches!(
            solver.solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        is_solved.then(|| solver.solution.x.clone())
    }
}

/// A robot of prismatic joints with the same limits, without shapes, in an empty scene.
pub fn sliders(count: usize, limits: (f64, f64)) -> CollisionModel {
    let link = |i: usize| LinkDescription {
        name: format!("link{i}"),
        collision: Vec::new(),
    };
    let joint = |i: usize| JointDescription {
        name: format!("joint{i}"),
        kind: JointKind::Prismatic,
        parent: format!("link{i}"),
        child: format!("link{}", i + 1),
        origin: Pose::identity(),
        axis: Vec3::X,
        limits: Some(limits),
        soft_limits: None,
        mimic: None,
    };
    let robot = RobotModel::new(RobotDescription {
        links: (0..=count).map(link).collect(),
        joints: (0..count).map(joint).collect(),
        ..RobotDescription::default()
    });
    CollisionModel::new(
        Arc::new(robot.expect("a chain")),
        Arc::new(Scene::default()),
    )
    .expect("an empty scene")
}

/// A disc in the plane, on two prismatic joints.
pub fn disc(radius: f64) -> RobotModel {
    let shape = Shape::cylinder(0.2, radius).expect("a size");
    let disc = vec![PlacedShape {
        pose: Pose::identity(),
        shape,
    }];
    let link = |name: &str, collision| LinkDescription {
        name: name.into(),
        collision,
    };
    let joint = |name: &str, axis, parent: &str, child: &str| JointDescription {
        name: name.into(),
        kind: JointKind::Prismatic,
        parent: parent.into(),
        child: child.into(),
        origin: Pose::identity(),
        axis,
        limits: Some((-5.0, 5.0)),
        soft_limits: None,
        mimic: None,
    };
    let description = RobotDescription {
        links: vec![
            link("plane", Vec::new()),
            link("slide", Vec::new()),
            link("disc", disc),
        ],
        joints: vec![
            joint("x", Vec3::X, "plane", "slide"),
            joint("y", Vec3::Y, "slide", "disc"),
        ],
        ..RobotDescription::default()
    };
    RobotModel::new(description).expect("a chain")
}
