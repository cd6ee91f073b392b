//! GPS time: weeks since 1980-01-06, without leap seconds.

/// Seconds from 1970 to the start of GPS time.
const GPS_EPOCH_S: i64 = 315_964_800;
/// UTC seconds since 1970, and the seconds that GPS time is ahead of UTC from then on (IERS, Bulletin C; none
/// since 2017).
const LEAP_SECONDS: [(i64, i64); 7] = [
    (1_483_228_800, 18),
    (1_435_708_800, 17),
    (1_341_100_800, 16),
    (1_230_768_000, 15),
    (1_136_073_600, 14),
    (915_148_800, 13),
    (0, 12),
];

/// GPS time in microseconds from a week and its milliseconds; `None` for values that no receiver reports.
pub fn gps_us(week: f64, week_ms: f64) -> Option<u64> {
    let is_whole = |value: f64, most: f64| value.is_finite() && (0.0..most).contains(&value);
    // The autopilot has extended ten-bit weeks; week 0 means that the receiver does not know the time yet.
    (is_whole(week, 10_000.0) && week >= 1.0 && is_whole(week_ms, 604_800_000.0))
        .then(|| week as u64 * 604_800_000_000 + week_ms as u64 * 1_000)
}

/// UTC seconds since 1970 at that GPS time.
pub fn utc_s(gps_us: i64) -> i64 {
    let s = gps_us.div_euclid(1_000_000) + GPS_EPOCH_S;
    let ahead = LEAP_SECONDS.iter().find(|(from_s, ahead)| s - ahead >= *from_s);
    s - ahead.map_or(0, |(_, ahead)| *ahead)
}

/// A UTC time as text for files; `None` beyond the calendar.
pub fn utc_text(utc_s: i64) -> Option<String> {
    let utc = time::UtcDateTime::from_unix_timestamp(utc_s).ok()?;
    let (date, (hour, minute, second)) = (utc.date(), utc.as_hms());
    let date = format!("{:04}-{:02}-{:02}", date.year(), u8::from(date.month()), date.day());
    Some(format!("{date}T{hour:02}:{minute:02}:{second:02}Z"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments_come_out() {
        // The second of the week at which 2017's leap second was over: 2017-01-01T00:00:00Z is week 1930, 18
        // s into Sunday.
        let at = |week, ms| utc_text(utc_s(gps_us(week, ms).unwrap() as i64)).unwrap();
        assert_eq!(at(1930.0, 18_000.0), "2017-01-01T00:00:00Z");
        assert_eq!(at(1930.0, 16_000.0), "2016-12-31T23:59:59Z");
        // A flight of 2013, when 16 leap seconds had been inserted.
        assert_eq!(at(1769.0, 130_040_903.0), "2013-12-02T12:07:04Z");
        assert_eq!(gps_us(0.0, 5.0), None);
        assert_eq!(gps_us(1930.0, 604_800_000.0), None);
        assert_eq!(gps_us(f64::NAN, 0.0), None);
    }
}
