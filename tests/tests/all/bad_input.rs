//! What the libraries say of bad input: typed, by kind, in one line that names what is wrong and what would be right.
//!
//! The lines are in `snapshots/`; the program's own are with its tests.

use faer::{Mat, mat};
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{
    Drift, Epidemic, EpidemicConfig, Gaussian, GraphDiffusion, GraphDiffusionConfig, LinearGaussian,
    Measurements, ModelShape, Noise, PartialMeasurements, Seed, Sequence, Simulations, Step, check_gradients,
    check_model, simulate,
};
use motes_proposals::{Backend, Cell, Family, Fcnn, Gnn, Psi, Rnn};
use motes_smc::{
    Bootstrap, FilterBank, FilterError, FilterSettings, MinDegeneracy, ParticleFilter, ResampleWhen,
};
use motes_tests::{Shifted, reference, small_fcnn, small_gnn, small_psi, small_rnn};
use motes_train::{AdamConfig, TrainConfig, TrainError, Training, train};

/// Compares with the committed lines.
macro_rules! assert_lines {
    ($cases:expr) => {
        insta::with_settings!({ omit_expression => true }, { insta::assert_snapshot!(lines($cases)) })
    };
}

/// One line for each case.
fn lines(cases: impl IntoIterator<Item = (&'static str, String)>) -> String {
    let line = |(name, said): (&str, String)| {
        assert_eq!(said.lines().count(), 1, "{name}: {said}");
        format!("{name}\n    {said}\n")
    };
    cases.into_iter().map(line).collect()
}

/// The loss on the way to a failure is rounding that grew: another on each kind of processor.
fn without_loss(said: &str) -> String {
    let (before, loss) = said.split_once("a loss of ").expect("it names the loss");
    let (_, after) = loss.split_once(", ").expect("it goes on");
    format!("{before}a loss of LOSS, {after}")
}

fn refused<T, E: ToString>(result: Result<T, E>) -> String {
    result.err().expect("it was taken").to_string()
}

#[test]
fn matrices() {
    let gaussian = |covariance: Mat<f64>| refused(Gaussian::new("P_0", vec![0.0; 2], covariance));
    let initial = || Gaussian::new("P_0", vec![0.0; 2], Mat::identity(2, 2)).unwrap();
    let linear = |a: Mat<f64>, q: Mat<f64>, c: Mat<f64>, r: Mat<f64>| {
        refused(LinearGaussian::new(initial(), a, q, c, r))
    };
    let one = || Mat::<f64>::identity(2, 2);
    assert_lines!([
        ("a covariance that is not symmetric", gaussian(mat![[1.0, 0.5], [0.4, 1.0]])),
        ("not positive definite", gaussian(mat![[1.0, 2.0], [2.0, 1.0]])),
        ("zero", gaussian(Mat::zeros(2, 2))),
        ("not finite", gaussian(mat![[1.0, f64::NAN], [f64::NAN, 1.0]])),
        ("of another shape", gaussian(Mat::identity(3, 3))),
        ("not square", gaussian(Mat::zeros(2, 3))),
        ("a mean that is not finite", refused(Gaussian::new("P_0", vec![f64::INFINITY], mat![[1.0]]))),
        ("no mean", refused(Gaussian::new("P_0", vec![], Mat::zeros(0, 0)))),
        ("A of another shape", linear(Mat::identity(3, 3), one(), one(), one())),
        ("A not finite", linear(mat![[1.0, 0.0], [f64::NEG_INFINITY, 1.0]], one(), one(), one())),
        ("Q not positive definite", linear(one(), Mat::zeros(2, 2), one(), one())),
        ("C of another shape", linear(one(), one(), Mat::identity(3, 2), one())),
        ("nothing measured", linear(one(), one(), Mat::zeros(0, 2), Mat::zeros(0, 0))),
        ("R not symmetric", linear(one(), one(), one(), mat![[1.0, 0.1], [0.0, 1.0]])),
    ]);
}

#[test]
fn systems() {
    let diffusion = |change: fn(&mut GraphDiffusionConfig)| {
        let mut config = GraphDiffusionConfig::new(10);
        change(&mut config);
        refused(GraphDiffusion::random(&config, &mut Seed::from_u64(1).stream()))
    };
    let epidemic = |change: fn(&mut EpidemicConfig)| {
        let mut config = EpidemicConfig::paper();
        change(&mut config);
        refused(Epidemic::new(&config))
    };
    let abs = GraphDiffusionConfig { drift: Drift::Abs, ..GraphDiffusionConfig::new(10) };
    let abs = GraphDiffusion::random(&abs, &mut Seed::from_u64(1).stream()).unwrap();
    assert_lines!([
        ("an SNR that is not finite", diffusion(|config| config.snr_db = f64::NAN)),
        ("one that leaves no noise", diffusion(|config| config.snr_db = 1e6)),
        ("nothing measured", diffusion(|config| config.measurement_dim = 0)),
        ("more measured than there is", diffusion(|config| config.measurement_dim = 11)),
        ("as many neighbours as nodes", diffusion(|config| config.neighbours = 10)),
        ("no node", diffusion(|config| config.state_dim = 0)),
        ("exact inference where the drift is no identity", refused(abs.moment_matched())),
        ("a negative rate", epidemic(|config| config.infection_rate = -1.0)),
        ("a variance of zero", epidemic(|config| config.state_variance = 0.0)),
        ("a mean that is not finite", epidemic(|config| config.initial_means[1] = f64::NAN)),
    ]);
}

/// Nothing but its dimensions.
struct OfSize {
    states: usize,
    measurements: usize,
}

impl Equations for OfSize {
    fn dimensions(&self) -> [usize; 2] {
        [self.states, self.measurements]
    }
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state.fill_with(|| draws.draw(normal(0.0, 1.0)));
    }
    fn transition<S: Scalar>(&self, step: &Step<'_, S>, _: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        self.initial(step, draws, state);
    }
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], y: &mut impl Coordinates<S>) {
        (0..self.measurements).for_each(|_| y.push(normal(0.0, 1.0)));
    }
}

#[test]
fn a_model_without_states_or_measurements_is_refused_everywhere_with_the_same_words() {
    let seed = Seed::from_u64(1);
    let fine = OfSize { states: 1, measurements: 1 };
    let measurements = simulate(&fine, 3, &mut seed.stream()).unwrap().measurements;
    let config = small_rnn(Cell::Lstm);
    let rnn = |shape: &ModelShape| Rnn::create(&config, shape, 0, Backend::Native.into(), &seed).map(|_| ());
    let mut proposal =
        Rnn::create(&config, &ModelShape::of(&fine), 0, Backend::Native.into(), &seed).unwrap();
    for (model, said) in [
        (
            OfSize { measurements: 0, ..fine },
            "the model's measurement dimension M is 0; it must be at least 1",
        ),
        (OfSize { states: 0, ..fine }, "the model's state dimension N is 0; it must be at least 1"),
    ] {
        assert_eq!(refused(check_model(&model)), said);
        assert_eq!(refused(simulate(&model, 3, &mut seed.stream())), said);
        assert_eq!(refused(Simulations::draw(&model, 3, 2, 1.0, &seed)), said);
        assert_eq!(refused(check_gradients(&model, 3, 1e-5, &mut seed.stream())), said);
        assert_eq!(refused(rnn(&ModelShape::of(&model))), said);
        let (config, proceed) = (TrainConfig::paper(4), |_, _| std::ops::ControlFlow::Continue(()));
        let trained = train(&mut proposal, &model, &measurements, &config, &mut seed.stream(), proceed);
        assert_eq!(refused(trained), said);
    }
}

#[test]
fn measurements() {
    let model = reference().model;
    let stream = || Seed::from_u64(1).stream();
    let step = |measurement: &[f64]| {
        let mut filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(4), stream()).unwrap();
        filter.step(&[0.1]).unwrap();
        refused(filter.step(measurement))
    };
    assert_lines!([
        ("one of them NaN", refused(Measurements::new(2, vec![0.0, 1.0, f64::NAN, 3.0]))),
        ("one of them infinite", refused(Measurements::new(1, vec![0.0, f64::NEG_INFINITY]))),
        ("rows that do not come out even", refused(Measurements::new(2, vec![0.0; 3]))),
        ("rows of nothing", refused(Sequence::new(0, vec![]))),
        ("with gaps, and one of them NaN", refused(PartialMeasurements::new(1, vec![None, Some(f64::NAN)]))),
        ("NaN in a stream", step(&[f64::NAN])),
        ("too wide in a stream", step(&[0.0, 1.0])),
        ("none in a stream", step(&[])),
    ]);
}

/// The gradient overflows 32 bits where the loss does not overflow 64, and nobody waits for the next loss.
#[test]
fn a_training_that_is_ended_early_says_that_it_has_diverged() {
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1e-80]]).unwrap();
    let measurements = reference().measurements;
    let (seed, config) = (Seed::from_u64(1), TrainConfig::paper(4));
    let fresh =
        || Fcnn::create(&small_fcnn(), &ModelShape::of(&model), 5, Backend::Native.into(), &seed).unwrap();
    let mut proposal = fresh();
    let end = |_, loss: f64| {
        assert!(loss.is_finite());
        std::ops::ControlFlow::Break(())
    };
    let found = train(&mut proposal, &model, &measurements, &config, &mut seed.stream(), end);
    assert!(matches!(found, Err(TrainError::Diverged { step: 0, .. })), "{found:?}");

    let (mut proposal, mut stream) = (fresh(), seed.stream());
    let mut training = Training::new(&proposal, &model, &measurements, &config, &mut stream).unwrap();
    training.check_weights(&proposal).unwrap();
    training.step(&mut proposal).unwrap();
    assert!(matches!(training.checkpoint(&proposal), Err(TrainError::Diverged { step: 0, .. })));
}

#[test]
fn filters() {
    let model = reference().model;
    let bank = |settings: FilterSettings, filters: usize| {
        refused(FilterBank::new(&model, Bootstrap, settings, filters, &Seed::from_u64(1)))
    };
    let settings = FilterSettings::new(4);
    let fails = |shift: f64| -> FilterError {
        let model = Shifted { model: reference().model, shift, from: 1 };
        let mut filter =
            ParticleFilter::new(&model, Bootstrap, settings, Seed::from_u64(1).stream()).unwrap();
        filter.step(&[0.0]).unwrap();
        filter.step(&[0.0]).unwrap_err()
    };
    let typed = |error: FilterError| format!("{:?}: {error}", error.kind());
    assert_lines!([
        ("no particle", bank(FilterSettings::new(0), 1)),
        ("more particles than can be stored", bank(FilterSettings::new(usize::MAX), 2)),
        ("more particles than there are bytes", bank(FilterSettings::new(usize::MAX), 1)),
        ("more particles than there is memory for", bank(FilterSettings::new(1 << 50), 1)),
        ("more filters than there is memory for", bank(settings, usize::MAX / 8)),
        ("no filter", bank(settings, 0)),
        (
            "a threshold above 1",
            bank(FilterSettings { resample_when: ResampleWhen::EssBelow(1.5), ..settings }, 1)
        ),
        (
            "a mixture of nothing but the transition",
            bank(FilterSettings { defensive_weight: Some(1.0), ..settings }, 1)
        ),
        ("all weights zero", typed(fails(f64::NEG_INFINITY))),
        ("a weight that is NaN", typed(fails(f64::NAN))),
        ("a weight that is infinite", typed(fails(f64::INFINITY))),
    ]);
}

#[test]
fn proposals_and_training() {
    let (reference, seed, compute) = (reference(), Seed::from_u64(1), Backend::Native.into());
    let model = &reference.model;
    let diffusion = GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut seed.stream()).unwrap();
    let mut fcnn = Fcnn::create(&small_fcnn(), &ModelShape::of(model), 5, compute, &seed).unwrap();
    let mut training = |change: fn(&mut TrainConfig)| {
        let mut config = TrainConfig { steps: 2, ..TrainConfig::paper(4) };
        change(&mut config);
        let proceed = |_, _| std::ops::ControlFlow::Continue(());
        refused(train(&mut fcnn, model, &reference.measurements, &config, &mut seed.stream(), proceed))
    };
    let stream = seed.stream();
    let elsewhere = Fcnn::create(&small_fcnn(), &ModelShape::of(model), 5, compute, &seed).unwrap();
    let mut misplaced = ParticleFilter::new(&diffusion, elsewhere, FilterSettings::new(4), stream).unwrap();
    let mut config = small_rnn(Cell::Lstm);
    config.hidden = 0;
    let refused_noise = MinDegeneracy::new(&diffusion.with_noise(Noise::Uniform));
    assert!(refused_noise.is_ok(), "moments are matched for any noise");
    assert_lines!([
        (
            "a graph network without a graph",
            refused(Gnn::create(
                &small_gnn(motes_proposals::Adapter::Fixed),
                &ModelShape::of(model),
                5,
                compute,
                &seed
            ))
        ),
        (
            "a hidden layer of nothing",
            refused(Rnn::create(&config, &ModelShape::of(model), 0, compute, &seed))
        ),
        (
            "no layer",
            refused(Psi::create(
                &motes_proposals::PsiConfig { layers: 0, ..small_psi() },
                &ModelShape::of(model),
                5,
                compute,
                &seed
            ))
        ),
        ("no time", refused(Fcnn::create(&small_fcnn(), &ModelShape::of(model), 0, compute, &seed))),
        ("a proposal of another system", refused(misplaced.step(&[0.0; 3]))),
        ("training with no particle", training(|config| config.particles = 0)),
        ("with more particles than can be counted", training(|config| config.particles = usize::MAX)),
        ("with more particles than there is memory for", training(|config| config.particles = 1 << 50)),
        (
            "with a rate that is nothing in 32 bits",
            training(|config| config.adam = AdamConfig { learning_rate: 1e-60, ..config.adam })
        ),
        (
            "with a negative rate",
            training(|config| config.adam = AdamConfig { learning_rate: -1.0, ..config.adam })
        ),
        (
            "with a rate that makes it diverge",
            without_loss(&training(|config| {
                config.steps = 50;
                config.adam = AdamConfig { learning_rate: 1e30, ..config.adam };
            }))
        ),
    ]);
}
