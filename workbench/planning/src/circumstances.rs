//! Where and how the flights were flown: a plan's starting point and its sensors' sample rates.

use flight_data::{Channel, Flight};

/// Slower than this is not flight, m/s.
const FLYING_MPS: f64 = 5.0;
/// The simulated airframe's own trim, m/s: used for planning if no flight records a speed.
const OWN_SPEED_MPS: f64 = 28.0;
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
