//! Random streams: every number drawn anywhere comes from a [`Seed`] that was derived on purpose.

use rand::rngs::{ChaCha8Rng, ChaCha12Rng};
use rand::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// The generator that everything draws from.
///
/// Counter based, so a stream's position depends on nothing but how much was drawn from it.
pub type Stream = ChaCha8Rng;

/// A stream that goes on as the given one does from where it is. (Generators have no `Clone`, so that none is doubled by accident.)
pub fn duplicate(stream: &Stream) -> Stream {
    StreamPosition::of(stream).stream()
}

/// Where a [`Stream`] is, to be written down: all that its later numbers depend on.
///
/// ```
/// use motes_models::{Seed, StreamPosition};
/// use rand::Rng;
///
/// let mut stream = Seed::from_u64(1).stream();
/// stream.next_u64();
/// let position = StreamPosition::of(&stream);
/// assert_eq!(position.stream().next_u64(), stream.next_u64());
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamPosition {
    key: [u8; 32],
    /// Which of the key's streams it is.
    number: u64,
    /// How many words of 32 bits were drawn.
    words: u128,
}

impl StreamPosition {
    /// That of a stream.
    pub fn of(stream: &Stream) -> Self {
        StreamPosition { key: stream.get_seed(), number: stream.get_stream(), words: stream.get_word_pos() }
    }

    /// A stream that goes on from there.
    pub fn stream(&self) -> Stream {
        let mut stream = Stream::from_seed(self.key);
        stream.set_stream(self.number);
        stream.set_word_pos(self.words);
        stream
    }
}

/// A node in a tree of random streams.
///
/// Children are derived by label or by number, and deriving one never changes another. The streams of unit 7 are the same
/// whether units 0 to 6 ran before it, after it, on another thread or not at all.
///
/// ```
/// use motes_models::Seed;
/// use rand::Rng;
///
/// let run = Seed::from_u64(42);
/// let mut noise = run.child("filter").nth(3).stream();
/// let mut again = run.child("filter").nth(3).stream();
/// assert_eq!(noise.next_u64(), again.next_u64());
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seed([u8; 32]);

/// What a key is used for; each use reads its own block of the key's keystream.
#[derive(Clone, Copy)]
enum Use {
    Label = 0,
    Index = 1,
    Stream = 2,
}

impl Seed {
    /// The root of a run.
    pub fn from_u64(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        Seed(key)
    }

    /// The child with this label.
    #[must_use]
    pub fn child(&self, label: &str) -> Seed {
        // 64-bit FNV-1a: labels are few and fixed, so all that matters is that it never changes.
        let tag = label.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        self.derive(Use::Label, tag)
    }

    /// The child with this number.
    #[must_use]
    pub fn nth(&self, index: u64) -> Seed {
        self.derive(Use::Index, index)
    }

    /// A generator that belongs to this node alone.
    pub fn stream(&self) -> Stream {
        Stream::from_seed(self.derive(Use::Stream, 0).0)
    }

    /// One generator each for the children 0, …, `count` − 1.
    pub fn streams(&self, count: usize) -> Vec<Stream> {
        (0..count as u64).map(|index| self.nth(index).stream()).collect()
    }

    /// ChaCha12 as a pseudo-random function: key = this seed, nonce = `tag`, block = `purpose`.
    fn derive(&self, purpose: Use, tag: u64) -> Seed {
        let mut prf = ChaCha12Rng::from_seed(self.0);
        prf.set_stream(tag);
        prf.set_word_pos(16 * purpose as u128);
        let mut key = [0; 32];
        prf.fill_bytes(&mut key);
        Seed(key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_differ_from_each_other_and_from_their_parent() {
        let root = Seed::from_u64(7);
        let seeds = [
            root.clone(),
            Seed::from_u64(8),
            root.child("a"),
            root.child("b"),
            root.child("a").child("a"),
            root.nth(0),
            root.nth(1),
            root.child("a").nth(0),
        ];
        let mut first: Vec<u64> = seeds.iter().map(|seed| seed.stream().next_u64()).collect();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), seeds.len());
    }

    #[test]
    fn derivation_is_fixed_for_ever() {
        // Every committed result depends on these bytes; a change here is a new unit-format version.
        let drawn = Seed::from_u64(1).child("graph").nth(3).stream().next_u64();
        assert_eq!(drawn, 9_446_624_587_637_209_557);
    }
}
