//! The cost of the parts of a tick.

use flight_computer::{PARTS, Part};
use flight_record::{MAX_PARTS, PartCost};
use heapless::Vec;

use crate::board::CostClock;

/// The clock at the end of a tick's last part, and the cost of each part so far.
pub struct TickMeter {
    last: u32,
    parts: [u32; PARTS],
}

impl TickMeter {
    /// Starts a tick.
    pub fn start() -> Self {
        Self { last: CostClock::now(), parts: [0; PARTS] }
    }

    /// Ends a part.
    pub fn lap(&mut self, part: Part) {
        let now = CostClock::now();
        let took = now.wrapping_sub(self.last);
        if let Some(cost) = self.parts.get_mut(part.index()) {
            *cost = cost.wrapping_add(took);
        }
        // The meter's own work is not part of any.
        self.last = CostClock::now();
    }

    /// All parts together.
    pub fn total(&self) -> u32 {
        self.parts.iter().fold(0, |sum, cost| sum.wrapping_add(*cost))
    }
}

/// Sums and worst cases over all ticks.
#[derive(Clone, Copy, Default)]
pub struct Costs {
    /// All parts together.
    pub whole: PartCost,
    parts: [PartCost; PARTS],
}

impl Costs {
    /// Adds a tick.
    pub fn take(&mut self, tick: &TickMeter) {
        add(&mut self.whole, tick.total());
        for (cost, took) in self.parts.iter_mut().zip(tick.parts) {
            add(cost, took);
        }
    }

    /// Adds work done below a tick, which is not part of the tick.
    pub fn take_below(&mut self, part: Part, took: u32) {
        if let Some(cost) = self.parts.get_mut(part.index()) {
            add(cost, took);
        }
    }

    /// The parts' costs, in the order of [`Part`].
    pub fn parts(&self) -> Vec<PartCost, MAX_PARTS> {
        self.parts.iter().copied().collect()
    }
}

/// A record has room for every part.
const _: () = assert!(PARTS <= MAX_PARTS);

fn add(cost: &mut PartCost, took: u32) {
    cost.sum = cost.sum.saturating_add(took.into());
    cost.worst = cost.worst.max(took);
}
