//! The name that was meant, perhaps.

/// What other languages call what is known here by another name.
const ELSEWHERE: [(&str, &str); 24] = [
    ("ln", "log"),
    ("fabs", "abs"),
    ("arctan", "atan"),
    ("arctan2", "atan2"),
    ("cosine", "cos"),
    ("sine", "sin"),
    ("minimum", "min"),
    ("maximum", "max"),
    ("PI", "pi"),
    ("Pi", "pi"),
    ("π", "pi"),
    ("time", "t"),
    ("T", "t"),
    ("gaussian", "normal"),
    ("gauss", "normal"),
    ("norm", "normal"),
    ("N", "normal"),
    ("student", "student_t"),
    ("lognormal", "log_normal"),
    ("double_exponential", "laplace"),
    ("expon", "exponential"),
    ("unif", "uniform"),
    ("pois", "poisson"),
    ("nbinom", "negative_binomial"),
];

/// The known name that is nearest to `name`, if one is near.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let known: Vec<&str> = known.into_iter().collect();
    let elsewhere = ELSEWHERE.iter().find(|(theirs, ours)| *theirs == name && known.contains(ours));
    if let Some((_, ours)) = elsewhere {
        return Some((*ours).to_string());
    }
    // A third of the letters may be wrong, and one of two.
    let allowed = (name.chars().count() / 3).max(1);
    let distance = |other: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let near = known.into_iter().map(|other| (distance(other), other));
    let near = near.filter(|&(distance, other)| distance <= allowed && distance < other.chars().count());
    near.min().map(|(_, other)| other.to_string())
}
