//! Taking up a training from bytes: whatever they are, one of two things happens, and neither is a panic.

use std::sync::OnceLock;

use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
use motes_proposals::{Backend, Family, Fcnn};
use motes_tests::small_fcnn;
use motes_train::{TrainConfig, TrainError, Training};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::cases;

/// The checkpoint of a training after two of four steps; or what comes of resuming from these bytes, and of a step from there.
fn training(bytes: Option<&[u8]>) -> Result<Vec<u8>, TrainError> {
    let seed = Seed::from_u64(133);
    let config = GraphDiffusionConfig::new(5);
    let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
    let measurements = simulate(&system, 3, &mut seed.child("data").stream()).unwrap().measurements;
    let mut proposal =
        Fcnn::create(&small_fcnn(), &ModelShape::of(&system), 3, Backend::Native.into(), &seed).unwrap();
    let (config, mut stream) = (TrainConfig { steps: 4, ..TrainConfig::paper(5) }, seed.stream());
    let mut training = Training::new(&proposal, &system, &measurements, &config, &mut stream).unwrap();
    match bytes {
        None => (0..2).for_each(|_| assert!(training.step(&mut proposal).is_ok())),
        Some(bytes) => {
            training.resume(&mut proposal, bytes)?;
            if !training.is_finished() {
                training.step(&mut proposal)?;
            }
        }
    }
    training.checkpoint(&proposal)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn no_bytes_make_resuming_panic(
        flips in vec((any::<Index>(), any::<u8>()), 0..6),
        cut in prop::option::weighted(0.3, any::<Index>()),
        other in prop::option::weighted(0.2, vec(any::<u8>(), 0..300)),
    ) {
        static SUSPENDED: OnceLock<Vec<u8>> = OnceLock::new();
        let mut bytes = SUSPENDED.get_or_init(|| training(None).unwrap()).clone();
        // Half of the flips hit the header, which says what lies where.
        for (at, (place, bits)) in flips.iter().enumerate() {
            let end = if at % 2 == 0 { bytes.len().min(600) } else { bytes.len() };
            bytes[place.index(end)] ^= bits;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Err(error) = training(Some(&other.unwrap_or(bytes))) {
            prop_assert_eq!(error.to_string().lines().count(), 1);
        }
    }
}
