//! What a name in a formula stands for, or why it stands for nothing.

use std::f64::consts::PI;

use super::formula::{Element, Node};
use super::meaning::Meaning;
use super::parts::may_have_parts;
use super::scope::Scope;
use super::total::Since;
use crate::error::{ComposedProblem, Problem, Section, nearest};
use crate::tables::{
    COMPOUNDS, Composition, Compound, FAMILIES, FUNCTIONS, Family, Function, WRAPPERS, Wrapper, call,
    compound, family, function, wrapper,
};

/// What can be called.
pub(super) enum Known<'a> {
    Function(&'static Function),
    /// A function of the file: its number among the definitions, and the names of its arguments.
    Own(usize, &'a [String]),
    Family(&'static Family),
    Compound(&'static Compound),
    Wrapper(&'static Wrapper),
}

/// What is said of priors without a density.
const IMPROPER: &str = "a prior integrates to 1: where next to nothing is known take a wide one, as in normal(0, 100) or log_normal(0, 5)";

/// What `name(…)` calls.
pub(super) fn called<'a>(name: &str, scope: Scope<'a>) -> Result<Known<'a>, Problem> {
    // One's own stand before those that there are, so that a file says what it computes.
    if let Some(Meaning::Function { number, arguments }) = scope.names.get(name) {
        return Ok(Known::Own(*number, arguments));
    }
    if let Some(function) = function(name) {
        return Ok(Known::Function(function));
    }
    if let Some(family) = family(name) {
        if scope.section == Section::Definitions {
            return Err(Problem::RandomInDefinition(name.to_string()));
        }
        return Ok(Known::Family(family));
    }
    if let Some(wrapper) = wrapper(name).filter(|_| scope.section != Section::Parameters) {
        return match scope.section {
            Section::Measurement => Ok(Known::Wrapper(wrapper)),
            Section::Definitions => Err(Problem::RandomInDefinition(name.to_string())),
            _ => Err(Problem::OnlyMeasured(name.to_string())),
        };
    }
    if let Some(compound) = compound(name) {
        let is_only_prior = matches!(compound.composition, Composition::Prior(_));
        return match scope.section {
            Section::Parameters if compound.composition.is_prior() => Ok(Known::Compound(compound)),
            Section::Parameters => Err(Problem::Composed(ComposedProblem::NoPrior(name.to_string()))),
            _ if is_only_prior => Err(Problem::Composed(ComposedProblem::OnlyPrior(name.to_string()))),
            Section::Definitions => Err(Problem::RandomInDefinition(name.to_string())),
            section if compound.parts.is_some() && !may_have_parts(compound, section) => {
                let problem = match section {
                    Section::Measurement => ComposedProblem::PartsMeasured(name.to_string()),
                    Section::Initial => ComposedProblem::PartsAtStart(name.to_string()),
                    _ => ComposedProblem::PartsElsewhere(name.to_string()),
                };
                Err(Problem::Composed(problem))
            }
            _ => Ok(Known::Compound(compound)),
        };
    }
    if scope.names.contains_key(name) || is_argument(name, scope) || matches!(name, "t" | "dt" | "i" | "pi") {
        return Err(Problem::NotAFunction(name.to_string()));
    }
    Err(Problem::UnknownName { name: name.to_string(), advice: advice_on_call(name, scope) })
}

/// What may be meant by the name of a call that is not known.
fn advice_on_call(name: &str, scope: Scope<'_>) -> String {
    let is_in_priors = scope.section == Section::Parameters;
    let own = scope.names.iter().filter(|(_, meaning)| matches!(meaning, Meaning::Function { .. }));
    let own = own.map(|(name, _)| name.as_str());
    let totals = ["total", "total_since_measured"].into_iter().filter(|_| scope.totals.is_some());
    let functions = FUNCTIONS.iter().map(|function| function.name);
    let functions: Vec<&str> = own.chain(functions).chain(["sum"]).chain(totals).collect();
    let distributions = distributions(scope.section);
    match (name, nearest(name, functions.iter().chain(&distributions).copied())) {
        ("pow" | "power", _) => "a power is written x^2".to_string(),
        ("log10" | "log2", _) => format!("it is log(x)/log({})", &name[3..]),
        ("cauchy", _) => "it is student_t(1, location, scale)".to_string(),
        ("flat" | "improper" | "jeffreys" | "reference", _) if is_in_priors => IMPROPER.to_string(),
        (_, None) if is_in_priors => format!("priors are {}", distributions.join(", ")),
        (_, Some(near)) => format!("did you mean `{near}`?"),
        (_, None) if distributions.is_empty() => format!("functions are {}", functions.join(", ")),
        (_, None) => {
            format!("functions are {}; distributions are {}", functions.join(", "), distributions.join(", "))
        }
    }
}

/// The distributions that a section may have, those that are made of others included.
fn distributions(section: Section) -> Vec<&'static str> {
    if section == Section::Definitions {
        return vec![];
    }
    let is_here = |compound: &&Compound| match section {
        Section::Parameters => compound.composition.is_prior(),
        _ => {
            let is_prior = matches!(compound.composition, Composition::Prior(_));
            !is_prior && (compound.parts.is_none() || may_have_parts(compound, section))
        }
    };
    let compounds = COMPOUNDS.iter().filter(is_here).map(|compound| compound.name);
    let wrappers = WRAPPERS.iter().filter(|_| section == Section::Measurement).map(|wrapper| wrapper.name);
    FAMILIES.iter().map(|family| family.name).chain(compounds).chain(wrappers).collect()
}

fn is_argument(name: &str, scope: Scope<'_>) -> bool {
    scope.arguments.iter().any(|argument| argument == name)
}

/// The node of a name that is not called; its index is not read yet.
pub(super) fn known(name: &str, scope: Scope<'_>, in_index: bool, has_index: bool) -> Result<Node, Problem> {
    let owned = || name.to_string();
    if let Some(number) = scope.arguments.iter().position(|argument| argument == name) {
        return if has_index { Err(Problem::NotAVector(owned())) } else { Ok(Node::Argument(number)) };
    }
    let node = match name {
        "t" | "dt" if scope.section == Section::Parameters => return Err(unknown(name, scope)),
        "t" => Node::Time,
        "dt" => Node::Length,
        "pi" => Node::Named(PI),
        "i" if !scope.is_vector => return Err(Problem::NoCoordinate),
        "i" => Node::Coordinate,
        _ => match scope.names.get(name) {
            Some(Meaning::Parameter(value)) => Node::Named(*value),
            Some(Meaning::List { .. }) if in_index => return Err(Problem::BadIndex(format!("`{name}`"))),
            Some(Meaning::List { lengths, .. }) if !has_index => {
                let example = format!("{name}[{}]", vec!["0"; lengths.len()].join(", "));
                return Err(Problem::Indices { name: owned(), example });
            }
            Some(&Meaning::List { number, .. }) => Node::Entry { list: number, indices: Vec::new() },
            Some(&Meaning::Input(number)) => Node::Input(number),
            Some(meaning @ &Meaning::Draw { length, .. }) if !has_draws(scope.section) => {
                let Some((_, totals)) = scope.totals else { return Err(Problem::DrawElsewhere(owned())) };
                check_index(name, length, has_index)?;
                // Measured is what was drawn in the last sub-step.
                let mut totals = totals.borrow_mut();
                let total = totals.of("", name, Some(meaning), Since::SubStep)?;
                Node::State {
                    first: totals.place_of(total),
                    length: length.unwrap_or(1),
                    element: Element::Whole,
                }
            }
            Some(&(Meaning::State { first, length } | Meaning::Draw { first, length })) => {
                check_index(name, length, has_index)?;
                Node::State { first, length: length.unwrap_or(1), element: Element::Whole }
            }
            Some(&Meaning::Definition { number, length }) => {
                check_index(name, length, has_index)?;
                Node::Definition { number, length: length.unwrap_or(1), element: Element::Whole }
            }
            Some(Meaning::Function { arguments, .. }) => {
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
                return Err(Problem::NotCalled { name: owned(), call: call(name, &arguments) });
            }
            Some(Meaning::Prior) => return Err(Problem::Composed(ComposedProblem::PriorOfPrior(owned()))),
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
        Node::Time | Node::Length | Node::Input(_) | Node::Named(_) | Node::Coordinate if has_index => {
            Err(Problem::NotAVector(owned()))
        }
        node => Ok(node),
    }
}

/// Whether draws of a step are known in a section.
fn has_draws(section: Section) -> bool {
    matches!(section, Section::Draws | Section::Transition)
}

/// Whether a name has an index where it needs one, and none elsewhere.
pub(super) fn check_index(name: &str, length: Option<usize>, has_index: bool) -> Result<(), Problem> {
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
    if let Some(compound) = compound(name) {
        return Problem::NotCalled { name: name.to_string(), call: call(name, compound.parameters) };
    }
    if let Some(family) = family(name) {
        return Problem::NotCalled { name: name.to_string(), call: call(name, family.parameters) };
    }
    if let Some(wrapper) = wrapper(name) {
        return Problem::NotCalled { name: name.to_string(), call: call(name, wrapper.parameters) };
    }
    if name == "inf" && scope.section == Section::Parameters {
        let advice = format!("only truncated(prior, low, high) has such an end; {IMPROPER}");
        return Problem::UnknownName { name: name.to_string(), advice };
    }
    if name == "inf" {
        let advice = "it is an end of censored(d, low, high) and of truncated(d, low, high)".to_string();
        return Problem::UnknownName { name: name.to_string(), advice };
    }
    let usable = |meaning: &Meaning| match meaning {
        Meaning::Parameter(_)
        | Meaning::List { .. }
        | Meaning::Input(_)
        | Meaning::State { .. }
        | Meaning::Definition { .. } => true,
        Meaning::Draw { .. } => has_draws(scope.section),
        Meaning::Function { .. } | Meaning::Measurement | Meaning::Prior => false,
    };
    let names = scope.names.iter().filter(|(_, meaning)| usable(meaning)).map(|(name, _)| name.as_str());
    // A prior holds at all times.
    let times = ["t"].into_iter().filter(|_| scope.section != Section::Parameters);
    let arguments = scope.arguments.iter().map(String::as_str);
    let names: Vec<&str> = arguments.chain(names).chain(times).chain(["pi"]).collect();
    let advice = match nearest(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if scope.section == Section::Parameters => {
            "a prior is made of numbers and of parameters above it".to_string()
        }
        None if names.len() <= 12 => format!("known are {}", names.join(", ")),
        None => format!("known are {} and more", names[..12].join(", ")),
    };
    Problem::UnknownName { name: name.to_string(), advice }
}
