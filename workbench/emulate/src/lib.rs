//! A flight through the firmware, in the emulated flight computer or on a board, compared with the host to
//! the bit.

mod agreement;
mod builder;
mod compare;
mod consequence;
mod debug_link;
pub mod downlink;
mod emulator;
mod error;
mod fault_names;
mod fault_script;
mod grid;
mod host;
mod image;
mod log;
mod made_of;
mod old_images;
mod one_processor;
mod record;
mod registry_paths;
mod starts;

use std::fs;
use std::path::Path;
use std::time::Duration;

use chip_models::flown::TruthCounts;
use drivers::Sensors as _;
use flight_computer::{Part, Step};
pub use flight_record::{CostUnit, SensorSource};
use flight_record::{ExitStatus, INPUT_FILE, OUTPUT_FILE, STRIKES_FILE, Strike, Summary, TickRecord};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use model::Model;
use survival::RestartReport;
use telemetry::{ComputerStatus, FrameQueue, Rates};

pub use agreement::{Agreement, SensorAgreement};
pub use builder::{Board, PlantedError, Program, TARGET, build};
pub use compare::Difference;
pub use consequence::{
    AltitudeDifference, BiasChange, CalibrationChange, CleanAndFaulty, Consequence, FlagsChange,
};
pub use debug_link::{DebugLink, TicksFlown};
pub use emulator::{Emulation, emulate};
pub use error::{FlyError, ResultsError, Shortfall};
pub use fault_script::{FaultError, PlannedFault};
pub use grid::{GridReport, TICK_US};
pub use image::Image;
pub use record::{FlightResult, Results};
pub use starts::Starts;

use crate::downlink::Downlink;
use fault_script::{Item, Scripted, schedule};
use grid::OnGrid;
use replay::Replay;

/// Longest wait for an emulation that does not end, besides [`PATIENCE_PER_TICK`].
const PATIENCE: Duration = Duration::from_secs(120);
/// And for each tick: some fifty times what a tick takes.
const PATIENCE_PER_TICK: Duration = Duration::from_millis(10);

/// The file of the telemetry's line, in the emulation's folder.
const TELEMETRY_FILE: &str = "telemetry.bin";

/// What a flight is flown on.
#[derive(Clone, Debug, Default)]
pub enum FlownOn {
    /// QEMU.
    #[default]
    Emulator,
    /// An STM32F405, through its debug link. Its own sensors, lines and crystal have no part in it: chips are
    /// models, as in QEMU.
    Board(DebugLink),
}

/// How to fly.
#[derive(Clone, Debug, Default)]
pub struct FlyOptions {
    /// What is flown on.
    pub on: FlownOn,
    /// How the flight's samples come to the estimator; by default as they are. On chips the rows are put on
    /// the flight computer's grid of ticks.
    pub sensors: SensorSource,
    /// Faults of the chips.
    pub faults: Vec<PlannedFault>,
    /// An error planted in the firmware, to see that it is found.
    pub target_error: Option<PlantedError>,
    /// The host's flight computer gets every barometer reading one unit in the last place off, to see that it
    /// is found.
    pub host_ulp_error: bool,
    /// Records what goes over the telemetry's line, in QEMU: a board's is silent.
    pub telemetry: bool,
    /// Keeps the flight computer's results as it sent them: a flight record.
    pub record: bool,
}

/// What went over the telemetry's line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Downlinked {
    /// The emulated flight computer's: whole frames, without those that still waited at the flight's end.
    pub target: Vec<u8>,
    /// What the host would have sent on a line that is never full.
    pub host: Vec<u8>,
}

/// A flight whose every tick had the same bits on host and target.
#[derive(Clone, Debug, PartialEq)]
pub struct FlyReport {
    /// Ticks flown and compared.
    pub ticks: u32,
    /// What the costs here are counted in: instructions in QEMU; on a board cycles, whatever a cost is
    /// called.
    pub cost_unit: CostUnit,
    /// Instructions of one tick, drivers and mission, mean.
    pub instructions_mean: f64,
    /// The dearest tick's.
    pub instructions_worst: u32,
    /// When that was, microseconds.
    pub worst_time_us: u64,
    /// From one tick to the next, instructions.
    pub tick_period: u32,
    /// How much later on its grid of 5 ms one tick began than another at most, instructions.
    pub start_jitter: u64,
    /// What each part of the ticks took.
    pub parts: Vec<PartReport>,
    /// Timer ticks at which the mission waited for its input.
    pub underruns: u32,
    /// Timer ticks at which it waited for room for its results.
    pub stalls: u32,
    /// Most stack that was ever in use, bytes.
    pub stack_used_bytes: u32,
    /// Stack there is, bytes.
    pub stack_size_bytes: u32,
    /// Flash that the image takes, bytes.
    pub flash_bytes: u64,
    /// RAM that its static variables take, bytes.
    pub static_ram_bytes: u64,
    /// How many polls of sensors failed, the same on both.
    pub sensor_faults: u32,
    /// What there is to say about a flight on chips.
    pub chips: Option<ChipsReport>,
    /// The latched calibration, the same on both; `None` for a flight without launch.
    pub latch: Option<LatchRecord>,
    /// What the firmware logged.
    pub log: Vec<String>,
    /// What went over the telemetry's line, if asked for.
    pub telemetry: Option<Downlinked>,
    /// The flight computer's results as it sent them, if asked for.
    pub record: Option<Vec<u8>>,
}

/// What there is to say about a flight on chips.
#[derive(Clone, Debug, PartialEq)]
pub struct ChipsReport {
    /// What became of the flight's rows.
    pub grid: GridReport,
    /// What could not go through the chips as the flight has it.
    pub truth: TruthCounts,
    /// Fixes that came before the receiver was configured, or too many at a time.
    pub untold_fixes: u32,
    /// How far the latched calibration is from the one of ideal sensors; `None` without a launch, or with
    /// faults planned.
    pub agreement: Option<Agreement>,
    /// What the planned faults did, beside the same flight without them; `None` without any.
    pub consequence: Option<Consequence>,
}

/// What one part of the ticks took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReport {
    /// Which.
    pub part: Part,
    /// Instructions a tick, mean.
    pub instructions_mean: f64,
    /// The dearest tick's.
    pub instructions_worst: u32,
}

/// Flies a flight through the firmware and compares every tick with the host's, bit for bit.
///
/// # Errors
/// [`FlyError`]; [`FlyError::Differs`] if a single bit differs.
pub fn fly(replay: &Replay<'_>, options: &FlyOptions) -> Result<FlyReport, FlyError> {
    // On chips the flight computer makes the inertial altitude itself.
    let inputs = match options.sensors {
        SensorSource::Ideal => replay.mission_inputs(),
        SensorSource::Chips => replay.inputs(),
    };
    fly_inputs(inputs, replay.model(), options)
}

/// As [`fly`], for ticks from anywhere.
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

/// Flies a flight on chips with and without the faults, on the host alone, and says what they did.
///
/// # Errors
/// As [`fly_on_host`], and a fault that cannot be.
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

/// Flies a flight through the host's flight computer alone, and shows every tick: what [`fly_inputs`]
/// compares the target with. Returns how many polls of sensors failed.
///
/// # Errors
/// As [`fly_inputs`], but for all that has to do with the firmware.
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

/// The results that an image left in its directory, as it sent them.
fn results(directory: &Path) -> Result<Vec<u8>, FlyError> {
    fs::read(directory.join(name(OUTPUT_FILE)?)).map_err(FlyError::io("the results"))
}

fn parts(summary: &Summary) -> Vec<PartReport> {
    let costs = Part::ALL.into_iter().zip(&summary.parts);
    let ticks = f64::from(summary.ticks.max(1));
    costs
        .map(|(part, cost)| PartReport {
            part,
            instructions_mean: cost.sum as f64 / ticks,
            instructions_worst: cost.worst,
        })
        .collect()
}

/// What a flight left behind.
pub struct Run {
    /// How the firmware ended it; `None` if it did not.
    pub status: Option<ExitStatus>,
    /// What it logged; QEMU's own words if the firmware did not end it.
    pub log: Vec<String>,
    /// Its results.
    pub results: Results,
}

/// Flies any bytes at all as a flight record, good or bad: nothing is compared.
///
/// # Errors
/// Only what keeps the emulation from running to an end of its own.
pub fn fly_bytes(record: &[u8], model: &Model, planted: Option<PlantedError>) -> Result<RawFlight, FlyError> {
    fly_raw(record, model, planted, &[])
}

/// Flies a flight record whose flight computer is struck at these times: it must go on.
///
/// # Errors
/// As [`fly_bytes`].
pub fn fly_struck(record: &[u8], model: &Model, strikes: &[Strike]) -> Result<RawFlight, FlyError> {
    fly_raw(record, model, Some(PlantedError::Strike), strikes)
}

/// As [`fly_struck`], of ticks on chips with faults of theirs.
///
/// # Errors
/// As [`fly_struck`], and a fault that cannot be.
pub fn fly_struck_on_chips(
    inputs: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    faults: &[PlannedFault],
    strikes: &[Strike],
) -> Result<RawFlight, FlyError> {
    let events = schedule(faults)?;
    GridReport::of(inputs.clone())?;
    fault_script::check(&events, OnGrid::new(inputs.clone()))?;
    let file = tempfile::NamedTempFile::new().map_err(FlyError::io("the flight record"))?;
    let items = Scripted::new(OnGrid::new(inputs), &events);
    record::write_inputs(file.path(), model.fingerprint()?, SensorSource::Chips, items)?;
    let record = fs::read(file.path()).map_err(FlyError::io("the flight record"))?;
    fly_struck(&record, model, strikes)
}

fn fly_raw(
    record: &[u8],
    model: &Model,
    planted: Option<PlantedError>,
    strikes: &[Strike],
) -> Result<RawFlight, FlyError> {
    let image = build(Program::Flight(Board::Qemu), model, planted)?;
    let directory = tempfile::tempdir().map_err(FlyError::io("temporary directory"))?;
    fs::write(directory.path().join(name(INPUT_FILE)?), record).map_err(FlyError::io("the flight record"))?;
    let blows: Vec<u8> = strikes.iter().flat_map(|strike| strike.to_bytes()).collect();
    fs::write(directory.path().join(name(STRIKES_FILE)?), blows).map_err(FlyError::io("the blows"))?;
    let ticks = u32::try_from(record.len() / 16).unwrap_or(u32::MAX);
    let mut run = emulated(&image, directory.path(), ticks, Some(TELEMETRY_FILE))?;
    let telemetry = fs::read(directory.path().join(TELEMETRY_FILE)).map_err(FlyError::io("the telemetry"))?;
    let record = results(directory.path())?;
    let mut flight =
        RawFlight { status: run.status, log: run.log, telemetry, record, ..RawFlight::default() };
    while let Some(result) = run.results.next_result()? {
        match result {
            FlightResult::Tick(tick) => flight.ticks.push(tick),
            FlightResult::Latch(latch) => flight.latches.push(latch),
            FlightResult::Restart(report) => flight.restarts.push((flight.ticks.len(), report)),
            FlightResult::Summary(summary) => flight.summary = Some(summary),
        }
    }
    Ok(flight)
}

/// What an emulated flight on any bytes said.
#[derive(Clone, Debug, Default)]
pub struct RawFlight {
    /// How the firmware ended it; `None` if it did not.
    pub status: Option<ExitStatus>,
    /// What it logged.
    pub log: Vec<String>,
    /// Every tick.
    pub ticks: Vec<TickRecord>,
    /// Every latched calibration; there should be one at most.
    pub latches: Vec<LatchRecord>,
    /// Every restart, and how many ticks there were before it.
    pub restarts: Vec<(usize, RestartReport)>,
    /// What was counted, if the flight came to its end.
    pub summary: Option<Summary>,
    /// What went over the telemetry's line; a restart may have cut a frame.
    pub telemetry: Vec<u8>,
    /// All of that but log and telemetry, as the flight computer sent it.
    pub record: Vec<u8>,
}

fn emulated(
    image: &Path,
    directory: &Path,
    ticks: u32,
    telemetry: Option<&'static str>,
) -> Result<Run, FlyError> {
    let patience = PATIENCE + PATIENCE_PER_TICK.saturating_mul(ticks);
    Run::of(emulate(image, directory, telemetry, patience)?, image, directory)
}

impl Run {
    /// Reads what an image has left in its directory.
    fn of(ended: Emulation, image: &Path, directory: &Path) -> Result<Self, FlyError> {
        let status = ended.code.and_then(ExitStatus::from_code);
        let elf = fs::read(image).map_err(FlyError::io(image.display().to_string()))?;
        let mut log = log::lines(&elf, &ended.stdout);
        log.extend(ended.stderr.lines().map(str::to_owned));
        let output = directory.join(name(OUTPUT_FILE)?);
        if !output.is_file() {
            return Err(FlyError::Stopped { status, log });
        }
        Ok(Self { status, log, results: Results::open(&output)? })
    }
}

fn name(file: &'static std::ffi::CStr) -> Result<&'static str, FlyError> {
    file.to_str().map_err(FlyError::FileName)
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
                        // A flight without chips and with faults was refused.
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
                untold_fixes: computer.sensors.recorded.untold_solutions(),
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

/// A good record must have been flown from its first input to its last.
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
