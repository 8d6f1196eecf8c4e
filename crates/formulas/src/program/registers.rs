//! Which registers are free.

/// Hands out registers, those that became free last first: they are in the nearest cache.
#[derive(Debug, Default)]
pub(super) struct Registers {
    free: Vec<u32>,
    count: u32,
}

impl Registers {
    pub(super) fn take(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.count += 1;
            self.count - 1
        })
    }

    pub(super) fn give_back(&mut self, register: u32) {
        self.free.push(register);
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count as usize
    }
}
