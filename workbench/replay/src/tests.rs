use flight_computer::{Estimation as _, Retainable as _};
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt};
use kf_core::mission::Mission;
use kf_core::output::Phase;
use kf_core::sensor::Sensor;
use kf_core::snapshot::MissionMark;
use rand::{RngExt as _, SeedableRng as _};

use super::*;
use flight_data::parse;

fn read(text: &str) -> Flight {
    parse(format!("# pylon-flight: 1\n{text}").as_bytes()).unwrap().0
}

fn inputs(text: &str) -> Vec<TickInput> {
    let flight = read(text);
    TickInputs::new(&flight, &[], None, flight.rows(), true, &model::formula::Columns::default()).collect()
}

/// Captive at 2000 m for `captive` seconds, then `free` seconds: gps 5 Hz, the rest 50 Hz; the slave reads
/// 70 m low, the baro 120 m low, the master 10 m high, each with uniform noise of +-1 m.
fn noisy_flight(captive: u32, free: u32, with_launch: bool) -> Flight {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut text =
        String::from("time_s,launch,gps_alt_m,gps_vd_mps,imu_master_alt_m,imu_slave_alt_m,baro_alt_m\n");
    for row in 0..(captive + free) * 50 {
        let mut noise = || random.random_range(-1.0..1.0_f32);
        let launched = row >= captive * 50;
        let launch = if with_launch { if launched { "1" } else { "0" } } else { "" };
        let gps = if row % 10 == 0 { format!("{},0", 2000.0 + noise()) } else { ",".into() };
        let master = if launched { String::new() } else { (2010.0 + noise()).to_string() };
        text += &format!(
            "{},{launch},{gps},{master},{},{}\n",
            f64::from(row) * 0.02,
            1930.0 + noise(),
            1880.0 + noise()
        );
    }
    read(&text)
}

fn run(replay: &Replay<'_>) -> (Vec<TickOutput>, ReplaySummary) {
    let mut outputs = Vec::new();
    let summary = replay.run(&mut |_, output| outputs.push(output.clone())).unwrap();
    (outputs, summary)
}

#[test]
fn every_cell_reaches_its_field() {
    let ticks = inputs(
        "time_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,gps_vacc_m,gps_sats,gps_time_s,baro_pa,baro_alt_m,\
         baro_temp_c,imu_master_alt_m,imu_slave_alt_m,accel_x_mps2,accel_y_mps2,accel_z_mps2,gyro_x_radps,\
         gyro_y_radps,gyro_z_radps,roll_rad,pitch_rad,yaw_rad,tas_mps,aoa_rad,sideslip_rad,throttle,oat_c\n\
         0.0050004,1,1,2,3,4,5,6,7.5,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25,26\n\
         1,,,,,,,,,,9,,,,,,,,,,,,,,,,,\n\
         2,0,nan,,,,,,,,,,,,,,,,,,,,,,,,,\n",
    );
    assert_eq!(
        ticks[0],
        TickInput {
            time_us: 5000,
            launch: true,
            launch_doubt: LaunchDoubt::None,
            gps: Some(GpsFix {
                altitude_m: 1.0,
                velocity_north_mps: Some(2.0),
                velocity_east_mps: Some(3.0),
                velocity_down_mps: Some(4.0),
                vertical_accuracy_m: Some(5.0),
                satellites: Some(6),
                fix_time_us: Some(7_500_000),
            }),
            baro: Some(BaroReading::PressurePa(8.0)),
            imu_master_altitude_m: Some(11.0),
            imu_slave_altitude_m: Some(12.0),
            imu: Some(ImuSample { accel_mps2: [13.0, 14.0, 15.0], gyro_radps: [16.0, 17.0, 18.0] }),
            signals: kf_core::input::Signals {
                true_airspeed_mps: Some(22.0),
                angle_of_attack_rad: Some(23.0),
                sideslip_rad: Some(24.0),
                throttle: Some(25.0),
                outside_air_temperature_c: Some(26.0),
                baro_temperature_c: Some(10.0),
                attitude_rad: Some([19.0, 20.0, 21.0]),
            },
            ..TickInput::default()
        }
    );
    assert_eq!(
        ticks[1],
        TickInput {
            time_us: 1_000_000,
            launch: true,
            baro: Some(BaroReading::AltitudeM(9.0)),
            ..TickInput::default()
        }
    );
    assert!(!ticks[2].launch && ticks[2].gps.is_some_and(|fix| fix.altitude_m.is_nan()));
}

#[test]
fn what_no_tick_can_carry_is_counted() {
    let flight = read(
        "time_s,gps_alt_m,gps_vd_mps,gps_sats,baro_pa,roll_rad,pitch_rad,yaw_rad,accel_x_mps2,accel_y_mps2,\
         accel_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps\n\
         0,,1,,,1,,,1,1,1,,,\n\
         1,5,,256,,1,2,,1,1,1,1,1,\n\
         2,5,,-1,,1,2,3,1,1,1,1,1,1\n\
         3,5,,nan,,,,,,,,,,\n",
    );
    let mut inputs =
        TickInputs::new(&flight, &[], None, flight.rows(), true, &model::formula::Columns::default());
    let ticks: Vec<_> = inputs.by_ref().collect();
    assert_eq!(
        *inputs.counters(),
        InputCounters {
            fixes_without_altitude: 1,
            satellites_not_a_count: 3,
            partial_attitudes: 2,
            partial_imu_samples: 2
        }
    );
    assert!(ticks[2].imu.is_some() && ticks[2].signals.attitude_rad.is_some());
    assert!(ticks.iter().skip(1).all(|tick| tick.gps.is_some_and(|fix| fix.satellites.is_none())));
}

#[test]
fn the_replay_is_the_mission_itself() {
    let flight = noisy_flight(40, 5, true);
    let replay = Replay::new(&flight, &Model::paper(), None).unwrap();
    assert_eq!(*replay.source(), CalibrationSource::LaunchColumn);
    let (outputs, summary) = run(&replay);
    let mut mission = Mission::<3, 1, 0>::new(&Model::paper().mission_config().unwrap()).unwrap();
    let direct: Vec<_> = replay.inputs().map(|input| mission.tick(&input)).collect();
    assert_eq!(outputs.len(), flight.rows());
    assert_eq!(outputs, direct);
    assert_eq!(summary.latch.as_ref(), mission.latch());
    assert_eq!(summary.latch.unwrap().time_us, 40_000_000);
}

/// The state for a restart is the mission's own, whatever its shape.
#[test]
fn a_boxed_missions_mark_is_the_missions() {
    let flight = noisy_flight(40, 5, true);
    let replay = Replay::new(&flight, &Model::paper(), None).unwrap();
    let mut boxed = mission(&Model::paper()).unwrap();
    let mut direct = Mission::<3, 1, 0>::new(&Model::paper().mission_config().unwrap()).unwrap();
    for input in replay.inputs() {
        assert_eq!(boxed.tick(&input), direct.tick(&input));
    }
    assert_eq!(boxed.mark(), direct.mark());
    assert_ne!(boxed.mark(), MissionMark::default(), "a mission that has flown");
}

/// Both shapes, with and without an estimated effect, find the offsets that are in the flight.
#[test]
fn every_shape_calibrates() {
    let flight = noisy_flight(60, 1, true);
    for propagate in ["true", "false"] {
        for effect in ["", "[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 0.1\nestimate = true"] {
            let text = format!("gps.propagate_climb_rate = {propagate}\n{effect}");
            let replay = Replay::new(&flight, &Model::parse(&text).unwrap(), None).unwrap();
            let latch = run(&replay).1.latch.unwrap();
            for (sensor, offset_m) in
                [(Sensor::ImuMaster, 10.0), (Sensor::ImuSlave, -70.0), (Sensor::Baro, -120.0)]
            {
                let bias_m = latch.sensors[sensor.index()].bias_m;
                // Uniform +-1 m is 0.58 m (1 sigma). The reference's mean over 250 fixes and the wander that
                // the models allow for leave some 0.1 to 0.2 m.
                assert!((bias_m - offset_m).abs() < 0.6, "{text}: {} {bias_m}", sensor.name());
            }
        }
    }
}

#[test]
fn a_given_window_skips_starts_and_launches() {
    let flight = noisy_flight(60, 10, false);
    let window: CalibrationWindow = "5..50".parse().unwrap();
    let replay = Replay::new(&flight, &Model::default(), Some(window)).unwrap();
    assert_eq!(replay.model().settling_s, 0.0);
    assert_eq!(replay.source().to_string(), "calibrated on 5..50 s of the flight's own clock, as given");
    let mut ticks = Vec::new();
    let summary = replay
        .run(&mut |input, output| ticks.push((input.time_us, output.phase, output.latched_now)))
        .unwrap();
    assert_eq!(summary.inputs.skipped_rows, 250);
    assert_eq!(ticks[0], (5_000_000, Phase::Calibrating, false));
    let latched: Vec<_> = ticks.iter().filter(|tick| tick.2).collect();
    assert_eq!(latched, [&(50_000_000, Phase::FreeFlight, true)]);
    assert_eq!(summary.latch.unwrap().time_us, 50_000_000);
}

#[test]
fn a_given_window_goes_before_the_launch_column() {
    let flight = noisy_flight(60, 10, true);
    let replay = Replay::new(&flight, &Model::default(), Some("0..40".parse().unwrap())).unwrap();
    assert_eq!(run(&replay).1.latch.unwrap().time_us, 40_000_000);
    let outside = Replay::new(&flight, &Model::default(), Some("0..400".parse().unwrap())).unwrap_err();
    assert!(outside.to_string().contains("does not lie within the flight, which goes from 0 s to 69.98 s"));
}

#[test]
fn a_given_take_off_and_landing_go_before_what_is_found() {
    let flight = noisy_flight(100, 0, false);
    let given = |calibration: Option<&str>, airborne: &str| GivenTimes {
        calibration: calibration.map(|window| window.parse().unwrap()),
        airborne: Some(airborne.parse().unwrap()),
    };
    // On the ground until 40 s, which is quiet, and nothing after 80 s.
    let replay = Replay::new(&flight, &Model::default(), given(None, "40..80")).unwrap();
    let interval = replay.extent().interval().unwrap();
    assert_eq!((interval.take_off_s, interval.landing_s), (Some(40.0), Some(80.0)));
    let CalibrationSource::Quiet(stretch) = replay.source() else { panic!("{}", replay.source()) };
    assert!(stretch.place == Place::Ground && stretch.window.end_s <= 40.0, "{stretch}");
    let last_us = replay.inputs().map(|input| input.time_us).max().unwrap();
    assert_eq!(last_us, 80_000_000, "a row at the landing belongs to the flight");
    let said = Usage::of(&replay).lines().join("; ");
    assert!(said.contains("those given") && said.contains("after the landing"), "{said}");
    // A flight that is in the air when the log begins has no ground before it.
    let replay = Replay::new(&flight, &Model::default(), given(None, "..80")).unwrap();
    assert!(!matches!(replay.source(), CalibrationSource::Quiet(QuietStretch { place: Place::Ground, .. })));
    // A diagnosis uses it as well, and a user's window may lie before it.
    let replay = Replay::to_diagnose(&flight, &Model::default(), given(Some("5..30"), "40..80")).unwrap();
    assert_eq!(replay.inputs().map(|input| input.time_us).max(), Some(80_000_000));
    let refused = |given: GivenTimes, flight: &Flight| {
        Replay::new(flight, &Model::default(), given).unwrap_err().to_string()
    };
    assert!(refused(given(Some("5..90"), "40..80"), &flight).contains("beyond the landing at 80 s"));
    assert!(refused(given(None, "40..800"), &flight).contains("which goes from 0 s to 99.98 s"));
    let launched = noisy_flight(60, 10, true);
    assert!(refused(given(None, "40..60"), &launched).contains("launch column"));
}

#[test]
fn a_given_time_in_the_air_takes_the_place_of_what_overlaps_it() {
    let mut flight = noisy_flight(100, 0, false);
    flight.time_s.iter_mut().for_each(|time_s| *time_s *= 10.0);
    let first = GivenTimes { airborne: Some("100..300".parse().unwrap()), ..GivenTimes::default() };
    let extent = Extent::of(&flight, first).unwrap();
    assert_eq!((extent.airborne.len(), extent.chosen, extent.used_s), (1, Some(0), (0.0, 300.0)));
}

#[test]
fn without_launch_the_first_quiet_stretch_is_taken() {
    let flight = noisy_flight(100, 0, false);
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    let window = replay.source().window().unwrap();
    assert_eq!(window, CalibrationWindow { start_s: 0.0, end_s: 45.0 });
    assert_eq!(run(&replay).1.latch.unwrap().time_us, 45_000_000);
}

#[test]
fn bad_samples_and_rows_are_summed_up() {
    let text = "time_s,launch,gps_alt_m,baro_alt_m\n0,0,100,50\n1,0,100,nan\n1,0,101,50\n0.5,0,101,50\n\
                2,0,inf,51\n3,0,102,52\n4,1,103,53\n5,0,104,54\n6,1,105,55\n";
    let flight = read(text);
    let summary = run(&Replay::new(&flight, &Model::default(), None).unwrap()).1;
    assert_eq!(summary.ignored_rows(), 2);
    assert_eq!(summary.not_finite_samples(), 2);
    assert_eq!(summary.held_fixes(), 1);
    assert_eq!(summary.counters.launch_repeats, 2);
    assert_eq!(summary.counters.ticks, 7);
}

#[test]
fn a_flights_own_latitude_goes_before_the_models() {
    let mut flight = noisy_flight(20, 1, true);
    let model = Model::parse("site.latitude_deg = -33.5").unwrap();
    let latitude =
        |flight: &Flight| Replay::new(flight, &model, None).map(|replay| replay.model().latitude_deg);
    assert_eq!(latitude(&flight).unwrap(), -33.5);
    flight.header.other.push(("latitude_deg".to_owned(), " 47.25".to_owned()));
    assert_eq!(latitude(&flight).unwrap(), 47.25);
    for bad in ["91", "nan", "north"] {
        flight.header.other[0].1 = bad.to_owned();
        let message = latitude(&flight).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("latitude_deg in the header is '{bad}', expected degrees from -90 to 90")
        );
    }
}

#[test]
fn refuses_flights_and_models_that_can_not_be_run() {
    let message = |flight: &Flight, model: &Model| match Replay::new(flight, model, None) {
        Err(error) => error.to_string(),
        Ok(replay) => replay.run(&mut |_, _| {}).unwrap_err().to_string(),
    };
    assert!(message(&Flight::default(), &Model::default()).contains("no column gps_alt_m"));
    let mut flight = noisy_flight(1, 1, true);
    let mut model = Model::default();
    model.reference.sigma_m = f32::NAN;
    assert!(message(&flight, &model).starts_with("gps.sigma_m is NaN"));
    model.reference.sigma_m = 1e30;
    assert!(message(&flight, &model).starts_with("the estimator refuses the model: "));
    flight.channels.retain(|(channel, _)| matches!(channel, Channel::GpsAltM | Channel::Launch));
    assert!(message(&flight, &Model::default()).starts_with("no altitude besides gps_alt_m"));
}

/// Rest at 2000 m (to a millimetre a second, else the receiver is stuck), 40 s captive and 20 s free, at this
/// rate of inertial samples and five fixes a second; `own` is the cell of `imu_slave_alt_m`.
fn inertial_flight(rate_hz: u32, own: &str) -> Flight {
    let mut text = String::from(
        "time_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,gps_time_s,baro_alt_m,imu_slave_alt_m,accel_x_mps2,accel_y_mps2,\
         accel_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps\n",
    );
    for row in 0..60 * rate_hz {
        let time_s = f64::from(row) / f64::from(rate_hz);
        let launch = u8::from(row >= 40 * rate_hz);
        let gps = if row % (rate_hz / 5) == 0 {
            format!("2000,20.00{},10,0,{time_s}", row / (rate_hz / 5) % 2)
        } else {
            ",,,,".to_owned()
        };
        text += &format!("{time_s:.4},{launch},{gps},{},{own},0,0,-9.80665,0,0,0\n", 1900 + row % 2);
    }
    read(&text)
}

#[test]
fn an_altitude_that_is_not_there_is_made_of_inertial_samples() {
    let flight = inertial_flight(50, "");
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    let made: Vec<_> = replay
        .mission_inputs()
        .filter_map(|input| input.imu_slave_altitude_m.map(|altitude_m| (input.time_us, altitude_m)))
        .collect();
    // From 20 s of alignment on, every third sample (50 ms are two and a half), or the next one where that
    // sample coincides with a fix.
    assert!((20_000_000..20_300_000).contains(&made[0].0), "{:?}", made[0]);
    let next_us =
        |time_us: u64| time_us + if (time_us + 60_000).is_multiple_of(200_000) { 80_000 } else { 60_000 };
    for pair in made.windows(2) {
        assert_eq!(pair[1].0, next_us(pair[0].0), "after {} us", pair[0].0);
    }
    assert!(made.last().is_some_and(|last| next_us(last.0) >= 60_000_000));
    // A perfect rest, apart from half the last bit of gravity over 20 s.
    assert!(made.iter().all(|(_, altitude_m)| (altitude_m - 2000.0).abs() < 0.01));
    let (_, summary) = run(&replay);
    let (counts, channel) = summary.inputs.inertial_altitude.unwrap();
    assert_eq!((counts.delivered as usize, channel.refused), (made.len(), 0));
    let captive = made.iter().filter(|(time_us, _)| *time_us < 40_000_000).count();
    assert_eq!(summary.latch.unwrap().sensors[Sensor::ImuSlave.index()].readings as usize, captive);
    // The ticks with the sensors' own values have no such altitude.
    assert!(replay.inputs().all(|input| input.imu_slave_altitude_m.is_none()));
}

#[test]
fn what_has_the_altitude_or_too_few_samples_is_flown_as_it_is() {
    for flight in [inertial_flight(50, "1234.5"), inertial_flight(45, "")] {
        let replay = Replay::new(&flight, &Model::default(), None).unwrap();
        assert!(replay.mission_inputs().eq(replay.inputs()));
        assert_eq!(run(&replay).1.inputs.inertial_altitude, None);
    }
}

#[test]
fn altitudes_of_two_datums_are_not_compared() {
    let head = "# altitude_datum: ellipsoid\n";
    let rows = "time_s,gps_alt_m,imu_slave_alt_m,baro_alt_m\n0,1,2,3\n";
    let refused = |more: &str| {
        let flight = read(&format!("{head}{more}{rows}"));
        Replay::uncalibrated(&flight, &Model::default(), None).err().map(|error| error.to_string())
    };
    // A pressure altitude is compared with any datum.
    assert_eq!(refused(""), None);
    let said = refused("# altitude_datum imu_slave_alt_m: msl\n").unwrap();
    let words = "imu_slave_alt_m is measured above mean sea level and gps_alt_m above the ellipsoid";
    assert!(said.starts_with(words) && said.contains("--to-msl gps_alt_m=GEOID_HEIGHT"), "{said}");
    assert!(refused("# altitude_datum baro_alt_m: msl\n").is_some());
    assert_eq!(refused("# altitude_datum imu_slave_alt_m: ellipsoid\n"), None);
    let typo = parse(format!("# pylon-flight: 1\n# altitude_datum baro_alt_m: mls\n{rows}").as_bytes());
    assert!(typo.unwrap_err().to_string().contains("expected msl, ellipsoid or pressure"));
}

/// The doubt of a launch is the value of its column, and holds until that changes: 1 a suspicion, 2 an
/// unconfirmed launch.
#[test]
fn the_doubt_of_a_launch_is_its_columns() {
    let ticks = inputs(
        "time_s,launch,launch_doubt,gps_alt_m,baro_alt_m\n0,0,0,1,2\n1,0,1,1,2\n2,0,,1,2\n3,1,2,1,2\n4,1,0,1,2\n",
    );
    let doubts: Vec<LaunchDoubt> = ticks.iter().map(|tick| tick.launch_doubt).collect();
    use LaunchDoubt::{None, Suspected, Unconfirmed};
    assert_eq!(doubts, [None, Suspected, Suspected, Unconfirmed, None]);
}

/// A fix without a satellite count does not count as a wrong one. Some of the accelerometer's cells alone are
/// an incomplete sample.
#[test]
fn what_is_not_there_is_no_wrong_count_and_a_part_of_a_sample_is_incomplete() {
    let flight = read(
        "time_s,gps_alt_m,gps_sats,accel_x_mps2,accel_y_mps2,accel_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps\n\
         0,5,7,1,1,,,,\n1,5,,,,,1,,\n2,5,,1,1,1,1,1,1\n3,5,,,,,,,\n",
    );
    let columns = model::formula::Columns::default();
    let mut inputs = TickInputs::new(&flight, &[], None, flight.rows(), true, &columns);
    assert_eq!(inputs.by_ref().count(), 4);
    let wanted = InputCounters { partial_imu_samples: 2, ..InputCounters::default() };
    assert_eq!(*inputs.counters(), wanted);
}

/// A column that only a formula of the model reads reaches the tick under the formula's number for it, in SI
/// units.
#[test]
fn a_formulas_column_reaches_the_tick() {
    let flight = read("time_s,gps_alt_m,baro_alt_m,duct_degc,oil_c\n0,1,2,3,20\n1,1,2,3,\n");
    let text = "[[effect_definition]]\nid = \"baro.oil\"\non = \"baro\"\nregressor = \"oil_c / 1[K] * 1[m]\"\nplausible = [-1.0, 1.0]\n\
                [[effect]]\nid = \"baro.oil\"\nsigma = 1.0\nestimate = true\n";
    let model = Model::parse(text).unwrap();
    let ticks: Vec<_> = TickInputs::new(&flight, &[], None, 2, true, model.columns()).collect();
    let mut wanted = kf_core::input::Columns::default();
    assert_eq!(ticks[1].columns, wanted);
    // 20 degrees Celsius in kelvin.
    wanted.set(0, 293.15);
    assert_eq!(ticks[0].columns, wanted);
}

/// Inertial samples at 50 Hz are enough, and two lost ones do not matter, because a log's times are rounded.
/// Neither does the clock's zero.
#[test]
fn fifty_inertial_samples_a_second_are_enough() {
    let makes = |lost: usize, zero_s: f64| {
        let mut flight = inertial_flight(50, "");
        flight.time_s.iter_mut().for_each(|time_s| *time_s += zero_s);
        let accel = flight.channels.iter_mut().find(|(channel, _)| *channel == Channel::AccelXMps2).unwrap();
        (100..100 + lost).for_each(|row| assert!(accel.1.set(row, None)));
        Replay::new(&flight, &Model::default(), None).unwrap().makes_inertial_altitude()
    };
    assert!(makes(0, 0.0) && makes(2, 0.0) && makes(2, 10_000.0));
    assert!(!makes(4, 0.0) && !makes(60, 10_000.0));
}

/// The analysed part ends with the row at the landing; it is reported in rows and in shares of the log's
/// time.
#[test]
fn rows_after_the_landing_are_counted_and_not_analysed() {
    let flight = noisy_flight(100, 0, false);
    let given = GivenTimes {
        calibration: Some("20..35".parse().unwrap()),
        airborne: Some("40..80".parse().unwrap()),
    };
    let replay = Replay::new(&flight, &Model::default(), given).unwrap();
    // Fifty rows a second, from 0 s to 80 s and from there to 99.98 s.
    assert_eq!(replay.times_s(), &flight.time_s[..4_001]);
    let inputs = run(&replay).1.inputs;
    assert_eq!((inputs.skipped_rows, inputs.rows_after), (1_000, 999));
    let usage = Usage::of(&replay);
    assert_eq!((usage.flights, usage.flight), (1, Some(1)));
    assert_eq!((usage.take_off_s, usage.landing_s), (Some(40.0), Some(80.0)));
    assert!((usage.used_share - 60.0 / 99.98).abs() < 1e-9, "{}", usage.used_share);
    assert!(usage.in_the_air().is_some());
    assert_eq!(
        noisy_flight(1, 1, true).rows(),
        Replay::new(&noisy_flight(1, 1, true), &Model::default(), None).unwrap().times_s().len()
    );
}

/// Another model flies the same part of the flight, unless its limits on calibration quality differ.
#[test]
fn another_model_takes_the_same_part_of_the_flight() {
    let flight = noisy_flight(60, 10, false);
    let window: CalibrationWindow = "5..50".parse().unwrap();
    let replay = Replay::new(&flight, &Model::default(), Some(window)).unwrap();
    let other =
        Model::parse("[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 0.1\nestimate = true").unwrap();
    let flown = replay.by_model(&other).unwrap();
    assert_eq!(flown.model().effects, other.effects);
    assert_eq!((flown.source(), flown.model().settling_s), (replay.source(), 0.0));
    assert!(flown.has_ticks_of(&replay) && replay.has_ticks_of(&flown));
    let mut stricter = Model::default();
    stricter.quality.minimum_duration_s += 1.0;
    assert!(replay.by_model(&stricter).is_none());
    let reads_more = "[[effect_definition]]\nid = \"baro.flap\"\non = \"baro\"\nregressor = \"flap * 1[m]\"\nplausible = [-1.0, 1.0]\n";
    let reads_more =
        Model::parse(&format!("{reads_more}[[effect]]\nid = \"baro.flap\"\nsigma = 1.0\nestimate = true\n"))
            .unwrap();
    assert!(replay.by_model(&reads_more).is_none());
    let with_more = Replay::new(&flight, &reads_more, Some(window)).unwrap();
    assert!(!with_more.has_ticks_of(&replay));
}

/// Two replays have the same ticks if they are of one flight, from and to the same row, with the same
/// barometer and nothing left out.
#[test]
fn ticks_are_the_same_for_the_same_part_of_the_same_flight() {
    let flight = noisy_flight(100, 0, false);
    let model = Model::default();
    let given = |window: &str, airborne: &str| GivenTimes {
        calibration: Some(window.parse().unwrap()),
        airborne: Some(airborne.parse().unwrap()),
    };
    let replay = Replay::new(&flight, &model, given("5..30", "40..80")).unwrap();
    let again = Replay::new(&flight, &model, given("5..30", "40..80")).unwrap();
    assert!(replay.has_ticks_of(&again));
    for (window, airborne) in [("5..35", "40..80"), ("5..30", "40..81")] {
        let other = Replay::new(&flight, &model, given(window, airborne)).unwrap();
        assert!(!replay.has_ticks_of(&other), "{window} {airborne}");
    }
    let copy = flight.clone();
    let other = Replay::new(&copy, &model, given("5..30", "40..80")).unwrap();
    assert!(!replay.has_ticks_of(&other));
    // A wild cell that a diagnosis leaves out and reports.
    let mut wild = flight.clone();
    let baro = wild.channels.iter_mut().find(|(channel, _)| *channel == Channel::BaroAltM).unwrap();
    baro.1.set(2_000, Some(90_000.0));
    let diagnosed = Replay::to_diagnose(&wild, &model, given("5..30", "40..80")).unwrap();
    assert_eq!(
        diagnosed.wild().iter().map(|cells| (cells.channel, cells.count)).collect::<Vec<_>>(),
        [(Channel::BaroAltM, 1)]
    );
    let plain = Replay::new(&wild, &model, given("5..30", "40..80")).unwrap();
    assert!(plain.wild().is_empty() && !diagnosed.has_ticks_of(&plain) && !plain.has_ticks_of(&diagnosed));
}

/// A diagnosis is not calibrated on a stretch in the air, which would lose what was flown before it; one on
/// the ground is kept.
#[test]
fn a_diagnosis_is_calibrated_on_the_ground_alone() {
    let flight = noisy_flight(100, 0, false);
    let given = |airborne: &str| GivenTimes { calibration: None, airborne: Some(airborne.parse().unwrap()) };
    let ground = Replay::to_diagnose(&flight, &Model::default(), given("40..80")).unwrap();
    assert!(matches!(ground.source(), CalibrationSource::Quiet(stretch) if stretch.place == Place::Ground));
    let aloft = Replay::to_diagnose(&flight, &Model::default(), given("..80")).unwrap();
    assert!(!aloft.is_calibrated(), "{}", aloft.source());
}

/// A flight that records its own launch is analysed as a whole: no take-off is looked for.
#[test]
fn a_launched_flight_is_used_as_a_whole() {
    let up = |row: u32| if (3_000..9_000).contains(&row) { 400.0 } else { 100.0 };
    let of = |launch: &str| {
        let mut text = String::from("time_s,launch,gps_alt_m,gps_vd_mps,baro_alt_m\n");
        for row in 0..12_000 {
            let fix = if row % 10 == 0 { format!("{},0", up(row)) } else { ",".into() };
            text +=
                &format!("{},{launch},{fix},{}\n", f64::from(row) * 0.05, up(row) + 1.5 * f64::from(row % 3));
        }
        read(&text)
    };
    let launched = of("0");
    let replay = Replay::uncalibrated(&launched, &Model::default(), None).unwrap();
    assert_eq!((replay.extent().airborne.len(), replay.extent().chosen), (0, None));
    assert_eq!(replay.times_s().len(), 12_000);
    let found = of("");
    let replay = Replay::uncalibrated(&found, &Model::default(), None).unwrap();
    assert_eq!((replay.extent().airborne.len(), replay.extent().chosen), (1, Some(0)));
    assert!(replay.times_s().len() < 9_100, "it lands at 450 s");
}

/// A stuck barometer is left out if there is also an inertial altitude; alone it leaves nothing to compare.
#[test]
fn a_stuck_barometer_is_left_out_or_refused() {
    let of = |inertial: &str| {
        let mut text = format!("time_s,launch,gps_alt_m,baro_alt_m{inertial}\n");
        for row in 0..200 {
            let own = if inertial.is_empty() { String::new() } else { format!(",{}", 100 + row) };
            text += &format!("{row},{},{},500{own}\n", u8::from(row > 150), 100 + row);
        }
        read(&text)
    };
    let flight = of(",imu_slave_alt_m");
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    assert!(replay.inputs().all(|tick| tick.baro.is_none() && tick.imu_slave_altitude_m.is_some()));
    let refused = Replay::new(&of(""), &Model::default(), None).unwrap_err().to_string();
    assert!(refused.starts_with("the barometer is stuck"), "{refused}");
    // Without a fault the barometer is used, with or without an inertial altitude.
    let sound = noisy_flight(20, 1, true);
    assert!(Replay::new(&sound, &Model::default(), None).unwrap().inputs().any(|tick| tick.baro.is_some()));
}

/// The state of a boxed mission is the mission's own: its time, and a snapshot from which another one can
/// continue.
#[test]
fn a_boxed_mission_is_restored_from_its_snapshot() {
    let flight = noisy_flight(40, 5, true);
    let replay = Replay::new(&flight, &Model::paper(), None).unwrap();
    let mut flown = mission(&Model::paper()).unwrap();
    for input in replay.inputs().take(2_101) {
        flown.tick(&input);
    }
    assert_eq!(flown.last_us(), 42_000_000);
    let mut bytes = [0; 4096];
    let length = flown.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
    let mut restored = mission(&Model::paper()).unwrap();
    assert_eq!(restored.restore_snapshot(&bytes[..length], &flown.mark()).unwrap(), 42_000_000);
    assert!(restored.restore_snapshot(&[1, 2, 3], &flown.mark()).is_err());
}

/// Every iterator of a flight's ticks is counted once, when its first tick is made.
#[test]
fn a_pass_is_counted_when_it_begins() {
    let flight = noisy_flight(2, 1, true);
    let replay = Replay::new(&flight, &Model::default(), None).unwrap();
    let before = passes_begun();
    let ticks = replay.inputs().count() as u64;
    let begun = passes_begun() - before;
    // Tests that run at the same time begin some too, but not one for every tick.
    assert!(begun >= 1 && begun < ticks, "{begun}");
}
