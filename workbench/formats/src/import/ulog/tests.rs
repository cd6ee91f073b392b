use super::*;
use crate::import::testing::{
    assert_any_byte_costs_its_message, assert_channels, assert_garbage_costs_nothing_else, doubles, garbage,
    import, said, samples, signal,
};
use flight_data::Channel;

/// Writes a log.
#[derive(Clone)]
struct Writer {
    log: Vec<u8>,
    formats: Vec<(&'static str, &'static str)>,
    ids: Vec<(u16, &'static str, u8)>,
    /// Where each message begins, and its kind.
    places: Vec<(usize, u8)>,
}

impl Writer {
    fn new() -> Self {
        let mut log = MAGIC.to_vec();
        log.push(1);
        log.extend(5_000_000_u64.to_le_bytes());
        Self { log, formats: Vec::new(), ids: Vec::new(), places: Vec::new() }
    }

    fn message(&mut self, kind: u8, payload: &[u8]) {
        self.places.push((self.log.len(), kind));
        self.log.extend((payload.len() as u16).to_le_bytes());
        self.log.push(kind);
        self.log.extend(payload);
    }

    fn flags(&mut self, incompatible: u8, appended: u64) {
        let mut payload = [0; 40];
        payload[8] = incompatible;
        payload[16..24].copy_from_slice(&appended.to_le_bytes());
        self.message(b'B', &payload);
    }

    fn format(&mut self, name: &'static str, members: &'static str) {
        self.formats.push((name, members));
        self.message(b'F', format!("{name}:{members}").as_bytes());
    }

    fn keyed(&mut self, kind: u8, key: &str, value: &[u8]) {
        let payload = [&[key.len() as u8], key.as_bytes(), value].concat();
        self.message(kind, &payload);
    }

    fn subscribe(&mut self, id: u16, topic: &'static str, instance: u8) {
        self.ids.push((id, topic, instance));
        let payload = [&[instance][..], &id.to_le_bytes(), topic.as_bytes()].concat();
        self.message(b'A', &payload);
    }

    /// Data of an id: its members' numbers in order, without padding.
    fn data(&mut self, id: u16, numbers: &[f64]) {
        let topic = self.ids.iter().find(|(known, ..)| *known == id).unwrap().1;
        let members = self.formats.iter().find(|(name, _)| *name == topic).unwrap().1;
        let mut payload = id.to_le_bytes().to_vec();
        let mut numbers = numbers.iter();
        for member in members.split(';').filter(|member| !member.is_empty()) {
            let (kind, name) = member.split_once(' ').unwrap();
            if name.starts_with("_padding") {
                continue;
            }
            let (kind, count) = match kind.split_once('[') {
                Some((kind, count)) => (kind, count.trim_end_matches(']').parse().unwrap()),
                None => (kind, 1),
            };
            for number in numbers.by_ref().take(count) {
                match kind {
                    "uint64_t" => payload.extend((*number as u64).to_le_bytes()),
                    "int32_t" => payload.extend((*number as i32).to_le_bytes()),
                    "float" => payload.extend((*number as f32).to_le_bytes()),
                    "double" => payload.extend(number.to_le_bytes()),
                    "uint8_t" | "bool" => payload.push(*number as u8),
                    other => panic!("{other}"),
                }
            }
        }
        assert!(numbers.next().is_none());
        self.message(b'D', &payload);
    }
}

const UTC_US: f64 = 1_700_000_000e6;

fn header() -> Writer {
    let mut log = Writer::new();
    log.flags(0, 0);
    log.keyed(b'I', "char[3] sys_name", b"PX4");
    log.keyed(b'I', "char[8] ver_hw", b"MADE_UP1");
    log.keyed(b'I', "uint32_t ver_sw_release", &[0xff, 3, 12, 1]);
    log.keyed(b'P', "float SENS_BARO_QNH", &1013.25_f32.to_le_bytes());
    log.keyed(b'P', "int32_t SYS_AUTOSTART", &4001_i32.to_le_bytes());
    log
}

/// A quadcopter of release 1.12; every fix comes twice.
fn copter(seconds: u32) -> Writer {
    let mut log = header();
    log.format(
        "vehicle_gps_position",
        "uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;int32_t alt;int32_t alt_ellipsoid;float epv;float vel_n_m_s;\
         float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;uint8_t satellites_used;uint8_t[5] _padding0;",
    );
    log.format(
        "vehicle_air_data",
        "uint64_t timestamp;float baro_alt_meter;float baro_temp_celcius;float baro_pressure_pa;float rho;",
    );
    log.format("sensor_baro", "uint64_t timestamp;float pressure;float temperature;");
    log.format("sensor_combined", "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;");
    log.format("vehicle_attitude", "uint64_t timestamp;float[4] q;");
    log.format("actuator_controls_0", "uint64_t timestamp;float[8] control;");
    log.format("cpuload", "uint64_t timestamp;float load;");
    for (id, topic, instance) in [
        (0, "vehicle_gps_position", 0),
        (1, "vehicle_air_data", 0),
        (2, "sensor_baro", 0),
        (3, "sensor_baro", 1),
        (4, "sensor_combined", 0),
        (5, "vehicle_attitude", 0),
        (6, "actuator_controls_0", 0),
        (7, "cpuload", 0),
    ] {
        log.subscribe(id, topic, instance);
    }
    for k in 0..seconds * 10 {
        let time_us = 5e6 + f64::from(k) * 1e5;
        let step = f64::from(k);
        log.data(4, &[time_us, 0.01, 0.02, 0.03, 0.1, 0.2, -9.8]);
        // A roll of 30 degrees.
        log.data(5, &[time_us + 100.0, 0.965_925_8, 0.258_819_04, 0.0, 0.0]);
        log.data(1, &[time_us + 200.0, 540.0, 31.5, 95_000.0 + step, 1.1]);
        log.data(2, &[time_us + 300.0, 950.0 + step / 100.0, 30.0]);
        log.data(3, &[time_us + 300.0, 951.0 + step / 100.0, 40.0]);
        log.data(6, &[time_us + 400.0, 0.0, 0.0, 0.0, 0.55, 0.0, 0.0, 0.0, 0.0]);
        if k % 2 == 0 {
            let fix = f64::from(k / 4);
            let utc_us = UTC_US + fix * 4e5;
            log.data(
                0,
                &[
                    time_us + 500.0,
                    utc_us,
                    471_234_567.0,
                    87_654_321.0,
                    500_000.0 + fix * 250.0,
                    548_000.0,
                    1.75,
                    1.0,
                    2.0,
                    -1.5,
                    3.0,
                    1.0,
                    12.0,
                ],
            );
        }
        log.data(7, &[time_us + 600.0, 0.5]);
    }
    log
}

#[test]
fn a_copters_log_has_every_channel_in_the_flights_units() {
    let (flight, notes) = import(&copter(10).log);
    assert_eq!(flight.header.vehicle, "PX4 1.12.3 on MADE_UP1");
    for (key, value) in [
        ("parameter SENS_BARO_QNH", "1013.25"),
        ("parameter SYS_AUTOSTART", "4001"),
        // 1.7e9 seconds, and half a millisecond less.
        ("start_utc", "2023-11-14T22:13:19Z"),
    ] {
        assert!(
            flight.header.other.contains(&(key.into(), value.into())),
            "{key}: {:?}",
            flight.header.other
        );
    }
    let expected = [
        (Channel::BaroPa, 100, 95_000.0),
        (Channel::BaroTempC, 100, 31.5),
        (Channel::GpsAltM, 25, 500.0),
        (Channel::GpsVnMps, 25, 1.0),
        (Channel::GpsVeMps, 25, 2.0),
        (Channel::GpsVdMps, 25, -1.5),
        (Channel::GpsSats, 25, 12.0),
        (Channel::GpsVaccM, 25, 1.75),
        (Channel::GpsTimeS, 25, 0.0),
        (Channel::AccelXMps2, 100, 0.1),
        (Channel::AccelZMps2, 100, -9.8),
        (Channel::GyroXRadps, 100, 0.01),
        (Channel::GyroZRadps, 100, 0.03),
        (Channel::RollRad, 100, std::f32::consts::FRAC_PI_6),
        (Channel::PitchRad, 100, 0.0),
        (Channel::YawRad, 100, 0.0),
        (Channel::Throttle, 100, 0.55),
    ];
    assert_channels(&flight, &expected);
    assert_eq!(doubles(&flight, "latitude_deg")[0], 47.123_456_7);
    // Hectopascals, as in old releases.
    assert_eq!(signal(&flight, "baro_2_pa")[0], 95_100.0);
    for words in [
        "750 messages over 9.9 s; read: actuator_controls_0 (100), sensor_baro (100), sensor_baro 2 (100)",
        "not used: cpuload (100)",
        "repeat the fix before them, taken once: 25",
    ] {
        assert!(said(&notes, words), "{words}: {notes:#?}");
    }
}

#[test]
fn topics_of_newer_and_older_releases_are_known() {
    let mut log = header();
    log.format(
        "sensor_gps",
        "uint64_t timestamp;uint64_t time_utc_usec;double latitude_deg;double longitude_deg;double altitude_msl_m;float vel_n_m_s;\
         float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;",
    );
    log.format("sensor_baro", "uint64_t timestamp;float pressure;float temperature;");
    log.format("vehicle_thrust_setpoint", "uint64_t timestamp;float[3] xyz;");
    log.format(
        "airspeed_validated",
        "uint64_t timestamp;float calibrated_airspeed_m_s;float true_airspeed_m_s;",
    );
    for (id, topic, instance) in [
        (0, "sensor_gps", 0),
        (1, "sensor_gps", 1),
        (2, "sensor_baro", 0),
        (3, "vehicle_thrust_setpoint", 0),
        (4, "airspeed_validated", 0),
    ] {
        log.subscribe(id, topic, instance);
    }
    for k in 0..50 {
        let time_us = 5e6 + f64::from(k) * 2e5;
        // The first receiver has no fix; the second one's velocity is not valid at first.
        log.data(0, &[time_us, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let valid = f64::from(u8::from(k > 9));
        log.data(
            1,
            &[time_us, UTC_US + f64::from(k) * 2e5, 47.123_456_789, 8.5, 512.345, 1.0, 2.0, 0.5, 3.0, valid],
        );
        log.data(2, &[time_us, 95_000.0, 30.0]);
        log.data(3, &[time_us, 0.0, 0.0, -0.6]);
        log.data(4, &[time_us, 20.0, 21.5]);
    }
    let (flight, notes) = import(&log.log);
    assert_eq!(samples(&flight, Channel::GpsAltM), [512.345; 50]);
    assert_eq!(samples(&flight, Channel::GpsVdMps), [0.5; 40]);
    assert_eq!(samples(&flight, Channel::BaroPa)[0], 95_000.0);
    assert_eq!(samples(&flight, Channel::Throttle)[0], 0.6);
    assert_eq!(samples(&flight, Channel::TasMps)[0], 21.5);
    for words in [
        "sensor_gps 1: 0 3D fixes, left out; sensor_gps 2 with 50 is used",
        "tas_mps is airspeed_validated's",
    ] {
        assert!(said(&notes, words), "{words}: {notes:?}");
    }
}

/// The autopilot's choice is the reference, and the data of its two receivers are kept beside it.
#[test]
fn of_several_receivers_each_is_kept_and_how_far_they_are_apart_is_said() {
    let gps = "uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;int32_t alt;float epv;float vel_n_m_s;float \
               vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;uint8_t satellites_used;";
    let log_of = |receivers: u8| {
        let mut log = header();
        log.format("vehicle_gps_position", gps);
        log.format("sensor_gps", gps);
        log.format("sensor_baro", "uint64_t timestamp;float pressure;float temperature;");
        log.subscribe(0, "vehicle_gps_position", 0);
        log.subscribe(9, "sensor_baro", 0);
        for receiver in 0..receivers {
            log.subscribe(1 + u16::from(receiver), "sensor_gps", receiver);
        }
        for k in 0..50 {
            let time_us = 5e6 + f64::from(k) * 2e5;
            let mut fix = |id: u16, later_us: f64, up_mm: f64| {
                let altitude_mm = 500_000.0 + f64::from(k) * 400.0 + up_mm;
                let utc_us = UTC_US + f64::from(k) * 2e5;
                log.data(
                    id,
                    &[
                        time_us + later_us,
                        utc_us,
                        4.7e8,
                        8.5e7,
                        altitude_mm,
                        1.5,
                        1.0,
                        2.0,
                        -2.0,
                        3.0,
                        1.0,
                        12.0,
                    ],
                );
            };
            fix(0, 0.0, 0.0);
            for receiver in 0..receivers {
                // 0.1 s later at 2 m/s.
                fix(1 + u16::from(receiver), 1e5, 200.0 + 2_500.0 * f64::from(receiver));
            }
            log.data(9, &[time_us, 95_000.0, 30.0]);
        }
        log.log
    };
    let (flight, notes) = import(&log_of(2));
    assert_eq!(samples(&flight, Channel::GpsAltM)[..2], [500.0, 500.4]);
    assert_eq!(signal(&flight, "gps_1_alt_m")[..2], [500.2, 500.6]);
    assert_eq!(signal(&flight, "gps_2_alt_m")[..2], [502.7, 503.1]);
    assert_eq!(signal(&flight, "gps_2_vd_mps"), [-2.0; 50]);
    let words = "vehicle_gps_position 1, with 50 3D fixes, is the reference; sensor_gps 2, with 50, is kept as gps_2_alt_m and other \
                 signals gps_2_*: its altitude differs from the other's by +2.5 m in the median, and by +2.5 to +2.5 m in 96 of 100 fixes";
    assert!(said(&notes, words), "{notes:#?}");
    // The flight can be written and read back.
    let mut written = Vec::new();
    flight_data::to_writer(&mut written, &flight).unwrap();
    let (again, remarks) = flight_data::parse(&written).unwrap();
    assert_eq!((signal(&again, "gps_2_alt_m").len(), remarks.len()), (50, 0), "{remarks:?}");
    // A single receiver is the source of the reference.
    let (flight, notes) = import(&log_of(1));
    assert!(
        signal(&flight, "gps_1_alt_m").is_empty() && said(&notes, "sensor_gps 1: 50 3D fixes, left out"),
        "{notes:?}"
    );
}

#[test]
fn a_log_with_any_byte_changed_costs_that_message_and_moves_no_other() {
    let log = copter(3);
    let (first, _) = *log.places.iter().find(|(_, kind)| *kind == b'D').unwrap();
    let message_of = |at| {
        let (start, _) = *log.places.iter().rev().find(|(place, _)| *place <= at).unwrap();
        (start, format!("the message at {start}"))
    };
    assert_any_byte_costs_its_message(&log.log, message_of, first);
}

/// The channels and signals of a flight, with their samples and times.
fn columns(flight: &flight_data::Flight) -> Vec<(String, Vec<(u64, u32)>)> {
    let known = flight.channels.iter().map(|(channel, column)| (channel.name().to_owned(), column));
    let signals = flight.extra.iter().map(|(name, column)| (name.clone(), column));
    known
        .chain(signals)
        .map(|(name, column)| {
            let sample = |(row, value): (usize, f32)| (flight.time_s[row].to_bits(), value.to_bits());
            (name, column.samples().map(sample).collect())
        })
        .collect()
}

/// Definitions have no check of their own: what is lost with one is reported.
#[test]
fn a_flipped_bit_of_a_definition_costs_nothing_without_a_word() {
    let log = copter(1);
    let (clean, said_of_clean) = import(&log.log);
    let clean = columns(&clean);
    let mut lost = 0;
    for (at, kind) in log.places.iter().take_while(|(_, kind)| *kind != b'D') {
        let length = usize::from(u16::from_le_bytes([log.log[*at], log.log[at + 1]]));
        // Any value of a parameter or a text is valid.
        let end = if matches!(kind, b'I' | b'P') { at + 3 } else { at + 3 + length };
        for (byte, bit) in (*at..end).flat_map(|byte| (0..8).map(move |bit| (byte, bit))) {
            let mut bytes = log.log.clone();
            bytes[byte] ^= 1 << bit;
            let Ok((flight, notes)) = crate::import::import(&bytes) else { continue };
            let found = columns(&flight);
            let samples = |columns: &[(String, Vec<_>)]| {
                columns.iter().map(|(_, samples)| samples.len()).sum::<usize>()
            };
            // A changed instance number renames a signal but loses no data.
            let is_renamed = *kind == b'A' && byte == at + 3 && samples(&found) == samples(&clean);
            if found == clean || is_renamed {
                continue;
            }
            lost += 1;
            let added: Vec<&str> = notes
                .iter()
                .map(|note| note.text())
                .filter(|text| !said_of_clean.iter().any(|said| said == text))
                .collect();
            let is_said = added.iter().any(|text| {
                ["left out", "damaged", "not used: the definition", "cannot be read"]
                    .iter()
                    .any(|words| text.contains(words))
            });
            let name = char::from(*kind);
            assert!(is_said, "bit {bit} of byte {} of {name} at {at}: {added:?}", byte - at);
        }
    }
    assert!(lost > 1_000, "{lost}");
}

#[test]
fn a_topic_that_is_lost_with_its_definition_is_named() {
    let log = copter(3);
    let place = |text: &str| memchr::memmem::rfind(&log.log, text.as_bytes()).unwrap();
    let damaged = |at: usize, letter: u8| {
        let mut bytes = log.log.clone();
        bytes[at] = letter;
        import(&bytes).1
    };
    for (at, letter, words) in [
        (
            place("vehicle_air_data:"),
            b'w',
            "whose format the log does not define, left out: the definition is missing or damaged: vehicle_air_data (30)",
        ),
        (
            place("baro_pressure_pa") + 3,
            b'p',
            "vehicle_air_data has no field baro_pressure_pa, but one called barp_pressure_pa",
        ),
        (
            place("vehicle_attitude") - 2,
            99,
            "that the log does not name, left out: its definition is missing or damaged: id 5 (30)",
        ),
        (
            place("timestamp;float[4] q"),
            b'T',
            "vehicle_attitude cannot be read, its definition has no timestamp; messages left out: 30",
        ),
        (
            place("float[4] q") + 6,
            b'3',
            "of another length than their topic's format, left out: one of the two is damaged: vehicle_attitude (30)",
        ),
        (
            place("vehicle_attitude") - 3,
            200,
            "vehicle_attitude 201 cannot be read, its instance is more than any autopilot has",
        ),
    ] {
        let notes = damaged(at, letter);
        assert!(said(&notes, words), "{words}: {notes:#?}");
    }
    // Damage to the receiver's own definition makes the log unusable, and the refusal gives the reason.
    let mut bytes = log.log.clone();
    bytes[place("vehicle_gps_position:")] = b'w';
    let error = crate::import::import(&bytes).unwrap_err().to_string();
    assert!(error.contains("the definition is missing or damaged: vehicle_gps_position (15)"), "{error}");
}

#[test]
fn a_log_cut_anywhere_is_read_up_to_there() {
    let log = copter(3);
    let mut last = 0;
    for length in 0..=log.log.len() {
        let Ok((flight, _)) = crate::import::import(&log.log[..length]) else { continue };
        let found = samples(&flight, Channel::AccelXMps2).len();
        assert!(found >= last, "{length}");
        last = found;
    }
    assert_eq!(last, 30);
    let (_, notes) = import(&log.log[..log.log.len() - 2]);
    assert!(said(&notes, "ends within its last message"), "{notes:?}");
}

#[test]
fn garbage_in_the_middle_is_named_and_costs_nothing_else() {
    let log = copter(10);
    assert_garbage_costs_nothing_else(&log.log, log.places[400].0, &garbage(5_000));
}

#[test]
fn dropouts_and_data_that_were_appended_after_a_crash_are_read_and_said() {
    let mut log = copter(10);
    log.message(b'O', &250_u16.to_le_bytes());
    // What was being written when the autopilot crashed, then a parameter and data of the rescue.
    let cut = log.log.len();
    log.log.extend([200, 0, b'D', 1, 0]);
    let appended = log.log.len();
    log.keyed(b'P', "float RESCUED", &1_f32.to_le_bytes());
    log.data(1, &[15e6, 540.0, 31.5, 94_000.0, 1.1]);
    let flags = log.places[0].0 + 3;
    log.log[flags + 8] = 1;
    log.log[flags + 16..flags + 24].copy_from_slice(&(appended as u64).to_le_bytes());
    let (flight, notes) = import(&log.log);
    assert_eq!(samples(&flight, Channel::BaroPa).last(), Some(&94_000.0));
    assert!(
        said(&notes, "could not keep up 1 times: 0.25 s of data are missing (2.5 %), the first at 9.9 s"),
        "{notes:?}"
    );
    assert!(
        said(&notes, "parameters that were changed while logging; the header has those of the start: 1"),
        "{notes:?}"
    );
    assert!(said(&notes, "before data were appended, left out: 1"), "{cut}: {notes:?}");
    assert!(!said(&notes, "damaged"), "{notes:?}");
}

#[test]
fn what_is_of_no_use_is_refused_with_what_was_read() {
    let mut log = header();
    log.format("vehicle_air_data", "uint64_t timestamp;float baro_pressure_pa;");
    log.subscribe(1, "vehicle_air_data", 0);
    log.data(1, &[5e6, 95_000.0]);
    let error = crate::import::import(&log.log).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "PX4 ULog without a 3D fix of a receiver (1 messages read, 0 of them of a receiver without one)"
        ),
        "{error}"
    );
    for other in [&MAGIC[..3], b"", b"ULog is not this"] {
        assert!(!Ulog.recognises(other));
    }
    assert!(Ulog.import(&MAGIC).is_err());
}

/// Formats within formats, each many times: computing the sizes again at each place took longer than a
/// flight.
#[test]
fn formats_that_name_each_other_many_times_do_not_hang() {
    let mut log = header();
    for level in 0..7_u32 {
        let inner = if level == 0 { "uint8_t".to_owned() } else { format!("level{}", level - 1) };
        let members: String = (0..400).map(|k| format!("{inner} m{k};")).collect();
        log.message(b'F', format!("level{level}:{members}").as_bytes());
    }
    for id in 0..2_000_u16 {
        log.message(b'A', &[&[0][..], &id.to_le_bytes(), b"level6"].concat());
    }
    assert!(Ulog.import(&log.log).is_err());
}
