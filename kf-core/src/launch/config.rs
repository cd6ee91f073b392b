//! Limits of the decision.

/// Limits of the decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchConfig {
    /// How long the wire must read open without a closed reading between, seconds.
    pub debounce_s: f32,
    /// Largest time between the edge and a departure of the force, and between the first sign and the last
    /// message, seconds.
    pub window_s: f32,
    /// Departure of the specific force's magnitude from its captive mean, as a share of that mean.
    pub departure: f32,
    /// The same in standard deviations of the captive magnitude, smoothed over 30 ms.
    pub departure_sigmas: f32,
    /// Mean intervals between messages after which they are silent.
    pub silent_intervals: u16,
    /// How long an unconfirmed open wire, a wire that cannot be read, or an unconfirmed sign in the force is
    /// left undecided, seconds.
    pub undecided_s: f32,
    /// Specific force below which the vehicle is near free fall, g.
    pub fall_load: f32,
    /// Duration of near free fall that shows a launch together with silence or the climb rate, seconds.
    pub fall_s: f32,
    /// Duration of near free fall that shows a launch by itself if no wire contradicts it, seconds.
    pub long_fall_s: f32,
}

impl LaunchConfig {
    /// From the module's physics. `undecided_s`: an engine must have been started, some blocks compared, and
    /// slow messages missed.
    pub const DEFAULT: Self = Self {
        debounce_s: 0.02,
        window_s: 0.25,
        departure: 0.3,
        departure_sigmas: 4.0,
        silent_intervals: 5,
        undecided_s: 3.0,
        fall_load: 0.3,
        fall_s: 0.3,
        long_fall_s: 2.0,
    };
}
