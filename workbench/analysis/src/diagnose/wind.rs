//! Columns for the wind where the airspeed is not measured.

use std::sync::Arc;

use kf_core::sensor::Sensor;

use super::epochs::Epochs;
use super::problem::Known;
use super::signals;

/// Sigma of what the wind adds to the barometer per m/s over ground where the airspeed is not measured: a
/// port that picks up a third of the dynamic pressure, in 10 m/s of wind.
const WIND_M_PER_MPS: f64 = 0.3;

/// Where a flight has no airspeed, the two columns that its square lacks.
///
/// With the velocity v over ground and the wind w, the airspeed's square is `|v|^2 - 2 v.w + |w|^2`. To the
/// squared speed over ground, which replaces it, belong the two components of v, with separate coefficients
/// for each flight. Without them, load factor and angle of attack would represent them.
pub(super) fn wind(epochs: &mut [Epochs], held: &mut [Epochs]) -> Vec<Known> {
    if !epochs.iter().any(lacks_airspeed) {
        return Vec::new();
    }
    let first = epochs.first().map_or(0, |epochs| epochs.series.columns.len());
    epochs.iter_mut().chain(held).for_each(append);
    let columns = first..first + signals::GROUND_VELOCITY.len();
    columns.map(|column| Known { column, sigma: WIND_M_PER_MPS }).collect()
}

/// Appends both columns to a flight's; they are zero for a flight with an airspeed.
pub(super) fn append(epochs: &mut Epochs) {
    let is_needed = lacks_airspeed(epochs);
    for signal in signals::GROUND_VELOCITY {
        let component = epochs.signals.iter().map(|block| {
            let value = if is_needed && block[signal].is_finite() { block[signal] } else { 0.0 };
            std::array::from_fn(|i| if i == Sensor::Baro.index() { value } else { 0.0 })
        });
        let component = component.collect();
        epochs.series.columns.push(Arc::new(component));
    }
}

fn lacks_airspeed(epochs: &Epochs) -> bool {
    epochs.signals.iter().all(|block| !block[0].is_finite())
}
