//! Flies a flight on chips: the board's drivers run on models of their chips, which are fed with the flight's
//! data tick by tick. The emulated flight computer and the workbench beside it run the same code.
//!
//! # What a flight becomes
//! A barometer reading becomes the static pressure at the MS5611 (an altitude is converted with the standard
//! atmosphere), an inertial sample the motion of the ICM-42688-P, a fix a solution of the u-blox receiver at
//! that moment, and the mother ship's altitude a MAVLink message on the umbilical. Each is held until the
//! flight has the next one. A chip is powered on at the flight's first value for it; a chip without values is
//! not on the board. What no chip of the board measures (an external unit's altitude, air data, attitude) is
//! passed on unchanged, and so is the launch discrete, except for faults of its wire.
//!
//! Values that could not go through a chip unchanged are counted: [`TruthCounts`].

mod fault;
mod fitted;
mod recorded;
mod suite;
mod truth;
mod wire;

pub use fault::{Chip, ChipFault, Fault, Quantity};
pub use fitted::Fitted;
pub use recorded::{RecordedSensors, SensorSource};
pub use suite::{ModelledSuite, RECEIVER_BAUD, UMBILICAL_BAUD};
pub use truth::{ASSUMED_SATELLITES, ASSUMED_TEMPERATURE_C, TruthCounts};
pub use wire::ModelledWire;
