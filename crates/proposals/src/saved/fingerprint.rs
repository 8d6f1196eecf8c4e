//! What tells one system from another: its densities at points that are drawn from it by a fixed stream.

use motes_models::{Seed, StateSpaceModel};
use rand::RngExt;
use rand_distr::StandardNormal;

use super::Entry;

/// Dimensions, and log densities at a few points; any change of a parameter that a filter would notice changes one of them.
pub(super) fn fingerprint(model: &dyn StateSpaceModel) -> Vec<Entry> {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let mut stream = Seed::from_u64(0).child("fingerprint").stream();
    let mut entries =
        vec![entry("the state dimension N", n as f64), entry("the measurement dimension M", m as f64)];
    let (mut previous, mut state, mut measurement) = (vec![0.0; n], vec![0.0; n], vec![0.0; m]);
    model.sample_initial(&mut stream, &mut previous);
    entries.push(entry("log p(x_0) at a fixed point", model.log_initial(&previous)));
    for time in 1..=2 {
        model.sample_transition(time, &previous, &mut stream, &mut state);
        let log = model.log_transition(time, &previous, &state);
        entries.push(entry(&format!("log p(x_{time} | x_{}) at a fixed point", time - 1), log));
        // Noise with bounds may exclude most measurements: several sizes, so that some are inside.
        for scale in [0.1, 1.0, 10.0] {
            measurement.fill_with(|| scale * stream.sample::<f64, _>(StandardNormal));
            let log = model.log_likelihood(time, &state, &measurement);
            entries.push(entry(&format!("log p(y_{time} | x_{time}) at a fixed point of size {scale}"), log));
        }
        previous.copy_from_slice(&state);
    }
    entries
}

fn entry(name: &str, value: f64) -> Entry {
    Entry { name: name.into(), value }
}
