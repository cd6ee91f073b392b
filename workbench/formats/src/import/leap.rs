//! Handles a flight's clock that leaps by days, or that goes back.

use flight_data::{Channel, Column, Flight, Note};

/// Longest step from one row to the next, seconds. The longest flights of aircraft with crews take less than
/// three days, and none of them is silent for one.
const LEAP_S: f64 = 86_400.0;
/// Number of rows after one that decide by majority whether it is ahead of them: as in `stamps.rs`.
const WITNESSES: usize = 16;
/// Rows within this, plus the usual time of that many rows, belong together, seconds.
const TOGETHER_S: f64 = 60.0;

/// Leaves out rows that are more than a day after the last row kept before them, and rows that are ahead of
/// the rows after them, which continue from the row before. Returns notes on both.
///
/// If only the first row is before the leap, the flight begins after it.
pub fn leave_out(flight: &mut Flight) -> Vec<Note> {
    let (Some(first), Some(second)) = (flight.time_s.first().copied(), flight.time_s.get(1).copied()) else {
        return Vec::new();
    };
    // Nothing leaps where no step is longer than the rows that belong together.
    if steps_are_within(&flight.time_s, TOGETHER_S) {
        return Vec::new();
    }
    let begins_after = second - first > LEAP_S;
    let near_s = TOGETHER_S + WITNESSES as f64 * usual_step_s(&flight.time_s);
    let mut latest = if begins_after { second } else { first };
    let (mut keeps, mut leaps, mut ahead) = (Vec::with_capacity(flight.rows()), Vec::new(), Vec::new());
    for (row, time_s) in flight.time_s.iter().enumerate() {
        let is_far = (begins_after && row == 0) || time_s - latest > LEAP_S;
        let is_ahead = !is_far && time_s - latest > near_s && is_alone(&flight.time_s, row, latest, near_s);
        keeps.push(!is_far && !is_ahead);
        if is_far {
            leaps.push(row);
        } else if is_ahead {
            ahead.push(row);
        } else {
            latest = latest.max(*time_s);
        }
    }
    let rows = flight.rows();
    let at_s = |row: usize| flight.time_s.get(row).copied().unwrap_or(0.0);
    let leap = leaps.first().map(|row| {
        Note::new(format!(
            "the flight's row {} leaps to {:.0} s; rows more than a day away from the flight, left out: {} of {rows}",
            row + 1,
            at_s(*row),
            leaps.len()
        ))
    });
    let alone = ahead.first().map(|row| {
        Note::new(format!(
            "the flight's row {} leaps to {} s, and those after it do not; such rows, left out: {} of {rows}",
            row + 1,
            at_s(*row),
            ahead.len()
        ))
    });
    let notes: Vec<Note> = leap.into_iter().chain(alone).collect();
    if notes.is_empty() {
        return notes;
    }
    let kept_rows: Vec<usize> =
        keeps.iter().enumerate().filter_map(|(row, is_kept)| is_kept.then_some(row)).collect();
    let kept = |column: &Column| column.picked(kept_rows.iter().copied());
    let channels: Vec<(Channel, Column)> =
        flight.channels.iter().map(|(channel, column)| (*channel, kept(column))).collect();
    flight.extra = flight.extra.iter().map(|(name, column)| (name.clone(), kept(column))).collect();
    flight.channels = channels;
    let mut keep = keeps.iter();
    flight.time_s.retain(|_| keep.next().copied().unwrap_or(false));
    notes
}

/// Whether no row is later than the one before it by more than this, seconds; false if a time is not a
/// number. Most flights need no look at their gaps and leaps, which takes a copy of the times.
pub fn steps_are_within(times_s: &[f64], longest_s: f64) -> bool {
    times_s.is_sorted_by(|one, next| next - one <= longest_s)
}

/// Whether most of the rows after one continue from the time before it.
fn is_alone(times_s: &[f64], row: usize, before_s: f64, near_s: f64) -> bool {
    let after = times_s.get(row + 1..).unwrap_or_default();
    let after = after.get(..WITNESSES.min(after.len())).unwrap_or_default();
    let near = after.iter().filter(|time_s| (*time_s - before_s).abs() <= near_s).count();
    2 * near > after.len()
}

/// Median time from one row to the next, seconds.
fn usual_step_s(times_s: &[f64]) -> f64 {
    let steps = times_s.iter().zip(times_s.iter().skip(1)).map(|(one, next)| next - one);
    let mut steps: Vec<f64> = steps.filter(|step_s| *step_s > 0.0).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Note on rows that are earlier than one before them.
pub fn backward(flight: &Flight) -> Option<Note> {
    let mut latest = f64::NEG_INFINITY;
    let mut first = None;
    let mut count = 0;
    for (row, time_s) in flight.time_s.iter().enumerate() {
        if *time_s < latest {
            count += 1;
            first = first.or(Some((row + 1, *time_s, latest)));
        }
        latest = latest.max(*time_s);
    }
    let (row, time_s, before_s) = first?;
    Some(Note::new(format!(
        "the flight's row {row} goes back in time, to {time_s} s after {before_s} s; rows before the latest one, which the estimator \
         ignores: {count} of {}",
        flight.rows()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_data::parse;

    fn left_out(times: &[f64]) -> (Vec<f64>, Option<String>) {
        let mut text = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m,flap\n".to_owned();
        times.iter().for_each(|time| text += &format!("{time},{time},1,{time}\n"));
        let mut flight = parse(text.as_bytes()).unwrap().0;
        let notes = leave_out(&mut flight);
        let note = notes.first().map(|note| note.text().to_owned());
        for column in [flight.channel(Channel::GpsAltM).unwrap(), &flight.extra[0].1] {
            let values: Vec<f64> = column.samples().map(|(_, value)| f64::from(value)).collect();
            assert_eq!(values, flight.time_s);
        }
        (flight.time_s, note)
    }

    #[test]
    fn rows_after_a_leap_are_left_out_and_rows_after_the_way_back_are_not() {
        assert_eq!(left_out(&[0.0, 1.0, 2.0, 1.5]), (vec![0.0, 1.0, 2.0, 1.5], None));
        let (times, note) = left_out(&[0.0, 1.0, 6e6, 6_000_001.0, 2.0]);
        assert_eq!(times, [0.0, 1.0, 2.0]);
        assert_eq!(
            note.unwrap(),
            "the flight's row 3 leaps to 6000000 s; rows more than a day away from the flight, left out: 2 of 5"
        );
        let (times, _) = left_out(&[0.0, 6e6, 6_000_001.0]);
        assert_eq!(times, [6e6, 6_000_001.0]);
    }

    /// All that follows would be behind it in time, which the estimator ignores.
    #[test]
    fn a_row_that_is_ahead_of_all_after_it_is_left_out_alone() {
        let mut flown: Vec<f64> = (0..100).map(f64::from).collect();
        flown[40] = 18_040.0;
        let (times, note) = left_out(&flown);
        assert_eq!((times.len(), times[40], times[98]), (99, 41.0, 99.0));
        let words =
            "the flight's row 41 leaps to 18040 s, and those after it do not; such rows, left out: 1 of 100";
        assert_eq!(note.unwrap(), words);
        // A gap, and a clock that goes back by some seconds, stay.
        let gap: Vec<f64> = (0..50).chain(18_050..18_100).map(f64::from).collect();
        assert_eq!(left_out(&gap), (gap.clone(), None));
        let back: Vec<f64> = (0..50).chain(30..80).map(f64::from).collect();
        assert_eq!(left_out(&back), (back.clone(), None));
    }

    #[test]
    fn rows_that_go_back_are_counted_and_the_first_one_is_named() {
        let said = |times: &[f64]| {
            let flight = Flight { time_s: times.to_vec(), ..Flight::default() };
            backward(&flight).map(|note| note.text().to_owned())
        };
        assert_eq!(said(&[0.0, 1.0, 1.0, 2.0]), None);
        let words = "the flight's row 4 goes back in time, to 0.5 s after 2 s; rows before the latest one, which the estimator ignores: 2 of 6";
        assert_eq!(said(&[0.0, 1.0, 2.0, 0.5, 1.5, 3.0]).unwrap(), words);
    }
}
