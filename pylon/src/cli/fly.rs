//! `pylon fly`.

use clap::Args;
use pylon::fly::{Difference, FlyError, FlyOptions, FlyReport, fly};
use pylon::replay::Replay;
use serde_json::{Value, json};

use super::failure::Failure;
use super::one_flight::OneFlight;
use super::progress::while_busy;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon fly flight.csv
      fly it through the firmware, emulated by QEMU, and compare every tick with the host's bits
  pylon fly flight.csv --model improved.toml --json

Exit status: 0 every bit is the same; 1 bits differ; 2 bad usage or bad input, or no emulator.";

/// Fly a flight through the firmware in QEMU and compare with the host, bit for bit
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    what: OneFlight,
    /// Give the host's mission every barometer reading one unit in the last place off: to see that
    /// it is found
    #[arg(long, hide = true)]
    plant_host_error: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = load::model(&arguments.what.model)?;
    let (flight, notes) = load::flight(&arguments.what.flight)?;
    load::write_notes(&notes);
    let replay = Replay::new(&flight, &model, arguments.what.calibrate)
        .map_err(|error| Failure::input(format!("{}: {error}", arguments.what.flight.display())))?;
    let file = arguments.what.flight.display();
    let options = FlyOptions { host_ulp_error: arguments.plant_host_error, ..FlyOptions::default() };
    let report = while_busy("flying in QEMU", || fly(&replay, &options)).map_err(|error| {
        let line = format!("{file}: {error}");
        let FlyError::Differs(difference) = error else { return Failure::input(line) };
        if arguments.what.json
            && let Err(failure) = put_json(&difference_json(&difference))
        {
            return failure;
        }
        Failure::differs(line)
    })?;
    if arguments.what.json {
        return put_json(&report_json(&report));
    }
    terminal::put(&text(&file.to_string(), &report))
}

fn text(file: &str, report: &FlyReport) -> String {
    let mut text = format!(
        "{file}: the emulated flight computer and the host agree to the bit in all {} ticks\n  \
         instructions a tick  {:.1} mean, {} worst (at {:.3} s)\n  \
         stack                {} of {} bytes used\n  \
         image                {} bytes of flash, {} bytes of static RAM\n",
        report.ticks,
        report.instructions_mean,
        report.instructions_worst,
        report.worst_time_us as f64 * 1e-6,
        report.stack_used_bytes,
        report.stack_size_bytes,
        report.flash_bytes,
        report.static_ram_bytes,
    );
    for part in &report.parts {
        text.push_str(&format!(
            "    {:<19}{:.1} mean, {} worst\n",
            part.part.name(),
            part.instructions_mean,
            part.instructions_worst
        ));
    }
    match &report.latch {
        Some(latch) => {
            text.push_str(&format!(
                "  latched              at {:.3} s, the same record on both\n",
                latch.time_us as f64 * 1e-6
            ));
        }
        None => text.push_str("  latched              nothing: no launch\n"),
    }
    if report.underruns > 0 || report.stalls > 0 {
        text.push_str(&format!(
            "  waited               {} timer ticks for input, {} for room for results\n",
            report.underruns, report.stalls
        ));
    }
    text
}

fn put_json(value: &Value) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    terminal::put(&text)
}

fn difference_json(difference: &Difference) -> Value {
    json!({
        "bit_for_bit": false,
        "ticks": difference.ticks,
        "ticks_that_differ": difference.ticks_that_differ,
        "first": {
            "tick": difference.tick,
            "time_s": difference.time_us as f64 * 1e-6,
            "field": difference.field,
            "host": difference.host,
            "target": difference.target,
        },
    })
}

fn report_json(report: &FlyReport) -> Value {
    json!({
        "bit_for_bit": true,
        "ticks": report.ticks,
        "instructions_mean": report.instructions_mean,
        "instructions_worst": report.instructions_worst,
        "parts": report.parts.iter().map(|part| (part.part.name().to_owned(), json!({
            "instructions_mean": part.instructions_mean,
            "instructions_worst": part.instructions_worst,
        }))).collect::<serde_json::Map<_, _>>(),
        "worst_time_s": report.worst_time_us as f64 * 1e-6,
        "stack_used_bytes": report.stack_used_bytes,
        "stack_size_bytes": report.stack_size_bytes,
        "flash_bytes": report.flash_bytes,
        "static_ram_bytes": report.static_ram_bytes,
        "underruns": report.underruns,
        "stalls": report.stalls,
        "latched_s": report.latch.as_ref().map(|latch| latch.time_us as f64 * 1e-6),
        "log": report.log,
    })
}
