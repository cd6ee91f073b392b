//! The flights that come with Pylon: scenarios that are simulated when opened.

use simulate::{Scenario, simulate};

use crate::engine::{Engine, Refused, refused};
use crate::opening::opened;
use crate::protocol::{OpenSampleRequest, Opened, Sample, Times};

macro_rules! scenario {
    ($name:literal) => {
        include_str!(concat!("../../../../flights/", $name, ".toml"))
    };
}

/// Name, description, scenario.
const SAMPLES: [(&str, &str, &str); 4] = [
    (
        "hidden-static-port",
        "A small UAV whose static port reads part of the dynamic pressure, which the model does not know (simulated).",
        scenario!("hidden-static-port"),
    ),
    (
        "hidden-static-port-second",
        "The same UAV on another day, to check what was learned on the first (simulated).",
        scenario!("hidden-static-port-second"),
    ),
    (
        "paper-reconstruction",
        "The paper's flight, reconstructed from its figures: the telemetry was never published (simulated).",
        scenario!("paper-reconstruction"),
    ),
    ("clean", "A flight that the model explains completely (simulated).", scenario!("clean")),
];

/// Lists all samples.
pub fn list() -> Vec<Sample> {
    let samples = SAMPLES.iter();
    samples.map(|(name, about, _)| Sample { name: (*name).to_owned(), about: (*about).to_owned() }).collect()
}

/// Simulates a sample and opens it.
pub fn open(engine: &mut Engine, request: OpenSampleRequest) -> Result<Opened, Refused> {
    let OpenSampleRequest { flight, sample } = request;
    let (name, _, text) = SAMPLES
        .iter()
        .find(|(name, ..)| *name == sample)
        .ok_or_else(|| refused(format!("no flight '{sample}' comes with Pylon")))?;
    let scenario = Scenario::from_toml(text, &format!("{name}.toml")).map_err(refused)?;
    let (made, _) = simulate(&scenario, scenario.seed).map_err(refused)?;
    // Written as CSV and read back, so that it is what a user would have.
    let mut csv = Vec::new();
    flight_data::to_writer(&mut csv, &made).map_err(refused)?;
    let read = flight_data::parse_with(&csv, engine.executor).map_err(refused)?;
    opened(
        engine.keep(flight, format!("{name}.csv"), "Pylon's own CSV, simulated".to_owned(), read),
        Times::default(),
    )
}
