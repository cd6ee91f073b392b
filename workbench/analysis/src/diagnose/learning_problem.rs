//! What one effect's coefficient is learned from: the flights' block means, the noise that goes with
//! them, and the terms that must be estimated beside it.

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
    /// What the model knows of its coefficient, as a sigma about what was taken off already; `None`: nothing.
    pub known_sigma: Option<f64>,
}

/// A column that is no effect, with a coefficient of each flight's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nuisance {
    /// Its column.
    pub column: usize,
    /// What is believed of its coefficient, as a sigma about zero.
    pub sigma: f64,
}

/// What an effect's coefficient is learned from.
#[derive(Clone, Debug)]
pub struct LearningProblem {
    /// The flights' block means.
    pub flights: Vec<Series>,
    /// The noise fitted beside the terms.
    pub noise: Noise,
    /// The effect first; then what else acts, and what the model has already.
    pub terms: Vec<Term>,
    /// The wind's share of the airspeed, north and east, where a flight has the speed over ground only.
    pub wind: Option<[Nuisance; 2]>,
    /// By how much the coefficient's variance is larger than a fit with this noise says: the spread over
    /// the parts of the flights, and the autocorrelation that is left.
    pub inflation: f64,
    /// The share of the coefficient that is unsure beside its noise: signals have scale errors of their own.
    pub scale: f64,
    /// What it is unsure by besides, in its unit: it is no constant.
    pub unsteadiness: f64,
    /// What the diagnosis itself makes of the coefficient, in f64, and the held-out errors.
    pub facts: CandidateFacts,
    /// What the flights' own stretches say of the coefficient.
    pub folds: Folds,
    /// What the held-out flights say of it, if there are any.
    pub held_out: Option<Evidence>,
}
