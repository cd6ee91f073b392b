//! The flight computer's image: the estimator inside a 200 Hz timer interrupt.
//!
//! Priorities: `tick` (TIM2) preempts everything and never waits. Below it `tell` makes the telemetry
//! messages from a tick's results, and `transmit` gives the line its next frame. In the remaining time
//! `report` writes a tick's results, and `feed` reads the flight record (only on the emulated board). `tell`,
//! `report` and `feed` run on interrupts that no device of the board uses, pended by software: pending one
//! that is running makes it run again.
#![no_std]
#![no_main]

mod board;
mod copies;
mod downlink;
mod failure;
mod meter;
mod mutation;
mod restart;
mod retained;
mod stack;
mod strike;
mod tick_timer;
mod watchdog;

use core::mem::MaybeUninit;

use drivers::Sensors as _;
use flight_computer::{
    FlightComputer, Onboard, Part, Snapshot, SnapshotKeeper, Step, assess_restart, keep_mark, resume_mission,
};
use flight_record::{ExitStatus, Summary, TickRecord};
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::estimator::ConfigError;
use kf_core::launch::LaunchConfig;
use kf_core::navigation::KeptInertial;
use kf_core::strapdown;
use survival::{MarkWriter, PAYLOAD_BYTES, RestartReport, Supervised, Supervisor, keep_captive_force};
use telemetry::ComputerStatus;

use board::{Board, CostClock, Feeder, Line, Next, Sensors, Sink, Source, Storage, Watchdog};
use downlink::{Downlink, Frames, FramesOut, QueuedTick, TickQueue};
use flown_mission::{Flown, FlownMission};
use meter::{Costs, TickMeter};
use mutation::Mutated;
use retained::RetainedWords;
use tick_timer::TickTimer;

/// The tasks that must be alive for the watchdog to be fed.
static SUPERVISOR: Supervisor = Supervisor::new();

/// Capacity of the queue of results between the tick and the report; one slot stays empty.
const RESULTS: usize = 8;

/// Counts over all ticks.
#[derive(Clone, Copy, Default)]
pub struct TickCounts {
    ticks: u32,
    underruns: u32,
    stalls: u32,
    lost_results: u32,
    /// Ticks that telemetry did not receive.
    untold: u32,
    /// The most expensive tick so far, in the units of the board's clock.
    longest: u32,
    sensor_faults: u32,
    start_cost: Option<u32>,
    costs: Costs,
    ended: bool,
}

impl TickCounts {
    /// The flight computer's status for telemetry.
    const fn status(&self) -> ComputerStatus {
        ComputerStatus {
            wire: None,
            sensor_faults: self.sensor_faults,
            lost_results: self.lost_results.saturating_add(self.untold),
            load_permille: CostClock::permille_of_a_tick(self.longest),
        }
    }
}

/// The chain of a tick.
type Computer = FlightComputer<Mutated<Sensors>, Flown<'static>>;

// Large values are made in their final place, each in a call of its own. Otherwise the stack that they need
// would be occupied while everything else is made.

#[inline(never)]
fn made(place: &'static mut MaybeUninit<FlownMission>) -> Result<&'static mut FlownMission, ConfigError> {
    flown_mission::mission(place)
}

/// For sensors of a recording, which contains the launch.
#[inline(never)]
fn recorded_computer(
    place: &'static mut MaybeUninit<Computer>,
    sensors: Sensors,
    mission: &'static mut FlownMission,
) -> &'static mut Computer {
    place.write(FlightComputer::new(Mutated(sensors), Flown(mission)))
}

#[inline(never)]
fn board_computer(
    place: &'static mut MaybeUninit<Computer>,
    sensors: Sensors,
    mission: &'static mut FlownMission,
    report: Option<&RestartReport>,
    inertial: Option<&KeptInertial>,
    memory: &RetainedWords,
) -> Result<&'static mut Computer, ConfigError> {
    let onboard = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS)?;
    let computer = place.write(FlightComputer::on_board(Mutated(sensors), Flown(mission), onboard));
    if let Some(onboard) = &mut computer.onboard {
        onboard.resume(report, inertial, memory);
    }
    Ok(computer)
}

#[rtic::app(device = stm32f4xx_hal::pac)]
mod app {
    use stm32f4xx_hal::pac::Interrupt;

    use super::*;

    const TRANSMIT: Interrupt = Interrupt::DMA2_STREAM7;
    const TELL: Interrupt = Interrupt::EXTI2;
    const REPORT: Interrupt = Interrupt::EXTI0;
    const FEED: Interrupt = Interrupt::EXTI1;

    #[shared]
    struct Shared {
        computer: &'static mut Computer,
        counts: TickCounts,
        #[lock_free]
        feeder: Feeder,
    }

    #[local]
    struct Local {
        timer: TickTimer,
        source: Source,
        results_in: Producer<'static, TickRecord>,
        results_out: Consumer<'static, TickRecord>,
        sink: Sink,
        ticks_in: Producer<'static, QueuedTick>,
        ticks_out: Consumer<'static, QueuedTick>,
        downlink: Downlink,
        line: Line,
        frames_out: FramesOut,
        marks: MarkWriter,
        marks_memory: RetainedWords,
        watchdog: Watchdog,
        keeper: SnapshotKeeper,
        snapshots_memory: RetainedWords,
        snapshot: &'static mut [u8; PAYLOAD_BYTES],
        snapshot_due: &'static mut MaybeUninit<Snapshot>,
        restarts: u32,
    }

    #[init(local = [
        storage: Storage = Storage::new(),
        mission: MaybeUninit<FlownMission> = MaybeUninit::uninit(),
        results: Queue<TickRecord, RESULTS> = Queue::new(),
        ticks: TickQueue = TickQueue::new(),
        frames: Frames = Frames::new(),
        snapshot_bytes: [u8; PAYLOAD_BYTES] = [0; PAYLOAD_BYTES],
        due: MaybeUninit<Snapshot> = MaybeUninit::uninit(),
        computer_place: MaybeUninit<Computer> = MaybeUninit::uninit(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        board::prepare(&cx.device);
        defmt::info!(
            "pylon on {=str}: model {=str}, fingerprint {=u64:016x}",
            board::NAME,
            flown_mission::NAME,
            flown_mission::FINGERPRINT
        );
        if !stack::is_guarded() {
            board::exit(ExitStatus::Configuration);
        }
        // SAFETY: opened; marks, snapshots and the board's words have one owner each from here on.
        let [marks_memory, mut snapshots_memory, board_words] =
            [0; 3].map(|_| unsafe { RetainedWords::claim() });
        let snapshot = cx.local.snapshot_bytes;
        let mut start = assess_restart(
            &mut snapshots_memory,
            flown_mission::FINGERPRINT,
            &board::reset_facts(),
            snapshot,
        );
        strike::arm(start.report.map_or(0, |report| report.resumed_us));
        let restart = start.report.filter(|report| report.restarts > 0);
        let Board { timer, source, feeder, sensors, is_recording, mut sink, mut line, mut watchdog } =
            match board::start(cx.device, cx.core, cx.local.storage, restart.as_ref(), board_words) {
                Ok(board) => board,
                Err(status) => board::exit(status),
            };
        if let Some(report) = restart.filter(|report| report.pause_us > 0) {
            restart::log_standby(&report);
            board::stand_by(&report, &mut line, &mut watchdog);
        }
        let mission = match made(cx.local.mission) {
            Ok(mission) => mission,
            Err(_) => board::exit(ExitStatus::Configuration),
        };
        let inertial =
            resume_mission(mission, &mut snapshots_memory, flown_mission::FINGERPRINT, &mut start, snapshot);
        let report = start.report;
        if let Some(report) = &report {
            restart::log(report);
            sink.write(report);
        }
        let made = if is_recording {
            Ok(recorded_computer(cx.local.computer_place, sensors, mission))
        } else {
            let (report, inertial) = (report.as_ref(), inertial.as_ref());
            board_computer(cx.local.computer_place, sensors, mission, report, inertial, &snapshots_memory)
        };
        let computer = match made {
            Ok(computer) => computer,
            Err(_) => board::exit(ExitStatus::Configuration),
        };
        let (results_in, results_out) = cx.local.results.split();
        let (ticks_in, ticks_out) = cx.local.ticks.split();
        let (frames_in, frames_out) = cx.local.frames.split();
        rtic::pend(FEED);
        (
            Shared {
                computer,
                counts: TickCounts { start_cost: CostClock::since_reset(), ..TickCounts::default() },
                feeder,
            },
            Local {
                timer,
                source,
                results_in,
                results_out,
                sink,
                ticks_in,
                ticks_out,
                downlink: Downlink::new(frames_in, report),
                line,
                frames_out,
                marks: MarkWriter::find(&marks_memory),
                marks_memory,
                watchdog,
                keeper: SnapshotKeeper::new(start.order, flown_mission::FINGERPRINT),
                snapshots_memory,
                snapshot,
                snapshot_due: cx.local.due,
                restarts: report.map_or(0, |report| report.restarts),
            },
        )
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// One tick of the flight computer.
    #[task(
        binds = TIM2,
        priority = 3,
        local = [timer, source, results_in, ticks_in, marks, marks_memory, watchdog],
        shared = [computer, counts],
    )]
    fn tick(cx: tick::Context) {
        let begun = CostClock::time();
        let tick::LocalResources {
            timer, source, results_in, ticks_in, marks, marks_memory, watchdog, ..
        } = cx.local;
        let mut computer = cx.shared.computer;
        let mut counts = cx.shared.counts;
        timer.acknowledge();
        SUPERVISOR.is_alive(Supervised::Tick);
        if stack::is_whole() {
            SUPERVISOR.is_alive(Supervised::Stack);
        }
        if SUPERVISOR.may_feed() {
            watchdog.feed();
        }
        let computer_status = counts.lock(|counts| counts.status());
        let stepped =
            computer.lock(|computer| match source.next(&mut computer.sensors.0, results_in.ready()) {
                Next::Tick(now_us) => {
                    let mut meter = TickMeter::start();
                    let step = computer.tick_measured(now_us, &mut |part| meter.lap(part));
                    let sensor_faults = computer.sensors.faults().count;
                    let wire = computer.onboard.as_ref().map(|onboard| onboard.launch().wire());
                    let tick = QueuedTick {
                        step: step.clone(),
                        counters: *computer.mission.0.counters(),
                        computer: ComputerStatus { wire, sensor_faults, ..computer_status },
                    };
                    let is_queued = ticks_in.enqueue(tick).is_ok();
                    meter.lap(Part::Telemetry);
                    keep_mark(marks, marks_memory, computer.mission.0, &step, CostClock::time(), wire);
                    meter.lap(Part::Mark);
                    strike::strike(now_us);
                    Ok((meter, step, sensor_faults, is_queued))
                }
                otherwise => Err(otherwise),
            });
        match stepped {
            Ok((meter, Step { input, output }, sensor_faults, is_queued)) => {
                counts.lock(|counts| {
                    counts.untold = counts.untold.saturating_add(u32::from(!is_queued));
                    counts.longest = counts.longest.max(meter.total());
                    counts.ticks = counts.ticks.saturating_add(1);
                    counts.costs.take(&meter);
                    counts.sensor_faults = sensor_faults;
                    if results_in.enqueue(TickRecord { begun, cost: meter.total(), input, output }).is_err() {
                        counts.lost_results = counts.lost_results.saturating_add(1);
                    }
                });
            }
            Err(Next::Underrun) => {
                counts.lock(|counts| counts.underruns = counts.underruns.saturating_add(1))
            }
            Err(Next::Stall) => counts.lock(|counts| counts.stalls = counts.stalls.saturating_add(1)),
            Err(Next::End | Next::Tick(_)) => counts.lock(|counts| counts.ended = true),
        }
        // All of them, even if there is nothing to do: each shows that it is alive.
        rtic::pend(TELL);
        rtic::pend(TRANSMIT);
        rtic::pend(REPORT);
        rtic::pend(FEED);
    }

    /// Makes the telemetry messages from the ticks' results.
    #[task(binds = EXTI2, priority = 2, local = [ticks_out, downlink], shared = [computer, counts])]
    fn tell(cx: tell::Context) {
        let tell::LocalResources { ticks_out, downlink, .. } = cx.local;
        let mut computer = cx.shared.computer;
        let mut counts = cx.shared.counts;
        SUPERVISOR.is_alive(Supervised::Telemetry);
        while let Some(tick) = ticks_out.peek() {
            let begun = CostClock::now();
            if downlink.lacks_latch(tick) {
                downlink.take_latch(computer.lock(|computer| computer.mission.0.latch().cloned()));
            }
            downlink.tell(tick);
            // It was read in place.
            drop(ticks_out.dequeue());
            let took = CostClock::now().wrapping_sub(begun);
            counts.lock(|counts| counts.costs.take_below(Part::Messages, took));
            rtic::pend(TRANSMIT);
        }
    }

    /// Gives the telemetry line its next frame when the last one is finished, and when there are new ones.
    /// The real board's DMA raises this interrupt; on the emulated one a timer pends it.
    #[task(binds = DMA2_STREAM7, priority = 2, local = [line, frames_out])]
    fn transmit(cx: transmit::Context) {
        let transmit::LocalResources { line, frames_out, .. } = cx.local;
        while line.is_free()
            && let Some(frame) = mutation::next_frame(frames_out)
        {
            line.send(&frame);
        }
        SUPERVISOR.is_alive(Supervised::Transmit);
    }

    /// Reads input for the coming ticks.
    #[task(binds = EXTI1, priority = 1, shared = [feeder])]
    fn feed(cx: feed::Context) {
        if mutation::is_busy(mutation::Work::Feed) {
            return;
        }
        cx.shared.feeder.feed();
        SUPERVISOR.is_alive(Supervised::Feed);
    }

    /// Writes the ticks' results.
    #[task(
        binds = EXTI0,
        priority = 1,
        local = [results_out, sink, keeper, snapshots_memory, snapshot, snapshot_due, restarts],
        shared = [computer, counts, feeder],
    )]
    fn report(cx: report::Context) {
        if mutation::is_busy(mutation::Work::Report) {
            return;
        }
        strike::hang_report();
        let report::LocalResources {
            results_out,
            sink,
            keeper,
            snapshots_memory,
            snapshot,
            snapshot_due,
            restarts,
            ..
        } = cx.local;
        let mut computer = cx.shared.computer;
        let mut counts = cx.shared.counts;
        while let Some(record) = results_out.dequeue() {
            sink.write(&record);
            if record.output.latched_now {
                defmt::info!(
                    "latched at {=u64} us, failed checks {=u16:b}",
                    record.output.time_us,
                    record.output.failed_checks
                );
                if let Some(latch) = computer.lock(|computer| computer.mission.0.latch().cloned()) {
                    sink.write(&latch);
                }
            }
        }
        if let Some(force) = computer.lock(|computer| keeper.captive_force_due(computer.onboard.as_ref())) {
            keep_captive_force(snapshots_memory, force);
        }
        let due = computer
            .lock(|computer| keeper.make_due(computer.mission.0, computer.onboard.as_ref(), snapshot_due));
        if let Some(due) = due {
            keeper.keep(snapshots_memory, due, snapshot);
        }
        SUPERVISOR.is_alive(Supervised::Report);
        let counts = counts.lock(|counts| *counts);
        if counts.ended {
            let stack = stack::usage();
            let summary = cx.shared.feeder.summarise(Summary {
                ticks: counts.ticks,
                underruns: counts.underruns,
                stalls: counts.stalls,
                lost_results: counts.lost_results,
                bad_frames: 0,
                bad_payloads: 0,
                missed_frames: 0,
                input_cut: false,
                restarts: *restarts,
                skipped_inputs: 0,
                start_cost: counts.start_cost,
                lost_snapshots: keeper.lost(),
                sensor_faults: counts.sensor_faults,
                cost_unit: CostClock::UNIT,
                cost_sum: counts.costs.whole.sum,
                cost_worst: counts.costs.whole.worst,
                parts: counts.costs.parts(),
                stack_used_bytes: stack.used_bytes,
                stack_size_bytes: stack.size_bytes,
            });
            sink.write(&summary);
            defmt::info!(
                "end of the record after {=u32} ticks, stack {=u32} of {=u32} bytes",
                counts.ticks,
                stack.used_bytes,
                stack.size_bytes
            );
            board::exit(sink.status());
        }
    }
}
