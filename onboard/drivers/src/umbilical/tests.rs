//! Robustness against any bytes on the line.

use core::convert::Infallible;

use embedded_io::ErrorType;
use kf_core::input::{BaroReading, GpsFix, ImuSample};

use super::*;
use crate::replay::{Replay, ReplayUmbilical};
use crate::sensor::{BarometerSample, VehicleState};
use crate::suite::{Sensors, Suite};

/// Length of the longest frame, and of the shortest: a payload of one byte.
const LONGEST: usize = 44;
const SHORTEST: usize = 13;

/// A line that is never idle: it delivers as many bytes as are requested.
struct Noise {
    state: u32,
    /// Bytes to deliver before random ones.
    planned: Vec<u8>,
    /// The bytes delivered last.
    given: Vec<u8>,
}

impl Noise {
    fn next(&mut self) -> u32 {
        self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.state >> 8
    }

    /// Bytes of all kinds: random ones, starts of frames, headers that fit, whole frames and frames with a
    /// flipped bit.
    fn plan(&mut self) {
        let kind = self.next() % 16;
        let bytes = match kind {
            0..8 => vec![(self.next() >> 8) as u8],
            8..11 => vec![0xFD; 1 + self.next() as usize % 50],
            11 => vec![0xFD, (self.next() % 40) as u8, 0, 0, 7, 1, 1, 141, 0, 0],
            _ => {
                let sender = [(1, 1), (2, 1), (1, 2)][self.next() as usize % 3];
                let altitude_m = f32::from_bits(self.next() << 8 | self.next() & 0xff);
                let mut frame = frame(sender, altitude_m, self.next() as u8);
                if kind == 15 {
                    let place = self.next() as usize % frame.len();
                    frame[place] ^= 1 << (self.next() % 8);
                } else if kind == 14 {
                    frame.truncate(self.next() as usize % frame.len());
                }
                frame
            }
        };
        self.planned = bytes.into_iter().rev().collect();
    }
}

impl ErrorType for Noise {
    type Error = Infallible;
}

impl ReadReady for Noise {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl Read for Noise {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        for slot in &mut *buffer {
            while self.planned.is_empty() {
                self.plan();
            }
            *slot = self.planned.pop().unwrap_or_default();
            self.given.push(*slot);
        }
        Ok(buffer.len())
    }
}

/// MAVLink's checksum, computed bit by bit.
fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |sum, byte| {
        (0..8).fold(sum ^ u16::from(*byte), |sum, _| (sum >> 1) ^ if sum & 1 == 0 { 0 } else { 0x8408 })
    })
}

fn frame(sender: (u8, u8), altitude_m: f32, sequence: u8) -> Vec<u8> {
    flagged(0, sender, altitude_m, sequence)
}

/// A frame with these flags, which a receiver has to know.
fn flagged(flags: u8, (system, component): (u8, u8), altitude_m: f32, sequence: u8) -> Vec<u8> {
    let mut payload = [0; 32];
    payload[12..16].copy_from_slice(&altitude_m.to_le_bytes());
    let mut bytes = vec![0xFD, 32, flags, 0, sequence, system, component, 141, 0, 0];
    bytes.extend(payload);
    let checked: Vec<u8> = bytes[1..].iter().copied().chain([47]).collect();
    bytes.extend(checksum(&checked).to_le_bytes());
    bytes
}

/// Whether these bytes hold a whole frame of that sender with that altitude.
fn holds(bytes: &[u8], sender: Sender, altitude_m: f32) -> bool {
    bytes.windows(SHORTEST).enumerate().any(|(start, head)| {
        let length = usize::from(head[1]);
        let end = start + 10 + length;
        let is_altitude = head[0] == 0xFD && head[7..10] == [141, 0, 0] && head[2] & !1 == 0;
        if !is_altitude || [head[5], head[6]] != [sender.system, sender.component] || end + 2 > bytes.len() {
            return false;
        }
        let checked: Vec<u8> = bytes[start + 1..end].iter().copied().chain([47]).collect();
        let mut payload = bytes[start + 10..end].to_vec();
        payload.resize(32, 0);
        checksum(&checked).to_le_bytes() == bytes[end..end + 2] && payload[12..16] == altitude_m.to_le_bytes()
    })
}

/// Ten million bytes: every accepted altitude is in a frame of the mother ship with a right checksum, and no
/// poll does more than its share.
#[test]
fn ten_million_bytes_of_anything() {
    let noise = Noise { state: 20_261_122, planned: Vec::new(), given: Vec::new() };
    let mut driver = Umbilical::new(noise, Sender::FIRST_AUTOPILOT);
    let (mut accepted, mut refused) = (0_u32, 0_u32);
    for tick in 0..10_000_000 / MAX_POLL_BYTES as u64 {
        let before = driver.link_counts();
        let polled = driver.poll(tick * 5_000);
        let counts = driver.link_counts();
        assert!(counts.bytes - before.bytes <= MAX_POLL_BYTES as u32);
        // Every attempted frame begins with a header that fits.
        let checked = counts.frames + counts.other_senders + counts.bad_frames
            - before.frames
            - before.other_senders
            - before.bad_frames;
        assert!(checked as usize <= (MAX_POLL_BYTES + LONGEST) / 10, "{checked}");
        match polled {
            Ok(Some(altitude_m)) => {
                accepted += 1;
                assert!(ALTITUDES_M.contains(&altitude_m));
                assert!(holds(&driver.port_mut().given, Sender::FIRST_AUTOPILOT, altitude_m), "{altitude_m}");
            }
            Err(SensorError::OutOfRange) => refused += 1,
            Ok(None) | Err(_) => {}
        }
        let given = &mut driver.port_mut().given;
        given.drain(..given.len().saturating_sub(LONGEST + MAX_POLL_BYTES));
    }
    let counts = driver.link_counts();
    assert!(accepted > 1_000 && refused > 1_000, "{accepted} {refused}");
    assert!(counts.other_senders > 10_000 && counts.bad_frames > 10_000, "{counts:?}");
}

/// Another sender's altitude is ignored, and so is one that no mother ship can have.
#[test]
fn only_the_mother_ships_plausible_altitudes_count() {
    let only = |bytes: Vec<u8>| {
        // The line ends with bytes that are no frame.
        let planned = bytes.into_iter().chain([0; MAX_POLL_BYTES]).rev().collect();
        let mut driver =
            Umbilical::new(Noise { state: 1, planned, given: Vec::new() }, Sender::FIRST_AUTOPILOT);
        (driver.poll(0), driver.link_counts())
    };
    assert_eq!(only(frame((1, 1), 2_000.0, 0)).0, Ok(Some(2_000.0)));
    for sender in [(2, 1), (1, 2), (0, 0), (255, 190)] {
        let (polled, counts) = only(frame(sender, 2_000.0, 0));
        assert_eq!((polled, counts.other_senders, counts.frames), (Ok(None), 1, 0));
    }
    for altitude_m in [f32::NAN, f32::INFINITY, 1e38, -1e38, 60_001.0, -1_001.0] {
        let (polled, counts) = only(frame((1, 1), altitude_m, 0));
        assert_eq!((polled, counts.implausible), (Err(SensorError::OutOfRange), 1), "{altitude_m}");
    }
}

/// A signed frame counts. One with an unknown flag must be discarded: it may mean anything.
#[test]
fn a_frame_with_an_unknown_flag_is_discarded() {
    for (flags, altitude_m) in [(0x00, Some(2_000.0)), (0x01, Some(2_000.0)), (0x02, None), (0x81, None)] {
        let mut bytes = flagged(flags, (1, 1), 2_000.0, 0);
        // The signature.
        bytes.extend([7; 13]);
        let mut driver = Umbilical::new(Line(bytes), Sender::FIRST_AUTOPILOT);
        assert_eq!(driver.poll(0), Ok(altitude_m), "{flags:#x}");
        let frames = u32::from(altitude_m.is_some());
        assert_eq!((driver.link_counts().frames, driver.link_counts().bad_frames), (frames, 0), "{flags:#x}");
    }
}

/// A line that delivers exactly these bytes.
struct Line(Vec<u8>);

impl ErrorType for Line {
    type Error = Infallible;
}

impl ReadReady for Line {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.is_empty())
    }
}

impl Read for Line {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let count = buffer.len().min(self.0.len());
        for (slot, byte) in buffer.iter_mut().zip(self.0.drain(..count)) {
            *slot = byte;
        }
        Ok(count)
    }
}

/// A second without an altitude is no silence yet. After it the silence is reported once a second, whatever
/// the time of the poll.
#[test]
fn more_than_a_second_of_silence_is_said_once_a_second() {
    let mut driver = Umbilical::new(Line(frame((1, 1), 2_000.0, 0)), Sender::FIRST_AUTOPILOT);
    assert_eq!(driver.poll(0), Ok(Some(2_000.0)));
    assert_eq!(driver.poll(SILENT_AFTER_US), Ok(None));
    for complaint_us in [SILENT_AFTER_US + 1_234, 3 * SILENT_AFTER_US] {
        assert_eq!(driver.poll(complaint_us), Err(SensorError::Stale));
        assert_eq!(driver.poll(complaint_us + SILENT_AFTER_US), Ok(None));
    }
}

/// What arrives in a tick: a fix, a pressure, a message of the mother ship.
#[derive(Clone, Copy, Default)]
struct Comes {
    fix: bool,
    pressure: bool,
    message: bool,
}

/// Altitudes of the mother ship that a suite delivers, tick by tick.
fn heard(ticks: &[Comes]) -> (Vec<Option<f32>>, LinkCounts) {
    let mut suite = Suite::new(
        Replay::<GpsFix>::new(),
        Replay::<BarometerSample>::new(),
        Replay::<ImuSample>::new(),
        Umbilical::new(Line(Vec::new()), Sender::FIRST_AUTOPILOT),
        Replay::<f32>::new(),
        Replay::<VehicleState>::new(),
        ReplayUmbilical::new(),
    );
    let heard = ticks.iter().enumerate().map(|(tick, &Comes { fix, pressure, message })| {
        suite.receiver.load(fix.then(GpsFix::default));
        suite.barometer.load(pressure.then_some(BarometerSample {
            reading: Some(BaroReading::PressurePa(90_000.0)),
            temperature_c: None,
        }));
        if message {
            suite.imu_master.port_mut().0.extend(frame((1, 1), tick as f32, 0));
        }
        suite.poll(5_000 * tick as u64).imu_master_altitude_m
    });
    let heard = heard.collect();
    assert!(
        suite.imu_master.port_mut().0.is_empty(),
        "what arrives is taken at every tick: no ring runs over"
    );
    (heard, suite.imu_master.link_counts())
}

/// A tick with a fix or a pressure is expensive enough without a message. The next tick takes it, and nothing
/// is lost.
#[test]
fn a_message_in_an_expensive_tick_waits_for_the_next_tick() {
    let none = Comes::default();
    let message = Comes { message: true, ..none };
    for expensive in [Comes { fix: true, ..none }, Comes { pressure: true, ..none }] {
        let both = Comes { message: true, ..expensive };
        assert_eq!(heard(&[both, none, message]).0, [None, Some(0.0), Some(2.0)]);
        assert_eq!(heard(&[none, expensive, message]).0, [None, None, Some(2.0)]);
        let (altitudes, counts) = heard(&[message, both, message, none]);
        assert_eq!(altitudes, [Some(0.0), None, Some(2.0), None]);
        assert_eq!((counts.frames, counts.superseded, counts.bytes), (3, 1, 3 * LONGEST as u32));
    }
}

/// Where every tick is expensive, there is no better tick to wait for.
#[test]
fn no_message_waits_twice() {
    let (fix, pressure) = (
        Comes { fix: true, message: true, pressure: false },
        Comes { pressure: true, message: true, fix: false },
    );
    for ticks in [[fix; 4], [pressure; 4], [pressure, fix, pressure, fix]] {
        assert_eq!(heard(&ticks).0, [None, Some(1.0), Some(2.0), Some(3.0)]);
    }
}
