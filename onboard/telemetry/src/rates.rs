//! How often each message is sent, and whether the line can carry that.

use crate::frame::line_bytes;
use crate::link::MessageKind;

/// A second, microseconds.
const SECOND_US: u32 = 1_000_000;
/// Shortest period of messages sent at every tick: the flight computer's own, microseconds.
const TICK_US: u32 = 5_000;
/// Bits of a byte on the line: start, eight bits, stop.
const BITS_PER_BYTE: u32 = 10;
/// Share of the line that the table may use, percent: the rest is for reports of drops, and for bursts.
const SHARE_PERCENT: u32 = 80;

/// Why there are no rates for a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RatesError {
    /// The line cannot carry even the narrow table.
    LineTooSlow,
}

/// The rate table: periods in microseconds; 0 means "at every tick that has a new sample".
///
/// | what | message | full | narrow |
/// |---|---|---|---|
/// | inertial and barometer samples | HIGHRES_IMU | every tick | 50 Hz |
/// | inertial altitudes, each | NAMED_VALUE_FLOAT | every tick | 25 Hz |
/// | fixes | GPS_RAW_INT, NAMED_VALUE_FLOAT | every fix | up to 10 Hz |
/// | attitude | ATTITUDE | 20 Hz | 10 Hz |
/// | airspeed, angle of attack, sideslip, throttle, each | NAMED_VALUE_FLOAT | 10 Hz | 5 Hz |
/// | altitudes | ALTITUDE | 10 Hz | 5 Hz |
/// | errors, moving averages, trust, in turn | NAMED_VALUE_FLOAT | 20 Hz | 10 Hz |
/// | everything else of [`crate::named`], in turn | NAMED_VALUE_FLOAT | 10 Hz | 5 Hz |
/// | texts, as they come, up to | STATUSTEXT | 20 Hz | 5 Hz |
/// | phase; status; launch; outside air temperature, each | HEARTBEAT, SYS_STATUS, NAMED_VALUE_FLOAT | 1 Hz | 1 Hz |
///
/// Besides the samples and fixes, at most one message a tick is sent: the one that has been due longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rates {
    /// Period of HIGHRES_IMU. Unless it is 0, the message waits for a tick with a barometer's sample, so that
    /// no sample is sent with another tick's time.
    pub sample_us: u32,
    /// Each inertial altitude.
    pub inertial_altitude_us: u32,
    /// A fix and its velocity down.
    pub fix_us: u32,
    /// ATTITUDE.
    pub attitude_us: u32,
    /// Each of airspeed, angle of attack, sideslip, throttle.
    pub signal_us: u32,
    /// ALTITUDE.
    pub altitude_us: u32,
    /// Errors, moving averages and trust, in turn.
    pub error_us: u32,
    /// Everything else, in turn.
    pub slow_us: u32,
    /// Texts.
    pub text_us: u32,
}

impl Rates {
    /// Every sample: the ground records what the estimator received.
    pub const FULL: Self = Self {
        sample_us: 0,
        inertial_altitude_us: 0,
        fix_us: 0,
        attitude_us: SECOND_US / 20,
        signal_us: SECOND_US / 10,
        altitude_us: SECOND_US / 10,
        error_us: SECOND_US / 20,
        slow_us: SECOND_US / 10,
        text_us: SECOND_US / 20,
    };

    /// For a line of 115200 baud.
    pub const NARROW: Self = Self {
        sample_us: SECOND_US / 50,
        inertial_altitude_us: SECOND_US / 25,
        fix_us: SECOND_US / 10,
        attitude_us: SECOND_US / 10,
        signal_us: SECOND_US / 5,
        altitude_us: SECOND_US / 5,
        error_us: SECOND_US / 10,
        slow_us: SECOND_US / 5,
        text_us: SECOND_US / 5,
    };

    /// HEARTBEAT, SYS_STATUS, the launch, the outside air temperature.
    pub const SECOND_US: u32 = SECOND_US;
    /// Period of the effects' names, for a ground station that joins late.
    pub const ANNOUNCE_US: u32 = 60 * SECOND_US;

    /// The fullest table that a line of that rate can carry within 80 %.
    ///
    /// # Errors
    /// [`RatesError::LineTooSlow`].
    pub const fn for_line(baud: u32) -> Result<Self, RatesError> {
        if Self::FULL.fits(baud) {
            Ok(Self::FULL)
        } else if Self::NARROW.fits(baud) {
            Ok(Self::NARROW)
        } else {
            Err(RatesError::LineTooSlow)
        }
    }

    /// Whether a line of that rate can carry this table within 80 %.
    #[must_use]
    pub const fn fits(&self, baud: u32) -> bool {
        self.bytes_per_second() <= baud / BITS_PER_BYTE / 100 * SHARE_PERCENT
    }

    /// Largest load of this table, with every sensor delivering at every tick, bytes a second.
    #[must_use]
    pub const fn bytes_per_second(&self) -> u32 {
        const NAMED: u32 = MessageKind::NamedValueFloat.line_bytes();
        per_second(self.sample_us) * MessageKind::HighresImu.line_bytes()
            + per_second(self.inertial_altitude_us) * 2 * NAMED
            + per_second(self.fix_us) * (MessageKind::GpsRawInt.line_bytes() + NAMED)
            + per_second(self.attitude_us) * MessageKind::Attitude.line_bytes()
            + per_second(self.signal_us) * 4 * NAMED
            + per_second(self.altitude_us) * MessageKind::Altitude.line_bytes()
            + (per_second(self.error_us) + per_second(self.slow_us)) * NAMED
            + per_second(self.text_us) * MessageKind::StatusText.line_bytes()
            + MessageKind::Heartbeat.line_bytes()
            + MessageKind::SysStatus.line_bytes()
            + 2 * NAMED
    }
}

impl MessageKind {
    /// Largest number of bytes of one of its frames, with the full payload including extensions.
    #[must_use]
    pub const fn line_bytes(self) -> u32 {
        use mavlink::dialects::common as messages;
        line_bytes(match self {
            Self::Heartbeat => messages::HEARTBEAT_DATA::ENCODED_LEN,
            Self::SysStatus => messages::SYS_STATUS_DATA::ENCODED_LEN,
            Self::GpsRawInt => messages::GPS_RAW_INT_DATA::ENCODED_LEN,
            Self::Attitude => messages::ATTITUDE_DATA::ENCODED_LEN,
            Self::HighresImu => messages::HIGHRES_IMU_DATA::ENCODED_LEN,
            Self::Altitude => messages::ALTITUDE_DATA::ENCODED_LEN,
            Self::NamedValueFloat => messages::NAMED_VALUE_FLOAT_DATA::ENCODED_LEN,
            Self::StatusText => messages::STATUSTEXT_DATA::ENCODED_LEN,
        })
    }
}

const fn per_second(period_us: u32) -> u32 {
    SECOND_US.div_ceil(if period_us < TICK_US { TICK_US } else { period_us })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_gets_the_fullest_table_that_it_carries() {
        assert_eq!(Rates::for_line(921_600), Ok(Rates::FULL));
        assert_eq!(Rates::for_line(460_800), Ok(Rates::NARROW));
        assert_eq!(Rates::for_line(115_200), Ok(Rates::NARROW));
        assert_eq!(Rates::for_line(57_600), Err(RatesError::LineTooSlow));
    }

    #[test]
    fn a_second_of_the_table_is_what_its_messages_weigh() {
        // Computed by hand: frames of 12 bytes and the payloads of MAVLink's definitions.
        let full = 200 * 75 + 400 * 30 + 200 * (64 + 30) + 20 * 40 + 40 * 30 + 10 * 44 + 30 * 30 + 20 * 66;
        assert_eq!(Rates::FULL.bytes_per_second(), full + 21 + 55 + 60);
        let narrow = 50 * 75 + 50 * 30 + 10 * (64 + 30) + 10 * 40 + 20 * 30 + 5 * 44 + 15 * 30 + 5 * 66;
        assert_eq!(Rates::NARROW.bytes_per_second(), narrow + 21 + 55 + 60);
    }

    #[test]
    fn what_is_sent_one_a_tick_has_ticks_enough() {
        let hz = |period_us| per_second(period_us);
        for rates in [Rates::FULL, Rates::NARROW] {
            let slots = hz(rates.attitude_us)
                + 4 * hz(rates.signal_us)
                + hz(rates.altitude_us)
                + hz(rates.error_us)
                + hz(rates.slow_us)
                + hz(rates.text_us)
                + 4;
            assert!(slots < 200, "{slots}");
        }
    }
}
