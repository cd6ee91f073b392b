use proptest::prelude::*;

use kf_core::effect::{Clock, Regressor};

use super::*;

fn message(text: &str) -> String {
    let message = Model::parse(text).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn bundled(name: &str) -> Model {
    Model::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/models").join(name)).unwrap()
}

#[test]
fn an_empty_file_is_the_default_preset() {
    assert_eq!(Model::parse("").unwrap(), Model::default());
}

#[test]
fn the_bundled_files_are_the_presets() {
    assert_eq!(bundled("default.toml"), Model::default());
    assert_eq!(bundled("paper.toml"), Model::paper());
    assert_eq!(Model::load("paper").unwrap(), Model::paper());
    assert_eq!(Model::load("default").unwrap(), Model::default());
}

#[test]
fn every_key_reaches_its_field() {
    let text = r#"
        settling_s = 1
        second_correction = "kalman"
        second_correction_wander_m_per_sqrt_s = 2
        [gps]
        sigma_m = 3
        correlation_time_s = 4
        prior_altitude_m = 5
        prior_sigma_m = 6
        climb_rate_sigma_mps = 7
        climb_rate_correlation_time_s = 8
        lost_after_s = 9
        [sensor.imu_master]
        sigma_m = 10
        [sensor.imu_slave]
        correlation_time_s = 11
        prior_bias_m = 12
        [sensor.baro]
        prior_sigma_m = 13
        wander_m_per_sqrt_s = 14
        [monitor]
        sigma = "covariance"
        multiplier = 15
        window_s = 16
        persistence_s = 16.5
        reference_check = false
        [quality]
        minimum_duration_s = 17
        trimmed_altitude_m = 18
        trimmed_airspeed_mps = 19
        reference_drift_m = 20
        minimum_satellites = 21
        vertical_accuracy_m = 22
        bias_drift_sigmas = 23
        implausible_share = 0.24
        [site]
        latitude_deg = -30
        [[effect]]
        id = "baro.warm_up"
        coefficient = -0.25
        sigma = 0.26
        estimate = true
        learned_from = "flight.csv"
        date = 2026-11-20
        time_constant_s = 27
        since = "start"
        envelope_m = [-28, 29]
        [[revision]]
        number = 1
        date = 2026-11-21
        effect = "baro.warm_up"
        learned_from = "flight.csv"
        coefficient = 35
        sigma = 36
        estimate = true
        time_constant_s = 37
        since = "start"
        replaced_coefficient = 38
        rms_before_m = 31
        rms_after_m = 32
        held_out_before_m = 33
        held_out_after_m = 34
        [[revision]]
        number = 2
    "#;
    let model = Model::parse(text).unwrap();
    let default = Model::default();
    assert_eq!(model.settling_s, 1.0);
    assert_eq!(model.second_correction, SecondCorrection::Kalman { wander_m_per_sqrt_s: 2.0 });
    assert_eq!(
        model.reference,
        ReferenceConfig {
            sigma_m: 3.0,
            correlation_time_s: 4.0,
            prior_altitude_m: Some(5.0),
            prior_sigma_m: 6.0,
            climb_rate: Some(ClimbRate { sigma_mps: 7.0, correlation_time_s: 8.0 }),
            lost_after_s: 9.0,
        }
    );
    let [master, slave, baro] = default.sensors;
    assert_eq!(
        model.sensors,
        [
            SensorConfig { sigma_m: 10.0, ..master },
            SensorConfig { correlation_time_s: 11.0, prior_bias_m: 12.0, ..slave },
            SensorConfig { prior_sigma_m: 13.0, wander_m_per_sqrt_s: 14.0, ..baro },
        ]
    );
    assert_eq!(model.monitor.sigma, SigmaSource::Covariance);
    assert_eq!([model.monitor.multiplier, model.monitor.window_s], [15.0, 16.0]);
    assert_eq!((model.monitor.persistence_s, model.monitor.reference_check), (16.5, false));
    assert_eq!(
        model.quality,
        kf_core::config::QualityConfig {
            minimum_duration_s: 17.0,
            trimmed_altitude_m: 18.0,
            trimmed_airspeed_mps: 19.0,
            reference_drift_m: 20.0,
            minimum_satellites: 21,
            vertical_accuracy_m: 22.0,
            bias_drift_sigmas: 23.0,
            implausible_share: 0.24,
        }
    );
    assert_eq!(
        model.effects,
        [Effect {
            term: EffectTerm {
                regressor: Regressor { id: EffectId::BaroWarmUp, time_constant_s: 27.0, since: Clock::Start },
                coefficient: -0.25,
                sigma: 0.26,
                envelope_m: Some([-28.0, 29.0]),
            },
            estimate: true,
            learned_from: Some("flight.csv".into()),
            date: Some("2026-11-20".into()),
        }]
    );
    assert_eq!(model.latitude_deg, -30.0);
    assert_eq!(
        model.revisions,
        [
            Revision {
                number: 1,
                date: Some("2026-11-21".into()),
                effect: Some(EffectId::BaroWarmUp),
                learned_from: Some("flight.csv".into()),
                coefficient: Some(35.0),
                sigma: Some(36.0),
                estimate: Some(true),
                time_constant_s: Some(37.0),
                since: Some(Clock::Start),
                replaced_coefficient: Some(38.0),
                rms_before_m: Some(31.0),
                rms_after_m: Some(32.0),
                held_out_before_m: Some(33.0),
                held_out_after_m: Some(34.0),
            },
            Revision {
                number: 2,
                date: None,
                effect: None,
                learned_from: None,
                coefficient: None,
                sigma: None,
                estimate: None,
                time_constant_s: None,
                since: None,
                replaced_coefficient: None,
                rms_before_m: None,
                rms_after_m: None,
                held_out_before_m: None,
                held_out_after_m: None,
            }
        ]
    );
}

#[test]
fn the_shape_follows_propagation_and_effects() {
    let effect = "[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 1\nestimate = true";
    let shape = |text: &str| {
        let shape = Model::parse(text).unwrap().shape();
        (shape.head, shape.tail, shape.effects)
    };
    assert_eq!(shape(""), (0, 4, 0));
    assert_eq!(shape(effect), (0, 5, 1));
    assert_eq!(shape("gps.propagate_climb_rate = false"), (3, 1, 0));
    assert_eq!(shape(&format!("gps.propagate_climb_rate = false\n{effect}")), (3, 2, 1));
    assert_eq!(Model::paper().shape(), crate::Shape { head: 3, tail: 1, effects: 0 });
}

#[test]
fn a_mission_is_made_for_the_models_effects() {
    let estimated =
        Model::parse("[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 1\nestimate = true").unwrap();
    assert_eq!(estimated.mission_config::<1>().unwrap().estimated_effects[0], estimated.effects[0].term);
    assert!(estimated.mission_config::<1>().unwrap().constant_effects.is_empty());
    let error = estimated.mission_config::<2>().unwrap_err().to_string();
    assert_eq!(error, "the model estimates 1 effects, the mission is made for 2");
    let constant = Model::parse("[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.1").unwrap();
    assert_eq!(constant.mission_config::<0>().unwrap().constant_effects[..], [constant.effects[0].term]);
    assert_eq!(constant.effects[0].term.sigma, 0.0);
}

#[test]
fn the_fingerprint_follows_what_flies_and_nothing_else() {
    let fingerprint = |text: &str| Model::parse(text).unwrap().fingerprint().unwrap();
    let effect = "[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 1\nestimate = true\nsigma = 1\n";
    assert_eq!(fingerprint(""), Model::default().fingerprint().unwrap());
    assert_eq!(
        fingerprint(effect),
        fingerprint(&format!("{effect}learned_from = \"x\"\n[[revision]]\nnumber = 1"))
    );
    let envelope = format!("{effect}envelope_m = [0, 9]\n");
    let warm_up = "[[effect]]\nid = \"baro.warm_up\"\ncoefficient = 1\ntime_constant_s = 9\n";
    let since = format!("{warm_up}since = \"start\"");
    let others = [
        "",
        "gps.sigma_m = 2.0000002",
        "monitor.sigma = \"covariance\"",
        "site.latitude_deg = 46",
        effect,
        &envelope,
        warm_up,
        &since,
    ];
    for (index, text) in others.iter().enumerate() {
        assert!(others[..index].iter().all(|other| fingerprint(other) != fingerprint(text)), "{text}");
    }
}

#[test]
fn unknown_names_come_with_the_nearest_known() {
    assert_eq!(
        message("[gps]\nsigm_m = 2"),
        "row 2, column 1: no key 'sigm_m' here; nearest: sigma_m, climb_rate_sigma_mps, prior_sigma_m"
    );
    assert!(
        message("[sensors.baro]").starts_with("row 1, column 2: no key 'sensors' here; nearest: sensor,")
    );
    assert!(message("[sensor.barometer]").contains("nearest: baro"));
    assert!(message("[[effect]]\nid = \"baro.dynamic_presure\"\ncoefficient = 1").starts_with(
        "row 2: no effect 'baro.dynamic_presure' in the catalogue; nearest: baro.dynamic_pressure"
    ));
    assert!(message("[monitor]\nsigma = \"residuals\"").contains("expected one of `residual`, `covariance`"));
    assert!(message("[gps]\nsigma_m = \"2\"").starts_with("row 2, column 11: invalid type: string \"2\""));
    assert!(message("[gps\n").starts_with("row 1, column"));
    let error = Model::read(Path::new("/no/such.toml")).unwrap_err().to_string();
    assert!(error.starts_with("/no/such.toml: cannot be read: "), "{error}");
}

#[test]
fn impossible_values_name_the_key() {
    let effect = "[[effect]]\nid = \"baro.dynamic_pressure\"\n";
    for (text, expected) in [
        ("settling_s = -1", "settling_s is -1, expected a finite number from 0 on"),
        ("gps.sigma_m = 0", "gps.sigma_m is 0, expected a finite number above 0"),
        ("gps.sigma_m = nan", "gps.sigma_m is NaN, expected a finite number above 0"),
        ("gps.sigma_m = 1e39", "gps.sigma_m is inf, expected a finite number above 0"),
        ("gps.prior_altitude_m = inf", "gps.prior_altitude_m is inf, expected a finite number"),
        (
            "gps.climb_rate_correlation_time_s = 0",
            "gps.climb_rate_correlation_time_s is 0, expected a finite number above 0",
        ),
        ("sensor.baro.sigma_m = -2", "sensor.baro.sigma_m is -2, expected a finite number above 0"),
        (
            "sensor.imu_slave.wander_m_per_sqrt_s = -1",
            "sensor.imu_slave.wander_m_per_sqrt_s is -1, expected a finite number from 0 on",
        ),
        ("monitor.window_s = 0", "monitor.window_s is 0, expected seconds above 0, at most a day"),
        (
            "monitor.window_s = 1e30",
            "monitor.window_s is 1000000000000000000000000000000, expected seconds above 0, at most a day",
        ),
        ("quality.implausible_share = 2", "quality.implausible_share is 2, expected a share from 0 to 1"),
        (
            "gps = { propagate_climb_rate = false, climb_rate_sigma_mps = 1 }",
            "gps.climb_rate_sigma_mps has no effect while gps.propagate_climb_rate is false; remove one of them",
        ),
        (
            "second_correction_wander_m_per_sqrt_s = 1",
            "second_correction_wander_m_per_sqrt_s has no effect while second_correction is not \"kalman\"; \
             remove one of them",
        ),
    ] {
        assert_eq!(message(text), expected);
    }
    assert_eq!(message(effect), "coefficient of effect baro.dynamic_pressure is missing, expected a number");
    assert_eq!(
        message(&format!("{effect}estimate = true")),
        "sigma of effect baro.dynamic_pressure is missing, expected a number"
    );
    assert_eq!(
        message(&format!("{effect}estimate = true\nsigma = 0")),
        "sigma of effect baro.dynamic_pressure is 0, expected a finite number above 0"
    );
    for (more, expected) in [
        (
            "time_constant_s = 3",
            "time_constant_s of effect baro.dynamic_pressure is given, expected no such key: this effect has no time constant",
        ),
        (
            "since = \"start\"",
            "since of effect baro.dynamic_pressure is given, expected no such key: this effect has no time constant",
        ),
        (
            "envelope_m = [2, 1]",
            "envelope_m's upper end of effect baro.dynamic_pressure is 1, expected a finite number from envelope_m's lower end on",
        ),
        (
            "envelope_m = [nan, 1]",
            "envelope_m's lower end of effect baro.dynamic_pressure is NaN, expected a finite number",
        ),
    ] {
        assert_eq!(message(&format!("{effect}coefficient = 1\n{more}")), expected);
    }
    let warm_up = "[[effect]]\nid = \"baro.warm_up\"\ncoefficient = 1\n";
    assert_eq!(message(warm_up), "time_constant_s of effect baro.warm_up is missing, expected a number");
    assert_eq!(
        message(&format!("{warm_up}time_constant_s = 0")),
        "time_constant_s of effect baro.warm_up is 0, expected a finite number above 0"
    );
    assert_eq!(
        message("site.latitude_deg = 91"),
        "site.latitude_deg is 91, expected a latitude from -90 to 90 degrees"
    );
    let twice = format!("{effect}coefficient = 1\n{effect}coefficient = 1");
    assert_eq!(message(&twice), "effect baro.dynamic_pressure occurs twice, expected once");
}

#[test]
fn revisions_have_numbers_of_their_own() {
    assert_eq!(
        message("[[revision]]\nnumber = 1\n[[revision]]\nnumber = 2\n[[revision]]\nnumber = 1"),
        "revision 1 in row 6 clashes with the one in row 2: give one of them another number"
    );
    assert!(message("[[revision]]\ndate = 2026-11-21").contains("missing field `number`"));
    assert!(message("[[revision]]\nnumber = -1").starts_with("row 2, column 10: "));
    assert_eq!(
        message("[[revision]]\nnumber = 1\nrms_after_m = nan"),
        "rms_after_m of revision 1 is NaN, expected a finite number"
    );
    assert!(
        message("[[revision]]\nnumber = 1\neffect = \"baro.lug\"")
            .starts_with("row 3: no effect 'baro.lug' in the catalogue; nearest: baro.lag,")
    );
}

#[test]
fn a_coefficient_that_nature_does_not_make_is_a_warning() {
    let warnings = |coefficient: &str| {
        Model::parse(&format!("[[effect]]\nid = \"baro.lag\"\ncoefficient = {coefficient}"))
            .unwrap()
            .warnings()
    };
    assert_eq!(warnings("0.2"), [""; 0]);
    assert_eq!(
        warnings("7"),
        [
            "coefficient of effect baro.lag is 7 s, outside of its physical range 0 to 5 s: check its sign and unit"
        ]
    );
    assert_eq!(warnings("-0.5").len(), 1);
}

#[test]
fn the_catalogue_in_the_readme_is_the_codes() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/models/README.md");
    let readme = std::fs::read_to_string(file).unwrap();
    for id in EffectId::ALL {
        let start = format!("| `{}` |", id.name());
        let row =
            readme.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("no row {start}"));
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [least, most] = id.plausible();
        assert_eq!(cells[3..5], [id.unit().to_owned(), format!("{least} to {most}")], "{row}");
    }
}

#[test]
fn more_effects_than_fit_are_refused() {
    let term = EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 1.0);
    let effect = Effect { term, estimate: true, learned_from: None, date: None };
    let model = Model { effects: vec![effect; 9], ..Model::default() };
    assert_eq!(model.validate().unwrap_err().to_string(), "9 estimated effects, expected at most 8");
}

proptest! {
    #[test]
    fn arbitrary_text_never_panics(text in "\\PC{0,80}", key in "[a-z_.]{0,20}", value in any::<f64>()) {
        let _ = Model::parse(&text);
        let _ = Model::parse(&format!("{key} = {value:?}"));
        let _ = Model::parse(&format!("gps.{key} = {value:?}"));
    }
}

/// A program reacts to an error's type, down to its cause, not to its wording.
#[test]
fn an_error_leads_to_its_cause() {
    use std::error::Error as _;

    let missing = Model::read(std::path::Path::new("no/such/folder/missing.toml")).unwrap_err();
    let unread = missing.source().unwrap();
    assert!(missing.to_string().ends_with(&format!("missing.toml: {unread}")), "{missing}");
    let cause = unread.source().and_then(|cause| cause.downcast_ref::<std::io::Error>()).unwrap();
    assert_eq!(cause.kind(), std::io::ErrorKind::NotFound);
    assert_eq!(unread.to_string(), format!("cannot be read: {cause}"));

    let syntax = Model::parse("settling_s = ").unwrap_err();
    assert!(syntax.source().unwrap().is::<Box<toml::de::Error>>(), "{syntax}");
    let formula = "[[effect_definition]]\nid = \"baro.x\"\non = \"baro\"\nunit = \"1\"\nplausible = [-1.0, 1.0]\nregressor = \"(\"\n";
    let formula = Model::parse(formula).unwrap_err();
    assert!(formula.source().unwrap().is::<Box<crate::formula::FormulaError>>(), "{formula}");
}
