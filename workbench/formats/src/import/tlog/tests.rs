use mavlink::dialects::common::*;
use mavlink::{MAVLinkV1MessageRaw, MAVLinkV2MessageRaw, MavHeader};
use telemetry::Frame;

use super::*;
use flight_data::Channel;

/// How far the receiver's clock is ahead of the sender's.
const AHEAD_US: u64 = 1_700_000_000_000_000;
const PYLON: Sender = (1, telemetry::COMPONENT_ID);

fn stamped(recorded_us: u64, frame: &[u8]) -> Vec<u8> {
    [&recorded_us.to_be_bytes()[..], frame].concat()
}

fn v2(recorded_us: u64, (system, component): Sender, message: &MavMessage) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message(
        MavHeader { system_id: system as _, component_id: component, sequence: 0 },
        message,
    );
    let len = 12 + usize::from(raw.payload_length());
    stamped(recorded_us, &raw.as_slice()[..len])
}

fn v1(recorded_us: u64, (system, component): Sender, message: &MavMessage) -> Vec<u8> {
    let mut raw = MAVLinkV1MessageRaw::new();
    raw.serialize_message(
        MavHeader { system_id: system as _, component_id: component, sequence: 0 },
        message,
    );
    let len = 8 + usize::from(raw.payload_length());
    stamped(recorded_us, &raw.as_slice()[..len])
}

fn fix(time_us: u64, altitude_mm: i32) -> MavMessage {
    MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
        time_usec: time_us,
        alt: altitude_mm,
        vel: 5_000,
        // North-east by east: cosine 0.6, sine 0.8.
        cog: 5_313,
        fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
        satellites_visible: 12,
        v_acc: 2_250,
        lat: 471_234_567,
        lon: 82_345_678,
        ..GPS_RAW_INT_DATA::default()
    })
}

fn pressure(time_us: u64, hpa: f32) -> MavMessage {
    MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
        time_usec: time_us,
        xacc: 0.25,
        yacc: -0.5,
        zacc: -9.75,
        xgyro: 0.125,
        ygyro: 0.0,
        zgyro: -0.25,
        abs_pressure: hpa,
        temperature: 21.5,
        fields_updated: HighresImuUpdatedFlags::from_bits_retain(0x123f),
        ..HIGHRES_IMU_DATA::default()
    })
}

fn value(time_ms: u32, name: &str, value: f32) -> MavMessage {
    MavMessage::NAMED_VALUE_FLOAT(NAMED_VALUE_FLOAT_DATA { time_boot_ms: time_ms, value, name: name.into() })
}

/// Found by fuzzing: a flight of some hundred thousand years, which a file cannot hold.
#[test]
fn stamps_that_are_ages_apart_are_one_flight_and_what_was_left_out() {
    let far_us = 3_000_000_000_000_000_000;
    // Times since 1970 are a receiver's, and give no information on the sender's clock.
    let at = |stamp_us: u64| v2(stamp_us, PYLON, &fix(AHEAD_US, 500_000));
    let stamps = [AHEAD_US, AHEAD_US + 1_000_000, far_us, far_us + 1_000_000];
    let log: Vec<u8> = stamps.iter().flat_map(|stamp| at(*stamp)).collect();
    let (flight, notes) = Tlog.import(&log).unwrap();
    assert_eq!(flight.time_s, [0.0, 1.0]);
    assert!(notes.iter().any(|note| note.text().contains("left out: 2 of 4")), "{notes:?}");
    flight_data::to_writer(&mut Vec::new(), &flight).unwrap();
}

/// A fix and a pressure a second.
fn seconds(count: u64) -> Vec<u8> {
    (0..count)
        .flat_map(|k| {
            let at_us = 5_000_000 + k * 1_000_000;
            [
                v2(AHEAD_US + at_us + 20_000, PYLON, &fix(at_us, 1_000_000 + k as i32)),
                v2(AHEAD_US + at_us + 21_000, PYLON, &pressure(at_us, 900.0)),
            ]
            .concat()
        })
        .collect()
}

fn import(log: &[u8]) -> (Flight, Vec<String>) {
    assert!(Tlog.recognises(log));
    let (flight, notes) = Tlog.import(log).unwrap();
    (flight, notes.iter().map(|note| note.text().to_owned()).collect())
}

fn samples(flight: &Flight, channel: Channel) -> Vec<(f64, f32)> {
    let column = flight.channel(channel).unwrap_or_else(|| panic!("no {}", channel.name()));
    column.samples().map(|(row, sample)| (flight.time_s[row], sample)).collect()
}

/// A capture of a serial line: the same flight without the receiver's times.
#[test]
fn a_stream_without_receivers_times_is_the_same_flight() {
    let log: Vec<u8> = (0..60_u64)
        .flat_map(|k| {
            let at_us = 5_000_000 + k * 1_000_000;
            let attitude = MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms: (at_us / 1_000) as u32,
                roll: 0.25,
                ..ATTITUDE_DATA::default()
            });
            let hud = MavMessage::VFR_HUD(VFR_HUD_DATA { airspeed: 20.0, ..VFR_HUD_DATA::default() });
            [attitude, fix(at_us, 1_000_000 + k as i32), pressure(at_us, 900.0), hud]
                .map(|message| v2(AHEAD_US + at_us, PYLON, &message))
        })
        .flatten()
        .collect();
    let (stamped, _) = import(&log);
    let mut raw = Vec::new();
    let mut packets = frame::Packets::new(&log, frame::STAMP);
    let mut at = 0;
    while packets.next().is_some() {
        let len = 12 + usize::from(log[at + 9]);
        raw.extend(&log[at + 8..at + 8 + len]);
        at += 8 + len;
    }
    let (flight, notes) = import(&raw);
    assert_eq!(flight.time_s, stamped.time_s);
    for channel in [Channel::GpsAltM, Channel::BaroPa, Channel::RollRad, Channel::TasMps] {
        assert_eq!(samples(&flight, channel), samples(&stamped, channel), "{}", channel.name());
    }
    assert!(!flight.header.other.iter().any(|(key, _)| key == "start_utc"));
    assert!(notes.iter().any(|note| note.starts_with("a stream without receiver's times")), "{notes:?}");
    // Garbage between its frames is reported with its place.
    raw.splice(1_000..1_000, [7; 100]);
    let (_, notes) = import(&raw);
    assert!(
        notes
            .iter()
            .any(|note| note.starts_with("damaged: ") && note.contains("are not frames, the first at byte ")),
        "{notes:?}"
    );
}

#[test]
fn a_second_receiver_is_kept_and_compared() {
    let mut log = seconds(20);
    for k in 0..20 {
        let at_us = 5_000_000 + k * 1_000_000;
        let message = MavMessage::GPS2_RAW(GPS2_RAW_DATA {
            time_usec: at_us,
            alt: 1_003_000 + k as i32,
            fix_type: if k == 0 { GpsFixType::GPS_FIX_TYPE_2D_FIX } else { GpsFixType::GPS_FIX_TYPE_3D_FIX },
            vel: u16::MAX,
            satellites_visible: 7,
            ..GPS2_RAW_DATA::default()
        });
        log.extend(v2(AHEAD_US + at_us + 22_000, PYLON, &message));
    }
    let (flight, notes) = import(&log);
    assert_eq!(samples(&flight, Channel::GpsAltM).len(), 20);
    let second = flight.extra.iter().find(|(name, _)| name == "gps_2_alt_m").unwrap();
    assert_eq!(second.1.samples().next(), Some((1, 1_003.001)));
    assert!(
        notes.iter().any(|note| note.contains("GPS2_RAW, with 19, is kept as gps_2_alt_m")
            && note.contains("differs from the other's by +3.0 m in the median")),
        "{notes:?}"
    );
}

#[test]
fn every_signal_of_a_pylon_arrives_with_its_unit_and_time() {
    let at_us = 7_005_300;
    let mut log = seconds(3);
    for (name, number) in [
        ("alt_master", 1_001.5),
        ("alt_slave", 990.25),
        ("gps_vd", -1.5),
        ("tas", 31.5),
        ("aoa", 0.0625),
        ("sideslip", -0.03125),
        ("throttle", 0.75),
        ("oat", -4.5),
        ("launch", 0.0),
        ("e_baro", 3.0),
    ] {
        log.extend(v2(AHEAD_US + at_us + 30_000, PYLON, &value(7_005, name, number)));
    }
    log.extend(v2(AHEAD_US + at_us + 30_000, PYLON, &pressure(at_us, 899.5)));
    let attitude =
        ATTITUDE_DATA { time_boot_ms: 7_005, roll: 0.5, pitch: -0.25, yaw: 3.0, ..ATTITUDE_DATA::default() };
    log.extend(v2(AHEAD_US + at_us + 30_000, PYLON, &MavMessage::ATTITUDE(attitude)));
    log.extend(v2(AHEAD_US + 8_000_000, PYLON, &value(8_000, "launch", 1.0)));
    let (flight, notes) = import(&log);

    // Milliseconds join the row of their tick: 5, 6, 7, 7.0053 and 8 s.
    assert_eq!(flight.time_s, [0.0, 1.0, 2.0, 2.0053, 3.0]);
    for (channel, expected) in [
        (Channel::ImuMasterAltM, 1_001.5),
        (Channel::ImuSlaveAltM, 990.25),
        (Channel::GpsVdMps, -1.5),
        (Channel::TasMps, 31.5),
        (Channel::AoaRad, 0.0625),
        (Channel::SideslipRad, -0.03125),
        (Channel::Throttle, 0.75),
        (Channel::OatC, -4.5),
        (Channel::RollRad, 0.5),
        (Channel::PitchRad, -0.25),
        (Channel::YawRad, 3.0),
    ] {
        assert_eq!(samples(&flight, channel), [(2.0053, expected)], "{}", channel.name());
    }
    for (channel, expected) in [
        (Channel::AccelXMps2, 0.25),
        (Channel::AccelYMps2, -0.5),
        (Channel::AccelZMps2, -9.75),
        (Channel::GyroXRadps, 0.125),
        (Channel::GyroYRadps, 0.0),
        (Channel::GyroZRadps, -0.25),
        (Channel::BaroTempC, 21.5),
    ] {
        let found = samples(&flight, channel);
        assert!(
            found.len() == 4 && found.iter().all(|(_, sample)| *sample == expected),
            "{}",
            channel.name()
        );
    }
    assert_eq!(samples(&flight, Channel::BaroPa)[3], (2.0053, 89_950.0));
    assert_eq!(samples(&flight, Channel::GpsAltM), [(0.0, 1_000.0), (1.0, 1_000.001), (2.0, 1_000.002)]);
    for (channel, expected) in [
        (Channel::GpsVnMps, 30.0),
        (Channel::GpsVeMps, 40.0),
        (Channel::GpsSats, 12.0),
        (Channel::GpsVaccM, 2.25),
    ] {
        let found = samples(&flight, channel);
        assert!(
            found.iter().all(|(_, sample)| (sample - expected).abs() < 0.005),
            "{}: {found:?}",
            channel.name()
        );
    }
    assert_eq!(samples(&flight, Channel::GpsTimeS), [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]);
    assert_eq!(samples(&flight, Channel::Launch), [(2.0053, 0.0), (3.0, 1.0)]);
    let latitude = &flight.extra.iter().find(|(name, _)| name == "latitude_deg").unwrap().1;
    assert!((latitude.get(0).unwrap() - 47.123_46).abs() < 1e-5);
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].contains("estimated itself") && notes[0].ends_with(": 1"), "{notes:?}");
}

#[test]
fn what_a_pylon_does_not_know_is_not_there() {
    let unknown = GPS_RAW_INT_DATA {
        time_usec: 1_000_000,
        alt: -3_500,
        lat: i32::MAX,
        lon: i32::MAX,
        vel: u16::MAX,
        cog: u16::MAX,
        satellites_visible: u8::MAX,
        fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
        ..GPS_RAW_INT_DATA::default()
    };
    let frame = Frame::new(&unknown, 0);
    let (flight, _) = import(&stamped(AHEAD_US, frame.bytes()));
    let known: Vec<Channel> = flight.channels.iter().map(|(channel, _)| *channel).collect();
    assert_eq!(known, [Channel::GpsAltM, Channel::GpsTimeS]);
    assert_eq!(samples(&flight, Channel::GpsAltM), [(0.0, -3.5)]);
    assert!(flight.extra.is_empty());
}

#[test]
fn another_autopilots_log_gives_what_it_has_and_says_what_that_is_worth() {
    let autopilot = (7, 1);
    let mut log = Vec::new();
    for k in 0..4_u64 {
        let at_us = 60_000_000 + k * 500_000;
        let recorded_us = AHEAD_US + at_us + 30_000;
        let at_ms = (at_us / 1_000) as u32;
        // Its receiver gives the time since 1970.
        let mut send = |message: &MavMessage| log.extend(v1(recorded_us, autopilot, message));
        send(&fix(1_699_999_999_000_000 + k * 500_000, 500_000));
        send(&MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: at_ms,
            vz: -150,
            ..GLOBAL_POSITION_INT_DATA::default()
        }));
        send(&MavMessage::SCALED_PRESSURE(SCALED_PRESSURE_DATA {
            time_boot_ms: at_ms,
            press_abs: 955.0,
            temperature: 2_150,
            ..SCALED_PRESSURE_DATA::default()
        }));
        send(&MavMessage::VFR_HUD(VFR_HUD_DATA { airspeed: 30.0, throttle: 55, ..VFR_HUD_DATA::default() }));
        send(&MavMessage::SCALED_IMU(SCALED_IMU_DATA {
            time_boot_ms: at_ms,
            zacc: -1_000,
            xgyro: 250,
            ..SCALED_IMU_DATA::default()
        }));
        // A ground station that is also in the log.
        log.extend(v2(recorded_us, (255, 190), &MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())));
    }
    let (flight, notes) = import(&log);
    assert_eq!(flight.header.vehicle, "MAVLink system 7, component 1");
    assert!(flight.header.other.contains(&("start_utc".to_owned(), "2023-11-14T22:14:20Z".to_owned())));
    let near = |channel: Channel, expected: f32| {
        let found = samples(&flight, channel);
        assert_eq!(found.len(), 4, "{}", channel.name());
        assert!(
            found.iter().all(|(_, sample)| (sample - expected).abs() < 1e-3),
            "{}: {found:?}",
            channel.name()
        );
    };
    near(Channel::GpsAltM, 500.0);
    near(Channel::GpsVdMps, -1.5);
    near(Channel::BaroPa, 95_500.0);
    near(Channel::BaroTempC, 21.5);
    near(Channel::Throttle, 0.55);
    near(Channel::AccelZMps2, -9.806_65);
    near(Channel::GyroXRadps, 0.25);
    // Density at 955 hPa in the standard atmosphere is 1.1678 kg/m^3, of 1.225 at sea level.
    let airspeeds = samples(&flight, Channel::TasMps);
    assert!(
        airspeeds.iter().all(|(_, mps)| (mps - 30.0 * (1.225_f32 / 1.167_8).sqrt()).abs() < 0.01),
        "{airspeeds:?}"
    );
    assert!((flight.time_s.last().unwrap() - 1.5).abs() < 0.031, "{:?}", flight.time_s);
    for word in
        ["other senders, left out: 4", "velocity down: the autopilot's estimate", "taken as calibrated"]
    {
        assert!(notes.iter().any(|note| note.contains(word)), "{word}: {notes:?}");
    }
}

#[test]
fn an_autopilots_own_altitude_is_a_reference_only_where_there_is_no_other() {
    let global = |k: u32| {
        MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: 1_000 + k * 200,
            alt: 123_456,
            vx: 1_000,
            vy: -500,
            vz: 25,
            ..GLOBAL_POSITION_INT_DATA::default()
        })
    };
    let log: Vec<u8> =
        (0..5).flat_map(|k| v2(AHEAD_US + u64::from(k) * 200_000, (1, 1), &global(k))).collect();
    let (flight, notes) = import(&log);
    assert_eq!(samples(&flight, Channel::GpsAltM)[0], (0.0, 123.456));
    assert_eq!(samples(&flight, Channel::GpsVnMps)[4].1, 10.0);
    assert_eq!(samples(&flight, Channel::GpsVdMps)[4].1, 0.25);
    assert!(notes.iter().any(|note| note.contains("not an independent reference")), "{notes:?}");
}

#[test]
fn garbage_damage_and_a_cut_end_are_counted_and_cost_nothing_else() {
    let whole = seconds(10);
    let clean = import(&whole).0;
    // Garbage with both markers before the first frame.
    let mut log = [&[0xfd; 5][..], &[0xfe, 3, 9, 0xfd, 0]].concat();
    log.extend(&whole);
    // One byte of the second fix's altitude, and the last frame without its end.
    let second_fix = log.windows(4).position(|bytes| bytes == 1_000_001_i32.to_le_bytes()).unwrap();
    log[second_fix] ^= 4;
    log.truncate(log.len() - 7);
    // A message of another dialect, and a signed frame.
    let mut unknown = stamped(AHEAD_US + 5_010_000, &[0xfd, 2, 0, 0, 0, 1, 1, 0x39, 0x30, 0, 1, 2, 3, 4]);
    let mut signed = v2(AHEAD_US + 5_010_000, PYLON, &pressure(5_500_000, 890.0));
    signed[8 + 2] = 1;
    let crc_at = signed.len() - 2;
    let crc = mavlink::calculate_crc(&signed[9..crc_at], 93).to_le_bytes();
    signed[crc_at..].copy_from_slice(&crc);
    signed.extend([0xab; 13]);
    unknown.extend(signed);
    let at = 10;
    log.splice(at..at, unknown);

    let (flight, notes) = import(&log);
    let pressures = samples(&flight, Channel::BaroPa);
    // Ten complete ones and the signed one, less the cut one.
    assert_eq!(pressures.len(), 10);
    assert!(pressures.contains(&(0.5, 89_000.0)), "{pressures:?}");
    let altitudes = samples(&flight, Channel::GpsAltM);
    let mut expected = samples(&clean, Channel::GpsAltM);
    expected.remove(1);
    assert_eq!(altitudes, expected);
    let garbage = format!("damaged: 10 of the file's {} bytes (", log.len());
    let is_said =
        |note: &String| note.starts_with(&garbage) && note.contains("are not frames, the first at byte 0;");
    assert!(notes.iter().any(is_said), "{notes:?}");
    for (word, count) in [("CRC is wrong", 1), ("common set", 1)] {
        let note =
            notes.iter().find(|note| note.contains(word)).unwrap_or_else(|| panic!("{word}: {notes:?}"));
        assert!(note.ends_with(&format!(": {count}")), "{note}");
    }
    assert!(notes.contains(&"the last frame is cut off".to_owned()), "{notes:?}");
}

#[test]
fn recorders_times_that_go_back_and_a_restarted_sender_are_said() {
    let mut log = seconds(3);
    // A frame that came 0.3 s late is accepted; its own time is in order.
    log.extend(v2(AHEAD_US + 7_400_000, PYLON, &value(7_200, "tas", 30.0)));
    log.extend(v2(AHEAD_US + 7_100_000, PYLON, &value(7_080, "tas", 31.0)));
    let (flight, notes) = import(&log);
    assert!(
        notes.iter().any(|note| note.contains("before the one before") && note.ends_with(": 1")),
        "{notes:?}"
    );
    assert!(flight.time_s.is_sorted());
    assert_eq!(samples(&flight, Channel::TasMps), [(2.08, 31.0), (2.2, 30.0)]);

    let mut log = Vec::new();
    for k in 0..20_u64 {
        // After five seconds it restarts.
        let boot_us = if k < 5 { 50_000_000 + k * 1_000_000 } else { 1_000_000 + k * 1_000_000 };
        let recorded_us = AHEAD_US + 50_000_000 + k * 1_000_000;
        log.extend(v2(recorded_us, PYLON, &fix(boot_us, 1_000_000)));
        log.extend(v2(recorded_us, PYLON, &pressure(boot_us, 900.0)));
        log.extend(v2(recorded_us, PYLON, &value((boot_us / 1_000) as u32, "tas", 30.0)));
    }
    let (flight, notes) = import(&log);
    assert!(
        notes.iter().any(|note| note.contains("starts of the sender's clock") && note.ends_with(": 1")),
        "{notes:?}"
    );
    assert_eq!((flight.time_s.first(), flight.time_s.last()), (Some(&0.0), Some(&14.0)));
}

#[test]
fn a_log_of_no_use_is_refused_with_what_was_read() {
    let heartbeat = MavMessage::HEARTBEAT(HEARTBEAT_DATA::default());
    let log: Vec<u8> = (0..5).flat_map(|k| v2(AHEAD_US + k, (1, 1), &heartbeat)).collect();
    assert!(Tlog.recognises(&log));
    let error = Tlog.import(&log).unwrap_err();
    assert_eq!(
        error.to_string(),
        "MAVLink tlog without a 3D fix (5 messages read, 0 damaged), expected GPS_RAW_INT or GLOBAL_POSITION_INT"
    );
    for other in [
        &b""[..],
        b"time_s,gps_alt_m,baro_pa\n0,1,2\n",
        &[0xfd; 4_000],
        b"B1101355206343N00006198WA0058700558\r\n",
    ] {
        assert!(!Tlog.recognises(other));
    }
}

#[test]
fn launch_is_by_the_heartbeat_where_no_value_says_it() {
    let mode = |custom_mode| {
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode,
            mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            ..HEARTBEAT_DATA::default()
        })
    };
    let mut log = seconds(4);
    log.extend(v2(AHEAD_US + 8_520_000, PYLON, &mode(1)));
    // The same number in an autopilot's message is a mode of its own.
    log.extend(v2(AHEAD_US + 9_020_000, (1, 1), &mode(2)));
    log.extend(v2(AHEAD_US + 9_520_000, PYLON, &mode(2)));
    let (flight, notes) = import(&log);
    assert_eq!(samples(&flight, Channel::Launch), [(3.5, 0.0), (4.5, 1.0)]);
    assert!(notes.iter().any(|note| note.contains("up to a second late")), "{notes:?}");
}

/// A fix, a pressure and a value without a time of its own each second; and where each frame begins.
fn with_hud(count: u64) -> (Vec<u8>, Vec<usize>) {
    let (mut log, mut places) = (Vec::new(), Vec::new());
    for k in 0..count {
        let at_us = 5_000_000 + k * 1_000_000;
        let hud = MavMessage::VFR_HUD(VFR_HUD_DATA { throttle: k as u16, ..VFR_HUD_DATA::default() });
        for (late_us, message) in
            [(20_000, fix(at_us, 1_000_000)), (21_000, pressure(at_us, 900.0)), (520_000, hud)]
        {
            places.push(log.len());
            log.extend(v2(AHEAD_US + at_us + late_us, PYLON, &message));
        }
    }
    (log, places)
}

#[test]
fn a_flipped_bit_of_a_receivers_time_moves_nothing_but_its_own_frame() {
    let (log, places) = with_hud(40);
    let clean = import(&log).0;
    let all = samples(&clean, Channel::Throttle);
    for (frame, place) in places.iter().enumerate() {
        for bit in 0..64 {
            let mut log = log.clone();
            log[place + 7 - bit / 8] ^= 1 << (bit % 8);
            let (flight, notes) = import(&log);
            let what = format!("bit {bit} of frame {frame}: {notes:?}");
            let (first, last) = (flight.time_s[0], flight.time_s[flight.rows() - 1]);
            assert!(first == 0.0 && last <= clean.time_s[clean.rows() - 1] + 5.0, "{what}");
            // The others keep their intervals.
            let own = (frame % 3 == 2).then_some((frame / 3) as f32 / 100.0);
            let others = |samples: &[(f64, f32)]| -> Vec<(f64, f32)> {
                samples.iter().copied().filter(|(_, value)| Some(*value) != own).collect()
            };
            let (found, expected) = (others(&samples(&flight, Channel::Throttle)), others(&all));
            assert_eq!(found.len(), expected.len(), "{what}");
            let shift = found[0].0 - expected[0].0;
            assert!(
                found.iter().zip(&expected).all(|(one, other)| (one.0 - other.0 - shift).abs() < 1e-6),
                "{what}"
            );
            // A frame at an end may be the first row, some seconds off.
            assert!(shift.abs() <= 5.0 && (shift == 0.0 || !(6..114).contains(&frame)), "{shift} {what}");
        }
    }
}

#[test]
fn a_wrong_receivers_time_is_said_in_words() {
    let (log, places) = with_hud(40);
    let with = |frame: usize, stamp: u64| {
        let mut log = log.clone();
        log[places[frame]..places[frame] + 8].copy_from_slice(&stamp.to_be_bytes());
        import(&log).1
    };
    // 2283 years of 365.2425 days after 1970, and half of one.
    let notes = with(60, (2_283 * 31_556_952 + 15_000_000) * 1_000_000);
    assert!(
        notes.iter().any(|note| note == "frame 61: the receiver's time is in the year 4253; frame left out"),
        "{notes:?}"
    );
    let notes = with(62, AHEAD_US + 25_520_000 - 24_000_000);
    let words = "frame 63: the receiver's time is 24.5 s before that of the frames around it; frame left out";
    assert!(notes.iter().any(|note| note == words), "{notes:?}");
}
