//! Selects the core's oscillator: the crystal, or the internal one if the crystal does not start.

/// Number of polls of the crystal before it is given up. A poll takes at least five cycles (load, test,
/// count, branch) of the 16 MHz after a reset: 20 ms, ten times what a crystal typically needs (2 ms, DS8626
/// rev 10, table 39).
const CRYSTAL_LOOKS: u32 = 64_000;
/// Number of polls of the PLL: at least 1 ms, three times its longest lock time (0.3 ms, DS8626, table 42).
const LOCK_LOOKS: u32 = 3_200;

/// Oscillator of the core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oscillator {
    /// The crystal.
    Crystal,
    /// The internal oscillator: the same frequency to 1 % at 25 degrees C, to 4 % from -10 to 85 (DS8626,
    /// table 41).
    Internal,
}

/// No oscillator locks the PLL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoClock;

/// The registers of a clock tree.
pub trait ClockTree {
    /// Turns the crystal on or off.
    fn turn_crystal(&mut self, on: bool);
    /// Whether the crystal runs.
    fn crystal_runs(&self) -> bool;
    /// Starts the PLL on an oscillator, with the core still on the internal one.
    fn start_pll(&mut self, oscillator: Oscillator);
    /// Stops the PLL.
    fn stop_pll(&mut self);
    /// Whether the PLL has locked.
    fn pll_is_locked(&self) -> bool;
}

/// Starts crystal and PLL, and waits for each no longer than it may take. If the crystal fails, uses the
/// internal oscillator, which runs after a reset.
///
/// # Errors
/// [`NoClock`].
pub fn start_clock(tree: &mut impl ClockTree) -> Result<Oscillator, NoClock> {
    tree.turn_crystal(true);
    if (0..CRYSTAL_LOOKS).any(|_| tree.crystal_runs()) && locks(tree, Oscillator::Crystal) {
        return Ok(Oscillator::Crystal);
    }
    // A crystal that starts later would not be used.
    tree.turn_crystal(false);
    if locks(tree, Oscillator::Internal) { Ok(Oscillator::Internal) } else { Err(NoClock) }
}

fn locks(tree: &mut impl ClockTree, oscillator: Oscillator) -> bool {
    tree.start_pll(oscillator);
    let is_locked = (0..LOCK_LOOKS).any(|_| tree.pll_is_locked());
    if !is_locked {
        tree.stop_pll();
    }
    is_locked
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    /// A clock tree whose crystal runs, and whose PLL locks, after this many polls.
    struct Tree {
        crystal_after: Option<u32>,
        locks_on: [bool; 2],
        crystal: Option<u32>,
        pll: Option<(Oscillator, u32)>,
        looks: Cell<u32>,
    }

    impl Tree {
        fn new(crystal_after: Option<u32>, locks_on: [bool; 2]) -> Self {
            Self { crystal_after, locks_on, crystal: None, pll: None, looks: Cell::new(0) }
        }

        fn looked(&self) -> u32 {
            self.looks.set(self.looks.get() + 1);
            self.looks.get()
        }
    }

    impl ClockTree for Tree {
        fn turn_crystal(&mut self, on: bool) {
            assert!(self.pll.is_none() || !on, "the PLL's source must not change while it runs");
            self.crystal = on.then(|| self.looks.get());
        }

        fn crystal_runs(&self) -> bool {
            let now = self.looked();
            self.crystal.zip(self.crystal_after).is_some_and(|(since, after)| now - since > after)
        }

        fn start_pll(&mut self, oscillator: Oscillator) {
            assert!(self.pll.is_none(), "its source can only be set while it is off (RM0090, 7.3.2)");
            assert!(oscillator == Oscillator::Internal || self.crystal_runs());
            self.pll = Some((oscillator, self.looks.get()));
        }

        fn stop_pll(&mut self) {
            self.pll = None;
        }

        fn pll_is_locked(&self) -> bool {
            let now = self.looked();
            self.pll
                .is_some_and(|(oscillator, since)| self.locks_on[oscillator as usize] && now - since > 100)
        }
    }

    #[test]
    fn the_crystal_is_taken_if_it_starts_in_time_and_locks() {
        for (crystal_after, locks_on, expected) in [
            (Some(5_000), [true, true], Ok(Oscillator::Crystal)),
            (Some(CRYSTAL_LOOKS - 1), [true, true], Ok(Oscillator::Crystal)),
            (Some(CRYSTAL_LOOKS), [true, true], Ok(Oscillator::Internal)),
            (None, [true, true], Ok(Oscillator::Internal)),
            (Some(5_000), [false, true], Ok(Oscillator::Internal)),
            (None, [true, false], Err(NoClock)),
            (Some(5_000), [false, false], Err(NoClock)),
        ] {
            let mut tree = Tree::new(crystal_after, locks_on);
            assert_eq!(start_clock(&mut tree), expected, "{crystal_after:?} {locks_on:?}");
            assert_eq!(tree.pll.map(|(oscillator, _)| oscillator), expected.ok());
            assert_eq!(tree.crystal.is_some(), expected == Ok(Oscillator::Crystal));
            assert!(tree.looks.get() <= CRYSTAL_LOOKS + 2 * LOCK_LOOKS + 1);
        }
    }
}
