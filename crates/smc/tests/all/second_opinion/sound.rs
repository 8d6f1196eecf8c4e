//! Filters that are sound, and how often they are warned of.

use motes_models::Simulator;
use motes_models::equations::Linearise;
use motes_smc::{Bootstrap, FilterSettings, Linearised, Proposal, ResampleWhen, Verdict};

use super::models::{Growth, Linear, Volatility, judge_all};

/// Sequences that are judged, and of how many there was a warning.
struct Trial {
    settings: FilterSettings,
    horizon: usize,
    sequences: u64,
    warned: usize,
    all: usize,
}

impl Trial {
    /// Judges one proposal for one model.
    fn add<M: Simulator, P: Proposal<M>>(&mut self, name: &str, model: &M, proposal: impl Fn() -> P) {
        let judged = judge_all(model, proposal, self.settings, self.horizon, 0..self.sequences);
        let count =
            |which: fn(&Verdict) -> bool| judged.iter().filter(|judged| which(&judged.verdict)).count();
        let warned = count(|verdict| matches!(verdict, Verdict::Warns { .. }));
        let without = count(|verdict| matches!(verdict, Verdict::NoOpinion { .. }));
        println!(
            "{name}, K = {}, T = {}, {:?}: {warned} of {} are warned of, of {without} there is no opinion",
            self.settings.particles, self.horizon, self.settings.resample_when, self.sequences
        );
        assert!(warned as f64 <= (0.01 * self.sequences as f64).max(1.0), "{name}: {warned}");
        self.warned += warned;
        self.all += judged.len();
    }

    /// Judges every model with every proposal that is sound for it.
    fn add_all(&mut self) {
        let linear = Linear { coordinates: 1, a: 0.9, q: 1.0, r: 1.0 };
        self.add("linear, bootstrap", &linear, || Bootstrap);
        self.add("linear, optimum", &linear, linearised(&linear));
        let three = Linear { coordinates: 3, ..linear };
        self.add("linear in 3 dimensions, optimum", &three, linearised(&three));
        let slow = Linear { coordinates: 1, a: 0.99, q: 0.1, r: 1.0 };
        self.add("slow, bootstrap", &slow, || Bootstrap);
        self.add("slow, optimum", &slow, linearised(&slow));
        self.add("growth, bootstrap", &Growth, || Bootstrap);
        self.add("growth, linearised", &Growth, linearised(&Growth));
        self.add("volatility", &Volatility { phi: 0.91, sigma: 1.0, beta: 0.5 }, || Bootstrap);
        self.add("slow volatility", &Volatility { phi: 0.98, sigma: 0.2, beta: 0.7 }, || Bootstrap);
    }
}

fn linearised<M: Linearise + Simulator>(model: &M) -> impl Fn() -> Linearised {
    let proposal = Linearised::new(model).unwrap();
    move || proposal.clone()
}

fn try_all(horizons: [usize; 2], particles: [usize; 3], sequences: u64) {
    let (mut warned, mut all) = (0, 0);
    for horizon in horizons {
        for particles in particles {
            for resample_when in [ResampleWhen::PAPER, ResampleWhen::Always] {
                let settings = FilterSettings { resample_when, ..FilterSettings::new(particles) };
                let mut trial = Trial { settings, horizon, sequences, warned: 0, all: 0 };
                trial.add_all();
                warned += trial.warned;
                all += trial.all;
            }
        }
    }
    println!("{warned} of {all} are warned of");
    // Of each a hundredth is allowed; most have none at all.
    assert!(warned as f64 <= 0.002 * all as f64 + 1.0, "{warned} of {all}");
}

#[test]
fn sound_filters_are_hardly_ever_warned_of() {
    try_all([100, 300], [100, 300, 1000], 8);
}

#[test]
#[ignore = "thorough: half an hour"]
fn sound_filters_are_hardly_ever_warned_of_in_hundreds_of_long_sequences() {
    try_all([100, 1000], [100, 300, 1000], 300);
}
