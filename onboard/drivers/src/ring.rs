//! A ring of bytes that something else writes, such as a DMA stream behind a UART: which of its bytes have
//! arrived, and whether any may have been lost.
//!
//! The stream reports only its position in the ring, not its number of laps. A reader that looks again later
//! than the line takes for half a ring must therefore treat everything as lost. One that looks in time, and
//! then takes up to half a ring at each poll, never takes a byte twice or one that has been overwritten.

/// Why the arrived bytes are unusable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingError {
    /// The line reports broken bytes among them (framing, overrun).
    Broken,
    /// The look came too late.
    Late,
}

/// Reads a ring of `BYTES` bytes. Times are counts of any clock that wraps at 32 bits.
#[derive(Clone, Debug)]
pub struct RingReader<const BYTES: usize> {
    /// The next byte to take, and the next that will be written, as last seen.
    next: usize,
    arrived: usize,
    seen: u32,
    late_after: u32,
    /// Where the ring was when broken bytes were last reported.
    broken_at: Option<usize>,
}

impl<const BYTES: usize> RingReader<BYTES> {
    /// A reader of an empty ring. `lap`: clock counts in which the line fills the ring.
    #[must_use]
    pub const fn new(now: u32, lap: u32) -> Self {
        Self { next: 0, arrived: 0, seen: now, late_after: lap / 2, broken_at: None }
    }

    /// The stream starts again at the ring's beginning.
    pub const fn restart(&mut self, now: u32) {
        *self = Self { next: 0, arrived: 0, seen: now, late_after: self.late_after, broken_at: None };
    }

    /// Whether everything that had arrived at the last look has been taken, so that it is time for another
    /// look.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.next == self.arrived
    }

    /// Looks again. `remaining`: bytes that the stream will write before it is back at the ring's beginning.
    /// `has_broken`: the line's flag of broken bytes, which stays set until another byte has come after the
    /// look.
    ///
    /// # Errors
    /// [`RingError`]; everything that has arrived is then skipped.
    pub fn look(&mut self, now: u32, remaining: usize, has_broken: bool) -> Result<(), RingError> {
        let elapsed = now.wrapping_sub(self.seen);
        self.seen = now;
        self.arrived = BYTES.saturating_sub(remaining) % BYTES;
        let is_news = has_broken && self.broken_at != Some(self.arrived);
        self.broken_at = has_broken.then_some(self.arrived);
        let outcome = if elapsed >= self.late_after {
            Err(RingError::Late)
        } else if is_news {
            Err(RingError::Broken)
        } else {
            Ok(())
        };
        if outcome.is_err() {
            self.next = self.arrived;
        }
        outcome
    }

    /// Index of the next byte in the ring.
    pub const fn take(&mut self) -> Option<usize> {
        if self.is_empty() {
            return None;
        }
        let place = self.next;
        self.next = (place + 1) % BYTES;
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BYTES: usize = 16;

    /// A stream that writes a byte at each count of the clock while the line is busy. A byte's value is its
    /// number.
    struct Line {
        ring: [u32; BYTES],
        written: u32,
        now: u32,
    }

    impl Line {
        fn run(&mut self, busy: &[bool]) {
            for &busy in busy {
                self.now = self.now.wrapping_add(1);
                if busy {
                    self.ring[self.written as usize % BYTES] = self.written;
                    self.written += 1;
                }
            }
        }

        fn remaining(&self) -> usize {
            BYTES - self.written as usize % BYTES
        }
    }

    proptest! {
        #[test]
        fn what_is_taken_is_what_came_in_order_and_only_late_looks_lose(
            start in any::<u32>(),
            polls in proptest::collection::vec(proptest::collection::vec(any::<bool>(), 1..40), 1..60),
        ) {
            let mut line = Line { ring: [0; BYTES], written: 0, now: start };
            let mut reader = RingReader::<BYTES>::new(start, BYTES as u32);
            let mut expected = 0;
            for busy in polls {
                line.run(&busy);
                prop_assert!(reader.is_empty());
                let looked = reader.look(line.now, line.remaining(), false);
                prop_assert_eq!(looked, if busy.len() >= BYTES / 2 { Err(RingError::Late) } else { Ok(()) });
                if looked.is_err() {
                    expected = line.written;
                }
                while let Some(place) = reader.take() {
                    prop_assert_eq!(line.ring[place], expected);
                    expected += 1;
                }
                prop_assert_eq!(expected, line.written);
            }
        }
    }

    #[test]
    fn broken_bytes_are_told_once_and_again_after_more_have_come() {
        let mut reader = RingReader::<BYTES>::new(0, 1_000);
        assert_eq!(reader.look(1, BYTES - 3, true), Err(RingError::Broken));
        assert_eq!(reader.take(), None, "passed over");
        assert_eq!(reader.look(2, BYTES - 3, true), Ok(()), "the flag of the same byte");
        assert_eq!(reader.look(3, BYTES - 5, true), Err(RingError::Broken), "another byte's flag");
        assert_eq!(reader.look(4, BYTES - 6, false), Ok(()));
        assert_eq!((reader.take(), reader.take()), (Some(5), None));
        assert_eq!(
            reader.look(5, BYTES - 6, true),
            Err(RingError::Broken),
            "raised without the byte being seen"
        );
    }

    #[test]
    fn a_stream_that_starts_again_starts_at_the_beginning() {
        let mut reader = RingReader::<BYTES>::new(0, 1_000);
        assert_eq!(reader.look(1, BYTES - 7, false), Ok(()));
        reader.restart(2);
        assert_eq!(reader.look(3, BYTES - 1, false), Ok(()));
        assert_eq!((reader.take(), reader.take()), (Some(0), None));
    }
}
