//! The diagnosis of real IGC logs as they are, if present; see SOURCES.md beside them. Each test reports a
//! missing log. With known effects added to them: `real_injections.rs`.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use host_tests::real_logs::{
    LANDING, NEW_ZEALAND, OPTLONG, SHORT, diagnosis as diagnosed, flight as log_flight,
};
use host_tests::real_trials::part;
use pylon::diagnose::{CandidateFacts, Diagnosis, SensorDiagnosis, Verdict, text};
use pylon::flight::Flight;

fn import(name: &str) -> Option<Flight> {
    log_flight(name).unwrap()
}

fn diagnosis(flight: &Flight) -> Diagnosis {
    let diagnosis = diagnosed(flight).unwrap();
    println!("{}", text(&diagnosis, false));
    diagnosis
}

fn baro(diagnosis: &Diagnosis) -> &SensorDiagnosis {
    diagnosis.sensors.get("baro").unwrap()
}

fn candidate<'a>(diagnosis: &'a Diagnosis, effect: &str) -> &'a CandidateFacts {
    let mut candidates = diagnosis.sensors.values().flat_map(|sensor| &sensor.candidates);
    candidates.find(|candidate| candidate.effect == effect).unwrap()
}

/// Identified, or in a set that can't be distinguished.
fn holds(diagnosis: &Diagnosis, effect: &str) -> bool {
    diagnosis.missing().chain(diagnosis.suspects()).any(|said| said == effect)
}

#[test]
fn a_sailplanes_height_scale_error_is_found_and_holds() {
    let Some(flight) = import(OPTLONG) else { return };
    let diagnosis = diagnosis(&flight);
    assert!(holds(&diagnosis, "baro.scale"));
    let scale = candidate(&diagnosis, "baro.scale");
    // A regression on the first half gives -4.3 %; the air differs within 6.8 hours, by some per cent of a
    // per cent.
    let apart = (scale.coefficient + 0.043).abs();
    assert!(apart < scale.sigma.hypot(0.01), "{} +- {}", scale.coefficient, scale.sigma);
    let (before, after) = (scale.rms_before_m.unwrap(), scale.rms_after_m.unwrap());
    assert!(after < 0.4 * before, "held out: {before} m, then {after} m");
}

/// Forty minutes of a flight that begins in the air. Nothing is identified: effects of the climb rate cannot
/// be distinguished, and a static-port error differs from part to part by more than chance. It is the most
/// probable of what it could be, and each half of the log has the same one, within two sigma.
#[test]
fn a_short_log_has_a_static_port_error_that_its_halves_agree_on() {
    let Some(flight) = import(SHORT) else { return };
    let diagnosed = diagnosis(&flight);
    assert_eq!(diagnosed.verdict, Verdict::Indistinguishable);
    assert_eq!(diagnosed.missing().count(), 0);
    let sets = &baro(&diagnosed).indistinguishable;
    assert!(sets.iter().any(|set| set[0] == "baro.dynamic_pressure"), "{sets:?}");
    // Rows after the landing belong to neither half.
    let end = flight.time_s.partition_point(|time_s| *time_s < 2370.0);
    let [one, other] = [0..end / 2, end / 2..end].map(|rows| {
        let of = diagnosis(&part(&flight, rows));
        let found = candidate(&of, "baro.dynamic_pressure");
        (found.coefficient, found.sigma)
    });
    assert!((one.0 - other.0).abs() < 2.0 * one.1.hypot(other.1), "{one:?}, {other:?}");
}

/// With only one sensor, a late barometer and an early receiver are indistinguishable.
#[test]
fn lags_of_one_sensor_are_not_pinned_on_it() {
    for (name, range_s) in [(NEW_ZEALAND, 0.5..2.0), (LANDING, 0.4..1.0)] {
        let Some(flight) = import(name) else { continue };
        let diagnosis = diagnosis(&flight);
        assert!(holds(&diagnosis, "baro.lag") && holds(&diagnosis, "gps.latency"), "{name}");
        assert!(!baro(&diagnosis).lacks("baro.lag"), "{name}");
        let lag_s = candidate(&diagnosis, "baro.lag").coefficient;
        assert!(range_s.contains(&lag_s), "{name}: {lag_s} s");
    }
}

/// A paraglider's ten hours, with a clock that is seconds off. Beside that, a scale that is more probable than
/// nothing is reported as just that: alone, with its own probability and that of nothing, and not as one of
/// two of which the other is next to impossible.
#[test]
fn what_may_be_nothing_is_reported_with_its_probability() {
    let Some(flight) = import("../igc_many/goigc2_2024-06-05-xct-rsu-01.igc") else { return };
    let diagnosis = diagnosis(&flight);
    assert_eq!(diagnosis.missing().collect::<Vec<_>>(), ["baro.lag"]);
    let sets: Vec<_> = baro(&diagnosis).sets().collect();
    let [set] = sets.as_slice() else { panic!("{sets:?}") };
    assert_eq!(set.effects, ["baro.scale"]);
    let (scale, nothing) = (set.probabilities[0], set.nothing.unwrap());
    assert!(scale > 0.5 && nothing < 0.5 && (0.9..1.0 + 1e-9).contains(&(scale + nothing)), "{set:?}");
    let advice = &baro(&diagnosis).advice;
    assert!(advice.starts_with("Either baro.scale acts, or nothing does. No short manoeuvre"), "{advice}");
    // Within a place and over all sets, the effect's probability is nearly the same.
    let acts = candidate(&diagnosis, "baro.scale").probability.unwrap();
    assert!((acts - scale).abs() < 0.05, "{acts} {scale}");
}
