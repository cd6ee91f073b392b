//! Reading a model's TOML.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use kf_core::config::{ClimbRate, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource};
use kf_core::effect::{Clock, EffectId, EffectTerm, Regressor};
use kf_core::sensor::{SENSORS, Sensor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

use crate::definitions::{DefinitionTable, definitions};
use crate::{Effect, Model, ModelError, Revision, SECOND_CORRECTION_WANDER_M_PER_SQRT_S};

impl Model {
    /// The preset with this name (`default`, `paper`), otherwise the model in the file with this name.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn load(preset_or_file: &str) -> Result<Self, ModelError> {
        Self::preset(preset_or_file).map_or_else(|| Self::read(Path::new(preset_or_file)), Ok)
    }

    /// Reads a model from a file.
    ///
    /// # Errors
    /// [`ModelError::InFile`] with the first error.
    pub fn read(file: &Path) -> Result<Self, ModelError> {
        fs::read_to_string(file)
            .map_err(ModelError::Io)
            .and_then(|text| Self::parse(&text))
            .map_err(|error| ModelError::InFile { file: file.to_path_buf(), error: Box::new(error) })
    }

    /// Reads a model from TOML text; a missing key takes the default preset's value.
    ///
    /// # Errors
    /// The first part of it that is not TOML, not a model's, or not possible.
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        let file: ModelFile = toml::from_str(text).map_err(|error| syntax_error(text, error))?;
        let mut model = Self::default();
        file.apply(&mut model, text)?;
        model.validate()?;
        Ok(model)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    settling_s: Option<f32>,
    second_correction: Option<Correction>,
    second_correction_wander_m_per_sqrt_s: Option<f32>,
    site: Option<Site>,
    gps: Option<Gps>,
    sensor: Option<SensorTables>,
    monitor: Option<Monitor>,
    quality: Option<Quality>,
    #[serde(default)]
    effect_definition: Vec<DefinitionTable>,
    #[serde(default)]
    effect: Vec<EffectTable>,
    #[serde(default)]
    revision: Vec<RevisionTable>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Correction {
    Off,
    MovingAverage,
    Kalman,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Site {
    latitude_deg: Option<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Gps {
    sigma_m: Option<f32>,
    correlation_time_s: Option<f32>,
    prior_altitude_m: Option<f32>,
    prior_sigma_m: Option<f32>,
    propagate_climb_rate: Option<bool>,
    climb_rate_sigma_mps: Option<f32>,
    climb_rate_correlation_time_s: Option<f32>,
    lost_after_s: Option<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorTables {
    imu_master: Option<SensorTable>,
    imu_slave: Option<SensorTable>,
    baro: Option<SensorTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorTable {
    sigma_m: Option<f32>,
    correlation_time_s: Option<f32>,
    prior_bias_m: Option<f32>,
    prior_sigma_m: Option<f32>,
    wander_m_per_sqrt_s: Option<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Monitor {
    sigma: Option<Sigma>,
    multiplier: Option<f32>,
    window_s: Option<f32>,
    persistence_s: Option<f32>,
    reference_check: Option<bool>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Sigma {
    Residual,
    Covariance,
    Datasheet,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Quality {
    minimum_duration_s: Option<f32>,
    trimmed_altitude_m: Option<f32>,
    trimmed_airspeed_mps: Option<f32>,
    reference_drift_m: Option<f32>,
    minimum_satellites: Option<u8>,
    vertical_accuracy_m: Option<f32>,
    bias_drift_sigmas: Option<f32>,
    implausible_share: Option<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EffectTable {
    id: Spanned<String>,
    coefficient: Option<f32>,
    sigma: Option<f32>,
    #[serde(default)]
    estimate: bool,
    learned_from: Option<String>,
    #[serde(default, deserialize_with = "date_or_text")]
    date: Option<String>,
    time_constant_s: Option<f32>,
    since: Option<Since>,
    envelope_m: Option<[f32; 2]>,
    formula: Option<Spanned<String>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Since {
    Launch,
    Start,
}

impl From<Since> for Clock {
    fn from(since: Since) -> Self {
        match since {
            Since::Launch => Self::Launch,
            Since::Start => Self::Start,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RevisionTable {
    number: Spanned<u32>,
    #[serde(default, deserialize_with = "date_or_text")]
    date: Option<String>,
    effect: Option<Spanned<String>>,
    learned_from: Option<String>,
    coefficient: Option<f32>,
    sigma: Option<f32>,
    estimate: Option<bool>,
    time_constant_s: Option<f32>,
    since: Option<Since>,
    replaced_coefficient: Option<f32>,
    rms_before_m: Option<f64>,
    rms_after_m: Option<f64>,
    held_out_before_m: Option<f64>,
    held_out_after_m: Option<f64>,
}

/// A date, as a TOML date or as text.
fn date_or_text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    use serde::de::Error as _;
    match toml::Value::deserialize(deserializer)? {
        toml::Value::String(text) => Ok(Some(text)),
        toml::Value::Datetime(date) => Ok(Some(date.to_string())),
        other => Err(D::Error::custom(format!("a date is {}, expected a date or text", other.type_str()))),
    }
}

fn put<T>(slot: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *slot = value;
    }
}

impl ModelFile {
    fn apply(self, model: &mut Model, text: &str) -> Result<(), ModelError> {
        put(&mut model.settling_s, self.settling_s);
        model.second_correction = second_correction(
            self.second_correction.unwrap_or(Correction::Off),
            self.second_correction_wander_m_per_sqrt_s,
        )?;
        put(&mut model.latitude_deg, self.site.and_then(|site| site.latitude_deg));
        if let Some(gps) = self.gps {
            gps.apply(&mut model.reference)?;
        }
        if let Some(tables) = self.sensor {
            tables.apply(&mut model.sensors);
        }
        if let Some(monitor) = self.monitor {
            let sigma = monitor.sigma.map(|sigma| match sigma {
                Sigma::Residual => SigmaSource::Residual,
                Sigma::Covariance => SigmaSource::Covariance,
                Sigma::Datasheet => SigmaSource::Datasheet,
            });
            put(&mut model.monitor.sigma, sigma);
            put(&mut model.monitor.multiplier, monitor.multiplier);
            put(&mut model.monitor.window_s, monitor.window_s);
            put(&mut model.monitor.persistence_s, monitor.persistence_s);
            put(&mut model.monitor.reference_check, monitor.reference_check);
        }
        if let Some(quality) = self.quality {
            let slots = &mut model.quality;
            put(&mut slots.minimum_duration_s, quality.minimum_duration_s);
            put(&mut slots.trimmed_altitude_m, quality.trimmed_altitude_m);
            put(&mut slots.trimmed_airspeed_mps, quality.trimmed_airspeed_mps);
            put(&mut slots.reference_drift_m, quality.reference_drift_m);
            put(&mut slots.minimum_satellites, quality.minimum_satellites);
            put(&mut slots.vertical_accuracy_m, quality.vertical_accuracy_m);
            put(&mut slots.bias_drift_sigmas, quality.bias_drift_sigmas);
            put(&mut slots.implausible_share, quality.implausible_share);
        }
        model.definitions = definitions(&self.effect_definition, text)?;
        let effects = self.effect.into_iter().map(|table| table.into_effect(model, text));
        model.effects = effects.collect::<Result<_, _>>()?;
        model.revisions = revisions(self.revision, model, text)?;
        Ok(())
    }
}

fn second_correction(kind: Correction, wander: Option<f32>) -> Result<SecondCorrection, ModelError> {
    match (kind, wander) {
        (Correction::Kalman, wander) => Ok(SecondCorrection::Kalman {
            wander_m_per_sqrt_s: wander.unwrap_or(SECOND_CORRECTION_WANDER_M_PER_SQRT_S),
        }),
        (_, Some(_)) => Err(ModelError::NoEffect {
            key: "second_correction_wander_m_per_sqrt_s",
            because: "second_correction is not \"kalman\"",
        }),
        (Correction::MovingAverage, None) => Ok(SecondCorrection::MovingAverage),
        (Correction::Off, None) => Ok(SecondCorrection::Off),
    }
}

impl Gps {
    fn apply(self, reference: &mut ReferenceConfig) -> Result<(), ModelError> {
        put(&mut reference.sigma_m, self.sigma_m);
        put(&mut reference.correlation_time_s, self.correlation_time_s);
        reference.prior_altitude_m = self.prior_altitude_m.or(reference.prior_altitude_m);
        put(&mut reference.prior_sigma_m, self.prior_sigma_m);
        put(&mut reference.lost_after_s, self.lost_after_s);
        if self.propagate_climb_rate == Some(false) {
            for (key, value) in [
                ("gps.climb_rate_sigma_mps", self.climb_rate_sigma_mps),
                ("gps.climb_rate_correlation_time_s", self.climb_rate_correlation_time_s),
            ] {
                if value.is_some() {
                    let because = "gps.propagate_climb_rate is false";
                    return Err(ModelError::NoEffect { key, because });
                }
            }
            reference.climb_rate = None;
        } else if let Some(ClimbRate { sigma_mps, correlation_time_s }) = &mut reference.climb_rate {
            put(sigma_mps, self.climb_rate_sigma_mps);
            put(correlation_time_s, self.climb_rate_correlation_time_s);
        }
        Ok(())
    }
}

impl SensorTables {
    fn apply(self, sensors: &mut [SensorConfig; SENSORS]) {
        for (slots, sensor) in sensors.iter_mut().zip(Sensor::ALL) {
            let table = match sensor {
                Sensor::ImuMaster => &self.imu_master,
                Sensor::ImuSlave => &self.imu_slave,
                Sensor::Baro => &self.baro,
            };
            let Some(table) = table else { continue };
            put(&mut slots.sigma_m, table.sigma_m);
            put(&mut slots.correlation_time_s, table.correlation_time_s);
            put(&mut slots.prior_bias_m, table.prior_bias_m);
            put(&mut slots.prior_sigma_m, table.prior_sigma_m);
            put(&mut slots.wander_m_per_sqrt_s, table.wander_m_per_sqrt_s);
        }
    }
}

impl EffectTable {
    /// Checks that a learned coefficient belongs to its effect's present formula.
    fn check_formula(&self, id: EffectId, text: &str) -> Result<(), ModelError> {
        let row = |place: std::ops::Range<usize>| row_and_column(text, place.start).0;
        let Some(parts) = id.formula() else {
            return match &self.formula {
                None => Ok(()),
                Some(_) => Err(ModelError::Value {
                    key: format!("formula of effect {}", id.name()),
                    found: "given".to_owned(),
                    expected: "no such key: this effect is the catalogue's",
                }),
            };
        };
        let now = fingerprint_text(parts.fingerprint);
        match &self.formula {
            Some(found) if *found.get_ref() != now => Err(ModelError::OtherFormula {
                row: row(found.span()),
                id: parts.name,
                found: found.get_ref().clone(),
                now,
            }),
            None if self.learned_from.is_some() => {
                Err(ModelError::NoFormula { row: row(self.id.span()), id: parts.name, now })
            }
            _ => Ok(()),
        }
    }

    fn into_effect(self, model: &Model, text: &str) -> Result<Effect, ModelError> {
        let id = effect_id(&self.id, model, text)?;
        let name = id.name();
        self.check_formula(id, text)?;
        let required = |key: &str, value: Option<f32>, default: Option<f32>| {
            value.or(default).ok_or_else(|| ModelError::Value {
                key: format!("{key} of effect {name}"),
                found: "missing".to_owned(),
                expected: "a number",
            })
        };
        // A prior mean of zero is neutral; a default for a constant coefficient or a prior sigma would not
        // be.
        let coefficient = required("coefficient", self.coefficient, self.estimate.then_some(0.0))?;
        let sigma = required("sigma", self.sigma, (!self.estimate).then_some(0.0))?;
        let mut regressor = Regressor::new(id);
        if id.has_time_constant() {
            regressor.time_constant_s = required("time_constant_s", self.time_constant_s, None)?;
            regressor.since = self.since.map_or(Clock::Launch, Clock::from);
        } else if self.time_constant_s.is_some() || self.since.is_some() {
            let key = if self.since.is_some() { "since" } else { "time_constant_s" };
            return Err(ModelError::Value {
                key: format!("{key} of effect {name}"),
                found: "given".to_owned(),
                expected: "no such key: this effect has no time constant",
            });
        }
        Ok(Effect {
            term: EffectTerm { regressor, coefficient, sigma, envelope_m: self.envelope_m },
            estimate: self.estimate,
            learned_from: self.learned_from,
            date: self.date,
        })
    }
}

/// The effect with this id.
fn effect_id(name: &Spanned<String>, model: &Model, text: &str) -> Result<EffectId, ModelError> {
    model.effect_named(name.get_ref()).ok_or_else(|| {
        let (row, _) = row_and_column(text, name.span().start);
        let id = name.get_ref().clone();
        ModelError::UnknownEffect { row, nearest: model.nearest_effects(&id), id }
    })
}

/// The revisions, checked that no two have the same number.
fn revisions(tables: Vec<RevisionTable>, model: &Model, text: &str) -> Result<Vec<Revision>, ModelError> {
    let mut rows: BTreeMap<u32, usize> = BTreeMap::new();
    let mut revisions = Vec::with_capacity(tables.len());
    for table in tables {
        let number = *table.number.get_ref();
        let (row, _) = row_and_column(text, table.number.span().start);
        if let Some(first) = rows.insert(number, row) {
            return Err(ModelError::RevisionClash { number, first, second: row });
        }
        let effect = table.effect.map(|name| effect_id(&name, model, text)).transpose()?;
        let finite = |key: &str, value: Option<f64>| match value {
            Some(value) if !value.is_finite() => Err(ModelError::Value {
                key: format!("{key} of revision {number}"),
                found: value.to_string(),
                expected: "a finite number",
            }),
            value => Ok(value),
        };
        let single = |key: &str, value: Option<f32>| {
            finite(key, value.map(f64::from))?;
            Ok(value)
        };
        revisions.push(Revision {
            number,
            date: table.date,
            effect,
            learned_from: table.learned_from,
            coefficient: single("coefficient", table.coefficient)?,
            sigma: single("sigma", table.sigma)?,
            estimate: table.estimate,
            time_constant_s: single("time_constant_s", table.time_constant_s)?,
            since: table.since.map(Clock::from),
            replaced_coefficient: single("replaced_coefficient", table.replaced_coefficient)?,
            rms_before_m: finite("rms_before_m", table.rms_before_m)?,
            rms_after_m: finite("rms_after_m", table.rms_after_m)?,
            held_out_before_m: finite("held_out_before_m", table.held_out_before_m)?,
            held_out_after_m: finite("held_out_after_m", table.held_out_after_m)?,
        });
    }
    Ok(revisions)
}

/// The names nearest to `name`, best first, for a message.
pub(crate) fn nearest(name: &str, known: &[&str]) -> String {
    const SHOWN: usize = 3;
    let mut ranked: Vec<_> = known.iter().map(|known| (strsim::jaro_winkler(name, known), *known)).collect();
    ranked.sort_by(|(left, _), (right, _)| right.total_cmp(left));
    let names: Vec<_> = ranked.into_iter().take(SHOWN).map(|(_, known)| known).collect();
    names.join(", ")
}

/// A formula's fingerprint as written in `formula` of `[[effect]]`.
#[must_use]
pub fn fingerprint_text(fingerprint: u64) -> String {
    format!("{fingerprint:016x}")
}

/// Line and character of a byte of the text, from 1.
pub(crate) fn row_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |end| end + 1);
    let column = before.get(line_start..).map_or(0, |line| line.chars().count());
    (before.matches('\n').count() + 1, column + 1)
}

fn syntax_error(text: &str, error: toml::de::Error) -> ModelError {
    let (row, column) = row_and_column(text, error.span().map_or(0, |span| span.start));
    let message = one_line(error.message());
    // serde's wording: "unknown field `a`, expected one of `b`, `c`". Every second piece is a name.
    let mut pieces = message.split('`').skip(1).step_by(2);
    let message = match pieces.next() {
        Some(found) if message.starts_with("unknown field") => {
            format!("no key '{found}' here; nearest: {}", nearest(found, &pieces.collect::<Vec<_>>()))
        }
        _ => message,
    };
    ModelError::Syntax { row, column, message, source: Box::new(error) }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
