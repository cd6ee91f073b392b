//! Sensor drivers of the flight computer: one trait for each kind of sensor, and the suite that turns one
//! poll of every sensor into the estimator's input.
//!
//! The drivers of the chips implement these traits ([`ms5611`], [`bmp390`], [`icm42688p`], [`ublox`],
//! [`umbilical`]); another chip is one more file. The emulated board uses those of [`Replay`], fed from a
//! flight record.
//!
//! A driver is split-phase: `poll` never waits. It starts the next transfer or conversion when one is due,
//! takes what has arrived since the last call, and returns each sample at most once. Time is an argument,
//! microseconds by the flight computer's clock; a driver has no clock of its own.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod bmp390;
mod bus;
mod error;
mod health;
pub mod icm42688p;
pub mod ms5611;
mod port;
mod replay;
mod ring;
mod sensor;
mod suite;
pub mod ublox;
pub mod umbilical;

pub use error::SensorError;
pub use health::Health;
pub use replay::{Replay, ReplayUmbilical, ReplayedSuite};
pub use ring::{RingError, RingReader};
pub use sensor::{
    AltitudeLink, Barometer, BarometerSample, InertialUnit, LaunchDiscrete, SatelliteReceiver, VehicleLink,
    VehicleState,
};
pub use suite::{Device, Faults, Sensors, Suite};
