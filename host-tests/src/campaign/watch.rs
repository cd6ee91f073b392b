//! A flight as observed from outside: what the flight computer publishes at each tick, and the truth.

use flight_computer::Step;
use kf_core::atmosphere::pressure_altitude_m;
use kf_core::input::BaroReading;
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::output::{Phase, TickOutput, Trust};
use kf_core::sensor::{SENSORS, Sensor};
use survival::{RestartReport, Start};
use telemetry::{ComputerStatus, FrameQueue, Link, Rates, Telemetry, TickReport};

/// The reference's bit in [`Seen::fresh`], after the sensors' bits.
pub const REFERENCE: usize = SENSORS;
/// Window over which a sensor's true error is smoothed, seconds: the monitor's.
const SMOOTH_S: f32 = 2.0;
/// Ticks after a restart within which it must be reported: a second.
pub const REPORTING_TICKS: usize = 200;

/// Observations at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Reported trust in each sensor.
    pub trust: [Trust; SENSORS],
    /// Which sensors, and then the reference, delivered a reading that was used: one bit each.
    pub fresh: u8,
    /// True error of each sensor's calibrated reading, over the monitor's window, metres.
    pub true_error_m: [f32; SENSORS],
    /// The monitor's input error, metres, where there was a reading.
    pub error_m: [Option<f32>; SENSORS],
    /// Its moving average, metres, where the error was judged.
    pub average_m: [Option<f32>; SENSORS],
    /// Error of the receiver's altitude, metres, where there was a fix.
    pub fix_error_m: Option<f32>,
}

/// A sensor that is called untrustworthy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flagged {
    /// Tick of the flag.
    pub tick: usize,
    /// True error of its calibrated reading at that tick, over the monitor's window, metres.
    pub true_error_m: f32,
}

/// A start of the flight computer.
#[derive(Clone, Debug, PartialEq)]
pub struct Restarted {
    /// Tick of the start.
    pub tick: usize,
    /// The flight computer's own report.
    pub report: Option<RestartReport>,
    /// Whether the telemetry reported it.
    pub is_reported: bool,
}

/// Observations of a flight.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    /// All ticks of the flight; `None`: the flight computer was away.
    pub ticks: Vec<Option<Seen>>,
    /// Tick at which the launch was confirmed.
    pub launched: Option<usize>,
    /// The first tick at which the wire read open.
    pub first_edge: Option<usize>,
    /// The calibration.
    pub latch: Option<LatchRecord>,
    /// Calibrations that differ from the first.
    pub other_latches: usize,
    /// Sensors called untrustworthy.
    pub flagged: [Option<Flagged>; SENSORS],
    /// All starts after the first.
    pub restarts: Vec<Restarted>,
    /// An invalid number that was published, and its tick.
    pub not_finite: Option<(usize, &'static str)>,
    /// Largest number of operations on ports in a tick.
    pub most_operations: u32,
    /// Message of a panic.
    pub panic: Option<String>,
    /// Number of ticks in standby.
    pub standby_ticks: usize,
    /// Size of the step that was planted, metres.
    pub step_m: Option<f32>,
    smooth: [Option<(f32, usize)>; SENSORS],
    reporting: Option<(RestartReport, Vec<(Step, Counters)>)>,
}

impl Watched {
    /// Notes a tick without a mission.
    pub fn take_nothing(&mut self, stands_by: bool) {
        self.standby_ticks += usize::from(stands_by);
        self.ticks.push(None);
    }

    /// Notes a start.
    pub fn take_restart(&mut self, report: Option<RestartReport>) {
        self.end_reporting();
        let tick = self.ticks.len();
        // Standby has a message of its own, once a second, which `telemetry`'s tests check.
        let is_reported = report.is_some_and(|report| report.start == Start::Standby || report.pause_us > 0);
        self.restarts.push(Restarted { tick, report, is_reported });
        self.reporting = report.filter(|_| !is_reported).map(|report| (report, Vec::new()));
    }

    /// Notes a tick.
    pub fn take(
        &mut self,
        step: &Step,
        latch: Option<&LatchRecord>,
        counters: &Counters,
        altitude_m: f32,
        operations: u32,
    ) {
        let tick = self.ticks.len();
        let Step { input, output } = step;
        if output.phase == Phase::FreeFlight && self.launched.is_none() {
            self.launched = Some(tick);
        }
        match (&self.latch, latch) {
            (None, Some(latch)) => self.latch = Some(latch.clone()),
            (Some(known), Some(latch)) if output.latched_now && known != latch => self.other_latches += 1,
            _ => {}
        }
        self.most_operations = self.most_operations.max(operations);
        if self.not_finite.is_none() {
            self.not_finite = not_finite(output).map(|what| (tick, what));
        }
        let baro_m = input.baro.and_then(|reading| match reading {
            BaroReading::PressurePa(pa) => pressure_altitude_m(pa),
            BaroReading::AltitudeM(metres) => Some(metres),
        });
        let readings_m = [input.imu_master_altitude_m, input.imu_slave_altitude_m, baro_m];
        let mut fresh = u8::from(input.gps.is_some() && output.gps_rejection.is_none()) << REFERENCE;
        for sensor in Sensor::ALL {
            let i = sensor.index();
            let report = &output.sensors[i];
            if let (Some(reading_m), None) = (readings_m[i], report.rejection) {
                fresh |= 1 << i;
                let error_m = reading_m - report.bias_m - altitude_m;
                let (smooth_m, last) = self.smooth[i].unwrap_or((error_m, tick));
                let share = (((tick - last) as f32 * 0.005) / SMOOTH_S).clamp(0.0, 1.0);
                self.smooth[i] = Some((smooth_m + share * (error_m - smooth_m), tick));
            }
            if report.trust == Trust::Untrustworthy && self.flagged[i].is_none() {
                let true_error_m = self.smooth[i].map_or(0.0, |(error_m, _)| error_m);
                self.flagged[i] = Some(Flagged { tick, true_error_m });
            }
        }
        let trust = output.sensors.map(|sensor| sensor.trust);
        let true_error_m = self.smooth.map(|smooth| smooth.map_or(0.0, |(error_m, _)| error_m));
        let error_m = output.sensors.map(|sensor| sensor.error_m);
        let average_m = output.sensors.map(|sensor| sensor.moving_average_m);
        let fix_error_m = input.gps.map(|fix| fix.altitude_m - altitude_m);
        self.ticks.push(Some(Seen { trust, fresh, true_error_m, error_m, average_m, fix_error_m }));
        if let Some((_, steps)) = &mut self.reporting {
            steps.push((step.clone(), *counters));
            if steps.len() >= REPORTING_TICKS {
                self.end_reporting();
            }
        }
    }

    /// Checks whether the last restart was reported.
    pub fn end_reporting(&mut self) {
        if let (Some((report, steps)), Some(last)) = (self.reporting.take(), self.restarts.last_mut()) {
            // A flight computer that is off again before its first tick had no time to report anything.
            last.is_reported = steps.is_empty() || is_reported(&report, &steps, self.latch.as_ref());
        }
    }

    /// Reported trust in a sensor at a tick, if the flight computer was there.
    #[must_use]
    pub fn trust(&self, sensor: Sensor, tick: usize) -> Option<Trust> {
        self.ticks.get(tick).copied().flatten().map(|seen| seen.trust[sensor.index()])
    }

    /// Longest time without a used reading of a sensor or the reference, in ticks from `from` to `to`.
    #[must_use]
    pub fn longest_gap(&self, source: usize, from: usize, to: usize) -> usize {
        let is_fresh = |tick: &usize| {
            self.ticks.get(*tick).copied().flatten().is_some_and(|seen| seen.fresh & 1 << source != 0)
        };
        let mut last = (0..from).rev().find(is_fresh).unwrap_or(from);
        let mut longest = 0;
        for tick in from..to {
            if is_fresh(&tick) {
                longest = longest.max(tick - last);
                last = tick;
            }
        }
        longest.max(to.saturating_sub(last))
    }

    /// Mean error of the receiver's altitude over the monitor's window before a tick, metres; zero without a
    /// fix.
    #[must_use]
    pub fn fix_error_m(&self, tick: usize) -> f32 {
        let from = tick.saturating_sub((SMOOTH_S * 200.0) as usize);
        let seen = self.ticks.get(from..=tick).unwrap_or_default().iter().flatten();
        let (sum_m, count) = seen
            .filter_map(|seen| seen.fix_error_m)
            .fold((0.0, 0.0), |(sum_m, count), error_m| (sum_m + error_m, count + 1.0));
        sum_m / f32::max(count, 1.0)
    }

    /// Number of ticks of free flight at which a sensor was not monitored.
    #[must_use]
    pub fn unmonitored(&self, sensor: Sensor) -> usize {
        self.ticks.iter().flatten().filter(|seen| seen.trust[sensor.index()] == Trust::Unmonitored).count()
    }
}

fn not_finite(output: &TickOutput) -> Option<&'static str> {
    let is_bad = |value: f32| !value.is_finite();
    if is_bad(output.altitude_m) || is_bad(output.altitude_variance_m2) {
        return Some("altitude");
    }
    if output.sensors.iter().any(|sensor| is_bad(sensor.bias_m) || is_bad(sensor.bias_variance_m2)) {
        return Some("bias");
    }
    let optional = output
        .sensors
        .iter()
        .flat_map(|sensor| [sensor.innovation_m, sensor.signed_nis, sensor.error_m, sensor.moving_average_m]);
    if optional.flatten().any(is_bad) {
        return Some("error");
    }
    let check =
        output.cross_check.is_some_and(|check| is_bad(check.difference_m) || is_bad(check.moving_average_m));
    check.then_some("cross-check")
}

/// Whether the telemetry of these ticks reports a start.
fn is_reported(report: &RestartReport, steps: &[(Step, Counters)], latch: Option<&LatchRecord>) -> bool {
    let mut queue = FrameQueue::new();
    let (frames, mut line) = queue.split();
    let mut telemetry = Telemetry::new(Link::new(frames), Rates::FULL, &[]);
    telemetry.note_start(report);
    let words: &[&[u8]] = &[b"restart", b"cold start", b"standby"];
    for (step, counters) in steps {
        let report = TickReport { input: &step.input, output: &step.output, latch, counters };
        telemetry.tick(&report, &ComputerStatus::default());
        while let Some(frame) = line.dequeue() {
            let bytes = frame.bytes();
            if words.iter().any(|word| bytes.windows(word.len()).any(|part| part == *word)) {
                return true;
            }
        }
    }
    false
}
