//! Numbers of the standard distributions in bulk: normal, exponential, uniform.

use std::f64::consts::FRAC_PI_2;

use crate::Stream;
use crate::bulk::{Transform, fill};
use crate::elementary::{ln, sin_cos};

/// Fills `out` with independent standard normal numbers, in vector instructions.
///
/// They are Box and Muller's transform of 53-bit uniforms. Every number is finite and below 8.6 in size, and the tails are right
/// up to there.
///
/// Up to 16 numbers take 128 bytes of the stream. More take 256 bytes, however many: they come from generators that start there.
/// The same stream gives the same numbers, whatever vector instructions the machine has.
///
/// ```
/// use motes_models::{Seed, fill_standard_normal};
///
/// let mut noise = [0.0; 1000];
/// fill_standard_normal(&mut Seed::from_u64(3).stream(), &mut noise);
/// assert!(noise.iter().sum::<f64>().abs() < 4.0 * 1000.0_f64.sqrt());
/// ```
pub fn fill_standard_normal(stream: &mut Stream, out: &mut [f64]) {
    fill::<Normal>(stream, out);
}

/// Fills `out` with independent numbers of the exponential distribution with mean 1, each in `[0, 36.8]`.
///
/// Takes as much of the stream as [`fill_standard_normal`].
pub fn fill_standard_exponential(stream: &mut Stream, out: &mut [f64]) {
    fill::<Exponential>(stream, out);
}

/// Fills `out` with independent numbers, uniform on the multiples of `2⁻⁵³` in `[0, 1)`.
///
/// Takes as much of the stream as [`fill_standard_normal`].
pub fn fill_uniform(stream: &mut Stream, out: &mut [f64]) {
    fill::<Uniform>(stream, out);
}

/// `2⁻⁵³`.
const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;

/// Uniform on `[0, 1)`, of the upper 53 bits.
#[inline(always)]
fn from_zero(bits: u64) -> f64 {
    (bits >> 11) as f64 * UNIT
}

/// Uniform on `(0, 1]`, of the upper 53 bits.
#[inline(always)]
fn up_to_one(bits: u64) -> f64 {
    ((bits >> 11) + 1) as f64 * UNIT
}

struct Normal;

impl Transform for Normal {
    /// A radius `√(−2 ln u)` and an angle. 53 bits place the angle within an eighth of the circle to either side of an axis. Two
    /// other bits choose the axis.
    #[inline(always)]
    fn pairs<const L: usize>(a: &[u64; L], b: &[u64; L], x: &mut [f64; L], y: &mut [f64; L]) {
        // In one loop, so that a processor divides and takes roots while it multiplies for the angle.
        for i in 0..L {
            let size = (-2.0 * ln(up_to_one(a[i]))).sqrt();
            let (sin, cos) = sin_cos((from_zero(b[i]) - 0.5) * FRAC_PI_2);
            let radius = f64::from_bits(size.to_bits() ^ (b[i] << 63));
            let upright = b[i] & 2 != 0;
            x[i] = radius * if upright { sin } else { cos };
            y[i] = radius * if upright { cos } else { sin };
        }
    }
}

struct Exponential;

impl Transform for Exponential {
    #[inline(always)]
    fn pairs<const L: usize>(a: &[u64; L], b: &[u64; L], x: &mut [f64; L], y: &mut [f64; L]) {
        for (i, x) in x.iter_mut().enumerate() {
            *x = -ln(up_to_one(a[i]));
        }
        for (i, y) in y.iter_mut().enumerate() {
            *y = -ln(up_to_one(b[i]));
        }
    }
}

struct Uniform;

impl Transform for Uniform {
    #[inline(always)]
    fn pairs<const L: usize>(a: &[u64; L], b: &[u64; L], x: &mut [f64; L], y: &mut [f64; L]) {
        for i in 0..L {
            x[i] = from_zero(a[i]);
            y[i] = from_zero(b[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made<T: Transform>(a: u64, b: u64) -> [f64; 2] {
        let (mut x, mut y) = ([f64::NAN], [f64::NAN]);
        T::pairs(&[a], &[b], &mut x, &mut y);
        [x[0], y[0]]
    }

    #[test]
    fn the_outermost_bits_give_finite_numbers() {
        for a in [0, 1, 1 << 11, u64::MAX, u64::MAX << 11] {
            for b in [0, 1, 2, 3, 1 << 63, u64::MAX] {
                let [x, y] = made::<Normal>(a, b);
                assert!(x.is_finite() && y.is_finite() && x.hypot(y) < 8.6);
                assert!(made::<Exponential>(a, b).iter().all(|x| (0.0..36.8).contains(x)));
                assert!(made::<Uniform>(a, b).iter().all(|x| (0.0..1.0).contains(x)));
            }
        }
        let [x, y] = made::<Normal>(0, 1 << 63);
        assert!(x > 8.5 && y == 0.0, "the tail reaches {x}");
    }
}
