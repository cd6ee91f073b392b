//! The demo's second part: a flight that fails, what its model lacks, and the next flight, which succeeds.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use serde::Deserialize;

use crate::workspace;

/// The part of `pylon diagnose --json` that is used.
#[derive(Debug, Deserialize)]
pub struct Diagnosis {
    /// The verdict over all sensors.
    pub verdict: String,
    /// Diagnoses by sensor.
    pub sensors: BTreeMap<String, SensorDiagnosis>,
}

/// One sensor's diagnosis.
#[derive(Debug, Deserialize)]
pub struct SensorDiagnosis {
    /// Effects that are certainly missing.
    pub missing: Vec<String>,
}

impl Diagnosis {
    /// The missing effects of all sensors.
    pub fn missing(&self) -> Vec<&str> {
        self.sensors.values().flat_map(|sensor| &sensor.missing).map(String::as_str).collect()
    }
}

/// The part of `pylon add --json` that is used.
#[derive(Debug, Deserialize)]
pub struct Addition {
    coefficient: f64,
    sigma: f64,
    learning: Vec<FlightChange>,
    held_out: Vec<FlightChange>,
}

#[derive(Debug, Deserialize)]
struct FlightChange {
    sensors: BTreeMap<String, SensorChange>,
}

#[derive(Debug, Deserialize)]
struct SensorChange {
    before: Score,
    after: Score,
}

#[derive(Debug, Deserialize)]
struct Score {
    free_flight_rms_m: Option<f64>,
    doubtful_after_s: Option<f64>,
}

impl fmt::Display for Score {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rms_m = self.free_flight_rms_m.unwrap_or(f64::NAN);
        match self.doubtful_after_s {
            Some(after_s) => write!(formatter, "{rms_m:.2} m, doubtful after {after_s:.0} s"),
            None => write!(formatter, "{rms_m:.2} m, no flag"),
        }
    }
}

/// An improved model.
#[derive(Debug)]
pub struct Improvement {
    /// The effect that was found and added.
    pub effect: String,
    /// The sensor that it acts on.
    pub sensor: String,
    /// Result of `pylon add`.
    pub addition: Addition,
    /// Ticks of the held-out flight in QEMU with the improved model, each identical to the host's bits.
    pub ticks: u32,
    /// The improved model.
    pub model: PathBuf,
    /// The report of both flights with it.
    pub report: PathBuf,
}

impl fmt::Display for Improvement {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { effect, sensor, addition, ticks, model, report } = self;
        writeln!(
            formatter,
            "
Two simulated flights with an error that the default model does not account for.

  found       {effect} is missing (pylon diagnose, from the first flight alone)
  added       its coefficient {} +- {} (pylon add)
  {sensor:<11} rms error in free flight, and flags:",
            addition.coefficient, addition.sigma
        )?;
        for (name, flights) in
            [("first flight", &addition.learning), ("second, held out", &addition.held_out)]
        {
            for change in flights.iter().filter_map(|flight| flight.sensors.get(sensor)) {
                writeln!(formatter, "    {name:<17} before: {}", change.before)?;
                writeln!(formatter, "    {:<17} after:  {}", "", change.after)?;
            }
        }
        writeln!(
            formatter,
            "  emulated    {ticks} ticks of the second with the improved model, each bit for bit the host's

The improved model: {}
To look at in a browser, both flights and how the error fell: {}",
            workspace::shown(model),
            workspace::shown(report)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_was_found_and_what_it_did() {
        let flight = |before: &str, after: &str| {
            format!(
                r#"{{"sensors": {{"baro": {{
                    "before": {{"free_flight_rms_m": 4.0, "doubtful_after_s": {before}}},
                    "after": {{"free_flight_rms_m": 1.0, "doubtful_after_s": {after}}}}}}}}}"#
            )
        };
        let json = format!(
            r#"{{"coefficient": 0.12, "sigma": 0.003, "learning": [{}], "held_out": [{}]}}"#,
            flight("12.3", "null"),
            flight("20", "null")
        );
        let improvement = Improvement {
            effect: "baro.dynamic_pressure".to_owned(),
            sensor: "baro".to_owned(),
            addition: serde_json::from_str(&json).unwrap(),
            ticks: 40_000,
            model: workspace::root().join("target/demo/improved.toml"),
            report: workspace::root().join("target/demo/report.html"),
        }
        .to_string();
        for words in [
            "simulated",
            "baro.dynamic_pressure is missing",
            "0.12 +- 0.003",
            "first flight      before: 4.00 m, doubtful after 12 s",
            "after:  1.00 m, no flag",
            "40000 ticks",
            "target/demo/improved.toml",
            "target/demo/report.html",
        ] {
            assert!(improvement.contains(words), "{words} is not in:\n{improvement}");
        }
        assert!(improvement.lines().all(|line| line.chars().count() <= 100), "{improvement}");
    }
}
