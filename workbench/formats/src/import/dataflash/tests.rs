use super::*;
use crate::import::testing::{
    assert_any_byte_costs_its_message, assert_channels, assert_garbage_costs_nothing_else, doubles, garbage,
    import, said, samples, signal,
};
use flight_data::Channel;

/// The value of a field.
#[derive(Clone, Debug)]
enum Cell {
    Number(f64),
    Text(String),
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// Writes the same log in both formats.
#[derive(Clone, Default)]
struct Writer {
    kinds: Vec<(u8, &'static str, &'static str, &'static str)>,
    binary: Vec<u8>,
    text: String,
    /// Start of each message in the binary format, and its name.
    places: Vec<(usize, &'static str)>,
}

fn size(letter: u8) -> usize {
    match letter {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' => 2,
        b'n' | b'i' | b'I' | b'e' | b'E' | b'L' | b'f' => 4,
        b'N' => 16,
        b'Z' => 64,
        _ => 8,
    }
}

impl Writer {
    fn define(&mut self, kind: u8, name: &'static str, letters: &'static str, columns: &'static str) {
        self.kinds.push((kind, name, letters, columns));
        let length = 3 + letters.bytes().map(size).sum::<usize>();
        self.places.push((self.binary.len(), "FMT"));
        self.binary.extend([0xa3, 0x95, 128, kind, length as u8]);
        for (text, width) in [(name, 4), (letters, 16), (columns, 64)] {
            let mut bytes = text.as_bytes().to_vec();
            bytes.resize(width, 0);
            self.binary.extend(bytes);
        }
        self.text += &format!("FMT, {kind}, {length}, {name}, {letters}, {columns}\n");
    }

    fn put(&mut self, wanted: &str, cells: &[Cell]) {
        let (kind, name, letters, columns) =
            *self.kinds.iter().find(|(_, name, ..)| *name == wanted).unwrap();
        assert_eq!(cells.len(), columns.split(',').count(), "{name}");
        self.places.push((self.binary.len(), name));
        self.binary.extend([0xa3, 0x95, kind]);
        let mut line = name.to_owned();
        for (letter, cell) in letters.bytes().zip(cells) {
            match cell {
                Cell::Number(number) => {
                    let scaled = (number * if letter == b'L' { 1e7 } else { 100.0 }).round();
                    let bytes = match letter {
                        b'b' | b'M' => (*number as i8).to_le_bytes().to_vec(),
                        b'B' => vec![*number as u8],
                        b'h' => (*number as i16).to_le_bytes().to_vec(),
                        b'H' => (*number as u16).to_le_bytes().to_vec(),
                        b'i' => (*number as i32).to_le_bytes().to_vec(),
                        b'I' => (*number as u32).to_le_bytes().to_vec(),
                        b'c' => (scaled as i16).to_le_bytes().to_vec(),
                        b'C' => (scaled as u16).to_le_bytes().to_vec(),
                        b'e' | b'L' => (scaled as i32).to_le_bytes().to_vec(),
                        b'E' => (scaled as u32).to_le_bytes().to_vec(),
                        b'f' => (*number as f32).to_le_bytes().to_vec(),
                        b'Q' => (*number as u64).to_le_bytes().to_vec(),
                        other => panic!("letter {}", char::from(other)),
                    };
                    self.binary.extend(bytes);
                    line += &match letter {
                        b'f' => format!(", {}", *number as f32),
                        _ => format!(", {number}"),
                    };
                }
                Cell::Text(text) => {
                    let mut bytes = text.as_bytes().to_vec();
                    bytes.resize(size(letter), 0);
                    self.binary.extend(bytes);
                    line += &format!(", {text}");
                }
            }
        }
        self.text += &(line + "\n");
    }
}

macro_rules! put {
    ($writer:expr, $name:literal, $($cell:expr),*) => { $writer.put($name, &[$(Cell::from($cell)),*]) };
}

const WEEK: f64 = 2_100.0;

fn gps(writer: &mut Writer, time_us: f64, week_ms: f64, altitude_m: f64) {
    put!(
        writer,
        "GPS",
        time_us,
        0.0,
        3.0,
        week_ms,
        WEEK,
        12.0,
        0.8,
        47.123_456_7,
        8.765_432_1,
        altitude_m,
        10.0,
        90.0,
        -1.5
    );
}

/// Log of a current copter, `seconds` long; every fix is logged twice.
fn copter(seconds: u32) -> Writer {
    copter_of(seconds, false)
}

/// As [`copter`], with a second receiver that is 4 m higher and has one fix less.
fn copter_of(seconds: u32, has_second: bool) -> Writer {
    let mut writer = Writer::default();
    writer.define(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    writer.define(129, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds");
    writer.define(130, "PARM", "QNf", "TimeUS,Name,Value");
    writer.define(131, "MSG", "QZ", "TimeUS,Message");
    writer.define(132, "BARO", "QBffc", "TimeUS,I,Alt,Press,Temp");
    writer.define(133, "GPS", "QBBIHBcLLefff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ");
    writer.define(134, "GPA", "QBCC", "TimeUS,I,HAcc,VAcc");
    writer.define(135, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
    writer.define(136, "ATT", "QccC", "TimeUS,Roll,Pitch,Yaw");
    writer.define(137, "CTUN", "Qffhh", "TimeUS,ThI,ThO,CRt,X");
    writer.define(138, "MAG", "Qh", "TimeUS,MagX");
    put!(writer, "FMTU", 1e6, 132.0, "s#mPO", "F-000");
    put!(writer, "FMTU", 1e6, 137.0, "s--n-", "F--B-");
    put!(writer, "PARM", 1e6, "BARO_PRIMARY", 0.0);
    put!(writer, "MSG", 1e6, "ArduCopter V4.5.1 (2cb2a5ae), made");
    for k in 0..seconds * 10 {
        let time_us = 2e6 + f64::from(k) * 1e5;
        put!(writer, "IMU", time_us, 0.0, 0.01, 0.02, 0.03, 0.1, 0.2, -9.8);
        put!(writer, "IMU", time_us, 1.0, 0.01, 0.02, 0.03, 0.1, 0.2, -9.8);
        put!(writer, "ATT", time_us + 100.0, 1.5, -2.5, 337.0);
        put!(writer, "BARO", time_us + 200.0, 0.0, 1.0, 95_000.0 + f64::from(k), 31.5);
        put!(writer, "BARO", time_us + 200.0, 1.0, 1.0, 95_100.0 + f64::from(k), 41.5);
        put!(writer, "CTUN", time_us + 300.0, 0.4, 0.45, -150.0, 0.0);
        if k % 2 == 0 {
            let week_ms = 100_000.0 + f64::from(k / 4) * 400.0;
            gps(&mut writer, time_us + 400.0, week_ms, 500.0 + f64::from(k / 4) * 0.25);
            put!(writer, "GPA", time_us + 400.0, 0.0, 0.9, 1.75);
            if has_second && k % 4 == 0 && k > 0 {
                let altitude_m = 504.0 + f64::from(k / 4) * 0.25;
                let time_us = time_us + 450.0;
                put!(
                    writer, "GPS", time_us, 1.0, 3.0, week_ms, WEEK, 9.0, 0.8, 47.1, 8.7, altitude_m, 10.0,
                    90.0, -1.5
                );
            }
        }
        put!(writer, "MAG", time_us + 500.0, 200.0);
    }
    writer
}

fn times(flight: &Flight, channel: Channel) -> Vec<f64> {
    let column = flight.channel(channel).unwrap();
    column.samples().map(|(row, _)| flight.time_s[row]).collect()
}

#[test]
fn a_copters_log_is_the_same_flight_in_both_forms() {
    let log = copter(10);
    let (flight, notes) = import(&log.binary);
    let (from_text, text_notes) = import(log.text.as_bytes());
    assert_eq!(flight.header, from_text.header);
    assert_eq!(flight.time_s, from_text.time_s);
    for (channel, _) in &flight.channels {
        assert_eq!(samples(&flight, *channel), samples(&from_text, *channel), "{}", channel.name());
    }
    assert_eq!(notes, text_notes);
    assert_eq!(flight.header.vehicle, "ArduCopter V4.5.1 (2cb2a5ae), made");
    assert!(flight.header.other.contains(&("parameter BARO_PRIMARY".into(), "0".into())));
    // Week 2100 began on 2020-04-05; 100 s into it, less 18 leap seconds, less the 0.4 ms before the first
    // fix.
    assert!(
        flight.header.other.contains(&("start_utc".into(), "2020-04-05T00:01:21Z".into())),
        "{:?}",
        flight.header
    );

    let expected = [
        (Channel::BaroPa, 100, 95_000.0),
        (Channel::BaroTempC, 100, 31.5),
        (Channel::GpsAltM, 25, 500.0),
        (Channel::GpsVdMps, 25, -1.5),
        (Channel::GpsVeMps, 25, 10.0),
        (Channel::GpsSats, 25, 12.0),
        (Channel::GpsVaccM, 25, 1.75),
        (Channel::GpsTimeS, 25, 0.0),
        (Channel::AccelZMps2, 100, -9.8),
        (Channel::AccelXMps2, 100, 0.1),
        (Channel::GyroYRadps, 100, 0.02),
        (Channel::GyroZRadps, 100, 0.03),
        (Channel::RollRad, 100, 1.5_f32.to_radians()),
        (Channel::PitchRad, 100, (-2.5_f32).to_radians()),
        (Channel::YawRad, 100, (-23_f32).to_radians()),
        (Channel::Throttle, 100, 0.45),
    ];
    assert_channels(&flight, &expected);
    assert!(samples(&flight, Channel::GpsVnMps)[0].abs() < 1e-6);
    // With FMTU's multiplier, the integer -150 means hundredths of m/s.
    assert_eq!(signal(&flight, "autopilot_climb_mps")[0], -1.5);
    assert_eq!(signal(&flight, "baro_2_pa")[99], 95_199.0);
    assert_eq!(doubles(&flight, "latitude_deg")[0], 47.123_456_7);
    for words in [
        "used: FMTU (2), PARM (1), MSG (1), BARO (200), GPS (50), GPA (50), IMU (200), ATT (100), CTUN (100)",
        "not used: MAG (100)",
        "baro 2: 100 messages, kept as baro_2_pa, baro_2_temp_c; baro 1 is used",
        "imu 2: 100 messages, left out",
        "repeat the fix before them, taken once: 25",
    ] {
        assert!(said(&notes, words), "{words}: {notes:#?}");
    }
}

#[test]
fn a_log_with_any_byte_changed_costs_that_message_and_moves_no_other() {
    let log = copter(3);
    let (first, _) = *log.places.iter().find(|(_, name)| *name == "IMU").unwrap();
    let message_of = |at| {
        let (start, name) = *log.places.iter().rev().find(|(place, _)| *place <= at).unwrap();
        (start, name.to_owned())
    };
    assert_any_byte_costs_its_message(&log.binary, message_of, first);
}

#[test]
fn a_log_cut_anywhere_is_read_up_to_there() {
    let log = copter(3);
    let mut last = 0;
    for length in 0..=log.binary.len() {
        if let Ok((flight, _)) = crate::import::import(&log.binary[..length]) {
            let found = samples(&flight, Channel::BaroPa).len();
            // Complete messages before the cut; only one of two instances counts.
            let whole = log.places.iter().enumerate().filter(|(index, (_, name))| {
                *name == "BARO" && log.places.get(index + 1).is_none_or(|(end, _)| *end <= length)
            });
            assert_eq!(found, whole.count().div_ceil(2), "{length}");
            assert!(found >= last);
            last = found;
        }
    }
    assert_eq!(last, 30);
    for length in (0..log.text.len()).step_by(7) {
        let _ = crate::import::import(&log.text.as_bytes()[..length]);
    }
    let (_, notes) = import(&log.binary[..log.binary.len() - 2]);
    assert!(said(&notes, &format!("begins at byte {}", log.binary.len() - 13)), "{notes:?}");
}

#[test]
fn garbage_in_the_middle_and_lost_bytes_are_named_and_cost_nothing_else() {
    let log = copter(10);
    let clean = import(&log.binary).0;
    // It contains headers of a defined and of an undefined kind.
    let mut garbage = garbage(5_000);
    garbage[100..103].copy_from_slice(&[0xa3, 0x95, 132]);
    garbage[200..203].copy_from_slice(&[0xa3, 0x95, 250]);
    assert_garbage_costs_nothing_else(&log.binary, log.places[400].0, &garbage);

    // Ten bytes are missing in a message; the next one is complete.
    let (at, _) = *log.places.iter().skip(400).find(|(_, name)| *name == "IMU").unwrap();
    let mut bytes = log.binary.clone();
    bytes.drain(at + 10..at + 20);
    let (flight, notes) = import(&bytes);
    assert_eq!(samples(&flight, Channel::BaroPa), samples(&clean, Channel::BaroPa));
    let lost = samples(&clean, Channel::AccelXMps2).len() - samples(&flight, Channel::AccelXMps2).len();
    assert!(lost <= 1 && said(&notes, &format!("the first at byte {at}")), "{lost} {notes:?}");
}

#[test]
fn a_time_that_contradicts_its_neighbours_is_named_and_left_out() {
    let log = copter(10);
    let (at, _) = *log.places.iter().skip(500).find(|(_, name)| *name == "BARO").unwrap();
    for (byte, flip) in [(3 + 7, 0x40), (3 + 3, 0x04), (3 + 2, 0x40)] {
        let mut bytes = log.binary.clone();
        bytes[at + byte] ^= flip;
        let (flight, notes) = import(&bytes);
        assert_eq!(samples(&flight, Channel::BaroPa).len(), 99);
        assert!(*flight.time_s.last().unwrap() < 10.0);
        let words = format!("contradicts those around them, left out: 1 (0.14 %); the first is at byte {at}");
        assert!(said(&notes, &words), "{notes:?}");
    }
}

#[test]
fn text_lines_that_can_not_be_read_are_counted_and_named() {
    let log = copter(10);
    let number = log.text.lines().position(|line| line.starts_with("BARO")).unwrap();
    let mut lines: Vec<String> = log.text.lines().map(str::to_owned).collect();
    lines[number] = "BARO, 2000200, 0, 1.0, 95o00.0, 31.5".into();
    lines[number + 20] = "BARO, 3000".into();
    lines.insert(number + 30, "\u{1}rubbish".into());
    lines.insert(number + 31, "NEW, 1, 2".into());
    let (_, notes) = import(lines.join("\r\n").as_bytes());
    let words = "lines that could not be read and were left out: 3";
    assert!(said(&notes, words) && said(&notes, &format!("the first is line {}", number + 1)), "{notes:?}");
    assert!(said(&notes, "kinds that the log does not define, left out: 1"), "{notes:?}");
    // A file written on Windows by another program.
    let wide: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(log.text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    for log in [&wide[..], &wide[2..]] {
        let error = crate::import::import(log).unwrap_err().to_string();
        assert!(error.starts_with("text in UTF-16, expected UTF-8"), "{error}");
    }
}

#[test]
fn a_second_receiver_is_kept_beside_the_one_with_most_fixes() {
    let log = copter_of(10, true);
    for (flight, notes) in [import(&log.binary), import(log.text.as_bytes())] {
        assert_eq!(samples(&flight, Channel::GpsAltM).len(), 25);
        assert_eq!(signal(&flight, "gps_2_alt_m")[..2], [504.25, 504.5]);
        assert_eq!(signal(&flight, "gps_2_sats"), [9.0; 24]);
        assert!(
            said(
                &notes,
                "receiver 1, with 25 3D fixes, is the reference; receiver 2, with 24, is kept as gps_2_alt_m"
            ) && said(&notes, "differs from the other's by +4.0 m in the median"),
            "{notes:#?}"
        );
    }
}

/// A plane of 2014: times in milliseconds, the receiver's time in a field of its own, throttle in per cent,
/// no instances.
#[test]
fn a_log_of_milliseconds_has_the_receivers_own_time_beside_the_autopilots() {
    let mut writer = Writer::default();
    writer.define(
        130,
        "GPS",
        "BIHBcLLeeEefI",
        "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T",
    );
    writer.define(131, "BARO", "Iffcf", "TimeMS,Alt,Press,Temp,CRt");
    writer.define(132, "CTUN", "Icccch", "TimeMS,NavRoll,Roll,NavPitch,Pitch,ThrOut");
    writer.define(133, "ARSP", "Iff", "TimeMS,Airspeed,DiffPress");
    for k in 0..50 {
        let time_ms = 60_000.0 + f64::from(k) * 200.0;
        let week_ms = 130_040_903.0 + f64::from(k) * 200.0;
        put!(
            writer,
            "GPS",
            3.0,
            week_ms,
            1769.0,
            8.0,
            1.53,
            -35.354_717_8,
            149.166_967_3,
            5.0,
            885.52,
            20.0,
            180.0,
            0.5,
            time_ms
        );
        put!(writer, "BARO", time_ms + 5.0, 10.0, 90_000.0, 20.25, 0.0);
        put!(writer, "CTUN", time_ms + 7.0, 0.0, 1.0, 0.0, 1.0, 55.0);
        put!(writer, "ARSP", time_ms + 5.0, 20.0, 245.0);
    }
    for log in [&writer.binary[..], writer.text.as_bytes()] {
        let (flight, notes) = import(log);
        assert_eq!(times(&flight, Channel::GpsAltM)[1], 0.2);
        assert_eq!(times(&flight, Channel::BaroPa)[0], 0.005);
        assert_eq!(samples(&flight, Channel::GpsVdMps)[0], 0.5);
        assert_eq!(samples(&flight, Channel::GpsVnMps)[0], -20.0);
        assert_eq!(samples(&flight, Channel::Throttle)[0], 0.55);
        assert!(flight.header.other.contains(&("start_utc".into(), "2013-12-02T12:07:04Z".into())));
        // 900 hPa is 988.5 m in the standard atmosphere, where the density is 0.9085 of that at sea level.
        let true_mps = samples(&flight, Channel::TasMps)[0];
        assert!((true_mps - 20.0 / 0.9085_f32.sqrt()).abs() < 0.01, "{true_mps}");
        assert!(said(&notes, "tas_mps is ARSP's airspeed"), "{notes:?}");
    }
}

/// A log of 2012: only the receiver has a time, and the barometer is logged only in CTUN.
#[test]
fn messages_without_a_time_are_put_between_the_receivers_and_said() {
    let mut writer = Writer::default();
    writer.define(130, "GPS", "BIHBcLLeeEe", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs");
    writer.define(131, "CTUN", "hcefhhhhh", "ThrIn,SonAlt,BarAlt,WPAlt,NavThr,AngBst,CRate,ThrOut,DCRate");
    for k in 0..20 {
        put!(writer, "CTUN", 500.0, 0.0, 12.5, 15.0, 0.0, 0.0, 100.0, 500.0, 0.0);
        put!(
            writer,
            "GPS",
            3.0,
            1_000.0 + f64::from(k) * 200.0,
            1700.0,
            8.0,
            1.5,
            -35.0,
            149.0,
            5.0,
            885.5,
            0.0,
            0.0
        );
    }
    let (flight, notes) = import(&writer.binary);
    // The first is before any of the receiver's; each of the others is halfway between two fixes.
    assert_eq!(samples(&flight, Channel::BaroAltM), [12.5; 19]);
    assert_eq!(times(&flight, Channel::BaroAltM)[..2], [0.1, 0.3]);
    assert_eq!(samples(&flight, Channel::Throttle)[0], 0.5);
    assert_eq!(signal(&flight, "autopilot_climb_mps")[0], 1.0);
    for words in [
        "messages without a time of their own: 20",
        "left out: 1)",
        "baro_alt_m is CTUN's barometric altitude",
    ] {
        assert!(said(&notes, words), "{words}: {notes:?}");
    }
}

#[test]
fn a_log_without_a_barometer_or_a_fix_says_so() {
    let mut writer = Writer::default();
    writer.define(133, "GPS", "QBBIHBcLLefff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ");
    writer.define(134, "THR", "Qh", "TimeUS,ThrOut");
    for k in 0..20 {
        gps(&mut writer, f64::from(k) * 2e5, f64::from(k) * 200.0, 100.0);
        put!(writer, "THR", f64::from(k) * 2e5, 25.0);
    }
    let (flight, notes) = import(&writer.binary);
    assert!(said(&notes, "no barometer: the log has no BARO messages"), "{notes:?}");
    assert_eq!(samples(&flight, Channel::Throttle)[0], 0.25);
    assert!(flight.require_altitudes().is_err());

    let mut writer = Writer::default();
    writer.define(131, "BARO", "Iffcf", "TimeMS,Alt,Press,Temp,CRt");
    put!(writer, "BARO", 5.0, 10.0, 90_000.0, 20.25, 0.0);
    let error = crate::import::import(&writer.binary).unwrap_err().to_string();
    assert!(
        error.starts_with("ArduPilot DataFlash log without a 3D fix of a receiver (1 messages read"),
        "{error}"
    );
}

#[test]
fn units_that_contradict_a_field_leave_it_out() {
    let mut log = copter(10);
    // BARO.Press in metres.
    let text = log.text.replace("s#mPO", "s#mmO");
    log.text = text;
    let (flight, notes) = import(log.text.as_bytes());
    assert!(said(&notes, "BARO.Press is in m, which is not that field's unit elsewhere"), "{notes:?}");
    assert!(flight.channel(Channel::BaroPa).is_none());
}

#[test]
fn throttle_is_by_the_outputs_where_nothing_else_says_it() {
    let mut writer = Writer::default();
    writer.define(130, "PARM", "QNf", "TimeUS,Name,Value");
    writer.define(133, "GPS", "QBBIHBcLLefff", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ");
    writer.define(134, "RCOU", "QHHH", "TimeUS,C1,C2,C3");
    for (name, value) in [("SERVO3_FUNCTION", 70.0), ("SERVO3_MIN", 1_100.0), ("SERVO3_MAX", 1_900.0)] {
        put!(writer, "PARM", 1.0, name, value);
    }
    for k in 0..20 {
        gps(&mut writer, f64::from(k) * 2e5, f64::from(k) * 200.0, 100.0);
        put!(writer, "RCOU", f64::from(k) * 2e5, 1_500.0, 1_500.0 + f64::from(k), 1_300.0);
    }
    let (flight, notes) = import(&writer.binary);
    assert_eq!(samples(&flight, Channel::Throttle)[0], 0.25);
    assert!(said(&notes, "throttle is from the throttle's output pulses"), "{notes:?}");
    // An output that never moves is not a signal.
    assert_eq!((signal(&flight, "output_1_us").len(), signal(&flight, "output_2_us").len()), (0, 20));
}

#[test]
fn other_files_are_not_taken_for_logs() {
    for other in [
        &b""[..],
        b"FMT",
        b"FMT, 128",
        &[0xa3, 0x95, 128],
        &[0xa3; 4_000],
        b"time_s,gps_alt_m,baro_pa\n0,1,2\n",
        b"HFDTE010203\nB1602405407121N00249342WA0028000421\n",
    ] {
        assert!(!DataFlash.recognises(other) && !DataFlashText.recognises(other));
    }
}
