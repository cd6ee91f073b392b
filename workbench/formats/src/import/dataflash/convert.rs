//! Converts a log's groups to a flight's columns.

use std::collections::BTreeMap;

use super::collect::Collected;
use super::format::Layout;
use super::gps::{self, Receiver, receiver};
use super::rules::{BARO_ABOVE_GROUND, RULES, Rule, Target};
use super::throttle;
use crate::import::ImportError;
use crate::import::airspeed::put_true_airspeed;
use crate::import::gps_time::{utc_s, utc_text};
use crate::import::stamps::{self, Believed, NO_TIME};
use crate::import::table::{Destination, Filling, Group, Table, assemble};
use crate::import::words::most_of;
use flight_data::{Channel, Flight, Header, Note};

/// Name of a log's calibrated airspeed.
const CALIBRATED_AIRSPEED: &str = "calibrated_airspeed_mps";
/// An instance with less than this share of the messages of the most frequent one is damage or useless.
const SELDOM: f64 = 0.1;

/// Turns the collected data into a flight. `place` is the word for a place in the file.
pub fn convert(
    mut collected: Collected,
    layouts: &[Layout],
    place: &str,
    mut notes: Vec<String>,
) -> Result<(Flight, Vec<Note>), ImportError> {
    let format = "ArduPilot DataFlash log";
    let messages = collected.counts.iter().sum();
    let mut clock_notes = Vec::new();
    let times_us = times(&mut collected, place, &mut clock_notes);
    let receiver = receiver(&collected, &times_us);
    if receiver.fixes.fixes.is_empty() {
        let fixes_without = receiver.without;
        return Err(ImportError::NoFixInLog {
            format,
            messages,
            fixes_without,
            expected: "GPS messages of status 3 or more",
            lost: notes,
        });
    }
    let mut fillings = receiver.fillings.clone();
    let mut used_notes = Vec::new();
    of_groups(&collected, &mut fillings, &mut used_notes);
    let has = |fillings: &[Filling<'_>], channel| {
        fillings.iter().any(|filling| filling.destination == Destination::Channel(channel))
    };
    if !has(&fillings, Channel::Throttle) {
        used_notes.extend(throttle::from_outputs(&collected, &mut fillings));
    }
    if !has(&fillings, Channel::BaroPa) {
        used_notes.push(without_barometer(&mut fillings));
    }
    let header = header(&collected);
    let Table { mut flight, repeated, doubled, start_us } = assemble(header, &times_us, fillings);
    if let Some(epoch_us) = receiver.fixes.epoch_us {
        let start = utc_text(utc_s(epoch_us.saturating_add_unsigned(start_us)));
        flight.header.other.extend(start.map(|start| ("start_utc".to_owned(), start)));
    }
    let named = collected
        .parameters
        .iter()
        .map(|(name, value)| (format!("parameter {name}"), (*value as f32).to_string()));
    flight.header.other.extend(named);
    used_notes.extend(airspeed(&mut flight));

    let duration_s = flight.time_s.last().copied().unwrap_or(0.0);
    let mut first = summary(&collected, layouts, messages, duration_s);
    first.append(&mut notes);
    first.append(&mut clock_notes);
    fix_notes(&receiver, &times_us, &mut first);
    first.append(&mut used_notes);
    for unit in &collected.other_units {
        first.push(format!("{unit}, which is not that field's unit elsewhere; left out"));
    }
    if !doubled.is_empty() {
        first.push(format!(
            "signals that two messages have, of which the first is used: {}",
            doubled.join(", ")
        ));
    }
    for (count, what) in [
        (collected.not_finite, "values that are not finite, left out"),
        (collected.bad_instances, "messages of an instance that no autopilot has, left out"),
        (repeated, "values with the time of a later one of their kind, left out"),
    ] {
        if count > 0 {
            first.push(format!("{what}: {count}"));
        }
    }
    Ok((flight, first.into_iter().map(Note::new).collect()))
}

fn header(collected: &Collected) -> Header {
    Header {
        vehicle: collected.firmware.clone().unwrap_or_else(|| "ArduPilot".to_owned()),
        source: "imported ArduPilot DataFlash log".to_owned(),
        other: vec![("log_format".to_owned(), "dataflash".to_owned())],
        ..Header::default()
    }
}

/// The log's content: which of it is used and which is not.
fn summary(collected: &Collected, layouts: &[Layout], messages: usize, duration_s: f64) -> Vec<String> {
    let kinds = |wanted: bool| {
        let all = layouts.iter().zip(&collected.counts).zip(&collected.is_used);
        let found = all.filter(|((_, count), used)| **count > 0 && **used == wanted);
        found.map(|((layout, count), _)| (layout.name.clone(), *count)).collect::<Vec<_>>()
    };
    let used: Vec<String> = kinds(true).iter().map(|(name, count)| format!("{name} ({count})")).collect();
    let mut notes = vec![format!("{messages} messages over {duration_s:.1} s; used: {}", used.join(", "))];
    notes.extend(most_of(kinds(false)).map(|unused| format!("not used: {unused}")));
    if !collected.parameters.is_empty() {
        notes.push(format!("parameters, kept in the header: {}", collected.parameters.len()));
    }
    notes
}

fn fix_notes(receiver: &Receiver, times_us: &[Option<u64>], notes: &mut Vec<String>) {
    let used = gps::name(receiver.instance);
    notes.extend(receiver.others.iter().map(|other| other.sentence((&used, &receiver.fixes), times_us)));
    for (count, what) in [
        (receiver.without, "GPS messages without a 3D fix, which give no sample"),
        (receiver.fixes.repeated, "GPS messages that repeat the fix before them, taken once"),
    ] {
        if count > 0 {
            notes.push(format!("{what}: {count}"));
        }
    }
}

/// The time of each accepted stamp, microseconds.
fn times(collected: &mut Collected, place: &str, notes: &mut Vec<String>) -> Vec<Option<u64>> {
    // Logs from before 2013 have only the receiver's time.
    if collected.stamps_us.iter().all(|stamp| *stamp == NO_TIME) {
        for message in &collected.gps {
            if let (Some(time_us), Some(slot)) =
                (message.time_us(), collected.stamps_us.get_mut(message.stamp as usize))
            {
                *slot = time_us;
            }
        }
    }
    let places = &collected.places;
    let groups = collected.groups.values().map(Group::stamps);
    let described = |stamp: usize| format!("{place} {}", places.get(stamp).copied().unwrap_or(0));
    let Believed { mut times_us, notes: mut said, stamped } =
        stamps::believe(&collected.stamps_us, groups, described);
    notes.append(&mut said);
    let unstamped = collected.stamps_us.len() - stamped;
    if unstamped > 0 {
        let outside = interpolate(&collected.stamps_us, &mut times_us);
        notes.push(format!(
            "messages without a time of their own: {unstamped}; it is interpolated between those around them that have one, \
             by the order in the log{}",
            if outside > 0 {
                format!(" (before the first or after the last of those, left out: {outside})")
            } else {
                String::new()
            }
        ));
    }
    times_us
}

/// Interpolates times for messages without one from those of their neighbours; returns how many have none.
fn interpolate(stamps_us: &[u64], times_us: &mut [Option<u64>]) -> usize {
    let known: Vec<(usize, u64)> =
        times_us.iter().enumerate().filter_map(|(index, time)| Some((index, (*time)?))).collect();
    let mut outside = 0;
    let mut next = 0;
    for (index, (slot, stamp)) in times_us.iter_mut().zip(stamps_us).enumerate() {
        while known.get(next).is_some_and(|(at, _)| *at < index) {
            next += 1;
        }
        if *stamp != NO_TIME {
            continue;
        }
        let before = next.checked_sub(1).and_then(|before| known.get(before));
        match (before, known.get(next)) {
            (Some((from, from_us)), Some((to, to_us))) => {
                let share = (index - from) as f64 / (to - from) as f64;
                *slot = Some(from_us + (share * to_us.saturating_sub(*from_us) as f64) as u64);
            }
            _ => outside += 1,
        }
    }
    outside
}

/// Chooses the instance of each kind of message: as a parameter says, else the one with most messages.
fn of_groups<'a>(collected: &'a Collected, fillings: &mut Vec<Filling<'a>>, notes: &mut Vec<String>) {
    let mut of_rule: BTreeMap<usize, Vec<(u8, &'a Group)>> = BTreeMap::new();
    for ((rule, instance), group) in &collected.groups {
        of_rule.entry(*rule).or_default().push((*instance, group));
    }
    for (place, instances) in of_rule {
        let Some(rule) = RULES.get(place).filter(|_| place != super::rules::ACCURACY_PLACE) else { continue };
        let most = instances.iter().map(|(_, group)| group.len()).max().unwrap_or(0);
        let is_often = |group: &Group| group.len() as f64 >= SELDOM * most as f64;
        let chosen = primary(collected, rule, &instances)
            .or_else(|| instances.iter().find(|(_, group)| is_often(group)).map(|(instance, _)| *instance));
        for (instance, group) in &instances {
            if Some(*instance) == chosen {
                of_primary(rule, group, fillings);
                continue;
            }
            let signals =
                if is_often(group) { of_other(rule, *instance, group, fillings) } else { Vec::new() };
            let fate = if signals.is_empty() {
                "left out".to_owned()
            } else {
                format!("kept as {}", signals.join(", "))
            };
            notes.push(format!(
                "{} {}: {} messages, {fate}; {} {} is used",
                rule.family,
                instance % 8 + 1,
                group.len(),
                rule.family,
                chosen.map_or(0, |chosen| chosen % 8 + 1)
            ));
        }
    }
}

/// The instance selected by the vehicle's parameters, if the log has it.
fn primary(collected: &Collected, rule: &Rule, instances: &[(u8, &Group)]) -> Option<u8> {
    let names: &[&str] = match rule.family {
        "baro" => &["BARO_PRIMARY", "GND_PRIMARY"],
        "airspeed" => &["ARSPD_PRIMARY"],
        _ => &[],
    };
    let wanted = names.iter().find_map(|name| collected.parameters.get(*name))?;
    instances.iter().map(|(instance, _)| *instance).find(|instance| f64::from(*instance) == *wanted)
}

fn of_primary<'a>(rule: &Rule, group: &'a Group, fillings: &mut Vec<Filling<'a>>) {
    for (place, field) in rule.fields.iter().enumerate() {
        let destination = match field.target {
            Target::Channel(channel) => Destination::Channel(channel),
            Target::Signal(name) => Destination::signal(name),
            Target::CalibratedAirspeed => Destination::signal(CALIBRATED_AIRSPEED),
            Target::Throttle => Destination::Channel(Channel::Throttle),
        };
        let filling = Filling::of(destination, group, place);
        // An output that never moves carries no information.
        if rule.family != "outputs" || !is_constant(&filling) {
            fillings.push(filling);
        }
    }
}

fn is_constant(filling: &Filling<'_>) -> bool {
    let (mut first, mut is_constant) = (None, true);
    filling.samples.each(|_, value| is_constant &= *first.get_or_insert(value) == value);
    is_constant
}

/// Adds the useful fields of an instance that is not used, and returns their names.
fn of_other<'a>(rule: &Rule, instance: u8, group: &'a Group, fillings: &mut Vec<Filling<'a>>) -> Vec<String> {
    let mut names = Vec::new();
    for (place, field) in rule.fields.iter().enumerate() {
        let Some(suffix) = field.other else { continue };
        let name = format!("{}_{}_{suffix}", rule.family, instance + 1);
        fillings.push(Filling::of(Destination::signal(name.clone()), group, place));
        names.push(name);
    }
    names
}

/// Uses the barometric altitude above the ground where there is no pressure; returns a note about it.
fn without_barometer(fillings: &mut [Filling<'_>]) -> String {
    let own = Destination::signal(BARO_ABOVE_GROUND);
    let has_values = |filling: &&mut Filling<'_>| {
        let mut any = false;
        filling.samples.each(|_, _| any = true);
        any
    };
    match fillings.iter_mut().find(|filling| filling.destination == own).filter(has_values) {
        Some(filling) => {
            filling.destination = Destination::Channel(Channel::BaroAltM);
            "no barometer's pressure (BARO messages): baro_alt_m is CTUN's barometric altitude, which is above the ground at \
             arming; a bias takes up the difference"
                .to_owned()
        }
        None => "no barometer: the log has no BARO messages, so there is no barometer to calibrate in it; set LOG_BITMASK so \
                 that the next flight has them"
            .to_owned(),
    }
}

fn airspeed(flight: &mut Flight) -> Option<String> {
    let (_, column) = flight.extra.iter().find(|(name, _)| name == CALIBRATED_AIRSPEED)?;
    let calibrated: Vec<(usize, f64)> = column.samples().map(|(row, mps)| (row, f64::from(mps))).collect();
    if calibrated.iter().all(|(_, mps)| *mps == 0.0) {
        return None;
    }
    put_true_airspeed(flight, calibrated).then(|| {
        "tas_mps is ARSP's airspeed, which is calibrated, by the standard atmosphere's density".to_owned()
    })
}
