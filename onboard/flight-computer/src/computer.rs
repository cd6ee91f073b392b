//! The chain of steps in a tick.

use drivers::Sensors;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;

use crate::estimation::Estimation;
use crate::onboard::Onboard;
use crate::part::Part;

/// Input and output of one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// New values, as passed to the estimator.
    pub input: TickInput,
    /// The estimator's output.
    pub output: TickOutput,
}

/// The chain of steps in a tick, with its state from one tick to the next.
#[derive(Clone, Debug)]
pub struct FlightComputer<Suite, Mission> {
    /// The sensors.
    pub sensors: Suite,
    /// The estimator.
    pub mission: Mission,
    /// Decides the launch and computes the inertial altitude; `None` for a recording that has both already.
    pub onboard: Option<Onboard>,
}

impl<Suite: Sensors, Mission: Estimation> FlightComputer<Suite, Mission> {
    /// A flight computer before its first tick, with a recording's sensors, which report when the vehicle has
    /// left.
    pub const fn new(sensors: Suite, mission: Mission) -> Self {
        Self { sensors, mission, onboard: None }
    }

    /// A flight computer before its first tick, with the sensors of a board.
    pub const fn on_board(sensors: Suite, mission: Mission, onboard: Onboard) -> Self {
        Self { sensors, mission, onboard: Some(onboard) }
    }

    /// One tick, at the flight computer's time in microseconds.
    pub fn tick(&mut self, now_us: u64) -> Step {
        self.tick_measured(now_us, &mut |_| ())
    }

    /// As [`Self::tick`]; calls `done` at the end of each part, for measuring its cost. A part may occur more
    /// than once.
    pub fn tick_measured(&mut self, now_us: u64, done: &mut impl FnMut(Part)) -> Step {
        let mut input = self.sensors.poll_each(now_us, &mut |device| done(device.into()));
        if let Some(onboard) = &mut self.onboard {
            onboard.complete(&mut input, self.sensors.wire());
            self.sensors.decided(input.launch);
            done(Part::Onboard);
        }
        let output = self.mission.tick(&input);
        done(Part::Mission);
        Step { input, output }
    }
}
