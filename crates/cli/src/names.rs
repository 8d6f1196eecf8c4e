//! Which of the known names was meant.

/// "did you mean a? there are a, b, c": the names to choose from, the nearest one first.
pub fn one_of<'a>(found: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let nearest = names.iter().min_by_key(|name| strsim::damerau_levenshtein(found, name));
    let hint = nearest
        .filter(|name| strsim::damerau_levenshtein(found, name) <= found.len().max(3) / 3 + 1)
        .map(|name| format!("did you mean {name}? "))
        .unwrap_or_default();
    format!("{hint}there are {}", names.join(", "))
}
