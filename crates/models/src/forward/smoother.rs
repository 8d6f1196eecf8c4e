//! Backward through the states of a filter: probabilities and trajectories given all measurements.

use rand::RngExt;

use super::error::ForwardError;
use super::filter::ForwardStep;
use super::layer::{Layer, key, places};
use super::probabilities::StateProbabilities;
use super::system::{FiniteSystem, Limits};
use crate::{Step, StepRecord, Stream};

/// What all measurements say.
#[derive(Debug, Clone, PartialEq)]
pub struct Backward {
    /// `p(x_t | y_{0:T−1})` at each step.
    pub beliefs: Vec<StateProbabilities>,
    /// Trajectories that were drawn from `p(x_{0:T−1} | y_{0:T−1})`, path after path, each `T×N`.
    pub paths: Vec<f64>,
}

/// A way from a state to one of the layer behind it.
struct Way {
    from: usize,
    to: usize,
    probability: f64,
}

/// Goes back through the filter's steps, and draws a trajectory from each stream:
///
/// - `p(x_{t−1} | y_{0:T−1}) = p(x_{t−1} | y_{0:t−1}) Σ p(x_t | x_{t−1}) p(x_t | y_{0:T−1}) / p(x_t | y_{0:t−1})`
/// - `x_{t−1}` is drawn given `x_t` in proportion to `p(x_t | x_{t−1}) p(x_{t−1} | y_{0:t−1})`.
///
/// # Errors
/// [`ForwardError`] as the filter's own.
pub fn smooth_states(
    model: &(impl FiniteSystem + ?Sized),
    steps: &[(StepRecord, ForwardStep)],
    limits: Limits,
    streams: &mut [Stream],
) -> Result<Backward, ForwardError> {
    let n = model.state_dim();
    // Each layer with the step that leads to it; none where no time passes.
    let layers: Vec<(&Layer, Option<Step<'_>>)> = steps
        .iter()
        .flat_map(|(record, step)| {
            let of = record.step();
            step.layers.iter().enumerate().map(move |(part, layer)| {
                (layer, (of.sub_steps > 0).then(|| of.part(part, model.input_dim())))
            })
        })
        .collect();
    let Some(((last, _), _)) = layers.split_last() else {
        return Ok(Backward { beliefs: Vec::new(), paths: Vec::new() });
    };
    let mut smoothed: Vec<Vec<f64>> = vec![last.filtered.clone()];
    let mut chosen: Vec<Vec<usize>> =
        vec![streams.iter_mut().map(|stream| last.belief().at(stream.random())).collect()];
    for pair in layers.windows(2).rev() {
        let [(before, _), (after, part)] = pair else { continue };
        let ways = ways(model, before, after, part.as_ref(), limits)?;
        let later = smoothed.last().map_or(&[][..], Vec::as_slice);
        let mut own = vec![0.0; before.filtered.len()];
        for Way { from, to, probability } in &ways {
            let predicted = after.predicted.probabilities()[*to];
            if predicted > 0.0 {
                own[*from] += before.filtered[*from] * probability * later[*to] / predicted;
            }
        }
        let sum: f64 = own.iter().sum();
        own.iter_mut().for_each(|own| *own /= sum);
        let at = chosen.last().map_or(&[][..], Vec::as_slice);
        let mut back = Vec::with_capacity(at.len());
        for (stream, to) in streams.iter_mut().zip(at) {
            back.push(chosen_way(&ways, before, *to, stream.random()));
        }
        smoothed.push(own);
        chosen.push(back);
    }
    smoothed.reverse();
    chosen.reverse();
    // The last layer of each step.
    let ends: Vec<usize> = steps
        .iter()
        .scan(0, |count, (_, step)| {
            *count += step.layers.len();
            Some(*count - 1)
        })
        .collect();
    let belief = |at: &usize| {
        let states = layers[*at].0.predicted.states().to_vec();
        StateProbabilities::of(n, states, smoothed[*at].clone())
    };
    let path = |path: usize| {
        let (layers, chosen) = (&layers, &chosen);
        ends.iter().flat_map(move |at| layers[*at].0.predicted.state(chosen[*at][path]).iter().copied())
    };
    Ok(Backward {
        beliefs: ends.iter().map(belief).collect(),
        paths: (0..streams.len()).flat_map(path).collect(),
    })
}

/// All ways from the states of a layer that have a probability to those of the next.
fn ways(
    model: &(impl FiniteSystem + ?Sized),
    before: &Layer,
    after: &Layer,
    part: Option<&Step<'_>>,
    limits: Limits,
) -> Result<Vec<Way>, ForwardError> {
    let mut found = Vec::new();
    let Some(part) = part else {
        found.extend((0..before.filtered.len()).map(|at| Way { from: at, to: at, probability: 1.0 }));
        return Ok(found);
    };
    let (places, mut left) = (places(&after.predicted), limits.ways);
    for (from, (state, _)) in before.predicted.iter().enumerate() {
        if before.filtered[from] > 0.0 {
            model.branches(part, Some(state), &mut left, &mut |state, probability| {
                // The filter found all of them.
                if let Some(to) = places.get(&key(state)) {
                    found.push(Way { from, to: *to, probability });
                }
            })?;
        }
    }
    Ok(found)
}

/// The state that a way to another one comes from, at a place between 0 and 1 on the sum of the probabilities of all such ways.
fn chosen_way(ways: &[Way], before: &Layer, to: usize, place: f64) -> usize {
    let own = |way: &Way| if way.to == to { before.filtered[way.from] * way.probability } else { 0.0 };
    let all: f64 = ways.iter().map(own).sum();
    let mut below = 0.0;
    let reached = ways.iter().find(|way| {
        below += own(way);
        own(way) > 0.0 && place * all < below
    });
    let last = || ways.iter().rfind(|way| own(way) > 0.0);
    reached.or_else(last).map_or(0, |way| way.from)
}
