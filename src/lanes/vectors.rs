//! Eight vectors at once, and axes for them.

use std::ops::{Add, Mul, Sub};

use super::{Eight, Lanes, Packed};

/// Eight vectors.
#[derive(Clone, Copy, Debug)]
pub struct Vectors<S: Eight> {
    /// First components.
    pub x: Lanes<S>,
    /// Second components.
    pub y: Lanes<S>,
    /// Third components.
    pub z: Lanes<S>,
}

impl<S: Eight> Vectors<S> {
    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, v: [f32; 3]) -> Self {
        Self {
            x: Lanes::splat(simd, v[0]),
            y: Lanes::splat(simd, v[1]),
            z: Lanes::splat(simd, v[2]),
        }
    }
    /// Vectors from memory.
    #[inline(always)]
    pub fn new(simd: S, v: [Packed; 3]) -> Self {
        Self {
            x: Lanes::new(simd, v[0]),
            y: Lanes::new(simd, v[1]),
            z: Lanes::new(simd, v[2]),
        }
    }
    /// Vectors for memory.
    #[inline(always)]
    pub fn packed(self) -> [Packed; 3] {
        [self.x.packed, self.y.packed, self.z.packed]
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }
    /// Euclidean length.
    #[inline(always)]
    pub fn length(self) -> Lanes<S> {
        self.dot(self).sqrt()
    }
}

impl<S: Eight> Add for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }
}

impl<S: Eight> Sub for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<S: Eight> Mul<Lanes<S>> for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: Lanes<S>) -> Self {
        Self {
            x: self.x * scale,
            y: self.y * scale,
            z: self.z * scale,
        }
    }
}

impl<S: Eight> Mul<f32> for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: f32) -> Self {
        Self {
            x: self.x * scale,
            y: self.y * scale,
            z: self.z * scale,
        }
    }
}

/// Three axes, or the columns of a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Axes<S: Eight>(pub [Vectors<S>; 3]);

impl<S: Eight> Axes<S> {
    /// The same axes in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, axes: &[[f32; 3]; 3]) -> Self {
        Self([
            Vectors::splat(simd, axes[0]),
            Vectors::splat(simd, axes[1]),
            Vectors::splat(simd, axes[2]),
        ])
    }
    /// Axes from memory.
    #[inline(always)]
    pub fn new(simd: S, axes: &[[Packed; 3]; 3]) -> Self {
        Self([
            Vectors::new(simd, axes[0]),
            Vectors::new(simd, axes[1]),
            Vectors::new(simd, axes[2]),
        ])
    }
    /// Axes for memory.
    #[inline(always)]
    pub fn packed(self) -> [[Packed; 3]; 3] {
        [self.0[0].packed(), self.0[1].packed(), self.0[2].packed()]
    }
    /// The vector with these coordinates.
    #[inline(always)]
    pub fn combine(self, v: Vectors<S>) -> Vectors<S> {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }
    /// The vector with these coordinates, the same in all lanes.
    #[inline(always)]
    pub fn combine_constant(self, v: [f32; 3]) -> Vectors<S> {
        self.0[0] * v[0] + self.0[1] * v[1] + self.0[2] * v[2]
    }
    /// Coordinates of a vector along unit axes.
    #[inline(always)]
    pub fn coordinates(self, v: Vectors<S>) -> Vectors<S> {
        Vectors {
            x: self.0[0].dot(v),
            y: self.0[1].dot(v),
            z: self.0[2].dot(v),
        }
    }
}
