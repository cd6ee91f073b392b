//! What a diagnosis found: the keys of `pylon diagnose --json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::name::Name;
use replay::{Unused, Usage};

/// What is known about a misfit, ordered by how much it asks of the user.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model fits as well as the noise allows, and the flight would have shown a missing effect.
    #[default]
    NoSignificantMisfit,
    /// The model fits, but the flight would not have shown a missing effect.
    InsufficientExcitation,
    /// Effects of the catalogue are missing, and no other effect in it could replace them.
    Identified,
    /// An effect is missing, one of a set that this flight cannot tell apart; or an effect may be missing.
    Indistinguishable,
    /// A misfit that nothing in the catalogue explains.
    UnknownEffect,
}

impl Verdict {
    /// The name used in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoSignificantMisfit => "no_significant_misfit",
            Self::InsufficientExcitation => "insufficient_excitation",
            Self::Identified => "identified",
            Self::Indistinguishable => "indistinguishable",
            Self::UnknownEffect => "unknown_effect",
        }
    }
}

/// A diagnosis of one or more flights with one model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Diagnosis {
    /// Version of the keys' meaning. It increases where a key changes its meaning or is removed.
    pub version: u32,
    /// The verdict over all sensors: that of the sensor with the largest misfit.
    pub verdict: Verdict,
    /// The diagnosis by sensor; effects of the reference are under `gps`.
    pub sensors: BTreeMap<Name, SensorDiagnosis>,
    /// The model's name: a preset or a file.
    pub model: String,
    /// The flights learned from.
    pub flights: Vec<DiagnosedFlight>,
    /// The flights held out, if any. If none, stretches of the flights are held out in turn.
    pub hold_outs: Vec<String>,
    /// The noise that was found together with the effects.
    pub noise: NoiseFacts,
    /// Effects that could not be tested, because the flights lack a signal.
    pub untested: Vec<Untested>,
    /// Anything remarkable about the input.
    pub warnings: Vec<String>,
}

impl Diagnosis {
    /// The version that this program writes.
    pub const VERSION: u32 = 3;

    /// Why nothing could be tested, in words: no flight has a block with both the reference and a sensor that
    /// measures. `None` where something could.
    #[must_use]
    pub fn untestable(&self) -> Option<String> {
        let has_nothing = self.flights.iter().all(|flight| flight.blocks == 0 || flight.fault.is_some());
        if !has_nothing || self.sensors.keys().any(|name| *name != "gps") {
            return None;
        }
        Some(
            self.flights
                .iter()
                .find_map(|flight| flight.fault.clone())
                .unwrap_or_else(|| "no sensor has a reading while the reference is available".to_owned()),
        )
    }

    /// Ids of the effects that are certainly missing, sensor by sensor.
    pub fn missing(&self) -> impl Iterator<Item = &str> {
        self.sensors.values().flat_map(|sensor| &sensor.missing).map(|effect| &**effect)
    }

    /// Ids of the effects of all sets that cannot be told apart.
    pub fn suspects(&self) -> impl Iterator<Item = &str> {
        self.sensors
            .values()
            .flat_map(|sensor| sensor.indistinguishable.iter().flatten())
            .map(|effect| &**effect)
    }
}

/// One sensor, or the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorDiagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Ids of the effects that are certainly missing, the strongest first.
    pub missing: Vec<Name>,
    /// Sets of effect ids: one of each set acts, or none (see `nothing`), and the flights cannot
    /// tell which. The most probable comes first. Those below 5 % are not listed; but where an effect does
    /// act, the second is.
    pub indistinguishable: Vec<Vec<Name>>,
    /// Probability of each effect of a set, in the order of `indistinguishable`. What remains to 1 is that of
    /// nothing, and of effects that are not listed.
    pub probabilities: Vec<Vec<f64>>,
    /// Probability that no effect acts in the place of a set, in the order of `indistinguishable`. Null where
    /// it is below 5 %; where the climb rate is measured, null where the set has passed a test of
    /// significance.
    #[serde(default)]
    pub nothing: Vec<Option<f64>>,
    /// Every effect that was tried: the chosen ones first, then by p-value.
    pub candidates: Vec<CandidateFacts>,
    /// What to do next, in words; empty if nothing is to be done.
    pub advice: String,
    /// Signals that an unexplained residual follows, the closest first.
    pub follows: Vec<Follows>,
    /// How many times larger the sensor's own wander is in free flight than in captive flight, after
    /// everything that was found is subtracted.
    pub free_flight_factor: Option<f64>,
}

/// Effects of which one acts, or perhaps none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneOf<'a> {
    /// Ids of the effects, the most probable first.
    pub effects: &'a [Name],
    /// Their probabilities.
    pub probabilities: &'a [f64],
    /// The probability that none of them acts, from 5 % on.
    pub nothing: Option<f64>,
}

impl SensorDiagnosis {
    /// The sets of effects that the flights cannot tell apart.
    pub fn sets(&self) -> impl Iterator<Item = OneOf<'_>> {
        self.indistinguishable.iter().enumerate().map(|(at, effects)| OneOf {
            effects,
            probabilities: self.probabilities.get(at).map_or(&[], Vec::as_slice),
            nothing: self.nothing.get(at).copied().flatten(),
        })
    }

    /// Whether an effect is missing for sure.
    #[must_use]
    pub fn lacks(&self, effect: &str) -> bool {
        self.missing.iter().any(|missing| missing == effect)
    }
}

/// One candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CandidateFacts {
    /// Its id.
    pub effect: Name,
    /// Estimated coefficient: together with the other effects found, or alone if the effect was not chosen.
    pub coefficient: f64,
    /// One sigma of the coefficient, including autocorrelated noise and the spread over the manoeuvres.
    pub sigma: f64,
    /// Its unit.
    pub unit: Name,
    /// Probability that the effect acts: the sum over the sets of effects that explain the flights and
    /// contain it. Where the climb rate is measured, only identified effects and members of a set have one,
    /// which is the probability within that set.
    #[serde(default)]
    pub probability: Option<f64>,
    /// Probability of as strong a fit if the effect did not act, times the number of effects tried.
    pub p_value: f64,
    /// Root mean square of the held-out errors without this effect, with every other chosen one, m.
    pub rms_before_m: Option<f64>,
    /// The same with this effect, m. Both are absent where most of the error would come from the
    /// coefficient's own uncertainty, because only the held-out part shows the effect.
    pub rms_after_m: Option<f64>,
    /// Whether the effect is part of the explanation.
    pub chosen: bool,
    /// Time constant of the regressor, s, if it has one.
    pub time_constant_s: Option<f64>,
    /// Time constant of the low pass that fits a lag better than a shift of the slope does, seconds, if there
    /// is one.
    pub smoothing_s: Option<f64>,
    /// The pure delay that fits a lag better than a shift of the slope does, seconds, if there is one.
    pub pure_delay_s: Option<f64>,
    /// The share of the regressor's squares that is the noise of its own signals, beside the other chosen
    /// effects, at most one half. The coefficient may be too small by it, which sigma includes.
    pub noise_share: f64,
    /// When the clock of a regressor with a time constant starts: `launch` or `start`.
    pub since: Option<Name>,
    /// How much of the residual the effect makes in free flight, rms, m.
    pub size_m: f64,
    /// The range of the regressor in these flights, m per unit.
    pub envelope_m: [f64; 2],
}

/// A signal that the unexplained residual follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Follows {
    /// The signal, and which form of it.
    pub signal: String,
    /// How far the residual lags behind the signal, s.
    pub lag_s: f64,
    /// How much of the residual the signal would explain, rms, m.
    pub size_m: f64,
    /// What the signal gains in twice the log likelihood.
    pub evidence: f64,
}

/// One flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(from = "FlatFlight")]
pub struct DiagnosedFlight {
    /// The file.
    pub file: String,
    /// Where captive flight ends and free flight begins, and why.
    pub calibration: String,
    /// Which part of the log was used.
    #[serde(flatten)]
    pub usage: Usage,
    /// Number of blocks of residuals that were used.
    pub blocks: usize,
    /// Length of a block, s.
    pub block_s: f64,
    /// Stretches in which the reference jumped away and came back; they were left out.
    pub glitches: Vec<Glitch>,
    /// Readings left out because the reference was lost around them.
    pub unreferenced_readings: u64,
    /// Invalid readings, which the mission refuses as well: not finite, implausible, or of a sensor that is
    /// stuck.
    #[serde(default, skip_serializing_if = "is_none")]
    pub refused_readings: u64,
    /// What is wrong with a sensor for the whole flight, because of which it was left out: it is stuck, or a
    /// copy of the receiver.
    pub fault: Option<String>,
}

/// A stretch in which the reference jumped away and came back, in the flight's own time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Glitch {
    /// Its start, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

/// The noise that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct NoiseFacts {
    /// Sigma of the reference's wander, m.
    pub reference_wander_m: f64,
    /// Correlation time of the reference's wander, s.
    pub reference_time_s: f64,
    /// Sigma of a second, slower wander of the difference of the altitudes (the reference's or a sensor's),
    /// m; 0 where the climb rate is measured, which needs none.
    #[serde(default)]
    pub slow_wander_m: f64,
    /// Correlation time of the slow wander, s.
    #[serde(default)]
    pub slow_time_s: f64,
    /// White noise of one fix, m.
    pub fix_sigma_m: f64,
    /// Each sensor's own wander (captive flight).
    pub sensor_wander: BTreeMap<Name, SensorWander>,
}

/// A sensor's own wander.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorWander {
    /// Its sigma, m.
    pub sigma_m: f64,
    /// Its correlation time, s.
    pub time_s: f64,
}

/// An effect that could not be tested.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Untested {
    /// Its id.
    pub effect: Name,
    /// The columns that it needs.
    pub needs: Vec<Name>,
    /// Why no column would help, if none would.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
const fn is_none(count: &u64) -> bool {
    *count == 0
}

/// A flight as it is read: serde's `flatten` does not read numbers where a dependency makes `serde_json` keep
/// their digits (serde_json's issue 505).
#[derive(Deserialize, JsonSchema)]
struct FlatFlight {
    file: String,
    calibration: String,
    has_launch: bool,
    flights: usize,
    flight: Option<usize>,
    take_off_s: Option<f64>,
    landing_s: Option<f64>,
    used_share: f64,
    unused: Vec<Unused>,
    remarks: Vec<String>,
    blocks: usize,
    block_s: f64,
    glitches: Vec<Glitch>,
    unreferenced_readings: u64,
    #[serde(default)]
    refused_readings: u64,
    fault: Option<String>,
}

impl From<FlatFlight> for DiagnosedFlight {
    fn from(flat: FlatFlight) -> Self {
        Self {
            file: flat.file,
            calibration: flat.calibration,
            usage: Usage {
                has_launch: flat.has_launch,
                flights: flat.flights,
                flight: flat.flight,
                take_off_s: flat.take_off_s,
                landing_s: flat.landing_s,
                used_share: flat.used_share,
                unused: flat.unused,
                remarks: flat.remarks,
            },
            blocks: flat.blocks,
            block_s: flat.block_s,
            glitches: flat.glitches,
            unreferenced_readings: flat.unreferenced_readings,
            refused_readings: flat.refused_readings,
            fault: flat.fault,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagnosis_reads_what_it_wrote() {
        let unused = Unused { from_s: 0.0, to_s: 61.25, share: 0.1, reason: "on the ground".to_owned() };
        let usage = Usage { flight: Some(2), used_share: 0.9, unused: vec![unused], ..Usage::default() };
        let candidate = CandidateFacts {
            effect: "an.effect_of_ones_own".into(),
            coefficient: 0.1,
            sigma: 1e-9,
            unit: "s".into(),
            probability: Some(0.98),
            p_value: 3e-269,
            rms_before_m: Some(2.0),
            rms_after_m: None,
            chosen: true,
            time_constant_s: None,
            smoothing_s: Some(4.0),
            pure_delay_s: None,
            noise_share: 0.0,
            since: Some("launch".into()),
            size_m: 26.870_493_240_356_446,
            envelope_m: [-1.0, 1.5],
        };
        let sensor = SensorDiagnosis {
            verdict: Verdict::Indistinguishable,
            indistinguishable: vec![vec!["baro.lag".into(), candidate.effect.clone()]],
            probabilities: vec![vec![0.625, 0.25]],
            nothing: vec![Some(0.125)],
            candidates: vec![candidate],
            follows: vec![Follows { signal: "flap".to_owned(), lag_s: 2.0, size_m: 0.5, evidence: 20.0 }],
            free_flight_factor: Some(1.25),
            ..SensorDiagnosis::default()
        };
        let flight = DiagnosedFlight {
            usage,
            glitches: vec![Glitch { from_s: 1.0, to_s: 2.5 }],
            refused_readings: 3,
            ..DiagnosedFlight::default()
        };
        let untested =
            Untested { effect: "baro.propwash".into(), needs: vec!["throttle".into()], reason: None };
        let written = Diagnosis {
            version: Diagnosis::VERSION,
            verdict: Verdict::Indistinguishable,
            sensors: BTreeMap::from([("baro".into(), sensor)]),
            flights: vec![flight],
            untested: vec![untested],
            ..Diagnosis::default()
        };
        let json = serde_json::to_string(&written).unwrap();
        assert_eq!(serde_json::from_str::<Diagnosis>(&json).unwrap(), written, "{json}");
    }

    /// A set has its own effects, probabilities and nothing; an older result says nothing about nothing.
    #[test]
    fn a_set_is_read_with_the_probability_of_nothing() {
        let sensor = SensorDiagnosis {
            indistinguishable: vec![vec!["baro.drift".into()], vec!["baro.lag".into(), "baro.scale".into()]],
            probabilities: vec![vec![0.6], vec![0.7, 0.26]],
            nothing: vec![Some(0.4), None],
            ..SensorDiagnosis::default()
        };
        let nothing: Vec<Option<f64>> = sensor.sets().map(|set| set.nothing).collect();
        assert_eq!(nothing, [Some(0.4), None]);
        let first = sensor.sets().next().unwrap();
        assert_eq!((first.effects, first.probabilities), (&["baro.drift".into()][..], &[0.6][..]));
        let before = SensorDiagnosis { nothing: Vec::new(), ..sensor };
        assert!(before.sets().all(|set| set.nothing.is_none()));
    }
}
