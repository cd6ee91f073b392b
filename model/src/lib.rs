//! Model of the sensors: their noise and priors, the monitor's rule, and the effects that are accounted for.
//! A model is a TOML file; the workbench and the firmware's build read the same one.
//!
//! The keys, their units and defaults are in `flights/models/README.md`; every key sets the field of
//! [`kf_core::config`] with the same name.

mod board;
mod codegen;
mod definitions;
mod error;
mod file;
pub mod formula;
mod presets;
mod rebuild;
mod validate;

use kf_core::config::{
    MissionConfig, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig,
};
use kf_core::effect::{Clock, EffectId, EffectTerm};
use kf_core::sensor::SENSORS;

pub use board::Board;
pub use codegen::codegen;
pub use definitions::Definitions;
pub use error::ModelError;
pub use file::fingerprint_text;
pub use presets::SECOND_CORRECTION_WANDER_M_PER_SQRT_S;

/// An effect of a model, and the origin of its coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The effect, its coefficient and the coefficient's sigma.
    pub term: EffectTerm,
    /// Whether the coefficient is a state of the filter rather than a constant.
    pub estimate: bool,
    /// The flight that the coefficient was learned from.
    pub learned_from: Option<String>,
    /// When it was learned.
    pub date: Option<String>,
}

/// One change of a model: the effect that was added or learned again, and the error before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct Revision {
    /// Its number, unique in a model.
    pub number: u32,
    /// When it was made.
    pub date: Option<String>,
    /// The effect.
    pub effect: Option<EffectId>,
    /// The flight that its coefficient was learned from.
    pub learned_from: Option<String>,
    /// The effect's coefficient after this revision; its other values are stored with the effect.
    pub coefficient: Option<f32>,
    /// That coefficient's sigma.
    pub sigma: Option<f32>,
    /// Whether it was a state of the filter.
    pub estimate: Option<bool>,
    /// The time constant of its regressor, seconds, if it has one.
    pub time_constant_s: Option<f32>,
    /// When that regressor's clock starts, if it has a time constant.
    pub since: Option<Clock>,
    /// The coefficient that this one replaced, if the model had the effect before.
    pub replaced_coefficient: Option<f32>,
    /// Root mean square error on that flight with the revision before this one, metres.
    pub rms_before_m: Option<f64>,
    /// The same with this revision, metres.
    pub rms_after_m: Option<f64>,
    /// As [`Self::rms_before_m`], on held-out data.
    pub held_out_before_m: Option<f64>,
    /// As [`Self::rms_after_m`], on held-out data.
    pub held_out_after_m: Option<f64>,
}

/// A model. [`Default`] is the default preset: today's MEMS sensors and GPS.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Settling time: the first part of captive flight, which is ignored, seconds.
    pub settling_s: f32,
    /// The reference.
    pub reference: ReferenceConfig,
    /// Latitude of the flights, degrees, north positive; only `imu.eotvos` needs it.
    pub latitude_deg: f32,
    /// The sensors, in the order of [`kf_core::sensor::Sensor`].
    pub sensors: [SensorConfig; SENSORS],
    /// The monitor.
    pub monitor: MonitorConfig,
    /// The paper's section 4: a second correction in free flight.
    pub second_correction: SecondCorrection,
    /// Thresholds of the calibration's checks.
    pub quality: QualityConfig,
    /// The effects by formula that the model defines, whether or not it accounts for them.
    pub definitions: Definitions,
    /// The effects, in file order.
    pub effects: Vec<Effect>,
    /// The model's history, in file order.
    pub revisions: Vec<Revision>,
}

/// The filter sizes that a model needs: the const parameters of `kf_core`'s `Mission`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Head states: see `kf_core::ud`.
    pub head: usize,
    /// Tail states.
    pub tail: usize,
    /// Effects whose coefficients are states.
    pub effects: usize,
}

impl Model {
    /// The effects whose coefficients are states, in file order.
    pub fn estimated_effects(&self) -> impl Iterator<Item = &Effect> {
        self.effects.iter().filter(|effect| effect.estimate)
    }

    /// The effects whose coefficients are constants, in file order.
    pub fn constant_effects(&self) -> impl Iterator<Item = &Effect> {
        self.effects.iter().filter(|effect| !effect.estimate)
    }

    /// The effects by formula that the model defines, in file order, whether or not it accounts for them.
    #[must_use]
    pub fn definitions(&self) -> &[EffectId] {
        &self.definitions.effects
    }

    /// The columns of a flight that its formulas read and the estimator does not know, by their numbers in
    /// [`kf_core::input::Columns`].
    #[must_use]
    pub const fn columns(&self) -> &formula::Columns {
        &self.definitions.columns
    }

    /// Every effect available to this model: the catalogue's, then its own.
    pub fn catalogue(&self) -> impl Iterator<Item = EffectId> {
        EffectId::ALL.into_iter().chain(self.definitions.effects.iter().copied())
    }

    /// The effect with this id, from the catalogue or the model's own.
    #[must_use]
    pub fn effect_named(&self, name: &str) -> Option<EffectId> {
        self.catalogue().find(|effect| effect.name() == name)
    }

    /// The ids of [`Self::catalogue`] nearest to a name, best first, for a message.
    #[must_use]
    pub fn nearest_effects(&self, name: &str) -> String {
        file::nearest(name, &self.catalogue().map(EffectId::name).collect::<Vec<_>>())
    }

    /// Warnings about unlikely values, one line each: coefficients that do not occur in nature.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let unlikely = self.effects.iter().filter_map(|effect| {
            let (id, coefficient) = (effect.term.id(), effect.term.coefficient);
            let [least, most] = id.plausible();
            let unit = if id.unit() == "1" { String::new() } else { format!(" {}", id.unit()) };
            (!(least..=most).contains(&coefficient)).then(|| {
                format!(
                    "coefficient of effect {} is {coefficient}{unit}, outside of its physical range {least} to \
                     {most}{unit}: check its sign and unit",
                    id.name()
                )
            })
        });
        unlikely.collect()
    }

    /// The filter sizes that this model needs.
    ///
    /// Without climb-rate propagation the biases are head states and the rest is the tail (3 and 1 + E:
    /// the paper's problem); the process noise of propagation leaves no head (0 and 4 + E).
    #[must_use]
    pub fn shape(&self) -> Shape {
        let effects = self.estimated_effects().count();
        if self.reference.climb_rate.is_some() {
            Shape { head: 0, tail: 1 + SENSORS + effects, effects }
        } else {
            Shape { head: SENSORS, tail: 1 + effects, effects }
        }
    }

    /// The configuration of a mission with `E` estimated effects.
    ///
    /// # Errors
    /// [`ModelError::Effects`] if the model has another number of estimated effects, and the first error of
    /// [`Model::validate`].
    pub fn mission_config<const E: usize>(&self) -> Result<MissionConfig<E>, ModelError> {
        self.validate()?;
        let estimated: Vec<EffectTerm> = self.estimated_effects().map(|effect| effect.term).collect();
        Ok(MissionConfig {
            settling_s: self.settling_s,
            reference: self.reference,
            latitude_deg: self.latitude_deg,
            sensors: self.sensors,
            monitor: self.monitor,
            second_correction: self.second_correction,
            quality: self.quality,
            estimated_effects: estimated
                .try_into()
                .map_err(|terms: Vec<_>| ModelError::Effects { wanted: E, found: terms.len() })?,
            constant_effects: self.constant_effects().map(|effect| effect.term).collect(),
        })
    }
}
