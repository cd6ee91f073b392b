//! The flight computer's telemetry to the ground: MAVLink 2 messages, made once a tick and sent as the line
//! has room.
//!
//! [`Telemetry::tick`] turns a tick's input and output into messages. The rate table is [`Rates`], the
//! messages' fields and units are in [`message`], the names of the plain values in [`named`]. A whole frame
//! is queued without waiting, or is dropped and counted by message ([`Link`]); the other end of the queue
//! feeds the UART. A dropped frame uses up its sequence number, so that the receiver sees a gap where the
//! counters report a drop.
//!
//! A value that is not known is sent as MAVLink's "unknown" for its field, or is not sent.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod event;
mod frame;
mod link;
pub mod message;
pub mod named;
mod rates;
mod sample;
mod schedule;
mod standby;
mod status;
mod telemetry;
mod text;

pub use frame::{Frame, MAX_FRAME};
pub use link::{FRAMES, FrameQueue, Link, LinkCounts, MessageKind, Priority};
pub use rates::{Rates, RatesError};
pub use standby::standby;
pub use status::ComputerStatus;
pub use telemetry::{Telemetry, TickReport};

/// MAVLink's system id of the vehicle.
pub const SYSTEM_ID: u8 = 1;
/// MAVLink's component id: an onboard computer (`MAV_COMP_ID_ONBOARD_COMPUTER`), beside the autopilot's 1.
pub const COMPONENT_ID: u8 = 191;
