//! Vectors, rotations and poses: the gate's own, so that an error in taut's is not made here too.

/// x, y, z (m).
pub type Vector = [f64; 3];

pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scaled(a: Vector, by: f64) -> Vector {
    [a[0] * by, a[1] * by, a[2] * by]
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

pub fn unit(a: Vector) -> Vector {
    scaled(a, 1.0 / length(a))
}

/// A rotation, row by row.
pub type Rotation = [Vector; 3];

/// Where something is, and how it is turned.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub rotation: Rotation,
    pub at: Vector,
}

impl Pose {
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        at: [0.0; 3],
    };

    pub fn shift(at: Vector) -> Self {
        Self {
            at,
            ..Self::IDENTITY
        }
    }

    pub fn turn(rotation: Rotation) -> Self {
        Self {
            rotation,
            at: [0.0; 3],
        }
    }

    pub fn point(&self, p: Vector) -> Vector {
        add(self.direction(p), self.at)
    }

    pub fn direction(&self, d: Vector) -> Vector {
        self.rotation.map(|row| dot(row, d))
    }

    /// A direction of the outside in this frame.
    pub fn direction_inside(&self, d: Vector) -> Vector {
        let r = &self.rotation;
        std::array::from_fn(|i| r[0][i] * d[0] + r[1][i] * d[1] + r[2][i] * d[2])
    }

    /// This pose, and within it another.
    pub fn then(&self, inner: &Self) -> Self {
        let column = |i: usize| {
            self.direction([
                inner.rotation[0][i],
                inner.rotation[1][i],
                inner.rotation[2][i],
            ])
        };
        let columns = [column(0), column(1), column(2)];
        let rotation = std::array::from_fn(|row| std::array::from_fn(|i| columns[i][row]));
        Self {
            rotation,
            at: self.point(inner.at),
        }
    }
}

/// A turn about an axis of length 1 (rad), by Rodrigues' formula.
pub fn about(axis: Vector, angle: f64) -> Rotation {
    let (sine, cosine) = angle.sin_cos();
    let [x, y, z] = axis;
    let rest = 1.0 - cosine;
    [
        [
            cosine + x * x * rest,
            x * y * rest - z * sine,
            x * z * rest + y * sine,
        ],
        [
            y * x * rest + z * sine,
            cosine + y * y * rest,
            y * z * rest - x * sine,
        ],
        [
            z * x * rest - y * sine,
            z * y * rest + x * sine,
            cosine + z * z * rest,
        ],
    ]
}

/// URDF's roll, pitch, yaw: about the fixed x, then y, then z.
pub fn of_rpy([roll, pitch, yaw]: Vector) -> Rotation {
    let x = about([1.0, 0.0, 0.0], roll);
    let y = about([0.0, 1.0, 0.0], pitch);
    let z = about([0.0, 0.0, 1.0], yaw);
    Pose::turn(z)
        .then(&Pose::turn(y))
        .then(&Pose::turn(x))
        .rotation
}

/// x, y, z, w.
pub type Quaternion = [f64; 4];

pub fn normalised(q: Quaternion) -> Quaternion {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}

pub fn of_quaternion(q: Quaternion) -> Rotation {
    let [x, y, z, w] = normalised(q);
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// Half the cosine of the angle between two orientations is this one's angle; of either sign.
pub fn quaternion_dot(a: Quaternion, b: Quaternion) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Shoemake's slerp between unit quaternions, along the arc on which `b` stands as it does: flip it
/// for the other.
pub fn slerp(a: Quaternion, b: Quaternion, t: f64) -> Quaternion {
    let cosine = quaternion_dot(a, b).clamp(-1.0, 1.0);
    let angle = cosine.acos();
    if angle < 1e-9 {
        return normalised(std::array::from_fn(|i| a[i] + t * (b[i] - a[i])));
    }
    let from = ((1.0 - t) * angle).sin() / angle.sin();
    let to = (t * angle).sin() / angle.sin();
    normalised(std::array::from_fn(|i| from * a[i] + to * b[i]))
}
