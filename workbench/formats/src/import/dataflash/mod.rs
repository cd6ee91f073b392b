//! ArduPilot's DataFlash logs of copters, planes and rovers, binary (`.bin`) and as text (`.log`).
//!
//! A log defines its own messages (FMT) and their units (FMTU, UNIT, MULT). Messages have no checksum: damage
//! is detected by the header that must follow each message, and by times that contradict those around them.
//!
//! | in the log | in the flight |
//! |---|---|
//! | BARO | `baro_pa`, `baro_temp_c`; of the other instances `baro_N_pa`, `baro_N_temp_c` |
//! | GPS | `gps_alt_m`, `gps_vn_mps`, `gps_ve_mps` (speed and course), `gps_vd_mps`, `gps_sats`, `gps_time_s`; the position |
//! | GPA | `gps_vacc_m`, at its fix's time |
//! | IMU | `accel_*`, `gyro_*` |
//! | ATT | `roll_rad`, `pitch_rad`, `yaw_rad` (from half a turn below zero to half a turn above) |
//! | ARSP | `tas_mps` (from calibrated airspeed), and the airspeed as it stands |
//! | CTUN, THR, else RCOU | `throttle` |
//! | CTUN where there is no BARO | `baro_alt_m` |
//! | CTUN, XKF1 to 4 (NKF, EKF), AOA | signals `autopilot_*`: what the autopilot estimated |
//! | RCOU, VIBE | signals `output_*`, `vibration_*` |
//! | PARM | `parameter NAME` in the header |
//!
//! Times count from the autopilot's start: `TimeUS` or `TimeMS`, or interpolated between the receiver's times
//! where there is no other.

mod binary;
mod collect;
mod convert;
mod format;
mod gps;
mod rules;
mod text;
mod throttle;
mod units;

use crate::import::damage::percent;
use crate::import::{ImportError, Importer};
use flight_data::{Flight, Note};

use binary::Messages;
use collect::Collected;
use text::Lines;

/// A log is recognised by a definition within this many bytes.
const SNIFFED: usize = 1 << 16;

/// The importer of binary logs.
#[derive(Clone, Copy, Debug)]
pub struct DataFlash;

/// The importer of text logs.
#[derive(Clone, Copy, Debug)]
pub struct DataFlashText;

impl Importer for DataFlash {
    fn name(&self) -> &'static str {
        "ArduPilot DataFlash (.bin)"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        binary::has_definition(log.get(..SNIFFED).unwrap_or(log))
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let mut messages = Messages::new(log);
        let layouts = messages.layouts().to_vec();
        let mut collected = Collected::default();
        let mut unread = 0;
        for message in messages.by_ref() {
            unread += usize::from(!collected.take(&layouts, &message));
        }
        let mut notes = messages.damage.notes(log.len());
        for (count, what) in [
            (messages.undefined, "messages of kinds that the log does not define, left out"),
            (
                messages.bad_definitions,
                "definitions (FMT) that contradict themselves or another one, left out",
            ),
            (unread, "messages whose fields could not be read, left out"),
        ] {
            if count > 0 {
                notes.push(format!("{what}: {count}"));
            }
        }
        convert::convert(collected, &layouts, "byte", notes)
    }
}

impl Importer for DataFlashText {
    fn name(&self) -> &'static str {
        "ArduPilot DataFlash as text (.log)"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        text::has_definition(log.get(..SNIFFED).unwrap_or(log))
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let mut lines = Lines::new(log);
        let layouts = lines.layouts().to_vec();
        let mut collected = Collected::default();
        lines.preamble.iter().for_each(|line| collected.firmware_text(line));
        lines.each(|message| collected.take(&layouts, message));
        let text::Unread { lines: lost, first, undefined, bad_definitions } = lines.unread;
        let mut notes = Vec::new();
        if lost + bad_definitions > 0 {
            let all = log.iter().filter(|byte| **byte == b'\n').count();
            notes.push(format!(
                "damaged: lines that could not be read and were left out: {} ({}), the first is line {first}",
                lost + bad_definitions,
                percent(lost + bad_definitions, all)
            ));
        }
        if undefined > 0 {
            notes.push(format!("lines of kinds that the log does not define, left out: {undefined}"));
        }
        convert::convert(collected, &layouts, "line", notes)
    }
}

#[cfg(test)]
mod tests;
