//! One MAVLink 2 frame: marker, header, payload, CRC; unsigned.
//!
//! Source: MAVLink guide, "Packet Serialization". The payload comes from the `mavlink` crate.

use crc::{CRC_16_MCRF4XX, Crc};
use mavlink::{MavlinkVersion, MessageData};

use crate::{COMPONENT_ID, SYSTEM_ID};

/// Length of marker and header, bytes.
const HEADER: usize = 10;
/// Length of the longest payload that is sent, bytes: HIGHRES_IMU with its extension.
const MAX_PAYLOAD: usize = 63;
/// Length of the longest frame that is sent, bytes.
pub const MAX_FRAME: usize = HEADER + MAX_PAYLOAD + CRC_BYTES;
const CRC_BYTES: usize = 2;
/// MAVLink 2's marker.
const MARKER: u8 = 0xfd;
/// MAVLink's "X.25" checksum, called MCRF4XX in the catalogue of CRCs.
const CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_MCRF4XX);

/// A complete frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    len: u8,
    bytes: [u8; MAX_FRAME],
}

impl Frame {
    /// A frame without bytes.
    pub const EMPTY: Self = Self { len: 0, bytes: [0; MAX_FRAME] };

    /// The frame of a message, with that sequence number.
    ///
    /// The length of the longest message is known at compile time: a longer one does not compile.
    #[must_use]
    pub fn new<M: MessageData>(message: &M, sequence: u8) -> Self {
        const { assert!(M::ENCODED_LEN <= MAX_PAYLOAD) };
        let mut frame = Self::EMPTY;
        let Some((header, payload)) = frame.bytes.split_first_chunk_mut::<HEADER>() else {
            return Self::EMPTY;
        };
        let len = message.ser(MavlinkVersion::V2, payload);
        let [id_low, id_middle, id_high, _] = M::ID.to_le_bytes();
        *header = [MARKER, len as u8, 0, 0, sequence, SYSTEM_ID, COMPONENT_ID, id_low, id_middle, id_high];
        frame.seal(HEADER + len, M::EXTRA_CRC);
        frame
    }

    /// Adds the CRC after `len` bytes. Not generic, so that it exists once for all messages.
    #[inline(never)]
    fn seal(&mut self, len: usize, extra_crc: u8) {
        let mut digest = CHECKSUM.digest();
        digest.update(self.bytes.get(1..len).unwrap_or_default());
        digest.update(&[extra_crc]);
        if let Some(crc) = self.bytes.get_mut(len..len + CRC_BYTES) {
            crc.copy_from_slice(&digest.finalize().to_le_bytes());
        }
        self.len = (len + CRC_BYTES) as u8;
    }

    /// Its bytes, in the order of the line.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }
}

/// Largest number of bytes on the line for a message with that payload length: trailing zeros are not sent.
pub(crate) const fn line_bytes(payload: usize) -> u32 {
    (HEADER + payload + CRC_BYTES) as u32
}
