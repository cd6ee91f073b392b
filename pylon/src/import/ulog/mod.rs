//! PX4's ULog (`.ulg`).
//!
//! A log defines its own messages, and nothing in it is checked by a CRC: what is damaged is found by the message that must
//! follow each message, and by times that contradict those around them. The crates `yule_log` and `px4-ulog` stop at damage, the
//! latter by a panic on some files, so this reader is our own.
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

use crate::flight::{Flight, Note};
use crate::import::{ImportError, Importer};

use collect::Collected;
use reader::{MAGIC, Reader};

/// The importer of PX4's logs.
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
            (reader.unsubscribed, "messages of topics that the log does not define, left out"),
        ] {
            if count > 0 {
                notes.push(format!("{what}: {count}"));
            }
        }
        convert::convert(&collected, &reader, notes)
    }
}

#[cfg(test)]
mod tests;
