//! The flight computer's image: the estimator inside a 200 Hz timer interrupt.
//!
//! Priorities: `tick` (TIM2) preempts everything and never waits. With what time is left `report` writes
//! what it said, and `feed` brings the flight record (only the emulated board has one). Both run on
//! interrupts that no device of the board uses, pended by software: to pend one that runs runs it again.
#![no_std]
#![no_main]

mod board;
mod failure;
mod flown_model;
mod mutation;
mod stack;
mod tick_timer;

use flight_record::{ExitStatus, Summary, TickRecord};
use heapless::spsc::{Consumer, Producer, Queue};

use board::{Board, CostClock, Feeder, Next, Sensors, Sink, Source, Storage};
use flown_model::FlownMission;
use tick_timer::TickTimer;

/// Results between the tick and the report, one slot of which stays empty.
const RESULTS: usize = 8;

/// What the tick counts.
#[derive(Clone, Copy, Default)]
pub struct TickCounts {
    ticks: u32,
    underruns: u32,
    stalls: u32,
    lost_results: u32,
    sensor_faults: u32,
    cost_sum: u64,
    cost_worst: u32,
    ended: bool,
}

#[rtic::app(device = stm32f4xx_hal::pac)]
mod app {
    use stm32f4xx_hal::pac::Interrupt;

    use super::*;

    const REPORT: Interrupt = Interrupt::EXTI0;
    const FEED: Interrupt = Interrupt::EXTI1;

    #[shared]
    struct Shared {
        mission: FlownMission,
        counts: TickCounts,
        #[lock_free]
        feeder: Feeder,
    }

    #[local]
    struct Local {
        timer: TickTimer,
        clock: CostClock,
        source: Source,
        sensors: Sensors,
        results_in: Producer<'static, TickRecord>,
        results_out: Consumer<'static, TickRecord>,
        sink: Sink,
    }

    #[init(local = [storage: Storage = Storage::new(), results: Queue<TickRecord, RESULTS> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        defmt::info!(
            "pylon on {=str}: model {=str}, fingerprint {=u64:016x}",
            board::NAME,
            flown_model::NAME,
            flown_model::FINGERPRINT
        );
        let mission = match flown_model::mission() {
            Ok(mission) => mission,
            Err(_) => board::exit(ExitStatus::Configuration),
        };
        let Board { timer, clock, source, feeder, sensors, sink } =
            match board::start(cx.device, cx.core, cx.local.storage) {
                Ok(board) => board,
                Err(status) => board::exit(status),
            };
        let (results_in, results_out) = cx.local.results.split();
        rtic::pend(FEED);
        (
            Shared { mission, counts: TickCounts::default(), feeder },
            Local { timer, clock, source, sensors, results_in, results_out, sink },
        )
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// One tick of the mission.
    #[task(binds = TIM2, priority = 3, local = [timer, clock, source, sensors, results_in], shared = [mission, counts])]
    fn tick(cx: tick::Context) {
        let tick::LocalResources { timer, clock, source, sensors, results_in, .. } = cx.local;
        let mut mission = cx.shared.mission;
        let mut counts = cx.shared.counts;
        timer.acknowledge();
        let now_us = match source.next(sensors, results_in.ready()) {
            Next::Tick(now_us) => now_us,
            Next::Underrun => {
                counts.lock(|counts| counts.underruns = counts.underruns.saturating_add(1));
                rtic::pend(FEED);
                return;
            }
            Next::Stall => {
                counts.lock(|counts| counts.stalls = counts.stalls.saturating_add(1));
                rtic::pend(REPORT);
                return;
            }
            Next::End => {
                counts.lock(|counts| counts.ended = true);
                rtic::pend(REPORT);
                return;
            }
        };
        let input = mutation::mutated(sensors.poll(now_us));
        let record = mission.lock(|mission| {
            let start = clock.now();
            let output = mission.tick(&input);
            TickRecord { cost: clock.now().wrapping_sub(start), output }
        });
        counts.lock(|counts| {
            counts.ticks = counts.ticks.saturating_add(1);
            counts.cost_sum = counts.cost_sum.saturating_add(record.cost.into());
            counts.cost_worst = counts.cost_worst.max(record.cost);
            counts.sensor_faults = sensors.faults().count;
            if results_in.enqueue(record).is_err() {
                counts.lost_results = counts.lost_results.saturating_add(1);
            }
        });
        rtic::pend(REPORT);
        rtic::pend(FEED);
    }

    /// Brings input for the ticks to come.
    #[task(binds = EXTI1, priority = 1, shared = [feeder])]
    fn feed(cx: feed::Context) {
        if mutation::is_busy(mutation::Work::Feed) {
            return;
        }
        cx.shared.feeder.feed();
    }

    /// Writes what the ticks said.
    #[task(binds = EXTI0, priority = 1, local = [results_out, sink], shared = [mission, counts, feeder])]
    fn report(cx: report::Context) {
        if mutation::is_busy(mutation::Work::Report) {
            return;
        }
        let report::LocalResources { results_out, sink, .. } = cx.local;
        let mut mission = cx.shared.mission;
        let mut counts = cx.shared.counts;
        while let Some(record) = results_out.dequeue() {
            sink.write(&record);
            if record.output.latched_now {
                defmt::info!(
                    "latched at {=u64} us, failed checks {=u16:b}",
                    record.output.time_us,
                    record.output.failed_checks
                );
                if let Some(latch) = mission.lock(|mission| mission.latch().cloned()) {
                    sink.write(&latch);
                }
            }
        }
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
                sensor_faults: counts.sensor_faults,
                cost_unit: CostClock::UNIT,
                cost_sum: counts.cost_sum,
                cost_worst: counts.cost_worst,
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
