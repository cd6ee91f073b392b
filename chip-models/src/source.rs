//! What surrounds a chip.

/// A physical quantity by time. Closures are sources: `|time_us| Air { .. }`.
pub trait Source<Quantity> {
    /// The quantity at a time, microseconds by the flight computer's clock.
    fn at(&mut self, time_us: u64) -> Quantity;
}

impl<Quantity, Function: FnMut(u64) -> Quantity> Source<Quantity> for Function {
    fn at(&mut self, time_us: u64) -> Quantity {
        self(time_us)
    }
}

/// A quantity that stays what it was last set to: for a flight that is replayed sample by sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<Quantity>(pub Quantity);

impl<Quantity: Copy> Source<Quantity> for Held<Quantity> {
    fn at(&mut self, _time_us: u64) -> Quantity {
        self.0
    }
}

/// The air at a barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Static pressure, pascals.
    pub pressure_pa: f32,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: f32,
}
