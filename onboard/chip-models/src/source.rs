//! The surroundings of a chip.

/// A physical quantity as a function of time. Closures are sources: `|time_us| Air { .. }`.
pub trait Source<Quantity> {
    /// The quantity at a time, microseconds by the flight computer's clock.
    fn at(&mut self, time_us: u64) -> Quantity;
}

impl<Quantity, Function: FnMut(u64) -> Quantity> Source<Quantity> for Function {
    fn at(&mut self, time_us: u64) -> Quantity {
        self(time_us)
    }
}

/// A quantity that keeps its last set value, for replaying a flight sample by sample.
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

/// The motion that an inertial unit is subject to, in the chip's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Specific force, m/s^2.
    pub accel_mps2: [f32; 3],
    /// Angular rate, rad/s.
    pub gyro_radps: [f32; 3],
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: f32,
}
