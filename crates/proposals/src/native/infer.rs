//! Networks in a filter: forward only, some particles at a time.

use motes_smc::Past;

use super::alike::Computed;
use super::{At, Buffers, Native, Step};
use crate::gaussian::{Known, Networks};
use crate::values::{Real, Values, narrow, widen};
use crate::{Parameters, Precision};

/// Memory that is used again from step to step.
#[derive(Default)]
pub(crate) struct Inference {
    narrow: (Step<f32>, Buffers<f32>),
    wide: (Step<f64>, Buffers<f64>),
    computed: Computed,
}

impl Clone for Inference {
    /// A copy of a proposal has memory of its own.
    fn clone(&self) -> Self {
        Inference::default()
    }
}

/// Means and representations (`R×N` each) of particles that carry `hidden`, which is advanced.
pub(crate) fn infer<F: Networks>(
    networks: &F,
    parameters: &Parameters,
    past: &Past<'_>,
    hidden: &mut [Values],
    memory: &mut Inference,
    means: &mut [f64],
    representations: &mut [f64],
) {
    let Inference { narrow, wide, computed } = memory;
    match parameters.compute().precision {
        Precision::F32 => {
            infer_in(networks, parameters, past, hidden, (narrow, computed), means, representations);
        }
        Precision::F64 => {
            infer_in(networks, parameters, past, hidden, (wide, computed), means, representations);
        }
    }
}

fn infer_in<F: Networks, T: Real>(
    networks: &F,
    parameters: &Parameters,
    past: &Past<'_>,
    hidden: &mut [Values],
    ((step, buffers), computed): (&mut (Step<T>, Buffers<T>), &mut Computed),
    means: &mut [f64],
    representations: &mut [f64],
) {
    let n = means.len() / past.particles.max(1);
    computed.find::<T>(past, hidden);
    let mut first = 0;
    for rows in computed.blocks() {
        let block = computed.particles(first, rows);
        let at = first * n..(first + rows) * n;
        let mut previous = buffers.take(rows * n);
        match past.previous {
            Some(values) => {
                let places = previous.chunks_exact_mut(n).zip(block);
                places.for_each(|(place, row)| narrow(&values[row * n..][..n], place));
            }
            None => previous.fill(T::ZERO),
        }
        let mut measurement = buffers.take(past.measurement.len());
        narrow(past.measurement, &mut measurement);
        let previous = step.give(rows, n, previous);
        let measurement = step.give(1, past.measurement.len(), measurement);
        let hidden_in: Vec<At> = hidden
            .iter()
            .map(|values| {
                let width = values.len() / past.particles;
                let mut carried = buffers.take(rows * width);
                for (place, row) in carried.chunks_exact_mut(width).zip(block) {
                    place.copy_from_slice(&T::slice(values)[row * width..][..width]);
                }
                step.give(rows, width, carried)
            })
            .collect();
        let mut native = Native { weights: parameters.matrices(), step, buffers };
        let emission =
            networks.forward(&mut native, past.time, Known { previous, measurement, hidden: &hidden_in });
        widen(step.values(emission.means), &mut means[at.clone()]);
        widen(step.values(emission.representations), &mut representations[at]);
        for (values, advanced) in hidden.iter_mut().zip(&emission.hidden) {
            // To the first rows, where no particle lies whose turn is yet to come.
            let advanced = step.values(*advanced);
            T::slice_mut(values)[first * advanced.len() / rows..][..advanced.len()].copy_from_slice(advanced);
        }
        step.release(buffers);
        first += rows;
    }
    computed.hand_out(means, n);
    computed.hand_out(representations, n);
    for values in hidden {
        let width = values.len() / past.particles.max(1);
        computed.hand_out(T::slice_mut(values), width);
    }
}
