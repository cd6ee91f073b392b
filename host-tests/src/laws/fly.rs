//! A trial's flight.

use pylon::flight::{Channel, Column, Flight};
use pylon::simulate::{Scenario, simulate};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::draw::Case;
use super::hidden::Moment;
use crate::blind::flight::{add, spread};
use crate::real_trials::noise::{heavy, steps, wander};

/// Quantity that a column measures.
type Signal = fn(&Moment) -> f64;

/// A flown trial.
#[derive(Clone, Debug)]
pub struct Flown {
    /// The flight that the search sees.
    pub flight: Flight,
    /// What the hidden law adds to the barometer at every row, metres.
    pub true_m: Vec<f64>,
    /// Whether the row is in captive flight.
    pub captive: Vec<bool>,
}

/// Flies a case; another `number` gives another flight of the same aircraft with the same coefficient, in
/// other air and with another motion of the flap.
///
/// # Errors
/// If the aircraft can't fly the plan.
pub fn fly(case: &Case, number: u64) -> anyhow::Result<Flown> {
    let scenario = Scenario::from_toml(&case.scenario, "laws")?;
    let first = made(case, &scenario, 0)?;
    let scale = case.hidden.map_or(0.0, |(hidden, size)| {
        let spread = spread(&hidden.shape(&first.moments), &first.truth);
        let noise_m = case.noise_m.iter().map(|m| m * m).sum::<f64>().sqrt();
        if spread > 1e-9 { size * noise_m / spread } else { 0.0 }
    });
    let this = if number == 0 { first } else { made(case, &scenario, number)? };
    let shape =
        case.hidden.map_or_else(|| vec![0.0; this.moments.len()], |(hidden, _)| hidden.shape(&this.moments));
    let true_m: Vec<f64> = shape.iter().map(|value| scale * value).collect();
    let mut flight = this.flight;
    let mut random = ChaCha8Rng::seed_from_u64(case.seed.wrapping_mul(977).wrapping_add(number));
    let [gps_m, baro_m, fast_m] = case.noise_m;
    let times = flight.time_s.clone();
    let rows = times.len();
    let of_baro: Vec<f64> = [
        wander(&mut random, &times, 0.8 * baro_m, 40.0, 900.0),
        steps(&mut random, &times, 0.3 * baro_m, 200.0),
        heavy(&mut random, rows, 3.0 * fast_m, 4.0, 1),
    ]
    .iter()
    .fold(true_m.clone(), |sum, part| sum.iter().zip(part).map(|(a, b)| a + b).collect());
    add(&mut flight, Channel::BaroPa, &of_baro, 1.0)?;
    let of_gps: Vec<f64> = [
        wander(&mut random, &times, 0.9 * gps_m, 60.0, 1500.0),
        steps(&mut random, &times, 0.2 * gps_m, 300.0),
        heavy(&mut random, rows, 0.2, 3.0, 1),
    ]
    .iter()
    .fold(vec![0.0; rows], |sum, part| sum.iter().zip(part).map(|(a, b)| a + b).collect());
    add(&mut flight, Channel::GpsAltM, &of_gps, 1.0)?;
    Ok(Flown { flight, true_m, captive: this.truth.iter().map(|sample| sample.captive).collect() })
}

struct Made {
    flight: Flight,
    truth: Vec<pylon::simulate::TruthSample>,
    moments: Vec<Moment>,
}

/// The flight without law and noise, with the columns that the workbench does not know, which are recorded
/// ten times a second with noise.
fn made(case: &Case, scenario: &Scenario, number: u64) -> anyhow::Result<Made> {
    let seed = case.seed.wrapping_mul(1000).wrapping_add(number);
    let (mut flight, truth) = simulate(scenario, seed).map_err(|error| anyhow::anyhow!("{error}"))?;
    let truth = truth.trajectory;
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xf1a9);
    let (mut flap, mut wanted, mut next_s, mut rpm) = (0.0_f64, 0.0, 20.0, 3000.0_f64);
    let (mut bay_c, mut heater, mut switch_s) = (25.0_f64, 0.0, 30.0);
    let mut last_s = 0.0;
    let mut moments = Vec::with_capacity(truth.len());
    for sample in &truth {
        let step_s = sample.time_s - last_s;
        last_s = sample.time_s;
        if sample.time_s > next_s {
            wanted = if random.random::<bool>() { random.random_range(0.0..1.0) } else { 0.0 };
            next_s = sample.time_s + random.random_range(6.0..25.0);
        }
        flap += (wanted - flap).clamp(-0.3 * step_s, 0.3 * step_s);
        rpm += step_s / 0.8 * (2800.0 + 2600.0 * sample.throttle - rpm);
        if sample.time_s > switch_s {
            heater = if heater > 0.0 { 0.0 } else { random.random_range(15.0..35.0) };
            switch_s = sample.time_s + random.random_range(25.0..60.0);
        }
        bay_c += step_s / 25.0 * (25.0 + heater - bay_c);
        moments.push(Moment {
            time_s: sample.time_s,
            euler_rad: sample.euler_rad,
            rate_radps: sample.rate_radps,
            airspeed_mps: sample.airspeed_mps,
            throttle: sample.throttle,
            baro_temperature_c: sample.baro_temperature_c,
            flap,
            rpm,
            bay_c,
        });
    }
    let columns: [(&str, f64, Signal); 3] = [
        ("flap", 0.01, |now| now.flap),
        ("motor_rpm", 15.0, |now| now.rpm),
        ("bay_temp_c", 0.2, |now| now.bay_c),
    ];
    for (name, noise, of) in columns {
        let mut column = Column::with_capacity(moments.len());
        let mut due_s = 0.0;
        for now in &moments {
            let is_due = now.time_s >= due_s;
            if is_due {
                due_s += 0.1;
            }
            let white: f64 = StandardNormal.sample(&mut random);
            column.push(is_due.then(|| (of(now) + noise * white) as f32));
        }
        flight.extra.push((name.to_owned(), column));
    }
    Ok(Made { flight, truth, moments })
}
