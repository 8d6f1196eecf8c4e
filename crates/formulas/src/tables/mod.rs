//! What formulas know by name: the parser, its messages and the reference page are all made of these tables.

mod compounds;
mod families;
mod functions;
mod reference;
mod wrappers;

pub(crate) use compounds::{COMPOUNDS, Composition, Compound, MOST_OFF, PriorKind, compound};
pub(crate) use families::{EXACT, FAMILIES, Kind, Most, Values, of_kind};
pub use families::{Family, Range, family};
pub(crate) use functions::{FUNCTIONS, Function, Operation, function};
pub use reference::reference;
pub(crate) use wrappers::{Argument, MEASURED_CATEGORICAL, WRAPPERS, Wrapper, Wrapping, wrapper};

/// What a name means wherever it stands, in words. Those of distributions are free: they are always called, and gamma is a common rate.
pub(crate) fn reserved(name: &str) -> Option<&'static str> {
    match name {
        "t" => Some("the time"),
        "dt" => Some("the length of a sub-step"),
        "total" | "total_since_measured" | "sum" => Some("a function"),
        "i" => Some("the number of a vector's coordinate"),
        "pi" => Some("the circle constant"),
        "and" | "or" | "not" => Some("an operator"),
        _ if function(name).is_some() => Some("a function"),
        _ => None,
    }
}

/// How something is called: `normal(mean, sd)`.
pub(crate) fn call(name: &str, parameters: &[&str]) -> String {
    format!("{name}({})", parameters.join(", "))
}
