//! A monotone spline of rational quadratic pieces with the identity outside: each number has its own.

use motes_models::batch::LANES;
use motes_models::equations::{Dual, Lanes, Scalar};

/// The spline maps `[−B, B]` onto itself, and is the identity outside.
const BOUND: f64 = 4.0;

/// The least width and height of a piece, as a share of all.
const LEAST_SHARE: f64 = 1e-3;

/// The least slope at a knot.
const LEAST_SLOPE: f64 = 1e-3;

/// A spline of so many pieces (Durkan et al. 2019): its parameters are the logarithms of shares of widths and of heights, and what the slopes at inner knots are
/// made of. All 0 is the identity.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spline {
    pub(super) pieces: usize,
}

/// One piece for each particle: from `(x, y)`, `width` wide and `height` high, with the slopes at its ends.
#[derive(Clone, Copy)]
struct Piece<S> {
    x: S,
    width: S,
    y: S,
    height: S,
    slopes: [S; 2],
}

/// A number with derivatives along itself and the six numbers of its piece.
type Varied = Dual<Lanes, 8>;

/// What a spline made of a number, with derivatives of `log φ(z) + log z'` along its argument and its parameters.
pub(super) struct Evaluated {
    /// `z`.
    pub(super) value: Lanes,
    /// `log z'`.
    pub(super) log_slope: Lanes,
}

/// `softplus(θ + c)` with the `c` that makes 1 of 0, above [`LEAST_SLOPE`]; and its derivative.
#[inline(always)]
fn slope(theta: Lanes) -> [Lanes; 2] {
    // log(e − 1), less what is added.
    let start = ((1.0 - LEAST_SLOPE).exp() - 1.0).ln();
    let moved = theta + start;
    // Without overflow on either side.
    let small = (-moved.abs()).exp();
    let zero = Lanes::from(0.0);
    let value = moved.max(zero) + (small + 1.0).ln();
    let logistic = moved.where_positive(Lanes::from(1.0), small) / (small + 1.0);
    [value + LEAST_SLOPE, logistic]
}

impl Spline {
    /// How many parameters there are.
    pub(super) fn outputs(self) -> usize {
        3 * self.pieces - 1
    }

    /// How many entries of scratch it takes: shares and knots of both axes.
    pub(super) fn scratch(self) -> usize {
        4 * self.pieces + 2
    }

    /// Shares that sum to 1 of `logs`, and the knots between them.
    #[inline(always)]
    fn knots(self, logs: &[Lanes], shares: &mut [Lanes], knots: &mut [Lanes]) {
        let largest = logs.iter().fold(Lanes::from(f64::NEG_INFINITY), |largest, log| largest.max(*log));
        let mut sum = Lanes::from(0.0);
        for (share, log) in shares.iter_mut().zip(logs) {
            *share = (*log - largest).exp();
            sum = sum + *share;
        }
        knots[0] = Lanes::from(-BOUND);
        for (at, share) in shares.iter_mut().enumerate() {
            *share = *share / sum;
            let stretched = *share * (1.0 - LEAST_SHARE * self.pieces as f64) + LEAST_SHARE;
            knots[at + 1] = knots[at] + stretched * (2.0 * BOUND);
        }
    }

    /// Shares and knots of both axes, in `scratch`: widths, heights, knots of the argument, knots of the value.
    #[inline(always)]
    fn prepare(self, theta: &[Lanes], scratch: &mut [Lanes]) {
        let k = self.pieces;
        let (shares, knots) = scratch.split_at_mut(2 * k);
        let (widths, heights) = shares.split_at_mut(k);
        let (xs, ys) = knots.split_at_mut(k + 1);
        self.knots(&theta[..k], widths, xs);
        self.knots(&theta[k..2 * k], heights, ys);
    }

    /// The number of the piece that holds `value` of each particle, between these knots; none outside of all.
    #[inline(always)]
    fn find(self, value: Lanes, knots: &[Lanes]) -> [Option<usize>; LANES] {
        std::array::from_fn(|lane| {
            let value = value.0[lane];
            if !(value > -BOUND && value < BOUND) {
                return None;
            }
            let below = knots[1..self.pieces].iter().take_while(|knot| knot.0[lane] <= value).count();
            Some(below)
        })
    }

    /// The piece of each particle, and the derivatives of its slopes; any piece where there is none.
    #[inline(always)]
    fn piece(
        self,
        theta: &[Lanes],
        scratch: &[Lanes],
        at: &[Option<usize>; LANES],
    ) -> (Piece<Lanes>, [Lanes; 2]) {
        let k = self.pieces;
        let (xs, ys) = scratch[2 * k..].split_at(k + 1);
        let one = Lanes::from(1.0);
        let mut piece = Piece { x: -one, width: one, y: -one, height: one, slopes: [one; 2] };
        // What slopes are made of; the slopes at both outer ends are 1.
        let mut raw = [Lanes::from(0.0); 2];
        for (lane, at) in at.iter().enumerate() {
            let Some(at) = *at else { continue };
            piece.x.0[lane] = xs[at].0[lane];
            piece.width.0[lane] = xs[at + 1].0[lane] - xs[at].0[lane];
            piece.y.0[lane] = ys[at].0[lane];
            piece.height.0[lane] = ys[at + 1].0[lane] - ys[at].0[lane];
            if at > 0 {
                raw[0].0[lane] = theta[2 * k + at - 1].0[lane];
            }
            if at + 1 < k {
                raw[1].0[lane] = theta[2 * k + at].0[lane];
            }
        }
        let [left, right] = raw.map(slope);
        piece.slopes = [left[0], right[0]];
        (piece, [left[1], right[1]])
    }

    /// `z` of `r`, and `log z'`; [`Spline::gradient`] asks the scratch that it leaves.
    #[inline(always)]
    pub(super) fn evaluate(self, theta: &[Lanes], r: Lanes, scratch: &mut [Lanes]) -> Evaluated {
        self.prepare(theta, scratch);
        let at = self.find(r, &scratch[2 * self.pieces..]);
        let (piece, _) = self.piece(theta, scratch, &at);
        let [value, log_slope] = piece.evaluate(r);
        let mut found = Evaluated { value: r, log_slope: Lanes::from(0.0) };
        for (lane, at) in at.iter().enumerate() {
            if at.is_some() {
                found.value.0[lane] = value.0[lane];
                found.log_slope.0[lane] = log_slope.0[lane];
            }
        }
        found
    }

    /// Derivatives of `−½ z² + log z'`: along `r`, which is returned, and along the parameters, into `d_theta`; from the scratch that
    /// [`Spline::evaluate`] left.
    #[inline(always)]
    pub(super) fn gradient(
        self,
        theta: &[Lanes],
        r: Lanes,
        scratch: &[Lanes],
        d_theta: &mut [Lanes],
    ) -> Lanes {
        // Outside it is the identity.
        let density = |[value, log_slope]: [Varied; 2]| log_slope - value * value * 0.5;
        self.derivatives(theta, r, scratch, d_theta, -r, density)
    }

    /// Derivatives of `z`: along `r`, which is returned, and along the parameters, into `d_theta`; from the scratch that [`Spline::evaluate`] left.
    #[inline(always)]
    pub(super) fn value_gradient(
        self,
        theta: &[Lanes],
        r: Lanes,
        scratch: &[Lanes],
        d_theta: &mut [Lanes],
    ) -> Lanes {
        self.derivatives(theta, r, scratch, d_theta, Lanes::from(1.0), |[value, _]| value)
    }

    /// Derivatives of what `of` makes of `z` and `log z'`; `outside` is the one along `r` where the spline is the identity.
    #[inline(always)]
    fn derivatives(
        self,
        theta: &[Lanes],
        r: Lanes,
        scratch: &[Lanes],
        d_theta: &mut [Lanes],
        outside: Lanes,
        of: impl Fn([Varied; 2]) -> Varied,
    ) -> Lanes {
        let k = self.pieces;
        let at = self.find(r, &scratch[2 * k..]);
        let (piece, of_slopes) = self.piece(theta, scratch, &at);
        let variable = |value: Lanes, direction: usize| Varied::variable(value, direction);
        let varied = Piece {
            x: variable(piece.x, 1),
            width: variable(piece.width, 2),
            y: variable(piece.y, 3),
            height: variable(piece.height, 4),
            slopes: [variable(piece.slopes[0], 5), variable(piece.slopes[1], 6)],
        };
        let found = of(varied.evaluate(variable(r, 0)));
        let along = found.derivatives();
        d_theta.fill(Lanes::from(0.0));
        let mut d_r = outside;
        // Of the stretched shares: a piece's own, and those before it, which move its beginning.
        let stretch = 2.0 * BOUND * (1.0 - LEAST_SHARE * k as f64);
        for (lane, at) in at.iter().enumerate() {
            let Some(at) = *at else { continue };
            d_r.0[lane] = along[0].0[lane];
            for (axis, [begin, length]) in [[1, 2], [3, 4]].into_iter().enumerate() {
                for share in 0..at {
                    d_theta[axis * k + share].0[lane] = along[begin].0[lane] * stretch;
                }
                d_theta[axis * k + at].0[lane] = along[length].0[lane] * stretch;
            }
            if at > 0 {
                d_theta[2 * k + at - 1].0[lane] = along[5].0[lane] * of_slopes[0].0[lane];
            }
            if at + 1 < k {
                d_theta[2 * k + at].0[lane] = along[6].0[lane] * of_slopes[1].0[lane];
            }
        }
        // Through the shares, which sum to 1.
        for axis in 0..2 {
            let shares = &scratch[axis * k..(axis + 1) * k];
            let d_logs = &mut d_theta[axis * k..(axis + 1) * k];
            let mut mean = Lanes::from(0.0);
            for (share, d) in shares.iter().zip(&*d_logs) {
                mean = mean + *share * *d;
            }
            for (share, d) in shares.iter().zip(d_logs) {
                *d = *share * (*d - mean);
            }
        }
        d_r
    }

    /// The `r` of `z`.
    #[inline(always)]
    pub(super) fn invert(self, theta: &[Lanes], z: Lanes, scratch: &mut [Lanes]) -> Lanes {
        self.prepare(theta, scratch);
        let at = self.find(z, &scratch[3 * self.pieces + 1..]);
        let (piece, _) = self.piece(theta, scratch, &at);
        let inside = piece.invert(z);
        let mut found = z;
        for (lane, at) in at.iter().enumerate() {
            if at.is_some() {
                found.0[lane] = inside.0[lane];
            }
        }
        found
    }
}

impl<S: Scalar> Piece<S> {
    /// `z` and `log z'` at `r`.
    #[inline(always)]
    fn evaluate(self, r: S) -> [S; 2] {
        let Piece { x, width, y, height, slopes: [left, right] } = self;
        let (steep, xi) = (height / width, (r - x) / width);
        let rest = -xi + 1.0;
        let both = xi * rest;
        let denominator = steep + (left + right - steep * 2.0) * both;
        let value = y + height * (steep * xi * xi + left * both) / denominator;
        let rise = right * xi * xi + steep * both * 2.0 + left * rest * rest;
        [value, (steep * steep * rise / (denominator * denominator)).ln()]
    }
}

impl Piece<Lanes> {
    /// The `r` whose `z` this is: the root of a quadratic.
    #[inline(always)]
    fn invert(self, z: Lanes) -> Lanes {
        let Piece { x, width, y, height, slopes: [left, right] } = self;
        let (steep, above) = (height / width, z - y);
        let bend = left + right - steep * 2.0;
        let a = height * (steep - left) + above * bend;
        let b = height * left - above * bend;
        let c = -(steep * above);
        let discriminant = (b * b - a * c * 4.0).max(Lanes::from(0.0));
        x + width * (c * 2.0) / (-b - discriminant.sqrt())
    }
}
