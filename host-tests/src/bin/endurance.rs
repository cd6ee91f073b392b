//! Many flights, and long ones, through the emulated flight computer: `cargo xtask endurance`.

use std::process::ExitCode;

use anyhow::{Context as _, ensure};
use clap::{Parser, Subcommand};
use host_tests::blind::{Family, draw, fly as fly_trial};
use host_tests::endurance::LongFlight;
use indicatif::{ProgressBar, ProgressStyle};
use kf_core::sensor::Sensor;
use model::Model;
use pylon::fly::{FlyOptions, FlyReport, SensorSource, fly, fly_inputs};
use pylon::replay::Replay;

/// Fly long simulated flights, and many, through the emulated flight computer, and compare every tick with
/// the host's, bit for bit.
#[derive(Debug, Parser)]
#[command(name = "endurance")]
struct Arguments {
    #[command(subcommand)]
    job: Job,
}

#[derive(Debug, Subcommand)]
enum Job {
    /// Hours of captive flight without a pause, then a launch.
    Captive {
        /// Number of hours.
        #[arg(long, default_value_t = 10.0)]
        hours: f64,
    },
    /// Random flights of the blind trials, on models of the sensors' chips.
    Random {
        /// Number of flights.
        #[arg(long, default_value_t = 50)]
        flights: u64,
        /// Seed of the first flight; each further flight adds one.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().job {
        Job::Captive { hours } => captive(hours),
        Job::Random { flights, seed } => random(flights, seed),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn captive(hours: f64) -> anyhow::Result<()> {
    ensure!(hours > 0.02 && hours < 1_000.0, "--hours: between 0.02 and 1000, not {hours}");
    let bar = ProgressBar::new_spinner().with_message(format!("{hours} h of captive flight in QEMU"));
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let flight = LongFlight::new(hours);
    let report = fly_inputs(flight.clone(), &Model::default(), &FlyOptions::default())?;
    bar.finish_and_clear();
    println!(
        "{hours} h captive and a minute free, simulated: {} ticks, each bit for bit the host's\n{}",
        report.ticks,
        costs(&report)
    );
    ensure!(
        u64::from(report.ticks) == flight.ticks(),
        "{} ticks were flown of {}",
        report.ticks,
        flight.ticks()
    );
    let latch = report.latch.context("the flight did not latch")?;
    for (sensor, true_m) in [Sensor::ImuSlave, Sensor::Baro].into_iter().zip(flight.biases_m()) {
        let latched = &latch.sensors[sensor.index()];
        let sigma_m = f64::from(latched.bias_variance_m2).sqrt();
        let off = (f64::from(latched.bias_m) - true_m) / sigma_m;
        println!(
            "{}: latched bias {:.3} m, true {true_m:.3} m: {off:+.1} of its standard errors ({sigma_m:.3} m)",
            sensor.name(),
            latched.bias_m
        );
        // The chance of a larger one is one in 16,000.
        ensure!(off.abs() < 4.0, "the bias has drifted");
    }
    Ok(())
}

fn random(flights: u64, seed: u64) -> anyhow::Result<()> {
    let bar = ProgressBar::new(flights)
        .with_message("random flights in QEMU")
        .with_style(ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")?);
    let model = Model::default();
    let (mut flown, mut ticks, mut latched, mut next) = (0, 0_u64, 0, seed);
    while flown < flights {
        // A plan that the aircraft can't fly does not count; the next seed has another.
        let trial = fly_trial(&draw(Family::Dynamic, next), 0);
        next += 1;
        let Ok(trial) = trial else { continue };
        let replay = Replay::new(&trial.flight, &model, None)?;
        let options = FlyOptions { sensors: SensorSource::Chips, ..FlyOptions::default() };
        let report = fly(&replay, &options).with_context(|| format!("seed {}", next - 1))?;
        ticks += u64::from(report.ticks);
        latched += u64::from(report.latch.is_some());
        flown += 1;
        bar.inc(1);
    }
    bar.finish_and_clear();
    println!(
        "{flown} random flights, simulated (seeds {seed} to {}), through the chips' registers: {ticks} ticks, each bit for \
         bit the host's; {latched} latched, the same bits on both",
        next - 1
    );
    Ok(())
}

fn costs(report: &FlyReport) -> String {
    format!(
        "{:.0} instructions a tick, {} at worst; input late at {} timer ticks, results waited at {}; stack {} of {} bytes",
        report.instructions_mean,
        report.instructions_worst,
        report.underruns,
        report.stalls,
        report.stack_used_bytes,
        report.stack_size_bytes
    )
}
