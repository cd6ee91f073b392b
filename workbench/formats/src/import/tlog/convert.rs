//! Converts a recording's values to a flight's columns.

use super::Sender;
use super::clock::{Clock, EPOCH_US, Time, longest_run};
use super::frame::Losses;
use super::rows::Rows;
use super::value::{Fix, Global, Sampled, Timed, Value};
use crate::import::ImportError;
use crate::import::airspeed::put_true_airspeed;
use crate::import::damage::percent;
use crate::import::gps_time::utc_text;
use crate::import::{leap, receivers};
use flight_data::{Channel, Column, Flight, Header, Note};

/// Phase of a Pylon in free flight (HEARTBEAT's custom_mode).
const FREE_FLIGHT: u32 = 2;
/// Largest time between a fix and the autopilot's velocity down that belongs to it, seconds.
const SAME_FIX_S: f64 = 0.5;

struct Converter {
    values: Vec<Timed>,
    times: Vec<Time>,
    rows: Rows,
    flight: Flight,
    notes: Vec<Note>,
}

/// Turns a sender's values into a flight.
pub fn convert(
    sender: Sender,
    values: Vec<Timed>,
    losses: Losses,
    others: usize,
    left_out: Option<String>,
) -> Result<(Flight, Vec<Note>), ImportError> {
    let (values, restarts) = longest_run(values);
    let is_reference = |timed: &Timed| matches!(timed.value, Value::Fix(_) | Value::Global(_));
    if !values.iter().any(is_reference) {
        let unreadable = losses.bad_crc + losses.unreadable;
        return Err(ImportError::NoReference { format: "MAVLink tlog", messages: losses.read, unreadable });
    }
    let clock = Clock::of(&values);
    let times: Vec<Time> = values.iter().map(|timed| clock.time(timed)).collect();
    let rows = Rows::new(&times);
    // Without receiver's times, they count from the sender's start.
    let start_us = values
        .iter()
        .map(|timed| timed.recorded_us)
        .min()
        .filter(|start_us| *start_us >= EPOCH_US)
        .unwrap_or(0);
    let header = Header {
        vehicle: format!("MAVLink system {}, component {}", sender.0, sender.1),
        source: "imported MAVLink tlog".to_owned(),
        other: vec![("log_format".to_owned(), "tlog".to_owned())],
        ..Header::default()
    };
    let flight = Flight { header, time_s: rows.seconds(), ..Flight::default() };
    let mut converter = Converter { values, times, rows, flight, notes: Vec::new() };
    converter.notes.extend(left_out.map(Note::new));
    converter.note_losses(&losses, others, restarts);
    converter.reference();
    converter.inertial_and_barometer();
    converter.signals();
    converter.launch();
    let Converter { mut flight, mut notes, .. } = converter;
    // Without any time of the sender, nothing contradicts a wrong stamp of the receiver.
    notes.extend(leap::leave_out(&mut flight));
    let first_s = flight.time_s.first().copied().unwrap_or(0.0);
    flight.time_s.iter_mut().for_each(|time_s| *time_s -= first_s);
    let start_us = start_us.saturating_add((first_s * 1e6) as u64);
    let start = i64::try_from(start_us / 1_000_000).ok().and_then(utc_text);
    flight.header.other.extend(start.filter(|_| start_us > 0).map(|start| ("start_utc".to_owned(), start)));
    Ok((flight, notes))
}

impl Converter {
    fn note(&mut self, text: impl Into<String>) {
        self.notes.push(Note::new(text));
    }

    fn note_losses(&mut self, losses: &Losses, others: usize, restarts: usize) {
        let counted = [
            (losses.bad_crc, "frames whose CRC is wrong, left out"),
            (losses.unreadable, "frames with values that MAVLink does not define, left out"),
            (losses.unknown, "frames of messages that are not in MAVLink's common set, left out"),
            (
                losses.backward,
                "frames that were recorded before the one before them; the sender's times are used",
            ),
            (others, "messages of other senders, left out"),
            (restarts, "starts of the sender's clock within the log; the longest stretch is used"),
        ];
        for (count, what) in counted {
            if count > 0 {
                self.note(format!("{what}: {count}"));
            }
        }
        if losses.garbage_bytes > 0 {
            self.note(format!(
                "damaged: {} of the file's {} bytes ({}) are not frames, the first at byte {}; what is before and after was read",
                losses.garbage_bytes,
                losses.bytes,
                percent(losses.garbage_bytes, losses.bytes),
                losses.first_garbage
            ));
        }
        if losses.cut {
            self.note("the last frame is cut off");
        }
        let no_fixes = self.count(|value| matches!(value, Value::NoFix));
        if no_fixes > 0 {
            self.note(format!("fixes that are not 3D and give no GPS sample: {no_fixes}"));
        }
        let estimates = self.count(|value| matches!(value, Value::Estimate));
        if estimates > 0 {
            self.note(format!(
                "values that the flight computer estimated itself (biases, errors, ...), left out: {estimates}"
            ));
        }
    }

    fn count(&self, is: impl Fn(&Value) -> bool) -> usize {
        self.values.iter().filter(|timed| is(&timed.value)).count()
    }

    /// The samples selected by `pick`, with their rows.
    fn picked<T>(&self, pick: impl Fn(&Value) -> Option<T>) -> Vec<(usize, T)> {
        let timed = self.values.iter().zip(&self.times);
        timed.filter_map(|(timed, time)| Some((self.rows.row(*time)?, pick(&timed.value)?))).collect()
    }

    /// Sets a channel to these samples, if there are any; the last one of a row is used.
    fn put(&mut self, channel: Channel, samples: impl IntoIterator<Item = (usize, f64)>) {
        let mut column = Column::empty(self.rows.len());
        let mut any = false;
        for (row, sample) in samples {
            any |= column.set(row, Some(sample as f32));
        }
        if any {
            self.flight.set_channel(channel, column);
        }
    }

    fn put_signal(&mut self, name: &str, samples: impl IntoIterator<Item = (usize, f64)>) {
        let mut column = Column::empty_named(name, self.rows.len());
        for (row, sample) in samples {
            column.set_f64(row, Some(sample));
        }
        if column.samples().next().is_some() {
            self.flight.extra.push((name.to_owned(), column));
        }
    }

    fn named(&self, wanted: Sampled) -> Vec<(usize, f64)> {
        self.picked(|value| match value {
            Value::Named(sampled, number) if *sampled == wanted => Some(f64::from(*number)),
            _ => None,
        })
    }

    fn reference(&mut self) {
        let fixes = self.picked(|value| if let Value::Fix(fix) = value { Some(*fix) } else { None });
        let globals =
            self.picked(|value| if let Value::Global(global) = value { Some(*global) } else { None });
        if fixes.is_empty() {
            return self.fused_reference(&globals);
        }
        let each = |pick: fn(&Fix) -> Option<f64>| -> Vec<(usize, f64)> {
            fixes.iter().filter_map(|(row, fix)| Some((*row, pick(fix)?))).collect()
        };
        self.put(Channel::GpsAltM, each(|fix| Some(fix.altitude_m)));
        self.put(Channel::GpsVnMps, each(|fix| fix.ground_mps.map(|(north, _)| north)));
        self.put(Channel::GpsVeMps, each(|fix| fix.ground_mps.map(|(_, east)| east)));
        self.put(Channel::GpsSats, each(|fix| fix.satellites.map(f64::from)));
        self.put(Channel::GpsVaccM, each(|fix| fix.vertical_accuracy_m));
        self.put_signal("latitude_deg", each(|fix| fix.position_deg.map(|(latitude, _)| latitude)));
        self.put_signal("longitude_deg", each(|fix| fix.position_deg.map(|(_, longitude)| longitude)));
        let first_us = fixes.iter().map(|(_, fix)| fix.fix_time_us).min().unwrap_or(0);
        let times = fixes.iter().map(|(row, fix)| (*row, fix.fix_time_us.abs_diff(first_us) as f64 / 1e6));
        self.put(Channel::GpsTimeS, times.collect::<Vec<_>>());
        self.second_receiver(&fixes);

        let down = self.named(Sampled::VelocityDown);
        if !down.is_empty() {
            self.put(Channel::GpsVdMps, down);
        } else if !globals.is_empty() {
            let beside = self.beside(&fixes, &globals);
            self.put(Channel::GpsVdMps, beside);
            self.note("gps_vd_mps is GLOBAL_POSITION_INT's velocity down: the autopilot's estimate, not the receiver's");
        }
    }

    fn second_receiver(&mut self, used: &[(usize, Fix)]) {
        let fixes = self.picked(|value| if let Value::OtherFix(fix) = value { Some(*fix) } else { None });
        if fixes.is_empty() {
            return;
        }
        let each = |pick: fn(&Fix) -> Option<f64>| -> Vec<(usize, f64)> {
            fixes.iter().filter_map(|(row, fix)| Some((*row, pick(fix)?))).collect()
        };
        for (name, samples) in [
            ("gps_2_alt_m", each(|fix| Some(fix.altitude_m))),
            ("gps_2_vn_mps", each(|fix| fix.ground_mps.map(|(north, _)| north))),
            ("gps_2_ve_mps", each(|fix| fix.ground_mps.map(|(_, east)| east))),
            ("gps_2_vacc_m", each(|fix| fix.vertical_accuracy_m)),
            ("gps_2_sats", each(|fix| fix.satellites.map(f64::from))),
        ] {
            self.put_signal(name, samples);
        }
        let time_us = |row: &usize| (self.flight.time_s.get(*row).copied().unwrap_or(0.0) * 1e6) as u64;
        let altitudes = |fixes: &[(usize, Fix)]| -> Vec<(u64, f64)> {
            fixes.iter().map(|(row, fix)| (time_us(row), fix.altitude_m)).collect()
        };
        self.note(receivers::sentence(
            ("GPS_RAW_INT", &mut altitudes(used)),
            ("GPS2_RAW", 2, &altitudes(&fixes)),
        ));
    }

    /// For each fix, the velocity down of the nearest position.
    fn beside(&self, fixes: &[(usize, Fix)], globals: &[(usize, Global)]) -> Vec<(usize, f64)> {
        let time_s = |row: usize| self.flight.time_s.get(row).copied().unwrap_or(f64::NAN);
        let mut sorted: Vec<(f64, f64)> =
            globals.iter().map(|(row, global)| (time_s(*row), global.down_mps)).collect();
        sorted.sort_by(|one, other| one.0.total_cmp(&other.0));
        let nearest = |at_s: f64| {
            let next = sorted.partition_point(|(time_s, _)| *time_s < at_s);
            let around = sorted.get(next.saturating_sub(1)..(next + 1).min(sorted.len())).unwrap_or_default();
            around
                .iter()
                .copied()
                .min_by(|one, other| (one.0 - at_s).abs().total_cmp(&(other.0 - at_s).abs()))
        };
        let found = fixes.iter().filter_map(|(row, _)| {
            let at_s = time_s(*row);
            nearest(at_s)
                .filter(|(time_s, _)| (time_s - at_s).abs() <= SAME_FIX_S)
                .map(|(_, down)| (*row, down))
        });
        found.collect()
    }

    fn fused_reference(&mut self, globals: &[(usize, Global)]) {
        let each = |pick: fn(&Global) -> f64| -> Vec<(usize, f64)> {
            globals.iter().map(|(row, global)| (*row, pick(global))).collect()
        };
        self.put(Channel::GpsAltM, each(|global| global.altitude_m));
        self.put(Channel::GpsVnMps, each(|global| global.north_mps));
        self.put(Channel::GpsVeMps, each(|global| global.east_mps));
        self.put(Channel::GpsVdMps, each(|global| global.down_mps));
        self.put_signal("latitude_deg", each(|global| global.position_deg.0));
        self.put_signal("longitude_deg", each(|global| global.position_deg.1));
        self.note(
            "no GPS_RAW_INT: the reference is GLOBAL_POSITION_INT, the autopilot's own estimate, which uses the \
             barometer and is not an independent reference",
        );
    }

    fn inertial_and_barometer(&mut self) {
        let raw = |value: &Value| match value {
            Value::Inertial { accel_mps2, gyro_radps } => Some((*accel_mps2, *gyro_radps)),
            _ => None,
        };
        let scaled = |value: &Value| match value {
            Value::ScaledInertial { accel_mps2, gyro_radps } => Some((*accel_mps2, *gyro_radps)),
            _ => None,
        };
        let first = self.picked(raw);
        let samples = if first.is_empty() { self.picked(scaled) } else { first };
        let channels = [
            [Channel::AccelXMps2, Channel::AccelYMps2, Channel::AccelZMps2],
            [Channel::GyroXRadps, Channel::GyroYRadps, Channel::GyroZRadps],
        ];
        for (k, axes) in channels.into_iter().enumerate() {
            for (axis, channel) in axes.into_iter().enumerate() {
                let of = |(row, (accel, gyro)): &(usize, ([f32; 3], [f32; 3]))| {
                    let axes = if k == 0 { accel } else { gyro };
                    axes.get(axis).map(|value| (*row, f64::from(*value)))
                };
                self.put(channel, samples.iter().filter_map(of).collect::<Vec<_>>());
            }
        }
        let number = |wanted: fn(&Value) -> Option<f64>| wanted;
        let choices = [
            (
                Channel::BaroPa,
                number(|value| if let Value::PressurePa(pa) = value { Some(*pa) } else { None }),
                number(|value| if let Value::ScaledPressurePa(pa) = value { Some(*pa) } else { None }),
            ),
            (
                Channel::BaroTempC,
                number(|value| if let Value::BarometerC(c) = value { Some((*c).into()) } else { None }),
                number(|value| if let Value::ScaledBarometerC(c) = value { Some((*c).into()) } else { None }),
            ),
        ];
        for (channel, raw, scaled) in choices {
            let first = self.picked(raw);
            let samples = if first.is_empty() { self.picked(scaled) } else { first };
            self.put(channel, samples);
        }
        if self.flight.channel(Channel::BaroPa).is_none() {
            let altitudes = self.picked(|value| match value {
                Value::PressureAltitudeM(altitude_m) => Some(f64::from(*altitude_m)),
                _ => None,
            });
            self.put(Channel::BaroAltM, altitudes);
        }
    }

    fn signals(&mut self) {
        for (channel, sampled) in [
            (Channel::ImuMasterAltM, Sampled::MasterAltitude),
            (Channel::ImuSlaveAltM, Sampled::SlaveAltitude),
            (Channel::TasMps, Sampled::Airspeed),
            (Channel::AoaRad, Sampled::AngleOfAttack),
            (Channel::SideslipRad, Sampled::Sideslip),
            (Channel::Throttle, Sampled::Throttle),
            (Channel::OatC, Sampled::OutsideAir),
        ] {
            let samples = self.named(sampled);
            self.put(channel, samples);
        }
        let attitudes = self.picked(|value| match value {
            Value::AttitudeRad(angles_rad) => Some(*angles_rad),
            _ => None,
        });
        for (axis, channel) in [Channel::RollRad, Channel::PitchRad, Channel::YawRad].into_iter().enumerate()
        {
            let of = |(row, angles): &(usize, [f32; 3])| Some((*row, f64::from(*angles.get(axis)?)));
            self.put(channel, attitudes.iter().filter_map(of).collect::<Vec<_>>());
        }
        if self.flight.channel(Channel::Throttle).is_none() {
            let throttle = self.picked(|value| match value {
                Value::ThrottlePercent(percent) => Some(f64::from(*percent) / 100.0),
                _ => None,
            });
            self.put(Channel::Throttle, throttle);
        }
        if self.flight.channel(Channel::TasMps).is_none() {
            self.true_airspeed();
        }
    }

    /// VFR_HUD's airspeed is the calibrated one; an autopilot without an airspeed sensor sends zero or its
    /// estimate.
    fn true_airspeed(&mut self) {
        let calibrated = self.picked(|value| match value {
            Value::CalibratedAirspeedMps(mps) if mps.is_finite() => Some(f64::from(*mps)),
            _ => None,
        });
        if calibrated.iter().all(|(_, mps)| *mps == 0.0) {
            return;
        }
        if !put_true_airspeed(&mut self.flight, calibrated) {
            return;
        }
        self.note("tas_mps is VFR_HUD's airspeed, taken as calibrated, by the standard atmosphere's density");
    }

    fn launch(&mut self) {
        let discrete = self.named(Sampled::Launch);
        if !discrete.is_empty() {
            return self.put(Channel::Launch, discrete);
        }
        let phases = self.picked(|value| match value {
            Value::Phase(phase) => Some(if *phase == FREE_FLIGHT { 1.0 } else { 0.0 }),
            _ => None,
        });
        if !phases.is_empty() {
            self.put(Channel::Launch, phases);
            self.note("launch is from HEARTBEAT's mode, up to a second late: no value `launch` was recorded");
        }
    }
}
