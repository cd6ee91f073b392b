//! A recording of a telemetry line (`.tlog`), as a ground station makes it.
//!
//! The emulated flight computer's line has no clock. A frame is stamped with the time of flight of the last
//! message before it that has one; no line delivers it later than that.

use crate::import::tlog::frames;

/// The recording of a line's bytes, for a flight computer started at that time (microseconds since 1970). It
/// ends before the first bytes that are not a frame.
#[must_use]
pub fn recording(line: &[u8], start_us: u64) -> Vec<u8> {
    let mut log = Vec::with_capacity(line.len() + line.len() / 4);
    let mut boot_us = 0;
    for (frame, time_us) in frames(line) {
        boot_us = time_us.unwrap_or(boot_us).max(boot_us);
        log.extend_from_slice(&(start_us + boot_us).to_be_bytes());
        log.extend_from_slice(frame);
    }
    log
}
