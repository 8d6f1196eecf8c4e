//! Networks in a filter: forward only, some particles at a time.

use motes_smc::Past;

use super::{At, Buffers, Native, Step};
use crate::gaussian::{Known, Networks};
use crate::values::{Real, Values, narrow, widen};
use crate::{Parameters, Precision};

/// Memory that is used again from step to step.
#[derive(Default)]
pub(crate) struct Inference {
    narrow: (Step<f32>, Buffers<f32>),
    wide: (Step<f64>, Buffers<f64>),
}

impl Clone for Inference {
    /// A copy of a proposal has memory of its own.
    fn clone(&self) -> Self {
        Inference::default()
    }
}

/// Particles at a time: so few that what a layer says of them stays near, and so many that its weights are read seldom.
const BLOCK: usize = 256;

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
    match parameters.compute().precision {
        Precision::F32 => {
            infer_in(networks, parameters, past, hidden, &mut memory.narrow, means, representations);
        }
        Precision::F64 => {
            infer_in(networks, parameters, past, hidden, &mut memory.wide, means, representations);
        }
    }
}

fn infer_in<F: Networks, T: Real>(
    networks: &F,
    parameters: &Parameters,
    past: &Past<'_>,
    hidden: &mut [Values],
    (step, buffers): &mut (Step<T>, Buffers<T>),
    means: &mut [f64],
    representations: &mut [f64],
) {
    let n = means.len() / past.particles.max(1);
    let distinct = distinct(past);
    for first in (0..distinct).step_by(BLOCK) {
        let rows = BLOCK.min(distinct - first);
        let at = first * n..(first + rows) * n;
        let mut previous = buffers.take(rows * n);
        match past.previous {
            Some(values) => narrow(&values[at.clone()], &mut previous),
            None => previous.fill(T::ZERO),
        }
        let mut measurement = buffers.take(past.measurement.len());
        narrow(past.measurement, &mut measurement);
        let previous = step.give(rows, n, previous);
        let measurement = step.give(1, past.measurement.len(), measurement);
        let carried = |values: &Values| {
            let width = values.len() / past.particles;
            (width, first * width..(first + rows) * width)
        };
        let hidden_in: Vec<At> = hidden
            .iter()
            .map(|values| {
                let (width, at) = carried(values);
                let mut block = buffers.take(at.len());
                block.copy_from_slice(&T::slice(values)[at]);
                step.give(rows, width, block)
            })
            .collect();
        let mut native = Native { weights: parameters.matrices(), step, buffers };
        let emission =
            networks.forward(&mut native, past.time, Known { previous, measurement, hidden: &hidden_in });
        widen(step.values(emission.means), &mut means[at.clone()]);
        widen(step.values(emission.representations), &mut representations[at]);
        for (values, advanced) in hidden.iter_mut().zip(&emission.hidden) {
            let (_, at) = carried(values);
            T::slice_mut(values)[at].copy_from_slice(step.values(*advanced));
        }
        step.release(buffers);
    }
    if distinct < past.particles {
        repeat_first(means, n);
        repeat_first(representations, n);
        for values in hidden {
            let width = values.len() / past.particles;
            repeat_first(T::slice_mut(values), width);
        }
    }
}

/// How many particles know something that others do not: before the first state none does.
pub(super) fn distinct(past: &Past<'_>) -> usize {
    if past.previous.is_some() { past.particles } else { past.particles.min(1) }
}

/// Copies the first row into all others.
pub(super) fn repeat_first<T: Copy>(rows: &mut [T], width: usize) {
    let (first, others) = rows.split_at_mut(width);
    others.chunks_exact_mut(width.max(1)).for_each(|row| row.copy_from_slice(first));
}
