//! Heads: densities that integrate to 1, draws that follow them, derivatives; and a planted bug.

use std::sync::Mutex;

use motes_models::batch::LANES;
use motes_models::equations::Lanes;
use motes_models::{Seed, Stream, fill_standard_normal, fill_uniform};
use motes_proposals::{Covariance, Head, HeadConfig};
use rand::RngExt;

/// Every kind of head, for states of `n` coordinates.
fn heads(n: usize) -> Vec<(String, Box<dyn Head>)> {
    let mut configs = Vec::new();
    for covariance in [Covariance::Full, Covariance::Diagonal] {
        configs.push(HeadConfig::Gaussian { covariance });
        configs.push(HeadConfig::Mixture { components: 3, covariance });
        configs.push(HeadConfig::Flow { pieces: 6, covariance });
    }
    let covariance = Covariance::Shared;
    configs.push(HeadConfig::Gaussian { covariance });
    configs.push(HeadConfig::Flow { pieces: 6, covariance });
    configs.push(HeadConfig::Kernel);
    configs.into_iter().map(|config| (format!("{config:?}, N = {n}"), config.head(n).unwrap())).collect()
}

/// Parameters around those of an untrained network, the same in each lane or others.
fn theta(head: &dyn Head, size: f64, differ: bool, stream: &mut Stream) -> Vec<Lanes> {
    let around = |start: f64, stream: &mut Stream| start + size * (2.0 * stream.random::<f64>() - 1.0);
    let draw = |start: &f64| match differ {
        true => Lanes(std::array::from_fn(|_| around(*start, stream))),
        false => Lanes::from(around(*start, stream)),
    };
    head.start().iter().map(draw).collect()
}

fn log_density(head: &dyn Head, theta: &[Lanes], u: &[Lanes]) -> Lanes {
    head.log_density(theta, u, &mut vec![Lanes::from(0.0); head.scratch()])
}

#[test]
fn densities_integrate_to_one() {
    let mut stream = Seed::from_u64(1).stream();
    for (name, head) in heads(1) {
        for _ in 0..5 {
            let theta = theta(&*head, 0.8, false, &mut stream);
            // A tile of points at a time, from −40 to 40.
            let step = 0.0005;
            let sum: f64 = (0..5000)
                .map(|tile| {
                    let u = Lanes(std::array::from_fn(|lane| -40.0 + step * (tile * LANES + lane) as f64));
                    log_density(&*head, &theta, &[u]).0.iter().map(|log| log.exp() * step).sum::<f64>()
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-6, "{name}: {sum}");
        }
    }
}

/// How far the mean of `φ(u)/h(u)` over draws `u ~ h` is from 1, in standard errors: it is 1 for any density `φ` inside of the support of `h`.
///
/// `draws` draws, `densities` says what their density is said to be.
fn score(draws: &dyn Head, densities: &dyn Head, n: usize, seed: u64) -> f64 {
    let mut stream = Seed::from_u64(seed).stream();
    let theta = theta(draws, 0.5, false, &mut stream);
    // A normal density that is narrower than any component.
    let (centre, sd) = (0.2, 0.35);
    let mut ratios = Vec::new();
    for _ in 0..4000 {
        let mut u = vec![Lanes::from(0.0); n];
        u.iter_mut().for_each(|u| fill_standard_normal(&mut stream, &mut u.0));
        let mut uniforms = vec![Lanes::from(0.0); draws.uniforms()];
        uniforms.iter_mut().for_each(|u| fill_uniform(&mut stream, &mut u.0));
        draws.draw(&theta, &uniforms, &mut u);
        let log = log_density(densities, &theta, &u);
        for (lane, log) in log.0.iter().enumerate() {
            let of_point = |u: &Lanes| {
                let z = (u.0[lane] - centre) / sd;
                -0.5 * z * z - (sd * std::f64::consts::TAU.sqrt()).ln()
            };
            ratios.push((u.iter().map(of_point).sum::<f64>() - log).exp());
        }
    }
    let n = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

#[test]
fn draws_follow_their_density() {
    for n in [1, 2, 3] {
        for (number, (name, head)) in heads(n).into_iter().enumerate() {
            let z = score(&*head, &*head, n, 10 + number as u64);
            assert!(z.abs() < 4.0, "{name}: z = {z}");
        }
    }
}

/// A mixture that forgets the weights of its components in its density.
struct Unweighted(Box<dyn Head>, usize);

impl Head for Unweighted {
    fn outputs(&self) -> usize {
        self.0.outputs()
    }

    fn start(&self) -> Vec<f64> {
        self.0.start()
    }

    fn uniforms(&self) -> usize {
        self.0.uniforms()
    }

    fn draw(&self, theta: &[Lanes], uniforms: &[Lanes], normals: &mut [Lanes]) {
        self.0.draw(theta, uniforms, normals);
    }

    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        let mut theta = theta.to_vec();
        let each = theta.len() / self.1;
        theta.iter_mut().step_by(each).for_each(|weight| *weight = Lanes::from(0.0));
        self.0.log_density(&theta, u, scratch)
    }

    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes {
        self.0.gradient(theta, u, d_theta, scratch)
    }

    fn scratch(&self) -> usize {
        self.0.scratch()
    }
}

#[test]
fn a_mixtures_density_without_its_weights_is_caught() {
    let head = || HeadConfig::Mixture { components: 3, covariance: Covariance::Full }.head(1).unwrap();
    let z = score(&*head(), &Unweighted(head(), 3), 1, 11);
    assert!(z.abs() > 4.0, "z = {z}");
}

/// A flow that takes the density of its noise for that of its draws.
struct WithoutDeterminant(Box<dyn Head>, Mutex<Vec<Lanes>>);

impl Head for WithoutDeterminant {
    fn outputs(&self) -> usize {
        self.0.outputs()
    }

    fn start(&self) -> Vec<f64> {
        self.0.start()
    }

    fn draw(&self, theta: &[Lanes], uniforms: &[Lanes], normals: &mut [Lanes]) {
        *self.1.lock().unwrap() = normals.to_vec();
        self.0.draw(theta, uniforms, normals);
    }

    fn log_density(&self, _: &[Lanes], _: &[Lanes], _: &mut [Lanes]) -> Lanes {
        let noise = self.1.lock().unwrap();
        let of_one = |z: &Lanes| Lanes(z.0.map(|z| -0.5 * z * z - 0.5 * std::f64::consts::TAU.ln()));
        noise.iter().map(of_one).fold(Lanes::from(0.0), |sum, log| sum + log)
    }

    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes {
        self.0.gradient(theta, u, d_theta, scratch)
    }

    fn scratch(&self) -> usize {
        self.0.scratch()
    }
}

#[test]
fn a_flow_without_its_determinant_is_caught() {
    let head = HeadConfig::Flow { pieces: 6, covariance: Covariance::Full }.head(1).unwrap();
    let wrong = WithoutDeterminant(head, Mutex::default());
    let z = score(&wrong, &wrong, 1, 12);
    assert!(z.abs() > 4.0, "z = {z}");
}

#[test]
fn gradients_are_those_of_differences() {
    let mut stream = Seed::from_u64(3).stream();
    for n in [1, 3] {
        for (name, head) in heads(n) {
            // Differences have no digits left where the kernel's matrix is nearly singular.
            let size = if name.starts_with("Kernel") { 0.3 } else { 0.8 };
            let theta = theta(&*head, size, true, &mut stream);
            let mut u = vec![Lanes::from(0.0); n];
            u.iter_mut().for_each(|u| fill_standard_normal(&mut stream, &mut u.0));
            let mut found = vec![Lanes::from(f64::NAN); head.outputs()];
            let mut scratch = vec![Lanes::from(0.0); head.scratch()];
            let value = head.gradient(&theta, &u, &mut found, &mut scratch);
            assert_eq!(value, log_density(&*head, &theta, &u), "{name}");
            let h = 1e-5;
            for (at, found) in found.iter().enumerate() {
                let moved = |by: f64| {
                    let mut theta = theta.clone();
                    theta[at] = theta[at] + Lanes::from(by);
                    log_density(&*head, &theta, &u)
                };
                let (up, down) = (moved(h), moved(-h));
                for (lane, found) in found.0.iter().enumerate() {
                    let expected = (up.0[lane] - down.0[lane]) / (2.0 * h);
                    assert!(
                        (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                        "{name}, parameter {at}: {found} for {expected}"
                    );
                }
            }
        }
    }
}

/// Parameters and a draw of a head, with the noise that it was drawn from.
fn drawn(head: &dyn Head, name: &str, n: usize, stream: &mut Stream) -> [Vec<Lanes>; 3] {
    let size = if name.starts_with("Kernel") { 0.3 } else { 0.8 };
    let theta = theta(head, size, true, stream);
    let mut noise = vec![Lanes::from(0.0); n];
    // Some of them so large that a spline is the identity.
    noise.iter_mut().for_each(|noise| {
        fill_standard_normal(stream, &mut noise.0);
        noise.0.iter_mut().for_each(|value| *value *= 2.0);
    });
    let mut u = noise.clone();
    head.draw(&theta, &[], &mut u);
    [theta, noise, u]
}

#[test]
fn slopes_along_draws_and_derivatives_of_draws_are_those_of_differences() {
    let mut stream = Seed::from_u64(5).stream();
    let mut seen = 0;
    for n in [1, 3] {
        for (name, head) in heads(n) {
            let Some(reparametrised) = head.reparametrised() else {
                assert!(name.starts_with("Mixture"), "{name}");
                continue;
            };
            seen += 1;
            let [theta, noise, u] = drawn(&*head, &name, n, &mut stream);
            let mut scratch = vec![Lanes::from(0.0); head.scratch()];
            let near = |found: f64, expected: f64, what: &str| {
                let distance = (found - expected).abs();
                assert!(distance < 1e-6 * (1.0 + expected.abs()), "{name}, {what}: {found} for {expected}");
            };
            let h = 1e-5;
            let mut slope = vec![Lanes::from(f64::NAN); n];
            reparametrised.slope(&theta, &u, &mut slope, &mut scratch);
            for at in 0..n {
                let moved = |by: f64| {
                    let mut u = u.clone();
                    u[at] = u[at] + Lanes::from(by);
                    log_density(&*head, &theta, &u)
                };
                let (up, down) = (moved(h), moved(-h));
                for lane in 0..LANES {
                    near(slope[at].0[lane], (up.0[lane] - down.0[lane]) / (2.0 * h), "slope");
                }
            }
            let pull: Vec<Lanes> = (0..n).map(|at| Lanes::from(1.0 - 0.7 * at as f64)).collect();
            let mut found = vec![Lanes::from(f64::NAN); head.outputs()];
            reparametrised.pull_back(&theta, &u, &mut pull.clone(), &mut found, &mut scratch);
            for (at, found) in found.iter().enumerate() {
                // The same noise by other parameters.
                let moved = |by: f64| {
                    let mut theta = theta.clone();
                    theta[at] = theta[at] + Lanes::from(by);
                    let mut u = noise.clone();
                    head.draw(&theta, &[], &mut u);
                    u.iter().zip(&pull).fold(Lanes::from(0.0), |sum, (u, pull)| sum + *u * *pull)
                };
                let (up, down) = (moved(h), moved(-h));
                for (lane, found) in found.0.iter().enumerate() {
                    near(*found, (up.0[lane] - down.0[lane]) / (2.0 * h), &format!("parameter {at}"));
                }
            }
        }
    }
    assert_eq!(seen, 14);
}

#[test]
fn a_network_that_extrapolates_gives_no_scale_beyond_bounds() {
    for (name, head) in heads(2) {
        let theta = vec![Lanes::from(1e6); head.outputs()];
        let log = log_density(&*head, &theta, &[Lanes::from(0.5); 2]);
        assert!(log.0.iter().all(|log| log.is_finite() && *log < 1e20), "{name}: {}", log.0[0]);
    }
}
