//! A constant error of the forward acceleration, of which inertial regressors are integrated.
//!
//! A tilt's regressor is the forward acceleration integrated twice, which is measured with an error that the
//! attitude and the accelerometers hardly change within a flight. Integrated twice, a constant is a parabola
//! that after some minutes is as large as the aircraft's own motion. The coefficient that fits the wrong
//! regressor differs from the true one by what the fit makes of that parabola. A gyro's bias multiplies the
//! same acceleration by the time: the error is a cubic. How large the error still is after captive flight
//! ([`SignalTracker::forward_sigma_mps2`](kf_core::effect::SignalTracker::forward_sigma_mps2)) differs from
//! flight to flight.

use kf_core::effect::EffectId;
use kf_core::sensor::{SENSORS, Sensor};

use super::candidates::Candidate;
use super::information::Information;
use super::noise::Noise;
use super::problem::Problem;
use super::series::{BySensor, Series};
use super::shape_error::ByOrigin;

/// How the error of an effect's acceleration grows.
#[derive(Clone, Copy)]
enum Growth {
    /// Constant: a parabola after two integrations.
    Parabola,
    /// In proportion to the time since launch: a cubic.
    Cubic,
}

/// How the error of a regressor's acceleration grows; `None` where it uses no forward acceleration of the
/// accelerometers.
fn growth(candidate: &Candidate) -> Option<Growth> {
    match candidate.effect() {
        _ if candidate.signal.is_by_velocity => None,
        EffectId::ImuTilt => Some(Growth::Parabola),
        EffectId::ImuGyroBias => Some(Growth::Cubic),
        _ => None,
    }
}

/// The variance that this error gives the last pick's coefficient. `chosen` are the picks with their
/// coefficients. `None` where the picks cannot be told apart.
#[must_use]
pub fn variance(
    problem: &Problem<'_>,
    noise: &Noise,
    picks: &[usize],
    chosen: &[(&Candidate, f64)],
) -> Option<ByOrigin> {
    let mut variance = ByOrigin::default();
    for (at, (candidate, coefficient)) in chosen.iter().enumerate() {
        if let Some(growth) = growth(candidate) {
            let moved = coefficient * response(problem, noise, picks, growth)?;
            let origin = if at + 1 == chosen.len() { &mut variance.own } else { &mut variance.others };
            *origin += moved * moved;
        }
    }
    Some(variance)
}

/// How much the last pick's coefficient changes with one sigma of the error in every flight.
fn response(problem: &Problem<'_>, noise: &Noise, picks: &[usize], growth: Growth) -> Option<f64> {
    let mut information = Information::new(1 + picks.len() + 1);
    for flight in problem.flights {
        let error_m = grown(flight, growth);
        let mut columns = problem.columns(flight, picks);
        columns.push(&error_m);
        let one = problem.products(flight, noise, &columns, &|_| true);
        information.add_flight(&one.products, problem.own(), one.rows, 0.0);
    }
    let kept: Vec<usize> = (0..picks.len()).collect();
    let mut error = vec![0.0; picks.len()];
    error.push(1.0);
    information.regression(&error, &kept)?.last().copied()
}

/// One sigma of the error of the forward acceleration, integrated twice, metres.
fn grown(flight: &Series, growth: Growth) -> Vec<BySensor> {
    let launch = flight.free.iter().position(|free| *free);
    let launch_s = launch.map_or(f64::INFINITY, |block| flight.time_s[block] - 0.5 * flight.block_s);
    let of = |time_s: &f64| {
        let since_s = (time_s - launch_s).max(0.0);
        let mut by_sensor = [0.0; SENSORS];
        let grown = match growth {
            Growth::Parabola => since_s * since_s / 2.0,
            Growth::Cubic => since_s * since_s * since_s / 6.0,
        };
        by_sensor[Sensor::ImuSlave.index()] = flight.forward_sigma_mps2 * grown;
        by_sensor
    };
    flight.time_s.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use kf_core::effect::Regressor;
    use model::Model;

    use super::super::noise::{GaussMarkov, NoisePrior, SensorNoise};
    use super::*;

    const BLOCKS: u16 = 200;
    const WHITE_M: f64 = 0.5;
    const SIGMA_MPS2: f64 = 0.043;
    const INERTIAL: usize = Sensor::ImuSlave.index();

    /// An aircraft whose forward acceleration is a sine of this many m/s^2 and 100 s, from launch at 50 s on;
    /// the column is its double integral.
    fn flight(acceleration_mps2: f64) -> Series {
        let rate = std::f64::consts::TAU / 100.0;
        let column = (0..BLOCKS).map(|block| {
            let since_s = (f64::from(block) + 0.5 - 50.0).max(0.0);
            let mut by_sensor = [0.0; SENSORS];
            by_sensor[INERTIAL] =
                acceleration_mps2 * (since_s / rate - (rate * since_s).sin() / (rate * rate));
            by_sensor
        });
        let column: Vec<BySensor> = column.collect();
        let mut on_it = [f64::NAN; SENSORS];
        on_it[INERTIAL] = 0.0;
        let mut readings = [0; SENSORS];
        readings[INERTIAL] = 10;
        Series {
            time_s: (0..BLOCKS).map(|block| f64::from(block) + 0.5).collect(),
            fixes: vec![1.0; usize::from(BLOCKS)],
            free: (0..BLOCKS).map(|block| block >= 50).collect(),
            residual_m: vec![on_it; usize::from(BLOCKS)],
            readings: vec![readings; usize::from(BLOCKS)],
            columns: vec![Arc::new(column)],
            block_s: 1.0,
            full_block: [10.0; SENSORS],
            forward_sigma_mps2: SIGMA_MPS2,
        }
    }

    /// The sigma of a coefficient of 0.02 rad (or rad/s), under white noise.
    fn sigma(effect: EffectId, acceleration_mps2: f64) -> f64 {
        let none = GaussMarkov { sigma_m: 1e-6, time_s: 30.0 };
        let sensor = SensorNoise {
            wander: none,
            captive_white_m: WHITE_M,
            free_white_m: WHITE_M,
            free_flight_factor: 1.0,
        };
        let noise = Noise { reference: none, slow: none, fix_sigma_m: 1e-6, sensors: [sensor; SENSORS] };
        let flights = [flight(acceleration_mps2)];
        let model = Model::default();
        let prior = NoisePrior::new(&flights, &model.reference, &model.sensors);
        let problem = Problem::new(&flights, prior, Vec::new(), &executor::Inline);
        let variance =
            variance(&problem, &noise, &[0], &[(&Candidate::of(Regressor::new(effect)), 0.02)]).unwrap();
        assert_eq!(variance.others, 0.0);
        variance.own.sqrt()
    }

    /// By least squares beside a bias, written down: the coefficient moves by the offset times the coefficient
    /// times the parabola's regression on the column.
    #[test]
    fn a_tilts_coefficient_moves_with_the_parabola_of_its_offset() {
        let series = flight(2.0);
        let column: Vec<f64> = series.columns[0].iter().map(|by_sensor| by_sensor[INERTIAL]).collect();
        let parabola: Vec<f64> =
            series.time_s.iter().map(|time_s| 0.5 * (time_s - 50.0).max(0.0).powi(2)).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (column_mean, parabola_mean) = (mean(&column), mean(&parabola));
        let along = |values: &[f64], about: f64| {
            values.iter().zip(&column).map(|(a, b)| (a - about) * (b - column_mean)).sum::<f64>()
        };
        let regression = along(&parabola, parabola_mean) / along(&column, column_mean);
        let expected = SIGMA_MPS2 * 0.02 * regression;
        let found = sigma(EffectId::ImuTilt, 2.0);
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }

    /// Twice the acceleration shows a tilt twice as well. A gyro's bias has the time as a factor, so its error
    /// is another one; other effects use no forward acceleration.
    #[test]
    fn more_acceleration_leaves_less_uncertainty() {
        let (once, twice) = (sigma(EffectId::ImuTilt, 1.0), sigma(EffectId::ImuTilt, 2.0));
        assert!((once / twice - 2.0).abs() < 1e-3, "{once} {twice}");
        assert!(sigma(EffectId::ImuGyroBias, 2.0) > 10.0 * twice);
        assert_eq!(sigma(EffectId::ImuAccelBias, 2.0), 0.0);
    }
}
