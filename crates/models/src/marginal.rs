//! What is expected of one entry of a measurement at one state.

use crate::batch::with_scratch;

/// `p(y_i | x)` of one entry of a measurement, and where what was measured lies in it.
///
/// Mixed over the particles of a prediction it is `p(y_i | y_{0:t−1})`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marginal {
    /// A draw; NaN where it cannot be drawn.
    pub drawn: f64,
    /// Its mean, or the draw where there is no formula for it; NaN where it has none.
    pub mean: f64,
    /// Its variance; 0 where the draw stands for the mean, and NaN where it is infinite.
    pub variance: f64,
    /// `P(Y < y)` of what was measured, or whether the draw is less; NaN where nothing was.
    pub below: f64,
    /// `P(Y = y)` of what was measured, likewise: above 0 for counts and other numbers with a probability of their own.
    pub at: f64,
    /// Whether it is an angle, of which numbers a turn apart are the same.
    pub is_angle: bool,
}

impl Marginal {
    /// What a draw alone says, of which many together are as good as the distribution.
    pub fn of_draw(drawn: f64, measured: Option<f64>) -> Self {
        let share = |of: fn(&f64, &f64) -> bool| match measured {
            Some(value) if !drawn.is_nan() => f64::from(u8::from(of(&drawn, &value))),
            _ => f64::NAN,
        };
        let (below, at) = (share(f64::lt), share(f64::eq));
        Marginal {
            drawn,
            mean: drawn,
            variance: if drawn.is_nan() { f64::NAN } else { 0.0 },
            below,
            at,
            is_angle: false,
        }
    }
}

/// What draws alone say: `draw` draws `K×M` numbers.
pub(crate) fn by_draws(measurement: &[Option<f64>], out: &mut [Marginal], draw: impl FnOnce(&mut [f64])) {
    with_scratch(out.len(), |drawn| {
        draw(drawn);
        for ((out, drawn), measured) in out.iter_mut().zip(drawn).zip(measurement.iter().cycle()) {
            *out = Marginal::of_draw(*drawn, *measured);
        }
    });
}
