//! Random robots, meshes, scenes and paths: what the files are then written to say.

pub mod mesh;
pub mod path;
pub mod robot;
pub mod scene;

use fastrand::Rng;

use super::pose::{Quaternion, Vector, normalised, unit};

pub fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

pub fn one_in(rng: &mut Rng, many: usize) -> bool {
    rng.usize(0..many) == 0
}

pub fn pick<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.usize(0..of.len())]
}

pub fn vector(rng: &mut Rng, most: f64) -> Vector {
    std::array::from_fn(|_| uniform(rng, -most, most))
}

pub fn direction(rng: &mut Rng) -> Vector {
    loop {
        let v = vector(rng, 1.0);
        let norm = super::pose::length(v);
        if (0.1..=1.0).contains(&norm) {
            return unit(v);
        }
    }
}

pub fn quaternion(rng: &mut Rng) -> Quaternion {
    loop {
        let q: Quaternion = std::array::from_fn(|_| uniform(rng, -1.0, 1.0));
        let norm = q.iter().map(|x| x * x).sum::<f64>();
        if (0.1..=1.0).contains(&norm) {
            return normalised(q);
        }
    }
}
