//! Steps of a model's own, and the windows of them that proposals are learned from.

use std::collections::BTreeSet;

use motes_formulas::{FileModel, FormulaModel, Schedule, parse};
use motes_models::{OwnStep, OwnSteps, Seed, StateSpaceModel, Step, StepRecord};

/// A walk that an input pushes.
fn pushed() -> FormulaModel {
    let text = "[inputs]\nu = \"next\"\n[initial]\nx = \"normal(0, 1e-9)\"\n[transition]\nx = \"normal(x + u, 1e-9)\"\n\
                [measurement]\ny = \"normal(x, 1)\"\n";
    match parse(text, "m.toml", &[]).unwrap().model {
        FileModel::Formulas(model) => model,
        FileModel::LinearGaussian(_) => panic!("it has formulas"),
    }
}

/// A sequence of so many rows from a time on, the input of each of which is its time.
fn sequence(count: usize, start: f64) -> Vec<StepRecord> {
    let of_row = |index: usize| {
        let time = start + index as f64;
        StepRecord::of(&Step { time, inputs: &[time], ..Step::of_index(index) })
    };
    (0..count).map(of_row).collect()
}

#[test]
fn sequences_lie_one_behind_the_other_and_longer_ones_first() {
    let schedule = Schedule::of_sequences(vec![sequence(2, 100.0), vec![], sequence(3, 200.0)]).unwrap();
    let model = pushed().along(schedule);
    assert_eq!(model.own_sequences(), [0..3, 3..5]);
    let found: Vec<(usize, f64)> =
        (0..5).map(|index| model.step_of_index(index)).map(|step| (step.index, step.time)).collect();
    assert_eq!(found, [(0, 200.0), (1, 201.0), (2, 202.0), (0, 100.0), (1, 101.0)]);
    assert!(Schedule::of_sequences(vec![vec![]]).is_none() && Schedule::endless(vec![]).is_none());
}

#[test]
fn one_sequence_goes_on_with_its_later_steps() {
    let model = pushed().along(Schedule::endless(sequence(3, 0.0)).unwrap());
    let times: Vec<f64> = (0..6).map(|index| model.step_of_index(index).time).collect();
    assert_eq!(times, [0.0, 1.0, 2.0, 1.0, 2.0, 1.0]);
    assert!(model.own_sequences().is_empty() && model.step_of_index(5).index == 5);
}

/// Catches a window that begins without the states before it, and rows that are never learned from.
#[test]
fn windows_are_of_all_sequences_and_have_their_past() {
    let schedule = Schedule::of_sequences(vec![sequence(4, 100.0), sequence(6, 200.0)]).unwrap();
    let model = pushed().along(schedule);
    let mut seen = BTreeSet::new();
    for seed in 0..200 {
        let mut window = OwnSteps::new(&model, 3, &Seed::from_u64(seed)).unwrap().in_window(2);
        let mut times = vec![];
        while let Some(OwnStep { step, states, .. }) = window.advance() {
            let first = if step.time < 200.0 { 100.0 } else { 200.0 };
            let sum: f64 = (1..=step.index).map(|index| first + index as f64).sum();
            assert!(states.iter().all(|x| (x - sum).abs() < 1e-6), "{states:?} for {sum}");
            times.push(step.time as i64);
        }
        assert!(times.len() == 2 && times[1] == times[0] + 1, "{times:?}");
        seen.extend(times);
    }
    let all: Vec<i64> = (100..104).chain(200..206).collect();
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), all);
    let mut beginning = OwnSteps::new(&model, 3, &Seed::from_u64(1)).unwrap().at_beginning();
    assert!(beginning.advance().is_some_and(|step| step.previous.is_none()));
    // Where there are no sequences of its own, nothing changes.
    let model = pushed().along(Schedule::endless(sequence(3, 0.0)).unwrap());
    let new = || OwnSteps::new(&model, 3, &Seed::from_u64(1)).unwrap();
    let (mut plain, mut same) = (new(), new().in_window(2));
    for _ in 0..4 {
        assert_eq!(plain.advance().unwrap().states, same.advance().unwrap().states);
    }
}
