//! Derivatives that the proposals and training take, against central differences in f64.

use std::ops::ControlFlow;

use faer::MatRef;
use motes_models::batch::Rows;
use motes_models::{
    Drift, GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, Noise, Seed, StateSpaceModel,
    Step, simulate,
};
use motes_proposals::networks::Inputs;
use motes_proposals::{
    Backend, Cell, Compute, Family, Fcnn, Gradients, KernelCovariance, Learnable, Precision, Psi, Rnn,
    Workspace,
};
use motes_smc::{Conditional, Context, GaussianBatch, Proposal};
use motes_tests::{
    central_differences, distance, every_small_family, norm, relative_distance, small_fcnn, small_psi,
    small_rnn,
};
use motes_train::{AdamConfig, GradientFlow, Objective, Schedule, TrainConfig, rollout, train};
use rand::RngExt;

fn random(count: usize, seed: u64) -> Vec<f64> {
    let mut stream = Seed::from_u64(seed).stream();
    (0..count).map(|_| 2.0 * stream.random::<f64>() - 1.0).collect()
}

#[test]
fn a_sample_and_its_log_density_through_the_kernel_covariance() {
    let (n, particles) = (4, 3);
    let (z, mixing) = (random(n * particles, 62), random(n * n, 63));
    let (noise, d_states, d_log) =
        (random(n * particles, 64), random(n * particles, 65), random(particles, 66));
    let ridge = 0.05;
    let scalar = |z: &[f64], mixing: &[f64]| {
        let lowers = KernelCovariance::new(n, mixing, ridge).unwrap().factors(z).unwrap();
        let mut states = vec![0.0; n * particles];
        for row in 0..particles {
            let l = MatRef::from_column_major_slice(&lowers[row * n * n..(row + 1) * n * n], n, n);
            for i in 0..n {
                states[row * n + i] = (0..n).map(|j| l[(i, j)] * noise[row * n + j]).sum();
            }
        }
        let mut log_density = vec![0.0; particles];
        GaussianBatch::new(n, vec![0.0; n * particles], lowers).log_density(&states, &mut log_density);
        let of_states: f64 = states.iter().zip(&d_states).map(|(x, d)| x * d).sum();
        of_states + log_density.iter().zip(&d_log).map(|(l, d)| l * d).sum::<f64>()
    };
    let covariance = KernelCovariance::new(n, &mixing, ridge).unwrap();
    let lowers = covariance.factors(&z).unwrap();
    let (d_z, d_mixing) = covariance.pull_back(&z, &lowers, &noise, &d_states, Some(&d_log));
    assert!(relative_distance(&d_z, &central_differences(&z, 1e-6, |z| scalar(z, &mixing))) < 1e-5);
    let numeric = central_differences(&mixing, 1e-6, |mixing| scalar(&z, mixing));
    assert!(relative_distance(&d_mixing, &numeric) < 1e-5);
}

fn problem(drift: Drift) -> (GraphDiffusion, Measurements) {
    let config = GraphDiffusionConfig { drift, noise: Noise::Gaussian, ..GraphDiffusionConfig::new(5) };
    let system = GraphDiffusion::random(&config, &mut Seed::from_u64(67).stream()).unwrap();
    let measurements = simulate(&system, 3, &mut Seed::from_u64(68).stream()).unwrap().measurements;
    (system, measurements)
}

fn families(system: &GraphDiffusion, compute: Compute) -> Vec<(String, Box<dyn Learnable>)> {
    every_small_family(&ModelShape::on_graph(system), 3, compute, &Seed::from_u64(69))
}

/// The value of the loss and its gradient with respect to each matrix of weights.
type LossAndGradients = (f64, Vec<Vec<f64>>);

fn loss_and_gradients(
    proposal: &dyn Learnable,
    system: &GraphDiffusion,
    measurements: &Measurements,
    objective: Objective,
) -> LossAndGradients {
    let mut stream = Seed::from_u64(70).stream();
    let flow = GradientFlow::Full;
    let found = rollout(proposal, system, measurements, objective, flow, 4, &mut stream).unwrap();
    (-found.objective, host(&found.workspace.into_gradients(), proposal))
}

/// The gradient of each matrix; zeros where the loss does not depend on it, as on what multiplies `x_{−1} = 0`.
fn host(gradients: &Gradients, proposal: &dyn Learnable) -> Vec<Vec<f64>> {
    let parameters = proposal.parameters();
    let gradient = |at: usize| gradients.host(at).unwrap_or_else(|| vec![0.0; parameters.host(at).len()]);
    (0..parameters.len()).map(gradient).collect()
}

/// Holds the gradient with respect to each matrix against central differences.
fn check_gradients(
    label: &str,
    proposal: &mut dyn Learnable,
    loss_and_gradients: &dyn Fn(&dyn Learnable) -> LossAndGradients,
) {
    let (_, gradients) = loss_and_gradients(proposal);
    let whole = norm(&gradients.concat());
    for (index, gradient) in gradients.iter().enumerate() {
        let values = proposal.parameters().host(index);
        let numeric = central_differences(&values, 1e-5, |values| {
            proposal.parameters_mut().set_host(index, values).unwrap();
            loss_and_gradients(proposal).0
        });
        proposal.parameters_mut().set_host(index, &values).unwrap();
        let name = &proposal.parameters().names()[index];
        // What the loss does not depend on (an offset common to all of z, say) has a gradient of rounding errors.
        let error = distance(gradient, &numeric) / (norm(&numeric) + 1e-5 * whole);
        assert!(error < 1e-5, "{label}, {name}: relative error {error:e}");
    }
}

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };

#[test]
fn states_and_gradients_do_not_depend_on_whether_a_density_is_asked_for() {
    let (system, measurements) = problem(Drift::Abs);
    let compute = Compute { backend: Backend::Native, precision: Precision::F64 };
    for (family, proposal) in
        every_small_family(&ModelShape::on_graph(&system), 3, compute, &Seed::from_u64(72))
    {
        let particles = 11;
        let drawn = |asked: bool| {
            let mut tape = proposal.tape(particles, Workspace::new(proposal.parameters())).unwrap();
            let (mut states, mut log_q) = (vec![vec![0.0; 5 * particles]; 2], vec![0.0; particles]);
            for time in 0..2 {
                let (earlier, now) = states.split_at_mut(time);
                let previous = earlier.last().map(Vec::as_slice);
                let measurement = measurements.row(time);
                let inputs = Inputs { time, width: 5, previous, measurement, particles };
                let noise: Vec<f64> = random(5 * particles, 73).iter().map(|u| 0.5 * (u + 1.0)).collect();
                tape.draw(&inputs, &noise, &mut now[0], asked.then_some(&mut log_q)).unwrap();
            }
            let zeros = vec![0.0; particles];
            for time in (0..2).rev() {
                let d_states = random(5 * particles, 74 + time);
                let mut d_previous = vec![0.0; 5 * particles];
                tape.pull_back(&d_states, asked.then_some(&zeros), &mut d_previous).unwrap();
            }
            let gradients = tape.finish().into_gradients();
            let count = proposal.parameters().len();
            (states, (0..count).map(|index| gradients.host(index)).collect::<Vec<_>>())
        };
        assert_eq!(drawn(true), drawn(false), "{family}");
    }
}

#[test]
fn the_whole_objective_with_respect_to_every_weight() {
    for drift in [Drift::Identity, Drift::Abs] {
        let (system, measurements) = problem(drift);
        for (name, mut proposal) in families(&system, F64) {
            for objective in [Objective::LogLikelihood, Objective::Literal, Objective::Elbo] {
                check_gradients(
                    &format!("{name}, {drift:?}, {objective:?}"),
                    proposal.as_mut(),
                    &|proposal| loss_and_gradients(proposal, &system, &measurements, objective),
                );
            }
        }
    }
}

#[test]
fn the_whole_objective_of_trained_proposals() {
    let (system, measurements) = problem(Drift::Identity);
    for (name, mut proposal) in families(&system, F64) {
        let adam = AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() };
        let config = TrainConfig { steps: 50, adam, ..TrainConfig::paper(4) };
        let mut stream = Seed::from_u64(71).stream();
        let proceed = |_, _| ControlFlow::Continue(());
        train(proposal.as_mut(), &system, &measurements, &config, &mut stream, proceed).unwrap();
        check_gradients(&format!("trained {name}"), proposal.as_mut(), &|proposal| {
            loss_and_gradients(proposal, &system, &measurements, Objective::Elbo)
        });
    }
}

#[test]
fn backends_agree_on_loss_and_gradients() {
    let (system, measurements) = problem(Drift::Identity);
    for (precision, tolerance) in [(Precision::F32, 1e-4), (Precision::F64, 1e-9)] {
        for objective in [Objective::LogLikelihood, Objective::Elbo] {
            let of = |backend| {
                let proposals = families(&system, Compute { backend, precision }).into_iter();
                proposals.map(|(name, proposal)| {
                    (name, loss_and_gradients(proposal.as_ref(), &system, &measurements, objective))
                })
            };
            let native: Vec<_> = of(Backend::Native).collect();
            for backend in Backend::built(precision) {
                for ((name, native), (_, other)) in native.iter().zip(of(backend)) {
                    assert!((native.0 / other.0 - 1.0).abs() < tolerance, "{name} on {backend}");
                    let distance = relative_distance(&native.1.concat(), &other.1.concat());
                    assert!(
                        distance < tolerance,
                        "{name} on {backend}, {precision:?}: gradients differ by {distance:e}"
                    );
                }
            }
        }
    }
}

/// The objective in which each window takes the states and the memory it starts with as given by `base`.
fn objective_by_windows<F: Family + Learnable + Proposal<GraphDiffusion>>(
    base: &mut F,
    proposal: &mut F,
    (system, measurements): (&GraphDiffusion, &Measurements),
    window: usize,
) -> f64
where
    F::Memory: Clone,
{
    let (n, particles) = (5, 4);
    // In step with each other: both draw the same noise.
    let [mut streams, mut same_noise] = [70, 70].map(|seed| [Seed::from_u64(seed).stream()]);
    let mut base_memory = Proposal::<GraphDiffusion>::initial_memory(base, particles);
    let mut memory = Proposal::<GraphDiffusion>::initial_memory(proposal, particles);
    let (mut base_states, mut states) = (vec![0.0; n * particles], vec![0.0; n * particles]);
    let (mut log_q, mut log_model, mut sum) = (vec![0.0; particles], vec![0.0; particles], 0.0);
    for (time, measurement) in measurements.rows().enumerate() {
        if time % window == 0 {
            states.clone_from(&base_states);
            memory = base_memory.clone();
        }
        let context =
            |previous| Context::new(Step::of_index(time), (time > 0).then_some(previous), particles);
        let previous = base_states.clone();
        let mut scratch = F::Scratch::default();
        let mut conditional = base
            .condition_batch(system, context(&previous), measurement, &mut base_memory, &mut scratch)
            .unwrap();
        conditional.sample(&mut streams, &mut base_states, &mut log_q);
        drop(conditional);
        let previous = states.clone();
        let mut conditional = proposal
            .condition_batch(system, context(&previous), measurement, &mut memory, &mut scratch)
            .unwrap();
        conditional.sample(&mut same_noise, &mut states, &mut log_q);
        drop(conditional);
        match time {
            0 => system.density().unwrap().log_densities(&Step::of_index(0), None, &states, &mut log_model),
            _ => system.density().unwrap().log_densities(
                &Step::of_index(time),
                Some(Rows::all(&previous, n)),
                &states,
                &mut log_model,
            ),
        }
        sum += log_model.iter().sum::<f64>();
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        system.log_likelihoods(&Step::of_index(time), &states, &entries, &mut log_model).unwrap();
        sum += log_model.iter().sum::<f64>();
    }
    sum / particles as f64
}

fn check_truncated<F: Family + Learnable + Proposal<GraphDiffusion> + Clone>(config: &F::Config)
where
    F::Memory: Clone,
{
    let (system, measurements) = problem(Drift::Abs);
    let proposal = F::create(config, &ModelShape::on_graph(&system), 3, F64, &Seed::from_u64(69)).unwrap();
    for window in 1..=3 {
        let mut stream = Seed::from_u64(70).stream();
        let (objective, flow) = (Objective::LogLikelihood, GradientFlow::Truncated { window });
        let found = rollout(&proposal, &system, &measurements, objective, flow, 4, &mut stream).unwrap();
        let (mut base, mut moved) = (proposal.clone(), proposal.clone());
        let loss = |base: &mut F, moved: &mut F| {
            -objective_by_windows(base, moved, (&system, &measurements), window)
        };
        assert!((loss(&mut base, &mut moved) / -found.objective - 1.0).abs() < 1e-12);
        let gradients = host(&found.workspace.into_gradients(), &proposal);
        let whole = norm(&gradients.concat());
        for (index, gradient) in gradients.iter().enumerate() {
            let values = proposal.parameters().host(index);
            let numeric = central_differences(&values, 1e-5, |values| {
                moved.parameters_mut().set_host(index, values).unwrap();
                loss(&mut base, &mut moved)
            });
            moved.parameters_mut().set_host(index, &values).unwrap();
            let error = distance(gradient, &numeric) / (norm(&numeric) + 1e-5 * whole);
            let name = &proposal.parameters().names()[index];
            assert!(error < 1e-5, "{}, window {window}, {name}: relative error {error:e}", F::NAME);
        }
    }
}

#[test]
fn a_truncated_gradient_is_that_of_windows_that_take_their_past_as_given() {
    check_truncated::<Fcnn>(&small_fcnn());
    check_truncated::<Psi>(&small_psi());
    check_truncated::<Rnn>(&small_rnn(Cell::Lstm));
}

#[test]
fn a_clipped_gradient_is_shorter_and_points_the_same_way() {
    let (system, measurements) = problem(Drift::Identity);
    let adam = AdamConfig { epsilon: 1e3, ..AdamConfig::paper() };
    // With so large an ε a step of Adam is the gradient itself, scaled.
    let moved = |clip_norm| {
        let mut proposal =
            Fcnn::create(&small_fcnn(), &ModelShape::on_graph(&system), 3, F64, &Seed::from_u64(69)).unwrap();
        let before: Vec<f64> = weights(&proposal);
        let config = TrainConfig { steps: 1, adam, clip_norm, ..TrainConfig::paper(4) };
        let mut stream = Seed::from_u64(70).stream();
        let proceed = |_, _| ControlFlow::Continue(());
        train(&mut proposal, &system, &measurements, &config, &mut stream, proceed).unwrap();
        weights(&proposal).iter().zip(&before).map(|(after, before)| after - before).collect::<Vec<f64>>()
    };
    let mut stream = Seed::from_u64(70).stream();
    let proposal =
        Fcnn::create(&small_fcnn(), &ModelShape::on_graph(&system), 3, F64, &Seed::from_u64(69)).unwrap();
    let (objective, flow) = (Objective::LogLikelihood, GradientFlow::Full);
    let found = rollout(&proposal, &system, &measurements, objective, flow, 4, &mut stream).unwrap();
    let gradients = found.workspace.into_gradients();
    let length = gradients.norm();
    assert!((length / norm(&host(&gradients, &proposal).concat()) - 1.0).abs() < 1e-12);
    let (free, clipped, loose) = (moved(None), moved(Some(0.25 * length)), moved(Some(2.0 * length)));
    assert_eq!(free, loose);
    let quarter: Vec<f64> = free.iter().map(|step| 0.25 * step).collect();
    assert!(relative_distance(&clipped, &quarter) < 0.05);
}

#[test]
fn halfway_along_a_cosine_a_step_has_half_its_length() {
    let (system, measurements) = problem(Drift::Identity);
    let after = |steps_taken: usize, schedule| {
        let mut proposal =
            Fcnn::create(&small_fcnn(), &ModelShape::on_graph(&system), 3, F64, &Seed::from_u64(69)).unwrap();
        let config = TrainConfig { steps: 2, schedule, ..TrainConfig::paper(4) };
        let mut stream = Seed::from_u64(70).stream();
        let stop = |step, _| {
            if step + 1 == steps_taken { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        train(&mut proposal, &system, &measurements, &config, &mut stream, stop).unwrap();
        weights(&proposal)
    };
    let first = after(1, Schedule::Constant);
    assert_eq!(first, after(1, Schedule::Cosine));
    let from_first = |schedule| {
        after(2, schedule).iter().zip(&first).map(|(after, before)| after - before).collect::<Vec<f64>>()
    };
    let half: Vec<f64> = from_first(Schedule::Constant).iter().map(|step| 0.5 * step).collect();
    assert!(norm(&half) > 0.0);
    assert!(relative_distance(&from_first(Schedule::Cosine), &half) < 1e-9);
}

fn weights(proposal: &dyn Learnable) -> Vec<f64> {
    (0..proposal.parameters().len()).flat_map(|at| proposal.parameters().host(at)).collect()
}
