//! What a training learns from: sequences of measurements, recorded or drawn anew.

use std::borrow::Cow;

use motes_models::{MeasurementSource, Measurements, StateGradients, Stream};
use motes_proposals::Learnable;
use rand::seq::index::sample;

use crate::TrainError;
use crate::fit::{check_measurements, check_pair};

/// What a training learns from.
///
/// One sequence, a slice, an array or a vector of them become [`TrainingData::Recorded`] by themselves.
///
/// A proposal for any sequence of a model, learned from what the model simulates:
///
/// ```
/// use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, SimulatedMeasurements};
/// use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, OverTime};
/// use motes_train::{GradientFlow, Objective, TrainConfig, TrainingData, train};
/// use std::ops::ControlFlow;
///
/// let seed = Seed::from_u64(1);
/// let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
/// let networks = FcnnConfig { widths: vec![16, 16], networks: OverTime::Shared, ..FcnnConfig::paper() };
/// let shape = ModelShape::of(&system);
/// let mut proposal = Fcnn::create(&networks, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;
///
/// let source = SimulatedMeasurements::new(&system, 5, 1e6);
/// let config = TrainConfig {
///     objective: Objective::Elbo,
///     gradient: GradientFlow::Truncated { window: 1 },
///     steps: 20,
///     sequences_per_step: 4,
///     ..TrainConfig::paper(10)
/// };
/// let (data, mut stream) = (TrainingData::Fresh(&source), seed.child("training").stream());
/// let history = train(&mut proposal, &system, data, &config, &mut stream, |_, _| ControlFlow::Continue(()))?;
/// assert!(history.losses[19] < history.losses[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub enum TrainingData<'a> {
    /// Sequences of any lengths, one or more. A step takes [`TrainConfig::sequences_per_step`](crate::TrainConfig::sequences_per_step) of them, no
    /// two the same and each choice as likely as any other. A step that takes all of them draws nothing for the choice.
    Recorded(&'a [Measurements]),
    /// New sequences in every step. What the model simulates is
    /// [`SimulatedMeasurements`](motes_models::SimulatedMeasurements).
    Fresh(&'a dyn MeasurementSource),
}

impl<'a> From<&'a Measurements> for TrainingData<'a> {
    fn from(one: &'a Measurements) -> Self {
        TrainingData::Recorded(std::slice::from_ref(one))
    }
}

impl<'a> From<&'a [Measurements]> for TrainingData<'a> {
    fn from(many: &'a [Measurements]) -> Self {
        TrainingData::Recorded(many)
    }
}

impl<'a, const COUNT: usize> From<&'a [Measurements; COUNT]> for TrainingData<'a> {
    fn from(many: &'a [Measurements; COUNT]) -> Self {
        TrainingData::Recorded(many)
    }
}

impl<'a> From<&'a Vec<Measurements>> for TrainingData<'a> {
    fn from(many: &'a Vec<Measurements>) -> Self {
        TrainingData::Recorded(many)
    }
}

/// Which sequences a step takes.
pub(crate) enum Batch<'a> {
    /// All of these.
    All(&'a [Measurements]),
    /// Some of these, by their numbers.
    Chosen(&'a [Measurements], Vec<usize>),
    /// So many new ones.
    Fresh(&'a dyn MeasurementSource, usize),
}

impl<'a> TrainingData<'a> {
    /// Refuses what does not fit, as far as it is there to be seen.
    pub(crate) fn check(
        self,
        proposal: &dyn Learnable,
        model: &dyn StateGradients,
        particles: usize,
    ) -> Result<(), TrainError> {
        check_pair(proposal, model, particles)?;
        let TrainingData::Recorded(all) = self else { return Ok(()) };
        if all.is_empty() {
            let name = "the number of sequences of measurements";
            return Err(TrainError::Setting { name, value: "0".into(), expected: "at least 1" });
        }
        for (number, measurements) in all.iter().enumerate() {
            let checked = check_measurements(proposal, model, measurements, particles);
            checked.map_err(|error| match all.len() {
                1 => error,
                _ => TrainError::Recording { number, source: Box::new(error) },
            })?;
        }
        Ok(())
    }

    /// Draws which sequences the next step takes.
    pub(crate) fn choose(self, count: usize, stream: &mut Stream) -> Batch<'a> {
        match self {
            TrainingData::Recorded(all) if count >= all.len() => Batch::All(all),
            TrainingData::Recorded(all) => Batch::Chosen(all, sample(stream, all.len(), count).into_vec()),
            TrainingData::Fresh(source) => Batch::Fresh(source, count),
        }
    }
}

impl<'a> Batch<'a> {
    /// How many they are.
    pub(crate) fn len(&self) -> usize {
        match self {
            Batch::All(all) => all.len(),
            Batch::Chosen(_, numbers) => numbers.len(),
            Batch::Fresh(_, count) => *count,
        }
    }

    /// Number `at` of them; a new one is drawn.
    pub(crate) fn get(&self, at: usize, stream: &mut Stream) -> Result<Cow<'a, Measurements>, TrainError> {
        Ok(match self {
            Batch::All(all) => Cow::Borrowed(&all[at]),
            Batch::Chosen(all, numbers) => Cow::Borrowed(&all[numbers[at]]),
            Batch::Fresh(source, _) => Cow::Owned(source.draw(stream)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motes_models::Seed;

    /// Fails for a choice that takes a sequence twice, or one sequence more often than another.
    #[test]
    fn every_choice_of_different_sequences_is_as_likely_as_any_other() {
        let all: Vec<Measurements> =
            (0..5).map(|at| Measurements::new(1, vec![f64::from(at)]).unwrap()).collect();
        let (draws, mut stream) = (20_000, Seed::from_u64(1).stream());
        let mut counts = [[0; 5]; 5];
        for _ in 0..draws {
            let batch = TrainingData::from(&all).choose(2, &mut stream);
            assert_eq!(batch.len(), 2);
            let [first, second] = [0, 1].map(|at| match batch.get(at, &mut stream) {
                Ok(measurements) => measurements.values()[0] as usize,
                Err(error) => panic!("{error}"),
            });
            counts[first][second] += 1;
        }
        for (first, counts) in counts.iter().enumerate() {
            for (second, count) in counts.iter().enumerate() {
                // Each of the 20 ordered pairs is binomial.
                let (expected, deviation) =
                    (f64::from(draws) / 20.0, (f64::from(draws) * 0.05 * 0.95).sqrt());
                match first == second {
                    true => assert_eq!(*count, 0),
                    false => assert!((f64::from(*count) - expected).abs() < 4.0 * deviation, "{count}"),
                }
            }
        }
    }
}
