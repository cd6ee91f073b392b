//! A flight through the firmware, compared with the host's tick by tick.

use std::fs;

use drivers::Sensors as _;
use flight_computer::Step;
use flight_record::{ExitStatus, INPUT_FILE, SensorSource, Summary};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use model::Model;
use replay::Replay;
use telemetry::{ComputerStatus, FrameQueue, Rates};

use super::agreement;
use super::builder::{Board, Program, build};
use super::compare::{self, Difference};
use super::consequence::{self, Consequence};
use super::downlink::Downlink;
use super::error::{FlyError, ResultsError, Shortfall};
use super::fault_script::{self, Item, PlannedFault, Scripted, schedule};
use super::grid::{GridReport, OnGrid};
use super::host;
use super::image::Image;
use super::options::{FlownOn, FlyOptions};
use super::record::{self, FlightResult, Results};
use super::report::{ChipsReport, Downlinked, FlyReport, parts};
use super::run::{Run, TELEMETRY_FILE, emulated, name, results};
use super::starts::Starts;

/// Flies a flight through the firmware and compares every tick with the host's, bit for bit.
///
/// # Errors
/// [`FlyError`]; [`FlyError::Differs`] if a single bit differs.
pub fn fly(replay: &Replay<'_>, options: &FlyOptions) -> Result<FlyReport, FlyError> {
    // With chips, the flight computer computes the inertial altitude itself.
    let inputs = match options.sensors {
        SensorSource::Ideal => replay.mission_inputs(),
        SensorSource::Chips => replay.inputs(),
    };
    fly_inputs(inputs, replay.model(), options)
}

/// As [`fly`], for ticks from any source.
///
/// # Errors
/// As [`fly`].
pub fn fly_inputs(
    inputs: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    options: &FlyOptions,
) -> Result<FlyReport, FlyError> {
    let events = schedule(&options.faults)?;
    match options.sensors {
        SensorSource::Ideal if !events.is_empty() => Err(FlyError::IdealSensors),
        SensorSource::Ideal => fly_items(inputs.map(Item::Tick), model, options),
        SensorSource::Chips => {
            let grid = GridReport::of(inputs.clone())?;
            fault_script::check(&events, OnGrid::new(inputs.clone()))?;
            let items = Scripted::new(OnGrid::new(inputs.clone()), &events);
            let mut report = fly_items(items, model, options)?;
            if let Some(chips) = &mut report.chips {
                chips.grid = grid;
                if !events.is_empty() {
                    chips.consequence = Some(consequence::of(inputs, model, &events)?);
                } else if let Some(latch) = &report.latch {
                    chips.agreement = agreement::of(inputs, model, latch)?;
                }
            }
            Ok(report)
        }
    }
}

/// Flies a flight on chips with and without the faults, on the host alone, and reports their effect.
///
/// # Errors
/// As [`fly_on_host`], and a fault that is not possible.
pub fn consequence(
    inputs: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    faults: &[PlannedFault],
) -> Result<Consequence, FlyError> {
    let events = schedule(faults)?;
    GridReport::of(inputs.clone())?;
    fault_script::check(&events, OnGrid::new(inputs.clone()))?;
    consequence::of(inputs, model, &events)
}

/// Flies a flight through the host's flight computer alone and passes on every tick: the one [`fly_inputs`]
/// compares the target with. Returns how many polls of sensors failed.
///
/// # Errors
/// As [`fly_inputs`], except those of the firmware.
pub fn fly_on_host(
    inputs: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    options: &FlyOptions,
    on_tick: &mut dyn FnMut(&Step, u32),
) -> Result<u32, FlyError> {
    let events = schedule(&options.faults)?;
    let mut computer = host::computer(model, options.sensors, options.host_ulp_error)?;
    let mut take = |item| match item {
        Item::Fault(fault) => {
            computer.sensors.recorded.inject(fault);
        }
        Item::Tick(input) => {
            computer.sensors.recorded.load(&input);
            let step = computer.tick(input.time_us);
            on_tick(&step, computer.sensors.faults().count);
        }
    };
    match options.sensors {
        SensorSource::Ideal => inputs.map(Item::Tick).for_each(take),
        SensorSource::Chips => {
            GridReport::of(inputs.clone())?;
            Scripted::new(OnGrid::new(inputs), &events).for_each(&mut take);
        }
    }
    Ok(computer.sensors.faults().count)
}

fn fly_items(
    items: impl Iterator<Item = Item> + Clone,
    model: &Model,
    options: &FlyOptions,
) -> Result<FlyReport, FlyError> {
    let board = match &options.on {
        FlownOn::Emulator => Board::Qemu,
        FlownOn::Board(_) if options.telemetry => {
            return Err(FlyError::NoTelemetry);
        }
        FlownOn::Board(link) => {
            link.check()?;
            Board::Hil
        }
    };
    let image_path = build(Program::Flight(board), model, options.target_error)?;
    let image = Image::read(&image_path)?;
    let directory = tempfile::tempdir().map_err(FlyError::io("temporary directory"))?;
    let count = record::write_inputs(
        &directory.path().join(name(INPUT_FILE)?),
        model.fingerprint()?,
        options.sensors,
        items.clone(),
    )?;

    let line = options.telemetry.then_some(TELEMETRY_FILE);
    let mut run = match &options.on {
        FlownOn::Emulator => emulated(&image_path, directory.path(), count, line)?,
        FlownOn::Board(link) => {
            let ended = link.fly(&image_path, directory.path(), count)?;
            Run::of(ended, &image_path, directory.path())?
        }
    };
    if run.status != Some(ExitStatus::Finished) {
        return Err(FlyError::Stopped { status: run.status, log: run.log });
    }
    let compared = compare(items, model, options, &mut run.results)?;
    let summary = compared.summary;
    check_complete(&summary, count, compared.ticks, compared.sensor_faults)?;
    let telemetry = match line {
        Some(file) => Some(Downlinked {
            target: fs::read(directory.path().join(file)).map_err(FlyError::io("the telemetry"))?,
            host: compared.telemetry,
        }),
        None => None,
    };
    let record = match options.record {
        true => Some(results(directory.path())?),
        false => None,
    };
    Ok(FlyReport {
        ticks: summary.ticks,
        cost_unit: summary.cost_unit,
        instructions_mean: summary.cost_sum as f64 / f64::from(summary.ticks.max(1)),
        instructions_worst: summary.cost_worst,
        worst_time_us: compared.worst_time_us,
        tick_period: compared.starts.period(),
        start_jitter: compared.starts.jitter(),
        parts: parts(&summary),
        underruns: summary.underruns,
        stalls: summary.stalls,
        stack_used_bytes: summary.stack_used_bytes,
        stack_size_bytes: summary.stack_size_bytes,
        flash_bytes: image.flash_bytes,
        static_ram_bytes: image.static_ram_bytes,
        sensor_faults: compared.sensor_faults,
        chips: compared.chips,
        latch: compared.latch,
        log: run.log,
        telemetry,
        record,
    })
}

struct Compared {
    ticks: u64,
    worst_time_us: u64,
    starts: Starts,
    latch: Option<LatchRecord>,
    sensor_faults: u32,
    chips: Option<ChipsReport>,
    summary: Summary,
    telemetry: Vec<u8>,
}

/// Runs the host's flight computer beside the target's results.
fn compare(
    mut items: impl Iterator<Item = Item>,
    model: &Model,
    options: &FlyOptions,
    results: &mut Results,
) -> Result<Compared, FlyError> {
    let mut computer = host::computer(model, options.sensors, options.host_ulp_error)?;
    let mut frames = FrameQueue::new();
    let mut downlink = options.telemetry.then(|| Downlink::new(&mut frames, model, Rates::FULL));
    let mut first: Option<Difference> = None;
    let mut differing = 0_u64;
    let mut ticks = 0_u64;
    let mut last_us = 0;
    let (mut worst, mut worst_time_us) = (0, 0);
    let mut starts = Starts::default();
    let mut target_latch = None;
    let mut note = |tick, time_us, (field, host, target): compare::FieldDifference| {
        first.get_or_insert(Difference {
            tick,
            time_us,
            field,
            host,
            target,
            ticks_that_differ: 0,
            ticks: 0,
        });
    };
    let summary = loop {
        match results.next_result()? {
            Some(FlightResult::Tick(record)) => {
                let input = loop {
                    match items.next() {
                        Some(Item::Tick(input)) => break input,
                        // A flight with faults but without chips was refused before.
                        Some(Item::Fault(fault)) => {
                            computer.sensors.recorded.inject(fault);
                        }
                        None => return Err(ResultsError::MoreThanInputs.into()),
                    }
                };
                computer.sensors.recorded.load(&input);
                let host = computer.tick(input.time_us);
                if let Some(downlink) = &mut downlink {
                    let sensor_faults = computer.sensors.faults().count;
                    let wire = computer.onboard.as_ref().map(|onboard| onboard.launch().wire());
                    let status = ComputerStatus { wire, sensor_faults, ..ComputerStatus::default() };
                    downlink.tell(&host.input, &host.output, &*computer.mission, &status);
                }
                let target = Step { input: record.input, output: record.output };
                if !compare::same_step(&host, &target) {
                    differing += 1;
                    note(ticks, input.time_us, compare::tick_difference(&host, &target));
                }
                if record.cost > worst {
                    (worst, worst_time_us) = (record.cost, input.time_us);
                }
                starts.take(record.begun);
                last_us = input.time_us;
                ticks += 1;
            }
            Some(FlightResult::Latch(latch)) => target_latch = Some(latch),
            Some(FlightResult::Restart(report)) => return Err(FlyError::Restarted(report.cause.name())),
            Some(FlightResult::Summary(summary)) => break summary,
            None => return Err(ResultsError::NoSummary.into()),
        }
    };
    let host_latch = computer.mission.latch();
    if !compare::same_bits(&host_latch, &target_latch.as_ref()) {
        note(ticks, last_us, compare::latch_difference(host_latch, target_latch.as_ref()));
    }
    match first {
        Some(first) => {
            Err(FlyError::Differs(Box::new(Difference { ticks_that_differ: differing, ticks, ..first })))
        }
        None => {
            let chips = (options.sensors == SensorSource::Chips).then(|| ChipsReport {
                grid: GridReport::default(),
                truth: computer.sensors.recorded.counts(),
                untold_fixes: computer.sensors.recorded.unsent_solutions(),
                agreement: None,
                consequence: None,
            });
            let telemetry = downlink.map(Downlink::into_bytes).unwrap_or_default();
            let sensor_faults = computer.sensors.faults().count;
            Ok(Compared {
                ticks,
                worst_time_us,
                starts,
                latch: target_latch,
                sensor_faults,
                chips,
                summary,
                telemetry,
            })
        }
    }
}

/// Checks that a good record was flown from its first input to its last.
fn check_complete(summary: &Summary, inputs: u32, compared: u64, host_faults: u32) -> Result<(), FlyError> {
    let counts = [
        ("lost results", summary.lost_results),
        ("damaged frames", summary.bad_frames),
        ("damaged payloads", summary.bad_payloads),
        ("missing frames", summary.missed_frames),
        ("cut record", u32::from(summary.input_cut)),
    ];
    if let Some((what, count)) = counts.into_iter().find(|(_, count)| *count > 0) {
        return Err(FlyError::Incomplete(Shortfall::Counted { what, count }));
    }
    if summary.sensor_faults != host_faults {
        return Err(FlyError::Incomplete(Shortfall::SensorFaults {
            target: summary.sensor_faults,
            host: host_faults,
        }));
    }
    if summary.ticks != inputs || compared != u64::from(inputs) {
        return Err(FlyError::Incomplete(Shortfall::Ticks {
            inputs,
            ticks: summary.ticks,
            results: compared,
        }));
    }
    Ok(())
}
