//! Register-level models of the sensor chips of the flight computer: what a driver sees of a chip, byte by
//! byte, and what can go wrong with it.
//!
//! A model is fed with physical quantities by time ([`source::Source`]) and sits behind the same trait as the
//! real chip: `embedded_hal::spi::SpiDevice` ([`bus::ChipOnBus`]), or a UART of `embedded_io`
//! ([`ublox::ReceiverModel`]). It shares no arithmetic with the drivers: what they compute from the
//! datasheet's formulas, the models invert from those formulas anew. Only integers and `f32`, no clock and no
//! heap: the same bytes on the host and on the target.
//!
//! [`flown`] is the whole board: the drivers on these models, fed from a flight.
//!
//! A model is exact where the datasheet is (registers, commands, CRCs, quantisation, longest conversion
//! time) and ideal where it speaks of noise: noise belongs to the flight that feeds it.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod bmp390;
pub mod bus;
pub mod disturbance;
pub mod flown;
pub mod icm42688p;
pub mod line;
pub mod metered;
pub mod mother_ship;
pub mod ms5611;
pub mod source;
pub mod ublox;
pub mod vibration;
