//! Finds frames in a recording.
//!
//! Source: MAVLink guide, "Packet Serialization".

use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message, calculate_crc};

use super::Sender;

/// Length of the receiver's time before each frame of a recording, bytes.
pub const STAMP: usize = 8;
/// The same for a stream as sent: no bytes.
pub const NO_STAMP: usize = 0;
/// Fewest frames of a stream without stamps: one frame's CRC has only 16 bits.
const LEAST_UNSTAMPED: usize = 3;
const MARKER_1: u8 = 0xfe;
const MARKER_2: u8 = 0xfd;
/// Length of marker and header.
const HEADER_1: usize = 6;
const HEADER_2: usize = 10;
const CRC: usize = 2;
const SIGNATURE: usize = 13;
/// Flag of a signed frame: the only flag supported among those that a reader must know.
const SIGNED: u8 = 1;

/// One message and its source.
#[derive(Clone, Debug)]
pub struct Packet {
    /// Time of reception, microseconds since 1970.
    pub recorded_us: u64,
    /// Number of its frame in the recording, from 1.
    pub number: usize,
    /// Its sender.
    pub sender: Sender,
    /// The message.
    pub message: MavMessage,
}

/// What was left out, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames with a wrong CRC.
    pub bad_crc: usize,
    /// Frames of messages outside MAVLink's common set; their CRC cannot be checked.
    pub unknown: usize,
    /// Frames with a right CRC whose payload is not a valid message (a value outside the enumeration).
    pub unreadable: usize,
    /// Bytes between frames that are not a frame.
    pub garbage_bytes: usize,
    /// Offset of the first of them.
    pub first_garbage: usize,
    /// Length of the recording, bytes.
    pub bytes: usize,
    /// Whether the last frame is cut off.
    pub cut: bool,
    /// Frames that were received earlier than the frame before them.
    pub backward: usize,
    /// Messages read.
    pub read: usize,
}

/// The messages of a recording, in its order.
pub struct Packets<'a> {
    log: &'a [u8],
    /// Length of the stamp before each frame.
    stamp: usize,
    at: usize,
    last_us: u64,
    losses: Losses,
}

/// What was found at an offset.
enum Found {
    /// A message and its length in bytes.
    Packet(Box<Packet>, usize),
    /// A frame that is not used, and its length in bytes.
    Skipped(usize),
    /// The beginning of a frame that the end of the file cuts off.
    Cut,
    /// Not a frame.
    Nothing,
}

/// A frame's parts.
struct Frame<'a> {
    version: MavlinkVersion,
    sender: Sender,
    id: u32,
    payload: &'a [u8],
    /// The bytes that the CRC covers: all after the marker.
    checked: &'a [u8],
    crc: u16,
    len: usize,
}

impl<'a> Packets<'a> {
    /// The messages of these bytes, with a stamp of `stamp` bytes before each frame.
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
        // A stream without stamps has no receiver's time.
        let recorded_us = stamp.first_chunk::<STAMP>().map_or(0, |stamp| u64::from_be_bytes(*stamp));
        let frame = match parse(rest) {
            Ok(frame) => frame,
            Err(found) => return found,
        };
        let len = self.stamp + frame.len;
        if MavMessage::default_message_from_id(frame.id).is_none() {
            // The only confirmation is that another frame follows.
            if !self.is_boundary(self.at + len) {
                return Found::Nothing;
            }
            self.losses.unknown += 1;
            return Found::Skipped(len);
        }
        if calculate_crc(frame.checked, MavMessage::extra_crc(frame.id)) != frame.crc {
            // Damaged, if another frame follows; otherwise a marker in garbage.
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

    /// Skips a byte that is not part of a frame.
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
                    // A marker in garbage near the end looks the same; if frames follow it, it was one.
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

/// Length of the stamp before each frame of a log, whichever gives more frames at its beginning; `None` if
/// there is no frame at all. A stream without stamps, read as one with stamps, would give every other frame
/// with a meaningless time.
pub fn stamp_length(beginning: &[u8]) -> Option<usize> {
    let frames = |stamp| Packets::new(beginning, stamp).count();
    let (stamped, unstamped) = (frames(STAMP), frames(NO_STAMP));
    if unstamped > stamped && unstamped >= LEAST_UNSTAMPED {
        return Some(NO_STAMP);
    }
    (stamped > 0).then_some(STAMP)
}

/// The frame at the beginning of these bytes, with its CRC not yet checked.
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

/// The frames with messages in bytes without stamps, up to the first bytes that are not one.
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
