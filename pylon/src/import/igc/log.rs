//! An IGC file line by line, before its numbers get units.

use super::records::{self, Extension, Fix, Position};

/// Seconds of half a day: a clock that goes back further has passed midnight.
const HALF_DAY_S: f64 = 43_200.0;
const DAY_S: f64 = 86_400.0;

/// One time of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Seconds since the first fix.
    pub time_s: f64,
    /// The fix, unless the row only has data of a K record.
    pub fix: Option<Fix>,
    /// Position with every digit that the log has.
    pub position: Option<Position>,
    /// Additional values: index into [`Log::codes`], and the number as it stands.
    pub values: Vec<(usize, f64)>,
}

/// What was left out, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// B and K records that could not be read, and lines that are no record.
    pub corrupt_lines: usize,
    /// The first of them, as a line of the file, from 1.
    pub first_corrupt_line: usize,
    /// I and J records that were not as they say.
    pub bad_extension_records: usize,
    /// Additional values that are blank, not a number or cut off.
    pub blank_values: usize,
    /// Records with a time before the first fix.
    pub before_first_fix: usize,
}

/// A log as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// The rows, in file order; rows of K records are at their time.
    pub rows: Vec<Row>,
    /// The three-letter codes that rows have values of.
    pub codes: Vec<String>,
    /// Values of H records by their code, and of the A record by `A`, in file order.
    pub headers: Vec<(String, String)>,
    /// UTC date and second of the day of the first fix.
    pub start: Option<((u32, u32, u32), u32)>,
    /// What was left out.
    pub losses: Losses,
}

/// Turns times of the day into seconds since the first fix.
#[derive(Debug, Default)]
struct Clock {
    first_s: Option<f64>,
    last_s: f64,
    days: f64,
}

impl Clock {
    /// Seconds since the first fix; negative before it. Only a fix starts the clock.
    fn since_first(&mut self, second_s: f64, is_fix: bool) -> Option<f64> {
        if self.first_s.is_none() && is_fix {
            self.first_s = Some(second_s);
            self.last_s = second_s;
        }
        let first_s = self.first_s?;
        let mut absolute_s = self.days * DAY_S + second_s;
        if absolute_s < self.last_s - HALF_DAY_S {
            self.days += 1.0;
            absolute_s += DAY_S;
        } else if !is_fix && absolute_s > self.last_s + HALF_DAY_S && self.days > 0.0 {
            // A data record that belongs before the midnight that has been passed.
            absolute_s -= DAY_S;
        }
        self.last_s = absolute_s;
        // Fractions of a second add up to no more digits than the log has.
        Some(((absolute_s - first_s) * 1e6).round() / 1e6)
    }
}

impl Log {
    /// Reads a log; what can not be read is counted.
    #[must_use]
    pub fn read(text: &[u8]) -> Self {
        let mut log = Self::default();
        let mut clock = Clock::default();
        let mut fix_extensions = Vec::new();
        let mut data_extensions = Vec::new();
        let mut date = None;
        for (index, line) in lines(text).enumerate() {
            let line = line.trim_ascii_end();
            let good = match line.first() {
                None => true,
                Some(b'B') => log.take_fix(line, &fix_extensions, &mut clock, date),
                Some(b'K') => log.take_data(line, &data_extensions, &mut clock),
                Some(kind @ (b'I' | b'J')) => {
                    let (extensions, complete) = records::extensions(line);
                    log.losses.bad_extension_records += usize::from(!complete);
                    if *kind == b'I' {
                        fix_extensions = extensions;
                    } else {
                        data_extensions = extensions;
                    }
                    true
                }
                Some(b'H') => {
                    if line.get(2..5) == Some(b"DTE") && date.is_none() {
                        date = records::date(line);
                    }
                    log.take_header(&String::from_utf8_lossy(line));
                    true
                }
                Some(b'A') => {
                    if !log.headers.iter().any(|(code, _)| code == "A") {
                        let recorder =
                            String::from_utf8_lossy(line.get(1..).unwrap_or_default()).into_owned();
                        log.headers.push(("A".to_owned(), recorder));
                    }
                    true
                }
                Some(other) => other.is_ascii_uppercase(),
            };
            if !good {
                if log.losses.corrupt_lines == 0 {
                    log.losses.first_corrupt_line = index + 1;
                }
                log.losses.corrupt_lines += 1;
            }
        }
        log
    }

    /// The value of the first H record of that code.
    #[must_use]
    pub fn header(&self, code: &str) -> Option<&str> {
        let found = self.headers.iter().find_map(|(found, value)| (found == code).then_some(value.trim()));
        found.filter(|value| !value.is_empty())
    }

    fn take_header(&mut self, line: &str) {
        if let Some((code, value)) = records::header(line.as_bytes()) {
            self.headers.push((code.to_owned(), value.to_owned()));
        }
    }

    fn code_index(&mut self, code: &str) -> usize {
        self.codes.iter().position(|known| known == code).unwrap_or_else(|| {
            self.codes.push(code.to_owned());
            self.codes.len() - 1
        })
    }

    fn values(&mut self, line: &[u8], extensions: &[Extension]) -> Vec<(usize, f64)> {
        let mut values = Vec::new();
        for extension in extensions {
            if matches!(extension.code.as_str(), "LAD" | "LOD" | "TDS") {
                continue;
            }
            match extension.number(line) {
                Some(number) => values.push((self.code_index(&extension.code), number)),
                None => self.losses.blank_values += 1,
            }
        }
        values
    }

    fn take_fix(
        &mut self,
        line: &[u8],
        extensions: &[Extension],
        clock: &mut Clock,
        date: Option<(u32, u32, u32)>,
    ) -> bool {
        let Some(fix) = records::fix(line) else { return false };
        let second_s = f64::from(fix.second_of_day) + decimals(line, extensions, "TDS");
        let Some(time_s) = clock.since_first(second_s, true) else { return false };
        if time_s < 0.0 {
            self.losses.before_first_fix += 1;
            return true;
        }
        if self.start.is_none() {
            self.start = date.map(|date| (date, fix.second_of_day));
        }
        // Digits after the thousandth of a minute, away from zero as the rest of the number.
        let finer = |degrees: f64, code: &str| {
            degrees + decimals(line, extensions, code).copysign(degrees) / 60_000.0
        };
        let position = Position {
            latitude_deg: finer(fix.position.latitude_deg, "LAD"),
            longitude_deg: finer(fix.position.longitude_deg, "LOD"),
        };
        let values = self.values(line, extensions);
        self.rows.push(Row { time_s, fix: Some(fix), position: Some(position), values });
        true
    }

    fn take_data(&mut self, line: &[u8], extensions: &[Extension], clock: &mut Clock) -> bool {
        let Some(second) = records::data_time(line) else { return false };
        let second_s = f64::from(second) + decimals(line, extensions, "TDS");
        let time_s = clock.since_first(second_s, false).filter(|time_s| *time_s >= 0.0);
        let Some(time_s) = time_s else {
            self.losses.before_first_fix += 1;
            return true;
        };
        let values = self.values(line, extensions);
        // A K record may follow the fix of a later second; its place is before that.
        let later = self.rows.iter().rev().take_while(|row| row.time_s > time_s).count();
        let place = self.rows.len() - later;
        match place.checked_sub(1).and_then(|index| self.rows.get_mut(index)) {
            Some(row) if row.time_s == time_s => row.values.extend(values),
            _ => self.rows.insert(place, Row { time_s, fix: None, position: None, values }),
        }
        true
    }
}

/// Lines that end with LF, CR LF or CR.
fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let has_line_feed = text.contains(&b'\n');
    text.split(move |byte| *byte == if has_line_feed { b'\n' } else { b'\r' })
}

/// The digits of an extension as decimals of one unit: `7` is 0.7, `07` is 0.07; 0 where there are none.
fn decimals(line: &[u8], extensions: &[Extension], code: &str) -> f64 {
    let Some(extension) = extensions.iter().find(|extension| extension.code == code) else { return 0.0 };
    let is_digits = extension.text(line).is_some_and(|text| text.iter().all(u8::is_ascii_digit));
    match extension.number(line).filter(|_| is_digits) {
        Some(number) => number / 10_f64.powi(i32::try_from(extension.width()).unwrap_or(i32::MAX)),
        None => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(text: &str) -> Vec<f64> {
        Log::read(text.as_bytes()).rows.iter().map(|row| row.time_s).collect()
    }

    fn fix_at(time: &str) -> String {
        format!("B{time}5407121N00249342WA0028000421\r\n")
    }

    #[test]
    fn time_counts_from_the_first_fix_and_passes_midnight() {
        let at = |list: &[&str]| list.iter().map(|time| fix_at(time)).collect::<String>();
        assert_eq!(times(&at(&["235958", "235959", "000001", "000002"])), [0.0, 1.0, 3.0, 4.0]);
        // Repeated and backward times are kept, for the estimator to count.
        assert_eq!(times(&at(&["100000", "100001", "100001", "100000"])), [0.0, 1.0, 1.0, 0.0]);
        let log = Log::read(at(&["100000", "095959", "100001"]).as_bytes());
        assert_eq!((log.rows.len(), log.losses.before_first_fix), (2, 1));
        // Two midnights.
        let hours: Vec<_> =
            times(&at(&["190000", "050000", "190000", "050000"])).iter().map(|time| time / 3600.0).collect();
        assert_eq!(hours, [0.0, 10.0, 24.0, 34.0]);
    }

    #[test]
    fn finer_digits_refine_time_and_place() {
        let log = Log::read(
            b"I033636LAD3737LOD3839TDS\nB1602405407121N00249342WA002800042156-7\nB1602415407121S00249342EA00280004215607\n",
        );
        let row = &log.rows[0];
        let position = row.position.unwrap();
        assert!((position.latitude_deg - (54.0 + 7.1215 / 60.0)).abs() < 1e-12);
        assert!((position.longitude_deg + (2.0 + 49.3426 / 60.0)).abs() < 1e-12);
        // '-7' are no decimals; 07 are seven hundredths.
        assert_eq!([row.time_s, log.rows[1].time_s], [0.0, 1.07]);
        assert!(log.rows[1].position.unwrap().latitude_deg < -54.118_69);
        assert!(row.values.is_empty());
    }

    #[test]
    fn data_records_join_their_second_or_stand_alone() {
        let text = format!(
            "J020810OAT1112WSP\n{}K1602400120512\n{}K160241-0507x\nK160239999\n",
            fix_at("160240"),
            fix_at("160242")
        );
        // The K record of second 240 reads OAT 012 and WSP 05.
        let log = Log::read(text.replace("K1602400120512", "K16024001205").as_bytes());
        let times: Vec<_> = log.rows.iter().map(|row| (row.time_s, row.fix.is_some())).collect();
        assert_eq!(times, [(0.0, true), (1.0, false), (2.0, true)]);
        assert_eq!(log.codes, ["OAT", "WSP"]);
        assert_eq!(log.rows[0].values, [(0, 12.0), (1, 5.0)]);
        assert_eq!(log.rows[1].values, [(0, -5.0), (1, 7.0)]);
        assert_eq!(log.losses.before_first_fix, 1);
    }

    #[test]
    fn what_can_not_be_read_is_counted_and_the_rest_is_read() {
        let text = format!(
            "AXXX\nHFDTE010203\n{}I013638FXA\n{}B16024\nrubbish\n{}\n\nB160243X\nI013638\n",
            fix_at("160240"),
            fix_at("160241"),
            fix_at("160242").trim_end().to_owned() + "01"
        );
        let log = Log::read(text.as_bytes());
        assert_eq!(log.rows.len(), 3);
        assert_eq!(
            log.losses,
            Losses {
                corrupt_lines: 3,
                first_corrupt_line: 6,
                bad_extension_records: 1,
                blank_values: 2,
                before_first_fix: 0
            }
        );
        assert_eq!(log.start, Some(((2003, 2, 1), 57_760)));
    }

    #[test]
    fn reads_every_kind_of_line_end() {
        for end in ["\n", "\r\n", "\r"] {
            let text = fix_at("160240").trim_end().to_owned() + end + fix_at("160241").trim_end() + end;
            assert_eq!(times(&text), [0.0, 1.0], "{end:?}");
        }
    }
}
