//! Decides which frames' receiver's times are accepted: they have no CRC.

use super::clock::boot_us;
use super::frame::Packet;
use super::value::{self, Stamp, Timed};
use crate::import::gps_time::utc_text;
use crate::import::stamps;

/// A frame's time within this of the one computed from its message's own clock is right, whatever the others
/// are.
const AGREES_US: u64 = 1_000_000;

/// The data received from a sender.
#[derive(Default)]
pub struct Received {
    /// Whether the stream has no receiver's times: each frame then counts as received at the latest time that
    /// its sender gave.
    is_unstamped: bool,
    /// That time, and whether its clock counts milliseconds since the start, as in all of a sender's messages
    /// except those of its receiver and its sensors.
    latest: Option<(u64, bool)>,
    values: Vec<Timed>,
    /// Each frame's number, receiver's time, and the end index of its values.
    frames: Vec<(usize, u64, usize)>,
}

impl Received {
    /// Empty, for a stream with or without receiver's times.
    pub fn new(is_unstamped: bool) -> Self {
        Self { is_unstamped, ..Self::default() }
    }

    /// Adds a frame.
    pub fn take(&mut self, packet: &Packet) {
        let begin = self.values.len();
        value::take(packet, &mut self.values);
        let mut recorded_us = packet.recorded_us;
        if self.is_unstamped {
            let own = self.values.get_mut(begin..).unwrap_or_default();
            let said =
                |timed: &Timed| Some((boot_us(timed.stamp)?, matches!(timed.stamp, Stamp::Milliseconds(_))));
            let said = own.iter().find_map(said);
            let is_better =
                |(_, is_of_start): &(u64, bool)| *is_of_start || self.latest.is_none_or(|(_, known)| !known);
            self.latest = said.filter(is_better).or(self.latest);
            recorded_us = self.latest.map_or(0, |(time_us, _)| time_us);
            own.iter_mut().for_each(|timed| timed.recorded_us = recorded_us);
        }
        self.frames.push((packet.number, recorded_us, self.values.len()));
    }

    /// The values of the frames whose time is accepted, and a note on the others.
    pub fn believed(self) -> (Vec<Timed>, Option<String>) {
        if self.is_unstamped {
            // There are no receiver's times to check.
            let said = "a stream without receiver's times: those of its messages are used, and for messages without one the latest before \
                        them";
            return (self.values, Some(said.to_owned()));
        }
        let stamps_us: Vec<u64> = self.frames.iter().map(|(_, stamp, _)| *stamp).collect();
        let contradicting = stamps::contradicting_of_runs(&stamps_us);
        let begin = |frame: usize| {
            frame.checked_sub(1).and_then(|before| self.frames.get(before)).map_or(0, |(_, _, end)| *end)
        };
        let ahead_us = median_ahead(&self.values);
        let is_by_its_own = |frame: &usize| {
            let (Some((_, stamp, end)), Some(ahead_us)) = (self.frames.get(*frame), ahead_us) else {
                return false;
            };
            let own = self.values.get(begin(*frame)..*end).unwrap_or_default();
            own.iter().find_map(|timed| boot_us(timed.stamp)).is_some_and(|own_us| {
                (i128::from(*stamp) - i128::from(own_us)).abs_diff(i128::from(ahead_us))
                    <= u128::from(AGREES_US)
            })
        };
        let wrong: Vec<usize> = contradicting.into_iter().filter(|frame| !is_by_its_own(frame)).collect();
        if wrong.is_empty() {
            return (self.values, None);
        }
        let said = said(&self.frames, &wrong);
        let mut kept = Vec::with_capacity(self.values.len());
        let mut next = wrong.iter().peekable();
        for (frame, (_, _, end)) in self.frames.iter().enumerate() {
            if next.next_if_eq(&&frame).is_none() {
                kept.extend(self.values.get(begin(frame)..*end).unwrap_or_default());
            }
        }
        (kept, Some(said))
    }
}

/// Median lead of the receiver's clock over the sender's.
fn median_ahead(values: &[Timed]) -> Option<i64> {
    let ahead =
        |timed: &Timed| i64::try_from(timed.recorded_us).ok()?.checked_sub_unsigned(boot_us(timed.stamp)?);
    let mut found: Vec<i64> = values.iter().filter_map(ahead).collect();
    let middle = found.len() / 2;
    (!found.is_empty()).then(|| *found.select_nth_unstable(middle).1)
}

fn said(frames: &[(usize, u64, usize)], wrong: &[usize]) -> String {
    let Some((first, (number, stamp, _))) =
        wrong.first().and_then(|first| Some((*first, *frames.get(*first)?)))
    else {
        return String::new();
    };
    let is_right = |(index, _): &(usize, &(usize, u64, usize))| wrong.binary_search(index).is_err();
    let all = || frames.iter().enumerate();
    let neighbour = all()
        .skip(first)
        .find(is_right)
        .or_else(|| all().take(first).rev().find(is_right))
        .map_or(stamp, |(_, (_, stamp, _))| *stamp);
    let off_s = (i128::from(stamp) - i128::from(neighbour)) as f64 / 1e6;
    let year = |stamp: u64| {
        i64::try_from(stamp / 1_000_000)
            .ok()
            .and_then(utc_text)
            .and_then(|text| text.split('-').next().map(str::to_owned))
            .unwrap_or_else(|| "that no calendar has".to_owned())
    };
    let when = if year(stamp) == year(neighbour) {
        let direction = if off_s < 0.0 { "before" } else { "after" };
        format!("is {:.1} s {direction} that of the frames around it", off_s.abs())
    } else {
        format!("is in the year {}", year(stamp))
    };
    match wrong.len() {
        1 => format!("frame {number}: the receiver's time {when}; frame left out"),
        count => format!(
            "frames whose receiver's time contradicts those around them, left out: {count}; the first is frame {number}, whose \
             time {when}"
        ),
    }
}
