//! A flight through the firmware, in the emulated flight computer or on a board, compared with the host bit
//! by bit.

mod agreement;
mod builder;
mod compare;
mod consequence;
mod debug_link;
pub mod downlink;
mod emulator;
mod error;
mod fault_names;
mod fault_script;
mod fly;
mod grid;
mod host;
mod image;
mod log;
mod made_of;
mod old_images;
mod one_processor;
mod options;
mod raw_flight;
mod record;
mod registry_paths;
mod report;
mod run;
mod starts;

pub use agreement::{Agreement, SensorAgreement};
pub use builder::{Board, PlantedError, Program, TARGET, build};
pub use compare::Difference;
pub use consequence::{
    AltitudeDifference, BiasChange, CalibrationChange, CleanAndFaulty, Consequence, FlagsChange,
};
pub use debug_link::{DebugLink, TicksFlown};
pub use emulator::{Emulation, emulate};
pub use error::{FlyError, ResultsError, Shortfall};
pub use fault_script::{FaultError, PlannedFault};
pub use flight_record::{CostUnit, SensorSource};
pub use fly::{consequence, fly, fly_inputs, fly_on_host};
pub use grid::{GridReport, TICK_US};
pub use image::Image;
pub use options::{FlownOn, FlyOptions};
pub use raw_flight::{RawFlight, fly_bytes, fly_struck, fly_struck_on_chips};
pub use record::{FlightResult, Results};
pub use report::{ChipsReport, Downlinked, FlyReport, PartReport};
pub use run::Run;
pub use starts::Starts;
