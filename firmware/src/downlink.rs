//! The telemetry of this image: its line's rate, what that line carries, and what is told after each tick.

use telemetry::{ComputerStatus, FrameQueue, Link, Rates, Said, Telemetry};

use flight_computer::Step;
use heapless::spsc::{Consumer, Producer};

use crate::board::CostClock;
use crate::flown_model::{self, FlownMission};

include!(concat!(env!("OUT_DIR"), "/telemetry.rs"));

/// The fullest rate table that the line carries; a line that carries none does not compile.
const RATES: Rates = match Rates::for_line(BAUD) {
    Ok(rates) => rates,
    Err(_) => panic!("PYLON_TELEMETRY_BAUD is too slow for any rate table"),
};

/// The frames between the tick and the line.
pub type Frames = FrameQueue;

/// The tick's end of them.
pub type FramesIn = Producer<'static, telemetry::Frame>;

/// The line's.
pub type FramesOut = Consumer<'static, telemetry::Frame>;

/// What tells the ground of every tick.
pub struct Downlink {
    telemetry: Telemetry<'static>,
    longest: u32,
}

impl Downlink {
    /// Telemetry of the model that was compiled in.
    pub fn new(frames: FramesIn) -> Self {
        let telemetry = Telemetry::new(Link::new(frames), RATES, &flown_model::effects());
        Self { telemetry, longest: 0 }
    }

    /// Tells of a tick.
    pub fn tell(&mut self, step: &Step, mission: &FlownMission, sensor_faults: u32, lost_results: u32) {
        let said = Said {
            input: &step.input,
            output: &step.output,
            latch: mission.latch(),
            counters: mission.counters(),
        };
        let load_permille = CostClock::permille_of_a_tick(self.longest);
        self.telemetry.tick(&said, &ComputerStatus { sensor_faults, lost_results, load_permille });
    }

    /// Notes what a whole tick took, in the units of the board's clock.
    pub fn note_cost(&mut self, cost: u32) {
        self.longest = self.longest.max(cost);
    }
}
