//! What one effect's coefficient is learned from: the flights' block means, their noise, and the terms that
//! must be estimated together with it.

use kf_core::effect::Regressor;

use super::diagnosis::CandidateFacts;
use super::evidence::{Evidence, Folds};
use super::noise::Noise;
use super::series::Series;

/// A term of the residual: an effect with its column in every [`Series`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The effect and the constants of its regressor.
    pub regressor: Regressor,
    /// Its column.
    pub column: usize,
    /// The model's uncertainty of its coefficient, as a sigma about the value already subtracted; `None`:
    /// unknown.
    pub known_sigma: Option<f64>,
}

/// A column that is not an effect, with a separate coefficient for each flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nuisance {
    /// Its column.
    pub column: usize,
    /// Prior of its coefficient, as a sigma about zero.
    pub sigma: f64,
}

/// What an effect's coefficient is learned from.
#[derive(Clone, Debug)]
pub struct LearningProblem {
    /// The flights' block means.
    pub flights: Vec<Series>,
    /// The noise fitted together with the terms.
    pub noise: Noise,
    /// The effect first, then the other effects that act and those that the model already has.
    pub terms: Vec<Term>,
    /// The wind's share of the airspeed, north and east, where a flight has only the speed over ground.
    pub wind: Option<[Nuisance; 2]>,
    /// Factor by which the coefficient's variance exceeds that of a fit with this noise: from the spread over
    /// the parts of the flights, and the remaining autocorrelation.
    pub inflation: f64,
    /// Variance of the coefficient beyond that of the noise, in its unit squared: errors of signals and
    /// shapes, time constants that fit as well, effects that may act too.
    pub beyond_noise: f64,
    /// The part of it that is a share of the coefficient itself, and vanishes where the effect does not act.
    pub relative: f64,
    /// Time constant, seconds, with which the effect, a delay, is a low pass; `None` where it acts as in the
    /// catalogue, or its regressor is a low pass already.
    pub low_pass_s: Option<f64>,
    /// The diagnosis' own estimate of the coefficient, in f64, and the held-out errors.
    pub facts: CandidateFacts,
    /// The evidence of the flights' own stretches about the coefficient.
    pub folds: Folds,
    /// The evidence of the held-out flights, if there are any.
    pub held_out: Option<Evidence>,
}
