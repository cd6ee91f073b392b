//! A flight's clock that leaps by days, after which comes no flight, or that goes back.

use flight_data::{Channel, Column, Flight, Note};

/// From one row to the next, seconds. The longest flights of aircraft with crews take less than three days, and none is silent for one.
const LEAP_S: f64 = 86_400.0;

/// Leaves out the rows that are more than a day after the last one before them that is not; says so.
///
/// A flight whose first row is alone before the leap begins after it.
pub fn leave_out(flight: &mut Flight) -> Option<Note> {
    let second = flight.time_s.get(1).copied()?;
    let first = flight.time_s.first().copied()?;
    let begins_after = second - first > LEAP_S;
    let mut latest = if begins_after { second } else { first };
    let keeps: Vec<bool> = flight
        .time_s
        .iter()
        .enumerate()
        .map(|(row, time_s)| {
            let is_kept = !(begins_after && row == 0) && time_s - latest <= LEAP_S;
            latest = if is_kept { latest.max(*time_s) } else { latest };
            is_kept
        })
        .collect();
    let left_out = keeps.iter().filter(|is_kept| !**is_kept).count();
    let leap = keeps.iter().position(|is_kept| !is_kept)?;
    let to_s = flight.time_s.get(leap).copied().unwrap_or(0.0);
    let rows = flight.rows();
    let kept_rows: Vec<usize> =
        keeps.iter().enumerate().filter_map(|(row, is_kept)| is_kept.then_some(row)).collect();
    let kept = |column: &Column| column.picked(kept_rows.iter().copied());
    let channels: Vec<(Channel, Column)> =
        flight.channels.iter().map(|(channel, column)| (*channel, kept(column))).collect();
    flight.extra = flight.extra.iter().map(|(name, column)| (name.clone(), kept(column))).collect();
    flight.channels = channels;
    let mut keep = keeps.iter();
    flight.time_s.retain(|_| keep.next().copied().unwrap_or(false));
    Some(Note::new(format!(
        "the flight's row {} leaps to {to_s:.0} s; rows more than a day away from the flight, left out: {left_out} of {rows}",
        leap + 1
    )))
}

/// What is to be said of rows that do not come after all before them.
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
        let note = leave_out(&mut flight).map(|note| note.text().to_owned());
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
