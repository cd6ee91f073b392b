//! The mother ship's inertial altitude over the umbilical: MAVLink 2 on a UART
//! (<https://mavlink.io/en/guide/serialization.html>; the message is the `mavlink` crate's).
//!
//! # The message
//! ALTITUDE (#141), its field `altitude_amsl`: metres above mean sea level as a 32-bit float, so the link
//! adds no quantum of its own. (GLOBAL_POSITION_INT has millimetres, but is by definition a position fused
//! with satellites; the reference must not come back as a second sensor.) The mother ship puts its inertial
//! altitude there. Other messages on the line are skipped, and so are other senders' altitudes: many
//! autopilots put a fused one there, and a ground station's radio bridge carries those of every vehicle that
//! it receives.
//!
//! # Errors
//! A frame with a wrong checksum is an error of that poll, and so is an altitude outside of [`ALTITUDES_M`].
//! A link that has delivered and is then silent for [`SILENT_AFTER_US`] while the UAV is attached is an error
//! too. Once a launch is decided the link is gone: nothing is read from it, whatever noise an open line
//! carries, and that is no fault.

mod frame;
#[cfg(test)]
mod tests;

use core::ops::RangeInclusive;

use embedded_io::{Read, ReadReady};
use kf_core::guard::Guard;
use mavlink::dialects::common::ALTITUDE_DATA;
use mavlink::{MavlinkVersion, MessageData};

use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::AltitudeLink;
use frame::{Found, Frames};

/// Largest number of bytes that one poll takes: at 115,200 baud 58 arrive in 5 ms.
pub const MAX_POLL_BYTES: usize = 128;
/// Duration of a silence that is an error, microseconds. Each further such time is another error.
pub const SILENT_AFTER_US: u64 = 1_000_000;

/// Altitudes that a mother ship can have, metres: from below the shore of the Dead Sea to above every
/// balloon.
pub const ALTITUDES_M: RangeInclusive<f32> = -1_000.0..=60_000.0;

/// Address of a MAVLink system and its component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sender {
    /// The system's id.
    pub system: u8,
    /// The component's id.
    pub component: u8,
}

impl Sender {
    /// The first system's autopilot (`MAV_COMP_ID_AUTOPILOT1`), the address of most mother ships.
    pub const FIRST_AUTOPILOT: Self = Self { system: 1, component: 1 };
}

/// Traffic on the line since power-up. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Bytes received, of any kind.
    pub bytes: u32,
    /// Bytes that belonged to no frame with an altitude: other messages, and garbage.
    pub other_bytes: u32,
    /// Frames of the mother ship with an altitude and a right checksum.
    pub frames: u32,
    /// The same of other senders.
    pub other_senders: u32,
    /// Altitudes that are not finite, or that no mother ship can have.
    pub implausible: u32,
    /// Apparent frames with an altitude whose checksum was wrong.
    pub bad_frames: u32,
    /// Altitudes that a newer one in the same poll replaced.
    pub superseded: u32,
}

/// The driver.
#[derive(Clone, Debug)]
pub struct Umbilical<Port> {
    port: Port,
    mother_ship: Sender,
    /// Bytes that have arrived and were not read yet: the first `waiting` ones.
    bytes: [u8; MAX_POLL_BYTES],
    waiting: usize,
    frames: Frames,
    attached: bool,
    /// Time of the last altitude, or of the last error about its absence.
    heard_us: Option<u64>,
    health: Health,
    counts: LinkCounts,
}

impl<Port: Read + ReadReady> Umbilical<Port> {
    /// A driver that has received nothing yet, attached to the mother ship with that address.
    pub const fn new(port: Port, mother_ship: Sender) -> Self {
        Self {
            port,
            mother_ship,
            bytes: [0; MAX_POLL_BYTES],
            waiting: 0,
            frames: Frames::new(),
            attached: true,
            heard_us: None,
            health: Health::new(),
            counts: LinkCounts {
                bytes: 0,
                other_bytes: 0,
                frames: 0,
                other_senders: 0,
                implausible: 0,
                bad_frames: 0,
                superseded: 0,
            },
        }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// The line's counts.
    pub const fn link_counts(&self) -> LinkCounts {
        self.counts
    }

    /// The port, for a test or a board that accesses the mother ship's model.
    pub const fn port_mut(&mut self) -> &mut Port {
        &mut self.port
    }

    /// Appends the bytes that have arrived to those that wait.
    fn receive(&mut self) -> Result<(), SensorError> {
        let room = self.bytes.get_mut(self.waiting..).unwrap_or_default();
        let arrived = crate::port::receive(&mut self.port, room)?;
        self.counts.bytes = self.counts.bytes.saturating_add(u32::try_from(arrived).unwrap_or(u32::MAX));
        self.waiting += arrived;
        Ok(())
    }

    fn step(&mut self, now_us: u64) -> Result<Option<f32>, SensorError> {
        if !self.attached {
            return Ok(None);
        }
        self.receive()?;
        let mut newest = None;
        let mut bad = false;
        let mut rest = self.bytes.get(..self.waiting).unwrap_or_default();
        self.waiting = 0;
        while let taken @ 1.. = self.frames.take(rest) {
            rest = rest.get(taken..).unwrap_or_default();
            while let Some(found) = self.frames.next_found() {
                match found {
                    Found::Altitude { sender, .. }
                        if sender != self.mother_ship && Guard::KnownSender.stands() =>
                    {
                        count(&mut self.counts.other_senders);
                    }
                    Found::Altitude { payload, .. } => {
                        count(&mut self.counts.frames);
                        if newest.replace(payload).is_some() {
                            count(&mut self.counts.superseded);
                        }
                    }
                    Found::BadChecksum => {
                        count(&mut self.counts.bad_frames);
                        bad = true;
                    }
                    Found::OtherBytes(others) => {
                        let others = u32::try_from(others).unwrap_or(u32::MAX);
                        self.counts.other_bytes = self.counts.other_bytes.saturating_add(others);
                    }
                }
            }
        }
        // The payload has been extended to its full length, so this decodes.
        let altitude_m = newest
            .and_then(|payload| ALTITUDE_DATA::deser(MavlinkVersion::V2, &payload).ok())
            .map(|message| message.altitude_amsl);
        if let Some(altitude_m) = altitude_m {
            self.heard_us = Some(now_us);
            if ALTITUDES_M.contains(&altitude_m) {
                return Ok(Some(altitude_m));
            }
            count(&mut self.counts.implausible);
            return Err(SensorError::OutOfRange);
        }
        if bad {
            return Err(SensorError::Check);
        }
        match self.heard_us {
            Some(heard_us) if now_us.saturating_sub(heard_us) > SILENT_AFTER_US => {
                self.heard_us = Some(now_us);
                Err(SensorError::Stale)
            }
            _ => Ok(None),
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl<Port: Read + ReadReady> AltitudeLink for Umbilical<Port> {
    fn poll(&mut self, now_us: u64) -> Result<Option<f32>, SensorError> {
        let outcome = self.step(now_us);
        self.health.note(outcome)
    }

    fn put_off(&mut self) -> Result<bool, SensorError> {
        if self.attached {
            let outcome = self.receive().map(|()| None::<()>);
            self.health.note(outcome)?;
        }
        Ok(self.attached)
    }

    fn set_attached(&mut self, attached: bool) {
        if self.attached != attached {
            self.attached = attached;
            self.waiting = 0;
            self.heard_us = None;
            self.frames = Frames::new();
        }
    }
}
