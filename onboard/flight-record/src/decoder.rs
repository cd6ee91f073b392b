//! Reads frames.

use cobs::{DecodeResult, DecoderState};

use crate::CRC;
use crate::frame::{Frame, FrameError, HEAD, MAX_FRAME, TAIL};
use crate::payload::Kind;

/// Reads the frames of one stream byte by byte, and resynchronises after any error.
#[derive(Debug)]
pub struct Decoder {
    stuffing: DecoderState,
    /// More bytes have come since the last zero than a frame can have.
    too_long: bool,
    frame: [u8; MAX_FRAME],
    len: usize,
    next_sequence: u32,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            stuffing: DecoderState::Idle,
            too_long: false,
            frame: [0; MAX_FRAME],
            len: 0,
            next_sequence: 0,
        }
    }

    /// A decoder in the middle of a stream, before the frame with that number.
    #[must_use]
    pub const fn at(sequence: u32) -> Self {
        Self { next_sequence: sequence, ..Self::new() }
    }

    /// Takes one byte. Returns the frame that it closes, or why the bytes are no frame.
    ///
    /// # Errors
    /// The bytes since the last zero are no frame. The next zero starts again.
    pub fn push(&mut self, byte: u8) -> Result<Option<Frame<'_>>, FrameError> {
        if self.too_long {
            if byte != 0 {
                return Ok(None);
            }
            *self = Self { next_sequence: self.next_sequence, ..Self::new() };
            return Err(FrameError::TooLong);
        }
        match self.stuffing.feed(byte) {
            Ok(DecodeResult::NoData | DecodeResult::DataStart) => Ok(None),
            Ok(DecodeResult::DataContinue(unstuffed)) => {
                match self.frame.get_mut(self.len) {
                    Some(slot) => {
                        *slot = unstuffed;
                        self.len += 1;
                    }
                    None => self.too_long = true,
                }
                Ok(None)
            }
            Ok(DecodeResult::DataComplete) => {
                let len = core::mem::take(&mut self.len);
                self.close(len).map(Some)
            }
            // Only a zero can be wrong, so the next byte starts a new frame.
            Err(_) => {
                self.len = 0;
                Err(FrameError::Stuffing)
            }
        }
    }

    /// Whether bytes have come after the last zero. At the end of a stream this means that it was cut.
    #[must_use]
    pub const fn is_inside_frame(&self) -> bool {
        self.too_long || !matches!(self.stuffing, DecoderState::Idle)
    }

    /// Checks the frame in the buffer.
    fn close(&mut self, len: usize) -> Result<Frame<'_>, FrameError> {
        let frame = self.frame.get(..len).ok_or(FrameError::TooLong)?;
        let (checked, check) = frame.split_last_chunk::<TAIL>().ok_or(FrameError::TooShort)?;
        let (head, payload) = checked.split_first_chunk::<HEAD>().ok_or(FrameError::TooShort)?;
        if CRC.checksum(checked) != u32::from_le_bytes(*check) {
            return Err(FrameError::Check);
        }
        let [kind, sequence @ ..] = *head;
        let kind = Kind::from_byte(kind).ok_or(FrameError::Kind(kind))?;
        let sequence = u32::from_le_bytes(sequence);
        // A sender that has restarted counts from its header again.
        let starts_anew = kind == Kind::Header && sequence == 0;
        let missed = if starts_anew { 0 } else { sequence.wrapping_sub(self.next_sequence) };
        if missed > u32::MAX / 2 {
            return Err(FrameError::Repeated);
        }
        self.next_sequence = sequence.wrapping_add(1);
        Ok(Frame { kind, sequence, missed, payload })
    }
}
