//! The named checks that decide the quality of a calibration.
//!
//! A launch cannot be refused: a calibration with failed checks is latched together with them.

/// A check of the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Check {
    /// The settling time was over before launch.
    Settled = 0,
    /// The calibration lasted long enough.
    LongEnough = 1,
    /// The altitude was steady.
    TrimmedAltitude = 2,
    /// The airspeed was steady.
    TrimmedAirspeed = 3,
    /// The reference's own altitude had converged: it neither drifted nor jumped against its integrated climb
    /// rate, the sensors did not all drift against it alike, and the receiver's reported accuracy and
    /// satellites were good enough.
    ReferenceConverged = 4,
    /// The reference was available throughout the calibration and at launch.
    ReferenceFresh = 5,
    /// No bias drifted.
    BiasesStationary = 6,
    /// Innovations were as large as the model predicts.
    InnovationsPlausible = 7,
    /// Every number was finite, and time always increased.
    InputsValid = 8,
    /// A sensor that leaves with the UAV was delivering, and none was stuck or silent.
    SensorsAlive = 9,
    /// More than the umbilical's wire confirmed the launch.
    LaunchConfirmed = 10,
    /// For every source, the share of readings refused as implausible or as outliers was within its limit;
    /// none had settled on another level during the calibration or the settling time; and every bias is
    /// within what its prior allows.
    ReadingsConsistent = 11,
}

impl Check {
    /// Every check, in the order of its bit.
    pub const ALL: [Self; 12] = [
        Self::Settled,
        Self::LongEnough,
        Self::TrimmedAltitude,
        Self::TrimmedAirspeed,
        Self::ReferenceConverged,
        Self::ReferenceFresh,
        Self::BiasesStationary,
        Self::InnovationsPlausible,
        Self::InputsValid,
        Self::SensorsAlive,
        Self::LaunchConfirmed,
        Self::ReadingsConsistent,
    ];

    /// The name used in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Settled => "settled",
            Self::LongEnough => "long_enough",
            Self::TrimmedAltitude => "trimmed_altitude",
            Self::TrimmedAirspeed => "trimmed_airspeed",
            Self::ReferenceConverged => "reference_converged",
            Self::ReferenceFresh => "reference_fresh",
            Self::BiasesStationary => "biases_stationary",
            Self::InnovationsPlausible => "innovations_plausible",
            Self::InputsValid => "inputs_valid",
            Self::SensorsAlive => "sensors_alive",
            Self::LaunchConfirmed => "launch_confirmed",
            Self::ReadingsConsistent => "readings_consistent",
        }
    }
}

/// Checks that failed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FailedChecks(u16);

impl FailedChecks {
    /// Failed checks from the bits of [`Self::bits`].
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    /// One bit for each check, in the order of [`Check::ALL`].
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// Records the outcome of a check.
    pub fn note(&mut self, check: Check, passed: bool) {
        if !passed {
            self.0 |= 1 << check as u8;
        }
    }

    /// Replaces the recorded outcome of a check.
    pub fn settle(&mut self, check: Check, passed: bool) {
        self.0 &= !(1 << check as u8);
        self.note(check, passed);
    }

    /// Whether a check failed.
    #[must_use]
    pub const fn contains(self, check: Check) -> bool {
        self.0 & (1 << check as u8) != 0
    }

    /// Whether the calibration is good: no check failed.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Every check that failed.
    pub fn iter(self) -> impl Iterator<Item = Check> {
        Check::ALL.into_iter().filter(move |check| self.contains(*check))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_check_has_its_own_bit_and_name() {
        for (k, check) in Check::ALL.into_iter().enumerate() {
            let mut failed = FailedChecks::default();
            failed.note(check, true);
            assert!(failed.is_empty());
            failed.note(check, false);
            assert_eq!(failed.bits(), 1 << k);
            assert!(failed.iter().eq([check]));
            assert!(Check::ALL[..k].iter().all(|other| other.name() != check.name()));
        }
    }
}
