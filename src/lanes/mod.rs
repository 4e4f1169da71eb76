//! Eight f32 numbers at once: the arithmetic of the filter.
//!
//! The instruction set is chosen at run time. Every lane is computed alike on all of them: only
//! IEEE additions, products, quotients and square roots, never fused, so that no answer depends on
//! the machine.

mod vectors;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub use pulp::f32x8 as Packed;
use pulp::{Scalar256b, Simd, m32x8};
pub use vectors::{Axes, Vectors};

/// Lanes of a vector.
pub const LANES: usize = 8;

/// An instruction set with vectors of eight f32.
pub trait Eight: Simd<f32s = Packed, m32s = m32x8> {
    /// The lanes as bits, lane 0 lowest.
    fn bits(self, mask: m32x8) -> u8;
    /// `a > b ? a : b`: the second where one is no number, on every instruction set.
    fn larger(self, a: Packed, b: Packed) -> Packed;
    /// `a < b ? a : b`.
    fn smaller(self, a: Packed, b: Packed) -> Packed;
}

impl Eight for Scalar256b {
    #[inline(always)]
    fn bits(self, mask: m32x8) -> u8 {
        let lanes: [u32; LANES] = pulp::cast(mask);
        lanes
            .iter()
            .enumerate()
            .fold(0, |bits, (lane, set)| bits | ((set & 1) as u8) << lane)
    }
    #[inline(always)]
    fn larger(self, a: Packed, b: Packed) -> Packed {
        self.select_f32s(self.greater_than_f32s(a, b), a, b)
    }
    #[inline(always)]
    fn smaller(self, a: Packed, b: Packed) -> Packed {
        self.select_f32s(self.less_than_f32s(a, b), a, b)
    }
}

#[cfg(target_arch = "x86_64")]
impl Eight for pulp::x86::V3 {
    #[inline(always)]
    fn bits(self, mask: m32x8) -> u8 {
        self.avx._mm256_movemask_ps(pulp::cast(mask)) as u8
    }
    #[inline(always)]
    fn larger(self, a: Packed, b: Packed) -> Packed {
        pulp::cast(
            self.avx
                ._mm256_max_ps(pulp::cast(a), pulp::cast(b)),
        )
    }
    #[inline(always)]
    fn smaller(self, a: Packed, b: Packed) -> Packed {
        pulp::cast(
            self.avx
                ._mm256_min_ps(pulp::cast(a), pulp::cast(b)),
        )
    }
}

/// Work that is compiled once for each instruction set.
pub trait EightWide {
    /// What comes of it.
    type Output;
    /// Does it. Everything that it calls must be `#[inline(always)]`, closures and array methods
    /// are not: what is not inlined is compiled without the instruction set.
    fn run<S: Eight>(self, simd: S) -> Self::Output;
}

/// The instruction set of this machine.
#[derive(Clone, Copy, Debug)]
pub enum InstructionSet {
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// Whatever the compiler makes of arrays.
    Portable,
}

impl Default for InstructionSet {
    fn default() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Self::Avx2(simd);
        }
        Self::Portable
    }
}

impl InstructionSet {
    /// Does the work.
    #[inline]
    pub fn run<W: EightWide>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.vectorize(OnAvx2(simd, work)),
            Self::Portable => work.run(Scalar256b),
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct OnAvx2<W>(pulp::x86::V3, W);

#[cfg(target_arch = "x86_64")]
impl<W: EightWide> pulp::NullaryFnOnce for OnAvx2<W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.1.run(self.0)
    }
}

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Eight> {
    simd: S,
    /// The numbers.
    pub packed: Packed,
}

/// A truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask<S: Eight> {
    simd: S,
    mask: m32x8,
}

impl<S: Eight> Lanes<S> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self {
            simd,
            packed: simd.splat_f32s(value),
        }
    }
    /// Numbers from memory.
    #[inline(always)]
    pub fn new(simd: S, packed: Packed) -> Self {
        Self { simd, packed }
    }
    #[inline(always)]
    fn with(self, packed: Packed) -> Self {
        Self { packed, ..self }
    }
    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f32s(self.packed))
    }
    /// Absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.with(self.simd.abs_f32s(self.packed))
    }
    /// The larger; `other` where one of the two is no number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(self.simd.larger(self.packed, other.packed))
    }
    /// The smaller; `other` where one of the two is no number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(self.simd.smaller(self.packed, other.packed))
    }
    /// The nearest number in [−bound, bound].
    #[inline(always)]
    pub fn clamp(self, bound: f32) -> Self {
        self.max(Self::splat(self.simd, -bound))
            .min(Self::splat(self.simd, bound))
    }
    /// Lanes that are at least those of `other`; a lane that is no number is not.
    #[inline(always)]
    pub fn at_least(self, other: Self) -> Mask<S> {
        Mask {
            simd: self.simd,
            mask: self
                .simd
                .greater_than_or_equal_f32s(self.packed, other.packed),
        }
    }
    /// The nearest whole number, for magnitudes below 2²².
    #[inline(always)]
    pub fn round(self) -> Self {
        let large = Self::splat(self.simd, 12_582_912.0);
        self + large - large
    }
}

impl<S: Eight> Mask<S> {
    /// Lanes whose bit is set.
    #[inline(always)]
    pub fn from_bits(simd: S, bits: u8) -> Self {
        Self {
            simd,
            mask: pulp::cast(BITS[bits as usize]),
        }
    }
    /// The lanes as bits, lane 0 lowest.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.simd.bits(self.mask)
    }
    /// In both.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self {
            mask: self.simd.and_m32s(self.mask, other.mask),
            ..self
        }
    }
    /// `yes` where it holds, else `no`.
    #[inline(always)]
    pub fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        yes.with(
            self.simd
                .select_f32s(self.mask, yes.packed, no.packed),
        )
    }
}

/// Every mask by its bits: a load instead of eight shifts.
static BITS: [[u32; LANES]; 256] = {
    let mut table = [[0; LANES]; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut lane = 0;
        while lane < LANES {
            table[bits][lane] = if bits >> lane & 1 == 1 { u32::MAX } else { 0 };
            lane += 1;
        }
        bits += 1;
    }
    table
};

macro_rules! operator {
    ($trait:ident, $method:ident, $simd:ident) => {
        impl<S: Eight> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(self.simd.$simd(self.packed, other.packed))
            }
        }
        impl<S: Eight> $trait<f32> for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f32) -> Self {
                self.with(
                    self.simd
                        .$simd(self.packed, self.simd.splat_f32s(other)),
                )
            }
        }
    };
}
operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Eight> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.neg_f32s(self.packed))
    }
}

/// Sine and cosine, for magnitudes below 400; off by at most 3e-7.
///
/// The angle is brought to [−π/2, π/2] by whole multiples of π, whose parity is the sign of both;
/// there the Taylor series are cut off below the rounding.
#[inline(always)]
pub fn sin_cos<S: Eight>(angle: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    // π in three parts, the first two short enough that their products with the multiple are exact.
    const PI_HIGH: f32 = 3.140_625;
    const PI_MIDDLE: f32 = 9.670_257_6e-4;
    const PI_LOW: f32 = 6.277_114e-7;
    let turns = (angle * std::f32::consts::FRAC_1_PI).round();
    let x = angle - turns * PI_HIGH - turns * PI_MIDDLE - turns * PI_LOW;
    let odd = (turns - (turns * 0.5).round() * 2.0).abs();
    let sign = -(odd * 2.0) + 1.0;
    let square = x * x;
    let sine = square * (-1.0 / 39_916_800.0) + 1.0 / 362_880.0;
    let sine = square * sine - 1.0 / 5040.0;
    let sine = square * sine + 1.0 / 120.0;
    let sine = square * sine - 1.0 / 6.0;
    let sine = x + x * (square * sine);
    let cosine = square * (1.0 / 479_001_600.0) - 1.0 / 3_628_800.0;
    let cosine = square * cosine + 1.0 / 40_320.0;
    let cosine = square * cosine - 1.0 / 720.0;
    let cosine = square * cosine + 1.0 / 24.0;
    let cosine = square * cosine - 0.5;
    let cosine = square * cosine + 1.0;
    (sine * sign, cosine * sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct SinCos([f32; LANES]);

    impl EightWide for SinCos {
        type Output = [[f32; LANES]; 2];
        #[inline(always)]
        fn run<S: Eight>(self, simd: S) -> Self::Output {
            let (sine, cosine) = sin_cos(Lanes::new(simd, pulp::cast(self.0)));
            [pulp::cast(sine.packed), pulp::cast(cosine.packed)]
        }
    }

    #[test]
    fn sine_and_cosine_are_right_and_alike_on_every_instruction_set() {
        let mut random = fastrand::Rng::with_seed(1);
        for round in 0..20_000 {
            let range = if round % 2 == 0 { 4.0 } else { 400.0 };
            let angles: [f32; LANES] = std::array::from_fn(|_| (random.f32() - 0.5) * 2.0 * range);
            let here = InstructionSet::default().run(SinCos(angles));
            assert_eq!(here, InstructionSet::Portable.run(SinCos(angles)));
            for lane in 0..LANES {
                let (sine, cosine) = f64::from(angles[lane]).sin_cos();
                assert!(
                    (f64::from(here[0][lane]) - sine).abs() < 3e-7,
                    "sine of {}",
                    angles[lane]
                );
                assert!(
                    (f64::from(here[1][lane]) - cosine).abs() < 3e-7,
                    "cosine of {}",
                    angles[lane]
                );
            }
        }
    }

    struct Bits(u8);

    impl EightWide for Bits {
        type Output = u8;
        #[inline(always)]
        fn run<S: Eight>(self, simd: S) -> u8 {
            Mask::from_bits(simd, self.0).bits()
        }
    }

    #[test]
    fn masks_and_bits_are_the_same() {
        for bits in 0..=255 {
            assert_eq!(InstructionSet::default().run(Bits(bits)), bits);
            assert_eq!(InstructionSet::Portable.run(Bits(bits)), bits);
        }
    }

    struct Extremes([f32; LANES], [f32; LANES]);

    impl EightWide for Extremes {
        type Output = [[u32; LANES]; 2];
        #[inline(always)]
        fn run<S: Eight>(self, simd: S) -> Self::Output {
            let a = Lanes::new(simd, pulp::cast(self.0));
            let b = Lanes::new(simd, pulp::cast(self.1));
            [pulp::cast(a.max(b).packed), pulp::cast(a.min(b).packed)]
        }
    }

    /// An arithmetic of its own once made proofs differ between machines: of a ball whose centre is
    /// in a box the approach is 0 / 0.
    #[test]
    fn what_is_no_number_is_treated_alike_on_every_instruction_set() {
        let a = [f32::NAN, 1.0, 0.0, -0.0, f32::INFINITY, 2.0, f32::NAN, -1.0];
        let b = [
            1.0,
            f32::NAN,
            -0.0,
            0.0,
            f32::NAN,
            3.0,
            f32::NAN,
            f32::NEG_INFINITY,
        ];
        let here = InstructionSet::default().run(Extremes(a, b));
        assert_eq!(here, InstructionSet::Portable.run(Extremes(a, b)));
        assert_eq!(f32::from_bits(here[0][0]), 1.0);
        assert!(f32::from_bits(here[1][1]).is_nan());
    }
}
