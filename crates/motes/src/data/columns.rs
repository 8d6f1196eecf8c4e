//! What the columns of a file are for.

use motes_cli::nearest;
use serde::{Deserialize, Serialize};

use super::error::DataError;
use crate::estimate::{MOMENTS, OF_WEIGHTS, PLACE};
use crate::model::Model;
use crate::quantiles::Quantiles;

/// The place of each column that is used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Columns {
    /// Names of all columns, in order.
    pub(super) names: Vec<String>,
    /// The column of each measurement, in the model's order.
    pub(super) measurements: Vec<usize>,
    /// The column `series`.
    pub(super) series: Option<usize>,
    /// The column `t`.
    pub(super) time: Option<usize>,
    /// The column of times that the model names.
    pub(super) clock: Option<usize>,
    /// The columns that inputs come from, in the order of the model's; none for a measurement that is an input of later steps, in data whose measurements play no part.
    pub(super) inputs: Vec<Option<usize>>,
    /// The column that is carried to the output.
    pub(super) carried: Option<usize>,
    /// Names of the columns that are not used.
    pub ignored: Vec<String>,
}

/// Whether a number of a column `t` can be that of a row.
pub(super) fn counts_rows(time: f64) -> bool {
    time.fract() == 0.0 && time >= 0.0
}

impl Columns {
    /// Finds the columns of a model in a header, which errors call `place`.
    ///
    /// The column of times that the model names is carried to the output, or else the first column beside `series` and `t`, unless that is a measurement, an input or a state.
    ///
    /// # Errors
    /// [`DataError::MissingColumn`], [`DataError::ColumnTwice`], and [`DataError::ColumnOfResults`] where the carried column has the name of a result.
    pub fn of(header: &[String], place: &str, model: &Model) -> Result<Self, DataError> {
        Columns::find(header, place, model, model.measurements())
    }

    /// The same of data whose measurements play no part, and may not be there.
    ///
    /// # Errors
    /// As [`Columns::of`].
    pub fn of_inputs(header: &[String], place: &str, model: &Model) -> Result<Self, DataError> {
        let columns = Columns::find(header, place, model, &[])?;
        let is_measured = |name: &String| model.measurements().contains(name);
        let ignored = columns.ignored.into_iter().filter(|name| !is_measured(name)).collect();
        let carried = columns.carried.filter(|at| !is_measured(&columns.names[*at]));
        Ok(Columns { ignored, carried, ..columns })
    }

    fn find(
        header: &[String],
        place: &str,
        model: &Model,
        measurements: &[String],
    ) -> Result<Self, DataError> {
        let states = model.states();
        let names: Vec<String> = header.iter().map(|name| name.trim().to_string()).collect();
        for (at, name) in names.iter().enumerate() {
            if names[..at].contains(name) {
                return Err(DataError::ColumnTwice { header: place.into(), column: name.clone() });
            }
        }
        let at = |wanted: &str| names.iter().position(|name| name == wanted);
        let find = |wanted: &str, role: &'static str| {
            at(wanted).ok_or_else(|| {
                let is_one_column = names.len() == 1 && names[0].contains([';', '\t']);
                let near = nearest(wanted, names.iter().map(String::as_str));
                let hint = match (is_one_column, near) {
                    (true, _) => "; columns are separated by commas".to_string(),
                    (false, Some(near)) => format!("; is it {near}?"),
                    (false, None) => String::new(),
                };
                DataError::MissingColumn {
                    header: place.into(),
                    column: wanted.to_string(),
                    role,
                    found: names.join(", "),
                    hint,
                }
            })
        };
        let find_all = |wanted: &[String], role| -> Result<Vec<usize>, DataError> {
            wanted.iter().map(|wanted| find(wanted, role)).collect()
        };
        let measured: Vec<usize> = find_all(measurements, "the model measures")?;
        let may_be_absent = |name: &String| measurements.is_empty() && model.measurements().contains(name);
        let input = |wanted: &String| match at(wanted) {
            None if may_be_absent(wanted) => Ok(None),
            _ => find(wanted, "is an input of the model").map(Some),
        };
        let inputs = model.input_columns().iter().map(input).collect::<Result<Vec<_>, DataError>>()?;
        let clock = model.time_column().map(|name| find(name, "[time] of the model names")).transpose()?;
        let is_measured = |name: &str| measurements.iter().any(|measured| measured == name);
        let series = match model.series_column() {
            "series" => at("series").filter(|_| !is_measured("series")),
            named => Some(find(named, "[series] of the model names")?),
        };
        let time = at("t").filter(|_| !is_measured("t"));
        // Where the model names a column of times, no other counts them.
        let time = time.filter(|_| clock.is_none());
        let is_time = |at: usize| clock == Some(at) && names[at] == "t";
        let first = (0..names.len()).find(|&at| Some(at) != series && Some(at) != time);
        let is_known = |at: usize| {
            is_measured(&names[at])
                || states.contains(&names[at])
                || inputs.contains(&Some(at))
                || is_time(at)
        };
        let carried = clock.or(first).filter(|&at| !is_known(at));
        if let Some(column) = carried.map(|at| &names[at]).filter(|name| is_result(name, model)) {
            return Err(DataError::ColumnOfResults { header: place.into(), column: column.clone() });
        }
        let used = |at: usize| {
            measured.contains(&at)
                || inputs.contains(&Some(at))
                || [series, time, clock, carried].contains(&Some(at))
        };
        let ignored = (0..names.len()).filter(|&at| !used(at)).map(|at| names[at].clone()).collect();
        Ok(Columns { measurements: measured, series, time, clock, inputs, carried, ignored, names })
    }

    /// Whether rows say which series they belong to.
    pub fn has_series(&self) -> bool {
        self.series.is_some()
    }

    /// The name of the column that says which series a row belongs to.
    pub fn series(&self) -> Option<&str> {
        self.series.map(|at| self.names[at].as_str())
    }

    /// The place of each measurement of the model among the columns, in the model's order.
    pub fn measurements(&self) -> &[usize] {
        &self.measurements
    }

    /// The places of the columns `series` and `t`, and of the one that is carried to the output, where they are.
    pub fn others(&self) -> [Option<usize>; 3] {
        [self.series, self.time, self.carried]
    }

    /// Whether a column `t` counts rows.
    pub(crate) fn counts(&self) -> bool {
        self.time.is_some()
    }

    /// The place of the column of times that the model names.
    pub fn clock(&self) -> Option<usize> {
        self.clock
    }

    /// The place of each column that inputs come from, in the order of [`Model::input_columns`]; none for a measurement that is an input of later steps, in data whose measurements play no part.
    pub fn inputs(&self) -> &[Option<usize>] {
        &self.inputs
    }

    /// Their names, in that order.
    pub fn input_names(&self) -> Vec<&str> {
        self.inputs.iter().flatten().map(|at| self.names[*at].as_str()).collect()
    }

    /// The name of the column that is carried to the output.
    pub fn carried(&self) -> Option<&str> {
        self.carried.map(|at| self.names[at].as_str())
    }
}

/// Whether tables of results have a column of this name beside the carried one.
fn is_result(name: &str, model: &Model) -> bool {
    let is_of = |coordinate: &String, more: &[&str]| {
        let figure = name.strip_prefix(coordinate.as_str()).and_then(|rest| rest.strip_prefix('_'));
        let is_known = |figure| MOMENTS.contains(&figure) || more.contains(&figure);
        figure.is_some_and(|figure| is_known(figure) || Quantiles::is_name(figure))
    };
    OF_WEIGHTS.contains(&name)
        || model.states().iter().any(|state| is_of(state, &[]))
        || model.measurements().iter().any(|measured| is_of(measured, &[PLACE]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(header: &str) -> Columns {
        let text = r#"
            [initial]
            x = "normal(0, 1)"
            v = "normal(0, 1)"
            [transition]
            x = "normal(x, 1)"
            v = "normal(v, 1)"
            [measurement]
            y = "normal(x, 1)"
        "#;
        let header: Vec<String> = header.split(',').map(String::from).collect();
        Columns::of(&header, "data.csv", &Model::parse(text, "two.toml", &[]).unwrap()).unwrap()
    }

    #[test]
    fn the_first_column_of_another_name_is_carried() {
        let date = columns("date,y,note");
        assert_eq!((date.carried(), &date.ignored[..]), (Some("date"), &["note".to_string()][..]));
        assert_eq!(columns("series,date,y").carried(), Some("date"));
        assert_eq!(columns("t,date,y").carried(), Some("date"));
        assert_eq!(columns("y,note").carried(), None);
        // What `simulate` writes: states are no dates.
        let simulated = columns("series,t,x,v,y");
        assert_eq!((simulated.carried(), simulated.ignored.len(), simulated.has_series()), (None, 2, true));
    }
}
