//! Draws of the gamma distribution.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::rejection::{Rejection, Try, UNDECIDED};
use super::Needs;
use crate::Stream;
use crate::batch::by_widest_vectors;
use crate::equations::functions::{exp, exp_of_all, ln, ln_of_all};

/// That with scale 1, of its shape `a`: Marsaglia and Tsang's method (ACM Transactions on Mathematical Software 26, 2000).
///
/// With `d = a − ⅓` and a normal number `x`, `d v` for `v = (1 + x/√(9d))³` is accepted in nearly all tries. A shape below 1 is that of `a + 1` times `u^(1/a)` for
/// a uniform `u`.
pub(in crate::equations) struct StandardGamma;

/// `d`, and `1/√(9d)`; NaN for a shape that is out of range.
#[inline(always)]
fn centre(shape: f64) -> [f64; 2] {
    let large = if shape < 1.0 { shape + 1.0 } else { shape };
    let d = if (shape > 0.0) & (shape < f64::INFINITY) { large - 1.0 / 3.0 } else { f64::NAN };
    [d, 1.0 / (9.0 * d).sqrt()]
}

impl Rejection for StandardGamma {
    const NEEDS: Needs = Needs { normals: 1, exponentials: 0, uniforms: 2 };

    #[inline(always)]
    fn quick<const W: usize>(shape: &[f64; W], _: &[f64; W], random: &Try<[f64; W]>) -> [f64; W] {
        let [u, w] = &random.uniforms;
        let (mut drawn, mut base) = ([0.0; W], [0.0; W]);
        let is_small = by_widest_vectors(
            #[inline(always)]
            || {
                let mut is_small = false;
                for i in 0..W {
                    let [d, width] = centre(shape[i]);
                    let x = random.normal[i];
                    let root = 1.0 + width * x;
                    let square = x * x;
                    let is_accepted = (root > 0.0) & (u[i] < 1.0 - 0.0331 * square * square);
                    // NaN where d is.
                    drawn[i] = d * if is_accepted { root * root * root } else { UNDECIDED / d };
                    base[i] = 1.0 - w[i];
                    is_small |= shape[i] < 1.0;
                }
                is_small
            },
        );
        if is_small {
            let mut power = ln_of_all(&base);
            for (power, shape) in power.iter_mut().zip(shape) {
                *power = if *shape < 1.0 { *power / shape } else { 0.0 };
            }
            for (drawn, factor) in drawn.iter_mut().zip(exp_of_all(&power)) {
                *drawn *= if *drawn >= 0.0 { factor } else { 1.0 };
            }
        }
        drawn
    }

    fn draw(shape: f64, _: f64, first: Try<f64>, stream: &mut Stream) -> f64 {
        let [d, width] = centre(shape);
        if d.is_nan() {
            return f64::NAN;
        }
        let Try { normal: mut x, uniforms: [mut u, w] } = first;
        let drawn = loop {
            let root = 1.0 + width * x;
            let v = root * root * root;
            // Marsaglia and Tsang's test without their squeeze, which spares a logarithm and changes nothing.
            if root > 0.0 && ln(u) < 0.5 * x * x + d * (1.0 - v + ln(v)) {
                break d * v;
            }
            x = stream.sample(StandardNormal);
            u = stream.random();
        };
        if shape < 1.0 { drawn * exp(ln(1.0 - w) / shape) } else { drawn }
    }
}
