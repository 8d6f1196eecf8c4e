//! A proposal that was learned for one model is refused by others, wherever it is used.

use std::ops::ControlFlow;

use motes::{
    CompareOptions, Data, FilterOptions, LearnOptions, LearnedProposal, Model, MotesError, ProposalName,
    compare, filter, learn,
};

const TEXT: &str = "[parameters]\na = 0.9\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(a*x, 0.5)\"\n[measurement]\ny = \"normal(x, 0.5)\"\n";

const WIDER: &str = "[initial]\nx = \"normal(0, 1)\"\nz = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\nz = \"normal(z, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";

fn model(text: &str, a: f64) -> Model {
    let set = if text == TEXT { vec![("a".to_string(), a)] } else { vec![] };
    Model::parse(text, "model.toml", &set).unwrap()
}

fn learned(model: &Model) -> LearnedProposal {
    let options = LearnOptions { updates: 5, ..LearnOptions::default() };
    learn(model, None, &options, |_, _| ControlFlow::Continue(())).unwrap().proposal
}

fn refused<T>(result: Result<T, MotesError>) -> String {
    let said = result.err().expect("it is refused").to_string();
    assert!(said.contains("this proposal was trained for another system: "), "{said}");
    assert!(!said.contains('\n'), "{said}");
    said
}

#[test]
fn others_refuse_it_and_its_own_model_takes_it() {
    let own = model(TEXT, 0.9);
    let proposal = learned(&own);
    let options = FilterOptions {
        proposal: ProposalName::Learned(proposal.clone()),
        particles: 50,
        ..FilterOptions::default()
    };
    let filtered = |model: &Model| {
        let data = Data::read("y\n0.3\n0.7\n".as_bytes(), "y.csv", model).unwrap();
        filter(model, &data, &options, |_| ControlFlow::Continue(()))
    };
    assert!(filtered(&own).is_ok());
    // The same model, read once more.
    assert!(filtered(&model(TEXT, 0.9)).is_ok());
    for (other, what) in [
        (model(TEXT, -0.5), "a fixed projection of a fixed draw of x_1"),
        (model(WIDER, 0.0), "the state dimension N is 1 there and 2 in the model given"),
    ] {
        assert!(refused(filtered(&other)).contains(what));
        assert!(refused(proposal.check_model(&other)).starts_with("--proposal learned: "));
        let further = LearnOptions { start: Some(proposal.clone()), updates: 5, ..LearnOptions::default() };
        let learned = learn(&other, None, &further, |_, _| ControlFlow::Continue(()));
        assert!(refused(learned).starts_with("start: "));
        let card = CompareOptions::of_learned(&other, proposal.clone(), 50, 1);
        refused(compare(&other, None, &card, |_| ControlFlow::Continue(())));
        let folder = tempfile::tempdir().unwrap();
        refused(proposal.save(&folder.path().join("p"), &other));
        refused(proposal.to_bytes(&other));
        refused(LearnedProposal::from_bytes(&proposal.to_bytes(&own).unwrap(), &other));
    }
}

#[test]
fn one_that_is_read_to_be_tuned_is_for_the_model_that_it_is_read_for() {
    let (own, other) = (model(TEXT, 0.9), model(TEXT, 0.8));
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("p");
    learned(&own).save(&folder, &own).unwrap();
    refused(LearnedProposal::load(&folder, &other));
    let start = LearnedProposal::load_to_tune(&folder, &other).unwrap();
    let further = LearnOptions { start: Some(start.clone()), updates: 5, ..LearnOptions::default() };
    assert!(learn(&other, None, &further, |_, _| ControlFlow::Continue(())).is_ok());
    refused(learn(&own, None, &further, |_, _| ControlFlow::Continue(())));
}

#[test]
fn bytes_are_the_proposal_to_the_last_bit() {
    let own = model(TEXT, 0.9);
    let proposal = learned(&own);
    let bytes = proposal.to_bytes(&own).unwrap();
    let again = LearnedProposal::from_bytes(&bytes, &own).unwrap();
    assert_eq!((again.name(), again.notes()), (proposal.name(), proposal.notes()));
    assert_eq!(again.to_bytes(&own).unwrap(), bytes);
    let evidence = |proposal: LearnedProposal| {
        let options = FilterOptions { proposal: ProposalName::Learned(proposal), ..FilterOptions::default() };
        let data = Data::read("y\n0.3\n0.7\n".as_bytes(), "y.csv", &own).unwrap();
        filter(&own, &data, &options, |_| ControlFlow::Continue(())).unwrap().log_evidence().to_bits()
    };
    assert_eq!(evidence(again), evidence(proposal));
    let said = LearnedProposal::from_bytes(&bytes[1..], &own).err().unwrap().to_string();
    assert!(said.starts_with("a learned proposal: its bytes are not as they were written"), "{said}");
}
