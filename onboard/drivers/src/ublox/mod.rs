//! u-blox satellite receiver on a UART with the UBX protocol (interface description UBX-22008968). The
//! `ublox` crate reads the payload of a frame. Its parser is not used, because it sums a whole frame in the
//! tick of its last byte.
//!
//! # Configuration
//! The receiver is configured to send UBX only (its NMEA sentences, 650 bytes with each solution, would fill
//! a line of 38,400 baud at 6 solutions a second) and NAV-PVT with each solution, with its rate and its
//! dynamic model (airborne, below 4 g). Each message is sent again when no acknowledgement comes within
//! [`ACKNOWLEDGE_US`], up to [`ATTEMPTS`] times. A receiver that refuses the keys of generation 9 is
//! configured like generation 8. Fixes that arrive meanwhile are delivered. The board sets the port's speed:
//! a receiver that starts at another speed must have stored this one.
//!
//! # Errors
//! A receiver that sends no solution is stale; a wrong checksum is an error of that poll. The receiver is
//! configured again when it is stale, and when so many bytes come without a frame that they can only be NMEA:
//! so a reset of the receiver is repaired. A solution that is not three-dimensional and within the receiver's
//! own limits is counted and is no fix.

mod config_messages;
mod frames;
mod link;

pub use link::{ACKNOWLEDGE_US, ATTEMPTS};

use embedded_io::{Read, ReadReady, Write, WriteReady};
use frames::{Frame, FrameError, Frames};
use kf_core::input::GpsFix;
use link::{Answer, Link};
use ublox::ack::{AckAck, AckNak};
use ublox::nav_pvt::common::NavPvtFlags;
use ublox::nav_pvt::proto27::{NavPvt, NavPvtRef};
use ublox::proto27::{PacketRef, Proto27};
use ublox::{UbxPacketMeta as _, UbxProtocol as _};

use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::SatelliteReceiver;

/// Largest number of bytes that one poll takes. It bounds the poll's work: a fix of 100 bytes in every tick,
/// as in some flights.
pub const MAX_POLL_BYTES: usize = 128;
/// The receiver is stale after this many halves of the time between the last two solutions, and after
/// `STALE_AT_MOST_US` microseconds at the latest. One lost solution is not enough. Yet the receiver is
/// configured again early enough that its silence costs half a second beyond what caused it.
const STALE_HALVES: u64 = 5;
const STALE_AT_MOST_US: u64 = 1_000_000;
/// More bytes than this without a frame mean that the receiver sends something else: the longest expected
/// frame has 100.
const BYTES_WITHOUT_A_FRAME: u32 = 300;
/// Velocity is not used if the receiver's own estimate of its accuracy (sAcc) is worse than this, mm/s.
const WORST_SPEED_ACCURACY_MMPS: u32 = 10_000;
/// Accuracy that the receiver does not know: all bits of the field are set.
const UNKNOWN_ACCURACY: u32 = u32::MAX;
/// A week, ms: time of week starts again after it.
const WEEK_MS: u64 = 604_800_000;

/// Datum of the altitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datum {
    /// Height above the WGS 84 ellipsoid.
    Ellipsoid,
    /// Height above mean sea level by the receiver's own geoid.
    MeanSeaLevel,
}

/// Configuration of the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Which of the two heights becomes the fix's altitude.
    pub datum: Datum,
    /// Time from one solution to the next, ms.
    pub period_ms: u16,
    /// Speed of the line, baud: generation 8's message for the output repeats it.
    pub baud: u32,
}

/// Traffic on the line since power-up. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Bytes received, of any kind.
    pub bytes: u32,
    /// Frames received whose checksum was right.
    pub frames: u32,
    /// Frames whose checksum was wrong, or whose content did not match their message.
    pub bad_frames: u32,
    /// Frames, or false frames, longer than any expected one.
    pub oversized: u32,
    /// Solutions that were no fix: not three-dimensional, or outside the receiver's limits.
    pub no_fix: u32,
    /// Fixes that a newer one in the same poll replaced.
    pub superseded: u32,
    /// Configuration messages sent, repetitions included.
    pub sent: u32,
    /// Refusals.
    pub refused: u32,
    /// Acknowledgements that did not come in time.
    pub timeouts: u32,
}

/// The driver.
pub struct Ublox<Port> {
    port: Port,
    period_us: u64,
    /// Time between the last two solutions; before there are two, the configured one.
    interval_us: u64,
    bytes_without_a_frame: u32,
    stream: Stream,
    link: Link,
    last_solution_us: Option<u64>,
    quiet_since_us: u64,
    health: Health,
}

/// Handles the receiver's data, whatever the port: not generic, so that it is compiled once, in this crate,
/// and so for speed.
struct Stream {
    frames: Frames,
    datum: Datum,
    week_start_ms: u64,
    last_time_of_week_ms: u32,
    counts: LinkCounts,
}

impl<Port: Read + ReadReady + Write + WriteReady> Ublox<Port> {
    /// A driver that has not yet spoken to its receiver.
    pub const fn new(port: Port, config: Config) -> Self {
        let period_us = 1_000 * config.period_ms as u64;
        Self {
            port,
            period_us,
            interval_us: period_us,
            bytes_without_a_frame: 0,
            stream: Stream::new(config.datum),
            link: Link::new(config.period_ms, config.baud),
            last_solution_us: None,
            quiet_since_us: 0,
            health: Health::new(),
        }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// The line's counts.
    pub const fn link_counts(&self) -> LinkCounts {
        self.stream.counts
    }

    /// Whether the receiver has acknowledged its whole configuration.
    pub const fn is_configured(&self) -> bool {
        self.link.is_configured()
    }

    /// The port, for a test or a board that accesses the receiver's model.
    pub const fn port_mut(&mut self) -> &mut Port {
        &mut self.port
    }

    fn step(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        let mut bytes = [0; MAX_POLL_BYTES];
        let arrived = crate::port::receive(&mut self.port, &mut bytes)?;
        let arrived_bytes = u32::try_from(arrived).unwrap_or(u32::MAX);
        let counts = &mut self.stream.counts;
        counts.bytes = counts.bytes.saturating_add(arrived_bytes);
        let frames = counts.frames;
        let received = self.stream.parse(bytes.get(..arrived).unwrap_or_default());
        self.bytes_without_a_frame = if self.stream.counts.frames == frames {
            self.bytes_without_a_frame.saturating_add(arrived_bytes)
        } else {
            0
        };
        if received.solution
            && let Some(last_us) = self.last_solution_us.replace(now_us)
        {
            self.interval_us = now_us.saturating_sub(last_us);
        }
        // Before the configuration no data is expected, and a missing acknowledgement is the link's error.
        if received.solution || !self.link.is_configured() {
            self.quiet_since_us = now_us;
        }
        if self.link.begins() {
            self.health.initialised();
        }
        let sent = self.link.step(now_us, received.answer, &mut self.port, &mut self.stream.counts);
        if received.fix.is_some() {
            return Ok(received.fix);
        }
        sent?;
        if received.bad {
            return Err(SensorError::Check);
        }
        if self.link.is_configured() {
            let interval_us = self.interval_us.max(self.period_us);
            let stale_us = (interval_us / 2).saturating_mul(STALE_HALVES).min(STALE_AT_MOST_US);
            let is_stale = now_us.saturating_sub(self.quiet_since_us) > stale_us;
            let speaks_otherwise = self.bytes_without_a_frame > BYTES_WITHOUT_A_FRAME;
            if is_stale || speaks_otherwise {
                self.bytes_without_a_frame = 0;
                self.link.restart();
                return Err(if is_stale { SensorError::Stale } else { SensorError::ConfigurationLost });
            }
        }
        Ok(None)
    }
}

impl Stream {
    const fn new(datum: Datum) -> Self {
        Self {
            frames: Frames::new(),
            datum,
            week_start_ms: 0,
            last_time_of_week_ms: 0,
            counts: LinkCounts {
                bytes: 0,
                frames: 0,
                bad_frames: 0,
                oversized: 0,
                no_fix: 0,
                superseded: 0,
                sent: 0,
                refused: 0,
                timeouts: 0,
            },
        }
    }

    #[inline(never)]
    fn parse(&mut self, mut bytes: &[u8]) -> Received {
        let Self { frames, counts, datum, week_start_ms, last_time_of_week_ms } = self;
        let mut received = Received::default();
        while let Some(frame) = frames.next(&mut bytes) {
            let packet = match frame {
                Ok(frame) => packet(&frame),
                Err(FrameError::Oversized) => {
                    count(&mut counts.oversized);
                    continue;
                }
                Err(FrameError::Checksum) => None,
            };
            let Some(packet) = packet else {
                count(&mut counts.bad_frames);
                received.bad = true;
                continue;
            };
            count(&mut counts.frames);
            let Some(packet) = packet else {
                continue;
            };
            match packet {
                PacketRef::NavPvt(solution) => {
                    received.solution = true;
                    if !is_fix(&solution) {
                        count(&mut counts.no_fix);
                        continue;
                    }
                    let time_ms = unwrapped(solution.itow(), week_start_ms, last_time_of_week_ms);
                    if received.fix.replace(fix(&solution, *datum, time_ms)).is_some() {
                        count(&mut counts.superseded);
                    }
                }
                PacketRef::AckAck(ack) => {
                    received.answer = Some(Answer::Acknowledged(ack.class(), ack.msg_id()));
                }
                PacketRef::AckNak(nak) => {
                    received.answer = Some(Answer::Refused(nak.class(), nak.msg_id()));
                }
                _ => {}
            }
        }
        received
    }
}

/// Content of a frame, `Some(None)` if it is of no expected message; `None` if an expected message is
/// malformed. Messages are recognised by their constants, so that the image does not contain the checks of a
/// hundred messages that are never used.
fn packet<'a>(frame: &Frame<'a>) -> Option<Option<PacketRef<'a>>> {
    let known = match (frame.class, frame.id) {
        (NavPvt::CLASS, NavPvt::ID) => Proto27::match_packet(NavPvt::CLASS, NavPvt::ID, frame.payload),
        (AckAck::CLASS, AckAck::ID) => Proto27::match_packet(AckAck::CLASS, AckAck::ID, frame.payload),
        (AckNak::CLASS, AckNak::ID) => Proto27::match_packet(AckNak::CLASS, AckNak::ID, frame.payload),
        _ => return Some(None),
    };
    known.ok().map(Some)
}

/// Content of one poll's bytes.
#[derive(Default)]
struct Received {
    fix: Option<GpsFix>,
    solution: bool,
    answer: Option<Answer>,
    bad: bool,
}

/// A three-dimensional fix (with or without dead reckoning) within the receiver's limits (NAV-PVT: fixType,
/// flags).
fn is_fix(solution: &NavPvtRef<'_>) -> bool {
    matches!(solution.fix_type_raw(), 3 | 4)
        && solution.flags_raw() & NavPvtFlags::GPS_FIX_OK.bits() != 0
        // flags3: position invalid.
        && solution.flags3_raw() & 1 == 0
}

/// Converts mm and mm/s to m and m/s: f32 holds every mm up to 16 km.
fn fix(solution: &NavPvtRef<'_>, datum: Datum, time_ms: u64) -> GpsFix {
    let altitude_mm = match datum {
        Datum::Ellipsoid => solution.height_above_ellipsoid_raw(),
        Datum::MeanSeaLevel => solution.height_msl_raw(),
    };
    let metres = |millimetres: i32| millimetres as f32 / 1_000.0;
    let moves = solution.speed_accuracy_raw() <= WORST_SPEED_ACCURACY_MMPS;
    let vertical_accuracy_mm = solution.vertical_accuracy_raw();
    GpsFix {
        altitude_m: metres(altitude_mm),
        velocity_north_mps: moves.then(|| metres(solution.vel_north_raw())),
        velocity_east_mps: moves.then(|| metres(solution.vel_east_raw())),
        velocity_down_mps: moves.then(|| metres(solution.vel_down_raw())),
        vertical_accuracy_m: (vertical_accuracy_mm != UNKNOWN_ACCURACY)
            .then(|| vertical_accuracy_mm as f32 / 1_000.0),
        satellites: Some(solution.num_satellites()),
        fix_time_us: Some(time_ms.saturating_mul(1_000)),
    }
}

/// Time of week, ms, continued over the week's end: a step back of more than half a week is a new week.
fn unwrapped(time_of_week_ms: u32, week_start_ms: &mut u64, last_ms: &mut u32) -> u64 {
    if u64::from(last_ms.saturating_sub(time_of_week_ms)) > WEEK_MS / 2 {
        *week_start_ms = week_start_ms.saturating_add(WEEK_MS);
    }
    *last_ms = time_of_week_ms;
    week_start_ms.saturating_add(u64::from(time_of_week_ms))
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl<Port: Read + ReadReady + Write + WriteReady> SatelliteReceiver for Ublox<Port> {
    fn poll(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        let outcome = self.step(now_us);
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_runs_on_over_the_week() {
        let (mut week, mut last) = (0, 0);
        let times = [604_799_900, 604_799_800, 0, 100].map(|ms| unwrapped(ms, &mut week, &mut last));
        assert_eq!(times, [604_799_900, 604_799_800, 604_800_000, 604_800_100]);
    }
}
