//! Draws of the gamma distribution.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::needs::Needs;
use super::rejection::{Rejection, Try, UNDECIDED};
use crate::Stream;
use crate::batch::by_widest_vectors;
use crate::equations::functions::{exp, exp_of_all, ln, ln_of_all};

/// That with scale 1, of its shape `a`: Marsaglia and Tsang's method (ACM Transactions on Mathematical Software 26, 2000).
///
/// With `d = a − ⅓` and a normal number `x`, `d v` for `v = (1 + x/√(9d))³` is accepted with probability `e^h`, `h = ½x² + d (1 − v + log v)`, which is nearly 1. A shape
/// below 1 is that of `a + 1` times `w^(1/a)` for a uniform `w`.
pub(in crate::equations) struct StandardGamma;

/// `d`, and `1/√(9d)`; NaN for a shape that is out of range.
#[inline(always)]
fn centre(shape: f64) -> [f64; 2] {
    let large = if shape < 1.0 { shape + 1.0 } else { shape };
    let d = if (shape > 0.0) & (shape < f64::INFINITY) { large - 1.0 / 3.0 } else { f64::NAN };
    [d, 1.0 / (9.0 * d).sqrt()]
}

/// Bounds of the probability `e^h` that a normal number `x` is accepted, from below and from above.
///
/// With `y = x/√(9d)` it is `h = 3d (log(1 + y) − y + ½y² − ⅓y³)`. The bracket is at least `−y⁴/4` above 0, and `−0.4237 y⁴` down to `y = −½`; there `e^h ≥ 1 + h` is closer,
/// the larger the shape, than Marsaglia and Tsang's bound for all shapes from 1 on, which is taken below. The bracket is at most `−y⁴/4 + y⁵/5`, and `e^h ≤ 1 + h + ½h²`.
#[inline(always)]
fn bounds(width: f64, x: f64) -> [f64; 2] {
    let (y, square) = (width * x, x * x);
    let fourth = square * square;
    let scaled = width * width;
    let near = if y > 0.0 { scaled * (1.0 / 12.0) } else { scaled * 0.14124 };
    let share = if y > -0.5 { near } else { 0.0331 };
    let above = scaled * fourth * (y * (1.0 / 15.0) - 1.0 / 12.0);
    // Beyond `y = 5/4` the bound of h is positive.
    [1.0 - share * fourth, if above < 0.0 { 1.0 + above * (1.0 + 0.5 * above) } else { 1.0 }]
}

impl Rejection for StandardGamma {
    const NEEDS: Needs = Needs { normals: 1, exponentials: 0, uniforms: 1 };

    #[inline(always)]
    fn quick<const W: usize>(shape: &[f64; W], _: &[f64; W], random: &Try<&[f64; W]>, drawn: &mut [f64; W]) {
        let [u, _] = random.uniforms;
        let mut base = [0.0; W];
        let is_small = by_widest_vectors(
            #[inline(always)]
            || {
                let mut is_small = false;
                for i in 0..W {
                    let [d, width] = centre(shape[i]);
                    let x = random.normal[i];
                    let root = 1.0 + width * x;
                    let [sure, possible] = bounds(width, x);
                    let is_accepted = (root > 0.0) & (u[i] < sure);
                    let is_undecided = (root > 0.0) & (u[i] < possible);
                    let otherwise = if is_undecided { UNDECIDED } else { f64::NAN };
                    let found = if is_accepted { d * (root * root * root) } else { otherwise };
                    drawn[i] = if d > 0.0 { found } else { f64::NAN };
                    // Below its bound `u` is uniform again.
                    base[i] = if is_accepted { 1.0 - u[i] / sure } else { 1.0 };
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
    }

    #[inline(always)]
    fn draw(shape: f64, _: f64, first: Try<f64>, stream: &mut Stream) -> f64 {
        let [d, width] = centre(shape);
        if d.is_nan() {
            return f64::NAN;
        }
        let Try { normal: mut x, uniforms: [mut u, _] } = first;
        let drawn = loop {
            let root = 1.0 + width * x;
            let v = root * root * root;
            let [sure, possible] = bounds(width, x);
            if root > 0.0 && (u < sure || (u < possible && ln(u) < 0.5 * x * x + d * (1.0 - v + ln(v)))) {
                break d * v;
            }
            x = stream.sample(StandardNormal);
            u = stream.random();
        };
        if shape < 1.0 { drawn * exp(ln(1.0 - stream.random::<f64>()) / shape) } else { drawn }
    }
}

#[cfg(test)]
mod tests {
    use statrs::function::gamma::gamma_lr;

    use super::super::rejection::draw_all;
    use super::*;
    use crate::Seed;

    /// Catches a first try that is thrown away where the quick test does not decide it: what is left would be another distribution.
    #[test]
    fn draws_of_all_shapes_have_their_distribution() {
        const TILES: usize = 10_000;
        let mut stream = Seed::from_u64(3).stream();
        for shape in [0.05, 0.355, 0.9, 1.0, 1.7, 6.0, 250.0] {
            let mut drawn = Vec::new();
            for _ in 0..TILES {
                let normal = [(); 32].map(|()| stream.sample(StandardNormal));
                let uniforms = [[(); 32]; 2].map(|lanes| lanes.map(|()| stream.random()));
                let random = Try { normal: &normal, uniforms: uniforms.each_ref() };
                let (shapes, mut tile) = ([shape; 32], [0.0; 32]);
                draw_all::<StandardGamma, 32>(&shapes, &shapes, &random, 32, &mut stream, &mut tile);
                drawn.extend(tile);
            }
            let count = drawn.len() as f64;
            for part in [0.3, 0.8, 1.0, 1.1, 2.5] {
                let p = gamma_lr(shape, part * shape);
                let below = drawn.iter().filter(|drawn| **drawn < part * shape).count() as f64;
                let z = (below - p * count) / (p * (1.0 - p) * count).sqrt().max(1.0);
                assert!(z.abs() < 4.0, "shape {shape}, below {part}: z = {z}");
            }
        }
    }

    /// Catches bounds that are crossed, by which rejected tries would be drawn, or accepted ones tried again.
    #[test]
    fn the_probability_of_acceptance_lies_between_its_bounds() {
        for shape in [1.0, 1.001, 1.355, 2.0, 7.5, 100.0, 1e6] {
            let [d, width] = centre(shape);
            for step in -90_000..=90_000 {
                let x = 1e-4 * f64::from(step);
                let root = 1.0 + width * x;
                let v = root * root * root;
                let share = if root > 0.0 { (0.5 * x * x + d * (1.0 - v + v.ln())).exp() } else { 0.0 };
                let [sure, possible] = bounds(width, x);
                // The share itself is rounded where large numbers cancel.
                let rounding = 1e-15 * d.max(1.0);
                assert!(
                    root <= 0.0 || (sure <= share + rounding && share <= possible + rounding),
                    "shape {shape}, x = {x}: {sure}, {share}, {possible}"
                );
                assert!(
                    (sure > 0.97 * share - 0.02 && possible < share + 0.02) || x.abs() > 1.2,
                    "shape {shape}, x = {x}: {sure}, {share}, {possible}"
                );
            }
        }
    }

    #[test]
    fn a_shape_out_of_range_is_no_number() {
        let mut stream = Seed::from_u64(3).stream();
        let random = Try { normal: 0.1, uniforms: [0.5; 2] };
        for shape in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(StandardGamma::draw(shape, shape, random, &mut stream).is_nan(), "{shape}");
            let side_by_side = Try { normal: &[0.1; 4], uniforms: [&[0.5; 4]; 2] };
            let (shapes, mut tile) = ([shape; 4], [0.0; 4]);
            draw_all::<StandardGamma, 4>(&shapes, &shapes, &side_by_side, 4, &mut stream, &mut tile);
            assert!(tile[0].is_nan(), "{shape}");
        }
    }
}
