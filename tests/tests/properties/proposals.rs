//! Proposals of every family with any weights and any particles: numbers, or a typed error.

use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, fill_standard_normal};
use motes_proposals::{Adapter, Backend, Cell, Family, Fcnn, Gnn, Learnable, Psi, Rnn};
use motes_smc::{FilterBank, FilterSettings, Proposal};
use motes_tests::{small_fcnn, small_gnn, small_psi, small_rnn};
use proptest::prelude::*;

use crate::cases;

fn system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(130).stream()).unwrap()
}

/// Filters three measurements with weights of the given size: evidence is a number, or the error names what failed.
fn filter<F: Family + Learnable + Proposal<GraphDiffusion>>(
    config: &F::Config,
    size: f64,
    measured: f64,
    defensive_weight: Option<f64>,
    seed: u64,
) -> Result<(), TestCaseError> {
    let (system, seed) = (system(), Seed::from_u64(seed));
    let mut proposal =
        F::create(config, &ModelShape::on_graph(&system), 3, Backend::Native.into(), &seed.child("weights"))
            .unwrap();
    let mut stream = seed.child("values").stream();
    for index in 0..proposal.parameters().len() {
        let mut values = proposal.parameters().host(index);
        fill_standard_normal(&mut stream, &mut values);
        values.iter_mut().for_each(|value| *value *= size);
        proposal.parameters_mut().set_host(index, &values).unwrap();
    }
    let settings = FilterSettings { defensive_weight, ..FilterSettings::new(7) };
    let mut bank = FilterBank::new(&system, proposal, settings, 2, &seed.child("filter")).unwrap();
    for _ in 0..3 {
        match bank.step(&[measured; 3]) {
            Ok(()) => prop_assert!((0..2).all(|filter| bank.log_evidence(filter).is_finite())),
            Err(error) => {
                prop_assert!(!error.to_string().contains('\n'));
                return Ok(());
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_weights_give_numbers_or_a_typed_error(
        (size, measured) in (-6.0_f64..6.0, -9.0_f64..12.0),
        defensive_weight in prop::option::of(0.01..0.99),
        seed: u64,
    ) {
        let (size, measured) = (10_f64.powf(size), 10_f64.powf(measured));
        filter::<Fcnn>(&small_fcnn(), size, measured, defensive_weight, seed)?;
        filter::<Rnn>(&small_rnn(Cell::Lstm), size, measured, defensive_weight, seed)?;
        filter::<Gnn>(&small_gnn(Adapter::Fixed), size, measured, defensive_weight, seed)?;
        filter::<Psi>(&small_psi(), size, measured, defensive_weight, seed)?;
    }
}
