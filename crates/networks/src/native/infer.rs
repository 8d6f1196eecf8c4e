//! Networks in a filter: forward only, some particles at a time.

use super::buffers::Buffers;
use super::deduplicate::DistinctParticles;
use super::products::Multiply;
use super::step::{At, Native, Step};
use crate::error::NetworkError;
use crate::fit::{HIDDEN, OUTPUTS, unless_alike};
use crate::networks::{Few, Inputs, Known, Networks, Outputs};
use crate::parameters::Parameters;
use crate::values::{SliceMut, narrow, widen};

/// Memory that is used again from step to step.
#[derive(Default)]
pub(crate) struct Memory {
    narrow: (Step<f32>, Buffers<f32>),
    wide: (Step<f64>, Buffers<f64>),
    computed: DistinctParticles,
}

/// A precision whose part of the memory can be told from that of the other.
pub(crate) trait MemoryPart: Multiply {
    fn part(memory: &mut Memory) -> (&mut (Step<Self>, Buffers<Self>), &mut DistinctParticles);
}

impl MemoryPart for f32 {
    fn part(memory: &mut Memory) -> (&mut (Step<f32>, Buffers<f32>), &mut DistinctParticles) {
        (&mut memory.narrow, &mut memory.computed)
    }
}

impl MemoryPart for f64 {
    fn part(memory: &mut Memory) -> (&mut (Step<f64>, Buffers<f64>), &mut DistinctParticles) {
        (&mut memory.wide, &mut memory.computed)
    }
}

/// Each output (`R×width`) of particles that carry `hidden`, which is advanced.
///
/// Inputs and hidden values have been checked; of at least one particle.
///
/// # Errors
/// [`NetworkError::Shape`] if the networks emit something else than there are places for.
pub(crate) fn infer<F: Networks, T: MemoryPart>(
    networks: &F,
    parameters: &Parameters,
    inputs: &Inputs<'_>,
    hidden: &mut [SliceMut<'_>],
    memory: &mut Memory,
    outputs: &mut [&mut [f64]],
) -> Result<(), NetworkError> {
    let (n, particles) = (inputs.width, inputs.particles);
    let ((step, buffers), computed) = T::part(memory);
    computed.find::<T>(inputs, hidden);
    let mut first = 0;
    for rows in computed.blocks() {
        let block = computed.particles(first, rows);
        let mut previous = buffers.take(rows * n);
        match inputs.previous {
            Some(values) => {
                let places = previous.chunks_exact_mut(n).zip(block);
                places.for_each(|(place, row)| narrow(&values[row * n..][..n], place));
            }
            None => previous.fill(T::ZERO),
        }
        let mut measurement = buffers.take(inputs.measurement.len());
        narrow(inputs.measurement, &mut measurement);
        let previous = step.give(rows, n, previous);
        let measurement = step.give(1, inputs.measurement.len(), measurement);
        let hidden_in: Few<At> = hidden
            .iter_mut()
            .map(|values| {
                let width = values.len() / particles;
                let mut carried = buffers.take(rows * width);
                for (place, row) in carried.chunks_exact_mut(width.max(1)).zip(block) {
                    place.copy_from_slice(&T::pick_mut(values)[row * width..][..width]);
                }
                step.give(rows, width, carried)
            })
            .collect();
        let mut native = Native { weights: parameters.matrices(), step, buffers };
        let found =
            networks.forward(&mut native, inputs.time, Known { previous, measurement, hidden: &hidden_in });
        if let Err(error) = has_places(step, &found, [rows, particles], outputs, hidden) {
            step.release(buffers);
            return Err(error);
        }
        for (&at, output) in found.values.iter().zip(&mut *outputs) {
            let values = step.values(at);
            let width = values.len() / rows;
            widen(values, &mut output[first * width..(first + rows) * width]);
        }
        for (values, &advanced) in hidden.iter_mut().zip(&found.hidden) {
            // To the first rows, where no particle lies whose turn is yet to come.
            let advanced = step.values(advanced);
            T::pick_mut(values)[first * advanced.len() / rows..][..advanced.len()].copy_from_slice(advanced);
        }
        step.release(buffers);
        first += rows;
    }
    for output in outputs {
        let width = output.len() / particles;
        computed.hand_out(output, width);
    }
    for values in hidden {
        let width = values.len() / particles;
        computed.hand_out(T::pick_mut(values), width);
    }
    Ok(())
}

/// Refuses places that are not those of what was found of some rows.
fn has_places<T: MemoryPart>(
    step: &Step<T>,
    found: &Outputs<At>,
    [rows, particles]: [usize; 2],
    outputs: &[&mut [f64]],
    hidden: &[SliceMut<'_>],
) -> Result<(), NetworkError> {
    let of_all = |at: &At| step.values(*at).len() / rows * particles;
    unless_alike(OUTPUTS, outputs.iter().map(|output| output.len()), found.values.iter().map(of_all))?;
    unless_alike(HIDDEN, hidden.iter().map(SliceMut::len), found.hidden.iter().map(of_all))
}
