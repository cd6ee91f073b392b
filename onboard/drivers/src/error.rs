//! Reasons why a sensor has no sample.

/// Why a poll failed. A sample that has not come yet is no error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorError {
    /// There is no such device on this board, or it has never answered.
    NoDevice,
    /// The bus reported an error (no acknowledge, arbitration lost, overrun, framing).
    Bus,
    /// The received data fails its check (CRC, checksum, length).
    Check,
    /// The device has not answered within the time in its datasheet.
    Timeout,
    /// The data line never moved: every bit that was read is 0, or every bit is 1.
    StuckBus,
    /// A device answers, but its identity is not that of this driver's chip.
    WrongDevice,
    /// A conversion has no result: it was not started, was interrupted or took longer than the datasheet
    /// allows.
    NoConversion,
    /// The chip does not hold its configuration: it was reset in flight, or a register changed.
    ConfigurationLost,
    /// The chip answers, but has made no new sample for longer than its rate allows.
    Stale,
    /// At least one axis is at the end of its range: the true value may be anything beyond.
    Saturated,
    /// The value is outside the chip's measuring range in its datasheet.
    OutOfRange,
    /// The device refused its configuration, or did not acknowledge it after all retries.
    NotAcknowledged,
}
