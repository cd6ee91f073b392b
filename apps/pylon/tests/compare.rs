//! `compare` on generated flights whose errors are known.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use common::{MODEL, ROWS_PER_FIX, ROWS_PER_S, Recipe, dive_mps};
use model::Model;
use pylon::compare::{Comparison, Manoeuvre, Options, RuleRequirements, compare};
use pylon::flight::Flight;
use pylon::replay::Replay;

fn model() -> Model {
    Model::parse(MODEL).unwrap()
}

fn compared_by(flight: &Flight, model: &Model) -> Comparison {
    let replay = Replay::new(flight, model, None).unwrap();
    compare(&replay, &Options::default(), &mut |_| {}).unwrap().0
}

fn compared(recipe: &Recipe) -> Comparison {
    compared_by(&recipe.make(), &model())
}

#[test]
fn biases_and_spreads_are_those_put_in() {
    let recipe = Recipe::default();
    let comparison = compared(&recipe);
    for (index, name) in ["imu_master", "imu_slave", "baro"].into_iter().enumerate() {
        let sensor = &comparison.sensors[name];
        // The held fix adds its own noise, which every block of ten readings shares.
        let readings = 70.0 * ROWS_PER_S;
        let spread = recipe.white_m[index].hypot(recipe.gps_m);
        let bias_sigma = (recipe.white_m[index].powi(2) / readings
            + recipe.gps_m.powi(2) / (readings / ROWS_PER_FIX as f64))
            .sqrt();
        let bias = sensor.bias_m.unwrap();
        assert!((bias - recipe.biases_m[index]).abs() < 4.0 * bias_sigma, "{name}: {bias} +- {bias_sigma}");
        let mean_error = sensor.captive.bias_standard_error_m.unwrap();
        assert!((mean_error / bias_sigma - 1.0).abs() < 0.35, "{name}: {mean_error} {bias_sigma}");
        // The fix's part of the spread has a tenth of the independent values.
        let spread_sigma = 2.0 * spread / (2.0 * readings / ROWS_PER_FIX as f64).sqrt();
        for got in [sensor.residual_sigma_m, sensor.captive.spread_m, sensor.captive_rms_m] {
            assert!((got.unwrap() - spread).abs() < 4.0 * spread_sigma, "{name}: {got:?} {spread}");
        }
        let robust = sensor.captive.robust_spread_m.unwrap();
        assert!((robust - spread).abs() < 6.0 * spread_sigma, "{name}: {robust} {spread}");
    }
    assert_eq!(comparison.calibration.quality.as_deref(), Some("good"), "{:?}", comparison.calibration);
    assert_eq!(comparison.launch_s, Some(80.0));
    assert!(comparison.warnings.is_empty(), "{:?}", comparison.warnings);
}

#[test]
fn correlation_and_whiteness_are_those_put_in() {
    let recipe = Recipe {
        captive_s: 1_210.0,
        free_s: 2.0,
        baro_correlated: (2.0, 1.0),
        gps_m: 0.001,
        white_m: [0.5, 1.0, 1e-3],
        ..Recipe::default()
    };
    let comparison = compared(&recipe);
    let time_s = |name: &str| comparison.sensors[name].captive.correlation_time_s.unwrap();
    // A first-order process of 1 s has an integrated time of 2 s; 1,200 s determine it to sqrt(2 (2 * 5 * 2 +
    // ...) / 1200) = 18 %. White noise: one reading.
    assert!((time_s("baro") / 2.0 - 1.0).abs() < 4.0 * 0.18, "{}", time_s("baro"));
    assert!((time_s("imu_slave") * ROWS_PER_S - 1.0).abs() < 0.3, "{}", time_s("imu_slave"));
    let white = |name: &str| comparison.sensors[name].captive.error_whiteness.unwrap();
    assert!(white("imu_slave").p_value > 1e-3, "{:?}", white("imu_slave"));
    assert!(white("baro").p_value < 1e-6 && white("baro").lag_one > 0.9, "{:?}", white("baro"));
}

#[test]
fn innovations_of_a_matching_model_are_consistent_and_of_another_are_not() {
    let recipe = Recipe { gps_m: 0.02, captive_s: 200.0, ..Recipe::default() };
    let flight = recipe.make();
    let matching = Model::parse(&MODEL.replacen("sigma_m = 0.3", "sigma_m = 0.02", 1)).unwrap();
    let nis = |model: &Model| compared_by(&flight, model).sensors["imu_slave"].captive.nis.unwrap();
    let right = nis(&matching);
    // 9,500 innovations: the mean of chi-squared with one degree has sigma sqrt(2 / 9500) = 1.5 %.
    assert!((right.mean - 1.0).abs() < 4.0 * 0.015, "{right:?}");
    let mut optimistic = matching;
    optimistic.sensors[1].sigma_m = 0.5;
    let wrong = nis(&optimistic);
    assert!((wrong.mean - 4.0).abs() < 0.4 && !wrong.is_consistent(), "{wrong:?}");
}

#[test]
fn a_step_is_flagged_when_it_happens_and_measured() {
    let recipe =
        Recipe { baro_error: |after_s, _| if after_s >= 30.0 { 10.0 } else { 0.0 }, ..Recipe::default() };
    let baro = &compared(&recipe).sensors["baro"];
    let bound = baro.bound_m.unwrap();
    let sigma = recipe.white_m[2].hypot(recipe.gps_m);
    assert!((bound - 4.0 * sigma).abs() < 0.1 * bound, "{bound}");
    assert!((baro.doubtful_after_s.unwrap() - 30.0).abs() < 1e-6, "{:?}", baro.doubtful_after_s);
    // The average passes the alarm limit after this part of the 2 s; it is made of 32 bins, and noisy. The
    // error must also have lasted for the persistence.
    let delay = (2.0 * bound / 10.0).max(f64::from(Model::default().monitor.persistence_s));
    let after = baro.untrustworthy_after_s.unwrap() - 30.0;
    assert!((after - delay).abs() < 2.0 / 32.0 + 0.1, "{after} {delay}");
    let readings = 1_500.0_f64;
    let rms = (50.0 + sigma * sigma).sqrt();
    assert!((baro.free_flight_rms_m.unwrap() - rms).abs() < 4.0 * sigma / readings.sqrt() * 3.0);
    assert!((baro.free_flight.bias_m.unwrap() - 5.0).abs() < 0.1);
    assert!((baro.moving_average_end_m.unwrap() - 10.0).abs() < 4.0 * sigma / 10.0);
    assert_eq!(baro.trust, "untrustworthy");
}

#[test]
fn the_worst_stretch_is_where_the_error_was_put() {
    let recipe = Recipe {
        climb_mps: dive_mps,
        baro_error: |_, climb_mps| if climb_mps < 0.0 { 25.0 } else { 0.0 },
        slave_error: |after_s| if (40.0..50.0).contains(&after_s) { -15.0 } else { 0.0 },
        ..Recipe::default()
    };
    let comparison = compared(&recipe);
    let worst = |name: &str| comparison.failures.worst.iter().find(|stretch| stretch.sensor == name).unwrap();
    let baro = worst("baro");
    assert_eq!(baro.doing, Manoeuvre::Dive);
    assert!((baro.from_s - 10.0).abs() <= 1.0 && (baro.to_s - 25.0).abs() <= 1.0, "{baro:?}");
    assert!((baro.motion.climb_rate_mps.unwrap() + 30.0).abs() < 3.0);
    assert!((baro.motion.speed_mps.unwrap() - 60.0).abs() < 0.1);
    assert!((baro.mean_m - 25.0).abs() < 3.0, "{baro:?}");
    assert!(baro.share_of_squared_error > 0.98);
    let slave = worst("imu_slave");
    assert_eq!(slave.doing, Manoeuvre::LevelFlight);
    assert!(slave.from_s <= 40.0 && slave.to_s >= 50.0, "{slave:?}");
    assert!(comparison.failures.missing.iter().any(|line| line.starts_with("load factor unknown")));
    let seconds: f64 = comparison.failures.by_manoeuvre.iter().map(|kind| kind.seconds).sum();
    assert!((seconds - 60.0).abs() < 1e-9);
}

#[test]
fn second_corrections_take_a_slow_error_off_and_the_flown_one_is_the_main_result() {
    let recipe = Recipe { slave_error: |after_s| 0.5 * after_s, ..Recipe::default() };
    let flight = recipe.make();
    for flown in ["off", "moving_average", "kalman"] {
        let model = Model::parse(&format!("second_correction = \"{flown}\"\n{MODEL}")).unwrap();
        let comparison = compared_by(&flight, &model);
        let names: Vec<_> = comparison.remedies.iter().map(|remedy| &*remedy.second_correction).collect();
        assert_eq!(names, ["none", "moving_average", "kalman"]);
        let rms: Vec<f64> = comparison.remedies.iter().map(|remedy| remedy.sensors[0].rms_m).collect();
        // 0.5 m/s over 60 s: rms 30 / sqrt(3). The average lags by 1 s, 0.5 m, and has its own noise.
        assert!((rms[0] - 17.3).abs() < 0.2, "{rms:?}");
        assert!(rms[1] < 1.3 && rms[2] < 1.5, "{rms:?}");
        let index = ["off", "moving_average", "kalman"].iter().position(|name| *name == flown).unwrap();
        assert_eq!(comparison.sensors["imu_slave"].free_flight_rms_m, Some(rms[index]), "{flown}");
    }
}

#[test]
fn the_rule_that_is_recommended_holds_on_other_flights() {
    // A rule recommended on one flight for two false alarms an hour; then twenty other healthy flights of 36
    // s.
    let recipe = |seed| Recipe { seed, baro_correlated: (0.5, 0.4), free_s: 36.0, ..Recipe::default() };
    let flight = recipe(1).make();
    let model = model();
    let replay = Replay::new(&flight, &model, None).unwrap();
    let requirements = RuleRequirements { false_alarms_per_hour: 2.0, ..RuleRequirements::default() };
    let options = Options { requirements, ..Options::default() };
    let rules = compare(&replay, &options, &mut |_| {}).unwrap().0.rules;
    let advice = rules["baro"].recommended.as_ref().unwrap();
    assert!((advice.quality.false_alarms_per_hour / 2.0).ln().abs() < 0.4, "{advice:?}");
    let mut careful = model.clone();
    careful.monitor.multiplier = advice.multiplier as f32;
    careful.monitor.window_s = advice.window_s as f32;
    let alarms = (2..22)
        .filter(|&seed| {
            compared_by(&recipe(seed).make(), &careful).sensors["baro"].untrustworthy_after_s.is_some()
        })
        .count() as f64;
    // Expected: 0.4 in 720 s, and the first windows; Poisson.
    let expected = 20.0 * (0.02 + advice.quality.healthy_alarm_in_first_window);
    assert!(alarms <= expected + 4.0 * expected.sqrt(), "{alarms} alarms, expected {expected}");
}

#[test]
fn effects_are_said_with_their_coefficients() {
    let flight = Recipe { baro_error: |_, _| 0.1 * 60.0 * 60.0 / 19.613_3, ..Recipe::default() }.make();
    let with = |effect: &str| {
        let model =
            Model::parse(&format!("{MODEL}\n[[effect]]\nid = \"baro.dynamic_pressure\"\n{effect}")).unwrap();
        compared_by(&flight, &model)
    };
    // The airspeed never changes, so captive flight contains no information about the coefficient: the
    // prior's value and sigma stay, and the bias absorbs the error.
    let estimated = with("estimate = true\nsigma = 0.05\n");
    let fact = &estimated.effects[0];
    assert!(fact.estimated && fact.effect == "baro.dynamic_pressure" && fact.unit == "1");
    assert!(fact.coefficient.abs() < 0.05 && (fact.sigma - 0.05).abs() < 0.01, "{fact:?}");
    let constant = with("coefficient = 0.07\nsigma = 0.01\n");
    let fact = &constant.effects[0];
    assert!(!fact.estimated && (fact.coefficient - 0.07).abs() < 1e-6 && (fact.sigma - 0.01).abs() < 1e-6);
    assert!(
        pylon::compare::text(&constant, false)
            .contains("Effect baro.dynamic_pressure: 0.070 ± 0.010, constant in the model.")
    );
}

#[test]
fn an_extrapolated_coefficient_is_said_by_its_effect() {
    let flight = Recipe::default().make();
    let with = |ends_m: &str| {
        let effects = format!(
            "[[effect]]\nid = \"baro.drift\"\ncoefficient = 0.001\n[[effect]]\nid = \"baro.dynamic_pressure\"\n\
             coefficient = 0.01\nenvelope_m = [{ends_m}]\n"
        );
        compared_by(&flight, &Model::parse(&format!("{MODEL}\n{effects}")).unwrap())
    };
    // 60 m/s: 183.5 m, at every reading.
    let outside = with("10, 100");
    assert_eq!(outside.effects[0].extrapolated_ticks, 0);
    let fact = &outside.effects[1];
    assert_eq!(fact.envelope_m, Some([10.0, 100.0]));
    let readings = outside.sensors["baro"].readings.accepted;
    assert!(fact.extrapolated_ticks > 1_000 && fact.extrapolated_ticks <= readings, "{fact:?}");
    let text = pylon::compare::text(&outside, false);
    assert!(text.contains("ticks: its regressor was 10.00 to 100.0 m when it was learned"), "{text}");
    assert!(text.contains("readings were corrected by an effect outside of the range"), "{text}");
    let inside = with("100, 200");
    assert_eq!(inside.effects[1].extrapolated_ticks, 0);
    assert!(!pylon::compare::text(&inside, false).contains("extrapolated"));
}

#[test]
fn json_has_the_agreed_keys_and_no_number_that_is_none() {
    let comparison = compared(&Recipe::default());
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["launch_s"], 80.0);
    assert_eq!(json["calibration"]["quality"], "good");
    assert_eq!(json["calibration"]["failed_checks"], serde_json::json!([]));
    for name in ["imu_master", "imu_slave", "baro"] {
        for key in [
            "bias_m",
            "bias_sigma_m",
            "residual_sigma_m",
            "captive_rms_m",
            "free_flight_rms_m",
            "moving_average_end_m",
            "doubtful_after_s",
            "untrustworthy_after_s",
        ] {
            let value = json["sensors"][name].get(key).unwrap_or_else(|| panic!("{name}.{key}"));
            let is_captive = ["bias_m", "bias_sigma_m", "residual_sigma_m", "captive_rms_m"].contains(&key);
            assert!(if is_captive { value.is_number() } else { value.is_number() || value.is_null() });
        }
    }
    assert!(json["sensors"]["imu_master"]["free_flight_rms_m"].is_null());
    assert!(json["sensors"]["baro"]["doubtful_after_s"].is_null());
}

#[test]
fn without_a_launch_everything_after_it_is_null() {
    let comparison = compared(&Recipe { free_s: 0.0, ..Recipe::default() });
    let json = serde_json::to_value(&comparison).unwrap();
    assert!(json["launch_s"].is_null() && json["calibration"]["quality"].is_null());
    let baro = &comparison.sensors["baro"];
    assert!((baro.bias_m.unwrap() - 20.0).abs() < 0.3);
    assert_eq!((baro.free_flight_rms_m, baro.doubtful_after_s, &*baro.trust), (None, None, "calibrating"));
    assert!(comparison.remedies.is_empty() && comparison.failures.worst.is_empty());
    assert!(comparison.warnings.iter().any(|line| line.starts_with("no launch")));
}

/// The whole text, for a generated flight with a dive, a fault and a gap in its measurements.
#[test]
fn the_text_stays_as_it_is() {
    let recipe = Recipe {
        climb_mps: dive_mps,
        baro_correlated: (0.4, 0.5),
        baro_error: |_, climb_mps| if climb_mps < 0.0 { 25.0 } else { 0.0 },
        slave_error: |after_s| 0.05 * after_s,
        ..Recipe::default()
    };
    let mut comparison = compared(&recipe);
    comparison.flight.file = "made.csv".to_owned();
    comparison.model = "made.toml".to_owned();
    let plain = pylon::compare::text(&comparison, false);
    insta::assert_snapshot!(plain);
    assert!(plain.lines().all(|line| line.chars().count() <= 140), "{plain}");
    let coloured = pylon::compare::text(&comparison, true);
    assert!(coloured.contains("\u{1b}[") && !plain.contains('\u{1b}'));
}

#[test]
fn without_the_reference_the_sensors_disagreement_is_said() {
    use pylon::flight::Channel;

    let recipe = |slave_error| Recipe { free_s: 40.0, slave_error, ..Recipe::default() };
    let compared_without = |slave_error: fn(f64) -> f64| {
        let mut flight = recipe(slave_error).make();
        let mut fixes = flight.channel(Channel::GpsAltM).unwrap().clone();
        for (row, time_s) in flight.time_s.iter().enumerate() {
            if (90.0..110.0).contains(time_s) {
                assert!(fixes.set(row, None));
            }
        }
        flight.set_channel(Channel::GpsAltM, fixes);
        compared_by(&flight, &model())
    };
    assert_eq!(compared(&recipe(|_| 0.0)).cross_check, None, "never lost");
    let agreeing = compared_without(|_| 0.0);
    let check = agreeing.cross_check.clone().unwrap();
    assert_eq!((&*check.agreement, check.doubtful_after_s, check.disagree_after_s), ("agree", None, None));
    assert!(
        pylon::compare::text(&agreeing, false).contains("Without the reference baro and imu_slave agree")
    );
    // From 15 s after launch the inertial altitude is off by far more than both alarm limits.
    let disagreeing = compared_without(|after_s| if after_s < 15.0 { 0.0 } else { 1_000.0 });
    let check = disagreeing.cross_check.clone().unwrap();
    assert_eq!(check.agreement, "disagree");
    assert!((check.doubtful_after_s.unwrap() - 15.0).abs() < 0.1, "{check:?}");
    assert!(check.disagree_after_s.unwrap() >= 15.0 && check.disagree_after_s.unwrap() < 20.0, "{check:?}");
    assert!((check.largest_difference_m + 1_000.0).abs() < 200.0, "baro less inertial: {check:?}");
    assert!(pylon::compare::text(&disagreeing, false).contains("nothing shows which"));
}
