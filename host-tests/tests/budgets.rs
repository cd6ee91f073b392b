//! The firmware meets its budgets (`firmware/budgets.toml`).
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it). `cargo test -p host-tests --test budgets -- --show-output` prints the
//! measurements.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use host_tests::bench;
use host_tests::budget::{self, Budgets, Check};
use kf_core::input::{BaroReading, GpsFix, LaunchDoubt, TickInput};
use model::Model;
use pylon::fly::{FlyOptions, FlyReport, SensorSource, fly_inputs};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};

fn assert_kept(checks: &[Check]) {
    for check in checks {
        println!("{}", check.line());
    }
    let unexpected = Budgets::read().unwrap().unexpected(checks);
    assert!(unexpected.is_empty(), "{unexpected:#?}");
}

#[test]
fn images_keep_their_budgets() {
    assert_kept(&Budgets::read().unwrap().check_images().unwrap_or_else(|error| panic!("{error:#}")));
}

#[test]
fn the_tick_keeps_its_instructions() {
    let rows = bench::run().unwrap_or_else(|error| panic!("{error:#}"));
    assert!(rows.iter().all(|row| row.agrees != Some(false)), "{rows:#?}");
    assert_kept(&Budgets::read().unwrap().check_bench(&rows).unwrap());
}

#[test]
fn a_flight_keeps_its_stack_and_instructions() {
    let budgets = Budgets::read().unwrap();
    // 15 s captive and 5 s free, with everything new at every tick; the flights on chips include the drivers
    // and the strapdown channel.
    let inputs = |suspected_ticks| {
        (0..4_000_u64).map(move |k| TickInput {
            time_us: k * 5_000,
            launch: k >= 3_000,
            launch_doubt: match k {
                3_000.. => LaunchDoubt::None,
                _ if k + suspected_ticks >= 3_000 => LaunchDoubt::Suspected,
                _ => LaunchDoubt::None,
            },
            gps: Some(GpsFix {
                altitude_m: 2_000.0 + (k % 7) as f32,
                velocity_north_mps: Some(60.0),
                velocity_east_mps: Some(1.0),
                velocity_down_mps: Some((k % 3) as f32),
                ..GpsFix::default()
            }),
            baro: Some(BaroReading::PressurePa(79_000.0 + (k % 11) as f32)),
            imu_master_altitude_m: Some(2_010.0 + (k % 13) as f32),
            imu_slave_altitude_m: Some(1_930.0 + (k % 17) as f32),
            ..TickInput::default()
        })
    };
    let mut checks = Vec::new();
    for (name, model) in budget::models().unwrap() {
        // In a recording the launch comes without warning, and one tick does all the work. With four effects
        // it is the board's launch, which is suspected for as long as the wire bounces (`kf_core::launch`).
        let suspected_ticks = if model.estimated_effects().count() == 0 { 0 } else { 4 };
        let model = Model { settling_s: 1.0, ..model };
        let report = fly_inputs(inputs(suspected_ticks), &model, &FlyOptions::default())
            .unwrap_or_else(|error| panic!("{error}"));
        assert!(report.latch.is_some());
        checks.extend(budgets.check_flight(name, &report));
    }
    assert_kept(&checks);
}

/// `flights/quickstart.toml` (simulated) through the chips and their drivers, with or without a unit of its
/// own for `imu_slave`.
fn quickstart(model: &Model, has_slave: bool) -> FlyReport {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/quickstart.toml");
    let scenario = load_scenario(&file).unwrap();
    let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
    let replay = Replay::new(&flight, model, None).unwrap();
    let inputs = replay.inputs().map(|input| TickInput {
        imu_slave_altitude_m: input.imu_slave_altitude_m.filter(|_| has_slave),
        ..input
    });
    let options = FlyOptions { sensors: SensorSource::Chips, ..FlyOptions::default() };
    let report = fly_inputs(inputs, model, &options).unwrap_or_else(|error| panic!("{error}"));
    println!("{} instructions a tick, {} at worst", report.instructions_mean, report.instructions_worst);
    for part in &report.parts {
        println!("  {}: {}, {}", part.part.name(), part.instructions_mean, part.instructions_worst);
    }
    report
}

/// The whole tick: drivers, launch, strapdown channel as `imu_slave`, estimator, telemetry, mark.
#[test]
fn flights_on_chips_keep_their_stack_and_instructions() {
    let budgets = Budgets::read().unwrap();
    let mut checks = Vec::new();
    for (name, model) in budget::models().unwrap() {
        for has_slave in [true, false] {
            let name = format!(
                "{name} model, {}",
                if has_slave { "a unit's imu_slave" } else { "strapdown channel" }
            );
            println!("{name}:");
            let report = quickstart(&model, has_slave);
            let latch = report.latch.as_ref().unwrap();
            assert!(latch.sensors[1].readings > 1_000, "{name}: it delivers");
            let effects = model.estimated_effects().count();
            assert_eq!(latch.state.len(), 4 + effects, "{name}");
            checks.extend(budgets.check_flight(&name, &report));
        }
    }
    assert_kept(&checks);
}
