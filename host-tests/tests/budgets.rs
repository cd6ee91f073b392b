//! The firmware keeps its budgets (`firmware/budgets.toml`).
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used, clippy::panic)]

use host_tests::bench;
use host_tests::budget::{Budgets, Check};
use kf_core::input::{BaroReading, GpsFix, TickInput};
use model::Model;
use pylon::fly::{FlyOptions, fly_inputs};

fn assert_kept(checks: &[Check]) {
    let broken: Vec<&Check> = checks.iter().filter(|check| !check.kept).collect();
    assert!(broken.is_empty(), "{broken:#?}");
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
    // 15 s captive and 5 s free, with everything new at every tick: the dearest ticks there are.
    let inputs = (0..4_000_u64).map(|k| TickInput {
        time_us: k * 5_000,
        launch: k >= 3_000,
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
    });
    for (name, model) in [("default model", Model::default()), ("paper model", Model::paper())] {
        let model = Model { settling_s: 1.0, ..model };
        let report = fly_inputs(inputs.clone(), &model, &FlyOptions::default())
            .unwrap_or_else(|error| panic!("{error}"));
        assert!(report.latch.is_some());
        assert_kept(&budgets.check_flight(name, &report));
    }
}
