//! Signals that are missing, late or absurd; the regressors themselves are tested against simulated
//! flights in `apps/pylon/tests/effects.rs`.

use proptest::collection::vec;
use proptest::prelude::*;

use super::*;
use crate::input::{GpsFix, ImuSample, Signals, TickInput};
use crate::sensor::Sensor;

fn tick(time_us: u64, signals: Signals) -> TickInput {
    TickInput { time_us, signals, ..TickInput::default() }
}

fn value(tracker: &SignalTracker, id: EffectId) -> Option<f32> {
    tracker.regressor_m(Regressor::new(id))
}

const FIX: GpsFix = GpsFix {
    altitude_m: 500.0,
    velocity_north_mps: Some(3.0),
    velocity_east_mps: Some(4.0),
    velocity_down_mps: Some(12.0),
    vertical_accuracy_m: None,
    satellites: None,
    fix_time_us: None,
};

#[test]
fn the_catalogue_is_whole_and_consistent() {
    assert_eq!(EffectId::ALL.len(), 22);
    for (k, id) in EffectId::ALL.into_iter().enumerate() {
        assert_eq!(EffectId::from_name(id.name()), Some(id));
        assert!(EffectId::ALL[..k].iter().all(|other| other.name() != id.name()));
        let family = match id.subject() {
            EffectSubject::Gps => "gps",
            EffectSubject::Sensor(Sensor::Baro) => "baro",
            EffectSubject::Sensor(Sensor::ImuSlave) => "imu",
            EffectSubject::Sensor(Sensor::ImuMaster) => "imu_master",
        };
        assert_eq!(id.name().split_once('.').unwrap().0, family);
        assert_eq!(
            Sensor::ALL.into_iter().filter(|sensor| id.acts_on(*sensor)).count(),
            usize::from(family != "gps")
        );
        let [least, most] = id.plausible();
        assert!(least < most && least <= 0.0 && most > 0.0, "{}", id.name());
        let typical = id.typical_regressor_m();
        assert_eq!(typical.to_bits() & 0x007f_ffff, 0, "{}: {typical} is no power of two", id.name());
        let timed = matches!(id, EffectId::BaroWarmUp | EffectId::GpsConvergence);
        assert_eq!(id.has_time_constant(), timed, "{}", id.name());
    }
    assert_eq!(EffectId::from_name("baro"), None);
}

#[test]
fn ground_speed_stands_in_until_an_airspeed_is_measured() {
    let mut tracker = SignalTracker::default();
    assert_eq!((value(&tracker, EffectId::BaroDynamicPressure), tracker.airspeed_source()), (None, None));
    tracker.take(&tick(0, Signals::default()), Some(&FIX));
    assert_eq!(tracker.airspeed_squared_m2ps2(), Some(169.0));
    assert_eq!(tracker.airspeed_source(), Some(AirspeedSource::GroundSpeed));
    tracker.take(&tick(5_000, Signals { true_airspeed_mps: Some(100.0), ..Signals::default() }), None);
    assert_eq!(tracker.airspeed_source(), Some(AirspeedSource::TrueAirspeed));
    // 100 m/s: 10^4 / (2 * 9.80665) = 509.86 m.
    let head = value(&tracker, EffectId::BaroDynamicPressure).unwrap();
    assert!((head - 509.858).abs() < 1e-3, "{head}");
    tracker.take(&tick(10_000, Signals { true_airspeed_mps: Some(f32::NAN), ..Signals::default() }), None);
    assert_eq!((tracker.airspeed_squared_m2ps2(), tracker.refused()), (Some(10_000.0), 1));
}

/// All signals, at a time.
fn whole(time_us: u64) -> (TickInput, GpsFix) {
    let input = TickInput {
        time_us,
        imu: Some(ImuSample { accel_mps2: [1.0, 0.0, -9.0], gyro_radps: [0.0; 3] }),
        signals: Signals {
            true_airspeed_mps: Some(50.0),
            angle_of_attack_rad: Some(0.1),
            sideslip_rad: Some(-0.1),
            throttle: Some(0.5),
            outside_air_temperature_c: Some(10.0),
            baro_temperature_c: Some(20.0),
            attitude_rad: Some([0.0, 0.25, 1.0]),
        },
        ..TickInput::default()
    };
    (input, FIX)
}

#[test]
fn each_effect_waits_for_the_columns_it_names_and_for_no_other() {
    use EffectId::*;
    for id in EffectId::ALL {
        let present = |without: &str| {
            let (mut input, mut fix) = whole(0);
            let signals = &mut input.signals;
            match without {
                "tas_mps" => {
                    signals.true_airspeed_mps = None;
                    // Its stand-in is missing too.
                    fix.velocity_north_mps = None;
                }
                "aoa_rad" => signals.angle_of_attack_rad = None,
                "sideslip_rad" => signals.sideslip_rad = None,
                "throttle" => signals.throttle = None,
                "oat_c" => signals.outside_air_temperature_c = None,
                "baro_temp_c" => signals.baro_temperature_c = None,
                "roll_rad" | "pitch_rad" | "yaw_rad" => signals.attitude_rad = None,
                "gps_vn_mps" | "gps_ve_mps" => fix.velocity_east_mps = None,
                "gps_vd_mps" => fix.velocity_down_mps = None,
                "gps_alt_m" | "" => {}
                _ => input.imu = None,
            }
            let mut tracker = SignalTracker::for_effects([id], 45.0);
            tracker.take(&input, (without != "gps_alt_m").then_some(&fix));
            value(&tracker, id).is_some()
        };
        assert!(present(""), "{}", id.name());
        let columns = "tas_mps aoa_rad sideslip_rad throttle oat_c baro_temp_c roll_rad pitch_rad yaw_rad gps_vn_mps \
                       gps_ve_mps gps_alt_m accel_x_mps2 accel_y_mps2 accel_z_mps2 gyro_x_radps";
        for column in columns.split_whitespace() {
            // Ground speed stands in for what these two need; nothing replaces the parts of a fix without the
            // fix.
            let has_stand_in = matches!(id, ImuTilt | ImuGyroBias);
            let in_a_fix = id == ImuEotvos && column == "gps_alt_m";
            let both_speeds = id == ImuEotvos && column == "tas_mps";
            let needed = id.needs().contains(&column) && !has_stand_in;
            assert_eq!(present(column), !(needed || in_a_fix || both_speeds), "{} {column}", id.name());
        }
    }
}

#[test]
fn before_launch_time_and_integrals_stand_still() {
    let mut tracker = SignalTracker::default();
    for k in 0..1_000 {
        let (input, fix) = whole(k * 5_000);
        tracker.take(&input, Some(&fix));
    }
    for id in EffectId::ALL {
        let zero = id.name().starts_with("imu")
            || matches!(id, EffectId::BaroDrift | EffectId::BaroWarmUp | EffectId::BaroCarrierField);
        if zero {
            assert_eq!(value(&tracker, id), Some(0.0), "{}", id.name());
        }
    }
    assert_eq!(value(&tracker, EffectId::GpsConvergence), Some(1.0));
    let since_start = |id| Regressor { time_constant_s: 4.995, since: Clock::Start, ..Regressor::new(id) };
    let decayed = tracker.regressor_m(since_start(EffectId::GpsConvergence)).unwrap();
    assert!((decayed - (-1.0_f32).exp()).abs() < 1e-6);
    let warm = tracker.regressor_m(since_start(EffectId::BaroWarmUp)).unwrap();
    assert!((warm + decayed - 1.0).abs() < 1e-6);
    tracker.begin_free_flight(5_000_000);
    let head = dynamic_pressure_head_m(2_500.0);
    assert_eq!(value(&tracker, EffectId::BaroCarrierField), Some(head));
    let (mut input, fix) = whole(6_000_000);
    input.signals.true_airspeed_mps = Some(80.0);
    tracker.take(&input, Some(&fix));
    assert_eq!(value(&tracker, EffectId::BaroCarrierField), Some(head));
    assert_eq!(value(&tracker, EffectId::BaroDrift), Some(1.0));
}

#[test]
fn a_launch_sets_every_integral_to_zero_whatever_was_before() {
    let mut tracker = SignalTracker::default();
    tracker.begin_free_flight(0);
    for k in 0..1_000 {
        let (mut input, mut fix) = whole(k * 5_000);
        if let (true, Some(imu)) = (k % 2 == 0, &mut input.imu) {
            imu.accel_mps2[1] = 1.0;
        }
        fix.altitude_m += k as f32;
        tracker.take(&input, Some(&fix));
    }
    let integrated = EffectId::ALL.into_iter().filter(|id| id.name().starts_with("imu."));
    for id in integrated.clone() {
        assert!(value(&tracker, id).unwrap().abs() > 1e-3, "{}", id.name());
    }
    tracker.begin_free_flight(5_000_000);
    for id in integrated {
        assert_eq!(value(&tracker, id), Some(0.0), "{}", id.name());
    }
}

#[test]
fn heights_and_temperatures_count_from_the_calibrations_first() {
    let mut tracker = SignalTracker::default();
    let take = |tracker: &mut SignalTracker, k: u64, altitude_m: f32, temperature_c: f32| {
        let signals = Signals { baro_temperature_c: Some(temperature_c), ..Signals::default() };
        let fix = GpsFix { altitude_m, ..GpsFix::default() };
        tracker.take(&tick(k * 5_000, signals), Some(&fix));
        (value(tracker, EffectId::BaroScale).unwrap(), value(tracker, EffectId::BaroTemperature).unwrap())
    };
    assert_eq!(take(&mut tracker, 0, 100.0, 10.0), (0.0, 0.0));
    assert_eq!(take(&mut tracker, 1, 110.0, 12.0), (10.0, 2.0));
    tracker.begin_calibration();
    assert_eq!(take(&mut tracker, 2, 120.0, 15.0), (0.0, 0.0));
    assert_eq!(take(&mut tracker, 3, 125.0, 14.0), (5.0, -1.0));
}

#[test]
fn speed_over_ground_stands_in_for_an_inertial_unit() {
    let mut tracker = SignalTracker::default();
    tracker.begin_free_flight(0);
    assert_eq!(tracker.acceleration_source(), None);
    // 20 m/s for 10 s, then 2 m/s^2 for 10 s, with a fix every 0.1 s and a tick every 0.05 s.
    let mut end = [0.0; 2];
    for k in 0..=400_u16 {
        let time_s = f32::from(k) * 0.05;
        let speed = 20.0 + 2.0 * (time_s - 10.0).max(0.0);
        let fix =
            GpsFix { velocity_north_mps: Some(0.6 * speed), velocity_east_mps: Some(-0.8 * speed), ..FIX };
        let input = tick(u64::from(k) * 50_000, Signals::default());
        tracker.take(&input, (k % 2 == 0).then_some(&fix));
        end = [EffectId::ImuTilt, EffectId::ImuGyroBias].map(|id| value(&tracker, id).unwrap());
    }
    assert_eq!(tracker.acceleration_source(), Some(AccelerationSource::GroundSpeed));
    // Twice 2: 100 m. Twice 2 t from 10 s to 20 s: t^3/3 - 100 t + 2000/3, 1,333 m. Half an interval late.
    assert!((end[0] - 100.0).abs() < 20.0 * 0.1, "{end:?}");
    assert!((end[1] - 4_000.0 / 3.0).abs() < 300.0 * 0.1, "{end:?}");
    assert_eq!(value(&tracker, EffectId::ImuAccelScale), None);
}

/// The tilt's regressor 60 s after launch, and the remaining sigma of the forward acceleration's error, of an
/// aircraft at a constant airspeed in a wind. Its attitude reads 0.4 degrees too low a pitch and
/// `heading_error_rad` too large a heading; the captive flight of 120 s turns at this many rad/s.
fn with_a_wrong_pitch(turn_radps: f32, heading_error_rad: f32, has_heading: bool) -> (f32, f32) {
    const PITCH_ERROR_RAD: f32 = 0.007;
    let mut tracker = SignalTracker::default();
    for k in 0..=36_000_u32 {
        let (time_us, time_s) = (u64::from(k) * 5_000, k as f32 * 0.005);
        match k {
            1_000 => tracker.begin_calibration(),
            24_000 => tracker.begin_free_flight(time_us),
            _ => {}
        }
        let heading_rad = turn_radps * time_s.min(120.0);
        let fix = GpsFix {
            velocity_north_mps: Some(25.0 * heading_rad.cos() + 6.0),
            velocity_east_mps: Some(25.0 * heading_rad.sin() - 3.0),
            ..FIX
        };
        // Wings level and turning flat: the specific force along the body is that of level flight.
        let attitude_rad = [0.0, -PITCH_ERROR_RAD, heading_rad + heading_error_rad];
        let signals = Signals { attitude_rad: has_heading.then_some(attitude_rad), ..Signals::default() };
        let input = TickInput {
            imu: Some(ImuSample { accel_mps2: [0.0, 0.0, -9.80665], gyro_radps: [0.0; 3] }),
            ..tick(time_us, signals)
        };
        // Every other fix has no velocity.
        let without = GpsFix { velocity_north_mps: None, velocity_east_mps: None, ..FIX };
        let fix = if k % 80 == 0 { fix } else { without };
        tracker.take(&input, (k % 40 == 0).then_some(&fix));
    }
    (value(&tracker, EffectId::ImuTilt).unwrap(), tracker.forward_sigma_mps2())
}

/// 0.007 rad lets 0.0686 m/s^2 in, which 60 s after launch is 124 m. Captive flight of 115 s shows it with a
/// sigma of 0.2 m/s over that time, so all but a 600th of it is subtracted.
#[test]
fn captive_flight_shows_the_constant_error_of_the_forward_acceleration() {
    let (tilt_m, sigma_mps2) = with_a_wrong_pitch(0.0, 0.0, true);
    assert!((sigma_mps2 * 115.0 / 0.2 - 1.0).abs() < 0.01, "{sigma_mps2}");
    assert!(tilt_m.abs() < 124.0 / 500.0, "{tilt_m}");
}

/// A turn counts by what a wrong heading would let in of it. The velocity changes across by
/// `25 m/s * 0.027 /s` each second, 0.025 of which, 0.0169 m/s^2, is the measurement's sigma; so
/// `0.043^2 / (0.043^2 + 0.0169^2)`, 0.866 of the error is subtracted, and 16.6 m of 124 are left.
#[test]
fn half_a_circle_in_a_wind_shows_most_of_the_error() {
    let (tilt_m, _) = with_a_wrong_pitch(0.027, 0.0, true);
    assert!((tilt_m / 16.6 - 1.0).abs() < 0.05, "{tilt_m}");
}

/// Circles at 0.2 rad/s have a sigma of 0.125 m/s^2, and 0.1058 of what is measured is subtracted. A heading
/// that is 0.03 rad too large takes `25 * 0.2 * 0.03`, 0.15 m/s^2, away from that; one too small adds it.
#[test]
fn a_wrong_heading_in_circles_is_hardly_taken_for_an_error_of_the_acceleration() {
    for heading_error_rad in [-0.03, 0.0, 0.03] {
        let (tilt_m, sigma_mps2) = with_a_wrong_pitch(0.2, heading_error_rad, true);
        assert!((sigma_mps2 / (0.043 * (1.0 - 0.1058_f32).sqrt()) - 1.0).abs() < 0.01, "{sigma_mps2}");
        let used_mps2 = 0.1058 * (0.0686 - 5.0 * heading_error_rad);
        let left_m = (0.0686 - used_mps2) * 1_800.0;
        assert!((tilt_m - left_m).abs() < 2.0, "{heading_error_rad}: {tilt_m} {left_m}");
    }
}

/// A speed over ground has no such error, and nothing is subtracted from it.
#[test]
fn without_an_attitude_nothing_is_subtracted() {
    let (tilt_m, sigma_mps2) = with_a_wrong_pitch(0.0, 0.0, false);
    assert_eq!(tilt_m, 0.0);
    assert!((sigma_mps2 / 0.043 - 1.0).abs() < 1e-3, "{sigma_mps2}");
}

fn finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
}

prop_compose! {
    fn any_tick()(
        step_us in prop_oneof![Just(5_000_u64), any::<u32>().prop_map(u64::from)],
        numbers in vec(prop_oneof![finite(), -100.0_f32..100.0], 17),
        has in vec(any::<bool>(), 8),
        launch in 0_u8..20,
    ) -> (u64, Vec<f32>, Vec<bool>, u8) {
        (step_us, numbers, has, launch)
    }
}

proptest! {
    #[test]
    fn finite_signals_never_make_a_regressor_that_is_not(ticks in vec(any_tick(), 1..40)) {
        let mut tracker = SignalTracker::default();
        let mut time_us = 0_u64;
        for (step_us, n, has, launch) in ticks {
            time_us += step_us;
            match launch {
                0 => tracker.begin_free_flight(time_us),
                1 => tracker.begin_calibration(),
                _ => {}
            }
            let some = |k: usize, value: f32| has[k].then_some(value);
            let input = TickInput {
                time_us,
                imu: some(0, 0.0).map(|_| ImuSample { accel_mps2: [n[0], n[1], n[2]], gyro_radps: [0.0; 3] }),
                signals: Signals {
                    true_airspeed_mps: some(1, n[3]),
                    angle_of_attack_rad: some(2, n[4]),
                    sideslip_rad: some(2, n[5]),
                    throttle: some(3, n[6]),
                    outside_air_temperature_c: some(3, n[7]),
                    baro_temperature_c: some(3, n[8]),
                    attitude_rad: some(4, 0.0).map(|_| [n[9], n[10], n[11]]),
                },
                ..TickInput::default()
            };
            let fix = GpsFix {
                altitude_m: n[12],
                velocity_north_mps: some(5, n[13]),
                velocity_east_mps: some(6, n[14]),
                velocity_down_mps: some(7, n[15]),
                ..GpsFix::default()
            };
            tracker.take(&input, Some(&fix));
            for id in EffectId::ALL {
                for since in [Clock::Launch, Clock::Start] {
                    let regressor = Regressor { since, time_constant_s: n[16].abs().max(1e-3), id };
                    if let Some(value) = tracker.regressor_m(regressor) {
                        prop_assert!(value.is_finite(), "{} {value}", id.name());
                    }
                }
            }
        }
        // Sensible signals after absurd ones make a regressor again.
        for k in 1..=3 {
            let (input, fix) = whole(time_us + k * 5_000);
            tracker.take(&input, Some(&fix));
        }
        for id in [EffectId::BaroDynamicPressure, EffectId::BaroLag, EffectId::GpsLeverArm, EffectId::ImuVibration] {
            prop_assert!(value(&tracker, id).is_some(), "{}", id.name());
        }
    }
}
