//! One finished unit as a line of text, which shows whether it is whole.

use super::record::Record;

/// A line that is whole: `{"key":"K","length":L,"blake3":"H","unit":BODY}` with the length of BODY and the hash of K and BODY.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line<'a> {
    /// The key of the unit's configuration.
    pub(super) key: &'a str,
    /// The unit as JSON.
    pub(super) body: &'a str,
}

const KEY: &str = "{\"key\":\"";
const LENGTH: &str = "\",\"length\":";
const HASH: &str = ",\"blake3\":\"";
const UNIT: &str = "\",\"unit\":";
const END: &str = "}";

impl<'a> Line<'a> {
    /// The unit in a line, without its newline; `None` if it is not whole.
    pub(super) fn parse(bytes: &'a [u8]) -> Option<Self> {
        let text = std::str::from_utf8(bytes).ok()?;
        let (key, rest) = text.strip_prefix(KEY)?.split_once(LENGTH)?;
        let (length, rest) = rest.split_once(HASH)?;
        let (hash, rest) = rest.split_once(UNIT)?;
        let line = Line { key, body: rest.strip_suffix(END)? };
        let is_whole = length.parse() == Ok(line.body.len()) && line.hash() == hash;
        is_whole.then_some(line)
    }

    /// The line of text, with its newline.
    pub(super) fn text(self) -> String {
        let Line { key, body } = self;
        format!("{KEY}{key}{LENGTH}{}{HASH}{}{UNIT}{body}{END}\n", body.len(), self.hash())
    }

    fn hash(self) -> String {
        blake3::Hasher::new().update(self.key.as_bytes()).update(self.body.as_bytes()).finalize().to_string()
    }

    /// The unit, if this version of the program wrote it.
    pub(super) fn record(self) -> Option<Record> {
        serde_json::from_str(self.body).ok().filter(|record: &Record| record.config.key() == self.key)
    }
}

/// The line of a unit.
pub(super) fn encode(record: &Record) -> String {
    let body = serde_json::to_string(record).expect("a record has only string keys and finite numbers");
    Line { key: &record.config.key(), body: &body }.text()
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::record;
    use super::*;

    #[test]
    fn every_damaged_byte_is_noticed() {
        let text = encode(&record());
        let bytes = text.strip_suffix('\n').unwrap().as_bytes();
        assert_eq!(Line::parse(bytes).unwrap().record(), Some(record()));
        let _: serde_json::Value = serde_json::from_str(&text).unwrap();
        for at in 0..bytes.len() {
            let mut flipped = bytes.to_vec();
            flipped[at] ^= 1;
            assert_eq!(Line::parse(&flipped), None, "a flip in byte {at} went unnoticed");
            assert_eq!(Line::parse(&bytes[..at]), None, "a line of {at} bytes was taken for whole");
        }
    }
}
