//! Values as bytes, which are refused where they were damaged or are of another version.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::MotesError;

/// Bytes of a hash.
const HASH: usize = 32;

/// Bytes of a version.
const VERSION: usize = 4;

/// `value` as bytes: a hash of all that follows, the version of its form, and the value in CBOR, which has every number of 64 bits as it is. `what` says
/// what it is, in errors and in the hash: bytes of one kind are none of another.
///
/// # Errors
/// [`MotesError::Packed`] if the value has something that CBOR has not.
pub fn pack(what: &str, version: u32, value: &impl Serialize) -> Result<Vec<u8>, MotesError> {
    let mut bytes = vec![0; HASH];
    bytes.extend(version.to_le_bytes());
    ciborium::into_writer(value, &mut bytes)
        .map_err(|error| refused(what, format!("it cannot be written: {error}")))?;
    let hash = hash(what, &bytes[HASH..]);
    bytes[..HASH].copy_from_slice(&hash);
    Ok(bytes)
}

/// The value that [`pack`] made `bytes` of.
///
/// # Errors
/// [`MotesError::Packed`] if they are of another version or kind, or were damaged.
pub fn unpack<T: DeserializeOwned>(what: &str, version: u32, bytes: &[u8]) -> Result<T, MotesError> {
    let (found, content) = bytes.split_at_checked(HASH).ok_or_else(|| damaged(what))?;
    if found != hash(what, content) {
        return Err(damaged(what));
    }
    let (found, value) = content.split_first_chunk::<VERSION>().ok_or_else(|| damaged(what))?;
    let found = u32::from_le_bytes(*found);
    if found != version {
        let reason = format!("it is of version {found}; this version of motes has version {version}");
        return Err(refused(what, reason));
    }
    ciborium::from_reader(value).map_err(|_| damaged(what))
}

fn hash(what: &str, content: &[u8]) -> [u8; HASH] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(what.as_bytes()).update(&[0]).update(content);
    *hasher.finalize().as_bytes()
}

fn damaged(what: &str) -> MotesError {
    refused(what, "its bytes are not as they were written, or are those of something else".into())
}

fn refused(what: &str, reason: String) -> MotesError {
    MotesError::Packed { what: what.into(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_what_was_written() {
        let value = vec![0.1, f64::NEG_INFINITY, f64::from_bits(0x7ff8_0000_0000_1234), -0.0];
        let bytes = pack("numbers", 1, &value).unwrap();
        let again: Vec<f64> = unpack("numbers", 1, &bytes).unwrap();
        assert!(again.iter().zip(&value).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn damaged_bytes_other_kinds_and_other_versions_are_refused_in_one_line() {
        let bytes = pack("numbers", 1, &vec![1.0, 2.0]).unwrap();
        let said = |what: &str, version: u32, bytes: &[u8]| {
            unpack::<Vec<f64>>(what, version, bytes).unwrap_err().to_string()
        };
        assert_eq!(
            said("numbers", 2, &bytes),
            "numbers: it is of version 1; this version of motes has version 2"
        );
        let damaged = "its bytes are not as they were written, or are those of something else";
        assert_eq!(said("letters", 1, &bytes), format!("letters: {damaged}"));
        for at in 0..bytes.len() {
            let mut wrong = bytes.clone();
            wrong[at] ^= 1;
            assert_eq!(said("numbers", 1, &wrong), format!("numbers: {damaged}"));
            assert_eq!(said("numbers", 1, &bytes[..at]), format!("numbers: {damaged}"));
        }
        // Whole, but another value.
        let other = pack("numbers", 1, &"a word").unwrap();
        assert_eq!(said("numbers", 1, &other), format!("numbers: {damaged}"));
    }
}
