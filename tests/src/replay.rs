//! Whether what a particle remembers, and the density that it was weighed by, are those of the path that led to it.

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Seed, StateSpaceModel, Step, simulate};
use motes_proposals::Hidden;
use motes_smc::{Conditional, Context, FilterBank, FilterSettings, Proposal, ResampleWhen};

use crate::relative_distance;

/// The number of nodes of [`replayed_system`].
const N: usize = 5;

/// The system that paths are replayed on.
pub fn replayed_system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(N), &mut Seed::from_u64(110).stream()).unwrap()
}

/// What came of replaying the ancestral path of each particle from scratch, alone.
#[derive(Debug)]
pub struct Replay {
    /// How often a particle on a path had another number than its parent.
    pub moved: usize,
    /// The largest relative distance of a particle's memory from the replayed one.
    pub memory: f64,
    /// The largest relative distance of the weights of a filter from those by the replayed log q.
    pub weights: f64,
}

impl Replay {
    /// What the test of memory asks.
    pub fn holds(&self) -> bool {
        self.moved > 16 && self.memory < 1e-12 && self.weights < 1e-9
    }
}

/// Runs two filters of eight particles that resample at every step, nothing being measured at the times `missing`, and replays the path
/// of each. The last of the six times must not be among them.
pub fn replay<P: Proposal<GraphDiffusion> + Clone>(
    proposal: &P,
    hidden: impl Fn(&P::Memory) -> &Hidden,
    missing: &[usize],
) -> Replay {
    let (system, seed) = (replayed_system(), Seed::from_u64(112));
    let measurements = simulate(&system, 6, &mut seed.child("data").stream()).unwrap().measurements;
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(8) };
    let mut bank = FilterBank::new(&system, proposal.clone(), settings, 2, &seed.child("filter")).unwrap();
    let (mut states, mut ancestors) = (vec![], vec![]);
    for (time, measurement) in measurements.rows().enumerate() {
        match missing.contains(&time) {
            true => bank.step_at(&Step::of_index(time), &vec![None; measurement.len()]).unwrap(),
            false => bank.step(measurement).unwrap(),
        }
        states.push((0..2).flat_map(|filter| bank.particles(filter).to_vec()).collect::<Vec<f64>>());
        ancestors.push(bank.ancestors().to_vec());
    }
    let (stored, last) = (hidden(bank.memory()).host(), states.len() - 1);
    let mut found = Replay { moved: 0, memory: 0.0, weights: 0.0 };
    let (mut increments, mut proposal) = (vec![], proposal.clone());
    for row in 0..16 {
        let mut path = vec![row];
        for time in (1..=last).rev() {
            path.push(ancestors[time][path[path.len() - 1]]);
        }
        path.reverse();
        found.moved += path.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let (mut memory, mut scratch) = (proposal.initial_memory(1), P::Scratch::default());
        let mut log_density = [0.0];
        for time in (0..=last).filter(|time| !missing.contains(time)) {
            let state = |time: usize| &states[time][path[time] * N..(path[time] + 1) * N];
            let previous = (time > 0).then(|| state(time - 1));
            let context = Context::new(Step::of_index(time), previous, 1);
            let mut conditional = proposal
                .condition_batch(&system, context, measurements.row(time), &mut memory, &mut scratch)
                .unwrap();
            conditional.log_density(state(time), &mut log_density);
        }
        for (replayed, stored) in hidden(&memory).host().iter().zip(&stored) {
            let width = replayed.len();
            let distance = relative_distance(replayed, &stored[row * width..(row + 1) * width]);
            found.memory = found.memory.max(distance);
        }
        let state = &states[last][row * N..(row + 1) * N];
        let parent = &states[last - 1][path[last - 1] * N..(path[last - 1] + 1) * N];
        increments.push(
            system.log_likelihood(&Step::of_index(last), state, measurements.row(last)).unwrap()
                + system.density().unwrap().log_density(&Step::of_index(last), Some(parent), state)
                - log_density[0],
        );
    }
    // After resampling a weight is its last increment, normalised.
    for (filter, increments) in increments.chunks_exact(8).enumerate() {
        let largest = increments.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = increments.iter().map(|log| (log - largest).exp()).sum();
        let expected: Vec<f64> = increments.iter().map(|log| (log - largest).exp() / sum).collect();
        let distance = relative_distance(bank.weights(filter).normalised(), &expected);
        found.weights = found.weights.max(distance);
    }
    found
}
