//! Numbers as text that reads back as the same number.

/// The shortest text of a number that reads back as it is.
pub(super) fn text(value: f64) -> String {
    let size = value.abs();
    match size == 0.0 || (1e-5..1e16).contains(&size) {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_reads_back_as_it_is() {
        for value in [0.0, -0.0, 0.1, 1.0 / 3.0, 1e-320, f64::MAX, -1.5e300, 123_456_789.125, 1e16, 9.99e-6] {
            assert_eq!(text(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
            assert!(text(value).len() < 26, "{}", text(value));
        }
    }
}
