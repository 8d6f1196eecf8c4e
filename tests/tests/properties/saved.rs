//! Loading saved proposals: whatever lies there, one of two things happens, and neither is a panic.

use std::path::Path;

use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed};
use motes_proposals::{Adapter, Backend, Cell, Family, Fcnn, Gnn, Learnable, Psi, Rnn, load, save};
use motes_tests::{small_fcnn, small_gnn, small_psi, small_rnn};
use motes_train::TrainConfig;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::cases;

fn system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(131).stream()).unwrap()
}

/// The two files of a saved proposal.
fn files<F: Family + Learnable>(config: &F::Config) -> [Vec<u8>; 2] {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let proposal =
        F::create(config, &ModelShape::on_graph(&system), 3, Backend::Native.into(), &Seed::from_u64(132))
            .unwrap();
    save(folder.path(), &proposal, &system, &ModelShape::on_graph(&system), &TrainConfig::paper(10)).unwrap();
    ["proposal.toml", "weights.safetensors"].map(|name| std::fs::read(folder.path().join(name)).unwrap())
}

/// Writes both files, with the right hash in the first line if asked for: as damage, or as somebody who means it.
fn put(folder: &Path, description: &[u8], weights: &[u8], sealed: bool) {
    let mut description = description.to_vec();
    if sealed {
        let body = description.splitn(2, |byte| *byte == b'\n').nth(1).unwrap_or_default().to_vec();
        let hash = blake3::hash(&[body.as_slice(), weights].concat());
        description = [format!("blake3 = \"{hash}\"\n").as_bytes(), &body].concat();
    }
    std::fs::write(folder.join("proposal.toml"), description).unwrap();
    std::fs::write(folder.join("weights.safetensors"), weights).unwrap();
}

/// What can happen to a file.
#[derive(Debug, Clone)]
enum Change {
    Flip(Index, u8),
    Truncate(Index),
    Insert(Index, Vec<u8>),
    /// A number for another number.
    Number(Index, i64),
    Replace(Vec<u8>),
}

impl Change {
    fn apply(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        match self {
            Change::Flip(at, bits) => {
                let at = at.index(bytes.len());
                bytes[at] ^= bits;
            }
            Change::Truncate(at) => bytes.truncate(at.index(bytes.len())),
            Change::Insert(at, new) => {
                let at = at.index(bytes.len());
                bytes.splice(at..at, new.iter().copied());
            }
            Change::Number(at, new) => {
                let digits: Vec<usize> =
                    (0..bytes.len().min(2000)).filter(|&at| bytes[at].is_ascii_digit()).collect();
                if !digits.is_empty() {
                    let at = digits[at.index(digits.len())];
                    bytes.splice(at..=at, new.to_string().into_bytes());
                }
            }
            Change::Replace(new) => new.clone_into(bytes),
        }
    }
}

fn changes() -> impl Strategy<Value = Change> {
    prop_oneof![
        (any::<Index>(), 1_u8..).prop_map(|(at, bits)| Change::Flip(at, bits)),
        any::<Index>().prop_map(Change::Truncate),
        (any::<Index>(), vec(any::<u8>(), 1..8)).prop_map(|(at, new)| Change::Insert(at, new)),
        (any::<Index>(), prop_oneof![any::<i64>(), -3_i64..100])
            .prop_map(|(at, new)| Change::Number(at, new)),
        vec(any::<u8>(), 0..200).prop_map(Change::Replace),
    ]
}

fn check<F: Family + Learnable>(
    [description, weights]: &[Vec<u8>; 2],
    changes: &[(bool, Change)],
    sealed: bool,
) -> Result<(), TestCaseError> {
    let (folder, system) = (tempfile::tempdir().unwrap(), system());
    let (mut description, mut weights) = (description.clone(), weights.clone());
    for (of_description, change) in changes {
        change.apply(if *of_description { &mut description } else { &mut weights });
    }
    put(folder.path(), &description, &weights, sealed);
    match load::<F>(folder.path(), &system, &ModelShape::on_graph(&system), Backend::Native.into()) {
        Ok(proposal) => {
            let parameters = proposal.parameters();
            let finite = (0..parameters.len()).all(|at| parameters.host(at).iter().all(|v| v.is_finite()));
            prop_assert!(finite, "loaded weights that are not finite");
        }
        Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
    }
    Ok(())
}

/// The families, saved once.
fn saved() -> &'static [[Vec<u8>; 2]; 4] {
    static SAVED: std::sync::OnceLock<[[Vec<u8>; 2]; 4]> = std::sync::OnceLock::new();
    SAVED.get_or_init(|| {
        [
            files::<Fcnn>(&small_fcnn()),
            files::<Rnn>(&small_rnn(Cell::Lstm)),
            files::<Gnn>(&small_gnn(Adapter::Learned)),
            files::<Psi>(&small_psi()),
        ]
    })
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn no_bytes_make_loading_panic(changes in vec((any::<bool>(), changes()), 0..4), sealed: bool) {
        let [fcnn, rnn, gnn, psi] = saved();
        check::<Fcnn>(fcnn, &changes, sealed)?;
        check::<Rnn>(rnn, &changes, sealed)?;
        check::<Gnn>(gnn, &changes, sealed)?;
        check::<Psi>(psi, &changes, sealed)?;
    }
}
