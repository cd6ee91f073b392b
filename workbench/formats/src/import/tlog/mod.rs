//! Recordings of MAVLink streams (`.tlog`), as made by ground stations: before each frame of the stream, the
//! receiver's time as 8 bytes, big-endian, microseconds since 1970. Streams as sent, without these times, are
//! read too.
//!
//! | in the log | in the flight |
//! |---|---|
//! | HIGHRES_IMU | `accel_*`, `gyro_*`, `baro_pa` (from hectopascals) or `baro_alt_m`, `baro_temp_c` |
//! | SCALED_IMU, SCALED_PRESSURE | the same, where there is no HIGHRES_IMU |
//! | GPS_RAW_INT | `gps_alt_m`, `gps_vn_mps`, `gps_ve_mps` (speed and course), `gps_sats`, `gps_vacc_m`; the position |
//! | GLOBAL_POSITION_INT | where there is no GPS_RAW_INT, the reference; beside it, its velocity down |
//! | ATTITUDE | `roll_rad`, `pitch_rad`, `yaw_rad` |
//! | VFR_HUD | `tas_mps` (from calibrated airspeed), `throttle` |
//! | HEARTBEAT of a Pylon | `launch`, where its `launch` value is missing |
//! | NAMED_VALUE_FLOAT of a Pylon | `launch`, `imu_master_alt_m`, `imu_slave_alt_m`, `gps_vd_mps`, `tas_mps`, `aoa_rad`, `sideslip_rad`, `throttle`, `oat_c` ([`telemetry::named`]) |
//!
//! A Pylon's estimates (biases, errors, flags) are left out: a flight contains what was measured, and
//! `compare` computes the rest again. MAVLink 1 and 2 are read, signatures are not checked. Times are the
//! sender's where a message has one, else the receiver's less the least delay seen (ignoring one in a
//! hundred). A receiver's time has no CRC: frames whose time contradicts the frames around them and the
//! message's own time are left out.

mod clock;
mod convert;
mod frame;
mod received;
mod rows;
mod value;

use std::collections::BTreeMap;

use crate::import::{ImportError, Importer};
use flight_data::{Flight, Note};

use frame::{NO_STAMP, Packets, STAMP, stamp_length};
use received::Received;
use value::Timed;

/// A log is recognised by a frame within this many bytes.
const SNIFFED: usize = 1 << 16;

/// The importer of recorded MAVLink streams.
#[derive(Clone, Copy, Debug)]
pub struct Tlog;

impl Importer for Tlog {
    fn name(&self) -> &'static str {
        "MAVLink tlog"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        stamp_length(log.get(..SNIFFED).unwrap_or(log)).is_some()
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let stamp = stamp_length(log.get(..SNIFFED).unwrap_or(log)).unwrap_or(STAMP);
        let (sender, others) = sender(log, stamp);
        let mut received = Received::new(stamp == NO_STAMP);
        let mut packets = Packets::new(log, stamp);
        for packet in packets.by_ref().filter(|packet| packet.sender == sender) {
            received.take(&packet);
        }
        let (values, left_out) = received.believed();
        convert::convert(sender, values, packets.losses(), others, left_out)
    }
}

/// A component of a vehicle: system and component.
type Sender = (u32, u8);

/// The sender of most of the useful messages, and how many messages others sent.
fn sender(log: &[u8], stamp: usize) -> (Sender, usize) {
    let mut useful: BTreeMap<Sender, usize> = BTreeMap::new();
    let mut total = 0;
    let mut of_sender: BTreeMap<Sender, usize> = BTreeMap::new();
    let mut values: Vec<Timed> = Vec::new();
    for packet in Packets::new(log, stamp) {
        values.clear();
        value::take(&packet, &mut values);
        *useful.entry(packet.sender).or_default() += values.len();
        *of_sender.entry(packet.sender).or_default() += 1;
        total += 1;
    }
    let best = useful.iter().max_by_key(|(sender, count)| (**count, std::cmp::Reverse(**sender)));
    let best = best.map(|(sender, _)| *sender).unwrap_or_default();
    (best, total - of_sender.get(&best).copied().unwrap_or_default())
}

/// The complete frames of a line without receiver's times, each with the time since the sender's start that
/// its message gives, microseconds.
pub fn frames(line: &[u8]) -> impl Iterator<Item = (&[u8], Option<u64>)> {
    frame::unstamped(line).map(|(frame, packet)| {
        let mut values = Vec::new();
        value::take(&packet, &mut values);
        (frame, values.iter().find_map(|timed| clock::boot_us(timed.stamp)))
    })
}

#[cfg(test)]
mod tests;
