//! The minimum-degeneracy proposal: weights in closed form against its own densities.

use motes_models::{
    Drift, GraphDiffusion, GraphDiffusionConfig, Noise, Seed, StateSpaceModel, Step, simulate,
};
use motes_smc::{Conditional, Context, MinDegeneracy, Proposal};

#[test]
fn increments_are_likelihood_times_transition_over_proposal() {
    const PARTICLES: usize = 77;
    let seed = Seed::from_u64(65);
    for (drift, noise) in
        [(Drift::Identity, Noise::Gaussian), (Drift::Abs, Noise::Gaussian), (Drift::Abs, Noise::Uniform)]
    {
        let config = GraphDiffusionConfig { drift, noise, ..GraphDiffusionConfig::new(8) };
        let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
        let data = simulate(&system, 2, &mut seed.child("data").stream()).unwrap();
        let mut proposal = MinDegeneracy::new(&system).unwrap();
        let mut streams = [seed.child("filter").stream()];
        let mut states = vec![f64::NAN; PARTICLES * 8];
        let mut previous: Option<Vec<f64>> = None;
        for (time, measurement) in data.measurements.rows().enumerate() {
            let context = Context::new(Step::of_index(time), previous.as_deref(), PARTICLES);
            let mut increments = [f64::NAN; PARTICLES];
            let (mut log_q, scratch) = ([f64::NAN; PARTICLES], &mut ());
            let mut conditional =
                proposal.condition_batch(&system, context, measurement, &mut (), scratch).unwrap();
            let has_closed_form = conditional.sample_weighted(&mut streams, &mut states, &mut increments);
            assert_eq!(has_closed_form, noise == Noise::Gaussian);
            if !has_closed_form {
                conditional.sample(&mut streams, &mut states, &mut increments);
            }
            conditional.log_density(&states, &mut log_q);
            for (row, state) in states.chunks_exact(8).enumerate() {
                let log_prior = match context.previous {
                    None => system.density().unwrap().log_density(&Step::of_index(0), None, state),
                    Some(previous) => system.density().unwrap().log_density(
                        &Step::of_index(time),
                        Some(previous.row(row)),
                        state,
                    ),
                };
                let of_target =
                    system.log_likelihood(&Step::of_index(time), state, measurement).unwrap() + log_prior;
                let expected = if has_closed_form { of_target - log_q[row] } else { log_q[row] };
                let found = increments[row];
                assert!(found == expected || (found - expected).abs() < 1e-10, "{found} for {expected}");
            }
            // Drawn as a batch, log q is what it is when asked for.
            let (mut again, mut told) = (vec![f64::NAN; PARTICLES * 8], [f64::NAN; PARTICLES]);
            conditional.sample(&mut streams, &mut again, &mut told);
            conditional.log_density(&again, &mut log_q);
            assert!(told.iter().zip(log_q).all(|(told, asked)| (told - asked).abs() < 1e-10));
            previous = Some(states.clone());
        }
    }
}
