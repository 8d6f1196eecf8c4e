//! The reference of functions and distributions, for people.

use super::call;
use super::compounds::COMPOUNDS;
use super::families::FAMILIES;
use super::functions::FUNCTIONS;
use super::wrappers::WRAPPERS;

/// Three tables in Markdown of all that formulas know by name: functions, distributions, and what measurements alone can have.
pub fn reference() -> String {
    let mut page = String::from("| function | value |\n|---|---|\n");
    for function in &FUNCTIONS {
        page += &format!("| `{}` | {} |\n", call(function.name, function.parameters), function.about);
    }
    page += "| `sum(j, x[j])` | The sum along a vector or list, with an index of any name: `sum(j, a[j]*x[j])`. |\n";
    page += "| `pi` | The circle constant, 3.14159… |\n";
    page += "\n| distribution | what it is | parameters |\n|---|---|---|\n";
    for family in &FAMILIES {
        let ranges = family.parameters.iter().zip(family.ranges);
        let ranges: Vec<_> = ranges.map(|(name, range)| format!("{name}: {}", range.words())).collect();
        let (call, about) = (call(family.name, family.parameters), family.about);
        page += &format!("| `{call}` | {about} | {} |\n", ranges.join("; "));
    }
    for compound in &COMPOUNDS {
        let names = compound.parameters.iter().enumerate().filter(|(_, name)| **name != "…");
        let ranges: Vec<_> =
            names.map(|(number, name)| format!("{name}: {}", compound.words(number))).collect();
        let (call, about) = (call(compound.name, compound.parameters), compound.about);
        page += &format!("| `{call}` | {about} | {} |\n", ranges.join("; "));
    }
    page += "\n| for measurements | what it is | parameters |\n|---|---|---|\n";
    for wrapper in &WRAPPERS {
        let arguments = wrapper.parameters.iter().zip(wrapper.arguments);
        let words: Vec<_> =
            arguments.map(|(name, argument)| format!("{name}: {}", argument.words())).collect();
        let call = call(wrapper.name, wrapper.parameters);
        page += &format!("| `{call}` | {} | {} |\n", wrapper.about, words.join("; "));
    }
    page
}
