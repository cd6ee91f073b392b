//! The flight whose telemetry is tested, and how it is flown.
// Each test file uses only part of this.
#![allow(dead_code, clippy::unwrap_used)]

use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::output::TickOutput;
use model::Model;
use pylon::fly::{Downlinked, FlyOptions, FlyReport, PlantedError, fly_inputs};

use crate::ticks::{LAUNCH, TICK_US, flight, must, prompt};

/// One estimated effect, so that coefficients are sent too.
pub fn model() -> Model {
    prompt(
        Model::parse("[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 0.05\nestimate = true\n").unwrap(),
    )
}

/// The flight of `ticks`, with outside air and one invalid inertial altitude. From 21.2 to 29 s there is no
/// fix, and from 27 s on the inertial altitude, until then without error, is 30 m too high.
pub fn inputs() -> Vec<TickInput> {
    let mut inputs = flight();
    for (k, input) in inputs.iter_mut().enumerate() {
        input.signals.outside_air_temperature_c = (k % 200 == 7).then_some(-4.5 + k as f32 * 1e-4);
        if (4_041..5_600).contains(&k) {
            input.gps = None;
        }
        let free_s = k.saturating_sub(LAUNCH) as f32 * 0.005;
        let error_m = free_s * free_s - if (5_200..5_600).contains(&k) { 30.0 } else { 0.0 };
        input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m - error_m);
    }
    // The dive has its full rate from the first tick on.
    inputs[LAUNCH].gps.as_mut().unwrap().velocity_down_mps = Some(30.0);
    inputs[3_002].imu_slave_altitude_m = Some(f32::NAN);
    inputs
}

/// The tick at a time, microseconds.
pub fn tick_of(time_us: i64) -> usize {
    (time_us as u64 - 1_000_000).div_euclid(TICK_US) as usize
}

/// A tick with the host estimator's results.
pub struct Tick {
    pub input: TickInput,
    pub output: TickOutput,
    pub counters: Counters,
}

/// All ticks, and the latch.
pub fn ticks() -> (Vec<Tick>, LatchRecord) {
    let mut mission = pylon::replay::mission(&model()).unwrap();
    let ticks = inputs()
        .into_iter()
        .map(|input| Tick { input, output: mission.tick(&input), counters: *mission.counters() })
        .collect();
    (ticks, mission.latch().unwrap().clone())
}

/// Flies it in QEMU, without chips.
pub fn fly(target_error: Option<PlantedError>) -> (FlyReport, Downlinked) {
    let options = FlyOptions { telemetry: true, target_error, ..FlyOptions::default() };
    let mut report = must(fly_inputs(inputs().into_iter(), &model(), &options));
    let telemetry = report.telemetry.take().unwrap();
    (report, telemetry)
}
