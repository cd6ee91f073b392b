//! Why a sensor has no sample.

/// Why a poll failed. A sample that is merely not there yet is no error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorError {
    /// There is no such device on this board, or it has never answered.
    NoDevice,
    /// The bus reported an error (no acknowledge, arbitration lost, overrun, framing).
    Bus,
    /// What arrived fails its check.
    Check,
    /// The device has not answered in the time that its datasheet gives it.
    Timeout,
}
