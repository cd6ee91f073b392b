//! The candidates: every effect of the catalogue, with a grid of time constants where these are unknown.

use kf_core::effect::{Clock, EffectId, EffectSubject, Regressor};
use kf_core::sensor::Sensor;
use model::{Effect, Model};

use super::delay::{DelayShape, SHAPES};
use super::low_pass::{LowPassDelay, is_same_effect};
use super::signal_errors::{SignalError, errors, receiver_delays_s};
use super::wanted_effect::Tried;

/// Time constants that are tried, seconds: a factor of three apart. Between two of them a fitted exponential
/// differs from the true one by some per cent of its size.
const TIME_CONSTANTS_S: [f32; 6] = [3.0, 10.0, 30.0, 90.0, 270.0, 800.0];

/// One column: an effect, with a time constant if it has one, or with a shape of its lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The effect and the constants of its regressor.
    pub regressor: Regressor,
    /// Shape of a delay.
    pub delay: DelayShape,
    /// Assumed error of its signal.
    pub signal: SignalError,
}

impl Candidate {
    /// A candidate in the catalogue's own shape.
    #[must_use]
    pub fn of(regressor: Regressor) -> Self {
        Self { regressor, delay: DelayShape::Slope, signal: SignalError::default() }
    }

    /// Whether its regressor is the catalogue's own, which is the one that is flown.
    #[must_use]
    pub fn is_catalogues(&self) -> bool {
        *self == Self::of(self.regressor)
    }

    /// Whether its signal errs by nothing that lasts from flight to flight.
    #[must_use]
    pub fn is_read_as_flown(&self) -> bool {
        let SignalError { is_by_velocity, .. } = self.signal;
        self.signal == SignalError { is_by_velocity, ..SignalError::default() }
    }

    /// The effect.
    #[must_use]
    pub const fn effect(&self) -> EffectId {
        self.regressor.id
    }

    /// The coefficients that agree with its own shape: a delay's shape states how large the delay is.
    #[must_use]
    pub fn consistent(&self) -> [f64; 2] {
        match self.effect() {
            EffectId::BaroLag => self.delay.delays_s(),
            EffectId::GpsLatency if self.signal.late_s != 0.0 => receiver_delays_s(self.signal.late_s),
            EffectId::GpsLatency => self.delay.delays_s(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The sensor on which it acts; `None` for the reference, and so for all.
    #[must_use]
    pub const fn sensor(&self) -> Option<Sensor> {
        match self.regressor.id.subject() {
            EffectSubject::Gps => None,
            EffectSubject::Sensor(sensor) => Some(sensor),
        }
    }
}

/// Every candidate of the catalogue, and of the model's own effects.
///
/// If the climb rate is not measured, it is the slope of the reference's own altitude, and its noise is the
/// residual's. For a pure delay this does not matter: a slope is odd in time, so what it shares with the
/// noise before an instant cancels with what it shares after it, whatever the noise's spectrum. A low pass
/// also has an even part, which fits noise: two of them, large and opposite, make a false lag and a false
/// latency. Delays are then tried only as in the catalogue.
#[must_use]
pub fn catalogue(model: &Model, has_climb_rate: bool) -> Vec<Candidate> {
    let shapes = if has_climb_rate { SHAPES.as_slice() } else { &SHAPES[..1] };
    let mut candidates = Vec::new();
    // A delay defined as a low pass is the catalogue's own, whose shapes are all tried.
    let is_tried = |id: &EffectId| LowPassDelay::of(*id).is_none_or(|delay| delay.catalogues == *id);
    for id in model.catalogue().filter(is_tried) {
        let mut add = |time_constant_s, since, delay| {
            let regressor = Regressor { id, time_constant_s, since };
            candidates.push(Candidate { delay, ..Candidate::of(regressor) });
        };
        if id.has_time_constant() {
            // A formula defines itself when its time begins.
            let clocks =
                if id.formula().is_some() { &[Clock::Launch][..] } else { &[Clock::Launch, Clock::Start] };
            for since in clocks.iter().copied() {
                for time_constant_s in TIME_CONSTANTS_S {
                    add(time_constant_s, since, DelayShape::Slope);
                }
            }
        } else if matches!(id, EffectId::BaroLag | EffectId::GpsLatency) {
            for shape in shapes {
                add(0.0, Clock::Launch, *shape);
            }
        } else {
            add(0.0, Clock::Launch, DelayShape::Slope);
        }
        if has_climb_rate {
            let own = Candidate::of(Regressor { id, time_constant_s: 0.0, since: Clock::Launch });
            candidates.extend(errors(id).into_iter().skip(1).map(|signal| Candidate { signal, ..own }));
        }
    }
    candidates
}

/// What a diagnosis or a study tries: the whole catalogue, or the requested part of it, without the model's
/// effects; and those effects of the model whose coefficients are uncertain.
pub(super) fn candidates(
    model: &Model,
    has_climb_rate: bool,
    tried: Option<Tried<'_>>,
) -> (Vec<Candidate>, Vec<Candidate>) {
    let mut candidates = catalogue(model, has_climb_rate);
    if let Some(tried) = tried {
        let wanted = tried.wanted.effect;
        if LowPassDelay::of(wanted).is_some_and(|delay| delay.catalogues != wanted) {
            candidates.push(Candidate::of(Regressor::new(wanted)));
        }
        tried.narrow(&mut candidates);
    }
    let has =
        |effect: EffectId| model.effects.iter().any(|known| is_same_effect(known.term.regressor.id, effect));
    candidates.retain(|candidate| !has(candidate.effect()));
    let known = unsure(model).map(|effect| Candidate::of(effect.term.regressor));
    (candidates, known.collect())
}

/// The effects of a model whose coefficients may be wrong.
pub(super) fn unsure(model: &Model) -> impl Iterator<Item = &Effect> {
    model.effects.iter().filter(|effect| effect.term.sigma > 0.0)
}
