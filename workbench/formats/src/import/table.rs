//! Messages of a log as the rows of a flight: one row a time, one column a value.

use std::collections::BTreeSet;

use flight_data::{Channel, Column, Flight, Header};

/// Where a value of a message goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// A known column.
    Channel(Channel),
    /// A signal of that name.
    Signal(String),
}

impl Destination {
    /// A signal's.
    pub fn signal(name: impl Into<String>) -> Self {
        Self::Signal(name.into())
    }
}

/// The messages of one kind from one source. Each has the same values; one that is NaN is not there.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Values a message.
    width: usize,
    /// Which of the log's stamps each message has.
    stamps: Vec<u32>,
    /// The messages' values, one message after the other.
    values: Vec<f32>,
}

impl Group {
    /// Without messages yet, each to have so many values.
    pub const fn new(width: usize) -> Self {
        Self { width, stamps: Vec::new(), values: Vec::new() }
    }

    /// Adds a message; values that it lacks are NaN.
    pub fn push(&mut self, stamp: u32, values: impl IntoIterator<Item = f32>) {
        self.stamps.push(stamp);
        let end = self.values.len() + self.width;
        self.values.extend(values.into_iter().take(self.width));
        self.values.resize(end, f32::NAN);
    }

    /// How many messages there are.
    pub fn len(&self) -> usize {
        self.stamps.len()
    }

    /// Which of the log's stamps each message has, in the log's order.
    pub fn stamps(&self) -> &[u32] {
        &self.stamps
    }

    /// The values in one place of the messages, with their stamps.
    pub fn column(&self, place: usize) -> impl Iterator<Item = (u32, f32)> + '_ {
        let values = self.values.iter().skip(place).step_by(self.width.max(1));
        self.stamps.iter().copied().zip(values.copied()).filter(move |_| place < self.width)
    }
}

/// Stamps with values; NaN is no value.
#[derive(Clone, Debug)]
pub enum Samples<'a> {
    /// Made for this column.
    Own(Vec<(u32, f32)>),
    /// The same, positions.
    Double(Vec<(u32, f64)>),
    /// A group's values in one place, where they are.
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

/// One column to be filled.
#[derive(Clone, Debug)]
pub struct Filling<'a> {
    /// Where it goes.
    pub destination: Destination,
    /// What is in it.
    pub samples: Samples<'a>,
}

impl<'a> Filling<'a> {
    /// Of a group's values in one place.
    pub const fn of(destination: Destination, group: &'a Group, place: usize) -> Self {
        Self { destination, samples: Samples::Of(group, place) }
    }
}

/// Columns put together, and what that cost.
pub struct Table {
    /// The flight.
    pub flight: Flight,
    /// Values that share their column and time with a later one, which counts.
    pub repeated: usize,
    /// Signals that were given twice; the first counts.
    pub doubled: Vec<String>,
    /// Microseconds of the log's clock at the flight's time zero.
    pub start_us: u64,
}

/// The row of a stamp that has none.
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

/// Puts columns together. `times_us` has the time of each stamp, or none for a stamp that is not to be
/// believed; what has such a stamp is left out.
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
