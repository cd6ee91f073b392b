//! The sensors that a flight record is flown on.

use drivers::{Device, Faults, ReplayedSuite, Sensors};
use kf_core::input::TickInput;

pub use flight_record::SensorSource;

use super::fault::ChipFault;
use super::suite::ModelledSuite;
use super::truth::TruthCounts;
use crate::metered::WorkObserver;

/// Ideal or modelled sensors.
#[expect(clippy::large_enum_variant, reason = "there is one, and no heap")]
pub enum RecordedSensors<Observer> {
    /// Deliver the record's values unchanged.
    Ideal(ReplayedSuite),
    /// Drivers on models of their chips.
    Chips(ModelledSuite<Observer>),
}

impl<Observer: WorkObserver + Clone> RecordedSensors<Observer> {
    /// Sensors before the first tick.
    pub fn new(source: SensorSource, observer: &Observer) -> Self {
        match source {
            SensorSource::Ideal => Self::Ideal(ReplayedSuite::replayed()),
            SensorSource::Chips => Self::Chips(ModelledSuite::new(observer)),
        }
    }

    /// See [`ModelledSuite::restart`].
    pub fn restart(&mut self) {
        match self {
            Self::Ideal(suite) => *suite = ReplayedSuite::replayed(),
            Self::Chips(suite) => suite.restart(),
        }
    }
}

impl<Observer: WorkObserver> RecordedSensors<Observer> {
    /// Loads the record's values for the next poll.
    pub fn load(&mut self, record: &TickInput) {
        match self {
            Self::Ideal(suite) => suite.load(record),
            Self::Chips(suite) => suite.load(record),
        }
    }

    /// Starts or ends a fault of a chip. Returns whether there are chips.
    pub fn inject(&mut self, event: ChipFault) -> bool {
        match self {
            Self::Ideal(_) => false,
            Self::Chips(suite) => {
                suite.inject(event);
                true
            }
        }
    }

    /// Values that could not go through the chips unchanged; none for ideal sensors.
    pub fn counts(&self) -> TruthCounts {
        match self {
            Self::Ideal(_) => TruthCounts::default(),
            Self::Chips(suite) => suite.counts(),
        }
    }

    /// Fixes that the receiver did not send; see [`ModelledSuite::unsent_solutions`].
    pub fn unsent_solutions(&mut self) -> u32 {
        match self {
            Self::Ideal(_) => 0,
            Self::Chips(suite) => suite.unsent_solutions(),
        }
    }
}

impl<Observer: WorkObserver> Sensors for RecordedSensors<Observer> {
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        match self {
            Self::Ideal(suite) => suite.poll_each(now_us, polled),
            Self::Chips(suite) => suite.poll_each(now_us, polled),
        }
    }

    fn faults(&self) -> Faults {
        match self {
            Self::Ideal(suite) => suite.faults(),
            Self::Chips(suite) => suite.faults(),
        }
    }

    fn wire(&self) -> Option<bool> {
        match self {
            Self::Ideal(suite) => suite.wire(),
            Self::Chips(suite) => suite.wire(),
        }
    }

    fn decided(&mut self, has_left: bool) {
        match self {
            Self::Ideal(suite) => suite.decided(has_left),
            Self::Chips(suite) => suite.decided(has_left),
        }
    }
}
