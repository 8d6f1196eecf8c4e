//! Data from a file or from standard input, which can be stopped while it is waited for.

use std::io::{Error, Read, Result};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use motes::{Data, Model, MotesError};
use motes_cli::Interrupt;

/// What standard input is called in errors.
pub(super) const STANDARD: &str = "standard input";

/// Reads data from a file, or from standard input where the path is `-`.
pub(super) fn data(
    path: &Path,
    model: &Model,
    interrupt: &Interrupt,
) -> std::result::Result<Data, MotesError> {
    match path == Path::new("-") {
        true => Data::read(Standard::new(interrupt), STANDARD, model)
            .map_err(|error| stopped(error.into(), interrupt)),
        false => Ok(Data::open(path, model)?),
    }
}

/// What an error means once somebody asked to stop.
pub(super) fn stopped(error: MotesError, interrupt: &Interrupt) -> MotesError {
    if interrupt.check().is_break() { MotesError::Interrupted } else { error }
}

/// Standard input, read by a thread of its own: a read that waits cannot be stopped, waiting for that thread can.
pub(super) struct Standard {
    chunks: Receiver<Result<Vec<u8>>>,
    /// What is left of the last chunk.
    chunk: Vec<u8>,
    read: usize,
    interrupt: Interrupt,
}

impl Standard {
    pub(super) fn new(interrupt: &Interrupt) -> Self {
        const SIZE: usize = 64 * 1024;
        let (sender, chunks) = sync_channel(2);
        // It ends with the input, or with the process.
        std::thread::spawn(move || {
            let mut buffer = vec![0; SIZE];
            let mut standard = std::io::stdin().lock();
            loop {
                let chunk = match standard.read(&mut buffer) {
                    Ok(0) => return,
                    Ok(length) => Ok(buffer[..length].to_vec()),
                    Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
                    Err(error) => Err(error),
                };
                let is_last = chunk.is_err();
                if sender.send(chunk).is_err() || is_last {
                    return;
                }
            }
        });
        Standard { chunks, chunk: Vec::new(), read: 0, interrupt: interrupt.clone() }
    }
}

impl Read for Standard {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        const PATIENCE: Duration = Duration::from_millis(50);
        while self.read == self.chunk.len() {
            if self.interrupt.check().is_break() {
                return Err(Error::other("stopped"));
            }
            match self.chunks.recv_timeout(PATIENCE) {
                Ok(chunk) => (self.chunk, self.read) = (chunk?, 0),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
        }
        let length = buffer.len().min(self.chunk.len() - self.read);
        buffer[..length].copy_from_slice(&self.chunk[self.read..self.read + length]);
        self.read += length;
        Ok(length)
    }
}
