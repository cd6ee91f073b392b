//! Frames in a recording.
//!
//! Source: MAVLink guide, "Packet Serialization".

use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message, calculate_crc};

use super::Sender;

/// Bytes of the receiver's time before each frame of a recording.
pub const STAMP: usize = 8;
/// Bytes before each frame of a stream as it was sent.
pub const NO_STAMP: usize = 0;
/// A stream without stamps has at least so many frames: the check of one has 16 bits.
const LEAST_UNSTAMPED: usize = 3;
const MARKER_1: u8 = 0xfe;
const MARKER_2: u8 = 0xfd;
/// Marker and header.
const HEADER_1: usize = 6;
const HEADER_2: usize = 10;
const CRC: usize = 2;
const SIGNATURE: usize = 13;
/// The flag of a signed frame, the only one of those that a reader must know that is read here.
const SIGNED: u8 = 1;

/// One message and where it comes from.
#[derive(Clone, Debug)]
pub struct Packet {
    /// When it was received, microseconds since 1970.
    pub recorded_us: u64,
    /// Which of the recording's frames it is, from 1.
    pub number: usize,
    /// Who sent it.
    pub sender: Sender,
    /// The message.
    pub message: MavMessage,
}

/// What was left out, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames whose CRC is wrong.
    pub bad_crc: usize,
    /// Frames of messages that MAVLink's common set does not have; their CRC cannot be checked.
    pub unknown: usize,
    /// Frames whose CRC is right and whose payload makes no message (a value that the enumeration lacks).
    pub unreadable: usize,
    /// Bytes that are no frame, between frames.
    pub garbage_bytes: usize,
    /// Where the first of them is.
    pub first_garbage: usize,
    /// Bytes of all.
    pub bytes: usize,
    /// Whether the last frame is cut off.
    pub cut: bool,
    /// Frames that were received before the one before them.
    pub backward: usize,
    /// Messages that were read.
    pub read: usize,
}

/// The messages of a recording, in its order.
pub struct Packets<'a> {
    log: &'a [u8],
    /// Bytes before each frame.
    stamp: usize,
    at: usize,
    last_us: u64,
    losses: Losses,
}

/// What is at a place.
enum Found {
    /// A message, and the bytes that it takes.
    Packet(Box<Packet>, usize),
    /// A frame that is of no use, and the bytes that it takes.
    Skipped(usize),
    /// The beginning of a frame, which the end of the file cuts off.
    Cut,
    /// No frame.
    Nothing,
}

/// A frame's parts.
struct Frame<'a> {
    version: MavlinkVersion,
    sender: Sender,
    id: u32,
    payload: &'a [u8],
    /// What the CRC is of: all after the marker.
    checked: &'a [u8],
    crc: u16,
    len: usize,
}

impl<'a> Packets<'a> {
    /// The messages of these bytes, before each of whose frames there are so many of a stamp.
    pub fn new(log: &'a [u8], stamp: usize) -> Self {
        Self { log, stamp, at: 0, last_us: 0, losses: Losses { bytes: log.len(), ..Losses::default() } }
    }

    /// What was left out.
    pub fn losses(self) -> Losses {
        self.losses
    }

    fn find(&mut self) -> Found {
        let Some(rest) = self.log.get(self.at..) else { return Found::Nothing };
        let Some((stamp, rest)) = rest.split_at_checked(self.stamp) else { return Found::Nothing };
        // A stream without stamps says no receiver's time.
        let recorded_us = stamp.first_chunk::<STAMP>().map_or(0, |stamp| u64::from_be_bytes(*stamp));
        let frame = match parse(rest) {
            Ok(frame) => frame,
            Err(found) => return found,
        };
        let len = self.stamp + frame.len;
        if MavMessage::default_message_from_id(frame.id).is_none() {
            // Nothing vouches for it but that another frame follows.
            if !self.is_boundary(self.at + len) {
                return Found::Nothing;
            }
            self.losses.unknown += 1;
            return Found::Skipped(len);
        }
        if calculate_crc(frame.checked, MavMessage::extra_crc(frame.id)) != frame.crc {
            // Damaged, if another frame follows; else a marker in garbage.
            if !self.is_boundary(self.at + len) {
                return Found::Nothing;
            }
            self.losses.bad_crc += 1;
            return Found::Skipped(len);
        }
        let Ok(message) = MavMessage::parse(frame.version, frame.id, frame.payload) else {
            self.losses.unreadable += 1;
            return Found::Skipped(len);
        };
        let losses = &self.losses;
        let number = losses.read + losses.bad_crc + losses.unknown + losses.unreadable + 1;
        let packet = Packet { recorded_us, number, sender: frame.sender, message };
        Found::Packet(Box::new(packet), len)
    }

    /// Goes over a byte that is no frame.
    fn skip(&mut self) {
        if self.losses.garbage_bytes == 0 {
            self.losses.first_garbage = self.at;
        }
        self.losses.garbage_bytes += 1;
        self.at += 1;
    }

    /// Whether the log ends there, or has a marker where the next frame must have one.
    fn is_boundary(&self, at: usize) -> bool {
        at == self.log.len() || matches!(self.log.get(at + self.stamp), Some(&(MARKER_1 | MARKER_2)))
    }
}

impl Iterator for Packets<'_> {
    type Item = Packet;

    fn next(&mut self) -> Option<Packet> {
        while self.at < self.log.len() {
            match self.find() {
                Found::Packet(packet, len) => {
                    self.at += len;
                    self.losses.read += 1;
                    self.losses.backward += usize::from(packet.recorded_us < self.last_us);
                    self.last_us = packet.recorded_us;
                    return Some(*packet);
                }
                Found::Skipped(len) => self.at += len,
                Found::Cut => {
                    // A marker in garbage near the end looks the same; if there are frames after it, it was
                    // that.
                    let mut rest = Packets::new(self.log.get(self.at + 1..).unwrap_or_default(), self.stamp);
                    rest.losses.cut = true;
                    if self.losses.cut || rest.next().is_none() {
                        self.losses.cut = true;
                        self.at = self.log.len();
                    } else {
                        self.skip();
                    }
                }
                Found::Nothing => self.skip(),
            }
        }
        None
    }
}

/// Bytes before each frame of a log, by what its beginning has more of; `None` where it has no frame at all.
/// A stream without stamps read as one with them would give every other frame, with a time of nothing.
pub fn stamp_length(beginning: &[u8]) -> Option<usize> {
    let frames = |stamp| Packets::new(beginning, stamp).count();
    let (stamped, unstamped) = (frames(STAMP), frames(NO_STAMP));
    if unstamped > stamped && unstamped >= LEAST_UNSTAMPED {
        return Some(NO_STAMP);
    }
    (stamped > 0).then_some(STAMP)
}

/// The frame that these bytes begin with, its CRC not yet checked.
fn parse(bytes: &[u8]) -> Result<Frame<'_>, Found> {
    let byte = |at: usize| bytes.get(at).copied().ok_or(Found::Cut);
    let marker = bytes.first().ok_or(Found::Nothing)?;
    let (version, header) = match *marker {
        MARKER_1 => (MavlinkVersion::V1, HEADER_1),
        MARKER_2 => (MavlinkVersion::V2, HEADER_2),
        _ => return Err(Found::Nothing),
    };
    let payload_len = usize::from(byte(1)?);
    let (sender, id, signature) = match version {
        MavlinkVersion::V1 => ((u32::from(byte(3)?), byte(4)?), u32::from(byte(5)?), 0),
        MavlinkVersion::V2 => {
            let flags = byte(2)?;
            if flags & !SIGNED != 0 {
                return Err(Found::Nothing);
            }
            let id = u32::from_le_bytes([byte(7)?, byte(8)?, byte(9)?, 0]);
            ((u32::from(byte(5)?), byte(6)?), id, if flags & SIGNED == 0 { 0 } else { SIGNATURE })
        }
    };
    let end = header + payload_len;
    let len = end + CRC + signature;
    let (Some(payload), Some(checked), Some(&[low, high]), true) =
        (bytes.get(header..end), bytes.get(1..end), bytes.get(end..end + CRC), bytes.len() >= len)
    else {
        return Err(Found::Cut);
    };
    Ok(Frame { version, sender, id, payload, checked, crc: u16::from_le_bytes([low, high]), len })
}

/// The frames with messages in bytes without stamps, up to the first that is none.
pub fn unstamped(line: &[u8]) -> impl Iterator<Item = (&[u8], Packet)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = line.get(at..)?;
        let frame = parse(rest).ok()?;
        let is_whole = calculate_crc(frame.checked, MavMessage::extra_crc(frame.id)) == frame.crc;
        let message = MavMessage::parse(frame.version, frame.id, frame.payload).ok().filter(|_| is_whole)?;
        at += frame.len;
        Some((rest.get(..frame.len)?, Packet { recorded_us: 0, number: 0, sender: frame.sender, message }))
    })
}
