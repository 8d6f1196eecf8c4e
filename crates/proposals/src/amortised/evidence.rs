//! The derivative of a filter's log-evidence along the draws of an amortised proposal.

use motes_models::batch::{LANES, load, store};
use motes_networks::{NetworkTape, Workspace};
use motes_smc::ProposalError;

use super::draws::DrawnStage;
use super::inclusive::{Times, inputs_of};
use super::proposal::Amortised;
use super::units::{flat, flat_mut, lanes};
use crate::settings::of_networks;

impl Amortised {
    /// `Σ_r s_r ∂ log w_r/∂u_r · ∂u_r/∂θ` over the rows of a stage with their shares `s_r`, pulled back through the networks: the workspace holds minus that
    /// derivative with respect to the weights.
    ///
    /// `∂ log w/∂u = ∂/∂u [log p(y | x) + log N(v; 0, I) − log h(u | θ)]`, since `log p(x | x') = log N(v; 0, I) − Σ log T′` and
    /// `log q = log h + log |det L| − Σ log T′`. What `log h` depends on `θ` by itself, its score, is left out.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] for a head whose draws have no derivatives, [`ProposalError`] if the networks cannot be asked.
    pub fn differentiate_evidence(
        &self,
        times: Times,
        rows: &DrawnStage,
        workspace: Workspace,
    ) -> Result<Workspace, ProposalError> {
        let Some(head) = self.head(times.time()).reparametrised() else {
            return Err(ProposalError::Setting {
                name: "the head of a proposal whose draws are differentiated",
                value: "a mixture".into(),
                expected: "gaussian, kernel or flow",
            });
        };
        let (n, outputs, count) = (self.sizes(times.time()).units, head.outputs(), rows.len());
        let tape = NetworkTape::new(&self.networks, &self.parameters, count, workspace);
        let mut tape = tape.map_err(of_networks)?;
        let of_all = self.theta(times.time());
        let (emitted, mut slopes) = (of_all.emitted, of_all.no_slopes());
        let mut theta = vec![0.0; count * emitted];
        let inputs = inputs_of(times, rows.width, &rows.inputs);
        tape.forward(&inputs, &mut [&mut theta]).map_err(of_networks)?;
        let mut memory = vec![0.0; (3 * n + 2 * outputs + head.scratch()) * LANES];
        let (units, rest) = lanes(&mut memory).split_at_mut(n);
        let (pull, rest) = rest.split_at_mut(n);
        let (of_head, rest) = rest.split_at_mut(n);
        let (of_theta, rest) = rest.split_at_mut(outputs);
        let (d_theta, scratch) = rest.split_at_mut(outputs);
        of_all.place_shared(of_theta);
        for (first, theta) in (0..count).step_by(LANES).zip(theta.chunks_mut(LANES * emitted)) {
            let last = (first + LANES).min(count);
            load(&rows.units[first * n..last * n], n, flat_mut(units));
            load(&rows.slopes[first * n..last * n], n, flat_mut(pull));
            of_all.load(theta, of_theta);
            head.slope(of_theta, units, of_head, scratch);
            for (pull, of_head) in pull.iter_mut().zip(&*of_head) {
                // Minus: the derivative of the loss.
                *pull = *of_head - *pull;
                for (value, share) in pull.0.iter_mut().zip(&rows.shares[first..last]) {
                    *value *= share;
                }
            }
            head.pull_back(of_theta, units, pull, d_theta, scratch);
            store(flat(&d_theta[..emitted]), emitted, theta);
            of_all.add_slopes(d_theta, last - first, &mut slopes);
        }
        of_all.hand_over(&slopes, tape.gradients());
        tape.backward_to_weights(&[&theta]).map_err(of_networks)?;
        Ok(tape.finish())
    }
}
