//! The Kalman filter of a path, its likelihood, and the smoother that runs backwards over it.
//!
//! The smoother needs no inverse (Durbin and Koopman, "Time Series Analysis by State Space Methods", 2nd
//! edition, sections 4.4 and 6.4, with the measurements of an instant processed one after the other):
//! `r' = Z e / S + (I - k Z)^T r` back over each measurement, `r' = F^T r` back over each interval, and the
//! state is `x + P r` with the state and covariance predicted for the instant.

use super::path_model::{PathModel, STATES, State, Transition};

/// Two altitudes at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Time since the last one, seconds.
    pub elapsed_s: f64,
    /// The receiver's altitude, metres.
    pub reference_m: f64,
    /// The sensor's altitude, metres, if it has any there.
    pub sensor_m: Option<f64>,
}

/// The states whose sum is an altitude.
const RECEIVER: [usize; 2] = [0, 3];
const SENSOR: [usize; 2] = [0, 4];

/// One measurement as the filter processed it.
#[derive(Clone, Copy)]
struct Taken {
    at: [usize; 2],
    gain: State,
    innovation: f64,
    variance: f64,
}

/// A path at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Altitude above the receiver's datum, metres.
    pub altitude_m: f64,
    /// Climb rate, m/s.
    pub climb_mps: f64,
}

/// What the backward pass needs of an instant.
struct Step {
    predicted: PathPoint,
    /// The rows of the predicted covariance for the altitude and the climb rate.
    covariance: [State; 2],
    taken: [Option<Taken>; 2],
    transition: Transition,
}

struct Filter<'a> {
    model: &'a PathModel,
    state: State,
    covariance: [State; STATES],
    transition: Transition,
}

impl<'a> Filter<'a> {
    fn new(model: &'a PathModel, first: &Sighting) -> Self {
        let (state, covariance) = model.first(first.reference_m, first.sensor_m);
        Self { model, state, covariance, transition: model.over(0.0) }
    }

    fn pass(&mut self, elapsed_s: f64) {
        if self.transition.elapsed_s != elapsed_s {
            self.transition = self.model.over(elapsed_s);
        }
        let Transition { matrix, noise, .. } = &self.transition;
        let carried = |column: &State| -> State {
            std::array::from_fn(|r| matrix[r].iter().zip(column).map(|(left, right)| left * right).sum())
        };
        self.state = carried(&self.state);
        // F P by columns, which are rows of the symmetric P, and then its rows multiplied by F again.
        let half: [State; STATES] = std::array::from_fn(|c| carried(&self.covariance[c]));
        let turned: [State; STATES] = std::array::from_fn(|r| std::array::from_fn(|c| half[c][r]));
        self.covariance = std::array::from_fn(|r| {
            let row = carried(&turned[r]);
            std::array::from_fn(|c| row[c] + noise[r][c])
        });
    }

    fn take(&mut self, at: [usize; 2], measured_m: f64, sigma_m: f64) -> Taken {
        let covariance = &self.covariance;
        let shared: State = std::array::from_fn(|k| covariance[k][at[0]] + covariance[k][at[1]]);
        let variance = shared[at[0]] + shared[at[1]] + sigma_m * sigma_m;
        let innovation = measured_m - self.state[at[0]] - self.state[at[1]];
        let gain = shared.map(|shared| shared / variance);
        for (state, gain) in self.state.iter_mut().zip(gain) {
            *state += gain * innovation;
        }
        for (row, gain) in self.covariance.iter_mut().zip(gain) {
            for (entry, shared) in row.iter_mut().zip(shared) {
                *entry -= gain * shared;
            }
        }
        Taken { at, gain, innovation, variance }
    }

    /// Advances to a sighting; `sink` receives every measurement.
    fn advance(&mut self, sighting: &Sighting, sink: &mut dyn FnMut(Taken)) -> Step {
        self.pass(sighting.elapsed_s);
        let predicted = PathPoint { altitude_m: self.state[0], climb_mps: self.state[1] };
        let covariance = [self.covariance[0], self.covariance[1]];
        let reference = self.take(RECEIVER, sighting.reference_m, self.model.reference_m);
        sink(reference);
        let sensor = sighting.sensor_m.map(|sensor_m| self.take(SENSOR, sensor_m, self.model.sensor_m));
        sensor.into_iter().for_each(sink);
        Step { predicted, covariance, taken: [Some(reference), sensor], transition: self.transition }
    }
}

/// Twice the log likelihood of a stretch of sightings, up to a constant.
#[must_use]
pub fn twice_log_likelihood(sightings: &[Sighting], model: &PathModel) -> f64 {
    let Some(first) = sightings.first() else { return 0.0 };
    let mut filter = Filter::new(model, first);
    let mut sum = 0.0;
    for (k, sighting) in sightings.iter().enumerate() {
        // A stretch begins with its first sighting, whatever lies before it.
        let sighting = Sighting { elapsed_s: if k == 0 { 0.0 } else { sighting.elapsed_s }, ..*sighting };
        filter.advance(&sighting, &mut |taken| {
            sum -= taken.innovation * taken.innovation / taken.variance + libm::log(taken.variance);
        });
    }
    sum
}

/// The path at every sighting, given all of them.
#[must_use]
pub fn smoothed(sightings: &[Sighting], model: &PathModel) -> Vec<PathPoint> {
    let Some(first) = sightings.first() else { return Vec::new() };
    let mut filter = Filter::new(model, first);
    let steps: Vec<Step> = sightings.iter().map(|sighting| filter.advance(sighting, &mut |_| {})).collect();
    let mut behind: State = [0.0; STATES];
    let mut points: Vec<PathPoint> = steps.iter().rev().map(|step| step.back(&mut behind)).collect();
    points.reverse();
    points
}

impl Step {
    /// Steps back over the instant: returns the path there, and puts into `behind` what the earlier instant
    /// needs.
    fn back(&self, behind: &mut State) -> PathPoint {
        for taken in self.taken.iter().rev().flatten() {
            let of_gain: f64 = taken.gain.iter().zip(behind.iter()).map(|(gain, behind)| gain * behind).sum();
            for at in taken.at {
                behind[at] += taken.innovation / taken.variance - of_gain;
            }
        }
        let [moved_m, faster_mps] =
            self.covariance.map(|row| row.iter().zip(behind.iter()).map(|(p, r)| p * r).sum::<f64>());
        let matrix = &self.transition.matrix;
        *behind = std::array::from_fn(|c| (0..STATES).map(|r| matrix[r][c] * behind[r]).sum());
        PathPoint {
            altitude_m: self.predicted.altitude_m + moved_m,
            climb_mps: self.predicted.climb_mps + faster_mps,
        }
    }
}
