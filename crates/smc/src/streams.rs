//! Streams of the blocks of a large filter: any thread can draw any block.

use motes_models::Stream;
use rand::{Rng, SeedableRng};

/// A key for the streams of one step's blocks.
pub(crate) fn key(stream: &mut Stream) -> [u8; 32] {
    let mut key = [0; 32];
    stream.fill_bytes(&mut key);
    key
}

/// The stream of one block.
pub(crate) fn block_stream(key: [u8; 32], block: usize) -> Stream {
    let mut stream = Stream::from_seed(key);
    stream.set_stream(block as u64);
    stream
}
