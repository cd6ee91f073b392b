//! The content of one cell of a table.

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// Nothing, or a word that programs write for it.
    Empty,
    /// A number.
    Number(f64),
    /// A time of day, as seconds since midnight.
    Clock(f64),
    /// A date with its time, as seconds since 1970; without a zone, UTC is assumed.
    Date(f64),
    /// Anything else.
    Word,
}

/// Reads a cell without spaces or quotes around it.
pub fn cell(text: &[u8], decimal_comma: bool) -> Cell {
    let Ok(text) = str::from_utf8(text) else { return Cell::Word };
    if text.is_empty() {
        return Cell::Empty;
    }
    if let Some(number) = number(text, decimal_comma) {
        // A sensor cannot measure an infinite value.
        return if number.is_finite() { Cell::Number(number) } else { Cell::Empty };
    }
    let is = |words: &[&str]| words.iter().any(|word| text.eq_ignore_ascii_case(word));
    if is(&["-", "--", "n/a", "na", "null", "none", "nil", "?"]) {
        return Cell::Empty;
    }
    if is(&["true", "yes", "on"]) {
        return Cell::Number(1.0);
    }
    if is(&["false", "no", "off"]) {
        return Cell::Number(0.0);
    }
    if let Some(seconds) = clock(text) {
        return Cell::Clock(seconds);
    }
    date(text).map_or(Cell::Word, Cell::Date)
}

fn number(text: &str, decimal_comma: bool) -> Option<f64> {
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    // 1.013,25: points are only thousands separators.
    let has_one = text.bytes().filter(|byte| *byte == b',').count() == 1;
    (decimal_comma && has_one).then(|| text.replace('.', "").replace(',', ".").parse().ok()).flatten()
}

/// hh:mm:ss and fractions of it.
fn clock(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next()?);
    let is_two = |part: &str| (1..=2).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit());
    if parts.next().is_some() || !is_two(hours) || !is_two(minutes) {
        return None;
    }
    let (hours, minutes): (f64, f64) = (hours.parse().ok()?, minutes.parse().ok()?);
    let seconds: f64 = seconds.replace(',', ".").trim_end_matches('Z').parse().ok()?;
    (hours < 25.0 && minutes < 60.0 && (0.0..61.0).contains(&seconds))
        .then_some(hours * 3_600.0 + minutes * 60.0 + seconds)
}

/// 2023-05-01T12:34:56.789Z, with a space or a T, with or without a zone.
fn date(text: &str) -> Option<f64> {
    let (day, rest) = text.split_at_checked(10)?;
    let rest = rest.strip_prefix(['T', 't', ' '])?;
    let mut parts = day.split(['-', '/']);
    let (year, month, day): (i32, u8, u8) =
        (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
    let zone = rest.rfind(['+', '-']);
    let (time, zone) = zone.map_or((rest, ""), |at| rest.split_at(at));
    let date = time::Date::from_calendar_date(year, time::Month::try_from(month).ok()?, day).ok()?;
    let midnight = time::UtcDateTime::new(date, time::Time::MIDNIGHT).unix_timestamp();
    let seconds = clock(time.trim_end_matches(['Z', 'z', ' ']))?;
    Some(midnight as f64 + seconds - zone_s(zone)?)
}

/// Seconds that a zone is ahead of UTC: +02:00, -0530, or nothing.
fn zone_s(zone: &str) -> Option<f64> {
    let Some(sign) = zone.chars().next() else { return Some(0.0) };
    let digits: String = zone.chars().skip(1).filter(|letter| *letter != ':').collect();
    let (hours, minutes) = digits.split_at_checked(2)?;
    let hours: f64 = hours.parse().ok()?;
    let minutes: f64 = if minutes.is_empty() { 0.0 } else { minutes.parse().ok()? };
    let seconds = hours * 3_600.0 + minutes * 60.0;
    Some(if sign == '-' { -seconds } else { seconds })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_what_they_look_like() {
        let read = |text: &str| cell(text.as_bytes(), false);
        assert_eq!(read(""), Cell::Empty);
        assert_eq!(read("NaN"), Cell::Empty);
        assert_eq!(read("-1.5e3"), Cell::Number(-1_500.0));
        assert_eq!(read("True"), Cell::Number(1.0));
        assert_eq!(read("01:02:03.5"), Cell::Clock(3_723.5));
        assert_eq!(read("1970-01-02 00:00:01"), Cell::Date(86_401.0));
        assert_eq!(read("1970-01-02T02:00:01.25+02:00"), Cell::Date(86_401.25));
        assert_eq!(read("2023-13-02T00:00:00Z"), Cell::Word);
        assert_eq!(read("25:61:00"), Cell::Word);
        assert_eq!(read("boost"), Cell::Word);
        assert_eq!(read("1,5"), Cell::Word);
        assert_eq!(cell(b"1.013,25", true), Cell::Number(1_013.25));
        assert_eq!(cell(b"\xff", true), Cell::Word);
    }
}
