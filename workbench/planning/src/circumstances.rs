//! Where and how the flights were flown: a plan's starting point and its sensors' sample rates.

use flight_data::{Channel, Flight};

/// Slower than this is not flight, m/s.
const FLYING_MPS: f64 = 5.0;
/// The simulated airframe's own trim, m/s: used for planning if no flight records a speed.
const OWN_SPEED_MPS: f64 = 28.0;
/// Throttle of the simulated airframe in level flight at its trim (`simulate::scenario::Airframe`: a drag of 13
/// of 60 N). Its vibration is proportional to the throttle.
const LEVEL_THROTTLE: f64 = 0.22;
/// Rows a second of a scenario: no sensor is faster.
pub const ROWS_HZ: f64 = 200.0;

/// The flights' usual speed, altitude and rates.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances {
    /// Median true airspeed in flight, m/s, or the speed over ground if no airspeed is recorded.
    pub speed_mps: f64,
    /// Median altitude in flight, m above mean sea level.
    pub altitude_m: f64,
    /// Fixes a second.
    pub gps_hz: f64,
    /// The barometer's readings a second.
    pub baro_hz: f64,
    /// The inertial altitude's readings a second.
    pub imu_hz: f64,
    /// Whether the speed was recorded in a flight.
    pub is_speed_known: bool,
    /// Vibration of each body axis at full throttle (1 sigma), m/s^2, with which the simulated aircraft
    /// vibrates in level flight as these flights did; zero without an accelerometer.
    pub vibration_mps2: f64,
}

impl Circumstances {
    /// The circumstances of these flights.
    pub fn of(flights: &[&Flight]) -> Self {
        let speeds = flights.iter().flat_map(|flight| speeds(flight)).filter(|speed| *speed > FLYING_MPS);
        let speed_mps = median(speeds.collect());
        let altitudes = flights.iter().flat_map(|flight| altitudes(flight));
        let rate = |channels: &[Channel], otherwise: f64| {
            let rates = flights
                .iter()
                .filter_map(|flight| channels.iter().find_map(|channel| rate(flight, *channel)));
            median(rates.collect()).unwrap_or(otherwise).min(ROWS_HZ)
        };
        Self {
            speed_mps: speed_mps.unwrap_or(OWN_SPEED_MPS).round(),
            altitude_m: median(altitudes.collect()).unwrap_or(0.0).max(0.0).round(),
            gps_hz: rate(&[Channel::GpsAltM], 5.0),
            baro_hz: rate(&[Channel::BaroPa, Channel::BaroAltM], 50.0),
            imu_hz: rate(&[Channel::ImuSlaveAltM], 50.0),
            is_speed_known: speed_mps.is_some(),
            vibration_mps2: vibration_mps2(flights).unwrap_or(0.0) / LEVEL_THROTTLE,
        }
    }

    /// Remarks for the user about a plan.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = vec![
            "Flown by a simulated fixed-wing aircraft that trims at this speed, in calm air. Terrain, airspace and the limits of your \
             own aircraft are not considered."
                .to_owned(),
        ];
        if !self.is_speed_known {
            remarks.push(format!("No flight records a speed: {OWN_SPEED_MPS} m/s is assumed."));
        }
        remarks
    }
}

/// True airspeeds, or else speeds over ground.
fn speeds(flight: &Flight) -> Vec<f64> {
    if let Some(airspeed) = flight.channel(Channel::TasMps) {
        return airspeed.samples_f64().map(|(_, speed)| speed).filter(|speed| speed.is_finite()).collect();
    }
    let (Some(north), Some(east)) = (flight.channel(Channel::GpsVnMps), flight.channel(Channel::GpsVeMps))
    else {
        return Vec::new();
    };
    let speed = |(row, north): (usize, f64)| east.get_f64(row).map(|east| libm::hypot(north, east));
    north.samples_f64().filter_map(speed).filter(|speed| speed.is_finite()).collect()
}

/// Standard deviation of an axis' vibration in flight, m/s^2: half the mean square of the difference from one
/// sample to the next, as in the regressor of `imu.vibration`.
fn vibration_mps2(flights: &[&Flight]) -> Option<f64> {
    let axes = [Channel::AccelXMps2, Channel::AccelYMps2, Channel::AccelZMps2];
    let (mut sum, mut count) = (0.0, 0_u32);
    for flight in flights {
        let launch = flight.channel(Channel::Launch);
        let is_free = |row: usize| launch.is_none_or(|launch| launch.get(row) == Some(1.0));
        for column in axes.iter().filter_map(|axis| flight.channel(*axis)) {
            let samples = || column.samples_f64().filter(|(row, value)| is_free(*row) && value.is_finite());
            for ((_, one), (_, next)) in samples().zip(samples().skip(1)) {
                sum += 0.5 * (next - one) * (next - one);
                count += 1;
            }
        }
    }
    (count > 0).then(|| libm::sqrt(sum / f64::from(count)))
}

fn altitudes(flight: &Flight) -> Vec<f64> {
    let altitude = flight.channel(Channel::GpsAltM);
    altitude
        .into_iter()
        .flat_map(|column| column.samples_f64())
        .map(|(_, metres)| metres)
        .filter(|metres| metres.is_finite())
        .collect()
}

/// Sample rate, samples a second.
fn rate(flight: &Flight, channel: Channel) -> Option<f64> {
    let column = flight.channel(channel)?;
    let (first, _) = column.samples().next()?;
    let (count, last) = column.samples().fold((0_u32, first), |(count, _), (row, _)| (count + 1, row));
    let seconds = flight.time_s.get(last)? - flight.time_s.get(first)?;
    (seconds > 0.0).then(|| f64::from(count - 1) / seconds)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use flight_data::Column;

    use super::*;

    /// A vibration that alternates by two either way has differences of four: a variance of eight. Before the
    /// launch it does not count, and a steady force is none.
    #[test]
    fn the_vibration_is_that_of_the_flight() {
        let mut flight = Flight::default();
        let (mut launch, mut shaken, mut steady) = (Column::default(), Column::default(), Column::default());
        for row in 0..400_u16 {
            let is_free = row >= 200;
            let side = if row % 2 == 0 { 2.0 } else { -2.0 };
            flight.time_s.push(f64::from(row) * 0.01);
            launch.push(Some(f32::from(u8::from(is_free))));
            shaken.push(Some(if is_free { side - 9.81 } else { 30.0 * side }));
            steady.push(Some(3.0));
        }
        flight.set_channel(Channel::Launch, launch);
        flight.set_channel(Channel::AccelZMps2, shaken);
        assert!((vibration_mps2(&[&flight]).unwrap() - 8.0_f64.sqrt()).abs() < 1e-6);
        flight.set_channel(Channel::AccelXMps2, steady);
        assert!((vibration_mps2(&[&flight]).unwrap() - 2.0).abs() < 1e-6, "the mean of both axes' variances");
        assert_eq!(vibration_mps2(&[&Flight::default()]), None);
    }
}
