//! A flight as bytes: the inputs and outputs of the flight computer.
//!
//! A stream is a sequence of frames. Before stuffing a frame is
//!
//! | bytes | what |
//! |---|---|
//! | 1 | kind of the payload, [`Kind`] |
//! | 4 | sequence number of the frame in its stream, from 0, little-endian |
//! | any | the payload, in postcard's format |
//! | 4 | CRC-32/ISO-HDLC of all that, little-endian |
//!
//! and is then stuffed by COBS (Cheshire and Baker, "Consistent Overhead Byte Stuffing", 1999) and closed by
//! one zero byte. A reader that loses its place finds it again at the next zero; gaps in the sequence numbers
//! show what it lost.
//!
//! The first frame is a [`Header`]. A header with the number 0 later in the stream means that the sender has
//! restarted, and numbers continue from there. A stream of inputs ends with an [`End`], a stream of outputs
//! with a [`Summary`]; without it the stream was cut.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

use core::ffi::CStr;

mod decoder;
mod encoder;
mod exit;
mod frame;
mod payload;
mod strike;

pub use decoder::Decoder;
pub use encoder::{EncodeError, Encoder};
pub use exit::ExitStatus;
pub use frame::{Frame, FrameError, MAX_FRAME, MAX_STUFFED, PayloadError};
pub use payload::{
    CostUnit, End, FORMAT_VERSION, Header, Kind, MAGIC, MAX_PARTS, PartCost, Payload, SensorSource, Stream,
    Summary, TickRecord,
};
pub use strike::{Blow, STRIKE_BYTES, STRIKES_FILE, Strike};

use crc::{CRC_32_ISO_HDLC, Crc};

/// The check of a frame.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Name of the stream of inputs, in the directory where the emulator runs.
pub const INPUT_FILE: &CStr = c"input.record";
/// Name of the stream of outputs, in the same directory.
pub const OUTPUT_FILE: &CStr = c"output.record";
