//! An IGC file line by line, before its numbers get units.

use super::records::{self, Extension};
use super::times::{self, Judged};
use crate::import::velocity::Position;
use flight_data::Column;

const HALF_DAY_S: f64 = times::HALF_DAY_S as f64;
const DAY_S: f64 = 86_400.0;

/// The altitudes of a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Altitudes {
    /// Pressure altitude above 1013.25 hPa, metres.
    pub pressure_m: f32,
    /// GNSS altitude, metres.
    pub gnss_m: f32,
    /// Validity A: a 3D fix. Otherwise (V) there is no GNSS altitude.
    pub is_3d: bool,
}

/// What was left out, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// B and K records that could not be read, and lines that are not a record.
    pub corrupt_lines: usize,
    /// The first of them, as a line number of the file, from 1.
    pub first_corrupt_line: usize,
    /// I and J records that contradict themselves.
    pub bad_extension_records: usize,
    /// Additional values that are blank, not a number or cut off.
    pub blank_values: usize,
    /// Records with a time before the first fix.
    pub before_first_fix: usize,
    /// The first of them, as a line number of the file, from 1.
    pub first_before_line: usize,
    /// B and K records.
    pub records: usize,
    /// B and K records whose time contradicts those around them.
    pub times: Judged,
}

/// A log as read: one cell a row in each column, because rows allocated separately take several times the
/// size of their line. Rows are in file order; those of K records are at their time.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Seconds since the first fix.
    pub time_s: Vec<f64>,
    /// The altitudes of the fix, unless the row only has data of a K record.
    pub fixes: Vec<Option<Altitudes>>,
    /// Positions with every digit of the log; NaN where there is no fix.
    pub positions: Vec<Position>,
    /// Additional values by their three-letter code, as unconverted numbers. Whole numbers of up to seven
    /// digits are exact.
    pub values: Vec<(String, Column)>,
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
            // A data record from before the midnight that has been passed.
            absolute_s -= DAY_S;
        }
        self.last_s = absolute_s;
        // Rounded so that fractions of a second have no more digits than the log.
        Some(((absolute_s - first_s) * 1e6).round() / 1e6)
    }
}

impl Log {
    /// Reads a log, and counts what cannot be read.
    #[must_use]
    pub fn read(text: &[u8]) -> Self {
        let rows = lines(text).filter(|line| matches!(line.first(), Some(b'B' | b'K'))).count();
        let mut log = Self {
            time_s: Vec::with_capacity(rows),
            fixes: Vec::with_capacity(rows),
            positions: Vec::with_capacity(rows),
            ..Self::default()
        };
        let mut clock = Clock::default();
        let mut fix_extensions = Vec::new();
        let mut data_extensions = Vec::new();
        let mut date = None;
        log.losses.times = times::judge(text);
        let left_out = std::mem::take(&mut log.losses.times.left_out);
        let mut left_out = left_out.into_iter().peekable();
        for (index, line) in lines(text).enumerate() {
            let line = line.trim_ascii_end();
            let before = log.losses.before_first_fix;
            log.losses.records += usize::from(matches!(line.first(), Some(b'B' | b'K')));
            if left_out.next_if_eq(&index).is_some() {
                continue;
            }
            let good = match line.first() {
                None => true,
                // No recorder writes a zero byte: the data of the card are lost there.
                Some(_) if memchr::memchr(0, line).is_some() => false,
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
            if log.losses.before_first_fix > before && before == 0 {
                log.losses.first_before_line = index + 1;
            }
            if !good {
                if log.losses.corrupt_lines == 0 {
                    log.losses.first_corrupt_line = index + 1;
                }
                log.losses.corrupt_lines += 1;
            }
        }
        let rows = log.time_s.len();
        log.values.iter_mut().for_each(|(_, column)| column.fill_up(rows));
        log
    }

    /// The value of the first H record with that code.
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

    /// Stores a row's additional values; a later value of the same code replaces the earlier one.
    fn take_values(&mut self, row: usize, line: &[u8], extensions: &[Extension]) {
        let room = self.time_s.capacity();
        for extension in extensions {
            if matches!(extension.code.as_str(), "LAD" | "LOD" | "TDS") {
                continue;
            }
            let Some(number) = extension.number(line) else {
                self.losses.blank_values += 1;
                continue;
            };
            let place =
                self.values.iter().position(|(code, _)| *code == extension.code).unwrap_or_else(|| {
                    self.values.push((extension.code.clone(), Column::with_capacity(room)));
                    self.values.len() - 1
                });
            if let Some((_, column)) = self.values.get_mut(place) {
                column.fill_up(row + 1);
                column.set(row, Some(number as f32));
            }
        }
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
        self.take_values(self.time_s.len(), line, extensions);
        self.time_s.push(time_s);
        self.positions.push(position);
        self.fixes.push(Some(Altitudes {
            pressure_m: fix.pressure_altitude_m,
            gnss_m: fix.gnss_altitude_m,
            is_3d: fix.is_3d,
        }));
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
        // A K record may follow the fix of a later second; its place is before that fix.
        let later = self.time_s.iter().rev().take_while(|later_s| **later_s > time_s).count();
        let place = self.time_s.len() - later;
        let last = place.checked_sub(1);
        let row = match last.filter(|last| self.time_s.get(*last) == Some(&time_s)) {
            Some(row) => row,
            None => {
                self.insert_row(place, time_s);
                place
            }
        };
        self.take_values(row, line, extensions);
        true
    }

    /// Inserts a row without a fix.
    fn insert_row(&mut self, place: usize, time_s: f64) {
        self.time_s.insert(place, time_s);
        self.fixes.insert(place, None);
        self.positions.insert(place, Position { latitude_deg: f64::NAN, longitude_deg: f64::NAN });
        for (_, column) in self.values.iter_mut().filter(|(_, column)| column.len() > place) {
            column.insert(place, None);
        }
    }
}

/// Lines that end with LF, CR LF or CR.
pub fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
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
        Log::read(text.as_bytes()).time_s
    }

    fn fix_at(time: &str) -> String {
        format!("B{time}5407121N00249342WA0028000421\r\n")
    }

    fn cells(log: &Log) -> Vec<(&str, Vec<Option<f32>>)> {
        let of = |column: &Column| (0..column.len()).map(|row| column.get(row)).collect();
        log.values.iter().map(|(code, column)| (code.as_str(), of(column))).collect()
    }

    #[test]
    fn time_counts_from_the_first_fix_and_passes_midnight() {
        let at = |list: &[&str]| list.iter().map(|time| fix_at(time)).collect::<String>();
        assert_eq!(times(&at(&["235958", "235959", "000001", "000002"])), [0.0, 1.0, 3.0, 4.0]);
        // Repeated and backward times are kept; the estimator counts them.
        assert_eq!(times(&at(&["100000", "100001", "100001", "100000"])), [0.0, 1.0, 1.0, 0.0]);
        let log = Log::read(at(&["100000", "095959", "100001"]).as_bytes());
        assert_eq!((log.time_s.len(), log.losses.before_first_fix), (2, 1));
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
        let position = log.positions[0];
        assert!((position.latitude_deg - (54.0 + 7.1215 / 60.0)).abs() < 1e-12);
        assert!((position.longitude_deg + (2.0 + 49.3426 / 60.0)).abs() < 1e-12);
        // '-7' is not decimals; '07' is seven hundredths.
        assert_eq!(log.time_s, [0.0, 1.07]);
        assert!(log.positions[1].latitude_deg < -54.118_69);
        assert!(log.values.is_empty());
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
        assert_eq!(log.time_s, [0.0, 1.0, 2.0]);
        assert_eq!(log.fixes.iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, true]);
        assert_eq!(
            cells(&log),
            [("OAT", vec![Some(12.0), Some(-5.0), None]), ("WSP", vec![Some(5.0), Some(7.0), None])]
        );
        assert_eq!(log.losses.before_first_fix, 1);
    }

    #[test]
    fn a_row_that_is_put_in_late_moves_the_values_of_those_after_it() {
        let [first, second] = ["160240", "160243"].map(|time| fix_at(time).trim_end().to_owned());
        let text = format!("I013636SIU\nJ010809OAT\n{first}7\n{second}8\nK16024111\nK16024212\nK16024313\n");
        let log = Log::read(text.as_bytes());
        assert_eq!(log.time_s, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(
            cells(&log),
            [
                ("SIU", vec![Some(7.0), None, None, Some(8.0)]),
                ("OAT", vec![None, Some(11.0), Some(12.0), Some(13.0)])
            ]
        );
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
        assert_eq!(log.time_s.len(), 3);
        assert_eq!(
            log.losses,
            Losses {
                corrupt_lines: 3,
                first_corrupt_line: 6,
                bad_extension_records: 1,
                blank_values: 2,
                records: 5,
                ..Losses::default()
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
