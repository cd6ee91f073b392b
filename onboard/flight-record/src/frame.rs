//! One frame.

use crate::payload::{Kind, MAGIC, Payload};

/// Longest frame before stuffing, bytes. No payload of this crate comes near it.
pub const MAX_FRAME: usize = 640;
/// Longest frame as sent, bytes: COBS adds one byte to every 254 and the closing zero one more.
pub const MAX_STUFFED: usize = MAX_FRAME + MAX_FRAME.div_ceil(254) + 1;

/// Bytes before the payload: kind and sequence number.
pub(crate) const HEAD: usize = 5;
/// Bytes after it: the check.
pub(crate) const TAIL: usize = 4;

/// A frame whose check was right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What it carries.
    pub kind: Kind,
    /// Its number in the stream.
    pub sequence: u32,
    /// Frames that are missing between the last good one and this.
    pub missed: u32,
    pub(crate) payload: &'a [u8],
}

/// Why bytes between two zeros are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`MAX_FRAME`].
    TooLong,
    /// Too short to be one.
    TooShort,
    /// The stuffing is broken.
    Stuffing,
    /// The check is wrong.
    Check,
    /// The kind is unknown.
    Kind(u8),
    /// The sequence number has been there already.
    Repeated,
}

/// Why a frame does not carry what was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PayloadError {
    /// It carries something else.
    Kind(Kind),
    /// The payload breaks its format, or has bytes left over.
    Format,
}

impl Frame<'_> {
    /// The version of the format that a header of any version says; `None` for another frame, or a header
    /// that is none. Magic and version are its first fields in every version.
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
