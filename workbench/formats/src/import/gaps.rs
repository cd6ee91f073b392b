//! Stretches without data in a log.

use flight_data::{Flight, Note};

use super::damage::percent;
use super::leap::steps_are_within;

/// A gap is at least this many of the log's usual steps: after one, it is no longer known where the vehicle
/// went (the same as `GAP_BLOCKS` blocks of `FIXES_A_BLOCK` fixes in `replay::airborne`).
const STEPS: f64 = 10.0;
/// A gap is also at least this long, seconds: a logger of hundreds of rows a second that pauses for one has
/// lost nothing of a flight.
const LEAST_S: f64 = 10.0;

/// The note on a flight's gaps: how much is missing, and where the longest is.
pub fn note(flight: &Flight) -> Option<Note> {
    // No gap is shorter.
    if steps_are_within(&flight.time_s, LEAST_S) {
        return None;
    }
    let mut steps_s: Vec<f64> = Vec::with_capacity(flight.rows());
    let first_s = flight.time_s.first().copied()?;
    let mut latest_s = first_s;
    for time_s in flight.time_s.iter().skip(1).filter(|time_s| time_s.is_finite()) {
        if *time_s > latest_s {
            steps_s.push(time_s - latest_s);
            latest_s = *time_s;
        }
    }
    let middle = steps_s.len() / 2;
    if steps_s.is_empty() {
        return None;
    }
    let (_, usual_s, _) = steps_s.select_nth_unstable_by(middle, f64::total_cmp);
    let least_s = LEAST_S.max(STEPS * *usual_s);
    let (mut count, mut missing_s) = (0_usize, 0.0);
    let mut longest = (0.0, 0.0);
    let mut at_s = first_s;
    for time_s in flight.time_s.iter().copied().filter(|time_s| time_s.is_finite()) {
        if time_s - at_s > least_s {
            count += 1;
            missing_s += time_s - at_s;
            if time_s - at_s > longest.0 {
                longest = (time_s - at_s, at_s);
            }
        }
        at_s = at_s.max(time_s);
    }
    let (longest_s, from_s) = longest;
    let share = percent((missing_s * 1e3) as usize, ((latest_s - first_s) * 1e3) as usize);
    let until_s = from_s + longest_s;
    match count {
        0 => None,
        1 => Some(Note::new(format!(
            "nothing was recorded for {longest_s:.0} s ({share} of the log), from {from_s:.0} s to {until_s:.0} s"
        ))),
        _ => Some(Note::new(format!(
            "nothing was recorded {count} times, for {missing_s:.0} s in total ({share} of the log); the longest gap is from {from_s:.0} s to \
             {until_s:.0} s"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(times: impl IntoIterator<Item = f64>) -> Option<String> {
        let flight = Flight { time_s: times.into_iter().collect(), ..Flight::default() };
        note(&flight).map(|note| note.text().to_owned())
    }

    fn seconds(from: u32, to: u32) -> impl Iterator<Item = f64> {
        (from..to).map(f64::from)
    }

    #[test]
    fn a_gap_of_hours_is_said_with_its_place_and_share() {
        let words = "nothing was recorded for 18000 s (99 % of the log), from 99 s to 18099 s";
        assert_eq!(said(seconds(0, 100).chain(seconds(18_099, 18_199))).unwrap(), words);
        let words = "nothing was recorded 2 times, for 81 s in total (45 % of the log); the longest gap is from 49 s to 100 s";
        let twice = seconds(0, 50).chain(seconds(100, 140)).chain(seconds(169, 182));
        assert_eq!(said(twice).unwrap(), words);
    }

    #[test]
    fn what_a_slow_logger_always_leaves_and_times_that_go_back_are_none() {
        assert_eq!(said(seconds(0, 100).map(|minute| 60.0 * minute)), None);
        assert_eq!(said(seconds(0, 100).chain(seconds(109, 200))), None);
        assert_eq!(said(seconds(0, 100).chain(seconds(20, 105))), None);
        assert_eq!(said([]), None);
        assert_eq!(said([5.0]), None);
    }
}
