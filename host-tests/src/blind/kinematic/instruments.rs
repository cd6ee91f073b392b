//! The instruments' view of the truth: noise with heavy tails, buffeting that grows with the dynamic
//! pressure, quantisation, late and wrongly scaled signals, held and slow fixes.

use pylon::flight::{AltitudeDatum, Channel, Column, Flight, Header};
use pylon::simulate::TruthSample;
use pylon::simulate::scenario::{Effect, EffectId};
use rand::{Rng, RngExt as _};

use super::disturbance::{Gust, Steps, Tones, heavy_tailed, normal};
use super::path::STEP_S;
use super::physics::{self, altitude_m, barometer_pa, inertial_error_m, pressure_pa, receiver};
use crate::blind::draw::log_uniform;

/// A signal that is late, wrongly scaled and has an offset.
#[derive(Clone, Copy, Debug)]
struct Signal {
    scale: f64,
    offset: f64,
    lag_s: f64,
    sigma: f64,
}

impl Signal {
    fn draw(random: &mut impl Rng, scale: f64, offset: f64, lag_s: [f64; 2], sigma: f64) -> Self {
        Self {
            scale: 1.0 + scale * normal(random),
            offset: offset * normal(random),
            lag_s: random.random_range(lag_s[0]..lag_s[1]),
            sigma: sigma * log_uniform(random, 0.5, 2.0),
        }
    }
}

/// The instruments of one aircraft; the same on all its flights.
#[derive(Clone, Debug)]
pub(super) struct Instruments {
    gps_rate_hz: f64,
    gps_white_m: f64,
    gps_wander: [f64; 2],
    gps_steps: [f64; 3],
    gps_quantum_m: f64,
    gps_velocity_mps: f64,
    gps_holds: bool,
    gps_smoothing_s: f64,
    baro_rate_hz: f64,
    baro_bias_m: f64,
    baro_white_m: f64,
    baro_buffet_m: f64,
    baro_wander_m: f64,
    baro_quantum_pa: f64,
    is_hose: bool,
    slave_bias_m: f64,
    slave_white_m: f64,
    slave_wander_m: f64,
    accel_bias_mps2: [f64; 3],
    gyro_bias_radps: [f64; 3],
    airspeed: Signal,
    flow: [Signal; 2],
    attitude: [Signal; 3],
    temperatures: [Signal; 2],
}

impl Instruments {
    pub fn draw(random: &mut impl Rng) -> Self {
        Self {
            gps_rate_hz: one_of(random, &[1.0, 2.0, 5.0, 5.0, 10.0]),
            gps_white_m: log_uniform(random, 0.1, 1.0),
            gps_wander: [log_uniform(random, 0.3, 2.0), log_uniform(random, 20.0, 200.0)],
            gps_steps: [
                random.random_range(40.0..400.0),
                log_uniform(random, 0.2, 2.0),
                random.random_range(20.0..200.0),
            ],
            gps_quantum_m: one_of(random, &[0.001, 0.01, 0.1, 0.1, 1.0]),
            gps_velocity_mps: log_uniform(random, 0.05, 0.3),
            gps_holds: random.random_range(0..6) == 0,
            gps_smoothing_s: 0.0,
            baro_rate_hz: one_of(random, &[10.0, 20.0, 25.0]),
            baro_bias_m: random.random_range(-60.0..60.0),
            baro_white_m: log_uniform(random, 0.1, 0.8),
            baro_buffet_m: log_uniform(random, 0.05, 0.6),
            baro_wander_m: log_uniform(random, 0.1, 0.8),
            baro_quantum_pa: one_of(random, &[0.01, 1.0, 4.0]),
            is_hose: random.random(),
            slave_bias_m: random.random_range(-60.0..60.0),
            slave_white_m: log_uniform(random, 0.05, 0.4),
            slave_wander_m: log_uniform(random, 0.1, 0.8),
            accel_bias_mps2: std::array::from_fn(|_| 0.02 * normal(random)),
            gyro_bias_radps: std::array::from_fn(|_| 0.001 * normal(random)),
            airspeed: Signal::draw(random, 0.02, 0.2, [0.1, 0.6], 0.5),
            flow: std::array::from_fn(|_| Signal::draw(random, 0.05, 0.008, [0.05, 0.3], 0.005)),
            attitude: std::array::from_fn(|_| Signal::draw(random, 0.0, 0.006, [0.0, 0.05], 0.002)),
            temperatures: [
                Signal::draw(random, 0.0, 0.5, [0.5, 5.0], 0.05),
                Signal::draw(random, 0.0, 1.0, [1.0, 10.0], 0.2),
            ],
        }
    }

    /// Ratio of the physical coefficient to the one that is right for this aircraft's own signals: a signal
    /// that reads too high reduces the latter.
    pub fn effective(&self, id: EffectId) -> f64 {
        let head = self.airspeed.scale * self.airspeed.scale;
        match id {
            EffectId::BaroDynamicPressure | EffectId::BaroCarrierField => head,
            EffectId::BaroAngleOfAttack => head * self.flow[0].scale,
            EffectId::BaroSideslip => head * self.flow[1].scale * self.flow[1].scale,
            _ => 1.0,
        }
    }

    /// Makes the receiver filter its altitude with this time constant, s.
    pub fn smooth(&mut self, time_s: f64) {
        self.gps_smoothing_s = time_s;
    }
}

fn one_of(random: &mut impl Rng, values: &[f64]) -> f64 {
    values[random.random_range(0..values.len())]
}

/// A recorded flight, and the noise of each sensor's residual in free flight, rms over whole seconds, m:
/// first the barometer's, then the inertial altitude's.
pub(super) struct Recorded {
    pub flight: Flight,
    pub noise_m: [f64; 2],
}

/// Rows at which an instrument with that rate is read.
fn due(rows: usize, rate_hz: f64) -> impl Iterator<Item = usize> {
    let every = (1.0 / (rate_hz * STEP_S)).round() as usize;
    (0..rows).step_by(every.max(1))
}

fn quantised(value: f64, quantum: f64) -> f64 {
    (value / quantum).round() * quantum
}

/// A channel, its signal, its rate (Hz) and what it measures.
type Measured<'a> = (Channel, &'a Signal, f64, fn(&TruthSample) -> f64);

/// Records a flight.
pub(super) fn record<R: Rng>(
    truth: &[TruthSample],
    effects: &[Effect],
    own: &Instruments,
    random: &mut R,
) -> Recorded {
    let flight = Flight {
        header: Header {
            vehicle: "simulated".to_owned(),
            source: "host-tests' kinematic family, simulated".to_owned(),
            altitude_datum: AltitudeDatum::Msl,
            other: vec![("latitude_deg".to_owned(), physics::LATITUDE_RAD.to_degrees().to_string())],
        },
        time_s: truth.iter().map(|sample| sample.time_s).collect(),
        ..Flight::default()
    };
    let mut recorder = Recorder { truth, effects, own, random, flight };
    recorder.launch();
    let gps_noise_m = recorder.gps();
    let baro_noise_m = recorder.barometer();
    let slave_noise_m = recorder.inertial_altitudes();
    recorder.inertial();
    recorder.signals();
    let noise_m = [&baro_noise_m, &slave_noise_m].map(|own| residual_noise_m(truth, own, &gps_noise_m));
    Recorded { flight: recorder.flight, noise_m }
}

/// A flight while its instruments record it, one after another.
struct Recorder<'a, R> {
    truth: &'a [TruthSample],
    effects: &'a [Effect],
    own: &'a Instruments,
    random: &'a mut R,
    flight: Flight,
}

impl<R: Rng> Recorder<'_, R> {
    fn launch(&mut self) {
        let mut launch = Column::with_capacity(self.truth.len());
        for sample in self.truth {
            launch.push(Some(if sample.captive { 0.0 } else { 1.0 }));
        }
        self.flight.set_channel(Channel::Launch, launch);
    }

    /// The receiver's fixes; returns its noise where there was a fix, m.
    fn gps(&mut self) -> Vec<f64> {
        let Self { truth, effects, own, .. } = *self;
        let rows = truth.len();
        let mut noise_m = vec![f64::NAN; rows];
        let channels = [
            Channel::GpsAltM,
            Channel::GpsVnMps,
            Channel::GpsVeMps,
            Channel::GpsVdMps,
            Channel::GpsVaccM,
            Channel::GpsSats,
        ];
        let mut columns: [Column; 6] = std::array::from_fn(|_| Column::empty(rows));
        let mut wander = Gust::new(own.gps_wander[0], own.gps_wander[1]);
        let [every_s, size, fade_s] = own.gps_steps;
        let mut steps = Steps::new(every_s, size, fade_s);
        let mut held_until_s = 0.0;
        let mut last: Option<[f64; 6]> = None;
        let mut smoothed = truth.first().map_or(0.0, |sample| sample.altitude_m);
        let gain = if own.gps_smoothing_s > STEP_S { STEP_S / own.gps_smoothing_s } else { 1.0 };
        let altitude_m: Vec<f64> = truth
            .iter()
            .map(|sample| {
                smoothed += gain * (sample.altitude_m - smoothed);
                smoothed
            })
            .collect();
        for row in due(rows, own.gps_rate_hz) {
            let sample = &truth[row];
            let step_s = 1.0 / own.gps_rate_hz;
            let (added_m, late_s) = receiver(sample, effects);
            let at = row.saturating_add_signed(-(late_s / STEP_S).round() as isize).min(rows - 1);
            let seen = &truth[at];
            let noise = wander.next(self.random, step_s)
                + steps.next(self.random, step_s)
                + own.gps_white_m * heavy_tailed(self.random);
            let mut velocity =
                |k: usize| seen.velocity_mps[k] + own.gps_velocity_mps * heavy_tailed(self.random);
            let fix = [
                quantised(altitude_m[at] + added_m + noise, own.gps_quantum_m),
                velocity(0),
                velocity(1),
                velocity(2),
                1.5 * (own.gps_white_m + own.gps_wander[0]),
                9.0,
            ];
            if own.gps_holds && sample.time_s > held_until_s && self.random.random::<f64>() < step_s / 40.0 {
                held_until_s = sample.time_s + self.random.random_range(0.5..3.0);
            }
            let sent = match last {
                Some(old) if sample.time_s < held_until_s => old,
                _ => {
                    noise_m[row] = noise;
                    last = Some(fix);
                    fix
                }
            };
            for (column, value) in columns.iter_mut().zip(sent) {
                column.set(row, Some(value as f32));
            }
        }
        for (channel, column) in channels.into_iter().zip(columns) {
            self.flight.set_channel(channel, column);
        }
        noise_m
    }

    fn barometer(&mut self) -> Vec<f64> {
        let Self { truth, effects, own, .. } = *self;
        let mut noise_m = vec![f64::NAN; truth.len()];
        let mut column = Column::empty(truth.len());
        let sensed = barometer_pa(truth, effects, own.is_hose);
        let tones = Tones::draw(self.random, own.baro_wander_m, [8.0, 150.0]);
        // The speed that the aircraft flies at most of the time.
        let cruise = truth.first().map_or(1.0, |sample| sample.airspeed_mps);
        for row in due(truth.len(), own.baro_rate_hz) {
            let buffet = own.baro_buffet_m * (truth[row].airspeed_mps / cruise).powi(2);
            let noise = tones.at(truth[row].time_s)
                + own.baro_white_m * heavy_tailed(self.random)
                + buffet * normal(self.random);
            noise_m[row] = noise;
            let pascal = pressure_pa(altitude_m(sensed[row]) + own.baro_bias_m + noise);
            column.set(row, Some(quantised(pascal, own.baro_quantum_pa) as f32));
        }
        self.flight.set_channel(Channel::BaroPa, column);
        noise_m
    }

    fn inertial_altitudes(&mut self) -> Vec<f64> {
        let Self { truth, effects, own, .. } = *self;
        let mut noise_m = vec![f64::NAN; truth.len()];
        let (mut slave, mut master) = (Column::empty(truth.len()), Column::empty(truth.len()));
        let errors = inertial_error_m(truth, effects);
        let tones = Tones::draw(self.random, own.slave_wander_m, [15.0, 200.0]);
        let carrier = Tones::draw(self.random, 0.5, [20.0, 200.0]);
        for row in due(truth.len(), 25.0) {
            let sample = &truth[row];
            let noise = tones.at(sample.time_s) + own.slave_white_m * heavy_tailed(self.random);
            noise_m[row] = noise;
            slave.set(row, Some((sample.altitude_m + own.slave_bias_m + errors[row] + noise) as f32));
            if sample.captive {
                let reading = sample.altitude_m + carrier.at(sample.time_s) + 0.2 * heavy_tailed(self.random);
                master.set(row, Some(reading as f32));
            }
        }
        self.flight.set_channel(Channel::ImuSlaveAltM, slave);
        self.flight.set_channel(Channel::ImuMasterAltM, master);
        noise_m
    }

    fn inertial(&mut self) {
        let Self { truth, own, .. } = *self;
        let axes = [
            (Channel::AccelXMps2, Channel::GyroXRadps),
            (Channel::AccelYMps2, Channel::GyroYRadps),
            (Channel::AccelZMps2, Channel::GyroZRadps),
        ];
        for (axis, (accelerometer, gyro)) in axes.into_iter().enumerate() {
            let (mut force, mut rate) = (Column::empty(truth.len()), Column::empty(truth.len()));
            for (row, sample) in truth.iter().enumerate() {
                let shake = sample.vibration_mps2 * normal(self.random) + 0.03 * normal(self.random);
                let reading = sample.specific_force_mps2[axis] + own.accel_bias_mps2[axis] + shake;
                force.set(row, Some(reading as f32));
                let reading =
                    sample.rate_radps[axis] + own.gyro_bias_radps[axis] + 0.004 * normal(self.random);
                rate.set(row, Some(reading as f32));
            }
            self.flight.set_channel(accelerometer, force);
            self.flight.set_channel(gyro, rate);
        }
    }

    /// Air data, attitude, temperatures and throttle.
    fn signals(&mut self) {
        let own = self.own;
        // The lever's own position.
        let throttle = Signal { scale: 1.0, offset: 0.0, lag_s: 0.0, sigma: 0.005 };
        // A heading wraps, and is not filtered.
        let heading = Signal { lag_s: 0.0, ..own.attitude[2] };
        let signals: [Measured<'_>; 9] = [
            (Channel::TasMps, &own.airspeed, 10.0, |s| s.airspeed_mps),
            (Channel::AoaRad, &own.flow[0], 10.0, |s| s.angle_of_attack_rad),
            (Channel::SideslipRad, &own.flow[1], 10.0, |s| s.sideslip_rad),
            (Channel::RollRad, &own.attitude[0], 25.0, |s| s.euler_rad[0]),
            (Channel::PitchRad, &own.attitude[1], 25.0, |s| s.euler_rad[1]),
            (Channel::BaroTempC, &own.temperatures[0], own.baro_rate_hz, |s| s.baro_temperature_c),
            (Channel::OatC, &own.temperatures[1], 2.0, |s| s.air_temperature_c),
            (Channel::Throttle, &throttle, 10.0, |s| s.throttle),
            (Channel::YawRad, &heading, 25.0, |s| s.euler_rad[2]),
        ];
        for (channel, signal, rate_hz, value) in signals {
            let column = self.measured(signal, rate_hz, value);
            self.flight.set_channel(channel, column);
        }
    }

    /// A first-order lag of a row's value, then scale, offset and noise, sampled at a rate.
    fn measured(&mut self, signal: &Signal, rate_hz: f64, value: fn(&TruthSample) -> f64) -> Column {
        let mut column = Column::empty(self.truth.len());
        let mut lagged: Option<f64> = None;
        let mut next = due(self.truth.len(), rate_hz).peekable();
        let gain = if signal.lag_s > STEP_S { STEP_S / signal.lag_s } else { 1.0 };
        for (row, sample) in self.truth.iter().enumerate() {
            let now = value(sample);
            let last = lagged.unwrap_or(now);
            let filtered = last + gain * (now - last);
            lagged = Some(filtered);
            if next.next_if(|due| *due == row).is_some() {
                let noise = signal.sigma * heavy_tailed(self.random);
                column.set(row, Some((signal.scale * filtered + signal.offset + noise) as f32));
            }
        }
        column
    }
}

/// Rms in free flight of the noise of (sensor less receiver) over whole seconds, about its mean in captive
/// flight, m.
fn residual_noise_m(truth: &[TruthSample], sensor_m: &[f64], gps_m: &[f64]) -> f64 {
    let second = (1.0 / STEP_S).round() as usize;
    let mean = |values: &[f64]| {
        let seen: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        (!seen.is_empty()).then(|| seen.iter().sum::<f64>() / seen.len() as f64)
    };
    let (mut captive, mut free) = (Vec::new(), Vec::new());
    for ((rows, sensor), gps) in truth.chunks(second).zip(sensor_m.chunks(second)).zip(gps_m.chunks(second)) {
        if let (Some(sensor), Some(gps)) = (mean(sensor), mean(gps)) {
            if rows[0].captive { &mut captive } else { &mut free }.push(sensor - gps);
        }
    }
    let origin = mean(&captive).unwrap_or(0.0);
    (free.iter().map(|noise| (noise - origin).powi(2)).sum::<f64>() / free.len().max(1) as f64).sqrt()
}
