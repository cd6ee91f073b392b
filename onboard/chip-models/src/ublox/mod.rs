//! u-blox satellite receiver at the other end of a UART: NAV-PVT, the configuration messages and their
//! acknowledgements, the NMEA sentences that a receiver starts with, and the speed of the line.
//!
//! Interface description UBX-22008968 (generation 9), receiver description UBX-13003221 (generation 8).

mod frame;

use core::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use frame::{Fletcher, Incoming};
use heapless::Deque;

use crate::disturbance::Disturbance;
use crate::line::Line;
use crate::source::Source;

/// Time from power-on to the first byte, microseconds.
const BOOT_US: u64 = 500_000;
/// Output of an unconfigured receiver at each epoch (interface description, section 2.7: GGA, GLL, GSA, GSV,
/// RMC and VTG are on), with 16 satellites of two systems: 646 bytes.
const NMEA: [&[u8]; 11] = [
    b"$GNRMC,092725.00,A,4717.11399,N,00833.91590,E,0.004,77.52,091202,,,A*4A\r\n",
    b"$GNVTG,77.52,T,,M,0.004,N,0.008,K,A*18\r\n",
    b"$GNGGA,092725.00,4717.11399,N,00833.91590,E,1,12,1.01,499.6,M,48.0,M,,*4E\r\n",
    b"$GNGSA,A,3,23,29,07,08,09,18,26,28,,,,,1.94,1.18,1.54*13\r\n",
    b"$GNGSA,A,3,65,66,72,81,82,88,,,,,,,1.94,1.18,1.54*1D\r\n",
    b"$GPGSV,3,1,10,23,38,230,44,29,71,156,47,07,29,116,41,08,09,081,36*7F\r\n",
    b"$GPGSV,3,2,10,09,40,303,42,18,53,049,45,26,05,022,33,28,14,317,38*71\r\n",
    b"$GPGSV,3,3,10,10,07,189,,05,05,220,*7E\r\n",
    b"$GLGSV,2,1,06,65,21,049,38,66,60,108,44,72,18,343,36,81,27,310,40*6E\r\n",
    b"$GLGSV,2,2,06,82,53,246,43,88,11,177,35*6F\r\n",
    b"$GNGLL,4717.11399,N,00833.91590,E,092725.00,A,A*76\r\n",
];
/// Longest span that is simulated epoch by epoch, microseconds.
const LONGEST_SPAN_US: u64 = 10_000_000;
/// Number of solutions that can wait for their latency to pass.
const WAITING: usize = 16;
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
    /// Vertical accuracy, metres; `f32::INFINITY` if not known.
    pub vertical_accuracy_m: f32,
    /// Accuracy of the velocity, m/s; `f32::INFINITY` if not known.
    pub speed_accuracy_mps: f32,
    /// Satellites used.
    pub satellites: u8,
    /// fixType: 3 is three-dimensional.
    pub fix_type: u8,
}

/// Present faults of the receiver. Its line has faults of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// The receiver refuses every configuration message.
    pub refuses: bool,
    /// The receiver obeys but does not acknowledge.
    pub silent: bool,
    /// It has no fix, and its solutions report that.
    pub no_fix: bool,
    /// It repeats its last solution, with the time of that solution.
    pub held: bool,
}

/// A receiver that has started cold: its altitude is wrong at first, and the error decays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColdStart {
    /// Remaining error, metres.
    pub error_m: f32,
    /// Time constant of the decay, seconds.
    pub decay_s: f32,
    /// Whether the receiver's accuracy estimate includes the error.
    pub is_honest: bool,
}

#[derive(Clone, Copy, Debug)]
struct Settings {
    solutions: bool,
    ubx: bool,
    nmea: bool,
    period_us: u64,
    /// Configured speed; `None`: the line's, which is stored in the receiver.
    baud: Option<u32>,
}

/// NMEA once a second, no solutions by UBX.
const DEFAULT: Settings =
    Settings { solutions: false, ubx: true, nmea: true, period_us: 1_000_000, baud: None };
/// Number of settings that [`ReceiverModel::flip_setting`] can flip.
const SETTINGS: u8 = 3;

/// The receiver and its line.
#[derive(Clone, Debug)]
pub struct ReceiverModel<Surroundings> {
    /// Its solutions, sampled at the navigation epochs; `None` if this epoch has no new one.
    pub solutions: Surroundings,
    /// Present faults.
    pub faults: Faults,
    /// Errors of its solutions: altitude (bits of its millimetres), and the velocity north, east, down.
    pub disturbance: Disturbance,
    /// The error of a cold start, if any.
    pub cold_start: Option<ColdStart>,
    /// Its line to the flight computer.
    pub line: Line,
    /// Time from the epoch of a solution to its first byte, microseconds.
    pub latency_us: u64,
    /// Time of week at time 0, ms.
    pub time_of_week_ms: u64,
    /// Solutions of [`Self::solve`] that were not sent: not configured to, or too many at a time.
    pub unsent_solutions: u32,
    /// Epochs that were skipped in a long span without the time being set.
    pub skipped_epochs: u32,
    /// The last solution that it sent, and its epoch.
    last: Option<(u64, Solution)>,
    generation: u8,
    settings: Settings,
    now_us: u64,
    booted_us: u64,
    epoch_us: u64,
    waiting: Deque<(u64, Solution), WAITING>,
    incoming: Incoming,
}

/// Default time of week at time 0, ms.
pub const TIME_OF_WEEK_MS: u64 = 200_000_000;

impl<Surroundings: Source<Option<Solution>>> ReceiverModel<Surroundings> {
    /// A receiver of generation 8, or of 9 and later, just powered on, at a line speed in baud.
    pub const fn new(generation: u8, baud: u32, solutions: Surroundings) -> Self {
        Self {
            solutions,
            faults: Faults { refuses: false, silent: false, no_fix: false, held: false },
            disturbance: Disturbance::NONE,
            cold_start: None,
            last: None,
            line: Line::new(baud),
            latency_us: 50_000,
            time_of_week_ms: TIME_OF_WEEK_MS,
            unsent_solutions: 0,
            skipped_epochs: 0,
            generation,
            settings: DEFAULT,
            now_us: 0,
            booted_us: BOOT_US,
            epoch_us: BOOT_US,
            waiting: Deque::new(),
            incoming: Incoming::new(),
        }
    }

    /// Lets time pass up to `now_us`, microseconds, which never goes backward: the receiver computes and the
    /// line carries. Of a span longer than `LONGEST_SPAN_US` only the end is simulated, because nothing read
    /// the line meanwhile.
    pub fn set_time(&mut self, now_us: u64) {
        self.now_us = now_us;
        if let Some(beyond_us) = now_us.saturating_sub(self.epoch_us).checked_sub(LONGEST_SPAN_US) {
            let skipped = beyond_us / self.settings.period_us;
            self.epoch_us += skipped * self.settings.period_us;
            self.skipped_epochs =
                self.skipped_epochs.saturating_add(u32::try_from(skipped).unwrap_or(u32::MAX));
        }
        while self.epoch_us.saturating_add(self.latency_us) <= now_us {
            let epoch_us = self.epoch_us;
            if self.settings.solutions
                && let Some(solution) = self.solutions.at(epoch_us)
            {
                self.send_solution(epoch_us, solution);
            }
            if self.settings.nmea {
                self.send_sentences();
            }
            self.epoch_us = epoch_us + self.settings.period_us;
        }
        while let Some((epoch_us, solution)) = self.waiting.front().copied()
            && epoch_us.saturating_add(self.latency_us) <= now_us
        {
            let _ = self.waiting.pop_front();
            self.send_solution(epoch_us, solution);
        }
        self.line.carry_until(now_us);
    }

    /// Adds a navigation epoch now, beside those of the receiver's own raster, for replaying a flight fix by
    /// fix.
    pub fn solve(&mut self, solution: Solution) {
        let told = self.settings.solutions
            && self.now_us >= self.booted_us
            && self.waiting.push_back((self.now_us, solution)).is_ok();
        if !told {
            self.unsent_solutions = self.unsent_solutions.saturating_add(1);
        }
    }

    /// Powers it on now, microseconds, instead of at time 0.
    pub fn power_on(&mut self, now_us: u64) {
        self.now_us = now_us;
        self.power_dip();
        self.line.carry_until(now_us);
    }

    /// Models a dip of its power: its configuration and what was on the line are lost.
    pub fn power_dip(&mut self) {
        self.settings = DEFAULT;
        self.last = None;
        self.waiting.clear();
        self.line.cut();
        self.incoming = Incoming::new();
        self.booted_us = self.now_us.saturating_add(BOOT_US);
        self.epoch_us = self.booted_us;
    }

    /// Replaces it by one of that generation, with a line of that speed in baud, just powered on.
    pub fn exchange_for(&mut self, generation: u8, baud: u32) {
        self.generation = generation;
        self.line.set_baud(baud);
        self.power_dip();
    }

    /// Flips one of its settings: 0 whether it sends solutions, 1 whether it sends NMEA, 2 its rate, from the
    /// configured one to once a second. Returns whether there is such a setting.
    pub fn flip_setting(&mut self, setting: u8) -> bool {
        match setting {
            0 => self.settings.solutions = !self.settings.solutions,
            1 => self.settings.nmea = !self.settings.nmea,
            2 => self.settings.period_us = DEFAULT.period_us,
            _ => {}
        }
        setting < SETTINGS
    }

    /// Sends the default sentences. A sentence that finds no room is dropped, as every message is.
    fn send_sentences(&mut self) {
        for sentence in NMEA {
            if self.is_at_the_lines_speed() && self.line.has_room(sentence.len()) {
                self.inject(sentence);
            }
        }
    }

    /// Bytes at another speed than the board's are lost.
    fn is_at_the_lines_speed(&self) -> bool {
        self.settings.baud.is_none_or(|baud| baud == self.line.baud())
    }

    /// Puts bytes on the line as if the receiver had sent them.
    pub fn inject(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.line.send(byte));
    }

    /// Sends a message. Returns whether it could.
    fn send(&mut self, class: u8, id: u8, payload: &[u8]) -> bool {
        if !self.settings.ubx || !self.is_at_the_lines_speed() || !self.line.has_room(payload.len() + 8) {
            return false;
        }
        let [low, high] = u16::try_from(payload.len()).unwrap_or_default().to_le_bytes();
        let mut sum = Fletcher::default();
        self.inject(&[0xB5, 0x62]);
        for &byte in [class, id, low, high].iter().chain(payload) {
            sum.add(byte);
            self.line.send(byte);
        }
        self.inject(&sum.bytes());
        true
    }

    /// A solution with the receiver's faults, and its epoch.
    fn disturbed(&mut self, epoch_us: u64, mut solution: Solution) -> (u64, Solution) {
        if let Some((last_us, last)) = self.last
            && (self.faults.held || self.disturbance.frozen)
        {
            return (if self.faults.held { last_us } else { epoch_us }, last);
        }
        if self.faults.no_fix {
            solution.fix_type = 0;
        }
        let mut error_m = self.disturbance.error(0);
        if let Some(cold) = &mut self.cold_start {
            let since_s =
                self.last.map_or(0.0, |(last_us, _)| epoch_us.saturating_sub(last_us) as f32 * 1e-6);
            cold.error_m -= cold.error_m * (since_s / cold.decay_s).min(1.0);
            error_m += cold.error_m;
            if cold.is_honest {
                solution.vertical_accuracy_m += cold.error_m.abs();
            }
        }
        solution.ellipsoid_m += error_m;
        solution.mean_sea_level_m += error_m;
        for (index, velocity) in solution.velocity_ned_mps.iter_mut().enumerate() {
            *velocity += self.disturbance.error(1 + index);
        }
        self.last = Some((epoch_us, solution));
        (epoch_us, solution)
    }

    /// Sends NAV-PVT (section 3.15.11). Fields that are not modelled are 0.
    fn send_solution(&mut self, epoch_us: u64, solution: Solution) {
        let (epoch_us, solution) = self.disturbed(epoch_us, solution);
        let flipped = self.disturbance.flipped(0).cast_signed();
        let mut payload = [0u8; 92];
        let mut put = |at: usize, value: &[u8]| {
            for (slot, byte) in payload.iter_mut().skip(at).zip(value) {
                *slot = *byte;
            }
        };
        let time_of_week_ms = (self.time_of_week_ms + epoch_us / 1_000) % WEEK_MS;
        put(0, &u32::try_from(time_of_week_ms).unwrap_or_default().to_le_bytes());
        put(20, &[solution.fix_type, u8::from(solution.fix_type >= 2), 0, solution.satellites]);
        put(32, &(millis(solution.ellipsoid_m) ^ flipped).to_le_bytes());
        put(36, &(millis(solution.mean_sea_level_m) ^ flipped).to_le_bytes());
        put(44, &accuracy(solution.vertical_accuracy_m).to_le_bytes());
        put(68, &accuracy(solution.speed_accuracy_mps).to_le_bytes());
        for (index, velocity) in solution.velocity_ned_mps.into_iter().enumerate() {
            put(48 + 4 * index, &millis(velocity).to_le_bytes());
        }
        if !self.send(0x01, 0x07, &payload) {
            self.unsent_solutions = self.unsent_solutions.saturating_add(1);
        }
    }

    fn obey(&mut self, class: u8, id: u8, payload: &[u8]) {
        let obeyed = !self.faults.refuses && class == 0x06 && self.configure(id, payload);
        if class == 0x06 && !self.faults.silent {
            let _ = self.send(0x05, u8::from(obeyed), &[class, id]);
        }
    }

    /// Applies a configuration message. Returns whether this receiver knows it and could apply it.
    fn configure(&mut self, id: u8, payload: &[u8]) -> bool {
        let mut settings = self.settings;
        let known = match (id, payload) {
            (0x8A, [0, _, _, _, keys @ ..]) if self.generation >= 9 => set_keys(&mut settings, keys),
            (0x08, [low, high, ..]) => set_period(&mut settings, [*low, *high]),
            (0x24, payload) => payload.len() == 36,
            (0x00, payload) if self.generation < 9 => set_port(&mut settings, payload),
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

/// Applies CFG-VALSET's pairs of key and value. The size of a value is in its key (section 4.2).
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
            (0x3021_0002 | 0x2011_0021, _) => true,
            (0x1074_0001, [on]) => {
                settings.ubx = *on != 0;
                true
            }
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

/// Applies CFG-PRT of the first UART (receiver description, section 32.10.25): its speed, and its output.
fn set_port(settings: &mut Settings, payload: &[u8]) -> bool {
    let &[port, _, _, _, _, _, _, _, b0, b1, b2, b3, _, _, protocols, _, _, _, _, _] = payload else {
        return false;
    };
    settings.baud = Some(u32::from_le_bytes([b0, b1, b2, b3]));
    settings.ubx = protocols & 1 != 0;
    settings.nmea = protocols & 2 != 0;
    port == 1
}

/// Sets the period. 25 ms is the shortest that any receiver of these generations accepts.
fn set_period(settings: &mut Settings, period_ms: [u8; 2]) -> bool {
    settings.period_us = u64::from(u16::from_le_bytes(period_ms)) * 1_000;
    settings.period_us >= 25_000
}

/// Metres to millimetres, to the nearest; all ones for values beyond 32 bits, which a receiver sends for "not
/// known".
fn accuracy(value: f32) -> u32 {
    // A cast of a float saturates.
    (value * 1_000.0 + 0.5) as u32
}

/// Metres to millimetres, to the nearest.
fn millis(value: f32) -> i32 {
    let scaled = value * 1_000.0;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

impl<Surroundings> ErrorType for ReceiverModel<Surroundings> {
    type Error = Infallible;
}

impl<Surroundings: Source<Option<Solution>>> ReadReady for ReceiverModel<Surroundings> {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.line.has_arrived())
    }
}

impl<Surroundings: Source<Option<Solution>>> Read for ReceiverModel<Surroundings> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.line.read(buffer))
    }
}

impl<Surroundings: Source<Option<Solution>>> WriteReady for ReceiverModel<Surroundings> {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl<Surroundings: Source<Option<Solution>>> Write for ReceiverModel<Surroundings> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            let hears = self.now_us >= self.booted_us && self.is_at_the_lines_speed();
            if self.line.faults.unplugged || !hears {
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
