//! What a diagnosis found: the keys of `pylon diagnose --json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::replay::Usage;

/// What is known about a misfit. Ordered by how much it asks of the user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model fits as well as the noise allows, and the flight would have shown what it lacks.
    #[default]
    NoSignificantMisfit,
    /// The model fits, but the flight would not have shown what it lacks.
    InsufficientExcitation,
    /// Effects of the catalogue are missing, and nothing else in it could stand in their place.
    Identified,
    /// An effect is missing, and it is one of a set that this flight can't tell apart.
    Indistinguishable,
    /// A misfit that nothing in the catalogue explains.
    UnknownEffect,
}

impl Verdict {
    /// The word in JSON.
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
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Over all sensors: that of the sensor with the largest misfit.
    pub verdict: Verdict,
    /// By sensor; effects of the reference are under `gps`.
    pub sensors: BTreeMap<&'static str, SensorDiagnosis>,
    /// The model's name: a preset or a file.
    pub model: String,
    /// The flights learned from.
    pub flights: Vec<DiagnosedFlight>,
    /// The flights held out, if any; without, stretches of the flights are held out in turn.
    pub hold_outs: Vec<String>,
    /// The noise that was found beside the effects.
    pub noise: NoiseFacts,
    /// Effects that could not be tested, because the flights lack a signal.
    pub untested: Vec<Untested>,
    /// What was remarkable about the input.
    pub warnings: Vec<String>,
}

/// One sensor, or the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SensorDiagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Ids of the effects that are missing for sure, the strongest first.
    pub missing: Vec<&'static str>,
    /// Sets of ids: of each set, one acts, and the flights can't tell which. The best fit comes first.
    pub indistinguishable: Vec<Vec<&'static str>>,
    /// Every effect that was tried, the chosen ones first and then by their p-value.
    pub candidates: Vec<CandidateFacts>,
    /// What to do next, in words; empty where nothing is to be done.
    pub advice: String,
    /// Signals that an unexplained residual follows, the closest first.
    pub follows: Vec<Follows>,
    /// How many times larger the sensor's own wander is in free flight than in captive flight, once
    /// everything that was found is taken off.
    pub free_flight_factor: Option<f64>,
}

/// One candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateFacts {
    /// Its id.
    pub effect: &'static str,
    /// Estimated coefficient: beside the other effects found, or alone if it was not.
    pub coefficient: f64,
    /// One sigma of it, its autocorrelated noise and its spread over the manoeuvres accounted for.
    pub sigma: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Chance of as strong a fit if the effect did not act, times the number of effects tried.
    pub p_value: f64,
    /// Root mean square of the held-out errors without it, m.
    pub rms_before_m: Option<f64>,
    /// With it, m.
    pub rms_after_m: Option<f64>,
    /// Whether it is part of the explanation.
    pub chosen: bool,
    /// Time constant of its regressor, s, where it has one.
    pub time_constant_s: Option<f64>,
    /// Time constant of the low pass that fits a lag better than a shift of the slope does, seconds, if one does.
    pub smoothing_s: Option<f64>,
    /// When that regressor's clock starts, where it has a time constant: `launch` or `start`.
    pub since: Option<&'static str>,
    /// How much of the residual it makes in free flight, rms, m.
    pub size_m: f64,
    /// The range of its regressor in these flights, m per unit.
    pub envelope_m: [f64; 2],
}

/// A signal that the unexplained residual follows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Follows {
    /// The signal, and what of it.
    pub signal: String,
    /// How far the residual lags behind it, s.
    pub lag_s: f64,
    /// How much of the residual it would explain, rms, m.
    pub size_m: f64,
    /// What it gains in twice the log likelihood.
    pub evidence: f64,
}

/// One flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DiagnosedFlight {
    /// The file.
    pub file: String,
    /// Where captive flight ends and free flight begins, and why.
    pub calibration: String,
    /// Which part of the log was worked on.
    #[serde(flatten)]
    pub usage: Usage,
    /// Blocks of residuals that were worked on.
    pub blocks: usize,
    /// Their length, s.
    pub block_s: f64,
    /// Stretches in which the reference jumped away and came back; they were left out. Seconds.
    pub glitches_s: Vec<(f64, f64)>,
    /// Readings left out because the reference was lost around them.
    pub unreferenced_readings: u64,
}

/// The noise that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NoiseFacts {
    /// The reference's wander: sigma, m.
    pub reference_wander_m: f64,
    /// Its correlation time, s.
    pub reference_time_s: f64,
    /// White noise of one fix, m.
    pub fix_sigma_m: f64,
    /// Each sensor's own wander (captive flight): sigma, m, and correlation time, s.
    pub sensor_wander: BTreeMap<&'static str, (f64, f64)>,
}

/// An effect that could not be tested.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Untested {
    /// Its id.
    pub effect: &'static str,
    /// The columns that it needs.
    pub needs: Vec<&'static str>,
}
