//! The mission, whatever its shape.

use kf_core::input::TickInput;
use kf_core::mission::Mission;
use kf_core::output::TickOutput;

/// What takes a tick's input and says what it means: a [`Mission`] whose shape is known when it is compiled, or one
/// behind a pointer.
pub trait Estimation {
    /// See [`Mission::tick`].
    fn tick(&mut self, input: &TickInput) -> TickOutput;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Estimation for Mission<HEAD, TAIL, E> {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        Self::tick(self, input)
    }
}

/// Where it is too large to be moved about.
impl<E: Estimation> Estimation for &mut E {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        E::tick(self, input)
    }
}
