//! Prepares flights for the search: candidates, block means, and the terms estimated with the effects.

use executor::Executor;
use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;
use model::Model;

use super::candidates::{Candidate, candidates, unsure};
use super::epochs::Epochs;
use super::named_replay::NamedReplay;
use super::physical_range::{Bounds, measures_climb_rate, range};
use super::problem::{Known, Problem};
use super::roughness::{scale, shape};
use super::series::Series;
use super::suspects::{Regressors, Suspects};
use super::wanted_effect::Tried;
use super::wind::wind;
use replay::barometer;

/// The input of a search.
pub(crate) struct Prepared {
    /// The candidates that are tried, followed by the effects that the model already has; the columns of
    /// every series are in this order.
    pub candidates: Vec<Candidate>,
    /// The flights.
    pub epochs: Vec<Epochs>,
    /// Block means of the flights.
    pub series: Vec<Series>,
    /// Block means of the flights held out.
    pub held: Vec<Series>,
    /// Means of the signals in each block of the flights held out, as in [`Epochs::signals`].
    pub held_signals: Vec<Vec<Vec<f64>>>,
    /// Columns of the effects that the model already has, and of the wind.
    pub known: Vec<Known>,
    /// Whether the climb rate is measured in all flights.
    pub has_climb_rate: bool,
    /// Columns that are tried: those whose signals all flights have.
    tried: Vec<usize>,
}

impl Prepared {
    /// `tried`: what a study tries; `None`: the whole catalogue.
    pub(super) fn new(
        flights: &[NamedReplay<'_>],
        hold_outs: &[NamedReplay<'_>],
        model: &Model,
        tried: Option<Tried<'_>>,
        executor: &dyn Executor,
    ) -> Self {
        let has_climb_rate = flights.iter().all(|named| measures_climb_rate(&named.replay));
        let (mut candidates, of_model) = candidates(model, has_climb_rate, tried);
        // Flights on which the whole catalogue is tried together are also diagnosed one by one.
        let is_kept = tried.is_none() && flights.len() > 1;
        let tried = candidates.len();
        candidates.extend(of_model);
        let mut known: Vec<Known> = unsure(model)
            .zip(tried..)
            .map(|(effect, column)| Known { column, sigma: f64::from(effect.term.sigma) })
            .collect();
        if is_kept {
            flights.iter().for_each(|named| named.keep_all(executor));
        }
        let prepare = |named: &NamedReplay<'_>| named.epochs(&candidates, executor);
        let mut epochs: Vec<Epochs> = flights.iter().map(prepare).collect();
        let mut held: Vec<Epochs> = hold_outs.iter().map(prepare).collect();
        let wind = wind(&mut epochs, &mut held);
        for (named, epochs) in flights.iter().chain(hold_outs).zip(epochs.iter_mut().chain(&mut held)) {
            if barometer::check(named.replay.flight()).is_some() {
                leave_out(&mut epochs.series, Sensor::Baro.index());
            }
            if barometer::check_inertial(named.replay.flight()).is_some() {
                leave_out(&mut epochs.series, Sensor::ImuSlave.index());
            }
        }
        let available = |column: usize| epochs.iter().all(|epochs| epochs.available[column]);
        known.retain(|known| available(known.column));
        known.extend(wind);
        Self {
            tried: (0..tried).filter(|column| available(*column)).collect(),
            held_signals: held.iter_mut().map(|epochs| std::mem::take(&mut epochs.signals)).collect(),
            held: held.into_iter().map(|epochs| epochs.series).collect(),
            series: epochs.iter().map(|epochs| epochs.series.clone()).collect(),
            candidates,
            epochs,
            known,
            has_climb_rate,
        }
    }

    /// Leaves out a sensor's readings, of the flights held out too.
    pub(super) fn leave_out(&mut self, sensor: Sensor) {
        let of_epochs = self.epochs.iter_mut().map(|epochs| &mut epochs.series);
        for series in of_epochs.chain(&mut self.series).chain(&mut self.held) {
            leave_out(series, sensor.index());
        }
    }

    /// Whether the wind has columns of its own, after the candidates'.
    pub(super) fn has_wind(&self) -> bool {
        self.series.iter().any(|series| series.columns.len() > self.candidates.len())
    }

    /// The candidates that a search tries: those whose regressor moves.
    pub(super) fn suspects(&self, problem: &Problem<'_>) -> Suspects<'_> {
        let first_look = problem.information(&problem.prior.noise(&problem.prior.means()), &self.tried);
        let usable = self.tried.iter().enumerate();
        let usable: Vec<usize> = usable
            .filter(|(position, _)| first_look.is_excited(*position))
            .map(|(_, column)| *column)
            .collect();
        let mut noise_m2 = vec![0.0_f64; self.candidates.len()];
        for epochs in &self.epochs {
            for (most, noise_m2) in noise_m2.iter_mut().zip(&epochs.column_noise_m2) {
                *most = most.max(*noise_m2);
            }
        }
        let effects = || self.candidates.iter().map(Candidate::effect);
        let climb_noise_m2 = self.epochs.iter().map(|epochs| epochs.climb_noise_m2).fold(0.0, f64::max);
        let block_s = self.series.iter().map(|series| series.block_s).fold(0.0, f64::max);
        let attenuating_m2 = self.candidates.iter().zip(&noise_m2).map(|(candidate, noise_m2)| {
            let is_delay = matches!(candidate.effect(), EffectId::BaroLag | EffectId::GpsLatency);
            if is_delay && self.has_climb_rate {
                noise_m2.max(climb_noise_m2 * candidate.delay.passes(block_s))
            } else {
                *noise_m2
            }
        });
        let regressors = Regressors {
            attenuating_m2: attenuating_m2.collect(),
            noise_m2,
            shape: effects().map(|effect| shape(&self.epochs, effect)).collect(),
            bounds: self
                .candidates
                .iter()
                .map(|candidate| Bounds {
                    range: range(candidate.effect(), self.has_climb_rate),
                    scale: scale(&self.epochs, candidate.effect()),
                    consistent: candidate.consistent(),
                })
                .collect(),
        };
        Suspects::new(&self.candidates, regressors, usable)
    }
}

/// Removes a sensor that did not measure from a flight.
fn leave_out(series: &mut Series, sensor: usize) {
    for (residuals, readings) in series.residual_m.iter_mut().zip(&mut series.readings) {
        residuals[sensor] = f64::NAN;
        readings[sensor] = 0;
    }
}
