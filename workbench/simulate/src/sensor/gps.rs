//! The receiver.

use super::super::motion::TruthSample;
use super::super::random::{Random, Stream};
use super::super::scenario::Gps;
use super::{NoiseSource, Readings, Series, between, quantise, schedule};
use flight_data::Channel;

/// Fewest satellites of a fix.
const FIX_SATELLITES: f64 = 4.0;

/// The channels of a fix, in the order of [`Fix`].
const CHANNELS: [Channel; 7] = [
    Channel::GpsAltM,
    Channel::GpsVnMps,
    Channel::GpsVeMps,
    Channel::GpsVdMps,
    Channel::GpsVaccM,
    Channel::GpsSats,
    Channel::GpsTimeS,
];

type Fix = [f64; 7];

/// The fixes. `effects_m` is the sum of the injected effects on the altitude, a value for each row.
pub(in super::super) fn gps(
    sensor: &Gps,
    flight: &[TruthSample],
    effects_m: &[f64],
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let mut random = Random::new(seed, Stream::Gps);
    let mut receiver = Receiver { sensor, noise: NoiseSource::new(sensor.noise), smoothed: None };
    let mut columns: [Series; 7] = Default::default();
    let mut last: Option<Fix> = None;
    let mut due =
        schedule(&sensor.sampling, flight, row_rate_hz, Random::new(seed, Stream::GpsLosses)).peekable();
    for row in 0..flight.len() {
        let mut sent = sensor.hold;
        if let Some(due) = due.next_if(|due| due.row == row) {
            let fix = receiver.fix(flight, effects_m, due, &mut random);
            if !due.lost {
                let frozen = sensor.freezes.iter().any(|freeze| freeze.contains(due.time_s));
                last = if frozen { last } else { fix };
                sent = true;
            }
        }
        if let Some(fix) = last.filter(|_| sent) {
            for (column, value) in columns.iter_mut().zip(fix) {
                column.push((row, value));
            }
        }
    }
    CHANNELS
        .into_iter()
        .zip(columns)
        .filter(|(channel, _)| sensor.fix_time || *channel != Channel::GpsTimeS)
        .collect()
}

struct Receiver<'a> {
    sensor: &'a Gps,
    noise: NoiseSource,
    /// Output of the receiver's filter, m, and its time, s.
    smoothed: Option<(f64, f64)>,
}

impl Receiver<'_> {
    fn fix(
        &mut self,
        flight: &[TruthSample],
        effects_m: &[f64],
        due: super::Due,
        random: &mut Random,
    ) -> Option<Fix> {
        let sensor = self.sensor;
        let noise = self.noise.next(random, due.time_s);
        let velocity_noise = [0; 3].map(|_| sensor.velocity_sigma_mps * random.normal());
        let clean = between(due.source, |row| {
            Some(flight.get(row)?.altitude_m + sensor.bias_m + effects_m.get(row).copied()?)
        })?;
        let velocity = |axis: usize| {
            let truth = between(due.source, |row| flight.get(row)?.velocity_mps.get(axis).copied())?;
            Some(truth + velocity_noise.get(axis).copied()?)
        };

        let (mut cold_error, mut satellites) = (0.0, f64::from(sensor.satellites));
        if let Some(cold_start) = sensor.cold_start {
            let left = libm::exp(-due.time_s / cold_start.time_constant_s);
            cold_error = cold_start.altitude_error_m * left;
            satellites -= (satellites - f64::from(cold_start.satellites).max(FIX_SATELLITES)) * left;
        }
        let raw = clean + cold_error + noise;
        let altitude = match self.smoothed {
            Some((last, last_s)) if sensor.smoothing_s > 0.0 => {
                last + (raw - last) * -libm::expm1((last_s - due.time_s) / sensor.smoothing_s)
            }
            _ => raw,
        };
        self.smoothed = Some((altitude, due.time_s));

        let spread = libm::sqrt(
            sensor.noise.white * sensor.noise.white
                + sensor.noise.wander * sensor.noise.wander
                + cold_error * cold_error,
        );
        Some([
            quantise(altitude, sensor.quantum_m),
            velocity(0)?,
            velocity(1)?,
            velocity(2)?,
            spread * sensor.accuracy_factor,
            libm::rint(satellites),
            due.time_s - sensor.sampling.latency_s,
        ])
    }
}
