//! Schedules the messages.

/// Time at which something is to be sent next.
#[derive(Clone, Copy, Debug)]
pub struct Due {
    at_us: u64,
}

impl Due {
    /// Due at once.
    pub const NOW: Self = Self { at_us: 0 };

    /// Whether it is due.
    pub const fn is_due(self, now_us: u64) -> bool {
        now_us >= self.at_us
    }

    /// Time for which it has been due, microseconds.
    pub const fn overdue_us(self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.at_us)
    }

    /// Sets the next time: a period after the last, or after now if that is past.
    pub fn sent(&mut self, now_us: u64, period_us: u32) {
        let next_us = self.at_us.saturating_add(period_us.into());
        self.at_us = if next_us > now_us { next_us } else { now_us.saturating_add(period_us.into()) };
    }
}

/// Messages of which one a tick is sent; there are [`Slot::COUNT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Slot {
    /// Whether the vehicle has left.
    Launch,
    /// HEARTBEAT.
    Heartbeat,
    /// STATUSTEXT.
    Text,
    /// SYS_STATUS.
    SysStatus,
    /// ATTITUDE.
    Attitude,
    /// ALTITUDE.
    Altitude,
    /// True airspeed.
    Airspeed,
    /// Angle of attack.
    AngleOfAttack,
    /// Sideslip.
    Sideslip,
    /// Throttle.
    Throttle,
    /// Outside air temperature.
    OutsideAir,
    /// Errors, moving averages, trust.
    Error,
    /// Everything else.
    Slow,
}

impl Slot {
    const COUNT: usize = 13;
    const ALL: [Self; Self::COUNT] = [
        Self::Launch,
        Self::Heartbeat,
        Self::Text,
        Self::SysStatus,
        Self::Attitude,
        Self::Altitude,
        Self::Airspeed,
        Self::AngleOfAttack,
        Self::Sideslip,
        Self::Throttle,
        Self::OutsideAir,
        Self::Error,
        Self::Slow,
    ];
}

/// Times at which the slots are due.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    due: [Due; Slot::COUNT],
}

impl Schedule {
    /// Every slot due at once.
    pub const fn new() -> Self {
        Self { due: [Due::NOW; Slot::COUNT] }
    }

    /// The slot that has been due longest, of those with something to send; the first if there are several.
    pub fn next(&self, now_us: u64, has_something: impl Fn(Slot) -> bool) -> Option<Slot> {
        let mut found = None;
        for (slot, due) in Slot::ALL.into_iter().zip(&self.due) {
            let is_longer = found.is_none_or(|(_, at_us)| due.at_us < at_us);
            if due.is_due(now_us) && is_longer && has_something(slot) {
                found = Some((slot, due.at_us));
            }
        }
        found.map(|(slot, _)| slot)
    }

    /// Makes a slot the next.
    pub fn at_once(&mut self, slot: Slot) {
        self.set(slot, |due| *due = Due::NOW);
    }

    /// Records that a slot was sent.
    pub fn sent(&mut self, slot: Slot, now_us: u64, period_us: u32) {
        self.set(slot, |due| due.sent(now_us, period_us));
    }

    fn set(&mut self, slot: Slot, change: impl FnOnce(&mut Due)) {
        if let Some(due) = self.due.get_mut(slot as usize) {
            change(due);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_due_goes_first_and_none_starves() {
        // Five slots of 10 ms share ticks of 5 ms: each gets every fifth tick.
        let slots = [Slot::Heartbeat, Slot::Altitude, Slot::Airspeed, Slot::Error, Slot::Slow];
        let mut schedule = Schedule::new();
        let mut counts = [0_u32; 5];
        for tick in 0..1_000_u64 {
            let now_us = tick * 5_000;
            let slot = schedule.next(now_us, |slot| slots.contains(&slot)).unwrap();
            schedule.sent(slot, now_us, 10_000);
            counts[slots.iter().position(|known| *known == slot).unwrap()] += 1;
        }
        assert!(counts.iter().all(|count| (195..=205).contains(count)), "{counts:?}");
    }

    #[test]
    fn a_period_is_kept_over_ticks_that_do_not_divide_it_and_no_burst_follows_a_gap() {
        let mut due = Due::NOW;
        let sent = |due: &mut Due, times: &mut dyn Iterator<Item = u64>| {
            times
                .filter(|now_us| {
                    let is_due = due.is_due(*now_us);
                    if is_due {
                        due.sent(*now_us, 30_000);
                    }
                    is_due
                })
                .count()
        };
        assert_eq!(sent(&mut due, &mut (0..1_000).map(|tick| 1_000_000 + tick * 7_000)), 7_000 / 30 + 1);
        assert_eq!(sent(&mut due, &mut (0..3).map(|tick| 60_000_000 + tick * 7_000)), 1);
    }
}
