//! The barometer and the inertial altitudes.

use super::super::atmosphere::standard_pressure_pa;
use super::super::motion::TruthSample;
use super::super::random::{GaussMarkov, Random, Stream};
use super::super::scenario::{AltitudeSensor, Barometer, CarrierFlow};
use super::{NoiseSource, Readings, Series, between, quantise, schedule};
use flight_data::Channel;

/// The mother ship's disturbed flow at a sensor.
struct FlowSource {
    flow: CarrierFlow,
    settling_s: f64,
    process: GaussMarkov,
    last_s: Option<f64>,
}

impl FlowSource {
    fn new(flow: CarrierFlow, settling_s: f64) -> Self {
        Self { flow, settling_s, process: GaussMarkov::default(), last_s: None }
    }

    /// Metres; zero from release on.
    fn next(&mut self, random: &mut Random, time_s: f64, captive: bool) -> f64 {
        if self.flow.sigma_m == 0.0 {
            return 0.0;
        }
        let elapsed = time_s - self.last_s.unwrap_or(time_s);
        self.last_s = Some(time_s);
        let value = self.flow.sigma_m * self.process.next(random, elapsed / self.flow.correlation_time_s);
        match captive {
            false => 0.0,
            true if time_s < self.settling_s => value * self.flow.settling_factor,
            true => value,
        }
    }
}

/// Common part of all altitude sensors: `clean` is the altitude without noise (truth, effects, bias), a value
/// for each row.
struct Altimeter<'a> {
    flight: &'a [TruthSample],
    clean: &'a dyn Fn(usize) -> Option<f64>,
    noise: NoiseSource,
    flow: FlowSource,
    random: Random,
}

impl Altimeter<'_> {
    fn read(&mut self, due: super::Due) -> Option<f64> {
        let captive = self.flight.get(due.row).is_some_and(|sample| sample.captive);
        let noise = self.noise.next(&mut self.random, due.time_s);
        let flow = self.flow.next(&mut self.random, due.time_s, captive);
        let clean = between(due.source, self.clean)?;
        (!due.lost).then_some(clean + noise + flow)
    }
}

/// The barometer's pressure (Pa) and temperature (degrees Celsius). `effects_m` is the sum of the injected
/// effects on its pressure altitude, a value for each row.
pub(in super::super) fn baro(
    sensor: &Barometer,
    flight: &[TruthSample],
    effects_m: &[f64],
    settling_s: f64,
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let clean = |row: usize| {
        Some(flight.get(row)?.pressure_altitude_m + sensor.bias_m + effects_m.get(row).copied()?)
    };
    let mut altimeter = Altimeter {
        flight,
        clean: &clean,
        noise: NoiseSource::new(sensor.noise),
        flow: FlowSource::new(sensor.carrier_flow, settling_s),
        random: Random::new(seed, Stream::Baro),
    };
    let mut temperature_noise = Random::new(seed, Stream::BaroTemperature);
    let (mut pressures, mut temperatures) = (Series::new(), Series::new());
    let losses = Random::new(seed, Stream::BaroLosses);
    for due in schedule(&sensor.sampling, flight, row_rate_hz, losses) {
        let error_c = sensor.temperature.sigma_c * temperature_noise.normal();
        let temperature = between(due.source, |row| Some(flight.get(row)?.baro_temperature_c));
        if let (Some(altitude), Some(temperature)) = (altimeter.read(due), temperature) {
            pressures.push((due.row, quantise(standard_pressure_pa(altitude), sensor.quantum_pa)));
            temperatures.push((due.row, temperature + error_c));
        }
    }
    vec![(Channel::BaroPa, pressures), (Channel::BaroTempC, temperatures)]
}

/// Which inertial altitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum ImuAltitude {
    /// The mother ship's: it stays with the mother ship at launch.
    Master,
    /// The UAV's.
    Slave,
}

/// An inertial altitude, m.
pub(in super::super) fn imu_altitude(
    which: ImuAltitude,
    sensor: &AltitudeSensor,
    flight: &[TruthSample],
    effects_m: &[f64],
    settling_s: f64,
    row_rate_hz: f64,
    seed: u64,
) -> Readings {
    let (channel, stream, losses) = match which {
        ImuAltitude::Master => (Channel::ImuMasterAltM, Stream::ImuMaster, Stream::ImuMasterLosses),
        ImuAltitude::Slave => (Channel::ImuSlaveAltM, Stream::ImuSlave, Stream::ImuSlaveLosses),
    };
    let clean = |row: usize| Some(flight.get(row)?.altitude_m + sensor.bias_m + effects_m.get(row).copied()?);
    let mut altimeter = Altimeter {
        flight,
        clean: &clean,
        noise: NoiseSource::new(sensor.noise),
        flow: FlowSource::new(sensor.carrier_flow, settling_s),
        random: Random::new(seed, stream),
    };
    let mut series = Series::new();
    for due in schedule(&sensor.sampling, flight, row_rate_hz, Random::new(seed, losses)) {
        let aboard = which == ImuAltitude::Slave || flight.get(due.row).is_some_and(|s| s.captive);
        if let Some(altitude) = altimeter.read(due).filter(|_| aboard) {
            series.push((due.row, quantise(altitude, sensor.quantum_m)));
        }
    }
    vec![(channel, series)]
}
