//! A trial's flight.

use std::ops::Range;

use anyhow::{Context as _, bail};
use pylon::flight::{Channel, Column, Flight};
use pylon::simulate::scenario::{Captive, Effect, EffectId, InjectionPhase};
use pylon::simulate::{Scenario, TruthSample, regressor, simulate};
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::draw::{Case, Family, Kind};
use super::outside::Outside;

/// A flown trial.
#[derive(Clone, Debug)]
pub struct Flown {
    /// The flight that the diagnosis sees.
    pub flight: Flight,
    /// The injected effects, with the rms in metres that each causes in free flight, the largest first.
    pub effects: Vec<(Effect, f64)>,
    /// The residual's noise in free flight, rms, metres.
    pub noise_m: f64,
}

/// Flies a case. Another `number` gives a second flight of the same case: the same coefficients in other air.
///
/// # Errors
/// If the aircraft can't fly the plan, or a column is missing.
pub fn fly(case: &Case, number: u64) -> anyhow::Result<Flown> {
    fly_as(case, number, None)
}

/// As [`fly`], but on a planned flight instead of the case's own: its calibration and manoeuvres.
///
/// # Errors
/// If the aircraft can't fly the plan, or a column is missing.
pub(crate) fn fly_as(case: &Case, number: u64, planned: Option<&Scenario>) -> anyhow::Result<Flown> {
    match case.family {
        Family::Dynamic => dynamic(case, number, planned),
        Family::Kinematic => super::kinematic::fly(case, number, planned),
    }
}

fn dynamic(case: &Case, number: u64, planned: Option<&Scenario>) -> anyhow::Result<Flown> {
    let mut scenario = Scenario::from_toml(&case.scenario, "blind")?;
    let first = case.seed.wrapping_mul(1000);
    let seed = first.wrapping_add(number);
    // The coefficients are always computed from the first flight's path.
    let (_, truth) = simulate(&scenario, first).map_err(|error| anyhow::anyhow!("{error}"))?;
    let baro = &scenario.sensors.baro.noise;
    let gps = &scenario.sensors.gps.noise;
    let imu = &scenario.sensors.imu_slave.noise;
    let noise = |own: &pylon::simulate::scenario::Noise| {
        (own.white.powi(2) / 10.0 + own.wander.powi(2) + gps.wander.powi(2) + gps.white.powi(2)).sqrt()
    };
    let mut effects = Vec::new();
    let mut noise_m = noise(baro);
    match &case.kind {
        Kind::Effects(drawn) => {
            let mut random = ChaCha8Rng::seed_from_u64(case.seed ^ 0x5eed);
            for (id, time_constant_s, size) in drawn {
                let unit = unit(*id, *time_constant_s);
                noise_m = if id.name().starts_with("imu") { noise(imu) } else { noise(baro) };
                let spread =
                    spread(&regressor(&unit, &truth.trajectory, scenario.latitude_deg), &truth.trajectory);
                if spread < 1e-9 {
                    continue;
                }
                let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
                // Nature limits the coefficient; a level flight can't be made to show everything.
                let coefficient = natural(*id, sign * size * noise_m / spread, &mut random);
                effects.push((Effect { coefficient, ..unit }, coefficient.abs() * spread));
            }
            effects.sort_by(|a, b| b.1.total_cmp(&a.1));
            scenario.effect = effects.iter().map(|(effect, _)| *effect).collect();
        }
        Kind::SmoothedGps(time_s) => scenario.sensors.gps.smoothing_s = *time_s,
        Kind::Null | Kind::Outside(..) | Kind::Glitch(_) => {}
    }
    if let Some(planned) = planned {
        scenario.free_flight.clone_from(&planned.free_flight);
        scenario.captive = Captive { settling_s: scenario.captive.settling_s, ..planned.captive };
    }
    let (mut flight, truth) = simulate(&scenario, seed).map_err(|error| anyhow::anyhow!("{error}"))?;
    match &case.kind {
        Kind::Outside(outside, size) => {
            if outside.is_inertial() {
                noise_m = noise(imu);
            }
            add_outside(&mut flight, &truth.trajectory, *outside, size * noise_m)?;
        }
        Kind::Glitch(jump_m) => {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let free_s = scenario.captive.duration_s..scenario.duration_s();
            add_glitch(&mut flight, &truth.trajectory, free_s, *jump_m, &mut random)?;
        }
        Kind::Null | Kind::Effects(_) | Kind::SmoothedGps(_) => {}
    }
    flight.channels.retain(|(channel, _)| !case.missing.contains(&channel.name()));
    Ok(Flown { flight, effects, noise_m })
}

/// One unit of an effect.
pub(super) fn unit(id: EffectId, time_constant_s: Option<f64>) -> Effect {
    Effect { id, coefficient: 1.0, phase: phase(id), time_constant_s, width_m: None }
}

/// Adds a cause from outside the catalogue, with that rms in free flight, metres.
pub(super) fn add_outside(
    flight: &mut Flight,
    truth: &[TruthSample],
    outside: Outside,
    size_m: f64,
) -> anyhow::Result<()> {
    let shape = outside.shape(truth);
    let spread = spread(&shape, truth);
    let scale = if spread > 1e-9 { size_m / spread } else { 0.0 };
    let channel = if outside.is_inertial() { Channel::ImuSlaveAltM } else { Channel::BaroPa };
    add(flight, channel, &shape, scale)
}

/// Adds a jump of the receiver that ends within seconds, somewhere in free flight.
pub(super) fn add_glitch(
    flight: &mut Flight,
    truth: &[TruthSample],
    free_s: Range<f64>,
    jump_m: f64,
    random: &mut impl Rng,
) -> anyhow::Result<()> {
    let start_s = free_s.start + (free_s.end - free_s.start) * random.random_range(0.1..0.8);
    let end_s = start_s + random.random_range(1.0..8.0);
    let is_off = |sample: &TruthSample| (start_s..end_s).contains(&sample.time_s);
    let shape: Vec<f64> = truth.iter().map(|sample| f64::from(u8::from(is_off(sample)))).collect();
    add(flight, Channel::GpsAltM, &shape, jump_m)
}

/// The drawn coefficient if nature allows it; otherwise one within nature's limits, with the same sign where
/// that is possible.
pub(super) fn natural(id: EffectId, drawn: f64, random: &mut impl Rng) -> f64 {
    let known = kf_core::effect::EffectId::from_name(id.name());
    let [least, most] = known.map_or([-1.0, 1.0], kf_core::effect::EffectId::plausible).map(f64::from);
    let drawn = if least < 0.0 { drawn } else { drawn.abs() };
    let limit = if drawn < 0.0 { least } else { most };
    if (least..=most).contains(&drawn) { drawn } else { limit * random.random_range(0.3..1.0) }
}

/// The phase in which an effect acts, by the catalogue's definition of its clock.
const fn phase(id: EffectId) -> InjectionPhase {
    match id {
        EffectId::BaroWarmUp
        | EffectId::BaroDrift
        | EffectId::ImuVelocityError
        | EffectId::ImuAccelBias
        | EffectId::ImuAccelScale
        | EffectId::ImuTilt
        | EffectId::ImuGyroBias
        | EffectId::ImuVibration
        | EffectId::ImuGravityGradient
        | EffectId::ImuEotvos => InjectionPhase::Free,
        _ => InjectionPhase::Both,
    }
}

/// Rms of a shape in free flight, about its mean in captive flight.
pub(crate) fn spread(shape: &[f64], flight: &[TruthSample]) -> f64 {
    let of = |captive: bool| {
        shape.iter().zip(flight).filter(move |(_, sample)| sample.captive == captive).map(|(value, _)| *value)
    };
    let count = of(true).count().max(1) as f64;
    let origin = of(true).sum::<f64>() / count;
    let free = of(false).count().max(1) as f64;
    (of(false).map(|value| (value - origin).powi(2)).sum::<f64>() / free).sqrt()
}

/// Adds metres to a column; a pressure falls by their weight of air.
pub(crate) fn add(flight: &mut Flight, channel: Channel, shape: &[f64], scale: f64) -> anyhow::Result<()> {
    let column = flight.channel(channel).with_context(|| channel.name())?;
    let mut changed = Column::with_capacity(column.len());
    for (row, metres) in shape.iter().enumerate() {
        let cell = column.get(row).map(|value| {
            if channel == Channel::BaroPa {
                let altitude_m = kf_core::atmosphere::pressure_altitude_m(value).map_or(f64::NAN, f64::from);
                let target_m = altitude_m + scale * metres;
                // The standard atmosphere's pressure at an altitude, by inverting its altitude.
                (101_325.0 * (1.0 - target_m / 44_330.769).powf(5.255_88)) as f32
            } else {
                value + (scale * metres) as f32
            }
        });
        changed.push(cell);
    }
    if changed.len() != column.len() {
        bail!("a shape of {} rows for a column of {}", changed.len(), column.len());
    }
    flight.set_channel(channel, changed);
    Ok(())
}
