//! What was assumed of data that may be meant otherwise.

use super::blocks::blocks;
use super::columns::Columns;
use super::series::Data;
use super::shown::shown;
use super::times::{Irregular, Kind, Times, irregular, is_named_as_time};
use crate::calendar::Time;
use crate::warning::Warning;

/// Labels of the rows: what they are called in warnings, and what they say.
struct Labels<'a> {
    /// `column date`, or `the index`.
    what: String,
    /// The column's name; an index without one is an index.
    name: &'a str,
    texts: Vec<&'a str>,
}

/// So many series have a line each; of more, all have one together.
const FEW: usize = 3;

impl Data {
    /// What is to be said of how the rows were taken, at most one line for each series and kind of problem.
    ///
    /// Looked at is what labels the rows: the carried column, and an index. Where they are dates, months, quarters, or numbers that are evidently times, it warns of rows in
    /// a wrong order, of times that are there twice, and of steps that are not equal; months of unequal length and weekends that are passed over are no such steps. Where
    /// they may tell sequences apart that are not told apart by a column `series`, it warns of that.
    ///
    /// Where the model names the column of times, steps are as long as they are, and there is nothing to say.
    pub fn warnings(&self) -> Vec<Warning> {
        if self.columns.clock().is_some() {
            return Vec::new();
        }
        self.labels().iter().flat_map(|labels| self.of_labels(labels)).collect()
    }

    fn labels(&self) -> Vec<Labels<'_>> {
        let carried = self.columns.carried().map(|name| Labels {
            what: format!("column {name}"),
            name,
            texts: self.rows.iter().map(|row| row.label.as_deref().unwrap_or_default()).collect(),
        });
        let index = self.index.as_ref().map(|texts| Labels {
            what: "the index".into(),
            name: "index",
            texts: texts.iter().map(String::as_str).collect(),
        });
        carried.into_iter().chain(index).filter(|labels| labels.texts.len() == self.rows.len()).collect()
    }

    fn of_labels(&self, labels: &Labels<'_>) -> Vec<Warning> {
        let Some(times) = Times::of(&labels.texts) else {
            return self.of_blocks(labels).into_iter().collect();
        };
        let is_named = is_named_as_time(labels.name);
        if times.kind == Kind::Numbers
            && !is_named
            && let Some(warning) = self.of_blocks(labels)
        {
            return vec![warning];
        }
        if times.kind == Kind::Numbers && is_named && is_in_parts(&self.columns) {
            return Vec::new();
        }
        let mut warnings: Vec<Warning> = self.of_unread(labels, &times).into_iter().collect();
        let (of_series, is_whole) = (self.by_series(), !self.columns.has_series());
        let mut found: Vec<(usize, Irregular)> = Vec::new();
        for (series, places) in of_series.iter().enumerate() {
            let (rows, read): (Vec<usize>, Vec<Time>) =
                places.iter().filter_map(|&at| times.of_rows[at].map(|time| (at, time))).unzip();
            let called = |at: usize| self.called(labels, rows[at]);
            let what = irregular(labels.name, is_named, is_whole, &read, &called);
            found.extend(what.map(|what| (series, what)));
        }
        warnings.extend(self.collected(labels, found));
        warnings
    }

    /// A line for each series, or one for many.
    fn collected(&self, labels: &Labels<'_>, found: Vec<(usize, Irregular)>) -> Vec<Warning> {
        let name = |series: usize| self.columns.has_series().then(|| self.series[series].clone());
        if found.len() <= FEW {
            let warning = |(series, what): (usize, Irregular)| Warning {
                series: name(series),
                text: format!("{}: {}: {}", labels.what, what.found, what.assumed),
            };
            return found.into_iter().map(warning).collect();
        }
        let (count, all) = (found.len(), self.series.len());
        let first = found.into_iter().next();
        let warning = first.map(|(series, Irregular { found, assumed })| Warning {
            series: None,
            text: format!(
                "{}: the times of {count} of {all} series are not one step apart; in the first of them, {}: {found}: {assumed}",
                labels.what,
                name(series).unwrap_or_default()
            ),
        });
        warning.into_iter().collect()
    }

    /// Labels that may be those of series.
    fn of_blocks(&self, labels: &Labels<'_>) -> Option<Warning> {
        const NAMED: usize = 4;
        if self.columns.has_series() {
            return None;
        }
        let blocks = blocks(&labels.texts)?;
        let line = |row: usize| self.rows[row].line;
        let named = blocks.iter().take(NAMED).map(|block| {
            let (first, last) = (line(block.first), line(block.last));
            match first == last {
                true => format!("{} in {} {first}", shown(block.label), self.source.counted),
                false => format!("{} in {}s {first} to {last}", shown(block.label), self.source.counted),
            }
        });
        let named = named.collect::<Vec<_>>().join(", ");
        let more =
            if blocks.len() > NAMED { format!(" and {} more", blocks.len() - NAMED) } else { String::new() };
        let by = match self.columns.carried() == Some(labels.name) {
            true => format!(", or give the model [series] by = \"{}\"", labels.name),
            false => String::new(),
        };
        let text = format!(
            "{}: {named}{more}: is it series? rows are taken as one sequence; call it series{by}, and each is filtered on its own",
            labels.what
        );
        Some(Warning { series: None, text })
    }

    /// Rows whose labels are no times, where most are.
    fn of_unread(&self, labels: &Labels<'_>, times: &Times) -> Option<Warning> {
        let is_unread = |at: &usize| times.of_rows[*at].is_none();
        let unread: Vec<usize> = (0..self.rows.len()).filter(is_unread).collect();
        let first = (*unread.first()?, times.kind);
        if first.1 == Kind::Numbers {
            return None;
        }
        let kind = match times.kind {
            Kind::Months => "month",
            Kind::Quarters => "quarter",
            Kind::Dates | Kind::Numbers => "date",
        };
        let more = match unread.len() - 1 {
            0 => String::new(),
            more => format!(", and {more} more"),
        };
        let text = format!(
            "{}: {} is no {kind} as the others are{more}; whether it comes at its time is not known",
            labels.what,
            self.called(labels, first.0)
        );
        Some(Warning { series: None, text })
    }

    /// What a row is called: `line 3 (2024-03-01)`.
    fn called(&self, labels: &Labels<'_>, row: usize) -> String {
        format!("{} {} ({})", self.source.counted, self.rows[row].line, shown(labels.texts[row]))
    }
}

/// Whether times may be written in several columns, as year and month, of which one is not all.
fn is_in_parts(columns: &Columns) -> bool {
    columns.ignored.iter().any(|name| is_named_as_time(name))
}
