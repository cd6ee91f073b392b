//! The payloads of frames.

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
/// Largest number of parts into which a tick's cost can be divided.
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
    /// A fault of a chip, `chip_models::flown::ChipFault`; it begins with the next input.
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

    /// Writes it in postcard's format. Returns the number of bytes.
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

/// Implements a payload whose writing is compiled here, once, instead of wherever a frame is encoded: the
/// firmware compiles this crate for size.
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

/// Direction of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum Stream {
    /// Into the flight computer: one [`TickInput`] a tick.
    Inputs,
    /// Out of the flight computer: one [`TickRecord`] a tick.
    Outputs,
}

/// How the inputs of a record reach, or reached, the flight computer's estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum SensorSource {
    /// Unchanged.
    #[default]
    Ideal,
    /// Through the sensors' chips, or models of them, and the drivers.
    Chips,
}

/// Unit of [`TickRecord::cost`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub enum CostUnit {
    /// Instructions, as counted by QEMU.
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
    /// Direction of the stream.
    pub stream: Stream,
    /// Fingerprint of the model that the flight is meant for, or was flown with.
    pub model: u64,
    /// How the inputs are to reach the estimator, or how the outputs' inputs reached it.
    pub sensors: SensorSource,
}

impl Header {
    /// The header of a stream of this version.
    #[must_use]
    pub const fn new(stream: Stream, model: u64, sensors: SensorSource) -> Self {
        Self { magic: MAGIC, version: FORMAT_VERSION, stream, model, sensors }
    }
}

/// Input, output and cost of one tick.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize)]
pub struct TickRecord {
    /// Time at which its code began, wrapping. In a replay: by the clock of [`Summary::cost_unit`], including
    /// the instructions of the chips' models. On the flying board: the low half of the mission's
    /// microseconds, by a timer.
    pub begun: u32,
    /// Cost of the tick, in the summary's [`Summary::cost_unit`].
    pub cost: u32,
    /// New values, as passed to the estimator.
    pub input: TickInput,
    /// The estimator's output.
    pub output: TickOutput,
}

/// The last frame of a stream of inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct End {
    /// Number of inputs in the stream.
    pub inputs: u32,
}

/// Cost of one part of the ticks, in the summary's [`Summary::cost_unit`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct PartCost {
    /// Sum over all ticks.
    pub sum: u64,
    /// Largest in any tick.
    pub worst: u32,
}

/// The last frame of a stream of outputs: the flight computer's counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Summary {
    /// Ticks that ran the mission.
    pub ticks: u32,
    /// Timer ticks at which no input was ready, so that the mission waited.
    pub underruns: u32,
    /// Timer ticks at which there was no room for results, so that the mission waited.
    pub stalls: u32,
    /// Results that were lost because there was no room and the mission could not wait.
    pub lost_results: u32,
    /// Invalid input frames ([`crate::FrameError`]).
    pub bad_frames: u32,
    /// Input frames whose payload was not of its stated kind, or out of place.
    pub bad_payloads: u32,
    /// Missing input frames, by their sequence numbers.
    pub missed_frames: u32,
    /// Whether the input had no [`End`], or its count differed from the number of inputs received.
    pub input_cut: bool,
    /// Restarts since power-on.
    pub restarts: u32,
    /// Input frames that were skipped after a restart, because the flight continued meanwhile.
    pub skipped_inputs: u32,
    /// Cost from the last reset to the earliest first tick, in the costs' unit, if the board can measure it.
    pub start_cost: Option<u32>,
    /// Snapshots that could not be kept.
    pub lost_snapshots: u32,
    /// Failed polls of sensors.
    pub sensor_faults: u32,
    /// Unit of the costs.
    pub cost_unit: CostUnit,
    /// Sum of the ticks' costs.
    pub cost_sum: u64,
    /// Largest cost of a tick.
    pub cost_worst: u32,
    /// Costs of the parts of the ticks, in the order of `flight_computer::Part`.
    pub parts: heapless::Vec<PartCost, MAX_PARTS>,
    /// Largest stack use, bytes.
    pub stack_used_bytes: u32,
    /// Size of the stack, bytes.
    pub stack_size_bytes: u32,
}
