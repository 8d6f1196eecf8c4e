//! Which quantiles are given of each number that is estimated.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The probabilities of quantiles where nobody asks for others.
pub(crate) const PROBABILITIES: [f64; 3] = [0.05, 0.5, 0.95];

/// The probabilities of the quantiles that are given of each number: above 0 and below 1, each above the one before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantiles(Vec<f64>);

impl Default for Quantiles {
    fn default() -> Self {
        Quantiles(PROBABILITIES.to_vec())
    }
}

impl Quantiles {
    /// What probabilities have to be.
    pub const EXPECTED: &'static str =
        "probabilities above 0 and below 1, each above the one before, as in 0.05,0.5,0.95";

    /// Those of these probabilities; none if they are not as [`Quantiles::EXPECTED`] says.
    pub fn new(probabilities: Vec<f64>) -> Option<Self> {
        let are_inside = probabilities.iter().all(|probability| *probability > 0.0 && *probability < 1.0);
        let are_sorted = probabilities.is_sorted_by(|one, next| one < next);
        (!probabilities.is_empty() && are_inside && are_sorted).then_some(Quantiles(probabilities))
    }

    /// Their probabilities.
    pub fn probabilities(&self) -> &[f64] {
        &self.0
    }

    /// What tables call each of them behind the name of a coordinate and `_`: the decimals of its probability, two at least, as in `q05` and `q975`.
    pub fn names(&self) -> Vec<String> {
        let name = |probability: &f64| {
            let written = probability.to_string();
            format!("q{:0<2}", written.trim_start_matches("0."))
        };
        self.0.iter().map(name).collect()
    }

    /// From which to which they go, in words; none where there is one alone.
    #[cfg(feature = "report")]
    pub(crate) fn range(&self) -> Option<String> {
        let percent = |probability: &f64| format!("{} %", (1e10 * probability).round() / 1e8);
        let [low, .., high] = self.0.as_slice() else { return None };
        Some(format!("from the {} to the {} quantile", percent(low), percent(high)))
    }

    /// Whether it is a name that tables have for some quantile.
    pub(crate) fn is_name(figure: &str) -> bool {
        let decimals = figure.strip_prefix('q');
        decimals.is_some_and(|decimals| decimals.len() > 1 && decimals.bytes().all(|c| c.is_ascii_digit()))
    }
}

impl FromStr for Quantiles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split(',').map(|number| number.trim().parse().ok());
        let quantiles = numbers.collect::<Option<Vec<f64>>>().and_then(Quantiles::new);
        quantiles.ok_or_else(|| format!("it must be {}", Quantiles::EXPECTED))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_decimals() {
        let of = |text: &str| text.parse::<Quantiles>().unwrap();
        assert_eq!(Quantiles::default().names(), ["q05", "q50", "q95"]);
        assert_eq!(
            of("0.00001, 0.025,0.1,0.25,0.5,0.975").names(),
            ["q00001", "q025", "q10", "q25", "q50", "q975"]
        );
        assert!(of("0.001,0.3").names().iter().all(|name| Quantiles::is_name(name)));
        assert!(["q", "q5", "q0x", "mean", "05"].iter().all(|name| !Quantiles::is_name(name)));
        assert_eq!(of("0.025,0.07").range().unwrap(), "from the 2.5 % to the 7 % quantile");
        assert_eq!(of("0.5").range(), None);
    }

    #[test]
    fn what_is_no_probability_or_out_of_order_is_refused() {
        for wrong in
            ["", "0,0.5", "0.5,1", "-0.1", "1.5", "0.5,0.05", "0.5,0.5", "NaN", "a", "0.1,,0.2", "0.1;0.2"]
        {
            let refused = wrong.parse::<Quantiles>().unwrap_err();
            assert!(
                refused.starts_with("it must be probabilities above 0 and below 1"),
                "{wrong}: {refused}"
            );
        }
        assert_eq!(Quantiles::new(vec![]), None);
    }
}
