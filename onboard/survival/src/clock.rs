//! Extends a 32-bit timer to a 64-bit clock.

/// Carries a free-running 32-bit count of microseconds beyond its wrap after 71.6 minutes.
///
/// It must be read at least once in that time; every tick does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WideClock {
    now_us: u64,
    last_count: u32,
}

impl WideClock {
    /// A clock that shows `now_us` when the timer shows `count`.
    #[must_use]
    pub const fn new(now_us: u64, count: u32) -> Self {
        Self { now_us, last_count: count }
    }

    /// The time when the timer shows `count`, microseconds.
    pub const fn at(&mut self, count: u32) -> u64 {
        let elapsed_us = count.wrapping_sub(self.last_count);
        self.last_count = count;
        self.now_us = self.now_us.wrapping_add(elapsed_us as u64);
        self.now_us
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn follows_the_true_time_over_any_number_of_wraps(
            start_us in 0_u64..1 << 50,
            first_count in any::<u32>(),
            steps in prop::collection::vec(0_u32..=u32::MAX, 1..200),
        ) {
            let mut clock = WideClock::new(start_us, first_count);
            let mut true_us = start_us;
            for step in steps {
                true_us += u64::from(step);
                let count = first_count.wrapping_add((true_us - start_us) as u32);
                prop_assert_eq!(clock.at(count), true_us);
            }
        }
    }

    #[test]
    fn the_wrap_itself_is_one_microsecond() {
        let mut clock = WideClock::new(5, u32::MAX);
        assert_eq!((clock.at(0), clock.at(0), clock.at(u32::MAX)), (6, 6, 6 + u64::from(u32::MAX)));
    }
}
