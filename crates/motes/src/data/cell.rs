//! One cell: a number, or nothing.

const NO_MEASUREMENT: &str = "is no measurement; leave the cell empty where one is missing";
const NOT_FINITE: &str = "is not finite; leave the cell empty where a measurement is missing";

/// What stands in a cell: a number, or none where it is empty or `NA`.
///
/// # Errors
/// What is the matter with it.
pub(super) fn number(text: &str) -> Result<Option<f64>, &'static str> {
    let text = text.trim();
    if text.is_empty() || text == "NA" {
        return Ok(None);
    }
    // Names of what is not finite are numbers to the standard library.
    let has_digit = text.bytes().any(|byte| byte.is_ascii_digit());
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        Ok(_) if has_digit => Err("is beyond the largest number of 64 bits, 1.8e308"),
        Ok(value) if value.is_nan() => Err(NO_MEASUREMENT),
        Ok(_) => Err(NOT_FINITE),
        Err(_) if has_decimal_comma(text) => Err("has a decimal comma; write a point"),
        Err(_) => Err("is no number; leave the cell empty, or write NA, where a measurement is missing"),
    }
}

/// The same of a cell that is an input.
pub(super) fn of_input(problem: &'static str) -> &'static str {
    match problem {
        NO_MEASUREMENT => "is no number; leave the cell empty where the input is not needed",
        NOT_FINITE => "is not finite; leave the cell empty where the input is not needed",
        other => other,
    }
}

/// Whether a text would be a number with a point for its comma.
fn has_decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && text.replace(',', ".").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_a_number_or_empty() {
        assert_eq!(number(" 1.5e3 "), Ok(Some(1500.0)));
        assert_eq!(number("-0"), Ok(Some(0.0)));
        assert_eq!([number(""), number(" NA "), number("  ")], [Ok(None); 3]);
        for wrong in ["nan", "NaN", "inf", "-Infinity", "1e999", "3,5", "x", "1.2.3", "na", "1 2", "0x10"] {
            assert!(number(wrong).is_err(), "{wrong}");
        }
        assert!(number("3,5").unwrap_err().contains("decimal comma"));
        assert!(number("1e999").unwrap_err().contains("largest"));
    }
}
