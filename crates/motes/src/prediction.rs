//! What particles predict where none of them explains the measurement.

use motes_models::batch::Rows;
use motes_models::{Seed, Simulator, StateSpaceModel, Step};

/// So many particles say what the others would.
pub(crate) const MOST: usize = 1000;

/// So many entries of a measurement are named.
const NAMED: usize = 3;

/// Beyond so many, entries are not weighed one by one.
const WEIGHED: usize = 64;

/// A measurement beside what particles predict.
pub(crate) struct BesidePrediction {
    /// Which entries are where nothing is predicted; empty where nothing is measured.
    words: String,
    /// Whether particles can draw these entries at all.
    is_drawn: bool,
}

impl BesidePrediction {
    /// Why nothing explains the measurement, and what would help; `ess_before` is the effective sample size of particles, of which there are none where answers are exact.
    pub(crate) fn explained(&self, ess_before: Option<f64>) -> String {
        let BesidePrediction { words, is_drawn } = self;
        let (who, before, more) = match ess_before {
            None => ("state", String::new(), "give"),
            Some(ess) => (
                "particle",
                format!(" (the effective sample size before was {ess:.0})"),
                "take more particles or --proposal linearised, or give",
            ),
        };
        let cure = match is_drawn {
            true => {
                format!("correct it if it is wrong, else {more} the measurement more noise or heavier tails")
            }
            false => "look at the parameters of its distribution there, and at the inputs of this row".into(),
        };
        format!("no {who} explains the measurement: {words}{before}; {cure}")
    }
}

/// One entry of a measurement beside what is predicted for it.
struct Beside {
    entry: usize,
    value: f64,
    /// Mean, standard deviation, smallest and largest of what was drawn; none where nothing can be.
    drawn: Option<[f64; 4]>,
    /// Its distribution at the state from which the nearest value was drawn, where the model's formulas say.
    nearest: Option<String>,
    /// Whether it has density 0 at all states that were drawn.
    is_impossible: bool,
}

impl Beside {
    /// How far the value is from the mean, in standard deviations.
    fn distance(&self) -> f64 {
        let distance = |[mean, sd, ..]: [f64; 4]| (self.value - mean).abs() / sd.max(f64::MIN_POSITIVE);
        self.drawn.map_or(f64::INFINITY, distance)
    }
}

/// Draws `x_t`, given states before (`K×N`) or from `p(x_0)` where there are none, and `y_t`, and says in words which entries of the measurement (`M`) are where
/// nothing is predicted: those of density 0 at all that was drawn, or else those that are farthest off. `names` are those of the entries, and `distribution` writes that of an
/// entry at a state.
pub(crate) fn beside_prediction<M: Simulator + ?Sized>(
    model: &M,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    measurement: &[Option<f64>],
    names: &[String],
    distribution: &dyn Fn(usize, &[f64]) -> Option<String>,
) -> BesidePrediction {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let particles = previous.map_or(MOST, |previous| previous.len() / n);
    let mut streams = [Seed::from_u64(0).child("prediction").stream()];
    let (mut states, mut drawn) = (vec![0.0; particles * n], vec![0.0; particles * m]);
    model.sample_states(step, previous.map(|rows| Rows::all(rows, n)), &mut streams, &mut states);
    model.sample_measurements(step, &states, &mut streams, &mut drawn);
    let beside = |(entry, value): (usize, &Option<f64>)| {
        let value = (*value)?;
        let of_entry = || drawn.iter().skip(entry).step_by(m).copied();
        let distance = |drawn: f64| if drawn.is_finite() { (drawn - value).abs() } else { f64::INFINITY };
        let nearest = of_entry().zip(states.chunks_exact(n));
        let nearest = nearest.min_by(|(a, _), (b, _)| distance(*a).total_cmp(&distance(*b)));
        let nearest = nearest.and_then(|(_, state)| distribution(entry, state));
        let is_impossible = m <= WEIGHED && is_impossible(model, step, &states, entry, value);
        Some(Beside { entry, value, drawn: summary(of_entry()), nearest, is_impossible })
    };
    let mut all: Vec<Beside> = measurement.iter().enumerate().filter_map(beside).collect();
    all.sort_by(|a, b| {
        (b.is_impossible, b.distance())
            .partial_cmp(&(a.is_impossible, a.distance()))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    if all.iter().any(|beside| beside.is_impossible) {
        all.retain(|beside| beside.is_impossible);
    }
    let words = |beside: &Beside| {
        let (name, value) = (names.get(beside.entry).map_or("y", String::as_str), exact(beside.value));
        let nearest = |before: &str| {
            beside
                .nearest
                .as_ref()
                .map_or_else(String::new, |written| format!("{before}{written} at the nearest"))
        };
        let Some([mean, sd, low, high]) = beside.drawn.map(|drawn| drawn.map(short)) else {
            return format!(
                "{name} is {value}, and no particle can draw it{}",
                nearest("; its distribution is ")
            );
        };
        let nearest = nearest(", and its distribution is ");
        format!("{name} is {value}, where the particles predict {mean} ± {sd}, from {low} to {high}{nearest}")
    };
    let more = if all.len() > NAMED { format!("; and {} more", all.len() - NAMED) } else { String::new() };
    let named = &all[..all.len().min(NAMED)];
    BesidePrediction {
        words: named.iter().map(words).collect::<Vec<_>>().join("; ") + &more,
        is_drawn: named.iter().all(|beside| beside.drawn.is_some()),
    }
}

/// Whether one entry of a measurement has density 0 at all states.
fn is_impossible<M: StateSpaceModel + ?Sized>(
    model: &M,
    step: &Step<'_>,
    states: &[f64],
    entry: usize,
    value: f64,
) -> bool {
    let mut alone = vec![None; model.measurement_dim()];
    alone[entry] = Some(value);
    let mut densities = vec![f64::NAN; states.len() / model.state_dim()];
    let weighed = model.log_likelihoods(step, states, &alone, &mut densities);
    weighed.is_ok() && densities.iter().all(|density| *density == f64::NEG_INFINITY)
}

/// Mean, standard deviation, smallest and largest of finite numbers.
fn summary(values: impl Iterator<Item = f64>) -> Option<[f64; 4]> {
    let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    let count = values.len() as f64;
    let mean = values.iter().map(|value| value / count).sum::<f64>();
    let variance = values.iter().map(|value| (value - mean) * (value - mean) / count).sum::<f64>();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (!values.is_empty()).then_some([mean, variance.sqrt(), low, high])
}

/// A number in three digits.
fn short(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if size == 0.0 || !size.is_finite() => value.to_string(),
        _ if (1e-3..1e6).contains(&size) => {
            let decimals = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.2e}"),
    }
}

/// A number with all its digits.
fn exact(value: f64) -> String {
    match value == 0.0 || (1e-5..1e16).contains(&value.abs()) {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}
