//! The steps of a series, row by row.

use std::collections::VecDeque;

use motes_formulas::{Between, InputRule, InputSource, MOST_SUB_STEPS};
use motes_models::{Step, StepRecord};
use serde::{Deserialize, Serialize};

use super::error::{TimelineError, zone_words};
use super::load::Timeline;
use crate::calendar::{has_zone, label_of, time_of};

/// What a row says of its time and its inputs.
#[derive(Debug, Clone, Copy)]
pub struct RowTime<'a> {
    /// Its time as it is written, where the model names a column of times.
    pub label: Option<&'a str>,
    /// The columns of the data that inputs come from, in the order of [`Model::input_columns`](crate::Model::input_columns).
    pub columns: &'a [Option<f64>],
}

/// Where a series is: what its next steps depend on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    series: String,
    /// Steps and rows so far.
    steps: usize,
    rows: usize,
    /// What times are counted from, where they are days or weeks.
    origin: f64,
    previous: Option<PreviousRow>,
    /// Whether times of a day have a zone, once there was one.
    has_zones: Option<bool>,
    /// Whether the rows are behind: nothing is measured any more.
    is_ahead: bool,
    /// The inputs of the measurement that the row has no value of, and why: it must not have what is measured by them.
    #[serde(skip)]
    unknown: Vec<(usize, TimelineError)>,
    /// The columns of the rows before, the last one first, as many as an input looks back.
    past: VecDeque<Vec<Option<f64>>>,
}

/// What the next step needs of the row before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PreviousRow {
    time: f64,
    /// The gap before it, if there was one.
    gap: Option<f64>,
    /// Which entries of the measurement were there, at it or at another row of its time.
    measured: Vec<bool>,
}

/// A time, and the rows between which it lies.
struct Moment<'a> {
    time: f64,
    /// The share of the gap between the rows that is over.
    share: f64,
    before: Option<&'a [Option<f64>]>,
    after: &'a [Option<f64>],
    /// Whether it is a row itself.
    is_row: bool,
    place: &'static str,
}

impl Clock {
    /// Before the first row of a series.
    pub fn of_series(series: &str) -> Self {
        Clock { series: series.to_string(), ..Clock::default() }
    }

    /// How many rows there were.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Rows with measurements follow again.
    pub(crate) fn comes_back(&mut self) {
        self.is_ahead = false;
    }

    /// Counts a row that is a step, and gives the number of those before.
    pub(crate) fn count(&mut self) -> usize {
        let before = self.rows;
        self.rows += 1;
        self.steps += 1;
        before
    }

    /// The steps to the next row, of which all but the last have no measurement: one, or two where `x_0` comes before the first row.
    pub(crate) fn next(
        &mut self,
        timeline: &Timeline,
        row: RowTime<'_>,
    ) -> Result<Vec<StepRecord>, TimelineError> {
        let mut time = match &timeline.rule.column {
            None => self.rows as f64,
            Some(_) => time_of(row.label.unwrap_or_default(), timeline.rule.unit)?,
        };
        if timeline.rule.unit.is_some()
            && let Some(label) = row.label
            && let Some(has) = has_zone(label)
        {
            if self.has_zones.is_some_and(|before| before != has) {
                let [this, other] = zone_words(has);
                return Err(TimelineError::Zones { label: label.trim().to_string(), this, other });
            }
            self.has_zones = Some(has);
        }
        if self.rows == 0
            && let (Some(start), Some(label), Some(_)) =
                (timeline.start_date(), row.label, timeline.rule.unit)
        {
            let zones = [start, label].map(|label| has_zone(label) == Some(true));
            if zones[0] != zones[1] {
                let [this, other] = zone_words(zones[1]);
                let (label, start) = (label.trim().to_string(), start.to_string());
                return Err(TimelineError::StartZone { label, start, this, other });
            }
        }
        if timeline.rule.counts_from_first_row() && self.rows == 0 {
            self.origin = time;
        }
        time -= self.origin;
        self.next_at(timeline, time, row.columns)
    }

    /// The same, a gap after the row before; where there is none at 0, or a gap after the start.
    pub(crate) fn next_after(
        &mut self,
        timeline: &Timeline,
        gap: f64,
        columns: &[Option<f64>],
    ) -> Result<Vec<StepRecord>, TimelineError> {
        let time = self.time_after(timeline, gap);
        // Rows whose times nobody gave have those that follow from a start by the calendar.
        if let Some(date) = timeline.start_date().filter(|_| self.rows == 0) {
            self.has_zones = has_zone(date);
            if timeline.rule.counts_from_first_row() {
                self.origin = timeline.start.map_or(0.0, |start| start + gap);
            }
        }
        self.next_at(timeline, time, columns)
    }

    /// The time of a row a gap after the one before.
    pub(crate) fn time_after(&self, timeline: &Timeline, gap: f64) -> f64 {
        match (&self.previous, timeline.start) {
            _ if timeline.rule.column.is_none() => self.rows as f64,
            (Some(previous), _) => previous.time + gap,
            (None, Some(start)) if !timeline.rule.counts_from_first_row() => start + gap,
            (None, _) => 0.0,
        }
    }

    /// The steps to a row at which nothing is measured: the one that is given, or a gap as the last one ahead.
    pub(crate) fn ahead(
        &mut self,
        timeline: &Timeline,
        row: Option<RowTime<'_>>,
    ) -> Result<Vec<StepRecord>, TimelineError> {
        let gap = self.previous.as_ref().and_then(|previous| previous.gap).unwrap_or(1.0);
        self.is_ahead = true;
        let found = match row {
            Some(row) => self.next(timeline, row),
            None => self.next_after(timeline, gap, &vec![None; timeline.columns.len()]),
        };
        let time = || match row.and_then(|row| row.label) {
            Some(label) => label.to_string(),
            None if timeline.rule.column.is_none() => format!("t = {}", self.rows),
            None => self.label(timeline, self.time_after(timeline, gap)),
        };
        found.map_err(|error| match (error, row) {
            (TimelineError::Missing { input, .. }, None) => TimelineError::Ahead { input },
            (TimelineError::Missing { input, .. }, Some(_)) => {
                TimelineError::MissingAhead { input, time: time() }
            }
            (TimelineError::MissingBefore { input, rows, place, .. }, _) => {
                TimelineError::MissingBefore { input, rows, row: time(), place }
            }
            (other, _) => other,
        })
    }

    fn next_at(
        &mut self,
        timeline: &Timeline,
        time: f64,
        columns: &[Option<f64>],
    ) -> Result<Vec<StepRecord>, TimelineError> {
        let inputs = timeline.frame.inputs();
        let mut steps = Vec::with_capacity(1);
        let start = timeline.start_since(self.origin);
        let from = match (&self.previous, start) {
            (Some(previous), _) => Some(previous.time),
            (None, Some(start)) if start > time => {
                let [time, start] = [time, start].map(|time| self.label(timeline, time));
                return Err(TimelineError::BeforeStart { time, start });
            }
            (None, Some(start)) if start < time => Some(start),
            _ => None,
        };
        let measured = |entry: usize| Moment {
            time,
            share: 1.0,
            before: None,
            after: columns,
            is_row: true,
            place: timeline.place(if entry == 0 { "[measurement]" } else { "[initial]" }),
        };
        if self.previous.is_none() {
            let moment = match from {
                None => measured(1),
                Some(start) => Moment {
                    time: start,
                    share: 0.0,
                    before: None,
                    after: columns,
                    is_row: false,
                    place: timeline.place("[initial]"),
                },
            };
            let mut values = Vec::new();
            for (number, input) in inputs.iter().enumerate() {
                let value = || self.value(timeline, number, input, &moment);
                values.push(match timeline.frame.input_use(number).initial {
                    true => value()?,
                    // Functions may use it, but need not.
                    false if timeline.frame.is_of_functions() => value().unwrap_or(f64::NAN),
                    false => 0.0,
                });
            }
            values.resize(timeline.frame.input_dim(), 1.0);
            match from {
                None => self.add_measured(timeline, &measured(0), &mut values),
                Some(_) => values.extend(std::iter::repeat_n(0.0, timeline.frame.input_dim())),
            }
            let first = Step { time: from.unwrap_or(time), inputs: &values, ..Step::of_index(0) };
            steps.push(StepRecord::of(&first));
        }
        if let Some(from) = from {
            let gap = time - from;
            if gap < 0.0 {
                let [time, before] = [time, from].map(|time| self.label(timeline, time));
                return Err(TimelineError::Backwards { time, before });
            }
            let count = if gap == 0.0 { 0.0 } else { timeline.rule.sub_steps(gap) };
            if count > MOST_SUB_STEPS as f64 {
                let step = timeline.rule.step.unwrap_or(gap);
                return Err(TimelineError::SubSteps { gap, sub_steps: count, step });
            }
            let sub_steps = count as usize;
            let mut values = Vec::with_capacity((sub_steps + 1) * timeline.frame.input_dim());
            for part in 0..sub_steps {
                let share = part as f64 / count;
                let moment = Moment {
                    time: from + gap * share,
                    share,
                    before: self.past.front().map(Vec::as_slice),
                    after: columns,
                    is_row: false,
                    place: timeline.place("[transition]"),
                };
                for (number, input) in inputs.iter().enumerate() {
                    let is_used = timeline.frame.input_use(number).transition;
                    values.push(if is_used { self.value(timeline, number, input, &moment)? } else { 0.0 });
                }
                let of_row = self.previous.as_ref();
                let was_measured =
                    |entry: usize| of_row.is_none_or(|row| row.measured.get(entry).is_none_or(|was| *was));
                values.extend(timeline.frame.resets().iter().map(|entry| f64::from(was_measured(*entry))));
            }
            self.add_measured(timeline, &measured(0), &mut values);
            let index = self.steps + steps.len();
            let step = Step { time, length: gap, sub_steps, inputs: &values, ..Step::of_index(index) };
            steps.push(StepRecord::of(&step));
        }
        self.steps += steps.len();
        self.rows += 1;
        // Two rows at one time say nothing about how far rows are apart.
        let gap = from.map(|from| time - from).filter(|gap| *gap > 0.0);
        let gap = gap.or(self.previous.as_ref().and_then(|previous| previous.gap));
        // What was measured at a row of the same time begins anew after this one, too.
        let at_this_time = self.previous.take().filter(|_| from == Some(time));
        let measured = at_this_time.map_or(Vec::new(), |row| row.measured);
        self.previous = Some(PreviousRow { time, gap, measured });
        self.past.push_front(columns.to_vec());
        self.past.truncate(timeline.look_back());
        Ok(steps)
    }

    /// Adds the inputs of a measurement.
    fn add_measured(&mut self, timeline: &Timeline, moment: &Moment<'_>, values: &mut Vec<f64>) {
        self.unknown.clear();
        for (number, input) in timeline.frame.inputs().iter().enumerate() {
            let is_used = timeline.frame.is_measured_by(number);
            let value = is_used.then(|| self.value(timeline, number, input, moment));
            values.push(match value {
                // Nothing is measured yet: only a forecast of the measurement lacks it.
                Some(Err(_)) if self.is_ahead => f64::NAN,
                // Whether it is needed shows by what the row measures.
                Some(Err(error)) => {
                    self.unknown.push((number, error));
                    f64::NAN
                }
                Some(Ok(value)) => value,
                None => 0.0,
            });
        }
        values.extend(timeline.frame.resets().iter().map(|_| 1.0));
    }

    /// Refuses a row that lacks an input of a measurement, whichever it measures.
    pub(crate) fn check_measurable(&self) -> Result<(), TimelineError> {
        self.unknown.first().map_or(Ok(()), |(_, error)| Err(error.clone()))
    }

    /// What the time of the last row is called, if rows have times.
    pub(crate) fn label_of_last(&self, timeline: &Timeline) -> Option<String> {
        timeline.rule.column.as_ref()?;
        Some(self.label(timeline, self.previous.as_ref()?.time))
    }

    /// A time as the rows write theirs.
    fn label(&self, timeline: &Timeline, time: f64) -> String {
        label_of(time + self.origin, timeline.rule.unit, self.has_zones == Some(true))
    }

    /// The value of an input.
    fn value(
        &self,
        timeline: &Timeline,
        number: usize,
        input: &InputRule,
        moment: &Moment<'_>,
    ) -> Result<f64, TimelineError> {
        let missing = || TimelineError::Missing { input: input.name.clone(), place: moment.place };
        let before = |rows: usize| {
            let rows = if rows == 1 { "in the row".to_string() } else { format!("{rows} rows") };
            let (input, row) = (input.name.clone(), "this one".to_string());
            TimelineError::MissingBefore { input, rows, row, place: moment.place }
        };
        let no_first = || TimelineError::NoFirst { input: input.name.clone() };
        let at = |column: &str| timeline.columns.iter().position(|known| known == column);
        match &input.source {
            InputSource::File { .. } => {
                let Some(file) = timeline.files.get(number).and_then(Option::as_ref) else {
                    return Err(missing());
                };
                file.check_zones(self.has_zones)?;
                let time = (moment.time + self.origin, input.lag);
                file.value(&input.name, &self.series, time, input.between, input.holds_beyond, moment.is_row)
            }
            InputSource::Lag { column, rows, first } => {
                let behind = self.past.get(rows - 1);
                match (behind, at(column)) {
                    (None, _) => first.ok_or_else(no_first),
                    (Some(row), Some(at)) => row.get(at).copied().flatten().ok_or_else(|| before(*rows)),
                    (Some(_), None) => Err(missing()),
                }
            }
            InputSource::Column(column) => {
                let of = |row: &[Option<f64>]| at(column).and_then(|at| row.get(at).copied().flatten());
                let after = || of(moment.after).ok_or_else(missing);
                if moment.is_row || input.between == Between::Next {
                    return after();
                }
                let before = match moment.before {
                    Some(row) => of(row).ok_or_else(|| before(1))?,
                    None => input.first.ok_or_else(no_first)?,
                };
                match input.between {
                    Between::Linear if moment.share > 0.0 => Ok(before + moment.share * (after()? - before)),
                    _ => Ok(before),
                }
            }
        }
    }

    /// What was measured at the last row, whose measurements may be inputs of later steps.
    pub(crate) fn measured(
        &mut self,
        timeline: &Timeline,
        measurement: &[Option<f64>],
    ) -> Result<(), TimelineError> {
        let has_passed = self.previous.as_ref().is_some_and(|previous| previous.gap.is_some());
        let needs =
            |entry: &usize| !has_passed && measurement[*entry].is_some() && timeline.frame.needs_step(*entry);
        if let Some(entry) = (0..measurement.len()).find(needs) {
            return Err(TimelineError::NoStepBefore { entry: timeline.measurements[entry].clone() });
        }
        for (input, error) in &self.unknown {
            let needs =
                |entry: usize| measurement[entry].is_some() && timeline.frame.needs_input(entry, *input);
            if (0..measurement.len()).any(needs) {
                return Err(error.clone());
            }
        }
        if let Some(previous) = &mut self.previous {
            previous.measured.resize(measurement.len(), false);
            previous.measured.iter_mut().zip(measurement).for_each(|(was, value)| *was |= value.is_some());
        }
        let Some(last) = self.past.front_mut() else { return Ok(()) };
        for (column, value) in timeline.columns.iter().zip(last) {
            if let Some(entry) = timeline.measurements.iter().position(|name| name == column) {
                *value = measurement[entry];
            }
        }
        Ok(())
    }
}
