//! Turns the messages of a log into the rows of a flight: one row a time, one column a value.

use std::collections::BTreeSet;

use flight_data::{Channel, Column, Flight, Header};

/// Destination of a message's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// A known column.
    Channel(Channel),
    /// A signal of that name.
    Signal(String),
}

impl Destination {
    /// The destination of a signal.
    pub fn signal(name: impl Into<String>) -> Self {
        Self::Signal(name.into())
    }
}

/// The messages of one kind from one source. Each has the same values; NaN means that the value is missing.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Values a message.
    width: usize,
    /// Index of each message's stamp in the log.
    stamps: Vec<u32>,
    /// The messages' values, one message after the other.
    values: Vec<f32>,
}

impl Group {
    /// Without messages yet; each message will have `width` values.
    pub const fn new(width: usize) -> Self {
        Self { width, stamps: Vec::new(), values: Vec::new() }
    }

    /// Adds a message; its missing values are NaN.
    pub fn push(&mut self, stamp: u32, values: impl IntoIterator<Item = f32>) {
        self.stamps.push(stamp);
        let end = self.values.len() + self.width;
        self.values.extend(values.into_iter().take(self.width));
        self.values.resize(end, f32::NAN);
    }

    /// Number of messages.
    pub fn len(&self) -> usize {
        self.stamps.len()
    }

    /// Index of each message's stamp in the log, in the log's order.
    pub fn stamps(&self) -> &[u32] {
        &self.stamps
    }

    /// The values at one index of the messages, with their stamps.
    pub fn column(&self, place: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let values = self.values.iter().skip(place).step_by(self.width.max(1));
        self.stamps.iter().copied().zip(values.copied()).filter(move |_| place < self.width)
    }
}

/// Values with their stamps; NaN is a missing value.
#[derive(Clone, Debug)]
pub enum Samples<'a> {
    /// Values made for this column.
    Own(Vec<(u32, f32)>),
    /// The same, for positions.
    Double(Vec<(u32, f64)>),
    /// A group's values at one index, without a copy.
    Of(&'a Group, usize),
}

impl From<Vec<(u32, f32)>> for Samples<'_> {
    fn from(samples: Vec<(u32, f32)>) -> Self {
        Self::Own(samples)
    }
}

impl Samples<'_> {
    /// Every stamp with a value.
    pub fn each(&self, mut take: impl FnMut(u32, f64)) {
        let single = |(stamp, value): (u32, f32)| (stamp, f64::from(value));
        let mut take = |(stamp, value): (u32, f64)| {
            if !value.is_nan() {
                take(stamp, value);
            }
        };
        match self {
            Self::Own(samples) => samples.iter().copied().map(single).for_each(&mut take),
            Self::Double(samples) => samples.iter().copied().for_each(&mut take),
            Self::Of(group, place) => group.column(*place).map(single).for_each(&mut take),
        }
    }
}

/// A column to be filled.
#[derive(Clone, Debug)]
pub struct Filling<'a> {
    /// Its destination.
    pub destination: Destination,
    /// Its values.
    pub samples: Samples<'a>,
}

impl<'a> Filling<'a> {
    /// A column of a group's values at one index.
    pub const fn of(destination: Destination, group: &'a Group, place: usize) -> Self {
        Self { destination, samples: Samples::Of(group, place) }
    }
}

/// The assembled columns, and what was lost.
pub struct Table {
    /// The flight.
    pub flight: Flight,
    /// Values replaced by a later one with the same column and time.
    pub repeated: usize,
    /// Signals that were given twice; the first is used.
    pub doubled: Vec<String>,
    /// Microseconds of the log's clock at the flight's time zero.
    pub start_us: u64,
}

/// Row of a stamp that has none.
const NO_ROW: u32 = u32::MAX;

/// The row of each stamp that is used. Messages mostly come in order, so most rows are the next one.
fn rows_of(times_us: &[Option<u64>], is_used: &[bool], rows_us: &[u64]) -> Vec<u32> {
    let mut next = 0;
    let of = |(time_us, is_used): (&Option<u64>, &bool)| {
        let time_us = time_us.as_ref().filter(|_| *is_used)?;
        if rows_us.get(next) != Some(time_us) {
            next = rows_us.binary_search(time_us).ok()?;
        }
        let row = next;
        next += 1;
        u32::try_from(row).ok()
    };
    times_us.iter().zip(is_used).map(of).map(|row| row.unwrap_or(NO_ROW)).collect()
}

/// Assembles columns into a flight. `times_us` has the time of each stamp, `None` for a stamp that is not
/// accepted; values with such a stamp are left out.
pub fn assemble(header: Header, times_us: &[Option<u64>], fillings: Vec<Filling<'_>>) -> Table {
    let mut is_used = vec![false; times_us.len()];
    for filling in &fillings {
        filling.samples.each(|stamp, _| {
            if let Some(slot) = is_used.get_mut(stamp as usize) {
                *slot = true;
            }
        });
    }
    let used = times_us.iter().zip(&is_used).filter_map(|(time, used)| time.filter(|_| *used));
    let mut rows_us: Vec<u64> = used.collect();
    rows_us.sort_unstable();
    rows_us.dedup();
    let start_us = rows_us.first().copied().unwrap_or(0);
    let mut flight = Flight {
        header,
        time_s: rows_us.iter().map(|time_us| (time_us - start_us) as f64 / 1e6).collect(),
        ..Flight::default()
    };
    let rows = rows_of(times_us, &is_used, &rows_us);
    let mut repeated = 0;
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let mut doubled = Vec::new();
    for filling in fillings {
        let mut column = match &filling.destination {
            Destination::Signal(name) => Column::empty_named(name, rows_us.len()),
            Destination::Channel(_) => Column::empty(rows_us.len()),
        };
        let mut any = false;
        let mut latest = NO_ROW;
        filling.samples.each(|stamp, value| {
            let Some(row) = rows.get(stamp as usize).copied().filter(|row| *row != NO_ROW) else { return };
            repeated += usize::from(latest == row);
            latest = row;
            any |= column.set_f64(row as usize, Some(value));
        });
        if !any {
            continue;
        }
        match filling.destination {
            Destination::Channel(channel) => flight.set_channel(channel, column),
            Destination::Signal(name) => {
                if taken.insert(name.clone()) {
                    flight.extra.push((name, column));
                } else {
                    doubled.push(name);
                }
            }
        }
    }
    Table { flight, repeated, doubled, start_us }
}
