//! What a name in a formula stands for, or why it stands for nothing.

use std::f64::consts::PI;

use super::formula::{Element, Node};
use super::scope::{Meaning, Scope};
use crate::error::{Problem, Section, nearest};
use crate::tables::{
    FAMILIES, FUNCTIONS, Family, Function, WRAPPERS, Wrapper, call, family, function, wrapper,
};

/// What can be called.
pub(super) enum Known {
    Function(&'static Function),
    Family(&'static Family),
    Wrapper(&'static Wrapper),
}

/// What `name(…)` calls.
pub(super) fn called(name: &str, scope: Scope<'_>) -> Result<Known, Problem> {
    if let Some(function) = function(name) {
        return Ok(Known::Function(function));
    }
    if let Some(family) = family(name) {
        if scope.section == Section::Definitions {
            return Err(Problem::RandomInDefinition(name.to_string()));
        }
        return Ok(Known::Family(family));
    }
    if let Some(wrapper) = wrapper(name) {
        return match scope.section {
            Section::Measurement => Ok(Known::Wrapper(wrapper)),
            Section::Definitions => Err(Problem::RandomInDefinition(name.to_string())),
            _ => Err(Problem::OnlyMeasured(name.to_string())),
        };
    }
    if scope.names.contains_key(name) || matches!(name, "t" | "i" | "pi") {
        return Err(Problem::NotAFunction(name.to_string()));
    }
    let functions = FUNCTIONS.iter().map(|function| function.name);
    let families = FAMILIES.iter().map(|family| family.name);
    let names: Vec<&str> = functions.chain(families).collect();
    let wrappers =
        WRAPPERS.iter().map(|wrapper| wrapper.name).filter(|_| scope.section == Section::Measurement);
    let all = names.iter().copied().chain(wrappers);
    let advice = match (name, nearest(name, all)) {
        ("pow" | "power", _) => "a power is written x^2".to_string(),
        ("log10" | "log2", _) => format!("it is log(x)/log({})", &name[3..]),
        (_, Some(near)) => format!("did you mean `{near}`?"),
        (_, None) => format!("there are {}", names.join(", ")),
    };
    Err(Problem::UnknownName { name: name.to_string(), advice })
}

/// The node of a name that is not called; its index is not read yet.
pub(super) fn known(name: &str, scope: Scope<'_>, in_index: bool, has_index: bool) -> Result<Node, Problem> {
    let owned = || name.to_string();
    let node = match name {
        "t" => Node::Time,
        "pi" => Node::Named(PI),
        "i" if !scope.is_vector => return Err(Problem::NoCoordinate),
        "i" => Node::Coordinate,
        _ => match scope.names.get(name) {
            Some(Meaning::Parameter(value)) => Node::Named(*value),
            Some(Meaning::List { .. }) if in_index => return Err(Problem::BadIndex(format!("`{name}`"))),
            Some(&Meaning::List { dimensions, .. }) if !has_index => {
                let example = format!("{name}[{}]", vec!["0"; dimensions].join(", "));
                return Err(Problem::Indices { name: owned(), example });
            }
            Some(&Meaning::List { number, .. }) => Node::Entry { list: number, indices: Vec::new() },
            Some(Meaning::Draw { .. }) if !has_draws(scope.section) => {
                return Err(Problem::DrawElsewhere(owned()));
            }
            Some(&(Meaning::State { first, length } | Meaning::Draw { first, length })) => {
                check_index(name, length, has_index)?;
                Node::State { first, length: length.unwrap_or(1), element: Element::Whole }
            }
            Some(&Meaning::Definition { number, length }) => {
                check_index(name, length, has_index)?;
                Node::Definition { number, length: length.unwrap_or(1), element: Element::Whole }
            }
            Some(Meaning::Measurement) => return Err(Problem::MeasurementInFormula(owned())),
            None => return Err(unknown(name, scope)),
        },
    };
    let is_index = matches!(node, Node::Coordinate)
        || matches!(node, Node::Named(value) if name != "pi" && value.fract() == 0.0);
    match node {
        Node::Named(value) if in_index && !is_index => {
            Err(Problem::BadIndex(format!("`{name}`, which is {value},")))
        }
        _ if in_index && !is_index => Err(Problem::BadIndex(format!("`{name}`"))),
        Node::Time | Node::Named(_) | Node::Coordinate if has_index => Err(Problem::NotAVector(owned())),
        node => Ok(node),
    }
}

/// Whether draws of a step are known in a section.
fn has_draws(section: Section) -> bool {
    matches!(section, Section::Draws | Section::Transition)
}

/// Whether a name has an index where it needs one, and none elsewhere.
fn check_index(name: &str, length: Option<usize>, has_index: bool) -> Result<(), Problem> {
    match length {
        Some(length) if !has_index => Err(Problem::NoIndex { name: name.to_string(), length }),
        None if has_index => Err(Problem::NotAVector(name.to_string())),
        _ => Ok(()),
    }
}

fn unknown(name: &str, scope: Scope<'_>) -> Problem {
    if let Some(function) = function(name) {
        let call = call(name, function.parameters);
        return Problem::NotCalled { name: name.to_string(), call };
    }
    if let Some(family) = family(name) {
        return Problem::NotCalled { name: name.to_string(), call: call(name, family.parameters) };
    }
    if let Some(wrapper) = wrapper(name) {
        return Problem::NotCalled { name: name.to_string(), call: call(name, wrapper.parameters) };
    }
    if name == "inf" {
        let advice = "it is an end of censored(d, low, high) and of truncated(d, low, high)".to_string();
        return Problem::UnknownName { name: name.to_string(), advice };
    }
    let usable = |meaning: &Meaning| match meaning {
        Meaning::Parameter(_) | Meaning::List { .. } | Meaning::State { .. } | Meaning::Definition { .. } => {
            true
        }
        Meaning::Draw { .. } => has_draws(scope.section),
        Meaning::Measurement => false,
    };
    let names = scope.names.iter().filter(|(_, meaning)| usable(meaning)).map(|(name, _)| name.as_str());
    let names: Vec<&str> = names.chain(["t", "pi"]).collect();
    let advice = match nearest(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names.len() <= 12 => format!("known are {}", names.join(", ")),
        None => format!("known are {} and more", names[..12].join(", ")),
    };
    Problem::UnknownName { name: name.to_string(), advice }
}
