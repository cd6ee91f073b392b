//! The umbilical's break-wire, and what can be wrong with it.

use drivers::{LaunchDiscrete, SensorError};
use kf_core::input::LaunchDoubt;

use super::fault::Fault;
use crate::line::noise_after;

/// The wire: it follows the flight unless it has a fault.
#[derive(Clone, Copy, Debug)]
pub struct ModelledWire {
    is_open: bool,
    doubt: LaunchDoubt,
    fault: Fault,
    /// Whether the cable that contains the wire is torn.
    is_torn: bool,
    bouncing: Bouncing,
}

/// A contact that opens and closes by itself.
#[derive(Clone, Copy, Debug, Default)]
struct Bouncing {
    noise: u32,
    is_open: bool,
    until_us: u64,
}

impl ModelledWire {
    /// A closed wire.
    pub const fn new() -> Self {
        Self {
            is_open: false,
            doubt: LaunchDoubt::None,
            fault: Fault::None,
            is_torn: false,
            bouncing: Bouncing { noise: 0, is_open: false, until_us: 0 },
        }
    }

    /// Sets what the flight has: whether the vehicle has left, and how far that is in doubt.
    pub const fn set(&mut self, is_open: bool, doubt: LaunchDoubt) {
        self.is_open = is_open;
        self.doubt = doubt;
    }

    /// Sets the wire's fault from now on.
    pub const fn fail(&mut self, fault: Fault) {
        self.fault = fault;
        if let Fault::Bounces { seed, .. } = fault {
            self.bouncing = Bouncing { noise: seed, is_open: false, until_us: 0 };
        }
    }

    /// Tears the cable that contains the wire, or makes it whole again.
    pub const fn tear(&mut self, is_torn: bool) {
        self.is_torn = is_torn;
    }
}

impl Default for ModelledWire {
    fn default() -> Self {
        Self::new()
    }
}

impl Bouncing {
    fn at(&mut self, now_us: u64, open_us: u32, closed_us: u32) -> bool {
        if self.until_us <= now_us {
            self.is_open = !self.is_open;
            self.noise = noise_after(self.noise);
            let mean_us = if self.is_open { open_us } else { closed_us };
            let lasts_us = (2 * u64::from(mean_us) * u64::from(self.noise >> 8)) >> 24;
            self.until_us = now_us.saturating_add(lasts_us);
        }
        self.is_open
    }
}

impl LaunchDiscrete for ModelledWire {
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError> {
        let is_open = self.is_open || self.is_torn;
        match self.fault {
            Fault::Open => Ok(true),
            Fault::Shorted => Ok(false),
            Fault::Unreadable => Err(SensorError::Bus),
            Fault::Bounces { open_us, closed_us, .. } => Ok(self.bouncing.at(now_us, open_us, closed_us)),
            _ => Ok(is_open),
        }
    }

    fn doubt(&self) -> LaunchDoubt {
        self.doubt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_US: u64 = 5_000;

    fn readings(wire: &mut ModelledWire, ticks: u64) -> Vec<Result<bool, SensorError>> {
        (1..=ticks).map(|tick| wire.poll(tick * TICK_US)).collect()
    }

    #[test]
    fn a_fault_hides_what_the_flight_has() {
        for is_open in [false, true] {
            let mut wire = ModelledWire::new();
            wire.set(is_open, LaunchDoubt::None);
            assert_eq!(wire.poll(0), Ok(is_open));
            for (fault, reads) in [
                (Fault::Open, Ok(true)),
                (Fault::Shorted, Ok(false)),
                (Fault::Unreadable, Err(SensorError::Bus)),
                (Fault::None, Ok(is_open)),
            ] {
                wire.fail(fault);
                assert_eq!(wire.poll(0), reads, "{fault:?}");
            }
            wire.tear(true);
            assert_eq!(wire.poll(0), Ok(true));
            wire.tear(false);
            assert_eq!(wire.poll(0), Ok(is_open));
        }
    }

    /// A mean of 40 ms open and 120 ms closed: a quarter of 2,000 ticks, in runs of all lengths up to 80 and
    /// 240 ms.
    #[test]
    fn a_bouncing_wire_is_open_for_its_share() {
        let mut wire = ModelledWire::new();
        wire.fail(Fault::Bounces { open_us: 40_000, closed_us: 120_000, seed: 5 });
        let read = readings(&mut wire, 2_000);
        let open = read.iter().filter(|reading| **reading == Ok(true)).count();
        // About 60 runs of each: the share's standard deviation is about 0.03.
        assert!((320..680).contains(&open), "{open}");
        let longest = read.chunk_by(|a, b| a == b).map(<[_]>::len).max();
        assert!(longest.is_some_and(|ticks| (30..=49).contains(&ticks)), "{longest:?}");
    }
}
