//! Turns ticks into messages.

use heapless::Vec;
use kf_core::atmosphere::pressure_altitude_m;
use kf_core::config::MAX_ESTIMATED_EFFECTS;
use kf_core::effect::EffectId;
use kf_core::input::{BaroReading, LaunchDoubt, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::launch::WireCondition;
use kf_core::mission::Counters;
use kf_core::output::{Agreement, Phase, Rejection, TickOutput, Trust};
use kf_core::sensor::SENSORS;

use crate::event::Events;
use crate::link::{Link, LinkCounts, MessageKind, Priority};
use crate::message::{self, SensorBits, SysStatus, boot_ms};
use crate::named::{self, Name};
use crate::rates::Rates;
use crate::sample::Sample;
use crate::schedule::{Due, Schedule, Slot};
use crate::status::ComputerStatus;

mod occasions;
mod turns;
mod watch;

use turns::Turn;
use watch::Watch;

/// Longest wait of HIGHRES_IMU, at rates with a period, for a barometer's sample; then it is sent without
/// one, microseconds.
const BAROMETER_PATIENCE_US: u64 = 100_000;
/// Age beyond which a fix is no longer used as the vehicle's altitude, milliseconds.
const FIX_LIFE_MS: u32 = 2_000;

/// Number of sources: inertial unit and barometer, two inertial altitudes, the receiver.
const SOURCES: u8 = 4;

/// Input and output of a tick of the mission.
#[derive(Clone, Copy, Debug)]
pub struct TickReport<'a> {
    /// The tick's input.
    pub input: &'a TickInput,
    /// The tick's output.
    pub output: &'a TickOutput,
    /// The calibration, once it is latched.
    pub latch: Option<&'a LatchRecord>,
    /// The mission's counts.
    pub counters: &'a Counters,
}

/// The flight computer's telemetry. The work of a tick is bounded: its samples and its fix, and one other
/// message.
pub struct Telemetry<'a> {
    link: Link<'a>,
    rates: Rates,
    effects: Vec<EffectId, MAX_ESTIMATED_EFFECTS>,
    schedule: Schedule,
    samples_due: Due,
    altitudes_due: [Due; 2],
    fix_due: Due,
    first_source: u8,
    announcement_due: Due,
    clock_is_internal: bool,
    events: Events,
    watch: Watch,
    turns: [Turn; 2],
    counts_at_status: LinkCounts,
    launch: Option<bool>,
    launch_doubt: LaunchDoubt,
    wire: Option<WireCondition>,
    agreement: Agreement,
    phase: Option<Phase>,
    trust: [Trust; SENSORS],
    barometer: Sample<BaroReading>,
    fix_m: Sample<f32>,
    attitude: Sample<([f32; 3], Option<[f32; 3]>)>,
    airspeed: Sample<f32>,
    angle_of_attack: Sample<f32>,
    sideslip: Sample<f32>,
    throttle: Sample<f32>,
    outside_air: Sample<f32>,
    errors: [Sample<f32>; SENSORS],
    averages: [Sample<f32>; SENSORS],
    innovation: Sample<f32>,
}

impl<'a> Telemetry<'a> {
    /// Telemetry on that link. `effects` are the estimated effects in the model's order; those beyond
    /// [`MAX_ESTIMATED_EFFECTS`], which no model has, are omitted.
    #[must_use]
    pub fn new(link: Link<'a>, rates: Rates, effects: &[EffectId]) -> Self {
        let mut known = Vec::new();
        for id in effects {
            if known.push(*id).is_err() {
                break;
            }
        }
        Self {
            counts_at_status: *link.counts(),
            link,
            rates,
            effects: known,
            schedule: Schedule::new(),
            samples_due: Due::NOW,
            altitudes_due: [Due::NOW; 2],
            fix_due: Due::NOW,
            first_source: 0,
            announcement_due: Due::NOW,
            clock_is_internal: false,
            events: Events::new(),
            watch: Watch::new(),
            turns: [Turn::ERRORS, Turn::SLOW],
            launch: None,
            launch_doubt: LaunchDoubt::None,
            wire: None,
            agreement: Agreement::Agree,
            phase: None,
            trust: [Trust::Calibrating; SENSORS],
            barometer: Sample::NONE,
            fix_m: Sample::NONE,
            attitude: Sample::NONE,
            airspeed: Sample::NONE,
            angle_of_attack: Sample::NONE,
            sideslip: Sample::NONE,
            throttle: Sample::NONE,
            outside_air: Sample::NONE,
            errors: [Sample::NONE; SENSORS],
            averages: [Sample::NONE; SENSORS],
            innovation: Sample::NONE,
        }
    }

    /// Counts of queued and dropped frames.
    #[must_use]
    pub const fn counts(&self) -> &LinkCounts {
        self.link.counts()
    }

    /// Takes a tick's report and queues the messages that are due. A tick that was out of order only counts.
    #[inline(never)]
    pub fn tick(&mut self, report: &TickReport<'_>, computer: &ComputerStatus) {
        let now_us = report.input.time_us;
        if report.output.out_of_order {
            return;
        }
        let now_ms = boot_ms(now_us);
        self.hold(report, now_ms);
        self.note_events(report, now_us);
        self.note_wire(computer.wire, now_us);
        // The sources take turns; otherwise the first of them would take all of a full line.
        for k in 0..SOURCES {
            self.send_source((self.first_source + k) % SOURCES, report, now_us, now_ms);
        }
        self.first_source = (self.first_source + 1) % SOURCES;
        let Some(slot) = self.schedule.next(now_us, |slot| self.has(slot)) else { return };
        let wait_us = if self.send_slot(slot, report, computer, now_ms) { self.period_us(slot) } else { 0 };
        self.schedule.sent(slot, now_us, wait_us);
    }

    /// Keeps values that may be sent later.
    fn hold(&mut self, report: &TickReport<'_>, now_ms: u32) {
        let TickReport { input, output, .. } = report;
        let signals = &input.signals;
        self.watch.take(report, now_ms);
        self.barometer.take(now_ms, input.baro);
        let rates_radps = input.imu.as_ref().map(|imu| imu.gyro_radps);
        self.attitude.take(now_ms, signals.attitude_rad.map(|attitude_rad| (attitude_rad, rates_radps)));
        self.airspeed.take(now_ms, signals.true_airspeed_mps);
        self.angle_of_attack.take(now_ms, signals.angle_of_attack_rad);
        self.sideslip.take(now_ms, signals.sideslip_rad);
        self.throttle.take(now_ms, signals.throttle);
        self.outside_air.take(now_ms, signals.outside_air_temperature_c);
        self.innovation.take(now_ms, output.gps_innovation_m);
        let sensors = output.sensors.iter().zip(&mut self.errors).zip(&mut self.averages);
        for ((sensor, error), average) in sensors {
            error.take(now_ms, sensor.error_m);
            average.take(now_ms, sensor.moving_average_m);
        }
    }

    fn send_source(&mut self, source: u8, report: &TickReport<'_>, now_us: u64, now_ms: u32) {
        let input = report.input;
        match source {
            0 => self.send_samples(input, now_us),
            1 => self.send_inertial_altitude(0, named::ALTITUDE_MASTER, input.imu_master_altitude_m, now_us),
            2 => self.send_inertial_altitude(1, named::ALTITUDE_SLAVE, input.imu_slave_altitude_m, now_us),
            _ => self.send_fix(report, now_us, now_ms),
        }
    }

    fn send_samples(&mut self, input: &TickInput, now_us: u64) {
        let has_barometer = input.baro.is_some();
        let has_any = has_barometer || input.imu.is_some() || input.signals.baro_temperature_c.is_some();
        let waits = self.rates.sample_us > 0
            && !has_barometer
            && self.samples_due.overdue_us(now_us) < BAROMETER_PATIENCE_US;
        if has_any && self.samples_due.is_due(now_us) && !waits {
            self.link.send(MessageKind::HighresImu, Priority::Sample, &message::highres_imu(input));
            self.samples_due.sent(now_us, self.rates.sample_us);
        }
    }

    fn send_inertial_altitude(&mut self, which: usize, name: Name, altitude_m: Option<f32>, now_us: u64) {
        let (Some(altitude_m), Some(due)) = (altitude_m, self.altitudes_due.get_mut(which)) else { return };
        if due.is_due(now_us) {
            send_value(&mut self.link, Priority::Sample, boot_ms(now_us), name, altitude_m);
            due.sent(now_us, self.rates.inertial_altitude_us);
        }
    }

    /// Sends a fix that was not held and is finite, even if the filter refused it.
    fn send_fix(&mut self, report: &TickReport<'_>, now_us: u64, now_ms: u32) {
        let Some(fix) = &report.input.gps else { return };
        let is_none = matches!(report.output.gps_rejection, Some(Rejection::Held | Rejection::NotFinite));
        if is_none || !fix.altitude_m.is_finite() {
            return;
        }
        self.fix_m.take(now_ms, Some(fix.altitude_m));
        if !self.fix_due.is_due(now_us) {
            return;
        }
        self.link.send(MessageKind::GpsRawInt, Priority::Sample, &message::gps_raw_int(now_us, fix));
        if let Some(down_mps) = fix.velocity_down_mps {
            send_value(&mut self.link, Priority::Sample, now_ms, named::VELOCITY_DOWN, down_mps);
        }
        self.fix_due.sent(now_us, self.rates.fix_us);
    }

    /// Whether a slot has something to send.
    fn has(&self, slot: Slot) -> bool {
        match slot {
            Slot::Launch | Slot::Heartbeat | Slot::SysStatus | Slot::Error | Slot::Slow => true,
            Slot::Text => !self.events.is_empty(),
            Slot::Attitude => self.attitude.is_new(),
            Slot::Altitude => self.barometer.latest().is_some() || self.fix_m.latest().is_some(),
            Slot::Airspeed => self.airspeed.is_new(),
            Slot::AngleOfAttack => self.angle_of_attack.is_new(),
            Slot::Sideslip => self.sideslip.is_new(),
            Slot::Throttle => self.throttle.is_new(),
            Slot::OutsideAir => self.outside_air.is_new(),
        }
    }

    const fn period_us(&self, slot: Slot) -> u32 {
        match slot {
            Slot::Launch | Slot::Heartbeat | Slot::SysStatus | Slot::OutsideAir => Rates::SECOND_US,
            Slot::Text => self.rates.text_us,
            Slot::Attitude => self.rates.attitude_us,
            Slot::Altitude => self.rates.altitude_us,
            Slot::Airspeed | Slot::AngleOfAttack | Slot::Sideslip | Slot::Throttle => self.rates.signal_us,
            Slot::Error => self.rates.error_us,
            Slot::Slow => self.rates.slow_us,
        }
    }

    /// Sends a slot's message. Returns whether it is done: sent or dropped. A message that is sent once and
    /// found no room is not done.
    #[inline(never)]
    fn send_slot(
        &mut self,
        slot: Slot,
        report: &TickReport<'_>,
        computer: &ComputerStatus,
        now_ms: u32,
    ) -> bool {
        match slot {
            Slot::Launch => {
                let launched = if report.input.launch { 1.0 } else { 0.0 };
                let message = message::named_value_float(now_ms, named::LAUNCH, launched);
                return self.link.offer(MessageKind::NamedValueFloat, &message);
            }
            Slot::Text => {
                if let Some((time_us, event)) = self.events.first() {
                    let went = self.link.offer(MessageKind::StatusText, &event.message(*time_us));
                    if went {
                        self.events.forget_first();
                    }
                    return went;
                }
            }
            Slot::Heartbeat => {
                let untrustworthy = self.trust.contains(&Trust::Untrustworthy);
                let message = message::heartbeat(report.output.phase, untrustworthy);
                self.link.send(MessageKind::Heartbeat, Priority::Status, &message);
            }
            Slot::SysStatus => self.send_status(report, computer, now_ms),
            Slot::Attitude => {
                if let Some((time_ms, (attitude_rad, rates_radps))) = self.attitude.send() {
                    let message = message::attitude(time_ms, attitude_rad, rates_radps);
                    self.link.send(MessageKind::Attitude, Priority::Turn, &message);
                }
            }
            Slot::Altitude => self.send_altitude(report, now_ms),
            Slot::Airspeed => send_sample(&mut self.link, named::TRUE_AIRSPEED, &mut self.airspeed),
            Slot::AngleOfAttack => {
                send_sample(&mut self.link, named::ANGLE_OF_ATTACK, &mut self.angle_of_attack);
            }
            Slot::Sideslip => send_sample(&mut self.link, named::SIDESLIP, &mut self.sideslip),
            Slot::Throttle => send_sample(&mut self.link, named::THROTTLE, &mut self.throttle),
            Slot::OutsideAir => send_sample(&mut self.link, named::OUTSIDE_AIR, &mut self.outside_air),
            Slot::Error => self.send_in_turn(0, report, now_ms),
            Slot::Slow => self.send_in_turn(1, report, now_ms),
        }
        true
    }

    fn send_altitude(&mut self, report: &TickReport<'_>, now_ms: u32) {
        let baro_m = self.barometer.latest().and_then(|(_, reading)| match reading {
            BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa),
            BaroReading::AltitudeM(altitude_m) => Some(altitude_m),
        });
        let fix_m = self.fix_m.latest().filter(|(at_ms, _)| now_ms.wrapping_sub(*at_ms) <= FIX_LIFE_MS);
        let reference_m = fix_m.map(|(_, fix_m)| match report.output.phase {
            Phase::FreeFlight => fix_m,
            Phase::Settling | Phase::Calibrating => report.output.altitude_m,
        });
        let message = message::altitude(report.input.time_us, baro_m, reference_m);
        self.link.send(MessageKind::Altitude, Priority::Turn, &message);
    }

    fn send_status(&mut self, report: &TickReport<'_>, computer: &ComputerStatus, now_ms: u32) {
        let counts = *self.link.counts();
        let since = &self.counts_at_status;
        let dropped = counts.all_dropped().saturating_sub(since.all_dropped());
        let queued = counts.all_queued().saturating_sub(since.all_queued());
        let per_ten_thousand = u64::from(dropped) * 10_000 / (u64::from(dropped) + u64::from(queued)).max(1);
        let (present, healthy) = self.watch.bits(&self.trust, now_ms);
        let status = SysStatus {
            sensors: SensorBits { present, healthy },
            drop_rate: per_ten_thousand as u16,
            dropped: counts.all_dropped(),
            refused: watch::refused(report.counters),
            out_of_order: report.counters.out_of_order,
            computer: *computer,
        };
        self.link.send(MessageKind::SysStatus, Priority::Status, &message::sys_status(&status));
        self.counts_at_status = counts;
    }
}

#[inline(never)]
fn send_value(link: &mut Link<'_>, priority: Priority, time_ms: u32, name: Name, value: f32) {
    link.send(MessageKind::NamedValueFloat, priority, &message::named_value_float(time_ms, name, value));
}

#[inline(never)]
fn send_sample(link: &mut Link<'_>, name: Name, sample: &mut Sample<f32>) {
    if let Some((time_ms, value)) = sample.send() {
        send_value(link, Priority::Turn, time_ms, name, value);
    }
}
