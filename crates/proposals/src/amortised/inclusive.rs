//! The inclusive objective: how likely an amortised proposal finds what a model drew, and its derivative.

use motes_models::batch::{LANES, load, store};
use motes_models::equations::{Lanes, Scalar};
use motes_networks::{Inference, Inputs, NetworkTape, Workspace};
use motes_smc::ProposalError;

use super::examples::Stage;
use super::proposal::Amortised;
use super::theta::Theta;
use super::units::{flat, flat_mut, lanes};
use crate::settings::of_networks;

impl Amortised {
    /// `mean log[(1 − α) h(u | θ) + α p(u)] − log p(u)` over the rows of a stage, in nats: how much likelier than the transition `p` the proposal
    /// finds the states that were drawn, with a share `α` of the transition mixed in.
    ///
    /// It is 0 where there are no rows. Its expectation is largest for `p(x_t | x_{t−1}, y_t)`, which gives the information that the measurement has on the state.
    ///
    /// # Errors
    /// [`ProposalError`] if the networks cannot be asked.
    pub fn gain(&self, stage: Times, rows: &Stage, share: f64) -> Result<f64, ProposalError> {
        if rows.is_empty() {
            return Ok(0.0);
        }
        let of_all = self.theta(stage.time());
        let mut theta = vec![0.0; rows.len() * of_all.emitted];
        let inputs = inputs_of(stage, rows.width, &rows.inputs);
        let run =
            Inference::default().run(&self.networks, &self.parameters, &inputs, &mut [], &mut [&mut theta]);
        run.map_err(of_networks)?;
        Ok(self.over_tiles(stage, rows, &of_all, &mut theta, share, None))
    }

    /// [`Amortised::gain`]; the workspace then holds the derivatives of its negative with respect to the weights.
    ///
    /// # Errors
    /// As [`Amortised::gain`].
    pub fn differentiate_gain(
        &self,
        stage: Times,
        rows: &Stage,
        share: f64,
        workspace: Workspace,
    ) -> Result<(f64, Workspace), ProposalError> {
        let mut tape =
            NetworkTape::new(&self.networks, &self.parameters, rows.len(), workspace).map_err(of_networks)?;
        let of_all = self.theta(stage.time());
        let mut theta = vec![0.0; rows.len() * of_all.emitted];
        tape.forward(&inputs_of(stage, rows.width, &rows.inputs), &mut [&mut theta]).map_err(of_networks)?;
        let mut slopes = of_all.no_slopes();
        let gain = self.over_tiles(stage, rows, &of_all, &mut theta, share, Some(&mut slopes));
        of_all.hand_over(&slopes, tape.gradients());
        tape.backward_to_weights(&[&theta]).map_err(of_networks)?;
        Ok((gain, tape.finish()))
    }

    /// The mean gain; `theta`, what the network emitted, is replaced by the derivative of its negative if that is wanted, and the derivative along what all
    /// particles share is added to `slopes`.
    fn over_tiles(
        &self,
        stage: Times,
        rows: &Stage,
        of_all: &Theta,
        theta: &mut [f64],
        share: f64,
        mut slopes: Option<&mut Vec<f64>>,
    ) -> f64 {
        let (head, emitted) = (self.head(stage.time()), of_all.emitted);
        let (n, outputs, count) = (self.sizes(stage.time()).units, head.outputs(), rows.len());
        let mut memory = vec![0.0; (n + 2 * outputs + head.scratch()) * LANES];
        let (units, rest) = lanes(&mut memory).split_at_mut(n);
        let (of_theta, rest) = rest.split_at_mut(outputs);
        let (d_theta, scratch) = rest.split_at_mut(outputs);
        of_all.place_shared(of_theta);
        let (log_head, log_share) = ((-share).ln_1p(), share.ln());
        let mut sum = 0.0;
        for (first, theta) in (0..count).step_by(LANES).zip(theta.chunks_mut(LANES * emitted)) {
            let last = (first + LANES).min(count);
            load(&rows.units[first * n..last * n], n, flat_mut(units));
            of_all.load(theta, of_theta);
            let mut of_transition = Lanes::from(0.0);
            of_transition.0[..last - first].copy_from_slice(&rows.log_transition[first..last]);
            let of_head = match slopes {
                Some(_) => head.gradient(of_theta, units, d_theta, scratch),
                None => head.log_density(of_theta, units, scratch),
            };
            // log[(1 − α) h + α p], with the larger of both in front.
            let (a, b) = (of_head + log_head, of_transition + log_share);
            let largest = a.max(b);
            let mixture = largest + ((a - largest).exp() + (b - largest).exp()).ln();
            sum += (0..last - first).map(|lane| mixture.0[lane] - of_transition.0[lane]).sum::<f64>();
            if let Some(slopes) = &mut slopes {
                let weight = (a - mixture).exp() * (-1.0 / count as f64);
                for slope in &mut *d_theta {
                    *slope = *slope * weight;
                }
                store(flat(&d_theta[..emitted]), emitted, theta);
                of_all.add_slopes(d_theta, last - first, slopes);
            }
        }
        sum / count as f64
    }
}

/// Which of the two networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Times {
    /// That of `t = 0`.
    Initial,
    /// That of all later times.
    Later,
}

impl Times {
    /// One of these times.
    pub(super) fn time(self) -> usize {
        usize::from(self == Times::Later)
    }
}

/// What the network of these times is asked: the inputs of `R` rows.
pub(super) fn inputs_of(times: Times, width: usize, inputs: &[f64]) -> Inputs<'_> {
    Inputs {
        time: times.time(),
        width,
        previous: Some(inputs),
        measurement: &[],
        particles: inputs.len() / width.max(1),
    }
}
