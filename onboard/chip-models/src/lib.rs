//! Register-level models of the sensor chips of the flight computer: what a driver sees of a chip, byte by
//! byte, and the chip's faults.
//!
//! A model is fed with physical quantities by time ([`source::Source`]) and sits behind the same trait as the
//! real chip: `embedded_hal::spi::SpiDevice` ([`bus::ChipOnBus`]), or a UART of `embedded_io`
//! ([`ublox::ReceiverModel`]). It shares no arithmetic with the drivers: the models invert the datasheet's
//! formulas with code of their own. They use only integers and `f32`, no clock and no heap, so that host and
//! target produce the same bytes.
//!
//! [`flown`] is the whole board: the drivers on these models, fed from a flight.
//!
//! A model is exact where the datasheet is (registers, commands, CRCs, quantisation, longest conversion time)
//! and ideal where the datasheet specifies noise: noise belongs to the flight that feeds it.
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
