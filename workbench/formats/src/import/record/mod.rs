//! Flight records: what a flight computer sends on its results' line (docs/bring-up.md says how to record
//! it), and what `pylon fly` gives one to fly.
//!
//! | in the record | in the flight |
//! |---|---|
//! | each tick's readings, as the drivers delivered them | the columns of the same name, at the tick's time |
//! | `imu_slave`, as the flight computer's strapdown channel made it | `imu_slave_alt_m`: `compare` does not make it anew |
//! | the launch as decided, and its doubt | `launch`, `launch_doubt` |
//! | the receiver's time of a fix | `gps_time_s`, from the first fix on |
//! | the latched calibration, the launch, the flags | header keys `flown_*`, beside which `compare` can be held |
//! | everything else that was estimated | nothing: a flight is what was measured |
//!
//! Every number is written with the digits that give the same `f32` back, and times to the microsecond, so
//! that a mission of the same model makes of the flight what the flight computer made of it, to the bit: same
//! biases, same flags at the same ticks. It does not where the flight computer was reset: `compare` flies
//! through, and what differs is said in a note. Only the times of fixes have less resolution than the
//! record's (24 bits), and serve to tell a held fix from a new one alone.

mod convert;
mod frames;
mod recording;

use crate::import::{ImportError, Importer};
use flight_data::{Flight, Note};

use frames::OtherVersion;
use recording::Recordings;

/// The importer of flight records.
#[derive(Clone, Copy, Debug)]
pub struct Record;

impl Importer for Record {
    fn name(&self) -> &'static str {
        "flight record"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        // One frame, anywhere: 32 bits of check are enough, and what lies before it may be any garbage.
        frames::has_frame(log)
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let mut recordings = Recordings::default();
        let losses =
            frames::read(log, &mut |event| recordings.take(event)).map_err(|OtherVersion(found)| {
                ImportError::RecordVersion { found, expected: flight_record::FORMAT_VERSION }
            })?;
        let (recording, left) =
            recordings.longest().map_err(|begins| convert::without_ticks(&begins, &losses))?;
        convert::convert(recording, left, &losses)
    }
}

#[cfg(test)]
mod tests;
