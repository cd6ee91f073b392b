//! Every message, decoded field by field by the `mavlink` crate from the bytes of the queue.

#![allow(clippy::unwrap_used, clippy::panic)]

use heapless::spsc::Consumer;
use kf_core::config::MAX_ESTIMATED_EFFECTS;
use kf_core::effect::EffectId;
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, Signals, TickInput};
use kf_core::latch::{LatchRecord, SensorLatch};
use kf_core::mission::{Counters, SourceCounters};
use kf_core::output::{
    Agreement, CoefficientOutput, CrossCheckOutput, Phase, Rejection, SensorOutput, TickOutput, Trust,
};
use mavlink::dialects::common::*;
use mavlink::{MAVLinkV2MessageRaw, MavlinkVersion, Message};
use survival::{Cause, Refusal, RestartReport, Start};
use telemetry::{ComputerStatus, Frame, FrameQueue, Link, Rates, Telemetry, TickReport};

/// A tick with every input present.
fn input(time_us: u64) -> TickInput {
    TickInput {
        time_us,
        launch: false,
        launch_doubt: LaunchDoubt::None,
        gps: Some(GpsFix {
            altitude_m: 1_234.567,
            velocity_north_mps: Some(-30.0),
            velocity_east_mps: Some(-40.0),
            velocity_down_mps: Some(1.25),
            vertical_accuracy_m: Some(2.5),
            satellites: Some(11),
            fix_time_us: None,
        }),
        baro: Some(BaroReading::PressurePa(87_654.32)),
        imu_master_altitude_m: Some(1_230.5),
        imu_slave_altitude_m: Some(1_220.25),
        imu: Some(ImuSample { accel_mps2: [0.1, -0.2, -9.8], gyro_radps: [0.01, 0.02, -0.03] }),
        signals: Signals {
            true_airspeed_mps: Some(28.5),
            angle_of_attack_rad: Some(0.07),
            sideslip_rad: Some(-0.02),
            throttle: Some(0.6),
            outside_air_temperature_c: Some(-4.5),
            baro_temperature_c: Some(21.25),
            attitude_rad: Some([0.1, 0.2, -3.0]),
        },
        ..TickInput::default()
    }
}

fn sensor(bias_m: f32) -> SensorOutput {
    SensorOutput {
        bias_m,
        bias_variance_m2: 0.25,
        innovation_m: Some(0.5),
        signed_nis: Some(0.1),
        error_m: Some(bias_m / 10.0),
        moving_average_m: None,
        trust: Trust::Calibrating,
        rejection: None,
    }
}

fn output(time_us: u64) -> TickOutput {
    let mut coefficients = heapless::Vec::new();
    coefficients.push(CoefficientOutput { coefficient: 0.06, variance: 0.0004 }).unwrap();
    TickOutput {
        time_us,
        out_of_order: false,
        phase: Phase::Calibrating,
        latched_now: false,
        failed_checks: 0,
        altitude_m: 1_234.0,
        altitude_variance_m2: 0.09,
        gps_innovation_m: Some(0.75),
        gps_signed_nis: Some(0.2),
        gps_rejection: None,
        sensors: [sensor(2.0), sensor(-7.5), sensor(14.0)],
        extrapolated: 0,
        cross_check: None,
        bridged_us: None,
        coefficients,
    }
}

fn latch() -> LatchRecord {
    let of = |bound_m2| SensorLatch { bound_m2, residual_variance_m2: 4.0, ..SensorLatch::default() };
    LatchRecord {
        time_us: 0,
        duration_s: 60.0,
        failed_checks: 0b101,
        sensors: [of(0.0), of(2.25), of(9.0)],
        state: heapless::Vec::new(),
        covariance: heapless::Vec::new(),
    }
}

/// Sequence number and message.
type Decoded = (u8, MavMessage);

struct Flight<'a> {
    telemetry: Telemetry<'a>,
    line: Consumer<'a, Frame>,
    counters: Counters,
    latch: Option<LatchRecord>,
    computer: ComputerStatus,
    decoded: Vec<Decoded>,
}

impl<'a> Flight<'a> {
    fn new(queue: &'a mut FrameQueue, rates: Rates, effects: &[EffectId]) -> Self {
        let (frames, line) = queue.split();
        Self {
            telemetry: Telemetry::new(Link::new(frames), rates, effects),
            line,
            counters: Counters::default(),
            latch: None,
            computer: ComputerStatus::default(),
            decoded: Vec::new(),
        }
    }

    fn tick(&mut self, input: &TickInput, output: &TickOutput) {
        let report = TickReport { input, output, latch: self.latch.as_ref(), counters: &self.counters };
        self.telemetry.tick(&report, &self.computer);
    }

    fn drain(&mut self, at_most: usize) {
        for _ in 0..at_most {
            let Some(frame) = self.line.dequeue() else { return };
            self.decoded.push(decode(frame.bytes()));
        }
    }

    /// The messages that `pick` selects.
    fn all<T>(&self, pick: impl Fn(&MavMessage) -> Option<T>) -> Vec<T> {
        self.decoded.iter().filter_map(|(_, message)| pick(message)).collect()
    }

    fn named(&self, name: &str) -> Vec<(u32, f32)> {
        self.all(|message| match message {
            MavMessage::NAMED_VALUE_FLOAT(value) if value.name.to_str() == Ok(name) => {
                Some((value.time_boot_ms, value.value))
            }
            _ => None,
        })
    }

    fn texts(&self) -> Vec<(MavSeverity, String)> {
        self.all(|message| match message {
            MavMessage::STATUSTEXT(text) => Some((text.severity, text.text.to_str().unwrap().to_owned())),
            _ => None,
        })
    }
}

/// Checks marker, header, length and CRC as a receiver does.
fn decode(bytes: &[u8]) -> (u8, MavMessage) {
    let mut buffer = [0; 283];
    buffer[..bytes.len()].copy_from_slice(bytes);
    let raw = MAVLinkV2MessageRaw::from_bytes_unparsed(buffer);
    assert_eq!(bytes[0], 0xfd);
    assert_eq!(bytes.len(), 12 + usize::from(raw.payload_length()));
    assert_eq!((raw.incompatibility_flags(), raw.compatibility_flags()), (0, 0));
    assert_eq!((raw.system_id(), raw.component_id()), (1, 191));
    assert!(raw.has_valid_crc::<MavMessage>(), "{bytes:02x?}");
    (raw.sequence(), MavMessage::parse(MavlinkVersion::V2, raw.message_id(), raw.payload()).unwrap())
}

/// A second of ticks at 200 Hz from that time on.
fn second(flight: &mut Flight<'_>, from_us: u64, change: impl Fn(&mut TickInput, &mut TickOutput)) {
    for tick in 0..200 {
        let time_us = from_us + tick * 5_000;
        let (mut input, mut output) = (input(time_us), output(time_us));
        change(&mut input, &mut output);
        flight.tick(&input, &output);
        flight.drain(usize::MAX);
    }
}

const START_US: u64 = 7_000_000;

#[test]
fn every_field_of_the_samples_is_as_documented() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    second(&mut flight, START_US, |_, _| ());

    let imu = flight.all(|message| match message {
        MavMessage::HIGHRES_IMU(imu) => Some(imu.clone()),
        _ => None,
    });
    assert_eq!(imu.len(), 200);
    let first = &imu[0];
    assert_eq!(first.time_usec, START_US);
    assert_eq!([first.xacc, first.yacc, first.zacc], [0.1, -0.2, -9.8]);
    assert_eq!([first.xgyro, first.ygyro, first.zgyro], [0.01, 0.02, -0.03]);
    assert_eq!((first.abs_pressure, first.temperature, first.id), (876.543_2, 21.25, 0));
    let unknown = [first.xmag, first.ymag, first.zmag, first.diff_pressure, first.pressure_alt];
    assert!(unknown.iter().all(|value| value.is_nan()));
    assert_eq!(first.fields_updated.bits(), 0b1_0010_0011_1111);
    assert_eq!(imu[199].time_usec, START_US + 199 * 5_000);

    let fixes = flight.all(|message| match message {
        MavMessage::GPS_RAW_INT(fix) => Some(fix.clone()),
        _ => None,
    });
    assert_eq!(fixes.len(), 200);
    let expected = GPS_RAW_INT_DATA {
        time_usec: START_US,
        lat: i32::MAX,
        lon: i32::MAX,
        alt: 1_234_567,
        eph: u16::MAX,
        epv: u16::MAX,
        vel: 5_000,
        // South-west by west: atan2(-40, -30) = -126.87 degrees.
        cog: 23_313,
        fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
        satellites_visible: 11,
        alt_ellipsoid: 0,
        h_acc: 0,
        v_acc: 2_500,
        vel_acc: 0,
        hdg_acc: 0,
        yaw: 0,
    };
    assert_eq!(fixes[0], expected);
    assert_eq!(flight.named("gps_vd").len(), 200);
    assert_eq!(flight.named("gps_vd")[0], (7_000, 1.25));
    assert_eq!(flight.named("alt_master")[1], (7_005, 1_230.5));
    assert_eq!(flight.named("alt_slave")[199], (7_995, 1_220.25));

    let attitudes = flight.all(|message| match message {
        MavMessage::ATTITUDE(attitude) => Some(attitude.clone()),
        _ => None,
    });
    assert!((18..=22).contains(&attitudes.len()), "{}", attitudes.len());
    let of = &attitudes[0];
    assert_eq!([of.roll, of.pitch, of.yaw], [0.1, 0.2, -3.0]);
    assert_eq!([of.rollspeed, of.pitchspeed, of.yawspeed], [0.01, 0.02, -0.03]);
    assert!((7_000..7_100).contains(&of.time_boot_ms));

    let altitudes = flight.all(|message| match message {
        MavMessage::ALTITUDE(altitude) => Some(altitude.clone()),
        _ => None,
    });
    assert!((9..=11).contains(&altitudes.len()), "{}", altitudes.len());
    // The standard atmosphere's troposphere (ISO 2533), to a few units in the last place of an f32.
    let standard_m = 288.15 / 0.0065 * (1.0 - (87_654.32_f64 / 101_325.0).powf(0.0065 * 287.053 / 9.80665));
    assert!((f64::from(altitudes[0].altitude_monotonic) - standard_m).abs() < 0.05, "{standard_m}");
    assert_eq!(altitudes[0].altitude_amsl, 1_234.0);
    assert!(altitudes[0].altitude_local.is_nan() && altitudes[0].altitude_relative.is_nan());
    assert!(altitudes[0].altitude_terrain < -1_000.0 && altitudes[0].bottom_clearance < 0.0);

    for (name, value) in [("tas", 28.5), ("aoa", 0.07), ("sideslip", -0.02), ("throttle", 0.6)] {
        let sent = flight.named(name);
        assert!((9..=11).contains(&sent.len()), "{name}: {}", sent.len());
        assert!(sent.iter().all(|(_, sent)| *sent == value), "{name}");
    }
    assert_eq!(flight.named("oat").iter().map(|(_, value)| *value).collect::<Vec<_>>(), [-4.5]);
}

#[test]
fn what_is_not_there_is_not_sent_or_sent_as_unknown() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    second(&mut flight, START_US, |input, _| {
        *input = TickInput {
            time_us: input.time_us,
            baro: Some(BaroReading::AltitudeM(1_215.0)),
            gps: Some(GpsFix { altitude_m: -3.5, ..GpsFix::default() }),
            ..TickInput::default()
        };
    });
    let names: std::collections::BTreeSet<&str> =
        flight.decoded.iter().map(|(_, message)| message.message_name()).collect();
    let expected = ["ALTITUDE", "GPS_RAW_INT", "HEARTBEAT", "HIGHRES_IMU", "NAMED_VALUE_FLOAT", "SYS_STATUS"];
    assert_eq!(names.into_iter().collect::<Vec<_>>(), expected);
    for name in ["gps_vd", "alt_master", "alt_slave", "tas", "aoa", "sideslip", "throttle", "oat"] {
        assert_eq!(flight.named(name), [], "{name}");
    }
    for (_, message) in &flight.decoded {
        match message {
            MavMessage::GPS_RAW_INT(fix) => {
                assert_eq!((fix.alt, fix.vel, fix.cog), (-3_500, u16::MAX, u16::MAX));
                assert_eq!((fix.satellites_visible, fix.v_acc), (u8::MAX, 0));
            }
            MavMessage::HIGHRES_IMU(imu) => {
                assert_eq!(imu.fields_updated, HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_PRESSURE_ALT);
                assert_eq!(imu.pressure_alt, 1_215.0);
                assert!([imu.xacc, imu.zgyro, imu.abs_pressure, imu.temperature].iter().all(|x| x.is_nan()));
            }
            _ => {}
        }
    }
}

#[test]
fn held_and_infinite_fixes_are_not_sent_and_refused_ones_are() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    let rejections = [None, Some(Rejection::Held), Some(Rejection::NotFinite), Some(Rejection::Variance)];
    for (k, rejection) in rejections.into_iter().enumerate() {
        let time_us = START_US + k as u64 * 5_000;
        let (mut input, mut output) = (input(time_us), output(time_us));
        if let (Some(fix), Some(Rejection::NotFinite)) = (&mut input.gps, rejection) {
            fix.altitude_m = f32::INFINITY;
        }
        output.gps_rejection = rejection;
        flight.tick(&input, &output);
    }
    flight.drain(usize::MAX);
    let times = flight.all(|message| match message {
        MavMessage::GPS_RAW_INT(fix) => Some((fix.time_usec - START_US) / 5_000),
        _ => None,
    });
    assert_eq!(times, [0, 3]);
}

#[test]
fn the_status_has_bits_and_counts() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    flight.counters.gps = SourceCounters { variance: 2, held: 50, ..SourceCounters::default() };
    flight.counters.sensors[2] = SourceCounters { not_finite: 3, stuck: 4, ..SourceCounters::default() };
    flight.counters.signals_not_finite = 5;
    flight.counters.out_of_order = 6;
    flight.computer =
        ComputerStatus { wire: None, sensor_faults: 70_000, lost_results: 8, load_permille: Some(17) };
    second(&mut flight, START_US, |_, _| ());
    // For the next four seconds the barometer is stuck, and there is no fix.
    for k in 1..5 {
        second(&mut flight, START_US + k * 1_000_000, |input, output| {
            input.gps = None;
            output.sensors[2].rejection = Some(Rejection::Stuck);
        });
    }
    let statuses = flight.all(|message| match message {
        MavMessage::SYS_STATUS(status) => Some(status.clone()),
        _ => None,
    });
    assert!((5..=6).contains(&statuses.len()), "{}", statuses.len());
    use MavSysStatusSensor as Bit;
    let inertial = Bit::MAV_SYS_STATUS_SENSOR_3D_GYRO | Bit::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    let all = inertial
        | Bit::MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
        | Bit::MAV_SYS_STATUS_SENSOR_GPS
        | Bit::MAV_SYS_STATUS_AHRS;
    let none = MavSysStatusSensorExtended::empty();
    let expected = SYS_STATUS_DATA {
        onboard_control_sensors_present: all,
        onboard_control_sensors_enabled: all,
        onboard_control_sensors_health: all,
        load: 17,
        voltage_battery: u16::MAX,
        current_battery: -1,
        drop_rate_comm: 0,
        errors_comm: 0,
        errors_count1: u16::MAX,
        errors_count2: 14,
        errors_count3: 6,
        errors_count4: 8,
        battery_remaining: -1,
        onboard_control_sensors_present_extended: none,
        onboard_control_sensors_enabled_extended: none,
        onboard_control_sensors_health_extended: none,
    };
    assert_eq!(statuses[0], expected);
    let last = statuses.last().unwrap();
    assert_eq!(last.onboard_control_sensors_present, all);
    assert_eq!(last.onboard_control_sensors_health, inertial | Bit::MAV_SYS_STATUS_AHRS);
}

#[test]
fn phases_flags_and_failed_checks_are_said_with_time_and_cause() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[EffectId::BaroDynamicPressure]);
    second(&mut flight, START_US, |_, _| ());
    flight.latch = Some(latch());
    let launch_us = START_US + 1_000_000;
    for k in 0..6 {
        second(&mut flight, launch_us + k * 1_000_000, |input, output| {
            let since_us = input.time_us - launch_us;
            input.launch = true;
            output.phase = Phase::FreeFlight;
            output.latched_now = since_us == 0;
            output.failed_checks = 0b101;
            for sensor in &mut output.sensors {
                sensor.trust = Trust::Trusted;
                sensor.moving_average_m = Some(0.5);
            }
            output.sensors[0].trust = Trust::Unmonitored;
            let baro = &mut output.sensors[2];
            (baro.error_m, baro.moving_average_m) = (Some(-3.25), Some(-3.0625));
            baro.trust = match since_us {
                0..1_500_000 => Trust::Trusted,
                1_500_000..2_500_000 => Trust::Doubtful,
                _ => Trust::Untrustworthy,
            };
            if (3_000_000..4_000_000).contains(&since_us) {
                output.sensors[1].trust = Trust::Unmonitored;
            }
        });
    }
    let severity = |number: u8| {
        move |(severity, text): &(MavSeverity, String)| (*severity as u8 == number).then(|| text.clone())
    };
    let report = |number: u8| flight.texts().iter().filter_map(severity(number)).collect::<Vec<_>>();
    assert_eq!(report(6), ["c_0 is baro.dynamic_pressure"]);
    assert_eq!(report(5), ["t=12.000 imu_slave monitored again"]);
    assert_eq!(
        report(4),
        [
            "t=8.000 latched degraded, 2 checks failed",
            "t=8.000 failed check settled",
            "t=8.000 failed check trimmed_altitude",
            "t=9.500 baro doubtful -3.3>3.0m",
            "t=11.000 imu_slave unmonitored: no reference",
        ]
    );
    assert_eq!(report(3), ["t=10.500 baro untrustworthy -3.1>3.0m"]);

    let modes = flight.all(|message| match message {
        MavMessage::HEARTBEAT(heartbeat) => Some((heartbeat.custom_mode, heartbeat.system_status as u8)),
        _ => None,
    });
    assert_eq!(modes.first(), Some(&(1, MavState::MAV_STATE_CALIBRATING as u8)));
    assert!(modes.contains(&(2, MavState::MAV_STATE_ACTIVE as u8)), "{modes:?}");
    assert_eq!(modes.last(), Some(&(2, MavState::MAV_STATE_CRITICAL as u8)));
    let heartbeat = flight.all(|message| match message {
        MavMessage::HEARTBEAT(heartbeat) => Some(heartbeat.clone()),
        _ => None,
    });
    assert_eq!(heartbeat[0].mavtype, MavType::MAV_TYPE_ONBOARD_CONTROLLER);
    assert_eq!(heartbeat[0].autopilot, MavAutopilot::MAV_AUTOPILOT_INVALID);
    assert_eq!(heartbeat[0].base_mode, MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED);
    assert_eq!(heartbeat[0].mavlink_version, 3);
    // Seven seconds and one change of phase.
    assert!((7..=9).contains(&heartbeat.len()), "{}", heartbeat.len());

    // The launch is reported at the very tick, and again every second.
    let launches = flight.named("launch");
    let first_open = launches.iter().find(|(_, open)| *open == 1.0);
    assert_eq!(first_open, Some(&((launch_us / 1_000) as u32, 1.0)));
    assert!(launches.iter().all(|(at_ms, open)| (*open == 1.0) == (u64::from(*at_ms) * 1_000 >= launch_us)));

    for (name, value) in [
        ("e_baro", -3.25),
        ("ma_baro", -3.0625),
        ("tr_baro", 3.0),
        ("tr_master", 4.0),
        ("tr_slave", 1.0),
        ("b_master", 2.0),
        ("b_slave", -7.5),
        ("b_baro", 14.0),
        ("sb_baro", 0.5),
        ("sr_slave", 2.0),
        ("bd_slave", 1.5),
        ("bd_baro", 3.0),
        ("c_0", 0.06),
        ("sc_0", 0.02),
        ("checks", 5.0),
        ("i_gps", 0.75),
        ("ticks", 0.0),
        ("d_text", 0.0),
    ] {
        assert_eq!(flight.named(name).last().map(|(_, value)| *value), Some(value), "{name}");
    }
    assert_eq!(flight.named("s_ref")[0].1, 0.3);
    assert_eq!(flight.named("c_1"), []);
}

#[test]
fn doubts_about_the_launch_and_the_cross_check_are_said_with_time_and_cause() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    flight.latch = Some(latch());
    let doubts = |from_us: u64, doubt: LaunchDoubt| {
        move |input: &mut TickInput, _: &mut TickOutput| {
            input.launch_doubt =
                if (from_us..from_us + 15_000).contains(&input.time_us) { doubt } else { LaunchDoubt::None };
        }
    };
    second(&mut flight, START_US, doubts(START_US + 200_000, LaunchDoubt::Suspected));
    // A suspicion that a launch confirmed is not reported as withdrawn.
    second(&mut flight, START_US + 1_000_000, |input, _| {
        let since_us = input.time_us - START_US - 1_000_000;
        input.launch = since_us >= 300_000;
        input.launch_doubt =
            if (200_000..300_000).contains(&since_us) { LaunchDoubt::Suspected } else { LaunchDoubt::None };
    });
    second(&mut flight, START_US + 2_000_000, |input, _| {
        (input.launch, input.launch_doubt) = (true, LaunchDoubt::Unconfirmed);
    });
    second(&mut flight, START_US + 3_000_000, |input, output| {
        (input.launch, input.launch_doubt) = (true, LaunchDoubt::Unconfirmed);
        let since_us = input.time_us - START_US - 3_000_000;
        // Pairs of readings come every other tick; in the ticks between there is nothing to report.
        output.cross_check = since_us.is_multiple_of(10_000).then_some(CrossCheckOutput {
            difference_m: -4.5,
            moving_average_m: -3.9,
            agreement: match since_us {
                0..400_000 => Agreement::Agree,
                400_000..600_000 => Agreement::Doubtful,
                _ => Agreement::Disagree,
            },
        });
    });
    let texts: Vec<(u8, String)> =
        flight.texts().into_iter().map(|(severity, text)| (severity as u8, text)).collect();
    // The limit is the root of 2.25 and 9 square metres.
    let expected = [
        (4, "t=7.200 launch suspected, calibration held"),
        (5, "t=7.215 launch not confirmed, calibrating"),
        (4, "t=8.200 launch suspected, calibration held"),
        (4, "t=9.000 launched, not confirmed"),
        (4, "t=10.400 baro-imu_slave doubtful -4.5>3.4m"),
        (3, "t=10.600 baro-imu_slave disagree -3.9>3.4m"),
    ];
    assert_eq!(texts, expected.map(|(severity, text)| (severity, text.to_owned())));
}

#[test]
fn a_start_that_is_no_power_on_is_said_before_all_else() {
    let snapshot_us = START_US - 150_000;
    let resumed = RestartReport {
        start: Start::Resumed,
        cause: Cause::Stuck,
        crash: None,
        mark: None,
        snapshot_us: Some(snapshot_us),
        refused: [None; 2],
        resumed_us: START_US,
        restarts: 1,
        pause_us: 0,
    };
    let none_left = RestartReport { start: Start::Lost, snapshot_us: None, ..resumed };
    let refused = [Some(Refusal::Corrupt), Some(Refusal::OtherModel)];
    for (report, expected) in [
        (resumed, vec![(3, "t=7.000 restart 1: something stuck"), (3, "t=7.000 resumed, 0.150s not known")]),
        (
            RestartReport { pause_us: 2_000_000, ..resumed },
            vec![
                (0, "t=7.000 standby 2s: something stuck"),
                (3, "t=7.000 restart 1: something stuck"),
                (3, "t=7.000 resumed, 0.150s not known"),
            ],
        ),
        (
            RestartReport { refused: [None, Some(Refusal::NotUnderstood)], ..resumed },
            vec![
                (3, "t=7.000 restart 1: something stuck"),
                (2, "t=7.000 copy 1 refused: another version's"),
                (3, "t=7.000 resumed, 0.150s not known"),
            ],
        ),
        (
            RestartReport { refused, ..none_left },
            vec![
                (3, "t=7.000 restart 1: something stuck"),
                (2, "t=7.000 copy 0 refused: corrupt"),
                (2, "t=7.000 copy 1 refused: another model's"),
                (2, "t=7.000 calibration lost in the restart"),
            ],
        ),
        // No snapshot had been kept yet, so there is nothing to refuse.
        (
            RestartReport { refused: [Some(Refusal::Empty); 2], ..none_left },
            vec![(3, "t=7.000 restart 1: something stuck"), (2, "t=7.000 calibration lost in the restart")],
        ),
        (
            RestartReport { start: Start::Captive, snapshot_us: None, ..resumed },
            vec![(3, "t=7.000 restart 1: something stuck"), (4, "t=7.000 calibration starts again")],
        ),
        (
            RestartReport { start: Start::Cold, cause: Cause::Supply, refused, ..none_left },
            vec![(5, "t=7.000 cold start: a loss of power")],
        ),
    ] {
        let mut queue = FrameQueue::new();
        let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
        flight.telemetry.note_start(&report);
        second(&mut flight, START_US, |input, _| input.launch_doubt = LaunchDoubt::Unconfirmed);
        let mut texts: Vec<(u8, String)> =
            flight.texts().into_iter().map(|(severity, text)| (severity as u8, text)).collect();
        let last = texts.pop();
        assert_eq!(last, Some((4, "t=7.000 launched, not confirmed".to_owned())), "{report:?}");
        assert_eq!(
            texts,
            expected.iter().map(|(severity, text)| (*severity, (*text).to_owned())).collect::<Vec<_>>()
        );
    }
}

#[test]
fn an_internal_clock_is_said_from_the_start_on_and_again() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    flight.telemetry.note_internal_clock();
    for k in 0..70 {
        second(&mut flight, START_US + k * 1_000_000, |_, _| ());
    }
    let report: Vec<String> = flight.texts().into_iter().map(|(_, text)| text).collect();
    assert_eq!(report[0], "t=7.000 no crystal: clock 1% to 4% off");
    assert!(report.iter().filter(|text| text.contains("no crystal")).count() >= 2, "{report:?}");
}

#[test]
fn in_standby_the_cause_and_the_pause_are_sent() {
    let report = RestartReport {
        start: Start::Resumed,
        cause: Cause::HardFault,
        crash: None,
        mark: None,
        snapshot_us: None,
        refused: [None; 2],
        resumed_us: START_US,
        restarts: 4,
        pause_us: 4_000_000,
    };
    let (sequence, message) = decode(telemetry::standby(&report, 7).bytes());
    let MavMessage::STATUSTEXT(text) = message else { panic!("{message:?}") };
    assert_eq!(
        (sequence, text.severity, text.text.to_str()),
        (7, MavSeverity::MAV_SEVERITY_EMERGENCY, Ok("t=3.000 standby 4s: a hard fault"))
    );
}

#[test]
fn sequence_numbers_have_gaps_for_counted_drops_and_for_nothing_else() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[EffectId::BaroLag; MAX_ESTIMATED_EFFECTS]);
    // A line that takes two of the five or six frames of a tick.
    for tick in 0..2_000 {
        let time_us = START_US + tick * 5_000;
        let (mut input, mut output) = (input(time_us), output(time_us));
        if tick >= 1_000 {
            input.launch = true;
            output.latched_now = tick == 1_000;
            output.failed_checks = 0x3ff;
        }
        flight.tick(&input, &output);
        flight.drain(2);
    }
    flight.drain(usize::MAX);
    let counts = *flight.telemetry.counts();
    let dropped = counts.all_dropped();
    assert!(dropped > 5_000, "{counts:?}");
    assert_eq!(counts.all_queued() as usize, flight.decoded.len());
    let mut gaps = 0;
    for pair in flight.decoded.windows(2) {
        gaps += u32::from(pair[1].0.wrapping_sub(pair[0].0).wrapping_sub(1));
    }
    // Drops after the last frame that was sent leave no gap; there are fewer of them than the queue's length.
    assert!(dropped - gaps < 200, "{dropped} dropped, {gaps} seen");
    // Every text was sent, the launch was sent at once, and the drops are reported.
    assert_eq!(flight.texts().len(), 1 + 10 + MAX_ESTIMATED_EFFECTS);
    assert_eq!(counts.dropped[7], 0);
    let told = flight.all(|message| match message {
        MavMessage::SYS_STATUS(status) => Some((status.errors_comm, status.drop_rate_comm)),
        _ => None,
    });
    let (errors, rate) = *told.last().unwrap();
    assert!(errors > 3_000 && (4_000..9_000).contains(&rate), "{errors} {rate}");
    let fixes = flight.named("d_gps").last().unwrap().1;
    assert!(fixes > 500.0 && fixes <= counts.dropped[2] as f32, "{fixes} {counts:?}");
    // No source has the line to itself: they share what is left of it.
    let [imu, gps] = [counts.queued[4], counts.queued[2]];
    assert!(gps > imu / 2 && imu > gps / 2 && imu > 100, "{counts:?}");
}

#[test]
fn a_tick_out_of_order_brings_nothing() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::FULL, &[]);
    let mut late = output(START_US);
    late.out_of_order = true;
    flight.tick(&input(START_US), &late);
    flight.drain(usize::MAX);
    assert!(flight.decoded.is_empty());
}

#[test]
fn narrow_rates_are_kept_and_the_barometer_is_never_under_another_ticks_time() {
    let mut queue = FrameQueue::new();
    let mut flight = Flight::new(&mut queue, Rates::NARROW, &[]);
    let mut bytes = 0;
    for tick in 0..2_000_u64 {
        let time_us = START_US + tick * 5_000;
        let (mut input, output) = (input(time_us), output(time_us));
        // A barometer at 40 Hz whose value is the number of the tick.
        input.baro = (tick % 5 == 0).then_some(BaroReading::PressurePa((tick * 100) as f32));
        flight.tick(&input, &output);
        while let Some(frame) = flight.line.dequeue() {
            bytes += frame.bytes().len();
            flight.decoded.push(decode(frame.bytes()));
        }
    }
    let imu = flight.all(|message| match message {
        MavMessage::HIGHRES_IMU(imu) => Some((imu.time_usec, imu.abs_pressure)),
        _ => None,
    });
    assert!((395..=405).contains(&imu.len()), "{}", imu.len());
    assert!(imu.iter().all(|(time_us, hpa)| (time_us - START_US) / 5_000 == *hpa as u64), "{imu:?}");
    let budget = f64::from(Rates::NARROW.bytes_per_second());
    assert!((bytes as f64 / 10.0) < budget && bytes as f64 / 10.0 > 0.5 * budget, "{bytes} of {budget}");
}
