//! The networks over whole sequences, forward and back.

use motes_networks::{Inference, Inputs, NetworkError, NetworkTape, Parameters, Values, Workspace};

use super::decoded::Layout;
use super::loss::{LossScratch, Transition, log_ratio};
use super::networks::{OneWay, PotentialNetworks, Reader};
use super::paths::PathBatch;

/// What networks see of nothing: their inputs have no measurement of their own.
const NOTHING: [f64; 1] = [0.0];

/// The sizes of a batch: `T` steps of `S` sequences with `F` features, and `H` hidden units in each direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    pub(super) steps: usize,
    pub(super) sequences: usize,
    pub(super) features: usize,
    pub(super) hidden: usize,
}

impl Sizes {
    /// What the reader sees of a step: the hidden states of both directions, and the features.
    fn read(self) -> usize {
        2 * self.hidden + self.features
    }

    /// The features of all sequences at a step, or nothing at the beginning.
    fn inputs(self, features: Option<&[f64]>, time: usize) -> Inputs<'_> {
        Inputs {
            time,
            width: self.features,
            previous: features,
            measurement: &NOTHING,
            particles: self.sequences,
        }
    }

    /// What a network sees that reads the features of each step alone.
    pub(super) fn of_features(self, features: &[f64]) -> Inputs<'_> {
        let particles = self.steps * self.sequences;
        Inputs { time: 1, width: self.features, previous: Some(features), measurement: &NOTHING, particles }
    }

    /// What the reader of both directions sees.
    fn of_both(self, read: &[f64]) -> Inputs<'_> {
        let particles = self.steps * self.sequences;
        Inputs { time: 1, width: self.read(), previous: Some(read), measurement: &NOTHING, particles }
    }

    /// Which step comes at which place of a direction.
    fn step(self, way: usize, place: usize) -> usize {
        if way == 0 { place } else { self.steps - 1 - place }
    }

    /// Puts the features of all steps where the reader sees them.
    fn with_features(self, features: &[f64]) -> Vec<f64> {
        let mut read = vec![0.0; self.steps * self.sequences * self.read()];
        for (row, features) in read.chunks_exact_mut(self.read()).zip(features.chunks_exact(self.features)) {
            row[2 * self.hidden..].copy_from_slice(features);
        }
        read
    }

    /// The hidden states of a direction at a step, among what the reader sees.
    fn hidden_rows(self, read: &mut [f64], way: usize, step: usize) -> impl Iterator<Item = &mut [f64]> {
        let rows = read[step * self.sequences * self.read()..][..self.sequences * self.read()]
            .chunks_exact_mut(self.read());
        rows.map(move |row| &mut row[way * self.hidden..][..self.hidden])
    }
}

/// What a reader emits for rows, into `outputs`.
pub(super) fn read(
    reader: &Reader,
    parameters: &Parameters,
    inputs: Inputs<'_>,
    inference: &mut Inference,
    outputs: &mut [f64],
) -> Result<(), NetworkError> {
    inference.run(reader, parameters, &inputs, &mut [], &mut [outputs])
}

/// The outputs (`T·S×O`) for features (`T×S×F`).
pub(super) fn outputs(
    networks: &PotentialNetworks,
    parameters: &Parameters,
    sizes: Sizes,
    layout: Layout,
    features: &[f64],
) -> Result<Vec<f64>, NetworkError> {
    let Sizes { steps, sequences, features: width, hidden } = sizes;
    let mut seen = sizes.with_features(features);
    let mut inference = Inference::default();
    let mut emitted = vec![0.0; sequences * hidden];
    for (way, network) in networks.ways.iter().enumerate() {
        let mut carried = Values::none(parameters.compute().precision).zeros_like(sequences * hidden);
        let mut run = |inputs: Inputs<'_>, emitted: &mut [f64]| {
            inference.run(network, parameters, &inputs, &mut [carried.as_slice_mut()], &mut [emitted])
        };
        run(sizes.inputs(None, 0), &mut emitted)?;
        for place in 0..steps {
            let step = sizes.step(way, place);
            let of_step = &features[step * sequences * width..][..sequences * width];
            run(sizes.inputs(Some(of_step), 1 + place), &mut emitted)?;
            for (row, hidden) in sizes.hidden_rows(&mut seen, way, step).zip(emitted.chunks_exact(hidden)) {
                row.copy_from_slice(hidden);
            }
        }
    }
    let mut outputs = vec![0.0; steps * sequences * layout.outputs()];
    read(&networks.reader, parameters, sizes.of_both(&seen), &mut inference, &mut outputs)?;
    Ok(outputs)
}

/// The mean of `log ψ_t(x_t) − log Z_t(x_{t−1})` over a batch; its derivatives (`T·S×O`), turned round and divided by the number of rows, into `d_outputs`.
pub(super) fn gain(batch: &PathBatch, layout: Layout, outputs: &[f64], d_outputs: &mut [f64]) -> f64 {
    let (n, width) = (layout.n, layout.outputs());
    let rows = batch.steps * batch.sequences;
    let mut scratch = LossScratch::default();
    let mut sum = 0.0;
    for row in 0..rows {
        let transition = Transition {
            state: &batch.states[row * n..][..n],
            centre: &batch.centres[row * n..][..n],
            spread: &batch.spreads[row * n * n..][..n * n],
        };
        let (of_row, d_of_row) = (&outputs[row * width..][..width], &mut d_outputs[row * width..][..width]);
        sum += log_ratio(layout, of_row, transition, -1.0 / rows as f64, d_of_row, &mut scratch);
    }
    sum / rows as f64
}

/// The gains of a batch, ahead and now, and the derivative of their sum along the weights, turned round: of each direction, of the reader, and of the network of a step alone.
pub(super) fn differentiate(
    networks: &PotentialNetworks,
    parameters: &Parameters,
    batch: &PathBatch,
    layout: Layout,
    sizes: Sizes,
    memory: [Workspace; 4],
) -> Result<([f64; 2], [Workspace; 4]), NetworkError> {
    let Sizes { steps, sequences, features: width, hidden } = sizes;
    let [forwards, backwards, of_reader, of_now] = memory;
    let mut seen = sizes.with_features(&batch.features);
    let mut emitted = vec![0.0; sequences * hidden];
    let mut record = |way: usize, network, memory| -> Result<NetworkTape<'_, OneWay>, NetworkError> {
        let mut tape = NetworkTape::new(network, parameters, sequences, memory)?;
        tape.forward(&sizes.inputs(None, 0), &mut [&mut emitted])?;
        for place in 0..steps {
            let step = sizes.step(way, place);
            let of_step = &batch.features[step * sequences * width..][..sequences * width];
            tape.forward(&sizes.inputs(Some(of_step), 1 + place), &mut [&mut emitted])?;
            for (row, hidden) in sizes.hidden_rows(&mut seen, way, step).zip(emitted.chunks_exact(hidden)) {
                row.copy_from_slice(hidden);
            }
        }
        Ok(tape)
    };
    let [of_first, of_last] = &networks.ways;
    let tapes = [record(0, of_first, forwards)?, record(1, of_last, backwards)?];
    let mut d_seen = vec![0.0; seen.len()];
    let (ahead, reader) = read_back(
        &networks.reader,
        parameters,
        batch,
        layout,
        sizes.of_both(&seen),
        Some(&mut d_seen),
        of_reader,
    )?;
    let (now, of_now) = read_back(
        &networks.now,
        parameters,
        batch,
        layout,
        sizes.of_features(&batch.features),
        None,
        of_now,
    )?;
    let [forwards, backwards] = tapes;
    let mut undone = |way: usize, mut tape: NetworkTape<'_, OneWay>| -> Result<Workspace, NetworkError> {
        for place in (0..steps).rev() {
            let step = sizes.step(way, place);
            for (row, d) in sizes.hidden_rows(&mut d_seen, way, step).zip(emitted.chunks_exact_mut(hidden)) {
                d.copy_from_slice(row);
            }
            tape.backward_to_weights(&[&emitted])?;
        }
        emitted.fill(0.0);
        tape.backward_to_weights(&[&emitted])?;
        Ok(tape.finish())
    };
    Ok(([ahead, now], [undone(0, forwards)?, undone(1, backwards)?, reader, of_now]))
}

/// The gain of a reader on what it sees, and its derivatives along its weights and, where they are asked for, along what it sees.
fn read_back(
    reader: &Reader,
    parameters: &Parameters,
    batch: &PathBatch,
    layout: Layout,
    seen: Inputs<'_>,
    d_seen: Option<&mut [f64]>,
    memory: Workspace,
) -> Result<(f64, Workspace), NetworkError> {
    let mut outputs = vec![0.0; seen.particles * layout.outputs()];
    let mut d_outputs = outputs.clone();
    let mut tape = NetworkTape::new(reader, parameters, seen.particles, memory)?;
    tape.forward(&seen, &mut [&mut outputs])?;
    let gain = gain(batch, layout, &outputs, &mut d_outputs);
    match d_seen {
        Some(d_seen) => tape.backward(&[&d_outputs], d_seen)?,
        None => tape.backward_to_weights(&[&d_outputs])?,
    }
    Ok((gain, tape.finish()))
}
