//! A flight and its name.

use replay::Replay;

/// A flight ready to be replayed, and what the user calls it.
pub struct NamedReplay<'a> {
    /// The file.
    pub file: String,
    /// The flight, the model and the calibration.
    pub replay: Replay<'a>,
}
