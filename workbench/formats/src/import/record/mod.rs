//! Flight records: what a flight computer sends on its results line (docs/bring-up.md explains how to record
//! it), and what `pylon fly` gives it to fly.
//!
//! | in the record | in the flight |
//! |---|---|
//! | each tick's readings, as the drivers delivered them | the columns of the same name, at the tick's time |
//! | `imu_slave`, as flown by the strapdown channel | `imu_slave_alt_m`; `compare` does not recompute it |
//! | the launch as decided, and its doubt | `launch`, `launch_doubt` |
//! | the receiver's time of a fix | `gps_time_s`, from the first fix on |
//! | the latched calibration, the launch, the flags | header keys `flown_*`, to check `compare` against |
//! | all other estimates | left out: a flight contains what was measured |
//!
//! Every number is written with the digits that give the same `f32` back, and times to the microsecond. A
//! mission of the same model therefore computes from the flight what the flight computer did, to the bit:
//! same biases, same flags at the same ticks. This does not hold where the flight computer was reset:
//! `compare` flies on, and a note reports what differs. Only the times of fixes have less resolution than in
//! the record (24 bits); they only serve to distinguish a held fix from a new one.

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
        // One frame anywhere is enough with a 32-bit CRC; the bytes before it may be anything.
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
