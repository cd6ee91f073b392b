//! A value that waits for sending.

/// The latest sample of a value, and whether it has been sent.
#[derive(Clone, Copy, Debug)]
pub struct Sample<T> {
    value: Option<(u32, T)>,
    sent: bool,
}

impl<T: Copy> Sample<T> {
    /// No sample yet.
    pub const NONE: Self = Self { value: None, sent: true };

    /// Stores a sample with that time, if there is one.
    pub fn take(&mut self, time_ms: u32, sample: Option<T>) {
        if let Some(sample) = sample {
            self.value = Some((time_ms, sample));
            self.sent = false;
        }
    }

    /// Whether there is a sample that has not been sent.
    pub const fn is_new(&self) -> bool {
        !self.sent
    }

    /// Returns the sample that has not been sent, and marks it as sent.
    pub fn send(&mut self) -> Option<(u32, T)> {
        if self.sent {
            return None;
        }
        self.sent = true;
        self.value
    }

    /// The latest sample, sent or not, with its time.
    pub const fn latest(&self) -> Option<(u32, T)> {
        self.value
    }
}
