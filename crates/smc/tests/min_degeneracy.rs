//! The minimum-degeneracy proposal by rows against its own densities.

use motes_models::batch::Rows;
use motes_models::{Drift, GraphDiffusion, GraphDiffusionConfig, Noise, Seed, StateSpaceModel, simulate};
use motes_smc::{Conditional, MinDegeneracy, Past, Proposal, RowPast};

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
            let past = Past { time, previous: previous.as_deref(), measurement, particles: PARTICLES };
            let mut increments = [f64::NAN; PARTICLES];
            let rows = proposal.by_rows(&system, time, measurement).unwrap().expect("it draws by rows");
            let rows_before = previous.as_deref().map(|previous| Rows::all(previous, 8));
            let from = RowPast { time, measurement, previous: rows_before };
            rows.draw(&system, from, &mut streams, &mut states, &mut increments);
            let mut log_q = [f64::NAN; PARTICLES];
            proposal.condition(&system, past, &mut ()).unwrap().log_density(&states, &mut log_q);
            for (row, state) in states.chunks_exact(8).enumerate() {
                let log_prior = match past.previous {
                    None => system.log_initial(state),
                    Some(previous) => system.log_transition(time, &previous[row * 8..][..8], state),
                };
                let expected = system.log_likelihood(time, state, measurement) + log_prior - log_q[row];
                let found = increments[row];
                assert!(found == expected || (found - expected).abs() < 1e-10, "{found} for {expected}");
            }
            // Drawn as a batch, log q is what it is when asked for.
            let mut conditional = proposal.condition(&system, past, &mut ()).unwrap();
            let (mut again, mut told) = (vec![f64::NAN; PARTICLES * 8], [f64::NAN; PARTICLES]);
            conditional.sample(&mut streams, &mut again, &mut told);
            conditional.log_density(&again, &mut log_q);
            assert!(told.iter().zip(log_q).all(|(told, asked)| (told - asked).abs() < 1e-10));
            previous = Some(states.clone());
        }
    }
}
