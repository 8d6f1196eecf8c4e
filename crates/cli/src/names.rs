//! Which of the known names was meant.

/// The name that is nearest to what was written, if one is near.
pub fn nearest<'a>(written: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let distance = |name: &str| strsim::damerau_levenshtein(&written.to_lowercase(), &name.to_lowercase());
    let (distance, name) =
        names.into_iter().map(|name| (distance(name), name)).min_by_key(|(distance, _)| *distance)?;
    (distance <= written.len().max(3) / 3 + 1 && distance < name.chars().count()).then_some(name)
}

/// "did you mean a? there are a, b, c": the names to choose from, the nearest one first.
pub fn one_of<'a>(written: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let hint = nearest(written, names.iter().copied())
        .map_or(String::new(), |name| format!("did you mean {name}? "));
    format!("{hint}there are {}", names.join(", "))
}
