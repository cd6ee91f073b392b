//! A long series, kept as the range of its values in each of a bounded number of time slots.

/// Largest number of slots for a figure on paper.
pub const FIGURE_SLOTS: usize = 1_024;
/// Width of the first slots, microseconds.
const FIRST_WIDTH_US: u64 = 1_000;

/// Least, greatest, mean and last value of a series within one time slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Time of the slot's first value, microseconds.
    pub time_us: u64,
    /// Least value.
    pub least: f32,
    /// Greatest value.
    pub greatest: f32,
    /// Last value.
    pub last: f32,
    /// Sum of the values.
    pub sum: f64,
    /// Their number, at least 1.
    pub count: u32,
}

impl Slot {
    fn new(time_us: u64, value: f32) -> Self {
        Self { time_us, least: value, greatest: value, last: value, sum: f64::from(value), count: 1 }
    }

    /// Takes in a slot that follows.
    #[inline]
    fn merge(&mut self, later: &Self) {
        self.least = self.least.min(later.least);
        self.greatest = self.greatest.max(later.greatest);
        self.last = later.last;
        self.sum += later.sum;
        self.count += later.count;
    }

    /// Mean of its values.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / f64::from(self.count)
    }
}

/// A series thinned out so that its drawing looks the same: no spike is lost, and memory does not grow with
/// the series.
#[derive(Clone, Debug)]
pub struct Envelope {
    slots: Vec<Slot>,
    capacity: u64,
    width_us: u64,
    start_us: Option<u64>,
}

impl Envelope {
    /// An empty series. If there are more than `capacity` slots (at least 1), neighbours are merged, so that
    /// at least half as many are left.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { slots: Vec::new(), capacity: capacity.max(1) as u64, width_us: FIRST_WIDTH_US, start_us: None }
    }

    /// Adds a finite value; times must not decrease.
    #[inline]
    pub fn push(&mut self, time_us: u64, value: f32) {
        let start_us = *self.start_us.get_or_insert(time_us);
        let slot_of = |time: u64, width: u64| time.saturating_sub(start_us) / width;
        while slot_of(time_us, self.width_us) >= self.capacity {
            self.width_us *= 2;
            let width = self.width_us;
            self.slots.dedup_by(|later, earlier| {
                let is_same = slot_of(later.time_us, width) == slot_of(earlier.time_us, width);
                if is_same {
                    earlier.merge(later);
                }
                is_same
            });
        }
        match self.slots.last_mut() {
            Some(slot) if slot_of(slot.time_us, self.width_us) == slot_of(time_us, self.width_us) => {
                slot.merge(&Slot::new(time_us, value));
            }
            _ => self.slots.push(Slot::new(time_us, value)),
        }
    }

    /// The slots, in time order.
    #[must_use]
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn loses_no_extreme_and_stays_bounded(
            steps in prop::collection::vec((0_u64..200_000, -1e3_f32..1e3), 1..3_000),
            capacity in 1_usize..2_000,
        ) {
            let mut envelope = Envelope::new(capacity);
            let mut time_us = 5;
            let mut series = Vec::new();
            for (dt, value) in steps {
                time_us += dt;
                series.push((time_us, value));
                envelope.push(time_us, value);
            }
            let slots = envelope.slots();
            prop_assert!(slots.len() <= capacity);
            prop_assert!(slots.windows(2).all(|pair| pair[0].time_us < pair[1].time_us));
            prop_assert_eq!(slots.last().unwrap().last, series.last().unwrap().1);
            for (index, slot) in slots.iter().enumerate() {
                let end = slots.get(index + 1).map_or(u64::MAX, |next| next.time_us);
                let within = || series.iter().filter(|(t, _)| (slot.time_us..end).contains(t)).map(|(_, v)| *v);
                prop_assert_eq!(slot.least, within().fold(f32::INFINITY, f32::min));
                prop_assert_eq!(slot.greatest, within().fold(f32::NEG_INFINITY, f32::max));
                prop_assert_eq!(slot.count as usize, within().count());
                let mean = within().map(f64::from).sum::<f64>() / f64::from(slot.count);
                prop_assert!((slot.mean() - mean).abs() < 1e-6);
            }
        }
    }
}
