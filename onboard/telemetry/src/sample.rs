//! A value that waits to be sent.

/// The latest sample of something, and whether it has been sent.
#[derive(Clone, Copy, Debug)]
pub struct Sample<T> {
    value: Option<(u32, T)>,
    sent: bool,
}

impl<T: Copy> Sample<T> {
    /// None yet.
    pub const NONE: Self = Self { value: None, sent: true };

    /// Takes a sample of that time, if there is one.
    pub fn take(&mut self, time_ms: u32, sample: Option<T>) {
        if let Some(sample) = sample {
            self.value = Some((time_ms, sample));
            self.sent = false;
        }
    }

    /// Whether there is one that has not been sent.
    pub const fn is_new(&self) -> bool {
        !self.sent
    }

    /// The one that has not been sent, which now counts as sent.
    pub fn send(&mut self) -> Option<(u32, T)> {
        if self.sent {
            return None;
        }
        self.sent = true;
        self.value
    }

    /// The latest, sent or not, with its time.
    pub const fn latest(&self) -> Option<(u32, T)> {
        self.value
    }
}
