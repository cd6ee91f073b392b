//! A flight in memory: named channels on one time axis.

mod channel;
mod column;

pub use channel::Channel;
pub use column::Column;

/// What the altitudes of a flight are measured from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AltitudeDatum {
    /// Mean sea level.
    #[default]
    Msl,
    /// The WGS-84 ellipsoid.
    Ellipsoid,
}

/// The `# key: value` lines at a flight's head.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The vehicle.
    pub vehicle: String,
    /// Where the flight comes from.
    pub source: String,
    /// What its altitudes are measured from.
    pub altitude_datum: AltitudeDatum,
    /// Every other key, in file order.
    pub other: Vec<(String, String)>,
}

/// One flight. Every column has one cell a row.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// The header.
    pub header: Header,
    /// Time of each row, seconds, as written in the file (it may repeat or run backward: the
    /// estimator counts such rows and ignores them).
    pub time_s: Vec<f64>,
    /// The known channels that the flight has.
    pub channels: Vec<(Channel, Column)>,
    /// Columns of other names, offered as signals.
    pub extra: Vec<(String, Column)>,
}

impl Flight {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// The column of a channel, if the flight has it.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> Option<&Column> {
        self.channels.iter().find_map(|(name, column)| (*name == channel).then_some(column))
    }
}
