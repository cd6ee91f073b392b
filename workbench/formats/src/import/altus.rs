//! AltusMetrum's flight computers (TeleMega, TeleMetrum, EasyMega with a receiver), as exported by AltosUI:
//! CSV whose first line begins with `#version`.
//!
//! | in the log | in the flight |
//! |---|---|
//! | the `altitude` behind `longitude`, where the receiver has a lock | `gps_alt_m`; `gps_sats`, `gps_time_s`, the position |
//! | positions | `gps_vn_mps`, `gps_ve_mps`, by differences |
//! | `pressure`, `temperature` | `baro_pa`, `baro_temp_c` |
//! | `state`, `acceleration`, `tilt`, `accel_*`, `gyro_*` | signals `altus_*` in the log's units and axes, which are the board's |
//! | `altitude` (the first), `height`, `speed` | left out: they are computed from the pressure |
//!
//! A fix is repeated in every line until the next one; it is taken once, where its time or position changes.

use std::collections::BTreeSet;

use super::damage::percent;
use super::fixes::{Fix, Fixes};
use super::stamps::{self, Believed};
use super::table::{Destination, Filling, Samples, Table, assemble};
use super::velocity::{Position, TimedPosition, velocities};
use super::{ImportError, Importer};
use crate::import::gps_time::utc_text;
use flight_data::{Channel, Flight, Header, Note};

/// Beginning of the first line.
const BEGINNING: &[u8] = b"#version,serial,flight,call,time";
/// Columns of the receiver, which its altitude follows.
const OF_FIX: [&str; 9] =
    ["nsat", "latitude", "longitude", "year", "month", "day", "hour", "minute", "second"];
/// Columns that are kept unchanged.
const SIGNALS: [(&str, &str); 9] = [
    ("state", "altus_state"),
    ("acceleration", "altus_acceleration_mps2"),
    ("accel_x", "altus_accel_x_mps2"),
    ("accel_y", "altus_accel_y_mps2"),
    ("accel_z", "altus_accel_z_mps2"),
    ("gyro_roll", "altus_gyro_roll_dps"),
    ("gyro_pitch", "altus_gyro_pitch_dps"),
    ("gyro_yaw", "altus_gyro_yaw_dps"),
    ("tilt", "altus_tilt_deg"),
];

/// The importer of AltusMetrum's exports.
#[derive(Clone, Copy, Debug)]
pub struct Altus;

impl Importer for Altus {
    fn name(&self) -> &'static str {
        "AltusMetrum CSV"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        log.strip_prefix(b"\xef\xbb\xbf").unwrap_or(log).starts_with(BEGINNING)
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        Lines::read(log).convert()
    }
}

/// The log's lines as numbers.
#[derive(Default)]
struct Lines {
    names: Vec<String>,
    /// Numbers of each line that could be read; NaN for a cell that is not a number.
    rows: Vec<Vec<f64>>,
    /// Line number of each in the file, from 1.
    places: Vec<usize>,
    unread: usize,
    first_unread: usize,
    vehicle: Option<String>,
    /// The flight's number, as counted by the flight computer.
    number: String,
    state_names: Vec<(f64, String)>,
}

impl Lines {
    fn read(log: &[u8]) -> Self {
        let mut lines = Self::default();
        let log = log.strip_prefix(b"\xef\xbb\xbf").unwrap_or(log);
        let all = log.split(|byte| matches!(byte, b'\n' | b'\r')).filter(|line| !line.is_empty());
        for (index, line) in all.enumerate() {
            let text = String::from_utf8_lossy(line);
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            if index == 0 {
                lines.names = cells.iter().map(|name| name.trim_start_matches('#').to_owned()).collect();
                continue;
            }
            let numbers: Vec<f64> = cells.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
            let time_s = lines.column("time", 0).and_then(|column| numbers.get(column)).copied();
            if cells.len() != lines.names.len() || !time_s.is_some_and(f64::is_finite) {
                lines.first_unread = if lines.unread == 0 { index + 1 } else { lines.first_unread };
                lines.unread += 1;
                continue;
            }
            if lines.vehicle.is_none() {
                let cell =
                    |name| lines.column(name, 0).and_then(|column| cells.get(column)).copied().unwrap_or("");
                let clean =
                    |text: &str| text.chars().filter(|letter| !letter.is_control()).collect::<String>();
                let (serial, flight) = (clean(cell("serial")), clean(cell("flight")));
                lines.vehicle = Some(format!("AltusMetrum serial {serial}"));
                lines.number = flight;
            }
            if let (Some(state), Some(name)) = (lines.column("state", 0), lines.column("state_name", 0))
                && let (Some(state), Some(name)) = (numbers.get(state), cells.get(name))
                && lines.state_names.last().is_none_or(|(last, _)| last != state)
                && lines.state_names.len() < 32
            {
                lines.state_names.push((*state, (*name).chars().filter(char::is_ascii_alphabetic).collect()));
            }
            lines.rows.push(numbers);
            lines.places.push(index + 1);
        }
        lines
    }

    /// The column with that name, searched from an index on.
    fn column(&self, name: &str, from: usize) -> Option<usize> {
        self.names.iter().skip(from).position(|found| found == name).map(|place| place + from)
    }

    fn convert(self) -> Result<(Flight, Vec<Note>), ImportError> {
        let first_s = self.column("time", 0).map_or(0.0, |time| {
            self.rows.iter().filter_map(|row| row.get(time)).copied().fold(f64::INFINITY, f64::min)
        });
        let stamps_us: Vec<u64> = match self.column("time", 0) {
            // Rounded to the log's hundredth of a second, starting at zero, and limited to the greatest time
            // of a flight.
            Some(time) => {
                let us = |row: &Vec<f64>| (row.get(time).copied().unwrap_or(0.0) - first_s) * 1e6;
                self.rows.iter().map(|row| us(row).round().clamp(0.0, 9e15) as u64).collect()
            }
            None => Vec::new(),
        };
        let described = |stamp: usize| format!("line {}", self.places.get(stamp).copied().unwrap_or(0));
        let Believed { times_us, notes: mut clock, .. } =
            stamps::believe(&stamps_us, std::iter::empty(), described);
        let (fixes, without) = self.fixes(&times_us);
        if fixes.fixes.is_empty() {
            return Err(ImportError::NoFixInLog {
                format: "AltusMetrum CSV",
                messages: self.rows.len(),
                fixes_without: without,
                expected: "lines whose receiver is locked, with nsat, latitude, longitude and altitude",
                lost: Vec::new(),
            });
        }
        let mut fillings = fixes.fillings(&times_us);
        for (name, channel) in [("pressure", Channel::BaroPa), ("temperature", Channel::BaroTempC)] {
            fillings.extend(self.filling(name, Destination::Channel(channel)));
        }
        for (name, signal) in SIGNALS {
            fillings.extend(self.filling(name, Destination::signal(signal)));
        }
        let header = Header {
            vehicle: self.vehicle.clone().unwrap_or_default(),
            source: "imported AltusMetrum CSV".to_owned(),
            other: vec![
                ("log_format".to_owned(), "altusmetrum".to_owned()),
                ("flight_number".to_owned(), self.number.clone()),
                ("gps_velocity".to_owned(), "derived from positions".to_owned()),
            ],
            ..Header::default()
        };
        let Table { mut flight, start_us, .. } = assemble(header, &times_us, fillings);
        if let Some(epoch_us) = fixes.epoch_us {
            let start = utc_text(epoch_us.saturating_add_unsigned(start_us).div_euclid(1_000_000));
            flight.header.other.extend(start.map(|start| ("start_utc".to_owned(), start)));
        }
        let mut notes = self.notes(&flight, &fixes, without, first_s + start_us as f64 / 1e6);
        notes.append(&mut clock);
        let believed: BTreeSet<u64> = times_us.iter().flatten().copied().collect();
        let shared = times_us.iter().flatten().count() - believed.len();
        if shared > 0 {
            notes.push(format!("lines with the same time as a later one, whose numbers count: {shared}"));
        }
        Ok((flight, notes.into_iter().map(Note::new).collect()))
    }

    fn notes(&self, flight: &Flight, fixes: &Fixes, without: usize, zero_s: f64) -> Vec<String> {
        let count = self.rows.len() + self.unread;
        let states: Vec<&str> = self.state_names.iter().map(|(_, name)| name.as_str()).collect();
        let mut notes = vec![
            format!(
                "{count} lines over {:.1} s, states {}; time zero is {zero_s:.2} s of the flight computer's clock, which counts \
                 from the launch that it detected",
                flight.time_s.last().copied().unwrap_or(0.0),
                states.join(", ")
            ),
            format!(
                "fixes: {}, each taken once (lines that repeat one: {}); gps_vn_mps and gps_ve_mps are derived from positions; \
                 no vertical velocity is measured",
                fixes.fixes.len(),
                fixes.repeated
            ),
        ];
        if self.unread > 0 {
            notes.push(format!(
                "damaged: lines that could not be read and were left out: {} ({}), the first is line {}",
                self.unread,
                percent(self.unread, count),
                self.first_unread
            ));
        }
        if without > 0 {
            notes.push(format!("lines without a lock of the receiver, which give no fix: {without}"));
        }
        if flight.channel(Channel::BaroPa).is_none() {
            notes.push(
                "no barometer: the log has no pressure, so there is none to calibrate in it".to_owned(),
            );
        }
        notes
    }

    fn filling(&self, name: &str, destination: Destination) -> Option<Filling<'static>> {
        let column = self.column(name, 0)?;
        let samples = self.rows.iter().zip(0_u32..).filter_map(|(row, stamp)| {
            let value = *row.get(column)?;
            value.is_finite().then_some((stamp, value as f32))
        });
        Some(Filling { destination, samples: Samples::Own(samples.collect()) })
    }

    /// The fixes, and how many lines have none.
    fn fixes(&self, times_us: &[Option<u64>]) -> (Fixes, usize) {
        let places: Option<Vec<usize>> = OF_FIX.iter().map(|name| self.column(name, 0)).collect();
        let Some(places) = places else { return (Fixes::default(), self.rows.len()) };
        let altitude = places.get(2).and_then(|longitude| self.column("altitude", *longitude));
        let (Some(altitude), locked) = (altitude, self.column("locked", 0)) else {
            return (Fixes::default(), self.rows.len());
        };
        let mut without = 0;
        let mut found: Vec<Fix> = Vec::new();
        for (row, stamp) in self.rows.iter().zip(0_u32..) {
            let number = |place: usize| row.get(place).copied().unwrap_or(f64::NAN);
            let of_fix = |k: usize| places.get(k).map_or(f64::NAN, |place| number(*place));
            let is_locked = locked.is_none_or(|locked| number(locked) == 1.0);
            if !is_locked || !number(altitude).is_finite() || !of_fix(1).is_finite() || !of_fix(2).is_finite()
            {
                without += 1;
                continue;
            }
            found.push(Fix {
                stamp,
                time_us: utc_us([3, 4, 5, 6, 7, 8].map(of_fix)),
                altitude_m: number(altitude),
                velocity_mps: [f64::NAN; 3],
                satellites: of_fix(0),
                vertical_accuracy_m: f64::NAN,
                latitude_deg: of_fix(1),
                longitude_deg: of_fix(2),
            });
        }
        let mut fixes = Fixes::new(found, times_us);
        let timed = |fix: &Fix| {
            let time_us = times_us.get(fix.stamp as usize).copied().flatten()?;
            let position = Position { latitude_deg: fix.latitude_deg, longitude_deg: fix.longitude_deg };
            Some((time_us as f64 / 1e6, position))
        };
        let positions: Vec<Option<TimedPosition>> = fixes.fixes.iter().map(timed).collect();
        let velocities = velocities(positions.iter().copied().flatten());
        let believed = fixes.fixes.iter_mut().zip(&positions).filter(|(_, position)| position.is_some());
        for ((fix, _), velocity) in believed.zip(velocities) {
            if let Some((north, east)) = velocity {
                fix.velocity_mps = [f64::from(north), f64::from(east), f64::NAN];
            }
        }
        (fixes, without)
    }
}

/// Microseconds since 1970 of year, month, day, hour, minute and second.
fn utc_us([year, month, day, hour, minute, second]: [f64; 6]) -> Option<u64> {
    let whole = |value: f64, most: f64| (0.0..=most).contains(&value).then_some(value as u8);
    let month = time::Month::try_from(whole(month, 12.0)?).ok()?;
    let date = time::Date::from_calendar_date(year as i32, month, whole(day, 31.0)?).ok()?;
    let time = time::Time::from_hms(whole(hour, 23.0)?, whole(minute, 59.0)?, whole(second, 59.0)?).ok()?;
    let seconds = time::UtcDateTime::new(date, time).unix_timestamp();
    u64::try_from(seconds).ok().map(|seconds| seconds * 1_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten lines a second, a fix a second; the barometric altitude is not the receiver's.
    fn log(seconds: usize) -> String {
        let mut log = "#version,serial,flight,call,time,state,state_name,acceleration,pressure,altitude,height,speed,temperature,\
                       connected,locked,nsat,latitude,longitude,altitude,year,month,day,hour,minute,second,pad_dist\n"
            .to_owned();
        for k in 0..seconds * 10 {
            let (second, altitude) = (k / 10, 1_394 + 30 * (k / 10));
            log += &format!(
                "6, 6583, 3,CALL, {:.2}, 3,   boost, 1.47, {}.00, 1330.09, 0.28,     NaN, 33.4, 1, 1, 11, 32.9395109,\
                 {:.7}, {altitude}.0, 2022,  6, 24, 15, 17, {second}, 0\n",
                k as f64 / 10.0 - 0.3,
                86_334 - k,
                -106.911_431_8 + 0.0001 * second as f64,
            );
        }
        log
    }

    fn samples(flight: &Flight, channel: Channel) -> Vec<(f64, f32)> {
        let column = flight.channel(channel).unwrap_or_else(|| panic!("no {}", channel.name()));
        column.samples().map(|(row, value)| (flight.time_s[row], value)).collect()
    }

    #[test]
    fn the_receivers_altitude_is_the_second_one_and_a_repeated_fix_is_one() {
        let (flight, notes) = crate::import::import(log(5).as_bytes()).unwrap();
        assert_eq!(
            samples(&flight, Channel::GpsAltM),
            [(0.0, 1394.0), (1.0, 1424.0), (2.0, 1454.0), (3.0, 1484.0), (4.0, 1514.0)]
        );
        assert_eq!(samples(&flight, Channel::GpsTimeS)[4].1, 4.0);
        assert_eq!(samples(&flight, Channel::BaroPa).len(), 50);
        assert_eq!(samples(&flight, Channel::BaroPa)[1], (0.1, 86_333.0));
        assert_eq!(samples(&flight, Channel::BaroTempC)[0].1, 33.4);
        // One ten-thousandth of a degree of longitude at that latitude.
        let east = samples(&flight, Channel::GpsVeMps)[2].1;
        assert!((east - 9.35).abs() < 0.02, "{east}");
        assert_eq!(flight.header.vehicle, "AltusMetrum serial 6583");
        assert!(flight.header.other.contains(&("flight_number".to_owned(), "3".to_owned())));
        assert!(flight.header.other.contains(&("start_utc".into(), "2022-06-24T15:17:00Z".into())));
        let said = |words: &str| notes.iter().any(|note| note.text().contains(words));
        assert!(said("fixes: 5, each taken once (lines that repeat one: 45)"), "{notes:?}");
        assert!(said("time zero is -0.30 s"), "{notes:?}");
    }

    #[test]
    fn lines_that_can_not_be_read_and_times_that_leap_are_named() {
        let text = log(10);
        let mut lines: Vec<&str> = text.lines().collect();
        let leap = lines[60].replace(" 5.60,", " 6000000.00,");
        assert_ne!(leap, lines[60]);
        lines[60] = &leap;
        lines[20] = "6, 6583, 3";
        let (flight, notes) = crate::import::import(lines.join("\n").as_bytes()).unwrap();
        assert_eq!(samples(&flight, Channel::BaroPa).len(), 98);
        assert!(*flight.time_s.last().unwrap() < 10.0);
        let said = |words: &str| notes.iter().any(|note| note.text().contains(words));
        assert!(said("left out: 1 (1.0 %), the first is line 21"), "{notes:?}");
        assert!(said("the first is at line 61, with a time of 6000000.300 s"), "{notes:?}");
        for length in 0..text.len() {
            let _ = crate::import::import(&text.as_bytes()[..length]);
        }
    }

    #[test]
    fn a_log_without_a_lock_is_refused() {
        let text = log(2).replace(", 1, 1, 11,", ", 1, 0, 0,");
        let error = crate::import::import(text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.starts_with("AltusMetrum CSV without a 3D fix of a receiver (20 messages read, 20"),
            "{error}"
        );
        assert!(!Altus.recognises(b"# pylon-flight: 1\n"));
    }
}
