//! The chain of a tick.

use drivers::Sensors;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;

use crate::estimation::Estimation;
use crate::onboard::Onboard;
use crate::part::Part;

/// What one tick saw and said.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What was new, as the estimator got it.
    pub input: TickInput,
    /// What the estimator said.
    pub output: TickOutput,
}

/// The chain of a tick, with everything that it remembers from one tick to the next.
#[derive(Clone, Debug)]
pub struct FlightComputer<Suite, Mission> {
    /// The sensors.
    pub sensors: Suite,
    /// The estimator.
    pub mission: Mission,
    /// What decides the launch and makes the inertial altitude; `None` where a recording has both already.
    pub onboard: Option<Onboard>,
}

impl<Suite: Sensors, Mission: Estimation> FlightComputer<Suite, Mission> {
    /// A flight computer before its first tick, with sensors that know when the vehicle has left: a
    /// recording's.
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

    /// As [`Self::tick`]; `done` is called at the end of each part, for a meter. A part may come more than
    /// once.
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
