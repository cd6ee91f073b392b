//! Missions on arbitrary bits: the input of a tick, its time, and what may be published.
#![allow(clippy::unwrap_used)] // Clippy's exception for tests does not reach their helper functions.

use kf_core::config::{
    ClimbRate, MissionConfig, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig,
    SigmaSource,
};
use kf_core::effect::{EffectId, EffectTerm};
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, Signals, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::launch::{LaunchConfig, LaunchDetector, LaunchInput, LaunchState};
use kf_core::mission::Mission;
use kf_core::navigation::InertialAltitude;
use kf_core::output::TickOutput;
use kf_core::snapshot::MAX_SNAPSHOT_BYTES;
use kf_core::strapdown;

/// A mission of the dense shape with four effects as states.
pub type Flown = Mission<0, 8, 4>;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    pub fn one_in(&mut self, n: u64) -> bool {
        self.bits().is_multiple_of(n)
    }

    /// Uniform, of mean 0 and variance 1.
    pub fn noise(&mut self) -> f32 {
        ((self.bits() >> 40) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6
    }

    /// Arbitrary bits, the special values, and the possible output of a broken sensor.
    pub fn hostile(&mut self) -> f32 {
        const SPECIAL: [f32; 12] = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            1e-45,
            0.0,
            -0.0,
            1e38,
            99_999.0,
            -999.0,
        ];
        match self.bits() % 4 {
            0 => f32::from_bits(self.bits() as u32),
            1 => SPECIAL[(self.bits() % SPECIAL.len() as u64) as usize],
            2 => self.noise() * 3_000.0 + 2_000.0,
            _ => self.noise() * 100.0,
        }
    }
}

/// The default model's noise, and four effects as states, including integrated ones and one on the reference.
pub fn config() -> MissionConfig<4> {
    let sensor = |sigma_m, correlation_time_s, wander_m_per_sqrt_s| SensorConfig {
        sigma_m,
        correlation_time_s,
        prior_bias_m: 0.0,
        prior_sigma_m: 100.0,
        wander_m_per_sqrt_s,
    };
    let effect = |id, sigma| EffectTerm::new(id, 0.0, sigma);
    MissionConfig {
        settling_s: 0.5,
        reference: ReferenceConfig {
            sigma_m: 2.0,
            correlation_time_s: 60.0,
            prior_altitude_m: None,
            prior_sigma_m: 50.0,
            climb_rate: Some(ClimbRate { sigma_mps: 0.15, correlation_time_s: 5.0 }),
            lost_after_s: 5.0,
        },
        latitude_deg: 45.0,
        sensors: [sensor(3.0, 10.0, 0.1), sensor(1.0, 1.0, 2.3), sensor(0.5, 0.5, 0.14)],
        monitor: MonitorConfig {
            sigma: SigmaSource::Residual,
            multiplier: 3.0,
            window_s: 2.0,
            persistence_s: 1.25,
            reference_check: true,
        },
        second_correction: SecondCorrection::MovingAverage,
        quality: QualityConfig {
            minimum_duration_s: 10.0,
            trimmed_altitude_m: 10.0,
            trimmed_airspeed_mps: 2.0,
            reference_drift_m: 6.0,
            minimum_satellites: 6,
            vertical_accuracy_m: 5.0,
            bias_drift_sigmas: 1.0,
            implausible_share: 0.027,
        },
        estimated_effects: [
            effect(EffectId::GpsLatency, 0.2),
            effect(EffectId::BaroLag, 0.5),
            effect(EffectId::BaroDynamicPressure, 0.2),
            effect(EffectId::ImuTilt, 0.01),
        ],
        constant_effects: heapless::Vec::from_slice(&[
            EffectTerm::new(EffectId::BaroScale, 0.01, 0.01),
            EffectTerm::new(EffectId::ImuVibration, 1e-4, 1e-4),
        ])
        .unwrap(),
    }
}

/// A tick of a healthy flight at 2,000 m: biases of 5, -20 and 30 m.
pub fn healthy(k: u64, random: &mut Random) -> TickInput {
    let mut input = TickInput { time_us: 5_000 * k, ..TickInput::default() };
    if k.is_multiple_of(40) {
        input.gps = Some(GpsFix {
            altitude_m: 2_000.0 + 2.0 * random.noise(),
            velocity_north_mps: Some(30.0 + 0.1 * random.noise()),
            velocity_east_mps: Some(0.1 * random.noise()),
            velocity_down_mps: Some(0.1 * random.noise()),
            vertical_accuracy_m: Some(3.0),
            satellites: Some(11),
            fix_time_us: Some(5_000 * k),
        });
    }
    if k.is_multiple_of(4) {
        input.imu_master_altitude_m = Some(2_005.0 + random.noise());
        input.imu_slave_altitude_m = Some(1_980.0 + 0.5 * random.noise());
        input.baro = Some(BaroReading::AltitudeM(2_030.0 + 0.5 * random.noise()));
        input.signals =
            Signals { true_airspeed_mps: Some(30.0 + 0.1 * random.noise()), ..Signals::default() };
    }
    input.imu = Some(ImuSample {
        accel_mps2: [0.1 * random.noise(), 0.1 * random.noise(), -9.81 + 0.5 * random.noise()],
        gyro_radps: [0.01 * random.noise(), 0.01 * random.noise(), 0.01 * random.noise()],
    });
    input
}

/// Makes parts of a tick hostile, each with a chance of one in `rarity`.
pub fn poison(input: &mut TickInput, random: &mut Random, rarity: u64) {
    let r = random;
    if r.one_in(rarity) {
        let maybe = |r: &mut Random| (!r.one_in(4)).then(|| r.hostile());
        input.gps = Some(GpsFix {
            altitude_m: r.hostile(),
            velocity_north_mps: maybe(r),
            velocity_east_mps: maybe(r),
            velocity_down_mps: maybe(r),
            vertical_accuracy_m: maybe(r),
            satellites: Some(r.bits() as u8),
            fix_time_us: r.one_in(2).then(|| r.bits()),
        });
    }
    if r.one_in(rarity) {
        let value = r.hostile();
        input.baro =
            Some(if r.one_in(2) { BaroReading::PressurePa(value) } else { BaroReading::AltitudeM(value) });
    }
    if r.one_in(rarity) {
        input.imu_master_altitude_m = Some(r.hostile());
    }
    if r.one_in(rarity) {
        input.imu_slave_altitude_m = Some(r.hostile());
    }
    if r.one_in(rarity) {
        let three = |r: &mut Random| [r.hostile(), r.hostile(), r.hostile()];
        input.imu = Some(ImuSample { accel_mps2: three(r), gyro_radps: three(r) });
    }
    if r.one_in(rarity) {
        let signals = &mut input.signals;
        let value = Some(r.hostile());
        match r.bits() % 7 {
            0 => signals.true_airspeed_mps = value,
            1 => signals.angle_of_attack_rad = value,
            2 => signals.sideslip_rad = value,
            3 => signals.throttle = value,
            4 => signals.outside_air_temperature_c = value,
            5 => signals.baro_temperature_c = value,
            _ => signals.attitude_rad = Some([r.hostile(), r.hostile(), r.hostile()]),
        }
    }
}

fn assert_finite(values: &[f32], output: &TickOutput) {
    assert!(values.iter().all(|value| value.is_finite()), "{output:?}");
}

/// Every published number must be finite, and no variance negative.
pub fn check(output: &TickOutput, latch: Option<&LatchRecord>) {
    assert_finite(&[output.altitude_m, output.altitude_variance_m2], output);
    let optional = [output.gps_innovation_m, output.gps_signed_nis];
    assert!(
        output.altitude_variance_m2 >= 0.0 && optional.iter().flatten().all(|x| x.is_finite()),
        "{output:?}"
    );
    for sensor in &output.sensors {
        let optional = [sensor.innovation_m, sensor.signed_nis, sensor.error_m, sensor.moving_average_m];
        assert!(optional.iter().flatten().all(|value| value.is_finite()), "{output:?}");
        assert_finite(&[sensor.bias_m, sensor.bias_variance_m2], output);
        assert!(sensor.bias_variance_m2 >= 0.0, "{output:?}");
    }
    for said in &output.coefficients {
        assert_finite(&[said.coefficient, said.variance], output);
    }
    if let Some(said) = &output.cross_check {
        assert_finite(&[said.difference_m, said.moving_average_m], output);
    }
    if let Some(latch) = latch {
        for sensor in &latch.sensors {
            let variances = [
                sensor.bias_variance_m2,
                sensor.residual_variance_m2,
                sensor.mean_variance_m2,
                sensor.bound_m2,
            ];
            assert!(variances.iter().all(|variance| variance.is_finite() && *variance >= 0.0), "{latch:?}");
        }
        assert!(latch.state.iter().chain(&latch.covariance).all(|entry| entry.is_finite()), "{latch:?}");
    }
}

/// The parts that decide and integrate before the mission does, on the same bits: launch, and the altitude of
/// the inertial unit.
struct Before {
    launch: LaunchDetector,
    inertial: InertialAltitude,
    last_message_us: Option<u64>,
    is_open: bool,
}

impl Before {
    fn new() -> Self {
        Self {
            launch: LaunchDetector::new(LaunchConfig::DEFAULT).unwrap(),
            inertial: InertialAltitude::new(strapdown::Config::MEMS),
            last_message_us: None,
            is_open: false,
        }
    }

    /// A launch is final, and the integrated altitude is finite, for any input.
    fn tick(&mut self, input: &mut TickInput, is_off: bool, rarity: u64, random: &mut Random) {
        let before = self.launch.state();
        if !is_off && random.one_in(20) {
            self.last_message_us = Some(input.time_us);
        }
        if random.one_in(100 * rarity) {
            self.last_message_us = random.one_in(4).then(|| random.bits());
        }
        if random.one_in(200 * rarity) {
            self.is_open = !self.is_open;
        }
        let climb_mps = input.gps.and_then(|fix| fix.velocity_down_mps).map(|down_mps| -down_mps);
        let state = self.launch.tick(&LaunchInput {
            time_us: input.time_us,
            is_open: (!random.one_in(10 * rarity)).then_some(self.is_open || is_off),
            force_mps2: input.imu.map(|imu| imu.accel_mps2),
            last_message_us: self.last_message_us,
            climb_mps,
            ground_speed_squared_m2ps2: climb_mps.map(|mps| mps * mps),
        });
        assert!(!before.is_launched() || state == before, "{before:?} {state:?}");
        input.launch = state.is_launched();
        input.launch_doubt = state.doubt();
        input.imu_slave_altitude_m = None;
        self.inertial.tick(input);
        assert!(input.imu_slave_altitude_m.is_none_or(f32::is_finite), "{input:?}");
        if let (true, Some(kept)) = (random.one_in(500), self.inertial.kept()) {
            let unknown_s = (random.bits() % 1_000) as f32 * 1e-3;
            self.inertial = InertialAltitude::new(strapdown::Config::MEMS);
            assert!(self.inertial.resume(&kept, unknown_s));
        }
    }

    fn is_launched(&self) -> bool {
        matches!(self.launch.state(), LaunchState::Launched(_))
    }
}

/// Result of a hostile run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Missions started.
    pub missions: u64,
    /// Calibrations latched.
    pub latched: u64,
    /// Launches decided on the same bits.
    pub decided: u64,
    /// Altitudes integrated from them.
    pub integrated: u64,
}

/// Flies missions on hostile input, for so many ticks in total. In every other one, launch and the altitude
/// of the UAV's inertial unit are computed from the same bits.
pub fn fly(seed: u64, ticks: u64) -> Outcome {
    let config = config();
    let mut random = Random(seed);
    let (mut flown, mut came) = (0, Outcome::default());
    while flown < ticks {
        came.missions += 1;
        let mut before = random.one_in(2).then(Before::new);
        let rarity = [1, 3, 30, 300, 3_000][(random.bits() % 5) as usize];
        // It takes half a minute until the inertial altitude is aligned.
        let length = 200 + random.bits() % if before.is_some() { 20_000 } else { 6_000 };
        let launch = random.bits() % (length + length / 4);
        let mut mission = Flown::new(&config).unwrap();
        // A mission may begin at any time; after that its clock is mostly right.
        let mut offset_us = if random.one_in(2) { random.bits() } else { 0 };
        for k in 0..length {
            let mut input = healthy(k, &mut random);
            poison(&mut input, &mut random, rarity);
            if random.one_in(2_000) {
                offset_us = match random.bits() % 4 {
                    0 => random.bits(),
                    1 => u64::MAX - 5_000 * k - random.bits() % 1_000_000,
                    2 => offset_us.wrapping_add(315_576_000_000_000),
                    _ => offset_us.wrapping_sub(random.bits() % 10_000_000),
                };
            }
            input.time_us = input.time_us.wrapping_add(offset_us);
            let is_edge = random.one_in(500);
            input.launch = k > launch || (is_edge && random.one_in(20));
            input.launch_doubt = match random.bits() % 8 {
                0 if is_edge || (launch.saturating_sub(10)..=launch).contains(&k) => LaunchDoubt::Suspected,
                1 => LaunchDoubt::Unconfirmed,
                _ => LaunchDoubt::None,
            };
            if let Some(before) = &mut before {
                before.tick(&mut input, k > launch, rarity, &mut random);
                came.integrated += u64::from(input.imu_slave_altitude_m.is_some());
            }
            let output = mission.tick(&input);
            came.latched += u64::from(output.latched_now);
            check(&output, mission.latch().filter(|_| output.latched_now));
            flown += 1;
            if random.one_in(500) {
                mission = restarted(mission, &config);
            }
        }
        came.decided += u64::from(before.is_some_and(|before| before.is_launched()));
    }
    came
}

/// The mission after a reset: restored from its snapshot's bytes, if there is a snapshot.
fn restarted(mission: Flown, config: &MissionConfig<4>) -> Flown {
    let Some(snapshot) = mission.snapshot() else { return mission };
    let mut bytes = [0; MAX_SNAPSHOT_BYTES];
    let length = snapshot.to_bytes(&mut bytes).unwrap();
    let mut resumed = Flown::new(config).unwrap();
    resumed.restore_snapshot(&bytes[..length], &mission.mark()).unwrap();
    resumed
}
