//! Finds records of an IGC log whose time contradicts those around them.
//!
//! Lines of the format have no checksum. One wrong digit of an hour makes a record hours early or late.
//! Everything after a late one seems to go back in time, which an estimator ignores; a record half a day late
//! even counts as a midnight.

use super::log::lines;
use super::records;

/// Number of records after one that decide by majority whether the clock continued from it.
const WITNESSES: usize = 16;
/// Records within this, plus the usual time of that many records, belong together, seconds: `TOGETHER_US` of
/// the other logs.
const TOGETHER_S: u32 = 60;
const DAY_S: u32 = 86_400;
/// A clock that goes back by more has passed midnight.
pub const HALF_DAY_S: u32 = 43_200;

/// A record whose time is not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// Its line, from 0.
    pub line: usize,
    /// Its second of the day.
    pub second: u32,
    /// Second of the day of the last accepted fix before it; `None` for the first.
    pub before: Option<u32>,
}

/// What is left out because of its time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Judged {
    /// Lines that are left out, from 0, in order.
    pub left_out: Vec<usize>,
    /// Number that contradict those around them.
    pub contradicting: usize,
    /// The first one that contradicts.
    pub first: Option<Contradiction>,
    /// How often the clock went back and stayed there: only fixes of the longest run are used.
    pub restarts: usize,
    /// Fixes of the other runs.
    pub of_other_runs: usize,
}

/// One fix.
#[derive(Clone, Copy)]
struct Timed {
    line: u32,
    second: u32,
}

/// Judges the fixes and data records of a log.
pub fn judge(text: &[u8]) -> Judged {
    let mut fixes: Vec<Timed> = Vec::new();
    let mut has_data = false;
    for (line, record) in (0_u32..).zip(lines(text)) {
        has_data |= record.first() == Some(&b'K');
        fixes.extend(records::fix_time(record).map(|second| Timed { line, second }));
    }
    let near_s = TOGETHER_S + WITNESSES as u32 * usual_step_s(&fixes);
    let is_brisk =
        |pair: &[Timed]| matches!(pair, [one, next] if forward_s(one.second, next.second) <= near_s);
    let mut judged = Judged::default();
    if !fixes.windows(2).all(is_brisk) {
        leave_out_contradicting(&mut fixes, near_s, &mut judged);
        leave_out_other_runs(&mut fixes, near_s, &mut judged);
    }
    if has_data {
        leave_out_data(text, &fixes, near_s, &mut judged);
    }
    judged.left_out.sort_unstable();
    judged
}

/// Seconds from one time of day to another, across midnight if needed.
const fn forward_s(from: u32, to: u32) -> u32 {
    (to + DAY_S - from) % DAY_S
}

fn apart_s(one: u32, other: u32) -> u32 {
    forward_s(one, other).min(forward_s(other, one))
}

/// Median time between fixes, seconds.
fn usual_step_s(fixes: &[Timed]) -> u32 {
    let steps = fixes.iter().zip(fixes.iter().skip(1)).map(|(one, next)| apart_s(one.second, next.second));
    let mut steps: Vec<u32> = steps.collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0 } else { *steps.select_nth_unstable(middle).1 }
}

/// Removes fixes from which those after them do not continue.
fn leave_out_contradicting(fixes: &mut Vec<Timed>, near_s: u32, judged: &mut Judged) {
    let mut believed: Vec<Timed> = Vec::with_capacity(fixes.len());
    for (place, fix) in fixes.iter().enumerate() {
        let after = fixes.get(place + 1..).unwrap_or_default();
        let after = after.get(..WITNESSES.min(after.len())).unwrap_or_default();
        let near = |center: u32| after.iter().filter(|other| apart_s(center, other.second) <= near_s).count();
        let most = |count: usize| 2 * count > after.len();
        let before = believed.last().map(|before| before.second);
        let is_believed = match before {
            Some(before) if apart_s(before, fix.second) <= near_s => true,
            // The clock continues from the one before; or, at the log's end, nothing continues from this one.
            Some(before) => !most(near(before)) && near(fix.second) > 0,
            None => {
                let goes_on = after.first().is_some_and(|next| most(near(next.second)));
                near(fix.second) > 0 || !goes_on
            }
        };
        if is_believed {
            believed.push(*fix);
        } else {
            judged.leave_out(fix.line as usize, fix.second, before);
        }
    }
    *fixes = believed;
}

/// Removes all but the longest run, where the clock goes back and stays there.
fn leave_out_other_runs(fixes: &mut Vec<Timed>, near_s: u32, judged: &mut Judged) {
    let goes_back = |one: &Timed, next: &Timed| {
        let back_s = one.second.saturating_sub(next.second);
        back_s > near_s && back_s <= HALF_DAY_S
    };
    let pairs = fixes.iter().zip(fixes.iter().skip(1));
    let starts: Vec<usize> =
        (1..).zip(pairs).filter_map(|(place, (one, next))| goes_back(one, next).then_some(place)).collect();
    let ends = starts.iter().copied().chain([fixes.len()]);
    let runs = [0].into_iter().chain(starts.iter().copied()).zip(ends);
    // Of two equally long ones, the first.
    let longest = runs.reduce(|best, run| if run.1 - run.0 > best.1 - best.0 { run } else { best });
    let (start, end) = longest.unwrap_or((0, fixes.len()));
    judged.restarts = starts.len();
    judged.of_other_runs = fixes.len() - (end - start);
    for (place, fix) in fixes.iter().enumerate() {
        if !(start..end).contains(&place) {
            judged.left_out.push(fix.line as usize);
        }
    }
    fixes.truncate(end);
    fixes.drain(..start);
}

/// Removes data records that are neither near the adjacent fixes in the file nor between them.
fn leave_out_data(text: &[u8], fixes: &[Timed], near_s: u32, judged: &mut Judged) {
    let mut after = fixes.iter().peekable();
    let mut before: Option<u32> = None;
    for (line, record) in (0_u32..).zip(lines(text)) {
        while let Some(fix) = after.next_if(|fix| fix.line < line) {
            before = Some(fix.second);
        }
        let Some(second) = records::data_time(record) else { continue };
        let next = after.peek().map(|fix| fix.second);
        let is_near = [before, next].into_iter().flatten().any(|fix| apart_s(fix, second) <= near_s);
        let is_between =
            before.zip(next).is_some_and(|(from, to)| forward_s(from, second) <= forward_s(from, to));
        if !is_near && !is_between && (before, next) != (None, None) {
            judged.leave_out(line as usize, second, before);
        }
    }
}

impl Judged {
    fn leave_out(&mut self, line: usize, second: u32, before: Option<u32>) {
        self.left_out.push(line);
        self.contradicting += 1;
        let found = Contradiction { line, second, before };
        if self.first.is_none_or(|first| line < first.line) {
            self.first = Some(found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log with a fix at each time, hhmmss.
    fn log(times: &[&str]) -> String {
        let line = |time: &&str| format!("B{time}5407121N00249342WA0028000421\r\n");
        times.iter().map(line).collect()
    }

    /// A fix a second for a minute, starting at a time hhmm.
    fn minute(from: &str) -> Vec<String> {
        (0..60).map(|second| format!("{from}{second:02}")).collect()
    }

    fn of(times: &[String]) -> Judged {
        judge(log(&times.iter().map(String::as_str).collect::<Vec<_>>()).as_bytes())
    }

    #[test]
    fn wrong_digits_of_an_hour_are_left_out_and_what_follows_them_is_not() {
        // Five hours late, nine hours early, and thirteen hours late, which would count as a midnight.
        for wrong in ["150020", "010020", "230020"] {
            let mut times = minute("1000");
            times[20] = wrong.to_owned();
            times[21] = wrong.replace("20", "21");
            let judged = of(&times);
            assert_eq!(
                (&judged.left_out[..], judged.contradicting, judged.restarts),
                (&[20, 21][..], 2, 0),
                "{wrong}"
            );
            let first = judged.first.unwrap();
            assert_eq!((first.line, first.before), (20, Some(36_019)), "{wrong}");
        }
        let mut ends = minute("1000");
        ends[0] = "150000".to_owned();
        ends[59] = "160059".to_owned();
        assert_eq!(of(&ends).left_out, [0, 59]);
    }

    #[test]
    fn a_gap_a_midnight_and_a_second_back_are_none() {
        for (one, next) in [("1000", "1501"), ("2359", "0000"), ("2300", "0500"), ("0500", "1900")] {
            assert_eq!(of(&[minute(one), minute(next)].concat()), Judged::default(), "{one} {next}");
        }
        assert_eq!(judge(log(&["100000", "095959", "100001"]).as_bytes()), Judged::default());
        assert_eq!(judge(b""), Judged::default());
    }

    #[test]
    fn a_clock_that_is_set_back_leaves_the_longest_run() {
        let judged = of(&[minute("1500"), minute("1000"), minute("1001")].concat());
        assert_eq!((judged.restarts, judged.of_other_runs, judged.contradicting), (1, 60, 0));
        assert_eq!(judged.left_out, (0..60).collect::<Vec<_>>());
    }

    #[test]
    fn data_records_are_held_against_the_fixes_beside_them() {
        let mut text = log(&minute("1000").iter().map(String::as_str).collect::<Vec<_>>());
        text += "K10005901205\nK15005901205\n";
        text += &log(&["100100", "100101"]);
        // A data record within a gap of hours keeps its time.
        text += "K12000001205\n";
        text += &log(&minute("1400").iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(judge(text.as_bytes()).left_out, [61]);
    }
}
