//! Converts a log's groups to a flight's columns.

use super::collect::Collected;
use super::gps::{Receiver, receiver};
use super::reader::Reader;
use super::rules::{RULES, Target};
use crate::import::ImportError;
use crate::import::damage::percent;
use crate::import::gps_time::utc_text;
use crate::import::receivers::Other;
use crate::import::stamps::{self, Believed};
use crate::import::table::{Destination, Filling, Group, Table, assemble};
use crate::import::words::most_of;
use flight_data::{Channel, Flight, Header, Note};

/// Pressures below this are in hectopascals: no aircraft flies at 2 kPa, and no weather makes 2000 hPa.
const LEAST_PA: f32 = 2_000.0;

struct Converter<'a> {
    collected: &'a Collected,
    fillings: Vec<Filling<'a>>,
    notes: Vec<String>,
}

/// Turns the collected data into a flight.
pub fn convert(
    collected: &Collected,
    reader: &Reader<'_>,
    mut damage: Vec<String>,
) -> Result<(Flight, Vec<Note>), ImportError> {
    let format = "PX4 ULog";
    let messages = collected.counts.values().sum();
    let groups = collected.groups.values().map(Group::stamps);
    let places = &collected.places;
    let described = |stamp: usize| format!("byte {}", places.get(stamp).copied().unwrap_or(0));
    let Believed { times_us, notes: mut clock, .. } =
        stamps::believe(&collected.stamps_us, groups, described);
    let receiver = receiver(collected, &times_us);
    if receiver.fixes.fixes.is_empty() {
        let expected = "vehicle_gps_position or sensor_gps with fix_type 3 or more";
        let fixes_without = receiver.without;
        return Err(ImportError::NoFixInLog { format, messages, fixes_without, expected, lost: damage });
    }
    let mut fillings = receiver.fixes.fillings(&times_us);
    fillings.extend(receiver.others.iter().flat_map(Other::fillings));
    let mut converter = Converter { collected, fillings, notes: Vec::new() };
    converter.receiver_notes(&receiver, &times_us);
    converter.barometer();
    converter.attitude();
    converter.airspeed();
    converter.throttle();
    converter.plain();
    let Converter { fillings, notes: mut used, .. } = converter;

    let Table { mut flight, repeated, start_us, doubled } = assemble(header(collected), &times_us, fillings);
    if let Some(epoch_us) = receiver.fixes.epoch_us {
        let start = utc_text(epoch_us.saturating_add_unsigned(start_us).div_euclid(1_000_000));
        flight.header.other.extend(start.map(|start| ("start_utc".to_owned(), start)));
    }
    let parameters = collected.parameters.iter();
    flight
        .header
        .other
        .extend(parameters.map(|(name, value)| (format!("parameter {name}"), (*value as f32).to_string())));
    let duration_s = flight.time_s.last().copied().unwrap_or(0.0);
    let mut notes = summary(collected, reader, messages, duration_s);
    notes.append(&mut damage);
    notes.append(&mut clock);
    notes.extend(dropouts(collected, start_us, duration_s));
    notes.append(&mut used);
    if !doubled.is_empty() {
        notes.push(format!(
            "signals that two topics have, of which the first is used: {}",
            doubled.join(", ")
        ));
    }
    for (count, what) in [
        (collected.changed, "parameters that were changed while logging; the header has those of the start"),
        (collected.unstamped, "messages without a time, left out"),
        (repeated, "values with the time of a later one of their kind, left out"),
    ] {
        if count > 0 {
            notes.push(format!("{what}: {count}"));
        }
    }
    Ok((flight, notes.into_iter().map(Note::new).collect()))
}

fn header(collected: &Collected) -> Header {
    let text = |name: &str| {
        let bytes = collected.info.get(name)?;
        let text: String =
            String::from_utf8_lossy(bytes).chars().filter(|letter| !letter.is_control()).collect();
        Some(text).filter(|text| !text.is_empty())
    };
    let mut vehicle = text("sys_name").unwrap_or_else(|| "PX4".to_owned());
    // Major, minor, patch and kind of release, one byte each.
    let release = collected.info.get("ver_sw_release").and_then(|bytes| bytes.first_chunk::<4>());
    if let Some([_, patch, minor, major]) = release {
        vehicle += &format!(" {major}.{minor}.{patch}");
    }
    if let Some(hardware) = text("ver_hw") {
        vehicle += &format!(" on {hardware}");
    }
    let mut other = vec![("log_format".to_owned(), "ulog".to_owned())];
    other.extend(text("sys_uuid").map(|id| ("vehicle_id".to_owned(), id)));
    Header { vehicle, source: "imported PX4 ULog".to_owned(), other, ..Header::default() }
}

/// The log's content: which of it is used and which is not.
fn summary(collected: &Collected, reader: &Reader<'_>, messages: usize, duration_s: f64) -> Vec<String> {
    let kinds = |wanted: bool| {
        let mut found: Vec<(String, usize)> = Vec::new();
        for (id, count) in &collected.counts {
            let Some(subscription) = reader.subscriptions.get(id) else { continue };
            let is_of_use = RULES.iter().any(|rule| rule.topic == subscription.topic);
            if is_of_use == wanted && !collected.unreadable.contains_key(id) {
                found.push((subscription.name(), *count));
            }
        }
        found.sort();
        found
    };
    let read: Vec<String> = kinds(true).iter().map(|(name, count)| format!("{name} ({count})")).collect();
    let mut notes = vec![format!("{messages} messages over {duration_s:.1} s; read: {}", read.join(", "))];
    notes.extend(most_of(kinds(false)).map(|unused| format!("not used: {unused}")));
    if !collected.parameters.is_empty() {
        notes.push(format!("parameters, kept in the header: {}", collected.parameters.len()));
    }
    notes
}

fn dropouts(collected: &Collected, start_us: u64, duration_s: f64) -> Option<String> {
    let (first_us, _) = collected.dropouts.first()?;
    let lost_s = collected.dropouts.iter().map(|(_, ms)| f64::from(*ms)).sum::<f64>() / 1e3;
    Some(format!(
        "the logger could not keep up {} times: {lost_s:.2} s of data are missing ({}), the first at {:.1} s",
        collected.dropouts.len(),
        percent((lost_s * 1e3) as usize, (duration_s * 1e3) as usize),
        first_us.saturating_sub(start_us) as f64 / 1e6
    ))
}

impl<'a> Converter<'a> {
    fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// The instances of a topic, in order.
    fn instances(&self, topic: &str) -> Vec<(u8, &'a Group)> {
        let Some(place) = RULES.iter().position(|rule| rule.topic == topic) else { return Vec::new() };
        let own = self.collected.groups.range((place, 0)..=(place, u8::MAX));
        own.map(|((_, instance), group)| (*instance, group)).collect()
    }

    /// The values at one index of a topic's first instance, if there are any.
    fn samples(&self, topic: &str, place: usize) -> Option<Vec<(u32, f32)>> {
        let (_, group) = *self.instances(topic).first()?;
        let samples: Vec<(u32, f32)> = group.column(place).filter(|(_, value)| value.is_finite()).collect();
        (!samples.is_empty()).then_some(samples)
    }

    /// The values at some indices of each message of a topic's first instance.
    fn rows<const N: usize>(&self, topic: &str, places: [usize; N]) -> Vec<(u32, [f32; N])> {
        let Some((_, group)) = self.instances(topic).first().copied() else { return Vec::new() };
        let mut rows: Vec<(u32, [f32; N])> =
            group.stamps().iter().map(|stamp| (*stamp, [f32::NAN; N])).collect();
        for (slot, place) in places.into_iter().enumerate() {
            for ((_, row), (_, value)) in rows.iter_mut().zip(group.column(place)) {
                if let Some(cell) = row.get_mut(slot) {
                    *cell = value;
                }
            }
        }
        rows
    }

    fn put(&mut self, channel: Channel, samples: Vec<(u32, f32)>) {
        self.fillings.push(Filling { destination: Destination::Channel(channel), samples: samples.into() });
    }

    fn receiver_notes(&mut self, receiver: &Receiver, times_us: &[Option<u64>]) {
        let (topic, instance) = receiver.source;
        let used = format!("{topic} {}", instance + 1);
        for other in &receiver.others {
            self.note(other.sentence((&used, &receiver.fixes), times_us));
        }
        for (other, number, count) in &receiver.left_out {
            self.note(format!(
                "{other} {}: {count} 3D fixes, left out; {used} with {} is used",
                number + 1,
                receiver.fixes.fixes.len()
            ));
        }
        for (count, what) in [
            (receiver.without, "GPS messages without a 3D fix, which give no sample"),
            (receiver.fixes.repeated, "GPS messages that repeat the fix before them, taken once"),
        ] {
            if count > 0 {
                self.note(format!("{what}: {count}"));
            }
        }
    }

    fn barometer(&mut self) {
        if let Some(pressures) = self.samples("vehicle_air_data", 0) {
            self.put(Channel::BaroPa, pressures);
            let temperatures = self.samples("vehicle_air_data", 1).unwrap_or_default();
            self.put(Channel::BaroTempC, temperatures);
            self.other_barometers(None);
        } else if self.samples("sensor_baro", 0).is_some() {
            let temperatures = self.samples("sensor_baro", 1).unwrap_or_default();
            self.put(Channel::BaroTempC, temperatures);
            self.other_barometers(Some(Channel::BaroPa));
        } else {
            for (topic, altitude, temperature) in
                [("vehicle_air_data", 2, 1), ("sensor_combined", 6, 7), ("sensor_baro", 2, 1)]
            {
                if let Some(altitudes) = self.samples(topic, altitude) {
                    self.put(Channel::BaroAltM, altitudes);
                    let temperatures = self.samples(topic, temperature).unwrap_or_default();
                    self.put(Channel::BaroTempC, temperatures);
                    self.note(format!(
                        "baro_alt_m is {topic}'s barometric altitude: the log has no pressure"
                    ));
                    return;
                }
            }
            self.note(
                "no barometer: neither vehicle_air_data nor sensor_baro is in the log, so there is no barometer to calibrate \
                 in it; set SDLOG_PROFILE so that the next flight has them",
            );
        }
    }

    /// Adds the pressures of the sensors themselves as signals; the first one's as a channel if there is
    /// nothing better.
    fn other_barometers(&mut self, first: Option<Channel>) {
        let instances: Vec<(u8, Vec<(u32, f32)>)> = self
            .instances("sensor_baro")
            .into_iter()
            .map(|(instance, group)| {
                (instance, group.column(0).filter(|(_, value)| value.is_finite()).collect())
            })
            .collect();
        let mut first = first;
        for (instance, mut samples) in instances {
            let mut values: Vec<f32> = samples.iter().map(|(_, value)| *value).collect();
            if values.is_empty() {
                continue;
            }
            let middle = values.len() / 2;
            let (_, median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
            if *median < LEAST_PA {
                samples.iter_mut().for_each(|(_, value)| *value = (f64::from(*value) * 100.0) as f32);
            }
            let name = format!("baro_{}_pa", instance + 1);
            match first.take() {
                Some(channel) => self.put(channel, samples),
                None => self
                    .fillings
                    .push(Filling { destination: Destination::signal(name), samples: samples.into() }),
            }
        }
    }

    fn attitude(&mut self) {
        let mut angles: [Vec<(u32, f32)>; 3] = [Vec::new(), Vec::new(), Vec::new()];
        for (stamp, quaternion) in self.rows("vehicle_attitude", [0, 1, 2, 3]) {
            for (column, angle) in angles.iter_mut().zip(euler_rad(quaternion.map(f64::from))) {
                column.push((stamp, angle as f32));
            }
        }
        for (channel, column) in
            [Channel::RollRad, Channel::PitchRad, Channel::YawRad].into_iter().zip(angles)
        {
            self.put(channel, column);
        }
    }

    fn airspeed(&mut self) {
        for topic in ["airspeed_validated", "airspeed"] {
            let samples = self.samples(topic, 0).filter(|samples| samples.iter().any(|(_, mps)| *mps != 0.0));
            if let Some(samples) = samples {
                self.put(Channel::TasMps, samples);
                self.note(format!("tas_mps is {topic}'s true airspeed, as the autopilot computed it"));
                return;
            }
        }
    }

    fn throttle(&mut self) {
        if let Some(samples) = self.samples("actuator_controls_0", 0) {
            return self.put(Channel::Throttle, samples);
        }
        let norm = |(stamp, [x, y, z]): (u32, [f32; 3])| {
            (stamp, f64::from(x).hypot(f64::from(y)).hypot(f64::from(z)) as f32)
        };
        let samples: Vec<(u32, f32)> =
            self.rows("vehicle_thrust_setpoint", [0, 1, 2]).into_iter().map(norm).collect();
        if samples.is_empty() {
            return;
        }
        self.put(Channel::Throttle, samples);
        self.note("throttle is the magnitude of vehicle_thrust_setpoint");
    }

    /// Adds the numbers whose rule names their column.
    fn plain(&mut self) {
        for rule in RULES {
            let instances = self.instances(rule.topic);
            let mut found: Vec<Filling<'a>> = Vec::new();
            if let Some((_, group)) = instances.first() {
                for (place, field) in rule.fields.iter().enumerate() {
                    let destination = match field.target {
                        Target::Channel(channel) => Destination::Channel(channel),
                        Target::Signal(name) => Destination::signal(name),
                        Target::Part => continue,
                    };
                    found.push(Filling::of(destination, group, place));
                }
            }
            let left_out = instances.len().saturating_sub(1);
            if left_out > 0 && !found.is_empty() {
                self.notes.push(format!("{}: of {} instances the first is used", rule.topic, left_out + 1));
            }
            self.fillings.append(&mut found);
        }
    }
}

/// Roll, pitch and yaw of a quaternion (w, x, y, z) from body to north-east-down axes.
fn euler_rad([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let norm = w * w + x * x + y * y + z * z;
    let [w, x, y, z] = [w, x, y, z].map(|part| part / norm.sqrt());
    [
        (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
        (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin(),
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
    ]
}
