//! Draws of distributions whose parameters differ from particle to particle, as filters make them.

use motes_models::batch::Rows;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, binomial, gamma, normal, poisson};
use motes_models::{Seed, StateSpaceModel, Step, Stream};

use crate::task::{Answer, DrawsTask};
use crate::work::Work;

/// Particles of a call, as many as filters hand over at a time.
const PARTICLES: usize = 1024;

/// Particles with parameters of their own, which are drawn for again and again: as many as stay in a cache, so that draws are timed and not memory. `draws_numpy.py` has
/// as many.
const DISTINCT: usize = 16 * PARTICLES;

/// What is drawn, with how large it is in the mean: a count's mean, or a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drawn {
    Binomial,
    Poisson,
    Gamma,
}

/// A model whose state is two parameters and what is drawn by them.
struct OneDraw(Drawn);

impl Equations for OneDraw {
    fn dimensions(&self) -> [usize; 2] {
        [3, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, _: &mut impl Draws<S>, state: &mut [S]) {
        state.fill(S::from(0.0));
    }

    fn transition<S: Scalar>(
        &self,
        _: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        state[0] = before[0];
        state[1] = before[1];
        state[2] = match self.0 {
            Drawn::Binomial => draws.draw(binomial(before[0], before[1])),
            Drawn::Poisson => draws.draw(poisson(before[0])),
            Drawn::Gamma => draws.draw(gamma(before[0], before[1])),
        };
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(state[2], 1.0));
    }
}

/// The parameters of one particle; `draws_numpy.py` has the same.
fn parameters(drawn: Drawn, size: f64, particle: usize) -> [f64; 2] {
    let [u, v] =
        [0.618_033_988_749_894_9, 0.754_877_666_246_692_7].map(|step| (step * particle as f64).fract());
    let size = size * (0.8 + 0.4 * u);
    match drawn {
        Drawn::Binomial => {
            let p = 0.01 + 0.02 * v;
            [(size / p).round(), p]
        }
        Drawn::Poisson => [size, 0.0],
        Drawn::Gamma => [size, 0.5 + v],
    }
}

/// Our draws.
pub(crate) struct Drawing {
    model: OneDraw,
    parameters: Vec<f64>,
    calls: usize,
    stream: Stream,
    states: Vec<f64>,
}

impl Drawing {
    pub(crate) fn of(task: &DrawsTask) -> Result<Self, String> {
        let drawn = match task.distribution.as_str() {
            "binomial" => Drawn::Binomial,
            "poisson" => Drawn::Poisson,
            "gamma" => Drawn::Gamma,
            other => return Err(format!("there is no distribution {other}")),
        };
        let of_particle = |particle| {
            let [a, b] = parameters(drawn, task.size, particle);
            [a, b, 0.0]
        };
        Ok(Drawing {
            model: OneDraw(drawn),
            parameters: (0..DISTINCT).flat_map(of_particle).collect(),
            calls: task.draws / PARTICLES,
            stream: Seed::from_u64(1).child("draws").stream(),
            states: vec![0.0; 3 * PARTICLES],
        })
    }

    /// Draws of all particles in turn; each call shows the states that it drew.
    fn draw(&mut self, mut seen: impl FnMut(&[f64])) {
        let step = Step::of_index(1);
        for before in self.parameters.chunks_exact(3 * PARTICLES).cycle().take(self.calls) {
            let streams = std::slice::from_mut(&mut self.stream);
            self.model.sample_states(&step, Some(Rows::all(before, 3)), streams, &mut self.states);
            seen(&self.states);
        }
    }
}

impl Work for Drawing {
    fn check(&mut self) -> Result<Answer, String> {
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        self.draw(|states| {
            for drawn in states.iter().skip(2).step_by(3) {
                count += 1.0;
                sum += drawn;
                squares += drawn * drawn;
            }
        });
        let mean: f64 = sum / count;
        let error = ((squares / count - mean * mean) / count).sqrt();
        Ok(Answer { mean_draw: Some(mean), mean_draw_error: Some(error), ..Answer::default() })
    }

    fn run(&mut self) -> Result<(), String> {
        self.draw(|states| {
            std::hint::black_box(states);
        });
        Ok(())
    }
}
