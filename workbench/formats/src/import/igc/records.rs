//! Lines of an IGC file (FAI, "Technical Specification for GNSS Flight Recorders", appendix A).

use crate::import::velocity::Position;

/// A B record: one fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// UTC, seconds of the day, without the fraction of `TDS`.
    pub second_of_day: u32,
    /// Latitude and longitude, to a thousandth of a minute.
    pub position: Position,
    /// Validity A: a 3D fix. Otherwise (V) there is no GNSS altitude.
    pub is_3d: bool,
    /// Pressure altitude above 1013.25 hPa, metres.
    pub pressure_altitude_m: f32,
    /// GNSS altitude, metres.
    pub gnss_altitude_m: f32,
}

/// Position of an additional value in a line: one entry of an I or J record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extension {
    /// Three-letter code.
    pub code: String,
    /// First byte in the line, from 1.
    pub first: usize,
    /// Last byte in the line, from 1.
    pub last: usize,
}

/// Length of the shortest B record.
const FIX_LENGTH: usize = 35;

/// `width` decimal digits at `from`.
fn digits(line: &[u8], from: usize, width: usize) -> Option<u32> {
    line.get(from..from + width)?
        .iter()
        .try_fold(0, |value: u32, byte| byte.is_ascii_digit().then(|| value * 10 + u32::from(byte - b'0')))
}

/// Seconds of the day of `HHMMSS` at `from`; second 60 is a leap second.
fn second_of_day(line: &[u8], from: usize) -> Option<u32> {
    let (hour, minute, second) =
        (digits(line, from, 2)?, digits(line, from + 2, 2)?, digits(line, from + 4, 2)?);
    (hour < 24 && minute < 60 && second <= 60).then_some(hour * 3600 + minute * 60 + second)
}

/// An altitude of five characters, of which the first may be a minus.
fn altitude(line: &[u8], from: usize) -> Option<f32> {
    if line.get(from) == Some(&b'-') {
        return digits(line, from + 1, 4).map(|metres| -(metres as f32));
    }
    digits(line, from, 5).map(|metres| metres as f32)
}

/// Degrees of `DDMMmmm` (with `width` digits of degrees) and a letter that gives the sign.
fn angle(line: &[u8], from: usize, width: usize, positive: u8, negative: u8, most: f64) -> Option<f64> {
    let degrees = digits(line, from, width)?;
    let thousandths = digits(line, from + width, 5)?;
    let sign = match *line.get(from + width + 5)? {
        letter if letter == positive => 1.0,
        letter if letter == negative => -1.0,
        _ => return None,
    };
    let value = f64::from(degrees) + f64::from(thousandths) / 60_000.0;
    (thousandths < 60_000 && value <= most).then_some(sign * value)
}

/// Reads a B record; `None` unless its fixed part is complete and valid.
#[must_use]
pub fn fix(line: &[u8]) -> Option<Fix> {
    if line.first() != Some(&b'B') || line.len() < FIX_LENGTH {
        return None;
    }
    Some(Fix {
        second_of_day: second_of_day(line, 1)?,
        position: Position {
            latitude_deg: angle(line, 7, 2, b'N', b'S', 90.0)?,
            longitude_deg: angle(line, 15, 3, b'E', b'W', 180.0)?,
        },
        is_3d: match line.get(24)? {
            b'A' => true,
            b'V' => false,
            _ => return None,
        },
        pressure_altitude_m: altitude(line, 25)?,
        gnss_altitude_m: altitude(line, 30)?,
    })
}

/// Second of the day of a line that may be a B record.
pub fn fix_time(line: &[u8]) -> Option<u32> {
    if line.first() == Some(&b'B') && line.len() >= FIX_LENGTH { second_of_day(line, 1) } else { None }
}

/// Reads the time of a K record, UTC seconds of the day.
#[must_use]
pub fn data_time(line: &[u8]) -> Option<u32> {
    if line.first() == Some(&b'K') { second_of_day(line, 1) } else { None }
}

/// Reads an I or J record; the flag reports whether it was complete and had the number of entries that it
/// gives. Entries are `SSFFCCC`; recorders whose lines are longer than 99 bytes write three digits.
#[must_use]
pub fn extensions(line: &[u8]) -> (Vec<Extension>, bool) {
    let mut found = Vec::new();
    let mut rest = line.get(3..).unwrap_or_default().trim_ascii_end();
    while !rest.is_empty() {
        let count = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let first_width = match count {
            4 | 5 => 2,
            6 => 3,
            _ => return (found, false),
        };
        let (Some(first), Some(last), Some(code)) = (
            digits(rest, 0, first_width),
            digits(rest, first_width, count - first_width),
            rest.get(count..count + 3).filter(|code| code.iter().all(u8::is_ascii_alphanumeric)),
        ) else {
            return (found, false);
        };
        let (first, last) = (first as usize, last as usize);
        // The record's own time is before byte 8.
        if first < 8 || last < first {
            return (found, false);
        }
        // Three-letter codes are capitals (FAI technical specification, A7): the same code in lower case is
        // the same value.
        let code = code.iter().map(|byte| char::from(byte.to_ascii_uppercase())).collect();
        found.push(Extension { code, first, last });
        rest = rest.get(count + 3..).unwrap_or_default();
    }
    let announced = digits(line, 1, 2).map(|count| count as usize);
    let complete = announced == Some(found.len());
    (found, complete)
}

impl Extension {
    /// How many characters the value has.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.last - self.first + 1
    }

    /// The value's characters in a line; `None` if the line is too short.
    #[must_use]
    pub fn text<'a>(&self, line: &'a [u8]) -> Option<&'a [u8]> {
        line.get(self.first - 1..self.last)
    }

    /// The value as a whole number, with a minus before its digits if negative. `None` if it is blank, not a
    /// number, or cut.
    #[must_use]
    pub fn number(&self, line: &[u8]) -> Option<f64> {
        let text = str::from_utf8(self.text(line)?.trim_ascii()).ok()?;
        // Wider fields are not quantities, and not exact in a float.
        if text.len() > 15 || !text.ends_with(|last: char| last.is_ascii_digit()) {
            return None;
        }
        text.parse::<i64>().ok().map(|value| value as f64)
    }
}

/// The three-letter code and the value of an H record: `HFCODE`, a long name that ends with a colon in
/// most files, the value.
#[must_use]
pub fn header(line: &[u8]) -> Option<(&str, &str)> {
    let text = str::from_utf8(line).ok()?;
    if !text.starts_with('H') {
        return None;
    }
    let (code, rest) = (text.get(2..5)?, text.get(5..)?);
    Some((code, rest.split_once(':').map_or(rest, |(_, value)| value).trim()))
}

/// The date of a DTE record as year, month, day. Written `HFDTE010203`, `HFDTEDATE:010203,01` or
/// `HFDTEDATE010203`; a two-digit year from 80 on is in the last century.
#[must_use]
pub fn date(line: &[u8]) -> Option<(u32, u32, u32)> {
    let from = line.iter().position(u8::is_ascii_digit)?;
    let (day, month, year) = (digits(line, from, 2)?, digits(line, from + 2, 2)?, digits(line, from + 4, 2)?);
    let century = if year >= 80 { 1900 } else { 2000 };
    ((1..=31).contains(&day) && (1..=12).contains(&month)).then_some((century + year, month, day))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_a_fix() {
        // The example of the specification's appendix A.
        let read = fix(b"B1602405407121N00249342WA0028000421205009950006").unwrap();
        assert_eq!(read.second_of_day, 16 * 3600 + 2 * 60 + 40);
        assert!((read.position.latitude_deg - (54.0 + 7.121 / 60.0)).abs() < 1e-12);
        assert!((read.position.longitude_deg + (2.0 + 49.342 / 60.0)).abs() < 1e-12);
        assert!(read.is_3d);
        assert_eq!((read.pressure_altitude_m, read.gnss_altitude_m), (280.0, 421.0));
        let below = fix(b"B0739373634583S03158247EV-0057-0630").unwrap();
        assert!(!below.is_3d && below.position.latitude_deg < 0.0);
        assert_eq!((below.pressure_altitude_m, below.gnss_altitude_m), (-57.0, -630.0));
    }

    #[test]
    fn refuses_what_is_not_a_fix() {
        let good = b"B1602405407121N00249342WA0028000421";
        assert!(fix(good).is_some());
        assert!(fix(&good[..34]).is_none());
        // Each byte of the fixed part matters.
        for index in 0..good.len() {
            let mut bad = *good;
            bad[index] = b'?';
            assert!(fix(&bad).is_none(), "byte {index}");
        }
        assert!(fix(b"B2402405407121N00249342WA0028000421").is_none());
        assert!(fix(b"B1602405460000N00249342WA0028000421").is_none());
        assert!(fix(b"B1602409007121N00249342WA0028000421").is_none());
        assert!(fix(b"B1602405407121N18049342WA0028000421").is_none());
    }

    #[test]
    fn reads_extensions_and_their_values() {
        // A code in another case is the same code (found by fuzzing: two columns of one name).
        assert_eq!(extensions(b"I013638FxA").0[0].code, "FXA");
        let (found, complete) = extensions(b"I033638FXA3940SIU4145VAT");
        assert!(complete);
        let codes: Vec<_> =
            found.iter().map(|found| (found.code.as_str(), found.first, found.last)).collect();
        assert_eq!(codes, [("FXA", 36, 38), ("SIU", 39, 40), ("VAT", 41, 45)]);
        let line = b"B1602405407121N00249342WA002800042112309-0138";
        let values: Vec<_> = found.iter().map(|found| found.number(line)).collect();
        assert_eq!(values, [Some(123.0), Some(9.0), Some(-138.0)]);
        assert_eq!(found[2].number(&line[..44]), None);
        assert_eq!(found[2].width(), 5);
    }

    #[test]
    fn reads_extensions_beyond_byte_99() {
        let (found, complete) = extensions(b"I0397101FFL102106FLE107OA1");
        assert!(!complete);
        assert_eq!((found[0].first, found[0].last), (97, 101));
        assert_eq!((found[1].first, found[1].last), (102, 106));
        let (found, complete) = extensions(b"I029799FFL100104OA1");
        assert!(complete);
        assert_eq!((found[1].first, found[1].last, found[1].code.as_str()), (100, 104, "OA1"));
    }

    #[test]
    fn a_bad_extension_record_gives_what_was_read() {
        for bad in [
            "I023638FXA",
            "I013638FXA3940SIU",
            "I023638FXA4039SIU",
            "I023638FXA3?40SIU",
            "I013638FX",
            "I010107TIM",
        ] {
            let (found, complete) = extensions(bad.as_bytes());
            assert!(!complete && found.len() <= 2, "{bad}");
        }
        assert_eq!(extensions(b"I00"), (vec![], true));
        assert_eq!(extensions(b"I"), (vec![], false));
    }

    #[test]
    fn blank_values_are_none() {
        let extension = Extension { code: "OAT".into(), first: 1, last: 4 };
        for blank in ["    ", "----", "-", "12.3", "a123", "1 2 "] {
            assert_eq!(extension.number(format!("{blank:4}").as_bytes()), None, "{blank:?}");
        }
        assert_eq!(extension.number(b" -05"), Some(-5.0));
    }

    #[test]
    fn reads_headers_and_dates() {
        assert_eq!(header(b"HFGTYGLIDERTYPE: LS 6 "), Some(("GTY", "LS 6")));
        assert_eq!(header(b"HFALG:GEO"), Some(("ALG", "GEO")));
        assert_eq!(header(b"HFFXA035"), Some(("FXA", "035")));
        assert_eq!(header(b"HF"), None);
        for text in ["HFDTE280423", "HFDTEDATE:280423,04", "HFDTEDATE280423", "HFDTE:280423"] {
            assert_eq!(date(text.as_bytes()), Some((2023, 4, 28)), "{text}");
        }
        assert_eq!(date(b"HFDTE010199"), Some((1999, 1, 1)));
        assert_eq!(date(b"HFDTE000000"), None);
        assert_eq!(date(b"HFDTE"), None);
    }
}
