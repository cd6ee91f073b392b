//! A healthy flight is not flagged: `flights/clean.toml` (simulated, without any effect) with the default
//! preset, over seeds.
//!
//! `cargo test -p host-tests --release --test healthy_flights -- --nocapture` prints the results.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use kf_core::output::Trust;
use kf_core::quality::{Check, FailedChecks};
use kf_core::sensor::Sensor;
use model::Model;
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};

const SEEDS: u64 = 40;

#[test]
fn healthy_sensors_stay_trusted_and_their_calibration_is_good() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/clean.toml");
    let scenario = load_scenario(&file).unwrap();
    let model = Model::default();
    let (mut untrustworthy, mut doubtful, mut degraded, mut misjudged) = (0, 0, 0, 0);
    for seed in 0..SEEDS {
        let (flight, truth) = simulate(&scenario, seed).unwrap();
        let replay = Replay::new(&flight, &model, None).unwrap();
        let mut trust = [Trust::Calibrating; 3];
        let mut checks = FailedChecks::default();
        let mut biases = [(0.0, 0.0); 3];
        replay
            .run(&mut |_, output| {
                trust = output.sensors.map(|sensor| sensor.trust);
                checks = FailedChecks::from_bits(output.failed_checks);
                biases = output.sensors.map(|sensor| (sensor.bias_m, sensor.bias_variance_m2));
            })
            .unwrap();
        let watched = [trust[Sensor::ImuSlave.index()], trust[Sensor::Baro.index()]];
        untrustworthy += u32::from(watched.contains(&Trust::Untrustworthy));
        doubtful += u32::from(watched.iter().any(|t| matches!(t, Trust::Doubtful | Trust::Untrustworthy)));
        degraded += u32::from(!checks.is_empty());
        for sensor in Sensor::ALL {
            let (bias_m, variance_m2) = biases[sensor.index()];
            let apart = f64::from(bias_m) - truth.sensors[sensor.name()].bias_m;
            misjudged += u32::from(apart * apart > 4.0 * f64::from(variance_m2));
        }
        if !checks.is_empty() {
            println!("seed {seed}: {:?}", checks.iter().map(Check::name).collect::<Vec<_>>());
        }
    }
    println!(
        "of {SEEDS} healthy flights: {untrustworthy} with an untrustworthy sensor, {doubtful} with a doubtful one, \
         {degraded} with a failed check; of {} biases {misjudged} beyond two sigma",
        3 * SEEDS
    );
    // The wander dominates: one error of one sigma, nearly constant over the flight, against a bound of
    // three. 5 % of flights would be 2 of 40; at 7 %, 7 or more of 40 would occur once in 100 such sets.
    assert!(untrustworthy <= 6, "{untrustworthy}");
    assert!(degraded <= 6, "{degraded}");
    // Sigma is honest if 5 % are beyond two sigma: 6 of 120, and because the three biases share the
    // reference, at most three sigma of 40 independent ones.
    assert!(misjudged <= 18, "{misjudged}");
}
