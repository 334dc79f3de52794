//! Four numbers side by side, in plain Rust that the compiler turns into vector instructions.
//!
//! Nothing here fuses a product with a sum, so that results have the same bytes with any instruction
//! set: only the speed depends on the processor.

use crate::geometry::Vector3;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// Four numbers: x, y, z of one particle and a zero, or four sums.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; 4]);

impl Lanes {
    pub const ZERO: Self = Self([0.0; 4]);

    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; 4])
    }

    #[inline(always)]
    pub fn of(v: &Vector3) -> Self {
        Self([v.x, v.y, v.z, 0.0])
    }

    #[inline(always)]
    pub fn xyz(self) -> Vector3 {
        Vector3::new(self.0[0], self.0[1], self.0[2])
    }

    /// Zero where a number is negative, or none.
    #[inline(always)]
    pub fn positive(self) -> Self {
        let [a, b, c, d] = self.0;
        let positive = |x: f64| if x > 0.0 { x } else { 0.0 };
        Self([positive(a), positive(b), positive(c), positive(d)])
    }

    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        Self([a + p, b + q, c + r, d + s])
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        Self([a - p, b - q, c - r, d - s])
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        Self([a * p, b * q, c * r, d * s])
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
