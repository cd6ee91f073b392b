//! How much the fixes, and a sensor's readings beside them, scatter about their neighbours.
//!
//! The aircraft's motion is in both alike, so that the one that scatters more is the noisier. A slow error of
//! one of the two shows in neither.

use flight_data::{Channel, Flight};

use crate::pairs::{Pair, SENSORS, bend_m, pairs, spread};

/// Fewest fixes for a comparison: a robust standard deviation of forty is known to a fifth.
const LEAST_FIXES: usize = 40;

/// The scatter of the fixes and of one sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// The sensor's column.
    pub channel: Channel,
    /// Standard deviation of a fix about its neighbours, metres: noise and motion.
    pub receiver_m: f64,
    /// The same of the sensor's reading at the fix, metres.
    pub sensor_m: f64,
}

/// The scatter in a flight, by the barometer or else by the first inertial altitude. `None` where there are
/// too few fixes.
#[must_use]
pub fn find(flight: &Flight) -> Option<Scatter> {
    let mut paired = SENSORS.into_iter().map(|channel| (channel, pairs(flight, channel)));
    let (channel, pairs) = paired.find(|(_, pairs)| pairs.len() >= LEAST_FIXES)?;
    // A bend is a difference less half of its two neighbours. Of values with equal variances it has five of
    // these: the weights are 1/2, -3/2, 3/2 and -1/2.
    let of = |altitude_m: fn(&Pair) -> f64| {
        spread(pairs.windows(4).map(|around| bend_m(around, altitude_m))) / 5.0_f64.sqrt()
    };
    Some(Scatter { channel, receiver_m: of(|pair| pair.receiver_m), sensor_m: of(|pair| pair.sensor_m) })
}

#[cfg(test)]
mod tests {
    use flight_data::Column;

    use super::*;

    /// Of white noise it is the standard deviation, whatever the climb.
    #[test]
    fn the_noise_of_both_altitudes_is_found() {
        let mut seed = 1_u32;
        let mut normal = || {
            (0..12).fold(-6.0_f32, |sum, _| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum + (seed >> 8) as f32 / (1 << 24) as f32
            })
        };
        let mut flight = Flight { time_s: (0..2000).map(f64::from).collect(), ..Flight::default() };
        let (mut receiver, mut baro) = (Column::default(), Column::default());
        for row in 0..2000 {
            let altitude_m = 500.0 + 2.0 * row as f32;
            receiver.push(Some(altitude_m + 15.0 * normal()));
            baro.push(Some(altitude_m + 0.5 * normal()));
        }
        flight.set_channel(Channel::GpsAltM, receiver);
        flight.set_channel(Channel::BaroAltM, baro);
        let found = find(&flight).unwrap();
        // 2,000 values, of which the median deviation is known to 2.6 % and neighbours share noise.
        assert!((found.receiver_m / 15.0 - 1.0).abs() < 0.15, "{found:?}");
        assert!((found.sensor_m / 0.5 - 1.0).abs() < 0.15, "{found:?}");
        assert_eq!(found.channel, Channel::BaroAltM);
        flight.time_s.truncate(39);
        assert_eq!(find(&flight), None);
    }
}
