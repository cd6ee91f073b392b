//! The telemetry of the emulated flight computer, taken from QEMU's USART1 and read by pymavlink: it equals
//! the host's, byte for byte, and every field of every message has the value of the flight and of the host's
//! estimator.
#![allow(clippy::unwrap_used, clippy::panic)]

mod mavlink_client;
mod telemetry_flight;
mod ticks;

use std::collections::BTreeMap;

use kf_core::input::{BaroReading, LaunchDoubt, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::output::{Agreement, Phase, Rejection, Trust};
use kf_core::quality::FailedChecks;
use pylon::fly::Downlinked;
use serde_json::Value;

use flight_computer::Part;
use mavlink_client::{decode, f32_of, gaps, of, texts, whole};
use telemetry_flight::{Tick, fly, tick_of, ticks};
use ticks::TICKS;

/// MAVLink's bits for the sensors.
const INERTIAL_UNIT: i64 = 1 | 2;
const ABSOLUTE_PRESSURE: i64 = 8;
const GPS: i64 = 32;
const AHRS: i64 = 0x20_0000;

#[test]
fn what_leaves_the_usart_is_the_hosts_telemetry_and_pymavlink_reads_every_field_of_it() {
    let (report, Downlinked { target, host }) = fly(None);
    // At the flight's end a few frames were still waiting.
    assert!(host.starts_with(&target), "{} of {} bytes", target.len(), host.len());
    assert!(host.len() - target.len() < 31 * 75, "{} of {} bytes", target.len(), host.len());
    assert_eq!((report.underruns, report.stalls, report.ticks as usize), (0, 0, TICKS));

    let messages = decode(&target);
    assert_eq!(gaps(&messages), 0);
    let (ticks, latch) = ticks();
    let flight = Flight { ticks, latch };
    let mut counts = BTreeMap::new();
    let mut now = 0;
    for message in &messages {
        assert_eq!((whole(message, "system"), whole(message, "component")), (1, 191), "{message}");
        let kind = message["mavpackettype"].as_str().unwrap();
        match kind {
            // Every tick has one, before the messages sent in turn: it dates those without a time of their
            // own.
            "HIGHRES_IMU" => {
                now = tick_of(whole(message, "time_usec"));
                flight.check_imu(message, counts.get(kind).copied().unwrap_or_default());
            }
            "GPS_RAW_INT" => flight.check_fix(message, counts.get(kind).copied().unwrap_or_default()),
            "ATTITUDE" => flight.check_attitude(message),
            "ALTITUDE" => flight.check_altitude(message),
            "HEARTBEAT" => flight.check_heartbeat(message, now),
            "SYS_STATUS" => flight.check_status(message, now),
            "NAMED_VALUE_FLOAT" => flight.check_value(message),
            "STATUSTEXT" => assert_eq!((whole(message, "id"), whole(message, "chunk_seq")), (0, 0)),
            other => panic!("{other}: {message}"),
        }
        *counts.entry(kind.to_owned()).or_insert(0) += 1;
        if let Some(name) = message["name"].as_str() {
            *counts.entry(name.to_owned()).or_insert(0) += 1;
        }
    }
    flight.check_texts(&messages);
    check_rates(&counts, &flight);

    let part = report.parts.iter().find(|part| part.part == Part::Messages).unwrap();
    println!(
        "telemetry: {:.0} instructions a tick, {} at worst; {} bytes in {} messages",
        part.instructions_mean,
        part.instructions_worst,
        target.len(),
        messages.len()
    );
}

/// The rate of each message and each name is as in docs/telemetry.md, over 30 s; the last few may not have
/// been sent.
fn check_rates(counts: &BTreeMap<String, usize>, flight: &Flight) {
    let sent_at = |pick: fn(&TickInput) -> bool| flight.ticks.iter().filter(|tick| pick(&tick.input)).count();
    let fixes = sent_at(|input| input.gps.is_some());
    for (name, least, most) in [
        ("HIGHRES_IMU", TICKS - 10, TICKS),
        ("GPS_RAW_INT", fixes - 1, fixes),
        ("gps_vd", fixes - 1, fixes),
        ("alt_master", 990, sent_at(|input| input.imu_master_altitude_m.is_some())),
        ("alt_slave", 1_490, sent_at(|input| input.imu_slave_altitude_m.is_some())),
        ("ATTITUDE", 595, 601),
        ("ALTITUDE", 295, 301),
        ("tas", 295, 301),
        ("aoa", 295, 301),
        ("sideslip", 295, 301),
        ("throttle", 295, 301),
        ("oat", 29, 30),
        // Once a second, and at once when the phase changes: twice.
        ("HEARTBEAT", 30, 33),
        ("SYS_STATUS", 29, 31),
        ("launch", 29, 32),
    ] {
        let count = counts.get(name).copied().unwrap_or_default();
        assert!((least..=most).contains(&count), "{name}: {count}");
    }
    let of_sensors = |prefix: &str| ["master", "slave", "baro"].map(|sensor| format!("{prefix}_{sensor}"));
    // 600 shared by nine in turn, and 300 by two or three dozen.
    for name in ["e", "tr"].iter().flat_map(|prefix| of_sensors(prefix)) {
        assert!(counts.get(&name).is_some_and(|count| *count > 50), "{name}: {counts:?}");
    }
    let mut slow: Vec<String> =
        ["b", "sb", "sr", "bd"].iter().flat_map(|prefix| of_sensors(prefix)).collect();
    slow.extend(
        ["ma_slave", "ma_baro", "c_0", "sc_0", "s_ref", "i_gps", "checks", "ticks"].map(str::to_owned),
    );
    slow.extend(["hb", "sys", "gps", "att", "imu", "alt", "nvf", "text"].map(|kind| format!("d_{kind}")));
    for name in slow {
        assert!(counts.get(&name).is_some_and(|count| *count >= 3), "{name}: {counts:?}");
    }
}

/// The flight that the messages are compared with.
struct Flight {
    ticks: Vec<Tick>,
    latch: LatchRecord,
}

/// Whether the numbers are equal, or both invalid.
fn same(sent: f32, expected: f32) -> bool {
    sent == expected || (sent.is_nan() && expected.is_nan())
}

fn unknown(message: &Value, fields: &[&str]) {
    for field in fields {
        assert!(f32_of(message, field).is_nan(), "{field}: {message}");
    }
}

fn whole_fields(message: &Value, fields: &[(&str, i64)]) {
    for (field, expected) in fields {
        assert_eq!(whole(message, field), *expected, "{field}: {message}");
    }
}

impl Flight {
    /// The tick at a time in milliseconds.
    fn at_ms(&self, message: &Value) -> &Tick {
        &self.ticks[tick_of(whole(message, "time_boot_ms") * 1_000)]
    }

    fn check_imu(&self, message: &Value, count: usize) {
        let input = &self.ticks[count].input;
        assert_eq!(whole(message, "time_usec") as u64, input.time_us);
        let sample = input.imu.unwrap();
        assert_eq!(["xacc", "yacc", "zacc"].map(|axis| f32_of(message, axis)), sample.accel_mps2);
        assert_eq!(["xgyro", "ygyro", "zgyro"].map(|axis| f32_of(message, axis)), sample.gyro_radps);
        let pressure_pa = match input.baro {
            Some(BaroReading::PressurePa(pressure_pa)) => pressure_pa,
            _ => f32::NAN,
        };
        // Hectopascals and back: one rounding.
        let sent_pa = f32_of(message, "abs_pressure") * 100.0;
        assert!(
            same(sent_pa, pressure_pa) || (sent_pa - pressure_pa).abs() <= pressure_pa * f32::EPSILON,
            "{sent_pa} {pressure_pa}"
        );
        let temperature_c = input.signals.baro_temperature_c;
        assert!(same(f32_of(message, "temperature"), temperature_c.unwrap_or(f32::NAN)), "{message}");
        let bits = 0x3f | i64::from(input.baro.is_some()) << 9 | i64::from(temperature_c.is_some()) << 12;
        whole_fields(message, &[("fields_updated", bits), ("id", 0)]);
        unknown(message, &["xmag", "ymag", "zmag", "diff_pressure", "pressure_alt"]);
    }

    fn check_fix(&self, message: &Value, count: usize) {
        let input = self.ticks.iter().map(|tick| &tick.input).filter(|input| input.gps.is_some()).nth(count);
        let (input, fix) = (input.unwrap(), input.unwrap().gps.unwrap());
        assert_eq!(whole(message, "time_usec") as u64, input.time_us);
        // Near two million millimetres, an f32 has a resolution of an eighth.
        assert!((whole(message, "alt") as f64 - f64::from(fix.altitude_m) * 1e3).abs() <= 0.5 + 0.125);
        let (north, east) = (fix.velocity_north_mps.unwrap(), fix.velocity_east_mps.unwrap());
        assert!((whole(message, "vel") as f32 - north.hypot(east) * 100.0).abs() <= 0.51);
        let course = east.atan2(north).to_degrees().rem_euclid(360.0) * 100.0;
        let off = (whole(message, "cog") as f32 - course).rem_euclid(36_000.0);
        assert!(off.min(36_000.0 - off) <= 0.6, "{message} {course}");
        whole_fields(message, &[("v_acc", 2_500), ("satellites_visible", 11), ("fix_type", 3)]);
        whole_fields(message, &[("lat", i32::MAX.into()), ("lon", i32::MAX.into())]);
        whole_fields(message, &[("eph", 65_535), ("epv", 65_535), ("alt_ellipsoid", 0), ("h_acc", 0)]);
        whole_fields(message, &[("vel_acc", 0), ("hdg_acc", 0), ("yaw", 0)]);
    }

    fn check_attitude(&self, message: &Value) {
        let input = &self.at_ms(message).input;
        let sent = ["roll", "pitch", "yaw"].map(|angle| f32_of(message, angle));
        assert_eq!(Some(sent), input.signals.attitude_rad);
        let rates = ["rollspeed", "pitchspeed", "yawspeed"].map(|rate| f32_of(message, rate));
        assert_eq!(Some(rates), input.imu.map(|imu| imu.gyro_radps));
    }

    fn check_altitude(&self, message: &Value) {
        let now = tick_of(whole(message, "time_usec"));
        let ticks = &self.ticks[..=now];
        let pressure_pa = ticks.iter().rev().find_map(|tick| match tick.input.baro {
            Some(BaroReading::PressurePa(pressure_pa)) => Some(f64::from(pressure_pa)),
            _ => None,
        });
        // The ISA's troposphere.
        let expected_m = 44_330.77 * (1.0 - (pressure_pa.unwrap() / 101_325.0).powf(0.190_263));
        let sent_m = f64::from(f32_of(message, "altitude_monotonic"));
        assert!((sent_m - expected_m).abs() < 0.02, "{sent_m} {expected_m}");

        let fix = ticks.iter().rev().take(401).find_map(|tick| tick.input.gps);
        let expected_m = match (fix, ticks[now].output.phase) {
            (None, _) => f32::NAN,
            (Some(fix), Phase::FreeFlight) => fix.altitude_m,
            (Some(_), _) => ticks[now].output.altitude_m,
        };
        assert!(same(f32_of(message, "altitude_amsl"), expected_m), "{message} {expected_m}");
        unknown(message, &["altitude_local", "altitude_relative"]);
        let fixed = ["altitude_terrain", "bottom_clearance"].map(|field| f32_of(message, field));
        assert_eq!(fixed, [-10_000.0, -1.0]);
    }

    fn check_heartbeat(&self, message: &Value, now: usize) {
        let output = &self.ticks[now].output;
        let is_critical = output.sensors.iter().any(|sensor| sensor.trust == Trust::Untrustworthy);
        let (mode, state) = match output.phase {
            Phase::Settling => (0, 2),
            Phase::Calibrating => (1, 2),
            Phase::FreeFlight => (2, if is_critical { 5 } else { 4 }),
        };
        whole_fields(message, &[("custom_mode", mode), ("system_status", state), ("base_mode", 1)]);
        whole_fields(message, &[("type", 18), ("autopilot", 8), ("mavlink_version", 3)]);
    }

    fn check_status(&self, message: &Value, now: usize) {
        let ticks = &self.ticks[..=now];
        let mut bits = (0, 0);
        let mut source = |bit: i64, rejection: &dyn Fn(&Tick) -> Option<Option<Rejection>>, trust: Trust| {
            let delivered = |(ago, tick): (usize, &Tick)| Some((ago, rejection(tick)?));
            let mut delivered = ticks.iter().rev().enumerate().filter_map(delivered);
            let last = delivered.find(|(_, rejection)| *rejection != Some(Rejection::Held));
            bits.0 |= if last.is_some() { bit } else { 0 };
            // 2.5 s are 500 ticks.
            let is_well = last.is_some_and(|(ago, rejection)| ago <= 500 && rejection.is_none());
            bits.1 |= if is_well && trust != Trust::Untrustworthy { bit } else { 0 };
        };
        let trust = |sensor: usize| ticks[now].output.sensors[sensor].trust;
        source(INERTIAL_UNIT, &|tick| tick.input.imu.map(|_| None), Trust::Trusted);
        source(
            ABSOLUTE_PRESSURE,
            &|tick| tick.input.baro.map(|_| tick.output.sensors[2].rejection),
            trust(2),
        );
        source(GPS, &|tick| tick.input.gps.map(|_| tick.output.gps_rejection), Trust::Trusted);
        let slave = |tick: &Tick| tick.input.imu_slave_altitude_m.map(|_| tick.output.sensors[1].rejection);
        source(AHRS, &slave, trust(1));
        let (present, healthy) = bits;
        for (field, expected) in [("present", present), ("enabled", present), ("health", healthy)] {
            let field = format!("onboard_control_sensors_{field}");
            assert_eq!(whole(message, &field), expected, "{field} at {now}");
            assert_eq!(whole(message, &format!("{field}_extended")), 0);
        }
        // The one reading that was not a number; nothing else was refused.
        let refused = i64::from(now >= 3_002);
        assert_eq!(i64::from(ticks[now].counters.sensors[1].not_finite), refused);
        whole_fields(message, &[("errors_count2", refused), ("errors_count1", 0), ("errors_count3", 0)]);
        whole_fields(message, &[("errors_count4", 0), ("drop_rate_comm", 0), ("errors_comm", 0)]);
        whole_fields(message, &[("load", 65_535), ("voltage_battery", 65_535), ("current_battery", -1)]);
        whole_fields(message, &[("battery_remaining", -1)]);
    }

    /// A named value; its time is the sample's.
    fn check_value(&self, message: &Value) {
        let Tick { input, output, counters } = self.at_ms(message);
        let name = message["name"].as_str().unwrap();
        let (prefix, suffix) = name.split_once('_').unwrap_or((name, ""));
        let sensor = ["master", "slave", "baro"].iter().position(|sensor| *sensor == suffix);
        let latch = (output.phase == Phase::FreeFlight).then_some(&self.latch);
        let expected = match (prefix, sensor) {
            ("alt", Some(0)) => input.imu_master_altitude_m,
            ("alt", Some(1)) => input.imu_slave_altitude_m,
            ("e", Some(k)) => output.sensors[k].error_m,
            ("ma", Some(k)) => output.sensors[k].moving_average_m,
            ("tr", Some(k)) => Some(match output.sensors[k].trust {
                Trust::Calibrating => 0.0,
                Trust::Trusted => 1.0,
                Trust::Doubtful => 2.0,
                Trust::Untrustworthy => 3.0,
                Trust::Unmonitored => 4.0,
            }),
            ("b", Some(k)) => Some(output.sensors[k].bias_m),
            ("sb", Some(k)) => Some(output.sensors[k].bias_variance_m2.sqrt()),
            ("sr", Some(k)) => latch.map(|latch| latch.sensors[k].residual_variance_m2.sqrt()),
            ("bd", Some(k)) => latch.map(|latch| latch.sensors[k].bound_m2.sqrt()),
            ("d", None) => Some(0.0),
            _ => match name {
                "gps_vd" => input.gps.and_then(|fix| fix.velocity_down_mps),
                "tas" => input.signals.true_airspeed_mps,
                "aoa" => input.signals.angle_of_attack_rad,
                "sideslip" => input.signals.sideslip_rad,
                "throttle" => input.signals.throttle,
                "oat" => input.signals.outside_air_temperature_c,
                "launch" => Some(f32::from(u8::from(input.launch))),
                "c_0" => Some(output.coefficients[0].coefficient),
                "sc_0" => Some(output.coefficients[0].variance.sqrt()),
                "s_ref" => Some(output.altitude_variance_m2.sqrt()),
                "i_gps" => output.gps_innovation_m,
                "checks" => latch.map(|latch| latch.failed_checks.into()),
                "ticks" => Some(counters.ticks as f32),
                other => panic!("{other}: {message}"),
            },
        };
        let expected = expected.unwrap_or_else(|| panic!("there is no such value: {message}"));
        assert!(same(f32_of(message, "value"), expected), "{message}: {expected}");
    }

    /// All texts that are sent once, in order, with severity, time and cause.
    fn check_texts(&self, messages: &[Value]) {
        let mut expected = vec![(6, "c_0 is baro.dynamic_pressure".to_owned())];
        let mut trusts = [Trust::Calibrating; 3];
        let (mut doubt, mut agreement) = (LaunchDoubt::None, Agreement::Agree);
        let mut latest = [[f32::NAN; 2]; 3];
        for Tick { input, output, .. } in &self.ticks {
            let at = format!("t={:.3}", input.time_us as f64 / 1e6);
            if std::mem::replace(&mut doubt, input.launch_doubt) != doubt {
                expected.push(match doubt {
                    LaunchDoubt::Suspected => (4, format!("{at} launch suspected, calibration held")),
                    _ => (5, format!("{at} launch not confirmed, calibrating")),
                });
            }
            if output.latched_now {
                let failed = FailedChecks::from_bits(output.failed_checks);
                expected.push(match failed.iter().count() {
                    0 => (5, format!("{at} latched good")),
                    count => (4, format!("{at} latched degraded, {count} checks failed")),
                });
                expected
                    .extend(failed.iter().map(|check| (4, format!("{at} failed check {}", check.name()))));
            }
            for (k, sensor) in output.sensors.iter().enumerate() {
                latest[k][0] = sensor.error_m.unwrap_or(latest[k][0]);
                latest[k][1] = sensor.moving_average_m.unwrap_or(latest[k][1]);
                let was = std::mem::replace(&mut trusts[k], sensor.trust);
                let (name, bound_m) = (["", "imu_slave", "baro"][k], self.latch.sensors[k].bound_m());
                match sensor.trust {
                    trust if k == 0 || trust == was => {}
                    Trust::Doubtful => {
                        expected.push((4, format!("{at} {name} doubtful {:.1}>{bound_m:.1}m", latest[k][0])));
                    }
                    Trust::Untrustworthy => expected
                        .push((3, format!("{at} {name} untrustworthy {:.1}>{bound_m:.1}m", latest[k][1]))),
                    Trust::Unmonitored => {
                        expected.push((4, format!("{at} {name} unmonitored: no reference")));
                    }
                    Trust::Trusted if was == Trust::Unmonitored => {
                        expected.push((5, format!("{at} {name} monitored again")));
                    }
                    Trust::Trusted | Trust::Calibrating => {}
                }
            }
            if let Some(check) = output.cross_check
                && std::mem::replace(&mut agreement, check.agreement) != check.agreement
            {
                let bound_m = (self.latch.sensors[1].bound_m2 + self.latch.sensors[2].bound_m2).sqrt();
                let (severity, value_m) = match check.agreement {
                    Agreement::Disagree => (3, check.moving_average_m),
                    _ => (4, check.difference_m),
                };
                let word = check.agreement.name();
                expected.push((severity, format!("{at} baro-imu_slave {word} {value_m:.1}>{bound_m:.1}m")));
            }
        }
        let severities = of(messages, "STATUSTEXT").into_iter().map(|message| whole(message, "severity"));
        let said: Vec<(i64, String)> = severities.zip(texts(messages)).collect();
        assert_eq!(said, expected);
        // None of the texts that the flight was made for may be missing.
        for word in [
            "suspected",
            "not confirmed",
            "latched",
            "failed",
            "baro doubtful",
            "baro untrustworthy",
            "imu_slave unmonitored",
            "imu_slave monitored again",
            "baro-imu_slave doubtful",
            "baro-imu_slave disagree",
        ] {
            assert!(said.iter().any(|(_, text)| text.contains(word)), "{word}");
        }
    }
}
