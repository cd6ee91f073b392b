//! Blind trials: flights with hidden effects, and how often the diagnosis is right about them.
//!
//! The generator draws the flight plan, the air, the sensors' noise, the recorded signals, and what is wrong:
//! nothing, one to three effects of the catalogue, a cause outside it, or a faulty receiver. The diagnosis
//! sees only the flight. All flights are simulated.

pub mod advised;
pub(crate) mod draw;
pub(crate) mod flight;
pub mod improvement;
mod intervals;
mod kinematic;
mod outside;
mod reliability;
mod score;
mod trial;

pub use draw::{Case, Family, Kind, Plan, draw};
pub use flight::fly;
pub use intervals::{Deviation, intervals};
pub use reliability::reliability;
pub use score::{Score, Share, table};
pub use trial::{Trial, run};
