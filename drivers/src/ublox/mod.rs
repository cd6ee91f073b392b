//! u-blox satellite receiver on a UART, by its UBX protocol (interface description UBX-22008968; the parser is the
//! `ublox` crate's).
//!
//! # Configuration
//! The receiver is told its rate, its dynamic model (airborne, below 4 g) and to send NAV-PVT. Each message is
//! sent anew when no acknowledgement comes within [`ACKNOWLEDGE_US`], [`ATTEMPTS`] times; a receiver that
//! refuses the keys of generation 9 is configured the way of generation 8. Fixes that arrive meanwhile
//! are delivered all the same. The port's speed is the board's matter.
//!
//! # Errors
//! A receiver that sends nothing is stale, one that sends a wrong checksum is an error of that poll, and
//! after silence everything is configured anew: a reset of the receiver heals itself. A solution that is not
//! three-dimensional and within the receiver's own limits is counted and is no fix.

mod config_messages;
mod link;

pub use link::{ACKNOWLEDGE_US, ATTEMPTS};

use embedded_io::{Read, ReadReady, Write, WriteReady};
use kf_core::input::GpsFix;
use link::{Answer, Link};
use ublox::nav_pvt::common::NavPvtFlags;
use ublox::nav_pvt::proto27::NavPvtRef;
use ublox::proto27::{PacketRef, Proto27};
use ublox::{FixedBuffer, Parser, ParserBuilder, ParserError, UbxPacket};

use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::SatelliteReceiver;

/// Bytes that one poll takes at most: at 115,200 baud 58 arrive in 5 ms.
pub const MAX_POLL_BYTES: usize = 128;
/// What the parser can hold back: the longest frame that is asked for has 100 bytes. A longer one, or garbage
/// that pretends to be one, is dropped after so many.
const PARSER_BYTES: usize = 256;
/// Longest time from one solution to the next, in periods, and at least so long in microseconds.
const STALE_PERIODS: u64 = 5;
const STALE_AT_LEAST_US: u64 = 1_000_000;
/// Velocity is no measurement where the receiver's own estimate of its accuracy (sAcc) is worse, mm/s.
const WORST_SPEED_ACCURACY_MMPS: u32 = 10_000;
/// An accuracy that the receiver does not know: the field is full.
const UNKNOWN_ACCURACY: u32 = u32::MAX;
/// A week, ms: time of week starts anew after it.
const WEEK_MS: u64 = 604_800_000;

/// What altitude means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datum {
    /// Height above the WGS 84 ellipsoid.
    Ellipsoid,
    /// Height above mean sea level by the receiver's own geoid.
    MeanSeaLevel,
}

/// What the receiver is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Which of the two heights becomes the fix's altitude.
    pub datum: Datum,
    /// Time from one solution to the next, ms.
    pub period_ms: u16,
}

/// What came and went on the line since power-up. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Bytes received, whatever they were.
    pub bytes: u32,
    /// Frames received whose checksum was right.
    pub frames: u32,
    /// Frames whose checksum was wrong, or whose content was not that of their message.
    pub bad_frames: u32,
    /// Frames, or what looked like them, longer than any that was asked for.
    pub oversized: u32,
    /// Solutions that were no fix: not three-dimensional, or outside the receiver's limits.
    pub no_fix: u32,
    /// Fixes that were followed by a newer one in the same poll.
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
    datum: Datum,
    stale_us: u64,
    parser: Parser<FixedBuffer<PARSER_BYTES>, Proto27>,
    link: Link,
    last_solution_us: Option<u64>,
    week_start_ms: u64,
    last_time_of_week_ms: u32,
    health: Health,
    counts: LinkCounts,
}

impl<Port: Read + ReadReady + Write + WriteReady> Ublox<Port> {
    /// A driver that has not yet spoken to its receiver.
    pub const fn new(port: Port, config: Config) -> Self {
        let periods_us = STALE_PERIODS * 1_000 * config.period_ms as u64;
        Self {
            port,
            datum: config.datum,
            stale_us: if periods_us > STALE_AT_LEAST_US { periods_us } else { STALE_AT_LEAST_US },
            parser: ParserBuilder::new().with_protocol::<Proto27>().with_fixed_buffer(),
            link: Link::new(config.period_ms),
            last_solution_us: None,
            week_start_ms: 0,
            last_time_of_week_ms: 0,
            health: Health::new(),
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

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// The line's counts.
    pub const fn link_counts(&self) -> LinkCounts {
        self.counts
    }

    /// Whether the receiver has acknowledged its whole configuration.
    pub const fn is_configured(&self) -> bool {
        self.link.is_configured()
    }

    /// The port, for a test or a board that has to speak to the receiver's model.
    pub const fn port_mut(&mut self) -> &mut Port {
        &mut self.port
    }

    fn step(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        let mut bytes = [0; MAX_POLL_BYTES];
        let arrived = crate::port::receive(&mut self.port, &mut bytes)?;
        self.counts.bytes = self.counts.bytes.saturating_add(u32::try_from(arrived).unwrap_or(u32::MAX));
        let received = self.parse(bytes.get(..arrived).unwrap_or_default());
        if received.solution {
            self.last_solution_us = Some(now_us);
        }
        if self.link.begins() {
            self.health.initialised();
        }
        let sent = self.link.step(now_us, received.answer, &mut self.port, &mut self.counts);
        if received.fix.is_some() {
            return Ok(received.fix);
        }
        sent?;
        if received.bad {
            return Err(SensorError::Check);
        }
        // Until it is configured nothing need come, and a missing acknowledgement is the link's error.
        match self.last_solution_us {
            Some(last_us) if self.link.is_configured() => {
                if now_us.saturating_sub(last_us) > self.stale_us {
                    self.link.restart();
                    return Err(SensorError::Stale);
                }
            }
            _ => self.last_solution_us = Some(now_us),
        }
        Ok(None)
    }

    fn parse(&mut self, bytes: &[u8]) -> Received {
        let Self { parser, counts, datum, week_start_ms, last_time_of_week_ms, .. } = self;
        let mut received = Received::default();
        let mut frames = parser.consume_ubx(bytes);
        while let Some(frame) = frames.next() {
            match frame {
                Ok(packet) => {
                    count(&mut counts.frames);
                    match packet {
                        UbxPacket::Proto27(PacketRef::NavPvt(solution)) => {
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
                        UbxPacket::Proto27(PacketRef::AckAck(ack)) => {
                            received.answer = Some(Answer::Acknowledged(ack.class(), ack.msg_id()));
                        }
                        UbxPacket::Proto27(PacketRef::AckNak(nak)) => {
                            received.answer = Some(Answer::Refused(nak.class(), nak.msg_id()));
                        }
                        _ => {}
                    }
                }
                Err(ParserError::OutOfMemory { .. }) => count(&mut counts.oversized),
                Err(_) => {
                    count(&mut counts.bad_frames);
                    received.bad = true;
                }
            }
        }
        received
    }
}

/// What one poll's bytes contained.
#[derive(Default)]
struct Received {
    fix: Option<GpsFix>,
    solution: bool,
    answer: Option<Answer>,
    bad: bool,
}

/// A three-dimensional fix (with or without dead reckoning) within the receiver's limits (NAV-PVT: fixType, flags).
fn is_fix(solution: &NavPvtRef<'_>) -> bool {
    matches!(solution.fix_type_raw(), 3 | 4)
        && solution.flags_raw() & NavPvtFlags::GPS_FIX_OK.bits() != 0
        // flags3: position invalid.
        && solution.flags3_raw() & 1 == 0
}

/// mm and mm/s become m and m/s: f32 holds every mm up to 16 km.
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

/// Time of week, ms, made to run on over the week's end: a step back of more than half a week is a new week.
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
