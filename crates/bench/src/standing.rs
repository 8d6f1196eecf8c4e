//! Which units a plan wants, which of them are there, and which are missing.

use std::collections::BTreeSet;
use std::fmt;

use crate::config::{Plan, Point};
use crate::store::{Contents, Outcome, Record, Store, StoreError};
use crate::tables::sort;
use crate::unit::UnitConfig;

/// A unit and its place in the figure.
pub(crate) type PlacedUnit = (Point, UnitConfig);

/// All units of a plan.
pub(crate) fn wanted(plan: &Plan) -> Vec<PlacedUnit> {
    let points = plan.points().into_iter();
    points.filter_map(|point| UnitConfig::at(plan, &point).map(|unit| (point, unit))).collect()
}

/// Whether a unit has no record, or lacks the model that is to be kept.
pub(crate) fn is_missing(plan: &Plan, records: &[Record], (point, unit): &PlacedUnit) -> bool {
    let has_model = || {
        let models = plan.models().filter(|_| unit.method.method().is_learned());
        models.is_none_or(|models| models.join(unit.key()).exists())
    };
    let record = recorded(records, (point, unit));
    !record.is_some_and(|record| matches!(record.outcome, Outcome::Failed(_)) || has_model())
}

/// How many units of a plan are there, and how many of these failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) wanted: usize,
    pub(crate) there: usize,
    pub(crate) failed: usize,
}

impl Count {
    pub(crate) fn of(wanted: &[PlacedUnit], records: &[Record]) -> Count {
        let found = wanted.iter().filter_map(|(point, unit)| recorded(records, (point, unit)));
        let (mut there, mut failed) = (0, 0);
        for record in found {
            there += 1;
            failed += usize::from(matches!(record.outcome, Outcome::Failed(_)));
        }
        Count { wanted: wanted.len(), there, failed }
    }

    pub(crate) fn left(&self) -> usize {
        self.wanted - self.there
    }
}

impl fmt::Display for Count {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Count { wanted, there, failed } = self;
        write!(formatter, "{} of {wanted} units done, {failed} failed, {} left", there - failed, self.left())
    }
}

fn recorded<'a>(records: &'a [Record], (point, unit): (&Point, &UnitConfig)) -> Option<&'a Record> {
    records.iter().find(|record| record.is_of(point, unit))
}

/// Those units of a folder that belong to this plan's configuration, sorted, and a remark for a person on each sort of others, which are left
/// alone.
pub(crate) fn belonging(plan: &Plan, contents: Contents, folder: &str) -> (Vec<Record>, Option<String>) {
    let Contents { mut records, foreign, .. } = contents;
    let all = records.len() + foreign;
    let mut differences = BTreeSet::new();
    if foreign > 0 {
        differences.insert("they were written by another version of this program".to_string());
    }
    records.retain(|record| {
        let expected = UnitConfig::at(plan, &record.point);
        let belongs = expected.as_ref() == Some(&record.config);
        if !belongs {
            differences.insert(differs(&record.config, expected.as_ref()));
        }
        belongs
    });
    let remark = (!differences.is_empty()).then(|| {
        let differences: Vec<String> = differences.into_iter().collect();
        let others = all - records.len();
        format!("{others} units in {folder} are of another run and not used: {}", differences.join("; "))
    });
    sort(plan, &mut records);
    (records, remark)
}

/// The folder's units that belong to a plan, merged into one file, and remarks on what was set aside and what is not used.
pub(crate) fn read(plan: &Plan, store: &mut Store) -> Result<(Vec<Record>, Vec<String>), StoreError> {
    let contents = store.read()?;
    let mut remarks = Vec::new();
    for (count, what) in
        [(contents.damaged, "damaged units"), (contents.torn, "lines that a killed run had begun")]
    {
        if count > 0 {
            let path = store.damaged();
            remarks.push(format!(
                "{what} set aside in {}: {count}; what is missing is computed again",
                path.display()
            ));
        }
    }
    let (records, remark) = belonging(plan, contents, &store.folder().display().to_string());
    remarks.extend(remark);
    Ok((records, remarks))
}

/// The first setting in which a stored unit differs from what this run would do.
fn differs(found: &UnitConfig, expected: Option<&UnitConfig>) -> String {
    let Some(expected) = expected else { return "this experiment has no such panel or method".into() };
    let json = |unit: &UnitConfig| serde_json::to_value(unit).unwrap_or_default();
    first_difference("", &json(found), &json(expected)).unwrap_or_else(|| "they differ".into())
}

fn first_difference(path: &str, found: &serde_json::Value, expected: &serde_json::Value) -> Option<String> {
    match (found.as_object(), expected.as_object()) {
        (Some(found), Some(expected)) => {
            let absent = serde_json::Value::Null;
            found.keys().chain(expected.keys()).find_map(|key| {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let side = |side: &serde_json::Map<_, _>| side.get(key).cloned().unwrap_or(absent.clone());
                first_difference(&path, &side(found), &side(expected))
            })
        }
        _ => (found != expected).then(|| format!("{path} is {found} there and {expected} here")),
    }
}
