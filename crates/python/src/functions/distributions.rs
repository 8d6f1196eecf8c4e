//! Distributions as Python functions return them.

use motes::formulas::{Family, family};
use motes::models::equations::{BatchDistribution, Column};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyFloat, PyList, PyTuple};

/// What was asked of a function.
pub(super) struct FunctionCall<'a> {
    pub(super) function: &'a str,
    pub(super) time: Option<f64>,
    /// The names of the coordinates whose distributions it is to return.
    pub(super) names: &'a [String],
    /// `K`.
    pub(super) particles: usize,
    /// Whether some rows are no particles'.
    pub(super) is_padded: bool,
    /// The rows, where a number may be infinite or follow from one that is too large.
    pub(super) may_overflow: Option<&'a [f64]>,
    pub(super) of_states: bool,
    /// Whether all coordinates of states are drawn and none is a count.
    pub(super) has_density: bool,
}

/// The family of what is not drawn.
const KNOWN: &str = "known";

/// Numbers that are larger have run away: to add 1 to them changes nothing.
const LARGEST: f64 = (1_u64 << 53) as f64;

impl<'a> FunctionCall<'a> {
    /// That of the first state, whose coordinates have these names.
    pub(super) fn of_initial(names: &'a [String], has_density: bool) -> Self {
        FunctionCall {
            function: "initial",
            time: None,
            names,
            particles: 1,
            is_padded: false,
            may_overflow: None,
            of_states: true,
            has_density,
        }
    }
}

impl FunctionCall<'_> {
    /// Whether a number that is out of range comes of a state that ran away in a simulation.
    fn overflows(&self, row: usize, value: f64) -> bool {
        let Some(rows) = self.may_overflow else { return false };
        let width = rows.len() / self.particles.max(1);
        let state = rows.get(row * width..(row + 1) * width).unwrap_or_default();
        value.abs() > LARGEST || state.iter().any(|x| x.is_nan() || x.abs() > LARGEST)
    }

    /// An error that says which function and when.
    fn refused(&self, what: &str) -> PyErr {
        let at = self.time.map_or_else(String::new, |time| format!(", t = {time}"));
        PyValueError::new_err(format!("{}{at}: {what}", self.function))
    }
}

/// The distribution of each coordinate; `slopes` are the derivatives of all parameters in the place of these.
///
/// A list has one for each, with parameters of shape `()`, `(K,)` or `(K, 1)`. A single one has parameters that can be broadcast to `(K, N)`.
pub(super) fn columns(
    py: Python<'_>,
    asked: &FunctionCall<'_>,
    found: &Bound<'_, PyAny>,
    slopes: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<BatchDistribution>> {
    let count = asked.names.len();
    let listed = listed(found);
    let Some(items) = listed else {
        let stated = DistributionArguments::of(py, asked, found, &asked.names.join(", "))?;
        return (0..count).map(|at| stated.coordinate(asked, at, count, None)).collect();
    };
    if items.len() != count {
        return Err(asked.refused(&format!(
            "{} distributions; it must be one for each of {count} coordinates",
            items.len()
        )));
    }
    let slopes = slopes.and_then(|slopes| self::listed(slopes));
    let of_item = |(at, item): (usize, &Bound<'_, PyAny>)| {
        let name = &asked.names[at];
        let of_slopes = slopes.as_ref().and_then(|slopes| slopes.get(at));
        let of_slopes =
            of_slopes.map(|slopes| DistributionArguments::of(py, asked, slopes, name)).transpose()?;
        DistributionArguments::of(py, asked, item, name)?.coordinate(asked, 0, 1, of_slopes.as_ref())
    };
    items.iter().enumerate().map(of_item).collect()
}

/// The items of a list or a tuple.
fn listed<'py>(found: &Bound<'py, PyAny>) -> Option<Vec<Bound<'py, PyAny>>> {
    if let Ok(list) = found.cast::<PyList>() {
        return Some(list.iter().collect());
    }
    found.cast::<PyTuple>().ok().map(|tuple| tuple.iter().collect())
}

/// A distribution with its parameters as they came.
struct DistributionArguments {
    name: String,
    /// None where the only parameter is the coordinate itself.
    family: Option<&'static Family>,
    parameters: Vec<Numbers>,
    scale: Option<Numbers>,
    shift: Option<Numbers>,
}

/// A number, or an array of them row by row with its shape.
enum Numbers {
    Same(f64),
    Array { values: Vec<f64>, shape: Vec<usize> },
}

impl DistributionArguments {
    fn of(py: Python<'_>, asked: &FunctionCall<'_>, found: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        let of_name = found.getattr(intern!(py, "family")).and_then(|family| family.extract::<String>());
        let of_name = of_name.unwrap_or_default();
        let family = family(&of_name);
        if family.is_none() && of_name != KNOWN {
            let kind = found.get_type().name()?;
            return Err(asked
                .refused(&format!("{name}: {kind}; it must be a distribution, as motes.normal(mean, sd)")));
        }
        let has_density = family.is_some_and(|family| !family.is_of_counts());
        if asked.of_states && asked.has_density && !has_density {
            return Err(asked.refused(&format!(
                "{name}: {of_name}; states that are known, follow or are counts have no density: density=False allows them"
            )));
        }
        if !asked.of_states && family.is_none() {
            return Err(asked.refused(&format!("{name}: {KNOWN}; a measurement has a distribution")));
        }
        let parameters: Bound<'_, PyTuple> = found.getattr(intern!(py, "parameters"))?.extract()?;
        let numbers = |value: &Bound<'_, PyAny>, parameter: &str| {
            Numbers::of(py, value).map_err(|_| {
                let kind = value.get_type().name().map_or_else(|_| String::new(), |name| name.to_string());
                asked.refused(&format!(
                    "{parameter} of {name}: {kind}; it must be a number or an array of numbers"
                ))
            })
        };
        let names = family.map_or(&["value"][..], |family| family.parameters);
        let pairs = parameters.iter().zip(names);
        let parameters = pairs.map(|(value, name)| numbers(&value, name)).collect::<PyResult<_>>()?;
        let optional = |attribute: &Bound<'_, pyo3::types::PyString>, what: &str| {
            let value = found.getattr(attribute)?;
            if value.is_none() { Ok(None) } else { numbers(&value, what).map(Some) }
        };
        let scale = optional(intern!(py, "scale"), "the factor")?;
        let shift = optional(intern!(py, "shift"), "the shift")?;
        Ok(DistributionArguments { name: name.to_string(), family, parameters, scale, shift })
    }

    /// That of coordinate `at` of `width` ones, with the derivatives of its parameters.
    fn coordinate(
        &self,
        asked: &FunctionCall<'_>,
        at: usize,
        width: usize,
        slopes: Option<&DistributionArguments>,
    ) -> PyResult<BatchDistribution> {
        let column = |numbers: &Numbers, slopes: Option<&Numbers>, what: &str| {
            let values = numbers.column(asked.particles, at, width).map_err(|shape| {
                let wanted = match width {
                    1 => format!("({},)", asked.particles),
                    _ => format!("({}, {width})", asked.particles),
                };
                asked.refused(&format!(
                    "{what} of {}: an array of shape {shape}; it must be a number or {wanted}",
                    self.name
                ))
            })?;
            Ok::<Column, PyErr>(match slopes {
                Some(Numbers::Array { values: slopes, .. }) => Column::with_slopes(values, slopes.clone()),
                _ => Column::each(values),
            })
        };
        let Some(family) = self.family else {
            let of_slopes = slopes.and_then(|slopes| slopes.parameters.first());
            let value = column(&self.parameters[0], of_slopes, KNOWN)?;
            if !asked.is_padded {
                self.check(asked, &value, KNOWN, f64::is_finite, "finite")?;
            }
            return Ok(BatchDistribution::known(value));
        };
        let mut parameters = Vec::with_capacity(self.parameters.len());
        for (number, (numbers, what)) in self.parameters.iter().zip(family.parameters).enumerate() {
            let of_slopes = slopes.and_then(|slopes| slopes.parameters.get(number));
            let column = column(numbers, of_slopes, what)?;
            if !asked.is_padded {
                let range = family.ranges[number];
                self.check(asked, &column, what, |value| range.has(value), range.words())?;
            }
            parameters.push(column);
        }
        let mut moved = [None, None];
        let parts = [(&self.scale, "the factor"), (&self.shift, "the shift")];
        for (number, (moved, (part, what))) in moved.iter_mut().zip(parts).enumerate() {
            let Some(numbers) = part else { continue };
            let of_slopes = slopes.and_then(|slopes| [&slopes.scale, &slopes.shift][number].as_ref());
            let column = column(numbers, of_slopes, what)?;
            if !asked.is_padded {
                let is_right = |value: f64| value.is_finite() && (number == 1 || value != 0.0);
                self.check(
                    asked,
                    &column,
                    what,
                    is_right,
                    if number == 1 { "finite" } else { "finite and not 0" },
                )?;
            }
            *moved = Some(column);
        }
        let [scale, shift] = moved;
        if !asked.is_padded && family.name == "uniform" {
            self.check_ends(asked, &parameters)?;
        }
        Ok(BatchDistribution::new(family.distribution(parameters, Column::same)).affine(scale, shift))
    }

    /// Refuses a parameter that is out of its range.
    fn check(
        &self,
        asked: &FunctionCall<'_>,
        column: &Column,
        what: &str,
        is_right: impl Fn(f64) -> bool,
        words: &str,
    ) -> PyResult<()> {
        let is_wrong = |(row, value): (usize, &f64)| !is_right(*value) && !asked.overflows(row, *value);
        let Some(row) = column.values().iter().enumerate().position(is_wrong) else { return Ok(()) };
        let value = column.values()[row];
        let at = if column.values().len() > 1 { format!(" in row {row}") } else { String::new() };
        Err(asked.refused(&format!("{what} of {}: {value}{at}; it must be {words}", self.name)))
    }

    fn check_ends(&self, asked: &FunctionCall<'_>, parameters: &[Column]) -> PyResult<()> {
        let [low, high] = parameters else { return Ok(()) };
        let of = |column: &Column, row: usize| *column.values().get(row).unwrap_or(&column.values()[0]);
        let rows = low.values().len().max(high.values().len());
        let is_wrong = |row: &usize| {
            let (low, high) = (of(low, *row), of(high, *row));
            low >= high && !asked.overflows(*row, high)
        };
        let Some(row) = (0..rows).find(is_wrong) else { return Ok(()) };
        let (low, high) = (of(low, row), of(high, row));
        Err(asked.refused(&format!(
            "high of {}: {high} in row {row}; it must be above low, which is {low}",
            self.name
        )))
    }
}

impl Numbers {
    fn of(py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(number) = value.cast::<PyFloat>() {
            return Ok(Numbers::Same(number.value()));
        }
        if let Ok(array) = value.cast::<PyArrayDyn<f64>>()
            && array.data().is_aligned()
        {
            return Ok(Numbers::of_array(&array.readonly()));
        }
        let numpy = py.import(intern!(py, "numpy"))?;
        let array = numpy.call_method1(intern!(py, "asarray"), (value,))?;
        // Integers and shorter numbers are fine; complex numbers, texts and objects are none.
        let casting = [("casting", "same_kind")].into_py_dict(py)?;
        let array = array.call_method(intern!(py, "astype"), ("float64",), Some(&casting))?;
        Ok(Numbers::of_array(&array.cast::<PyArrayDyn<f64>>()?.readonly()))
    }

    fn of_array(array: &PyReadonlyArrayDyn<'_, f64>) -> Self {
        let shape = array.shape().to_vec();
        let values = match array.as_slice() {
            // A slice may be in the order of columns.
            Ok(values) if array.is_c_contiguous() => values.to_vec(),
            _ => array.as_array().iter().copied().collect(),
        };
        match values[..] {
            [value] if shape.is_empty() => Numbers::Same(value),
            _ => Numbers::Array { values, shape },
        }
    }

    /// Coordinate `at` of `width` ones of `K` particles: one number, or `K`.
    ///
    /// # Errors
    /// The shape, if it is none that can be broadcast.
    fn column(&self, particles: usize, at: usize, width: usize) -> Result<Vec<f64>, String> {
        let Numbers::Array { values, shape } = self else {
            let Numbers::Same(value) = self else { return Ok(Vec::new()) };
            return Ok(vec![*value]);
        };
        match shape[..] {
            [count] if width > 1 && count == width => Ok(vec![values[at]]),
            [count] if width == 1 && count == particles => Ok(values.clone()),
            [1] => Ok(vec![values[0]]),
            [1, count] if count == width => Ok(vec![values[at]]),
            [rows, 1] if rows == particles => Ok(values.clone()),
            [rows, count] if rows == particles && count == width => {
                Ok(values.iter().skip(at).step_by(width).copied().collect())
            }
            [count] => Err(format!("({count},)")),
            _ => Err(format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))),
        }
    }
}
