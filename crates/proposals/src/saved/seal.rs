//! The first line of a description: a hash of all the rest, weights included.

/// The description with a first line that holds the hash of it and of the weights.
pub(super) fn seal(description: &str, weights: &[u8]) -> String {
    format!("{SEAL}\"{}\"\n{description}", hash(description, weights))
}

const SEAL: &str = "blake3 = ";

fn hash(description: &str, weights: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(description.as_bytes()).update(weights);
    hasher.finalize().to_hex().to_string()
}

/// The description behind a first line that is the hash of it and of the weights.
pub(super) fn unsealed<'a>(text: &'a str, weights: &[u8]) -> Option<&'a str> {
    let (line, description) = text.split_once('\n')?;
    let is_right = line.strip_prefix(SEAL) == Some(&format!("\"{}\"", hash(description, weights)));
    is_right.then_some(description)
}
