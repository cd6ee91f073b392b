//! The telemetry of this image: its line's rate, what fits on that line, and what is sent of each tick.

use flight_computer::Step;
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::output::Phase;
use survival::RestartReport;
use telemetry::{ComputerStatus, FrameQueue, Link, Rates, Telemetry, TickReport};

use crate::board;

include!(concat!(env!("OUT_DIR"), "/telemetry.rs"));

/// The fullest rate table that fits on the line; a line on which none fits does not compile.
const RATES: Rates = match Rates::for_line(BAUD) {
    Ok(rates) => rates,
    Err(_) => panic!("PYLON_TELEMETRY_BAUD is too slow for any rate table"),
};

/// The queue of frames between telemetry and the line.
pub type Frames = FrameQueue;

/// The sending end, of the task that makes telemetry.
pub type FramesIn = Producer<'static, telemetry::Frame>;

/// The receiving end, of the line.
pub type FramesOut = Consumer<'static, telemetry::Frame>;

/// Capacity of the queue of ticks for telemetry, one slot of which stays empty: the task that takes them has
/// the whole time between two ticks.
const TICKS: usize = 3;

/// The data that telemetry needs of a tick.
pub struct QueuedTick {
    /// Its inputs and outputs.
    pub step: Step,
    /// The mission's counters at its end.
    pub counters: Counters,
    /// The flight computer's status.
    pub computer: ComputerStatus,
}

/// The queue from the tick to telemetry. It has no lock: neither side waits for the other.
pub type TickQueue = Queue<QueuedTick, TICKS>;

/// Makes the messages, at a priority below the tick.
pub struct Downlink {
    telemetry: Telemetry<'static>,
    latch: Option<LatchRecord>,
    /// How the flight computer started, until it has been reported.
    start: Option<RestartReport>,
}

impl Downlink {
    /// Telemetry of the compiled-in model, for a flight computer that started in this way.
    pub fn new(frames: FramesIn, start: Option<RestartReport>) -> Self {
        let mut telemetry = Telemetry::new(Link::new(frames), RATES, &flown_mission::effects());
        if board::clock_is_internal() {
            telemetry.note_internal_clock();
        }
        Self { telemetry, latch: None, start }
    }

    /// Whether the calibration has been latched by the end of that tick and is not yet known here.
    pub fn lacks_latch(&self, tick: &QueuedTick) -> bool {
        self.latch.is_none() && tick.step.output.phase == Phase::FreeFlight
    }

    /// The latched calibration, which never changes.
    pub fn take_latch(&mut self, latch: Option<LatchRecord>) {
        self.latch = latch;
    }

    /// Reports a tick.
    pub fn tell(&mut self, tick: &QueuedTick) {
        if let Some(report) = self.start.take() {
            self.telemetry.note_start(&report);
        }
        let QueuedTick { step, counters, computer } = tick;
        let report =
            TickReport { input: &step.input, output: &step.output, latch: self.latch.as_ref(), counters };
        self.telemetry.tick(&report, computer);
    }
}
