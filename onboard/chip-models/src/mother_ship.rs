//! The mother ship at the other end of the umbilical: its inertial altitude as MAVLink 2 ALTITUDE (#141),
//! with the heartbeat (#0) that every MAVLink system sends once a second
//! (<https://mavlink.io/en/guide/serialization.html>,
//! <https://mavlink.io/en/messages/common.html>).

use core::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady};

use crate::line::Line;

/// Message id, and the byte that the message's definition adds to the checksum.
const HEARTBEAT: (u32, u8) = (0, 50);
const ALTITUDE: (u32, u8) = (141, 47);
/// MAV_TYPE_FIXED_WING, MAV_AUTOPILOT_INVALID, no mode, MAV_STATE_ACTIVE, MAVLink 2.
const HEARTBEAT_PAYLOAD: [u8; 9] = [0, 0, 0, 0, 1, 8, 0, 4, 3];
const HEARTBEAT_US: u64 = 1_000_000;
/// MAV_COMP_ID_AUTOPILOT1.
const COMPONENT: u8 = 1;

/// Time between two altitudes of another system, microseconds.
const STRANGER_US: u64 = 100_000;

/// Faults of the mother ship's messages.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MotherShipFault {
    /// No fault.
    #[default]
    None,
    /// The mother ship sends nothing.
    Silent,
    /// Another system sends altitudes too.
    Stranger {
        /// MAVLink system id of the other system.
        system: u8,
        /// Its component id.
        component: u8,
        /// Altitude that it sends, metres.
        altitude_m: f32,
    },
    /// The mother ship's altitude has an error.
    Lies {
        /// Error, positive upward, metres.
        by_m: f32,
    },
    /// She sends the same altitude for ever.
    Holds,
}

/// The mother ship and the line to the UAV.
#[derive(Clone, Debug)]
pub struct MotherShipModel {
    /// The line to the UAV.
    pub line: Line,
    /// Present fault.
    pub fault: MotherShipFault,
    system: u8,
    sequence: u8,
    is_attached: bool,
    now_us: u64,
    next_heartbeat_us: u64,
    next_stranger_us: u64,
    /// The last altitude sent, metres.
    sent_m: Option<f32>,
}

impl MotherShipModel {
    /// A mother ship with that MAVLink system id, at a line speed in baud.
    pub const fn new(system: u8, baud: u32) -> Self {
        Self {
            line: Line::new(baud),
            fault: MotherShipFault::None,
            system,
            sequence: 0,
            is_attached: true,
            now_us: 0,
            next_heartbeat_us: 0,
            next_stranger_us: 0,
            sent_m: None,
        }
    }

    /// Sets whether the other end of the line is connected. After separation nothing is sent, and bytes not
    /// yet sent are lost.
    pub fn set_attached(&mut self, is_attached: bool) {
        self.is_attached = is_attached;
        if !is_attached {
            self.line.cut();
        }
    }

    /// Lets time pass up to `now_us`, microseconds, which never goes backward.
    pub fn set_time(&mut self, now_us: u64) {
        self.now_us = now_us;
        if self.next_heartbeat_us <= now_us {
            if self.fault != MotherShipFault::Silent {
                self.send((self.system, COMPONENT), HEARTBEAT, &HEARTBEAT_PAYLOAD);
            }
            self.next_heartbeat_us = now_us.saturating_add(HEARTBEAT_US);
        }
        if let MotherShipFault::Stranger { system, component, altitude_m } = self.fault
            && self.next_stranger_us <= now_us
        {
            self.send_altitude((system, component), altitude_m);
            self.next_stranger_us = now_us.saturating_add(STRANGER_US);
        }
        self.line.carry_until(now_us);
    }

    /// Sends an inertial altitude that the mother ship has computed, metres above mean sea level. Fields
    /// without a value are NaN.
    pub fn navigate(&mut self, altitude_m: f32) {
        let altitude_m = match self.fault {
            MotherShipFault::Silent => return,
            MotherShipFault::Lies { by_m } => altitude_m + by_m,
            MotherShipFault::Holds => self.sent_m.unwrap_or(altitude_m),
            MotherShipFault::None | MotherShipFault::Stranger { .. } => altitude_m,
        };
        self.sent_m = Some(altitude_m);
        self.send_altitude((self.system, COMPONENT), altitude_m);
    }

    fn send_altitude(&mut self, sender: (u8, u8), altitude_m: f32) {
        let mut payload = [0; 32];
        let time = self.now_us.to_le_bytes();
        let values = [altitude_m, altitude_m, f32::NAN, f32::NAN, f32::NAN, f32::NAN];
        let bytes = time.into_iter().chain(values.into_iter().flat_map(f32::to_le_bytes));
        for (slot, byte) in payload.iter_mut().zip(bytes) {
            *slot = byte;
        }
        self.send(sender, ALTITUDE, &payload);
    }

    /// Sends a MAVLink 2 frame. Zeros at the end of its payload are left out, except for the first byte.
    fn send(&mut self, (system, component): (u8, u8), (identity, extra): (u32, u8), payload: &[u8]) {
        if !self.is_attached {
            return;
        }
        let length = payload.iter().rposition(|&byte| byte != 0).map_or(1, |last| last + 1);
        let [a, b, c, _] = identity.to_le_bytes();
        let header =
            [u8::try_from(length).unwrap_or(u8::MAX), 0, 0, self.sequence, system, component, a, b, c];
        self.sequence = self.sequence.wrapping_add(1);
        let mut sum = Crc16::new();
        self.line.send(0xFD);
        for &byte in header.iter().chain(payload.iter().take(length)) {
            sum.add(byte);
            self.line.send(byte);
        }
        sum.add(extra);
        sum.0.to_le_bytes().into_iter().for_each(|byte| self.line.send(byte));
    }
}

/// CRC-16/MCRF4XX (the guide's "X.25"), computed bit by bit.
struct Crc16(u16);

impl Crc16 {
    const fn new() -> Self {
        Self(0xFFFF)
    }

    fn add(&mut self, byte: u8) {
        self.0 ^= u16::from(byte);
        for _ in 0..8 {
            let carry = self.0 & 1 != 0;
            self.0 = (self.0 >> 1) ^ if carry { 0x8408 } else { 0 };
        }
    }
}

impl ErrorType for MotherShipModel {
    type Error = Infallible;
}

impl ReadReady for MotherShipModel {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.line.has_arrived())
    }
}

impl Read for MotherShipModel {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.line.read(buffer))
    }
}

#[cfg(test)]
mod tests {
    use mavlink::dialects::common::{ALTITUDE_DATA, HEARTBEAT_DATA, MavMessage};
    use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, MessageData};

    use super::*;

    fn sent(model: &mut MotherShipModel) -> Vec<u8> {
        model.line.carry_until(1_000_000);
        let mut bytes = vec![0; 200];
        let count = model.read(&mut bytes).unwrap();
        bytes.truncate(count);
        bytes
    }

    fn by_the_crate(sequence: u8, message: &MavMessage) -> Vec<u8> {
        let mut frame = MAVLinkV2MessageRaw::new();
        frame.serialize_message(MavHeader { system_id: 7, component_id: 1, sequence }, message);
        frame.raw_bytes().to_vec()
    }

    /// The frames equal the `mavlink` crate's, byte for byte.
    #[test]
    fn frames_are_those_of_the_crate() {
        let mut model = MotherShipModel::new(7, 115_200);
        model.set_time(0);
        model.now_us = 123_456_789;
        model.navigate(2_104.25);
        let heartbeat = HEARTBEAT_DATA::deser(MavlinkVersion::V2, &HEARTBEAT_PAYLOAD).unwrap();
        let altitude = ALTITUDE_DATA {
            time_usec: 123_456_789,
            altitude_monotonic: 2_104.25,
            altitude_amsl: 2_104.25,
            altitude_local: f32::NAN,
            altitude_relative: f32::NAN,
            altitude_terrain: f32::NAN,
            bottom_clearance: f32::NAN,
        };
        let expected = [
            by_the_crate(0, &MavMessage::HEARTBEAT(heartbeat)),
            by_the_crate(1, &MavMessage::ALTITUDE(altitude)),
        ];
        assert_eq!(sent(&mut model), expected.concat());
    }
}
