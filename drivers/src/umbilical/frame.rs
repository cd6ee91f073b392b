//! Finds MAVLink 2 frames with an altitude in a stream of bytes.
//!
//! Only what can be such a frame is kept: the first byte of a header that is none ends the attempt, and the search goes on
//! at the byte after the one it began with. So whatever comes before a whole frame, the frame is found; and no byte
//! costs more than one pass over the longest frame.

use mavlink::MessageData;
use mavlink::dialects::common::ALTITUDE_DATA;

/// Start of a MAVLink 2 frame.
const START: u8 = 0xFD;
/// Start, length, two bytes of flags, sequence, system, component, three bytes of the message's identity.
const HEADER: usize = 10;
const PAYLOAD: usize = ALTITUDE_DATA::ENCODED_LEN;
const CHECK: usize = 2;
const LONGEST: usize = HEADER + PAYLOAD + CHECK;
/// The frame is signed: 13 bytes follow, which are passed over. A receiver must discard a frame with any other flag.
const SIGNED: u8 = 0x01;
const IDENTITY: [u8; 4] = ALTITUDE_DATA::ID.to_le_bytes();

/// What the next bytes were.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// The payload of a frame whose checksum is right, with the zeros that the sender left out at its end.
    Altitude([u8; PAYLOAD]),
    /// A whole frame, but for its checksum. Its bytes are looked at again.
    BadChecksum,
    /// A byte that begins no frame with an altitude.
    OtherByte,
}

/// The bytes since the last frame, as far as they may be the next.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    bytes: [u8; LONGEST],
    len: usize,
    /// The frame at the front has been found wrong.
    rejected: bool,
}

impl Frames {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; LONGEST], len: 0, rejected: false }
    }

    /// Takes one byte; [`Self::next_found`] must have said `None` before.
    pub(super) fn push(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
    }

    /// What the bytes so far were; `None` until more have come.
    pub(super) fn next_found(&mut self) -> Option<Found> {
        if self.len == 0 {
            return None;
        }
        if self.rejected || !self.may_be_frame() {
            self.rejected = false;
            self.drop_front(1);
            return Some(Found::OtherByte);
        }
        let payload_len = self.payload_len();
        let end = HEADER + payload_len + CHECK;
        if self.len < HEADER || self.len < end {
            return None;
        }
        let checked = self.bytes.get(1..HEADER + payload_len).unwrap_or_default();
        let sum = mavlink::calculate_crc(checked, ALTITUDE_DATA::EXTRA_CRC).to_le_bytes();
        if self.bytes.get(end - CHECK..end) != Some(&sum[..]) {
            self.rejected = true;
            return Some(Found::BadChecksum);
        }
        let mut payload = [0; PAYLOAD];
        for (slot, byte) in payload.iter_mut().zip(self.bytes.iter().skip(HEADER).take(payload_len)) {
            *slot = *byte;
        }
        self.drop_front(end);
        Some(Found::Altitude(payload))
    }

    fn payload_len(&self) -> usize {
        usize::from(self.bytes[1])
    }

    /// Whether the bytes so far are those of a frame with an altitude.
    fn may_be_frame(&self) -> bool {
        let [start, length, incompatible, _, _, _, _, a, b, c, ..] = self.bytes;
        let conditions = [
            (0, start == START),
            (1, (1..=PAYLOAD).contains(&usize::from(length))),
            (2, incompatible & !SIGNED == 0),
            (7, a == IDENTITY[0]),
            (8, b == IDENTITY[1]),
            (9, c == IDENTITY[2]),
        ];
        conditions.iter().all(|&(place, holds)| place >= self.len || holds)
    }

    fn drop_front(&mut self, count: usize) {
        let kept = self.len.saturating_sub(count);
        for place in 0..kept {
            let byte = self.bytes.get(place + count).copied().unwrap_or_default();
            if let Some(slot) = self.bytes.get_mut(place) {
                *slot = byte;
            }
        }
        self.len = kept;
    }
}
