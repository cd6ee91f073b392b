//! One frame.

use crate::payload::{Kind, MAGIC, Payload};

/// Longest frame before stuffing, bytes. All payloads of this crate are much shorter.
pub const MAX_FRAME: usize = 640;
/// Longest frame as sent, bytes: COBS adds one byte to every 254 and the closing zero one more.
pub const MAX_STUFFED: usize = MAX_FRAME + MAX_FRAME.div_ceil(254) + 1;

/// Bytes before the payload: kind and sequence number.
pub(crate) const HEAD: usize = 5;
/// Bytes after the payload: the check.
pub(crate) const TAIL: usize = 4;

/// A frame with a right check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Kind of its payload.
    pub kind: Kind,
    /// Its number in the stream.
    pub sequence: u32,
    /// Number of frames missing between the last good one and this.
    pub missed: u32,
    pub(crate) payload: &'a [u8],
}

/// Why bytes between two zeros are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`MAX_FRAME`].
    TooLong,
    /// Too short for a frame.
    TooShort,
    /// The stuffing is broken.
    Stuffing,
    /// The check is wrong.
    Check,
    /// The kind is unknown.
    Kind(u8),
    /// The sequence number occurred before.
    Repeated,
}

/// Why a frame does not carry the requested payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PayloadError {
    /// It carries another kind.
    Kind(Kind),
    /// The payload is malformed, or has bytes left over.
    Format,
}

impl Frame<'_> {
    /// The format's version in a header of any version; `None` for another frame or an invalid header. Magic
    /// and version are the first fields in every version.
    #[must_use]
    pub fn format_version(&self) -> Option<u16> {
        let (magic, version): ([u8; 4], u16) = postcard::take_from_bytes(self.payload).ok()?.0;
        (self.kind == Kind::Header && magic == MAGIC).then_some(version)
    }

    /// The payload.
    ///
    /// # Errors
    /// The frame is of another kind, or its payload does not decode.
    pub fn payload<P: Payload>(&self) -> Result<P, PayloadError> {
        if self.kind != P::KIND {
            return Err(PayloadError::Kind(self.kind));
        }
        match postcard::take_from_bytes(self.payload) {
            Ok((payload, [])) => Ok(payload),
            _ => Err(PayloadError::Format),
        }
    }
}
