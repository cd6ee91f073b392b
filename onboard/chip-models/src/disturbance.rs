//! What a chip makes of its surroundings when something inside it is wrong: its results, not its wires.

/// Channels that a chip has at most: the inertial unit's six.
pub const CHANNELS: usize = 6;

/// What is wrong with a chip's results at present. A channel is a place in the order in which the model has
/// its quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Every result is the last one before this began, and is said to be new.
    pub frozen: bool,
    /// An error of one channel's physical quantity. The chip stops at the end of its range, as always.
    pub offset: Option<Offset>,
    /// Bits of one channel's result that are flipped.
    pub flip: Option<Flip>,
}

/// An error of a physical quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// Of which channel.
    pub channel: usize,
    /// How much, in the quantity's unit.
    pub by: f32,
    /// Results that it is still in.
    pub results: u32,
}

/// Flipped bits of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// Of which channel.
    pub channel: usize,
    /// The bits.
    pub mask: u32,
    /// Results that they are still flipped in.
    pub results: u32,
}

impl Disturbance {
    /// Nothing is wrong.
    pub const NONE: Self = Self { frozen: false, offset: None, flip: None };

    /// The error of one channel, which is about to be measured.
    pub fn error(&mut self, channel: usize) -> f32 {
        match &mut self.offset {
            Some(offset) if offset.channel == channel && offset.results > 0 => {
                offset.results -= 1;
                offset.by
            }
            _ => 0.0,
        }
    }

    /// The bits of one channel's result that are flipped; it is about to be given.
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
