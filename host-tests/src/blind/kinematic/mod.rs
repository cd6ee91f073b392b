//! A second family of simulated flights, which shares nothing with `pylon simulate` except the record of the
//! truth: other motion (kinematics), the effects by their physics, and noise that the estimator does not
//! assume. It guards against DESIGN.md's inverse crime.

mod disturbance;
mod instruments;
mod path;
mod physics;

use pylon::simulate::Scenario;
use pylon::simulate::scenario::Effect;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::draw::{Case, Family, Kind, kind, missing, plan};
use super::flight::{Flown, add_glitch, add_outside, natural, spread, unit};
use instruments::{Instruments, Recorded, record};
use path::{Airframe, Course, STEP_S};

/// Columns that a flight may lack, with the chance per hundred.
const MAY_BE_MISSING: [(&[&str], u32); 7] = [
    (&["aoa_rad", "sideslip_rad"], 30),
    (&["tas_mps"], 10),
    (&["throttle"], 15),
    (&["baro_temp_c"], 20),
    (&["oat_c"], 40),
    (&["imu_master_alt_m"], 40),
    (&["sideslip_rad"], 10),
];

/// Draws a trial of this family.
pub(super) fn draw(seed: u64) -> Case {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6b69_6e65);
    let plan = plan(&mut random);
    let kind = kind(&mut random);
    let missing = missing(&MAY_BE_MISSING, &mut random);
    let scenario = format!("kinematic family, seed {seed}\n");
    Case { family: Family::Kinematic, seed, kind, plan, scenario, missing }
}

/// Flies a case of this family; another `number` flies the same aircraft in other air on another path, which
/// is the `planned` one if there is one.
///
/// # Errors
/// If a column is missing.
pub(super) fn fly(case: &Case, number: u64, planned: Option<&Scenario>) -> anyhow::Result<Flown> {
    let mut aircraft = ChaCha8Rng::seed_from_u64(case.seed.wrapping_mul(1000) ^ 0x61_6972);
    let airframe = Airframe::draw(&mut aircraft);
    let mut instruments = Instruments::draw(&mut aircraft);
    let air = |number: u64| ChaCha8Rng::seed_from_u64(case.seed.wrapping_mul(1000).wrapping_add(number));
    if let Kind::SmoothedGps(time_s) = case.kind {
        instruments.smooth(time_s);
    }
    // The coefficients are always computed from the first flight.
    let mut random = air(0);
    let first = path::fly(&airframe, Course::Drawn(case.plan), &mut random);
    let Recorded { noise_m, .. } = record(&first, &[], &instruments, &mut random);
    let mut effects: Vec<(Effect, f64)> = Vec::new();
    if let Kind::Effects(drawn) = &case.kind {
        for (id, time_constant_s, size) in drawn {
            let unit = unit(*id, *time_constant_s);
            let spread = spread(&physics::unit_m(&unit, &first), &first);
            if spread < 1e-9 {
                continue;
            }
            let own_noise_m = noise_m[usize::from(id.name().starts_with("imu."))];
            let sign = if aircraft.random::<bool>() { -1.0 } else { 1.0 };
            let coefficient = natural(*id, sign * size * own_noise_m / spread, &mut aircraft);
            effects.push((Effect { coefficient, ..unit }, coefficient.abs() * spread / own_noise_m));
        }
        effects.sort_by(|a, b| b.1.total_cmp(&a.1));
    }
    let acting: Vec<Effect> = effects.iter().map(|(effect, _)| *effect).collect();
    let (truth, mut random) = if number == 0 {
        (first, air(0x1000))
    } else {
        let mut random = air(number);
        let course = planned.map_or(Course::Drawn(case.plan), Course::Planned);
        (path::fly(&airframe, course, &mut random), random)
    };
    let mut flight = record(&truth, &acting, &instruments, &mut random).flight;
    match &case.kind {
        Kind::Outside(outside, size) => {
            let own_noise_m = noise_m[usize::from(outside.is_inertial())];
            add_outside(&mut flight, &truth, *outside, size * own_noise_m)?;
        }
        Kind::Glitch(jump_m) => {
            let captive_s = truth.iter().filter(|row| row.captive).count() as f64 * STEP_S;
            let end_s = truth.len() as f64 * STEP_S;
            add_glitch(&mut flight, &truth, captive_s..end_s, *jump_m, &mut random)?;
        }
        Kind::Null | Kind::Effects(_) | Kind::SmoothedGps(_) => {}
    }
    flight.channels.retain(|(channel, _)| !case.missing.contains(&channel.name()));
    for (effect, _) in &mut effects {
        effect.coefficient /= instruments.effective(effect.id);
    }
    // Sizes are already relative to each effect's own noise.
    Ok(Flown { flight, effects, noise_m: 1.0 })
}
