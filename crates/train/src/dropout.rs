//! Dropout: each gradient step leaves out some hidden units.

use std::collections::BTreeMap;

use motes_models::Stream;
use motes_proposals::{HiddenReader, Parameters, Parametric, Workspace};
use rand::RngExt;

use crate::TrainError;

/// Refuses a share that is none.
pub(crate) fn check_dropout(share: f64) -> Result<(), TrainError> {
    match (0.0..1.0).contains(&share) {
        true => Ok(()),
        false => Err(TrainError::Setting {
            name: "the share of hidden units that are left out",
            value: share.to_string(),
            expected: "at least 0 and below 1",
        }),
    }
}

/// Leaves out each hidden unit with probability `p` in a gradient step, and scales the others by `1/(1 − p)`, so that the mean of what reads them stays.
///
/// A step has one mask, for all its rows, particles and times: the networks of a step are one function (Gal and Ghahramani 2016, where masks are shared
/// over time). A unit that is left out is one that nobody reads. So the mask `m` multiplies the rows of the matrices that read the unit:
/// `f(z ∘ m, W) = f(z, diag(m) W)`, and the gradient with respect to `W` is `diag(m)` times that with respect to `diag(m) W`. No network knows of it.
pub(crate) struct Dropout {
    share: f64,
    readers: Vec<HiddenReader>,
    /// The factor of each unit, by the layer that it is in.
    factors: BTreeMap<usize, Vec<f64>>,
    /// Each reader as it was.
    kept: Vec<Vec<f64>>,
}

impl Dropout {
    /// That of a proposal; none where nothing is left out.
    ///
    /// # Errors
    /// [`TrainError::Setting`] for a share outside of [0, 1), [`TrainError::NoHiddenUnits`] for a proposal none of whose units can be left out.
    pub(crate) fn new(share: f64, proposal: &(impl Parametric + ?Sized)) -> Result<Option<Self>, TrainError> {
        check_dropout(share)?;
        if share == 0.0 {
            return Ok(None);
        }
        let readers = proposal.hidden_readers();
        if readers.is_empty() {
            return Err(TrainError::NoHiddenUnits { share });
        }
        Ok(Some(Dropout { share, readers, factors: BTreeMap::new(), kept: Vec::new() }))
    }

    /// Draws the mask of a step, and masks the weights by it, until [`Dropout::put_back`].
    pub(crate) fn leave_out(&mut self, parameters: &mut Parameters, stream: &mut Stream) {
        self.factors.clear();
        self.kept.clear();
        let left = 1.0 / (1.0 - self.share);
        for HiddenReader { matrix, fed_by, copies } in &self.readers {
            let [rows, _] = parameters.shape(*matrix);
            let factors = self.factors.entry(*fed_by).or_insert_with(|| {
                let draw = |_| if stream.random::<f64>() < self.share { 0.0 } else { left };
                (0..rows / copies).map(draw).collect()
            });
            self.kept.push(parameters.host(*matrix));
            parameters.scale_rows(*matrix, factors);
        }
    }

    /// The weights as they were before [`Dropout::leave_out`], to the last bit.
    ///
    /// # Errors
    /// [`TrainError::Optimiser`] if they are of another proposal.
    pub(crate) fn put_back(&self, parameters: &mut Parameters) -> Result<(), TrainError> {
        for (HiddenReader { matrix, .. }, values) in self.readers.iter().zip(&self.kept) {
            let set = parameters.set_host(*matrix, values);
            set.map_err(|_| TrainError::Optimiser { what: "the weights that units were left out of" })?;
        }
        Ok(())
    }

    /// Makes a gradient with respect to masked weights one with respect to the weights.
    pub(crate) fn pull_back(&self, workspace: &mut Workspace) {
        let gradients = workspace.gradients();
        for HiddenReader { matrix, fed_by, .. } in &self.readers {
            if let Some(factors) = self.factors.get(fed_by) {
                gradients.scale_rows(*matrix, factors);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
    use motes_models::{
        GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, OwnSteps, Seed, Step,
    };
    use motes_proposals::networks::Inputs;
    use motes_proposals::{
        Amortised, AmortisedConfig, Backend, Cell, Compute, Examples, Family, Fcnn, FcnnConfig, Gnn,
        GnnConfig, Learnable, Precision, Psi, PsiConfig, Rnn, RnnConfig, Sees, Stage, Times,
    };

    use super::*;
    use crate::penalty::add_penalty;
    use crate::{GradientFlow, Objective, rollout};

    const SHARE: f64 = 0.4;
    const PENALTY: f64 = 0.3;

    fn compute() -> Compute {
        Compute { backend: Backend::Native, precision: Precision::F64 }
    }

    fn problem() -> (GraphDiffusion, Measurements) {
        let seed = Seed::from_u64(1);
        let config = GraphDiffusionConfig::new(5);
        let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
        let m = motes_models::StateSpaceModel::measurement_dim(&system);
        let values = (0..2 * m).map(|at| (at as f64).sin()).collect();
        let measurements = Measurements::new(m, values).unwrap();
        (system, measurements)
    }

    /// A family of each kind of hidden layer.
    fn families(system: &GraphDiffusion) -> Vec<(&'static str, Box<dyn Learnable>)> {
        let (shape, seed) = (ModelShape::on_graph(system), Seed::from_u64(2));
        let fcnn = FcnnConfig { widths: vec![4, 3], ..FcnnConfig::paper() };
        let gnn = GnnConfig { features: vec![4, 3], order: 2, ..GnnConfig::paper() };
        let rnn = RnnConfig { cell: Cell::Gru, hidden: 4, depth: 2, ..RnnConfig::paper() };
        vec![
            ("fcnn", Box::new(Fcnn::create(&fcnn, &shape, 2, compute(), &seed).unwrap())),
            ("gnn", Box::new(Gnn::create(&gnn, &shape, 2, compute(), &seed).unwrap())),
            ("rnn", Box::new(Rnn::create(&rnn, &shape, 2, compute(), &seed).unwrap())),
        ]
    }

    /// The mask of a step, always the same.
    fn mask() -> Stream {
        Seed::from_u64(3).stream()
    }

    /// `λ/2 Σ w²`.
    fn penalty_of(proposal: &(impl Parametric + ?Sized)) -> f64 {
        let of_matrix =
            |at: usize| proposal.parameters().host(at).iter().map(|weight| weight * weight).sum::<f64>();
        0.5 * PENALTY * proposal.weight_matrices().into_iter().map(of_matrix).sum::<f64>()
    }

    /// Holds the gradient of a masked loss with a penalty, as a step takes it, against central differences; `loss` leaves the gradient of its value.
    ///
    /// `wrong` spoils the gradient before it is compared; the largest distance to a difference comes back.
    fn distance<P: Parametric + ?Sized>(
        proposal: &mut P,
        loss: impl Fn(&P) -> (f64, Workspace),
        wrong: impl Fn(&Dropout, &mut Workspace),
    ) -> f64 {
        let mut dropout = Dropout::new(SHARE, &*proposal).unwrap().unwrap();
        let before = proposal.parameters().values().clone();
        let mut at = |proposal: &mut P| {
            dropout.leave_out(proposal.parameters_mut(), &mut mask());
            let found = loss(proposal);
            dropout.put_back(proposal.parameters_mut()).unwrap();
            found
        };
        let (_, mut workspace) = at(proposal);
        assert_eq!(*proposal.parameters().values(), before, "what was left out is put back");
        let value = |proposal: &mut P, at: &mut dyn FnMut(&mut P) -> (f64, Workspace)| {
            at(proposal).0 + penalty_of(proposal)
        };
        let mut expected = Vec::new();
        let h = 1e-5;
        for matrix in 0..proposal.parameters().len() {
            let weights = proposal.parameters().host(matrix);
            for place in (0..weights.len()).step_by(3) {
                let mut moved = |by: f64| {
                    let mut weights = weights.clone();
                    weights[place] += by;
                    proposal.parameters_mut().set_host(matrix, &weights).unwrap();
                    value(proposal, &mut at)
                };
                expected.push((matrix, place, (moved(h) - moved(-h)) / (2.0 * h)));
            }
            proposal.parameters_mut().set_host(matrix, &weights).unwrap();
        }
        wrong(&dropout, &mut workspace);
        add_penalty(PENALTY, &*proposal, &mut workspace);
        let gradients = workspace.gradients();
        // A matrix that the loss does not depend on is not penalised in this step.
        expected.iter().fold(0.0, |largest: f64, (matrix, place, expected)| match gradients.host(*matrix) {
            Some(found) => largest.max((found[*place] - expected).abs() / (1.0 + expected.abs())),
            None => largest,
        })
    }

    #[test]
    fn gradients_of_masked_and_penalised_losses_are_those_of_differences() {
        let (system, measurements) = problem();
        for (name, mut proposal) in families(&system) {
            let loss = |proposal: &(dyn Learnable + 'static)| {
                let (objective, flow, mut noise) =
                    (Objective::Elbo, GradientFlow::Full, Seed::from_u64(4).stream());
                let found =
                    rollout(proposal, &system, &measurements, objective, flow, 3, &mut noise).unwrap();
                (-found.objective, found.workspace)
            };
            let right = distance(&mut *proposal, loss, |dropout, workspace| dropout.pull_back(workspace));
            assert!(right < 1e-5, "{name}: {right:e}");
            // The bug: the gradient with respect to masked weights is taken for that of the weights.
            let wrong = distance(&mut *proposal, loss, |_, _| {});
            assert!(wrong > 1e-3, "{name}: {wrong:e}");
        }
    }

    #[test]
    fn so_they_are_of_proposals_that_are_learned_once() {
        let model = Chain;
        let seed = Seed::from_u64(5);
        let shape = ModelShape::on_dependences(&model, &seed);
        for sees in [Sees::All, Sees::Graph { order: 1 }] {
            let config = AmortisedConfig { widths: vec![4, 3], sees, ..AmortisedConfig::mixture(2) };
            let mut proposal = Amortised::create(&config, &shape, 0, compute(), &seed).unwrap();
            // An untrained network reads nothing of its hidden layers.
            let mut stream = seed.child("weights").stream();
            for at in proposal.weight_matrices() {
                let mut weights = proposal.parameters().host(at);
                weights.iter_mut().for_each(|weight| *weight += stream.random::<f64>() - 0.5);
                proposal.parameters_mut().set_host(at, &weights).unwrap();
            }
            let mut examples = Examples::default();
            let mut steps = OwnSteps::new(&model, 20, &seed).unwrap();
            for _ in 0..3 {
                proposal.encode(&model, &steps.advance().unwrap(), &mut examples).unwrap();
            }
            let batch: &Stage = &examples.later;
            let loss = |proposal: &Amortised| {
                let memory = Workspace::new(proposal.parameters());
                let (gain, found) = proposal.differentiate_gain(Times::Later, batch, 0.1, memory).unwrap();
                (-gain, found)
            };
            // Matrices of t = 0 are not penalised in a step of later times; their part of the penalty moves no difference of the others.
            let right = distance(&mut proposal, loss, |dropout, workspace| dropout.pull_back(workspace));
            assert!(right < 1e-5, "{sees:?}: {right:e}");
        }
    }

    /// A chain of three coordinates.
    struct Chain;

    impl Equations for Chain {
        fn dimensions(&self) -> [usize; 2] {
            [3, 2]
        }

        fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
            (0..3).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
        }

        fn transition<S: Scalar>(
            &self,
            _: &Step<'_, S>,
            x: &[S],
            draws: &mut impl Draws<S>,
            state: &mut [S],
        ) {
            state[0] = draws.draw(normal(x[0] * 0.9, 1.0));
            state[1] = draws.draw(normal(x[1] * 0.5 + x[0] * 0.2, 1.0));
            state[2] = draws.draw(normal(x[2] * 0.5 + x[1] * 0.2, 1.0));
        }

        fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
            y.push(normal(x[0] * x[0], 1.0));
            y.push(normal(x[2], 0.5));
        }
    }

    /// With one hidden layer the mean of the distribution is linear in what reads it.
    #[test]
    fn the_mean_over_masks_of_what_reads_a_layer_is_what_it_is_without() {
        let (system, measurements) = problem();
        let shape = ModelShape::of(&system);
        let config = FcnnConfig { widths: vec![6], ..FcnnConfig::paper() };
        let mut proposal = Fcnn::create(&config, &shape, 2, compute(), &Seed::from_u64(6)).unwrap();
        let mean = |proposal: &Fcnn| {
            let mut tape = proposal.tape(1, Workspace::new(proposal.parameters())).unwrap();
            let measurement = measurements.row(0);
            let inputs = Inputs { time: 0, width: 5, previous: None, measurement, particles: 1 };
            let mut state = [0.0; 5];
            tape.draw(&inputs, &[0.0; 5], &mut state, None).unwrap();
            state
        };
        let expected = mean(&proposal);
        let mut dropout = Dropout::new(SHARE, &proposal).unwrap().unwrap();
        let mut stream = Seed::from_u64(7).stream();
        let masks = 4000;
        let drawn: Vec<[f64; 5]> = (0..masks)
            .map(|_| {
                dropout.leave_out(proposal.parameters_mut(), &mut stream);
                let found = mean(&proposal);
                dropout.put_back(proposal.parameters_mut()).unwrap();
                found
            })
            .collect();
        for (coordinate, expected) in expected.iter().enumerate() {
            let n = f64::from(masks);
            let mean = drawn.iter().map(|state| state[coordinate]).sum::<f64>() / n;
            let squares = drawn.iter().map(|state| (state[coordinate] - mean).powi(2)).sum::<f64>();
            let z = (mean - expected) / (squares / (n - 1.0) / n).sqrt();
            assert!(z.abs() < 4.0, "coordinate {coordinate}: z = {z}");
        }
    }

    #[test]
    fn what_cannot_be_left_out_is_refused() {
        let (system, _) = problem();
        let shape = ModelShape::of(&system);
        let psi = Psi::create(&PsiConfig::paper(), &shape, 2, compute(), &Seed::from_u64(8)).unwrap();
        assert_eq!(Dropout::new(0.5, &psi).err(), Some(TrainError::NoHiddenUnits { share: 0.5 }));
        assert!(Dropout::new(0.0, &psi).unwrap().is_none());
        for share in [-0.1, 1.0, f64::NAN] {
            assert!(matches!(Dropout::new(share, &psi), Err(TrainError::Setting { .. })), "{share}");
        }
        for penalty in [-0.1, f64::INFINITY, f64::NAN] {
            assert!(crate::penalty::check_penalty(penalty).is_err(), "{penalty}");
        }
    }
}
