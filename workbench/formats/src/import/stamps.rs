//! Decides which times of a log are accepted.
//!
//! A logger's clock runs forward, and most logs have no checksum for single messages: one flipped bit makes a
//! message's time years late, or some seconds early. Such a time contradicts those of the messages around it,
//! before and after.

use super::damage::percent;

/// Stamp of a message without a time.
pub const NO_TIME: u64 = u64::MAX;
/// Largest time by which a logger's messages may be written out of order, microseconds.
const DISORDER_US: u64 = 1_000_000;
/// A clock that goes back by more, and stays there, has restarted, microseconds.
const RESTART_US: u64 = 5_000_000;
/// A logger writes many messages a second. A time farther than this from every other one is wrong,
/// microseconds.
const LONELY_US: u64 = 5_000_000;
/// Usual interval between messages for which the times above hold, microseconds.
const BRISK_US: u64 = 200_000;
/// Number of stamps on either side that decide by majority whether a clock has restarted.
const WITNESSES: usize = 16;
/// Stamps of one run within this belong together, for the witnesses, microseconds.
const TOGETHER_US: u64 = 60_000_000;

/// The result of the judgement.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Judged {
    /// Whether each stamp is accepted.
    believed: Vec<bool>,
    /// Indices of the stamps that contradict those around them, in order.
    contradicting: Vec<usize>,
    /// How often the clock restarted. Only stamps of the longest run are accepted.
    restarts: usize,
    /// Stamps of the other runs.
    of_other_runs: usize,
}

/// Judges the stamps of a log, microseconds, in the order in which they were written.
fn judge(stamps_us: &[u64]) -> Judged {
    let mut believed = vec![true; stamps_us.len()];
    let starts = starts(stamps_us);
    let mut judged = Judged { restarts: starts.len().saturating_sub(1), ..Judged::default() };
    let ends = starts.iter().skip(1).copied().chain([stamps_us.len()]);
    let longest = starts.iter().copied().zip(ends).max_by_key(|(start, end)| end - start);
    let (start, end) = longest.unwrap_or((0, 0));
    for (place, slot) in believed.iter_mut().enumerate() {
        *slot = (start..end).contains(&place);
    }
    judged.of_other_runs = stamps_us.len() - (end - start);
    let run = stamps_us.get(start..end).unwrap_or_default();
    for offset in contradicting(run) {
        if let Some(slot) = believed.get_mut(start + offset) {
            *slot = false;
            judged.contradicting.push(start + offset);
        }
    }
    judged.believed = believed;
    judged
}

/// A log's times.
#[derive(Clone, Debug, Default)]
pub struct Believed {
    /// The time of each accepted stamp, microseconds.
    pub times_us: Vec<Option<u64>>,
    /// Notes on what was left out.
    pub notes: Vec<String>,
    /// Number of stamps that have a time.
    pub stamped: usize,
}

/// Decides which of a log's stamps are accepted. `groups` are the stamps of each kind of message, in the
/// log's order; `described` gives a stamp's place in the file.
pub fn believe<'a>(
    stamps_us: &[u64],
    groups: impl Iterator<Item = &'a [u32]>,
    described: impl Fn(usize) -> String,
) -> Believed {
    believe_paced(stamps_us, 0, groups, described)
}

/// As [`believe`], for a log with a usual interval of `pace_us` between rows: in a log with a row a minute, a
/// gap of five seconds means nothing.
pub fn believe_paced<'a>(
    stamps_us: &[u64],
    pace_us: u64,
    groups: impl Iterator<Item = &'a [u32]>,
    described: impl Fn(usize) -> String,
) -> Believed {
    let stamped: Vec<usize> = stamps_us
        .iter()
        .enumerate()
        .filter_map(|(index, stamp)| (*stamp != NO_TIME).then_some(index))
        .collect();
    let known: Vec<u64> = stamped.iter().filter_map(|index| stamps_us.get(*index)).copied().collect();
    let slowness = (pace_us / BRISK_US).max(1);
    let brisk: Vec<u64> = known.iter().map(|stamp| stamp / slowness).collect();
    let Judged { believed, contradicting, restarts, of_other_runs } = judge(&brisk);
    let mut times_us = vec![None; stamps_us.len()];
    for ((index, time_us), believed) in stamped.iter().zip(&known).zip(&believed) {
        if let Some(slot) = times_us.get_mut(*index).filter(|_| *believed) {
            *slot = Some(*time_us);
        }
    }
    let mut contradicting: Vec<usize> =
        contradicting.iter().filter_map(|place| stamped.get(*place)).copied().collect();
    for group in groups {
        contradicting.extend(leave_out_of_order(group, &mut times_us));
    }
    contradicting.sort_unstable();
    let mut notes = Vec::new();
    if restarts > 0 {
        notes.push(format!(
            "the autopilot's clock restarted within the log ({restarts}x): the longest stretch is used; messages of the \
             others, left out: {of_other_runs} ({})",
            percent(of_other_runs, known.len())
        ));
    }
    if let Some(first) = contradicting.first() {
        let time_s = stamps_us.get(*first).copied().unwrap_or(0) as f64 / 1e6;
        let count = contradicting.len();
        notes.push(format!(
            "messages whose time contradicts those around them, left out: {count} ({}); the first is at {}, with a time of \
             {time_s:.3} s since the start",
            percent(count, known.len()),
            described(*first)
        ));
    }
    Believed { times_us, notes, stamped: known.len() }
}

/// Removes the times of messages of one kind that go back: a logger writes those of one kind in order.
/// `stamps` are their indices in `times_us`. Returns the removed ones.
fn leave_out_of_order(stamps: &[u32], times_us: &mut [Option<u64>]) -> Vec<usize> {
    let timed = |stamp: &u32| Some((*stamp as usize, times_us.get(*stamp as usize).copied().flatten()?));
    let found: Vec<(usize, u64)> = stamps.iter().filter_map(timed).collect();
    if found.is_sorted_by_key(|(_, time_us)| *time_us) {
        return Vec::new();
    }
    let values: Vec<u64> = found.iter().map(|(_, time_us)| *time_us).collect();
    let mut is_chained = vec![false; values.len()];
    for place in longest_ascending(&values) {
        if let Some(slot) = is_chained.get_mut(place) {
            *slot = true;
        }
    }
    let mut left_out = Vec::new();
    for ((stamp, _), _) in found.iter().zip(is_chained).filter(|(_, chained)| !chained) {
        if let Some(slot) = times_us.get_mut(*stamp) {
            *slot = None;
            left_out.push(*stamp);
        }
    }
    left_out
}

/// The stamps that contradict those around them, in a recording whose clock may have been reset: every run
/// counts.
pub fn contradicting_of_runs(stamps_us: &[u64]) -> Vec<usize> {
    let starts = starts(stamps_us);
    let ends = starts.iter().skip(1).copied().chain([stamps_us.len()]);
    let runs = starts.iter().copied().zip(ends);
    runs.flat_map(|(start, end)| {
        contradicting(stamps_us.get(start..end).unwrap_or_default())
            .into_iter()
            .map(move |offset| start + offset)
    })
    .collect()
}

/// Indices at which runs of the clock begin.
fn starts(stamps_us: &[u64]) -> Vec<usize> {
    let mut starts = if stamps_us.is_empty() { Vec::new() } else { vec![0] };
    for (index, pair) in stamps_us.windows(2).enumerate() {
        let [before, after] = pair else { continue };
        // A flipped bit may have moved a stamp to the end of the clock.
        if after.saturating_add(RESTART_US) >= *before {
            continue;
        }
        let at = index + 1;
        let run = starts.last().copied().unwrap_or(0);
        let earlier = stamps_us.get(at.saturating_sub(WITNESSES).max(run)..at).unwrap_or_default();
        let later = stamps_us.get(at..(at + WITNESSES).min(stamps_us.len())).unwrap_or_default();
        let near = |center: u64| move |stamp: &&u64| stamp.abs_diff(center) <= TOGETHER_US;
        let of_before = |stamp: &&u64| **stamp > after.saturating_add(RESTART_US) && near(*before)(stamp);
        let of_after = |stamp: &&u64| stamp.saturating_add(RESTART_US) < *before && near(*after)(stamp);
        let most = |found: usize, all: usize| all >= 4 && found * 4 >= all * 3;
        if most(earlier.iter().filter(of_before).count(), earlier.len())
            && most(later.iter().filter(of_after).count(), later.len())
        {
            starts.push(at);
        }
    }
    starts
}

/// The stamps of one run that do not agree with the others.
fn contradicting(run: &[u64]) -> Vec<usize> {
    let is_forward = |pair: &[u64]| matches!(pair, [a, b] if a <= b && b - a <= LONELY_US);
    if run.windows(2).all(is_forward) {
        return Vec::new();
    }
    let mut is_chained = vec![false; run.len()];
    for place in longest_ascending(run) {
        if let Some(slot) = is_chained.get_mut(place) {
            *slot = true;
        }
    }
    let chain: Vec<(usize, u64)> = is_chained
        .iter()
        .zip(run)
        .enumerate()
        .filter_map(|(place, (chained, stamp))| chained.then_some((place, *stamp)))
        .collect();
    for (index, (place, stamp)) in chain.iter().enumerate() {
        let near = |other: Option<&(usize, u64)>| {
            other.is_some_and(|(_, other)| other.abs_diff(*stamp) <= LONELY_US)
        };
        let before = index.checked_sub(1).and_then(|before| chain.get(before));
        // The only stamp of a log has nothing to contradict.
        if chain.len() > 1
            && !near(before)
            && !near(chain.get(index + 1))
            && let Some(slot) = is_chained.get_mut(*place)
        {
            *slot = false;
        }
    }
    // The nearest stamp of the chain after each place.
    let mut after = vec![None; run.len()];
    let mut next = None;
    for ((slot, stamp), chained) in after.iter_mut().zip(run).zip(&is_chained).rev() {
        *slot = next;
        next = if *chained { Some(*stamp) } else { next };
    }
    let mut before = None;
    let mut found = Vec::new();
    for (place, ((stamp, chained), after)) in run.iter().zip(&is_chained).zip(after).enumerate() {
        let near = |other: Option<u64>| other.is_some_and(|other| other.abs_diff(*stamp) <= DISORDER_US);
        if *chained {
            before = Some(*stamp);
        } else if !near(before) && !near(after) {
            found.push(place);
        }
    }
    found
}

/// Indices of a longest non-decreasing subsequence, by patience sorting.
fn longest_ascending(values: &[u64]) -> Vec<usize> {
    // Index of the smallest last value of a chain of each length.
    let mut tails: Vec<usize> = Vec::new();
    let mut before = vec![usize::MAX; values.len()];
    for (place, value) in values.iter().enumerate() {
        let length = tails.partition_point(|tail| values.get(*tail).is_some_and(|last| last <= value));
        if let Some(slot) = before.get_mut(place) {
            *slot = length.checked_sub(1).and_then(|last| tails.get(last)).copied().unwrap_or(usize::MAX);
        }
        match tails.get_mut(length) {
            Some(slot) => *slot = place,
            None => tails.push(place),
        }
    }
    let mut chain = Vec::with_capacity(tails.len());
    let mut next = tails.last().copied();
    while let Some(place) = next {
        chain.push(place);
        next = before.get(place).copied().filter(|place| *place != usize::MAX);
    }
    chain.reverse();
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(from_s: u64, count: u64) -> Vec<u64> {
        (0..count).map(|k| from_s * 1_000_000 + k * 100_000).collect()
    }

    #[test]
    fn a_flipped_bit_of_one_stamp_is_found_wherever_it_is() {
        let clean = steady(80, 200);
        assert_eq!(judge(&clean).contradicting, Vec::<usize>::new());
        for place in 0..clean.len() {
            for bit in 21..63 {
                let mut stamps = clean.clone();
                stamps[place] ^= 1 << bit;
                let off = stamps[place].abs_diff(clean[place]);
                let judged = judge(&stamps);
                assert_eq!(judged.restarts, 0, "{place} {bit}");
                let is_inner = (60..140).contains(&place);
                if is_inner || off > LONELY_US {
                    assert_eq!(judged.contradicting, [place], "bit {bit} of {place}");
                } else {
                    // At an end of the log, some seconds off: the adjacent one may be the wrong one, or none.
                    let (found, count) = (&judged.contradicting, judged.contradicting.len());
                    assert!(count <= 1 && found.iter().all(|at| at.abs_diff(place) <= 1), "{place} {bit}");
                }
            }
        }
    }

    #[test]
    fn a_clock_that_starts_anew_is_not_taken_for_damage() {
        let mut stamps = steady(500, 100);
        stamps.extend(steady(2, 300));
        let judged = judge(&stamps);
        assert_eq!((judged.restarts, judged.of_other_runs), (1, 100));
        assert!(judged.contradicting.is_empty());
        assert!(judged.believed[100..].iter().all(|believed| *believed));
        assert!(!judged.believed[..100].iter().any(|believed| *believed));
    }

    #[test]
    fn disorder_and_gaps_are_no_damage() {
        let mut stamps = steady(10, 100);
        for k in (0..90).step_by(7) {
            stamps.swap(k, k + 5);
        }
        stamps.extend(steady(3_000, 100));
        assert_eq!(judge(&stamps).contradicting, Vec::<usize>::new());
        assert_eq!(judge(&[]), Judged::default());
        assert_eq!(judge(&[5]).believed, [true]);
    }
}
