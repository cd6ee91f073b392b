//! The telemetry of this image: its line's rate, what that line carries, and what is told of each tick.

use flight_computer::Step;
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::output::Phase;
use survival::RestartReport;
use telemetry::{ComputerStatus, FrameQueue, Link, Rates, Telemetry, TickReport};

use crate::board;

include!(concat!(env!("OUT_DIR"), "/telemetry.rs"));

/// The fullest rate table that the line carries; a line that carries none does not compile.
const RATES: Rates = match Rates::for_line(BAUD) {
    Ok(rates) => rates,
    Err(_) => panic!("PYLON_TELEMETRY_BAUD is too slow for any rate table"),
};

/// The frames between telemetry and the line.
pub type Frames = FrameQueue;

/// The end of the task that makes telemetry.
pub type FramesIn = Producer<'static, telemetry::Frame>;

/// The line's.
pub type FramesOut = Consumer<'static, telemetry::Frame>;

/// Ticks that wait for telemetry, one slot of which stays empty: the task that takes them has all of the time
/// between two.
const TICKS: usize = 3;

/// What telemetry needs of a tick.
pub struct QueuedTick {
    /// Its inputs and outputs.
    pub step: Step,
    /// What the mission had counted by its end.
    pub counters: Counters,
    /// What the flight computer had.
    pub computer: ComputerStatus,
}

/// Ticks on their way from the tick to telemetry. It has no lock: neither side waits for the other.
pub type TickQueue = Queue<QueuedTick, TICKS>;

/// What makes the messages, below the tick.
pub struct Downlink {
    telemetry: Telemetry<'static>,
    latch: Option<LatchRecord>,
    /// How the flight computer has started, until that is told.
    start: Option<RestartReport>,
}

impl Downlink {
    /// Telemetry of the model that was compiled in, of a flight computer that has started so.
    pub fn new(frames: FramesIn, start: Option<RestartReport>) -> Self {
        let mut telemetry = Telemetry::new(Link::new(frames), RATES, &flown_mission::effects());
        if board::clock_is_internal() {
            telemetry.note_internal_clock();
        }
        Self { telemetry, latch: None, start }
    }

    /// Whether the calibration has been latched by the end of that tick and is not known here.
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
