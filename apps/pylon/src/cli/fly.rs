//! `pylon fly`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use pylon::export::tlog;
use pylon::fly::{
    ChipsReport, CostUnit, DebugLink, FlownOn, FlyError, FlyOptions, FlyReport, PlannedFault, SensorSource,
    fly,
};
use pylon::output_file::write_atomically;
use pylon::replay::Replay;
use pylon::results::{FlyAgreement, FlyDifference, FlyResult};

use super::failure::Failure;
use super::one_flight::OneFlight;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::{while_busy, while_telling};
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon fly flight.csv
      fly it through the firmware, emulated by QEMU, on models of the sensors' chips and their drivers, and compare
      every tick with the host's bits
  pylon fly flight.csv --model improved.toml --json
  pylon fly flight.csv --telemetry flight.tlog
      and record its telemetry, which the other commands read as a flight
  pylon fly flight.csv --record flight.record
      and keep its results; `import` turns them into a flight: what the flight computer saw
  pylon fly flight.csv --ideal-sensors
      without chips and drivers: the estimator gets the flight's rows unchanged
  pylon fly flight.csv --fault \"baro stuck-low 60..65\" --fault \"imu reset 70\"
      with a barometer whose data line hangs for 5 s and an inertial unit whose power dips; reports what that does to
      calibration, launch, flags and altitude, compared with the same flight without the faults
  pylon fly flight.csv --hil
      through an STM32F405 on an ST-LINK instead of QEMU (docs/bring-up.md); it needs openocd
  pylon fly flight.csv --hil --probe-config interface/cmsis-dap.cfg
      on a CMSIS-DAP probe

Faults (CHIP FAULT START..END, in seconds of the flight's time; those marked * happen once, at START):
  baro, imu       stuck-low, stuck-high, bus-error (the wires), stalled (no new samples)
  baro, imu, gps  frozen (old results, marked as new), offset=BY[,QUANTITY] (far beyond the range it saturates),
                  spike=BY[,RESULTS[,QUANTITY]] *, flip-data=MASK[,RESULTS[,QUANTITY]] * (in the chip), reset *
  all but wire    garbage=SEED (noise on its line), flip-bits=MASK[,AFTER] * (of one byte on the way)
  baro            slow=MICROSECONDS (conversions take this much longer), lose-conversions=COUNT *,
                  flip-prom=BYTE,MASK (of its calibration, as it is read)
  imu             flip-register=ADDRESS,MASK * (until it is written), vibration=HZ,AMPLITUDE[,QUANTITY]
  gps, umbilical  unplugged, lose-bytes=COUNT *
  gps             refuses, silent (to be configured, to acknowledge), no-fix, held (the last solution, with its time),
                  cold-start=METRES,SECONDS[,dishonest] (an altitude error that decays), generation-8=BAUD *,
                  flip-register=SETTING,1 * (until it is configured: 0 no solutions, 1 NMEA, 2 once a second)
  umbilical       silent (nothing is sent), stranger=METRES (another system sends an altitude too), lies=METRES (too
                  high), not-a-number, holds (repeats one altitude), torn (the whole cable, wire included)
  wire            open (broken), shorted, unreadable, bounces=MICROSECONDS (mean time open, and closed)
  BY and AMPLITUDE are in Pa, degrees, m/s^2, rad/s, m or m/s; QUANTITY is pressure, temperature; accel-x to -z,
  gyro-x to -z; altitude, velocity-north, -east, -down; without it pressure, accel-z or altitude.

Exit status: 0 every bit is the same; 1 bits differ; 2 bad usage or bad input, or no emulator,
probe or board.";

/// Fly a flight through the firmware, in QEMU or on a board, and compare it with the host bit for bit
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    what: OneFlight,
    /// Give the estimator the flight's rows directly, without sensor chips and drivers
    #[arg(long)]
    ideal_sensors: bool,
    /// Make a chip fail, such as "baro stuck-low 60..65" (may be repeated)
    #[arg(long = "fault", value_name = "FAULT", conflicts_with = "ideal_sensors")]
    faults: Vec<PlannedFault>,
    /// Write the emulated flight computer's telemetry, as a ground station records it
    #[arg(long, value_name = "TLOG", conflicts_with = "hil")]
    telemetry: Option<PathBuf>,
    /// Write the flight computer's results (a flight record) as a recorder on a board's results port would;
    /// `pylon import` turns it into a flight
    #[arg(long, value_name = "RECORD")]
    record: Option<PathBuf>,
    /// Fly through an STM32F405 on a debug probe (hardware in the loop); its flash is written
    #[arg(long)]
    hil: bool,
    /// OpenOCD configuration file of the probe, one of OpenOCD's or yours (may be repeated) [default:
    /// interface/stlink.cfg]
    #[arg(long = "probe-config", value_name = "FILE", requires = "hil")]
    probe_configs: Vec<PathBuf>,
    /// Give the host's mission every barometer reading one unit in the last place off, to check that the
    /// difference is found
    #[arg(long, hide = true)]
    plant_host_error: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = [
        Role::new(&arguments.what.flight, "the flight"),
        Role::new(Path::new(&arguments.what.model), "the model"),
    ];
    let telemetry = arguments.telemetry.iter().map(|file| Role::new(file, "the telemetry"));
    let record = arguments.record.iter().map(|file| Role::new(file, "the record"));
    refuse_overwriting(&inputs, &telemetry.chain(record).collect::<Vec<_>>())?;
    let model = load::model(&arguments.what.model)?;
    let (flight, notes) = load::flight(&arguments.what.flight)?;
    load::write_notes(&notes);
    let replay = Replay::new(&flight, &model, arguments.what.times.given())
        .map_err(|error| Failure::input(format!("{}: {error}", arguments.what.flight.display())))?;
    let file = arguments.what.flight.display();
    load::write_unused_of(&file, &replay);
    let link = arguments.debug_link();
    let progress = Arc::clone(&link.progress);
    let options = FlyOptions {
        on: if arguments.hil { FlownOn::Board(link) } else { FlownOn::Emulator },
        sensors: if arguments.ideal_sensors { SensorSource::Ideal } else { SensorSource::Chips },
        faults: arguments.faults.clone(),
        host_ulp_error: arguments.plant_host_error,
        telemetry: arguments.telemetry.is_some(),
        record: arguments.record.is_some(),
        ..FlyOptions::default()
    };
    let doing = || match progress.so_far() {
        _ if !arguments.hil => "flying in QEMU".to_owned(),
        (_, 0) => "building the image".to_owned(),
        (0, _) => "writing the image to the board".to_owned(),
        (done, of) => format!("flying on the board: {done} of {of} ticks"),
    };
    let report = while_telling(doing, || fly(&replay, &options)).map_err(|error| {
        let line = format!("{file}: {error}");
        let FlyError::Differs(difference) = error else { return Failure::input(line) };
        if arguments.what.json
            && let Err(failure) = terminal::put_json(&FlyResult::Differs(FlyDifference::from(&*difference)))
        {
            return failure;
        }
        Failure::differs(line)
    })?;
    if let (Some(file), Some(telemetry)) = (&arguments.telemetry, &report.telemetry) {
        let log = tlog::recording(&telemetry.target, 0);
        while_busy("writing", || write_atomically(file, |out| out.write_all(&log)))?;
    }
    if let (Some(file), Some(record)) = (&arguments.record, &report.record) {
        while_busy("writing", || write_atomically(file, |out| out.write_all(record)))?;
    }
    if arguments.what.json {
        return terminal::put_json(&FlyResult::Agrees(Box::new(FlyAgreement::from(&report))));
    }
    terminal::put(&text(&file.to_string(), &report))
}

impl Arguments {
    fn debug_link(&self) -> DebugLink {
        let link = DebugLink::default();
        if self.probe_configs.is_empty() {
            link
        } else {
            DebugLink { probe: self.probe_configs.clone(), ..link }
        }
    }
}

/// Name of the unit in which costs are counted.
const fn unit(report: &FlyReport) -> &'static str {
    match report.cost_unit {
        CostUnit::Instructions => "instructions",
        CostUnit::Cycles => "cycles",
    }
}

fn text(file: &str, report: &FlyReport) -> String {
    let unit = unit(report);
    let target = match report.cost_unit {
        CostUnit::Instructions => "emulated flight computer",
        CostUnit::Cycles => "board",
    };
    let mut text = format!(
        "{file}: the {target} and the host agree to the bit in all {} ticks\n  \
         {:<21}{:.1} mean, {} worst (at {:.3} s)\n  \
         ticks begin          within {} {unit} of an even 5 ms\n  \
         stack                {} of {} bytes used\n  \
         image                {} bytes of flash, {} bytes of static RAM\n",
        report.ticks,
        format!("{unit} a tick"),
        report.instructions_mean,
        report.instructions_worst,
        report.worst_time_us as f64 * 1e-6,
        report.start_jitter,
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
    if report.chips.is_none() {
        text.push_str("  sensors              ideal: the flight's rows as they are\n");
    }
    if let Some(chips) = &report.chips {
        text.push_str(&chips_text(chips, report.sensor_faults));
    }
    if report.underruns > 0 || report.stalls > 0 {
        text.push_str(&format!(
            "  waited               {} timer ticks for input, {} for room for results\n",
            report.underruns, report.stalls
        ));
    }
    text
}

fn chips_text(chips: &ChipsReport, sensor_faults: u32) -> String {
    let ChipsReport { grid, truth, untold_fixes, agreement, consequence } = chips;
    let mut text = format!(
        "  sensors              on chips: {} rows on {} ticks of 5 ms; {sensor_faults} polls failed, the same on both\n",
        grid.rows, grid.ticks
    );
    let counts = [
        ("rows that share a tick", grid.shared),
        ("samples replaced by a later one at the same tick", grid.superseded_samples),
        ("rows before the row before them", grid.late_rows),
        ("values that are not finite", truth.not_finite.into()),
        ("values beyond the barometer's range", truth.baro_beyond_range.into()),
        ("values beyond the inertial unit's range", truth.imu_beyond_range.into()),
        ("values beyond the receiver's range", truth.gps_beyond_range.into()),
        ("barometer readings without a temperature: 25 degrees assumed", truth.assumed_temperatures.into()),
        ("fixes without a satellite count: 12 assumed", truth.assumed_satellites.into()),
        ("fixes with a part of their velocity, not used", truth.partial_velocities.into()),
        ("fixes that were held, sent once", truth.held_fixes.into()),
        ("altitudes of the mother ship after launch, not sent", truth.after_launch.into()),
        ("ticks at an impossible time", truth.impossible_times.into()),
        ("fixes while the receiver was starting, not sent", (*untold_fixes).into()),
    ];
    for (what, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
        text.push_str(&format!("    {count} {what}\n"));
    }
    for sensor in agreement.iter().flat_map(|agreement| &agreement.sensors) {
        text.push_str(&format!(
            "    {:<19}latched {:.3} m, {:+.4} m from ideal sensors ({} m by the chips' resolution and delays)\n",
            sensor.sensor.name(),
            sensor.chips_bias_m,
            sensor.difference_m(),
            if sensor.is_within_bound() {
                format!("within {:.4}", sensor.bound_m)
            } else {
                format!("BEYOND {:.4}", sensor.bound_m)
            },
        ));
    }
    if let Some(consequence) = consequence {
        text.push_str(&consequence.to_string());
    }
    text
}
