//! Finds MAVLink 2 frames with an altitude in a stream of bytes.
//!
//! Only bytes that can be such a frame are kept. The first byte that does not fit a header ends the attempt,
//! and the search continues after the byte with which the attempt began. A whole frame is therefore found
//! whatever precedes it, and no byte costs more than one pass over the longest frame.

use crc::{CRC_16_MCRF4XX, Crc};
use mavlink::MessageData;
use mavlink::dialects::common::ALTITUDE_DATA;

use super::Sender;

/// MAVLink's "X.25" checksum, called MCRF4XX in the catalogue of CRCs. By table, because the `mavlink`
/// crate's own takes half of a poll.
const CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_MCRF4XX);
/// Start of a MAVLink 2 frame.
const START: u8 = 0xFD;
/// Start, length, two bytes of flags, sequence, system, component, three bytes of the message's id.
const HEADER: usize = 10;
/// Index of the sender in it.
const SYSTEM: usize = 5;
const COMPONENT: usize = 6;
const PAYLOAD: usize = ALTITUDE_DATA::ENCODED_LEN;
const CHECK: usize = 2;
const LONGEST: usize = HEADER + PAYLOAD + CHECK;
/// The frame is signed: 13 bytes follow, which are skipped. A receiver must discard a frame with any other
/// flag.
const SIGNED: u8 = 0x01;
const IDENTITY: [u8; 4] = ALTITUDE_DATA::ID.to_le_bytes();

/// Classification of the next bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// A frame whose checksum is right.
    Altitude {
        /// The sender.
        sender: Sender,
        /// Its payload, with the zeros that the sender omitted at its end.
        payload: [u8; PAYLOAD],
    },
    /// A whole frame with a wrong checksum. Its bytes are searched again.
    BadChecksum,
    /// This many bytes that belong to no frame with an altitude.
    OtherBytes(usize),
}

/// The bytes since the last frame that may belong to the next one.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    bytes: [u8; LONGEST],
    len: usize,
    /// Number of bytes that were found to fit a frame's header; at most `len`.
    fitting: usize,
    /// The frame at the front was found wrong.
    rejected: bool,
}

impl Frames {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; LONGEST], len: 0, fitting: 0, rejected: false }
    }

    /// Takes as many bytes from the front as can be taken before they are checked, and returns their number:
    /// at least one, if there is one. [`Self::next_found`] must have returned `None` before.
    pub(super) fn take(&mut self, bytes: &[u8]) -> usize {
        // The end of a frame is known once its header is complete.
        let wanted = if self.fitting < HEADER { HEADER } else { self.end() };
        let count = wanted.saturating_sub(self.len).min(bytes.len());
        match (self.bytes.get_mut(self.len..self.len + count), bytes.get(..count)) {
            (Some(room), Some(bytes)) => room.copy_from_slice(bytes),
            _ => return 0,
        }
        self.len += count;
        count
    }

    /// Classifies the bytes so far; `None` until more have come.
    pub(super) fn next_found(&mut self) -> Option<Found> {
        while !self.rejected && self.fitting < self.len.min(HEADER) {
            match self.bytes.get(self.fitting) {
                Some(byte) if fits(self.fitting, *byte) => self.fitting += 1,
                _ => self.rejected = true,
            }
        }
        if self.rejected {
            self.rejected = false;
            let others =
                self.bytes.iter().take(self.len).skip(1).take_while(|byte| **byte != START).count() + 1;
            self.drop_front(others);
            return Some(Found::OtherBytes(others));
        }
        let end = self.end();
        if self.len < HEADER || self.len < end {
            return None;
        }
        let payload_len = self.payload_len();
        let checked = self.bytes.get(1..HEADER + payload_len).unwrap_or_default();
        let mut digest = CHECKSUM.digest();
        digest.update(checked);
        digest.update(&[ALTITUDE_DATA::EXTRA_CRC]);
        if self.bytes.get(end - CHECK..end) != Some(&digest.finalize().to_le_bytes()[..]) {
            self.rejected = true;
            return Some(Found::BadChecksum);
        }
        let mut payload = [0; PAYLOAD];
        if let (Some(slots), Some(sent)) =
            (payload.get_mut(..payload_len), self.bytes.get(HEADER..HEADER + payload_len))
        {
            slots.copy_from_slice(sent);
        }
        let sender = Sender { system: self.bytes[SYSTEM], component: self.bytes[COMPONENT] };
        self.drop_front(end);
        Some(Found::Altitude { sender, payload })
    }

    /// End of the frame whose header these bytes begin with.
    fn end(&self) -> usize {
        HEADER + self.payload_len() + CHECK
    }

    fn payload_len(&self) -> usize {
        usize::from(self.bytes[1])
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
        self.fitting = 0;
    }
}

/// Whether a frame with an altitude may have this byte at this place.
fn fits(place: usize, byte: u8) -> bool {
    let [a, b, c, _] = IDENTITY;
    match place {
        0 => byte == START,
        1 => (1..=PAYLOAD).contains(&usize::from(byte)),
        2 => byte & !SIGNED == 0,
        7 => byte == a,
        8 => byte == b,
        9 => byte == c,
        _ => true,
    }
}
