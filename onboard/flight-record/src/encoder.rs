//! Writes frames.

use crate::CRC;
use crate::frame::{HEAD, MAX_FRAME, MAX_STUFFED, TAIL};
use crate::payload::{Kind, Payload};

/// The payload does not fit into a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncodeError;

/// Writes the frames of one stream.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    sequence: u32,
}

impl Encoder {
    /// An encoder at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self { sequence: 0 }
    }

    /// Encodes the next frame into `buffer`. Returns its bytes, including the closing zero.
    ///
    /// # Errors
    /// The payload is too long; the stream continues as if it had not been offered.
    pub fn encode<'a, P: Payload>(
        &mut self,
        payload: &P,
        buffer: &'a mut [u8; MAX_STUFFED],
    ) -> Result<&'a [u8], EncodeError> {
        let mut frame = [0; MAX_FRAME];
        let payload_len = payload.write(frame.get_mut(HEAD..MAX_FRAME - TAIL).ok_or(EncodeError)?)?;
        self.close(P::KIND, &mut frame, payload_len, buffer)
    }

    /// The part common to all kinds of payload, so that an image contains it once.
    #[inline(never)]
    fn close<'a>(
        &mut self,
        kind: Kind,
        frame: &mut [u8; MAX_FRAME],
        payload_len: usize,
        buffer: &'a mut [u8; MAX_STUFFED],
    ) -> Result<&'a [u8], EncodeError> {
        if let [first, sequence @ ..] = frame.get_mut(..HEAD).ok_or(EncodeError)? {
            *first = kind as u8;
            sequence.copy_from_slice(&self.sequence.to_le_bytes());
        }
        let checked = frame.get(..HEAD + payload_len).ok_or(EncodeError)?;
        let check = CRC.checksum(checked).to_le_bytes();
        let end = HEAD + payload_len + TAIL;
        frame.get_mut(HEAD + payload_len..end).ok_or(EncodeError)?.copy_from_slice(&check);

        let whole = frame.get(..end).ok_or(EncodeError)?;
        let stuffed = cobs::try_encode(whole, buffer).map_err(|_| EncodeError)?;
        *buffer.get_mut(stuffed).ok_or(EncodeError)? = 0;
        self.sequence = self.sequence.wrapping_add(1);
        buffer.get(..=stuffed).ok_or(EncodeError)
    }
}
