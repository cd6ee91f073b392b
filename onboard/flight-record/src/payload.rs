//! What a frame can carry.

use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::output::TickOutput;
use serde::Serialize;
use serde::de::DeserializeOwned;
use survival::RestartReport;

use crate::encoder::EncodeError;

/// First bytes of a header's payload.
pub const MAGIC: [u8; 4] = *b"PYFR";
/// Version of this format; a reader refuses any other.
pub const FORMAT_VERSION: u16 = 11;
/// Most parts that a tick's cost can be divided into.
pub const MAX_PARTS: usize = 16;

/// Kind of a payload: the first byte of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// [`Header`].
    Header = 1,
    /// [`TickInput`].
    Input = 2,
    /// [`TickRecord`].
    Tick = 3,
    /// [`End`].
    End = 4,
    /// [`Summary`].
    Summary = 5,
    /// [`LatchRecord`].
    Latch = 6,
    /// A fault of a chip, `chip_models::flown::ChipFault`: it begins with the input that follows.
    ChipFault = 7,
    /// [`RestartReport`].
    Restart = 8,
}

impl Kind {
    /// The kind of that byte, or `None`.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            1 => Some(Self::Header),
            2 => Some(Self::Input),
            3 => Some(Self::Tick),
            4 => Some(Self::End),
            5 => Some(Self::Summary),
            6 => Some(Self::Latch),
            7 => Some(Self::ChipFault),
            8 => Some(Self::Restart),
            _ => None,
        }
    }
}

/// A type that a frame can carry.
pub trait Payload: Serialize + DeserializeOwned {
    /// The kind of its frames.
    const KIND: Kind;

    /// Writes it in postcard's format and says how many bytes that took.
    ///
    /// # Errors
    /// There is too little room.
    fn write(&self, room: &mut [u8]) -> Result<usize, EncodeError> {
        written(self, room)
    }
}

#[inline(always)]
fn written<P: Payload>(payload: &P, room: &mut [u8]) -> Result<usize, EncodeError> {
    postcard::to_slice(payload, room).map(|bytes| bytes.len()).map_err(|_| EncodeError)
}

/// A payload whose writing is compiled here, once, and not wherever a frame is encoded: the firmware has this
/// crate compiled for size.
macro_rules! payload {
    ($($(#[$doc:meta])* $payload:ty: $kind:ident;)*) => {
        $($(#[$doc])* impl Payload for $payload {
            const KIND: Kind = Kind::$kind;

            #[inline(never)]
            fn write(&self, room: &mut [u8]) -> Result<usize, EncodeError> {
                written(self, room)
            }
        })*
    };
}

payload! {
    Header: Header;
    TickInput: Input;
    TickRecord: Tick;
    /// The calibration, right after the tick that latched it.
    LatchRecord: Latch;
    /// A restart, right after the header that starts its part of the stream.
    RestartReport: Restart;
    End: End;
    Summary: Summary;
}

/// Which way a stream goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum Stream {
    /// Into the flight computer: one [`TickInput`] a tick.
    Inputs,
    /// Out of it: one [`TickRecord`] a tick.
    Outputs,
}

/// How the inputs of a record come, or came, to the flight computer's estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum SensorSource {
    /// As they are.
    #[default]
    Ideal,
    /// Through the sensors' chips, or models of them, and the drivers.
    Chips,
}

/// What [`TickRecord::cost`] counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum CostUnit {
    /// Instructions, as QEMU counts them.
    Instructions,
    /// Clock cycles of the core.
    Cycles,
}

/// The first frame of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`FORMAT_VERSION`].
    pub version: u16,
    /// Which way the stream goes.
    pub stream: Stream,
    /// Fingerprint of the model that the flight is meant for, or was flown with.
    pub model: u64,
    /// What the inputs are for, or what the outputs came from.
    pub sensors: SensorSource,
}

impl Header {
    /// The header of a stream of this version.
    #[must_use]
    pub const fn new(stream: Stream, model: u64, sensors: SensorSource) -> Self {
        Self { magic: MAGIC, version: FORMAT_VERSION, stream, model, sensors }
    }
}

/// What one tick saw, what it said, and what it cost.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize)]
pub struct TickRecord {
    /// When its code began, wrapping: where a record is flown, by the clock of [`Summary::cost_unit`], with
    /// the instructions of the chips' models; on the board that flies, the low half of the mission's
    /// microseconds, by a timer.
    pub begun: u32,
    /// What the tick took, in the summary's [`Summary::cost_unit`].
    pub cost: u32,
    /// What was new, as the estimator got it.
    pub input: TickInput,
    /// What it said.
    pub output: TickOutput,
}

/// The last frame of a stream of inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct End {
    /// How many inputs the stream held.
    pub inputs: u32,
}

/// What one part of the ticks took, in the summary's [`Summary::cost_unit`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct PartCost {
    /// Sum over all ticks.
    pub sum: u64,
    /// The dearest tick's.
    pub worst: u32,
}

/// The last frame of a stream of outputs: what the flight computer counted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Summary {
    /// Ticks that ran the mission.
    pub ticks: u32,
    /// Timer ticks at which no input was ready, so that the mission waited.
    pub underruns: u32,
    /// Timer ticks at which results had no room, so that the mission waited.
    pub stalls: u32,
    /// Results that were lost because they had no room and the mission could not wait.
    pub lost_results: u32,
    /// Input frames that were no frames ([`crate::FrameError`]).
    pub bad_frames: u32,
    /// Input frames whose payload was not what it said it was, or out of place.
    pub bad_payloads: u32,
    /// Input frames that are missing between those that came, by their sequence numbers.
    pub missed_frames: u32,
    /// The input had no [`End`], or its count was not the number of inputs that came.
    pub input_cut: bool,
    /// Restarts since power-on.
    pub restarts: u32,
    /// Input frames that were passed over after a restart: the flight went on meanwhile.
    pub skipped_inputs: u32,
    /// From the last reset until the first tick may come, in the costs' unit, where the board can tell.
    pub start_cost: Option<u32>,
    /// Snapshots that could not be kept.
    pub lost_snapshots: u32,
    /// Polls of a sensor that failed.
    pub sensor_faults: u32,
    /// Unit of the costs.
    pub cost_unit: CostUnit,
    /// Sum of the ticks' costs.
    pub cost_sum: u64,
    /// The dearest tick's.
    pub cost_worst: u32,
    /// What each part of the ticks took, in the order of `flight_computer::Part`.
    pub parts: heapless::Vec<PartCost, MAX_PARTS>,
    /// Most stack that was ever in use, bytes.
    pub stack_used_bytes: u32,
    /// Stack there is, bytes.
    pub stack_size_bytes: u32,
}
