//! Diagnoses several flights one by one: what each lacks by itself, each vehicle's coefficients, and which
//! flight does not belong with the others.

use std::collections::BTreeMap;

use std::ops::ControlFlow;

use executor::contained::{Panicked, contained};
use executor::{Executor, Inline};
use flight_data::Header;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statistics::{Estimate, pooled};

pub use crate::batch_result::{DiagnoseResult, FailedDiagnosis};
use crate::diagnose::{Diagnosis, NamedReplay, Verdict, diagnose};
use crate::name::Name;

/// Header keys, beside the vehicle, that identify the aircraft.
const IDS: [&str; 4] = ["glider_id", "registration", "vehicle_id", "serial"];

/// One effect's coefficient from one flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Coefficient {
    /// The estimate, fitted together with the effects that this flight shows to be missing.
    pub value: f64,
    /// One sigma.
    pub sigma: f64,
    /// Whether that flight alone shows that the effect is missing.
    pub identified: bool,
}

/// Diagnosis of one flight alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightResult {
    /// The file.
    pub file: String,
    /// The vehicle, by the flight's header.
    pub vehicle: String,
    /// The verdict; `None` if the diagnosis failed.
    pub verdict: Option<Verdict>,
    /// Why it failed: a defect of this program.
    pub failed: Option<String>,
    /// Coefficients of the effects in question, by their ids, where the flight determines them.
    pub coefficients: BTreeMap<Name, Coefficient>,
}

/// One effect from all flights of a vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct EffectResult {
    /// Its id.
    pub effect: Name,
    /// Its unit.
    pub unit: Name,
    /// Number of flights that determine it.
    pub flights: usize,
    /// Mean of its coefficients, without the outliers.
    pub mean: f64,
    /// One sigma of the mean.
    pub sigma: f64,
    /// Spread of the coefficient from flight to flight beyond their sigmas, 1 sigma.
    pub spread: f64,
    /// Flights that do not belong with the others, the oddest first.
    pub outliers: Vec<OddFlight>,
}

/// A flight that does not belong with the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OddFlight {
    /// The file.
    pub file: String,
    /// Its coefficient.
    pub coefficient: f64,
    /// One sigma.
    pub sigma: f64,
    /// Probability that one of this many flights is as far off, if all were alike.
    pub p_value: f64,
}

/// A vehicle's flights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct VehicleResult {
    /// The vehicle; empty if the header has none.
    pub vehicle: String,
    /// Number of its flights.
    pub flights: usize,
    /// The effects in question that any of them determines.
    pub effects: Vec<EffectResult>,
}

/// Several flights, diagnosed one by one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Batch {
    /// The flights, in the user's order.
    pub by_flight: Vec<FlightResult>,
    /// The vehicles, by name.
    pub by_vehicle: Vec<VehicleResult>,
    /// Units of the effects in question.
    #[serde(skip)]
    units: BTreeMap<Name, Name>,
}

impl Batch {
    /// The effects in question.
    pub fn effects(&self) -> impl Iterator<Item = &str> {
        self.units.keys().map(|effect| &**effect)
    }

    /// The effects in question, each with its unit.
    pub fn units(&self) -> impl Iterator<Item = (&str, &str)> {
        self.units.iter().map(|(effect, unit)| (&**effect, &**unit))
    }

    /// Files of the flights that do not belong with the others.
    pub fn odd_files(&self) -> impl Iterator<Item = &str> {
        let effects = self.by_vehicle.iter().flat_map(|vehicle| &vehicle.effects);
        effects.flat_map(|effect| &effect.outliers).map(|odd| odd.file.as_str())
    }
}

/// The vehicle in a header, with the ids that distinguish it from another of its type.
#[must_use]
pub fn vehicle(header: &Header) -> String {
    let ids = IDS.iter().filter_map(|id| {
        let (_, value) = header.other.iter().find(|(key, _)| key == id)?;
        (!value.is_empty()).then_some(value.as_str())
    });
    std::iter::once(header.vehicle.as_str())
        .filter(|name| !name.is_empty())
        .chain(ids)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Diagnoses every flight by itself. `together` is the diagnosis of all; `progress` is called once a flight.
/// A flight on which the diagnosis panics does not affect the others.
#[must_use]
pub fn batch(
    flights: &[NamedReplay<'_>],
    together: Option<&Diagnosis>,
    progress: &(dyn Fn() + Sync),
    executor: &dyn Executor,
) -> Batch {
    // Flights run in parallel; if they are too few for the executor, each is divided.
    let inside: &dyn Executor = if flights.len() < executor.width() { executor } else { &Inline };
    let one = |flight| {
        let found = diagnose(std::slice::from_ref(flight), &[], &mut || ControlFlow::Continue(()), inside);
        found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
    };
    let jobs = flights.iter().map(|flight| {
        let one = &one;
        move || {
            let diagnosis = contained(|| one(flight));
            progress();
            diagnosis
        }
    });
    let alone: Vec<Result<Diagnosis, Panicked>> = executor::map(executor, jobs);
    let mut units = BTreeMap::new();
    for diagnosis in alone.iter().filter_map(|diagnosis| diagnosis.as_ref().ok()).chain(together) {
        let asked = in_question(diagnosis);
        let candidates = diagnosis.sensors.values().flat_map(|sensor| &sensor.candidates);
        units.extend(
            candidates
                .filter(|candidate| asked.contains(&candidate.effect))
                .map(|candidate| (candidate.effect.clone(), candidate.unit.clone())),
        );
    }
    let by_flight: Vec<FlightResult> = flights
        .iter()
        .zip(alone)
        .map(|(flight, diagnosis)| {
            let diagnosis = diagnosis.as_ref();
            FlightResult {
                file: flight.file.clone(),
                vehicle: vehicle(&flight.replay.flight().header),
                verdict: diagnosis.ok().map(|diagnosis| diagnosis.verdict),
                failed: diagnosis.err().map(ToString::to_string),
                coefficients: diagnosis.map(|diagnosis| coefficients(diagnosis, &units)).unwrap_or_default(),
            }
        })
        .collect();
    Batch { by_vehicle: vehicles(&by_flight, &units), by_flight, units }
}

/// Effects that a diagnosis reports as missing, and the best of each indistinguishable set.
fn in_question(diagnosis: &Diagnosis) -> Vec<Name> {
    let sensors = diagnosis.sensors.values();
    sensors
        .flat_map(|sensor| {
            let best = sensor.indistinguishable.iter().filter_map(|set| set.first());
            sensor.missing.iter().chain(best).cloned()
        })
        .collect()
}

fn coefficients(diagnosis: &Diagnosis, units: &BTreeMap<Name, Name>) -> BTreeMap<Name, Coefficient> {
    let mut found = BTreeMap::new();
    for sensor in diagnosis.sensors.values() {
        for candidate in &sensor.candidates {
            let is_known =
                candidate.coefficient.is_finite() && candidate.sigma.is_finite() && candidate.sigma > 0.0;
            if is_known && units.contains_key(&candidate.effect) {
                let coefficient = Coefficient {
                    value: candidate.coefficient,
                    sigma: candidate.sigma,
                    identified: sensor.missing.contains(&candidate.effect),
                };
                // The chosen candidates come first.
                found.entry(candidate.effect.clone()).or_insert(coefficient);
            }
        }
    }
    found
}

fn vehicles(flights: &[FlightResult], units: &BTreeMap<Name, Name>) -> Vec<VehicleResult> {
    let mut by_name: BTreeMap<&str, Vec<&FlightResult>> = BTreeMap::new();
    for flight in flights {
        by_name.entry(&flight.vehicle).or_default().push(flight);
    }
    let effect = |flights: &[&FlightResult], effect: &Name, unit: &Name| {
        let told: Vec<(&FlightResult, Coefficient)> =
            flights.iter().filter_map(|flight| Some((*flight, *flight.coefficients.get(effect)?))).collect();
        let estimates: Vec<Estimate> =
            told.iter().map(|(_, one)| Estimate { value: one.value, sigma: one.sigma }).collect();
        let pooled = pooled(&estimates)?;
        let outliers = pooled.outliers.iter().filter_map(|outlier| {
            let (flight, one) = told.get(outlier.place)?;
            Some(OddFlight {
                file: flight.file.clone(),
                coefficient: one.value,
                sigma: one.sigma,
                p_value: outlier.p_value,
            })
        });
        Some(EffectResult {
            effect: effect.clone(),
            unit: unit.clone(),
            flights: told.len(),
            mean: pooled.mean,
            sigma: pooled.sigma,
            spread: pooled.spread,
            outliers: outliers.collect(),
        })
    };
    by_name
        .into_iter()
        .map(|(vehicle, flights)| VehicleResult {
            vehicle: vehicle.to_owned(),
            flights: flights.len(),
            effects: units.iter().filter_map(|(id, unit)| effect(&flights, id, unit)).collect(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::CandidateFacts;

    fn facts(effect: &str, coefficient: f64, sigma: f64) -> CandidateFacts {
        CandidateFacts {
            effect: effect.to_owned().into(),
            coefficient,
            sigma,
            unit: "s".into(),
            probability: None,
            p_value: 0.5,
            rms_before_m: None,
            rms_after_m: None,
            chosen: false,
            time_constant_s: None,
            smoothing_s: None,
            pure_delay_s: None,
            noise_share: 0.0,
            since: None,
            size_m: 0.0,
            envelope_m: [0.0; 2],
        }
    }

    /// A coefficient counts if it and its sigma are finite, the sigma is positive and the effect is in
    /// question. Of several for one effect the first counts.
    #[test]
    fn coefficients_are_those_that_can_be_pooled() {
        let candidates = vec![
            facts("a.good", 1.5, 0.5),
            facts("a.good", 9.0, 0.1),
            facts("b.certain", 1.0, 0.0),
            facts("c.none", f64::NAN, 1.0),
            facts("d.unsure", 1.0, f64::INFINITY),
            facts("e.unasked", 1.0, 1.0),
        ];
        let sensor = crate::diagnose::SensorDiagnosis {
            missing: vec!["a.good".into()],
            candidates,
            ..crate::diagnose::SensorDiagnosis::default()
        };
        let diagnosis =
            Diagnosis { sensors: BTreeMap::from([("baro".into(), sensor)]), ..Diagnosis::default() };
        let asked = ["a.good", "b.certain", "c.none", "d.unsure"].map(|id| (Name::from(id), Name::from("s")));
        let found = coefficients(&diagnosis, &BTreeMap::from(asked));
        assert_eq!(found.keys().collect::<Vec<_>>(), ["a.good"]);
        let good = found["a.good"];
        assert_eq!((good.value, good.sigma, good.identified), (1.5, 0.5, true));
    }
}
