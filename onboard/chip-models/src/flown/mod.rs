//! A flight flown on chips: the board's drivers on the models of their chips, which are fed with what a
//! flight says, tick by tick. The emulated flight computer and the workbench beside it run the same.
//!
//! # What a flight becomes
//! A barometer reading becomes the static pressure at the MS5611 (an altitude through the standard
//! atmosphere), an inertial sample the motion of the ICM-42688-P, a fix a solution of the u-blox receiver at
//! that moment, the mother ship's altitude a MAVLink message on the umbilical. Each is held until the flight
//! has the next. A chip gets its power with the flight's first value for it; what a flight has no value for
//! is not on the board. What no chip of the board measures (an external unit's altitude, air data, attitude)
//! comes as it is, and so does the launch discrete, but for what is wrong with its wire.
//!
//! What could not go through a chip as the flight has it is counted: [`TruthCounts`].

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
