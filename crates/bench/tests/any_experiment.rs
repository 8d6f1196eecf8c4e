//! Experiment files with anything in them: a plan whose units can be made, or one line and no panic.
//!
//! `PROPTEST_CASES` says how many files; `cargo xtask ci --thorough` asks for more than the default.

mod common;

use std::path::Path;

use common::TINY;
use motes_bench::UnitConfig;
use motes_bench::config::{ConfigError, Plan, ReproduceArgs, plans};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::{Config, RngSeed};

const EPIDEMIC: &str = include_str!("../../../experiments/table1.toml");

/// What the program makes of a file, for every profile that the files here have.
fn plan(experiments: &Path, profile: &str) -> Result<Vec<Plan>, ConfigError> {
    plans(&ReproduceArgs {
        profile: profile.into(),
        jobs: Some(1),
        experiments: experiments.into(),
        ..ReproduceArgs::of("any")
    })
}

fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("any.toml"), bytes).unwrap();
    match plan(folder.path(), "quick") {
        Err(error) => {
            let line = error.to_string();
            prop_assert_eq!(line.lines().count(), 1, "{}", line);
            prop_assert!(line.contains("any.toml") || line.starts_with("--profile quick: "), "{}", line);
            prop_assert_eq!(error.exit_status(), 2);
        }
        Ok(plans) => {
            for plan in plans {
                // One repetition stands for all.
                let plan = Plan { repetitions: 1, ..plan };
                for point in plan.points() {
                    let unit = UnitConfig::at(&plan, &point);
                    prop_assert!(unit.is_some(), "no unit at {:?}", point);
                    prop_assert_eq!(unit.unwrap().key().len(), 32);
                }
            }
        }
    }
    Ok(())
}

/// Values of every type that TOML has, and of every size.
fn values() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<i64>().prop_map(|value| value.to_string()),
        (-3_i64..70).prop_map(|value| value.to_string()),
        any::<f64>().prop_map(|value| format!("{value:?}").to_lowercase()),
        select(vec!["nan", "inf", "-inf", "true", "\"\"", "[]", "{}", "1979-05-27", "[[1]]", "0.0"])
            .prop_map(String::from),
        vec(any::<i64>(), 0..4).prop_map(|values| format!("{values:?}")),
        any::<String>().prop_map(|text| toml::Value::String(text).to_string()),
    ]
}

/// What can happen to a line of a file.
#[derive(Debug, Clone)]
enum Change {
    Value(Index, String),
    Remove(Index),
    Repeat(Index, Index),
    Misspell(Index, Index),
}

impl Change {
    fn apply(&self, lines: &mut Vec<String>) {
        match self {
            Change::Value(at, value) => {
                let keys: Vec<usize> = (0..lines.len()).filter(|&at| lines[at].contains(" = ")).collect();
                if !keys.is_empty() {
                    let line = &mut lines[keys[at.index(keys.len())]];
                    let key = line.split(" = ").next().unwrap_or_default();
                    *line = format!("{key} = {value}");
                }
            }
            Change::Remove(at) if !lines.is_empty() => {
                lines.remove(at.index(lines.len()));
            }
            Change::Repeat(from, to) if !lines.is_empty() => {
                let line = lines[from.index(lines.len())].clone();
                lines.insert(to.index(lines.len()), line);
            }
            Change::Misspell(line, at) if !lines.is_empty() => {
                let line = line.index(lines.len());
                let line = &mut lines[line];
                let characters: Vec<char> = line.chars().collect();
                if !characters.is_empty() {
                    let at = at.index(characters.len());
                    *line = [&characters[..at], &characters[at + 1..]].concat().into_iter().collect();
                }
            }
            _ => {}
        }
    }
}

fn changes() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => (any::<Index>(), values()).prop_map(|(at, value)| Change::Value(at, value)),
        1 => any::<Index>().prop_map(Change::Remove),
        1 => (any::<Index>(), any::<Index>()).prop_map(|(from, to)| Change::Repeat(from, to)),
        1 => (any::<Index>(), any::<Index>()).prop_map(|(line, at)| Change::Misspell(line, at)),
    ]
}

proptest! {
    #![proptest_config(Config { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() })]

    #[test]
    fn a_file_that_was_changed(
        original in select(vec![TINY, EPIDEMIC]),
        changes in vec(changes(), 1..4),
    ) {
        let mut lines: Vec<String> = original.lines().map(String::from).collect();
        changes.iter().for_each(|change| change.apply(&mut lines));
        check(lines.join("\n").as_bytes())?;
    }

    #[test]
    fn any_bytes(bytes in vec(any::<u8>(), 0..300)) {
        check(&bytes)?;
    }

    #[test]
    fn any_text(text: String) {
        check(text.as_bytes())?;
    }
}
