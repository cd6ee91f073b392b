//! Counts that a driver keeps about itself.

use crate::error::SensorError;

/// A driver's counts since power-up. All saturate; none is ever reset in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// Samples delivered.
    pub samples: u32,
    /// Polls that ended in an error.
    pub errors: u32,
    /// Wrong answers for which the device was asked again.
    pub asked_again: u32,
    /// Initialisations of the device, including the first.
    pub initialisations: u32,
    /// The last error.
    pub last_error: Option<SensorError>,
}

impl Health {
    /// Counts at power-up.
    #[must_use]
    pub const fn new() -> Self {
        Self { samples: 0, errors: 0, asked_again: 0, initialisations: 0, last_error: None }
    }

    /// Counts the outcome of one poll and returns it.
    pub(crate) fn note<T>(
        &mut self,
        outcome: Result<Option<T>, SensorError>,
    ) -> Result<Option<T>, SensorError> {
        match &outcome {
            Ok(Some(_)) => self.samples = self.samples.saturating_add(1),
            Ok(None) => {}
            Err(error) => {
                self.errors = self.errors.saturating_add(1);
                self.last_error = Some(*error);
            }
        }
        outcome
    }

    pub(crate) fn asked_again(&mut self) {
        self.asked_again = self.asked_again.saturating_add(1);
    }

    pub(crate) fn initialised(&mut self) {
        self.initialisations = self.initialisations.saturating_add(1);
    }
}
