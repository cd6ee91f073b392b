//! u-blox satellite receiver at the other end of a UART: NAV-PVT, the configuration messages and their
//! acknowledgements, the NMEA chatter that a receiver starts with, and the speed of the line.
//!
//! Interface description UBX-22008968 (generation 9), receiver description UBX-13003221 (generation 8).

mod frame;

use core::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use frame::{Fletcher, Incoming};
use heapless::Deque;

use crate::source::Source;

/// From power to the first byte, microseconds.
const BOOT_US: u64 = 500_000;
/// What a sentence of a receiver that nobody has configured yet looks like.
const NMEA: &[u8] = b"$GNGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B\r\n";
/// What waits in the receiver, and in the UART's buffer of the flight computer.
const BUFFER_BYTES: usize = 512;
/// A week, ms.
const WEEK_MS: u64 = 604_800_000;

/// A navigation solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Height above the ellipsoid, metres.
    pub ellipsoid_m: f32,
    /// Height above mean sea level, metres.
    pub mean_sea_level_m: f32,
    /// North, east, down, m/s.
    pub velocity_ned_mps: [f32; 3],
    /// Vertical accuracy, metres.
    pub vertical_accuracy_m: f32,
    /// Satellites used.
    pub satellites: u8,
    /// fixType: 3 is three-dimensional.
    pub fix_type: u8,
}

/// What is wrong with the receiver or its line at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Nothing passes, either way.
    pub unplugged: bool,
    /// Bytes to lose, counted down: the next ones that the receiver sends.
    pub lose_bytes: u32,
    /// A byte to damage: after so many more, these bits.
    pub flip_bits: Option<(u32, u8)>,
    /// The receiver refuses every configuration message.
    pub refuses: bool,
    /// The receiver obeys and does not acknowledge.
    pub silent: bool,
}

#[derive(Clone, Copy, Debug)]
struct Settings {
    solutions: bool,
    nmea: bool,
    period_us: u64,
}

/// As it leaves the factory: NMEA once a second, no UBX.
const DEFAULT: Settings = Settings { solutions: false, nmea: true, period_us: 1_000_000 };

/// The receiver and its line.
#[derive(Clone, Debug)]
pub struct ReceiverModel<Surroundings> {
    /// Its solutions, sampled at the navigation epochs.
    pub solutions: Surroundings,
    /// What is wrong at present.
    pub faults: Faults,
    /// From the epoch of a solution to its first byte, microseconds.
    pub latency_us: u64,
    /// Time of week at time 0, ms.
    pub time_of_week_ms: u64,
    /// Bytes that the flight computer was too slow to take.
    pub overrun_bytes: u32,
    generation: u8,
    byte_time_ns: u64,
    settings: Settings,
    now_us: u64,
    booted_us: u64,
    epoch_us: u64,
    line_free_ns: u64,
    outgoing: Deque<u8, BUFFER_BYTES>,
    arrived: Deque<u8, BUFFER_BYTES>,
    incoming: Incoming,
}

impl<Surroundings: Source<Solution>> ReceiverModel<Surroundings> {
    /// A receiver of generation 8, or of 9 and later, that has just got power, at a line speed in baud.
    pub fn new(generation: u8, baud: u32, solutions: Surroundings) -> Self {
        Self {
            solutions,
            faults: Faults::default(),
            latency_us: 50_000,
            time_of_week_ms: 200_000_000,
            overrun_bytes: 0,
            generation,
            // A start bit, 8 bits, a stop bit.
            byte_time_ns: 10_000_000_000 / u64::from(baud.max(1)),
            settings: DEFAULT,
            now_us: 0,
            booted_us: BOOT_US,
            epoch_us: BOOT_US,
            line_free_ns: 0,
            outgoing: Deque::new(),
            arrived: Deque::new(),
            incoming: Incoming::new(),
        }
    }

    /// Lets time pass: the receiver computes, the line carries. Microseconds, never backward.
    pub fn set_time(&mut self, now_us: u64) {
        self.now_us = now_us;
        while self.epoch_us.saturating_add(self.latency_us) <= now_us {
            let epoch_us = self.epoch_us;
            if self.settings.solutions {
                let solution = self.solutions.at(epoch_us);
                self.send_solution(epoch_us, solution);
            }
            if self.settings.nmea && epoch_us % 1_000_000 < self.settings.period_us {
                NMEA.iter().for_each(|&byte| self.send_byte(byte));
            }
            self.epoch_us = epoch_us + self.settings.period_us;
        }
        while self.line_free_ns + self.byte_time_ns <= now_us * 1_000 {
            match self.outgoing.pop_front() {
                Some(byte) => {
                    self.line_free_ns += self.byte_time_ns;
                    self.carry(byte);
                }
                None => self.line_free_ns = now_us * 1_000,
            }
        }
    }

    /// Power dips: what it was told is forgotten, what was on the line is lost.
    pub fn power_dip(&mut self) {
        self.settings = DEFAULT;
        self.outgoing.clear();
        self.incoming = Incoming::new();
        self.booted_us = self.now_us + BOOT_US;
        self.epoch_us = self.booted_us;
    }

    /// Puts bytes on the line as if the receiver had sent them.
    pub fn inject(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.send_byte(byte));
    }

    fn send_byte(&mut self, byte: u8) {
        // A receiver whose buffer is full drops what it can not send.
        let _ = self.outgoing.push_back(byte);
    }

    fn carry(&mut self, byte: u8) {
        if self.faults.unplugged {
            return;
        }
        if self.faults.lose_bytes > 0 {
            self.faults.lose_bytes -= 1;
            return;
        }
        let byte = match &mut self.faults.flip_bits {
            Some((0, mask)) => {
                let flipped = byte ^ *mask;
                self.faults.flip_bits = None;
                flipped
            }
            Some((after, _)) => {
                *after -= 1;
                byte
            }
            None => byte,
        };
        if self.arrived.push_back(byte).is_err() {
            self.overrun_bytes += 1;
        }
    }

    fn send(&mut self, class: u8, id: u8, payload: &[u8]) {
        let [low, high] = u16::try_from(payload.len()).unwrap_or_default().to_le_bytes();
        let mut sum = Fletcher::default();
        self.inject(&[0xB5, 0x62]);
        for &byte in [class, id, low, high].iter().chain(payload) {
            sum.add(byte);
            self.send_byte(byte);
        }
        self.inject(&sum.bytes());
    }

    /// NAV-PVT (section 3.15.11): what is not modelled is 0.
    fn send_solution(&mut self, epoch_us: u64, solution: Solution) {
        let mut payload = [0u8; 92];
        let mut put = |at: usize, value: &[u8]| {
            for (slot, byte) in payload.iter_mut().skip(at).zip(value) {
                *slot = *byte;
            }
        };
        let time_of_week_ms = (self.time_of_week_ms + epoch_us / 1_000) % WEEK_MS;
        put(0, &u32::try_from(time_of_week_ms).unwrap_or_default().to_le_bytes());
        put(20, &[solution.fix_type, u8::from(solution.fix_type >= 2), 0, solution.satellites]);
        put(32, &millis(solution.ellipsoid_m).to_le_bytes());
        put(36, &millis(solution.mean_sea_level_m).to_le_bytes());
        put(44, &millis(solution.vertical_accuracy_m).to_le_bytes());
        for (index, velocity) in solution.velocity_ned_mps.into_iter().enumerate() {
            put(48 + 4 * index, &millis(velocity).to_le_bytes());
        }
        self.send(0x01, 0x07, &payload);
    }

    fn obey(&mut self, class: u8, id: u8, payload: &[u8]) {
        let obeyed = !self.faults.refuses && class == 0x06 && self.configure(id, payload);
        if class == 0x06 && !self.faults.silent {
            self.send(0x05, u8::from(obeyed), &[class, id]);
        }
    }

    /// Whether this receiver knows the message and could follow it.
    fn configure(&mut self, id: u8, payload: &[u8]) -> bool {
        let mut settings = self.settings;
        let known = match (id, payload) {
            (0x8A, [0, _, _, _, keys @ ..]) if self.generation >= 9 => set_keys(&mut settings, keys),
            (0x08, [low, high, ..]) => set_period(&mut settings, [*low, *high]),
            (0x24, payload) => payload.len() == 36,
            (0x01, [0x01, 0x07, rate]) => {
                settings.solutions = *rate > 0;
                true
            }
            _ => false,
        };
        if known {
            // A new rate starts a new raster.
            if settings.period_us != self.settings.period_us {
                self.epoch_us = (self.now_us / settings.period_us + 1) * settings.period_us;
            }
            self.settings = settings;
        }
        known
    }
}

/// CFG-VALSET's pairs of key and value; the size of a value is in its key (section 4.2).
fn set_keys(settings: &mut Settings, mut keys: &[u8]) -> bool {
    while let [a, b, c, d, rest @ ..] = keys {
        let key = u32::from_le_bytes([*a, *b, *c, *d]);
        let size = match key >> 28 {
            1 | 2 => 1,
            3 => 2,
            4 => 4,
            5 => 8,
            _ => return false,
        };
        let Some((value, after)) = rest.split_at_checked(size) else { return false };
        let known = match (key, value) {
            (0x1074_0001 | 0x3021_0002 | 0x2011_0021, _) => true,
            (0x1074_0002, [on]) => {
                settings.nmea = *on != 0;
                true
            }
            (0x3021_0001, [low, high]) => set_period(settings, [*low, *high]),
            (0x2091_0007, [rate]) => {
                settings.solutions = *rate > 0;
                true
            }
            _ => false,
        };
        if !known {
            return false;
        }
        keys = after;
    }
    keys.is_empty()
}

/// 25 ms is the fastest that any receiver of these generations takes.
fn set_period(settings: &mut Settings, period_ms: [u8; 2]) -> bool {
    settings.period_us = u64::from(u16::from_le_bytes(period_ms)) * 1_000;
    settings.period_us >= 25_000
}

/// Metres to millimetres, to the nearest.
fn millis(value: f32) -> i32 {
    let scaled = value * 1_000.0;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

impl<Surroundings> ErrorType for ReceiverModel<Surroundings> {
    type Error = Infallible;
}

impl<Surroundings: Source<Solution>> ReadReady for ReceiverModel<Surroundings> {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.arrived.is_empty())
    }
}

impl<Surroundings: Source<Solution>> Read for ReceiverModel<Surroundings> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        for slot in buffer {
            let Some(byte) = self.arrived.pop_front() else { break };
            *slot = byte;
            count += 1;
        }
        Ok(count)
    }
}

impl<Surroundings: Source<Solution>> WriteReady for ReceiverModel<Surroundings> {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl<Surroundings: Source<Solution>> Write for ReceiverModel<Surroundings> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            if self.faults.unplugged || self.now_us < self.booted_us {
                continue;
            }
            if let Some(arrived) = self.incoming.take(byte) {
                self.obey(arrived.class, arrived.id, arrived.payload());
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
