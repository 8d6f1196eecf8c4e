//! A checkpoint of a training as bytes, from which it goes on to the last bit.

use motes_proposals::{Learnable, Values};
use safetensors::tensor::{SafeTensors, TensorView};
use safetensors::{Dtype, serialize};

use crate::adam::Moments;
use crate::{TrainError, Training};

const WEIGHTS: &str = "weights";
const FIRST: &str = "first moments";
const SECOND: &str = "second moments";
const TAKEN: &str = "steps of each matrix";
const LOSSES: &str = "losses";
const POSITION: &str = "position in the stream";

impl Training<'_> {
    /// What is needed to go on from here: weights, the optimiser's moments, losses, and the position in the stream of noise.
    ///
    /// It takes about three times the memory of the weights.
    ///
    /// ```
    /// use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
    /// use motes_proposals::{Backend, Family, Fcnn, FcnnConfig};
    /// use motes_train::{TrainConfig, Training};
    ///
    /// let seed = Seed::from_u64(1);
    /// let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
    /// let measurements = simulate(&system, 4, &mut seed.child("data").stream())?.measurements;
    /// let settings = FcnnConfig { widths: vec![16], ..FcnnConfig::paper() };
    /// let fresh = || Fcnn::create(&settings, &ModelShape::of(&system), 4, Backend::Native.into(), &seed.child("weights"));
    /// let config = TrainConfig::paper(10);
    /// let [mut stream, mut same] = [0, 1].map(|_| seed.child("training").stream());
    ///
    /// let mut proposal = fresh()?;
    /// let mut training = Training::new(&proposal, &system, &measurements, &config, &mut stream)?;
    /// training.step(&mut proposal)?;
    /// let bytes = training.checkpoint(&proposal)?;
    ///
    /// let mut another = fresh()?;
    /// let mut resumed = Training::new(&another, &system, &measurements, &config, &mut same)?;
    /// resumed.resume(&mut another, &bytes)?;
    /// assert_eq!(training.step(&mut proposal)?, resumed.step(&mut another)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`TrainError::Diverged`] if the last step left weights that are not finite; [`TrainError::NotResumed`] if the numbers cannot be written.
    pub fn checkpoint(&self, proposal: &dyn Learnable) -> Result<Vec<u8>, TrainError> {
        self.check_weights(proposal)?;
        let weights = proposal.parameters().values();
        let zeros = || weights.zeros_like(weights.len());
        let (first, second) = match &self.adam.moments {
            Some(Moments { first, second }) => (bytes_of(first), bytes_of(second)),
            None => (bytes_of(&zeros()), bytes_of(&zeros())),
        };
        let mut taken = self.adam.steps.clone();
        taken.resize(proposal.parameters().len(), 0);
        let taken: Vec<u8> = taken.iter().flat_map(|steps| steps.to_le_bytes()).collect();
        let losses: Vec<u8> = self.history.losses.iter().flat_map(|loss| loss.to_le_bytes()).collect();
        let position = self.stream.get_word_pos().to_le_bytes();
        let real = match weights {
            Values::F32(_) => Dtype::F32,
            Values::F64(_) => Dtype::F64,
        };
        let weights = bytes_of(weights);
        let parts = [
            (WEIGHTS, real, weights.as_slice()),
            (FIRST, real, &first),
            (SECOND, real, &second),
            (TAKEN, Dtype::I32, &taken),
            (LOSSES, Dtype::F64, &losses),
            (POSITION, Dtype::U64, &position),
        ];
        let views = parts.map(|(name, dtype, bytes)| {
            TensorView::new(dtype, vec![bytes.len() * 8 / dtype.bitsize()], bytes).map(|view| (name, view))
        });
        let not_written = |error: safetensors::SafeTensorError| refuse(error.to_string());
        let views = views.into_iter().collect::<Result<Vec<_>, _>>().map_err(not_written)?;
        serialize(views, None).map_err(not_written)
    }

    /// Goes on from a checkpoint of a training with the same proposal, model, measurements, settings and stream.
    ///
    /// The caller sees to it that they are the same. Only other sizes are noticed.
    ///
    /// # Errors
    /// [`TrainError::NotResumed`] if the bytes do not fit the proposal, took more steps than there are, or hold an impossible
    /// number. Nothing has changed then.
    pub fn resume(&mut self, proposal: &mut dyn Learnable, bytes: &[u8]) -> Result<(), TrainError> {
        let file = SafeTensors::deserialize(bytes).map_err(|error| refuse(error.to_string()))?;
        let part = |name: &str, dtype: Dtype, count: Option<usize>| {
            let view = file.tensor(name).map_err(|error| refuse(error.to_string()))?;
            if view.dtype() != dtype {
                return Err(refuse(format!("{name} are {:?} and not {dtype:?}", view.dtype())));
            }
            let found = view.data().len() * 8 / dtype.bitsize();
            match count {
                Some(count) if found != count => Err(refuse(format!("{name}: {found} instead of {count}"))),
                _ => Ok(view.data().to_vec()),
            }
        };
        let weights = proposal.parameters().values();
        let (real, count) = match weights {
            Values::F32(_) => (Dtype::F32, Some(weights.len())),
            Values::F64(_) => (Dtype::F64, Some(weights.len())),
        };
        let values = |name| {
            let values = values_like(weights, &part(name, real, count)?);
            if values.are_finite() { Ok(values) } else { Err(refuse(format!("{name} are not all finite"))) }
        };
        let (new, first, second) = (values(WEIGHTS)?, values(FIRST)?, values(SECOND)?);
        let taken = part(TAKEN, Dtype::I32, Some(proposal.parameters().len()))?;
        let losses = part(LOSSES, Dtype::F64, None)?;
        let losses: Vec<f64> = losses.as_chunks().0.iter().map(|loss| f64::from_le_bytes(*loss)).collect();
        if losses.len() > self.steps() {
            return Err(refuse(format!("it took {} steps of {}", losses.len(), self.steps())));
        }
        if losses.iter().any(|loss| !loss.is_finite()) {
            return Err(refuse(format!("{LOSSES} are not all finite")));
        }
        let taken: Vec<i32> = taken.as_chunks().0.iter().map(|steps| i32::from_le_bytes(*steps)).collect();
        // A matrix may have been left out of steps, but was in none that were not taken.
        if let Some(steps) =
            taken.iter().find(|steps| usize::try_from(**steps).map_or(true, |steps| steps > losses.len()))
        {
            return Err(refuse(format!("a matrix took {steps} steps of {}", losses.len())));
        }
        let position = part(POSITION, Dtype::U64, Some(2))?;
        let position = position.as_array().map_or(0, |position| u128::from_le_bytes(*position));

        *proposal.parameters_mut().values_mut() = new;
        self.adam.moments = Some(Moments { first, second });
        self.adam.steps = taken;
        self.history.losses = losses;
        self.stream.set_word_pos(position);
        Ok(())
    }
}

fn refuse(reason: String) -> TrainError {
    TrainError::NotResumed { reason }
}

fn bytes_of(values: &Values) -> Vec<u8> {
    match values {
        Values::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        Values::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
    }
}

/// Numbers in the precision of `like`.
fn values_like(like: &Values, bytes: &[u8]) -> Values {
    match like {
        Values::F32(_) => Values::F32(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
        Values::F64(_) => Values::F64(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
    }
}
