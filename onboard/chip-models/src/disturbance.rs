//! Faults inside a chip that affect its results, not its wires.

/// Largest number of channels of a chip: the inertial unit's six.
pub const CHANNELS: usize = 6;

/// Present faults of a chip's results. A channel is an index into the model's quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Every result repeats the last one before this began, and is reported as new.
    pub frozen: bool,
    /// An error of one channel's physical quantity. The chip saturates at the end of its range, as always.
    pub offset: Option<Offset>,
    /// Flipped bits of one channel's result.
    pub flip: Option<Flip>,
}

/// An error of a physical quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// The channel.
    pub channel: usize,
    /// Size, in the quantity's unit.
    pub by: f32,
    /// Number of results still affected.
    pub results: u32,
}

/// Flipped bits of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// The channel.
    pub channel: usize,
    /// The bits.
    pub mask: u32,
    /// Number of results still affected.
    pub results: u32,
}

impl Disturbance {
    /// No fault.
    pub const NONE: Self = Self { frozen: false, offset: None, flip: None };

    /// The error of one channel for the measurement that follows.
    pub fn error(&mut self, channel: usize) -> f32 {
        match &mut self.offset {
            Some(offset) if offset.channel == channel && offset.results > 0 => {
                offset.results -= 1;
                offset.by
            }
            _ => 0.0,
        }
    }

    /// The flipped bits of one channel for the result that follows.
    pub fn flipped(&mut self, channel: usize) -> u32 {
        match &mut self.flip {
            Some(flip) if flip.channel == channel && flip.results > 0 => {
                flip.results -= 1;
                flip.mask
            }
            _ => 0,
        }
    }
}
