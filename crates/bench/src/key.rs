//! Keys: what determines a result, as a short text.

use serde::Serialize;

/// 32 hexadecimal digits of the BLAKE3 hash of a configuration as JSON.
pub(crate) fn key_of(configuration: &impl Serialize) -> String {
    let json = serde_json::to_string(configuration).expect("a configuration has only string keys");
    blake3::hash(json.as_bytes()).to_hex()[..32].to_string()
}
