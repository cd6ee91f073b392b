//! PX4's ULog (`.ulg`).
//!
//! A log defines its own messages, and no CRC protects any of it. Damage is found in two ways: each message
//! must be followed by another valid message, and times must agree with those around them. The crates
//! `yule_log` and `px4-ulog` stop at damage, the latter with a panic on some files, so this reader is our
//! own.
//!
//! | in the log | in the flight |
//! |---|---|
//! | vehicle_gps_position, else sensor_gps | `gps_alt_m` (mean sea level), `gps_vn_mps`, `gps_ve_mps`, `gps_vd_mps`, `gps_vacc_m` (epv), `gps_sats`, `gps_time_s`; the position |
//! | vehicle_air_data, else sensor_baro | `baro_pa` (or `baro_alt_m`), `baro_temp_c` |
//! | sensor_baro beside it | `baro_N_pa` |
//! | sensor_combined | `accel_*`, `gyro_*` |
//! | vehicle_attitude | `roll_rad`, `pitch_rad`, `yaw_rad` |
//! | airspeed_validated, else airspeed | `tas_mps` |
//! | actuator_controls_0, else vehicle_thrust_setpoint | `throttle` |
//! | vehicle_local_position, innovations, biases, wind | signals `autopilot_*`: what the autopilot estimated |
//! | parameters | `parameter NAME` in the header |

mod collect;
mod convert;
mod format;
mod gps;
mod reader;
mod rules;

use crate::import::words::most_of;
use crate::import::{ImportError, Importer};
use flight_data::{Flight, Note};

use collect::Collected;
use reader::{MAGIC, Reader};

/// Importer of PX4 logs.
#[derive(Clone, Copy, Debug)]
pub struct Ulog;

impl Importer for Ulog {
    fn name(&self) -> &'static str {
        "PX4 ULog (.ulg)"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        log.starts_with(&MAGIC)
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let mut reader = Reader::new(log);
        let collected = Collected::read(&mut reader);
        let mut notes = reader.damage.notes(log.len());
        if reader.unknown_flags {
            notes.push(
                "the log has flags that this reader does not know: it may be of a newer format".to_owned(),
            );
        }
        for (count, what) in [
            (
                reader.interrupted,
                "messages that were being written when the autopilot failed, before data were appended, left out",
            ),
            (reader.bad_definitions, "definitions that contradict themselves or another one, left out"),
        ] {
            if count > 0 {
                notes.push(format!("{what}: {count}"));
            }
        }
        notes.extend(lost_topics(&reader, &collected));
        convert::convert(&collected, &reader, notes)
    }
}

/// Notes on topics whose data are in the log but cannot be read, because a definition is lost.
fn lost_topics(reader: &Reader<'_>, collected: &Collected) -> Vec<String> {
    let (mut unknown, mut undefined, mut of_another_length) = (Vec::new(), Vec::new(), Vec::new());
    for (id, count) in &reader.unsubscribed {
        match reader.subscriptions.get(id) {
            None => unknown.push((format!("id {id}"), *count)),
            Some(found) if found.len.is_none() => undefined.push((found.name(), *count)),
            Some(found) => of_another_length.push((found.name(), *count)),
        }
    }
    let mut notes = Vec::new();
    for (topics, what) in [
        (
            unknown,
            "messages of a topic that the log does not name, left out: its definition is missing or damaged",
        ),
        (
            undefined,
            "messages of a topic whose format the log does not define, left out: the definition is missing or damaged",
        ),
        (
            of_another_length,
            "messages of another length than their topic's format, left out: one of the two is damaged",
        ),
    ] {
        notes.extend(most_of(topics).map(|topics| format!("{what}: {topics}")));
    }
    for (id, why) in &collected.unreadable {
        let Some(subscription) = reader.subscriptions.get(id) else { continue };
        let count = collected.counts.get(id).copied().unwrap_or(0);
        notes.push(format!("{} cannot be read, {why}; messages left out: {count}", subscription.name()));
    }
    for (topic, wanted, name) in &collected.misspelt {
        notes.push(format!(
            "{topic} has no field {wanted}, but one called {name}, which is not used: the definition may be damaged"
        ));
    }
    notes
}

#[cfg(test)]
mod tests;
