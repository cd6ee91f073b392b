//! Whole flights with chosen errors: the results are known beforehand.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::sync::Arc;

use executor::Inline;
use flight_data::Flight;
use model::Model;
use replay::Replay;

use crate::compare::{Comparison, Options, Traces, compare};
use crate::diagnose::{
    Diagnosis, NamedReplay, Term, Verdict, WantedEffect, diagnose, diagnose_further, study, study_remembering,
};
use crate::discover::{discover, id};
use crate::learn::learn;

const GRAVITY_MPS2: f64 = 9.806_65;
/// When the flights are launched, and how long they are, seconds.
const LAUNCH_S: f64 = 100.0;
const LENGTH_S: f64 = 280.0;
/// The barometer's bias, metres.
const BIAS_M: f64 = 3.0;

/// Pseudo-random numbers between -1 and 1: a generator of Numerical Recipes.
fn noise(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1_u32 << 23) - 1.0
    }
}

/// A moment of a flight.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    airspeed_mps: f64,
    climb_mps: f64,
    throttle: f64,
}

/// Airspeed, climb and throttle move with different periods.
fn moment(time_s: f64) -> Moment {
    Moment {
        time_s,
        airspeed_mps: 35.0 + 10.0 * (time_s / 7.0).sin(),
        climb_mps: 4.0 * (time_s / 11.0).sin(),
        throttle: 0.5 + 0.4 * (time_s / 4.3).cos(),
    }
}

/// A flight at 10 Hz with five fixes a second and an error of the barometer in addition to its bias and a
/// noise of +-0.2 m. `has_climb_rate`: whether the receiver gives the climb rate.
fn flight(has_climb_rate: bool, seed: u32, error_m: impl Fn(Moment) -> f64) -> Flight {
    let mut random = noise(seed);
    let mut csv =
        "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m,tas_mps,throttle\n".to_owned();
    for row in 0..(LENGTH_S * 10.0) as u32 {
        let time_s = f64::from(row) * 0.1;
        let now = moment(time_s);
        let altitude_m = 1_500.0 + 44.0 * (1.0 - (time_s / 11.0).cos());
        let fix = if row % 2 == 0 {
            let down = if has_climb_rate {
                format!("{:.3}", -now.climb_mps + 0.02 * random())
            } else {
                String::new()
            };
            format!("{:.3},{:.3},0,{down}", altitude_m + 0.1 * random(), now.airspeed_mps)
        } else {
            ",,,".to_owned()
        };
        let baro_m = altitude_m + BIAS_M + error_m(now) + 0.2 * random();
        let launch = u8::from(time_s >= LAUNCH_S);
        let _ = writeln!(
            csv,
            "{time_s:.1},{launch},{fix},{baro_m:.3},{:.3},{:.4}",
            now.airspeed_mps, now.throttle
        );
    }
    flight_data::parse(csv.as_bytes()).unwrap().0
}

/// Error of a static port that picks up a part of the dynamic pressure, metres.
fn dynamic_pressure_m(part: f64) -> impl Fn(Moment) -> f64 {
    move |now| part * now.airspeed_mps * now.airspeed_mps / (2.0 * GRAVITY_MPS2)
}

fn compared(flight: &Flight) -> (Comparison, Box<Traces>) {
    let replay = Replay::new(flight, &Model::default(), None).unwrap();
    let options = Options { trace_slots: Some(50), ..Options::default() };
    let (comparison, traces) = compare(&replay, &options, &mut |_| (), &Inline).unwrap();
    (comparison, traces.unwrap())
}

/// The replays of flights, in the form for a diagnosis.
fn named<'a>(flights: &'a [Flight], model: &Model) -> Vec<NamedReplay<'a>> {
    let replay = |flight| NamedReplay::new("a".to_owned(), Replay::to_diagnose(flight, model, None).unwrap());
    flights.iter().map(replay).collect()
}

fn diagnosed(flights: &[Flight]) -> Diagnosis {
    let mut progress = || ControlFlow::Continue(());
    diagnose(&named(flights, &Model::default()), &[], &mut progress, &Inline).unwrap()
}

/// A barometer that is correct except for its bias has that bias, and errors of its noise alone. One that
/// reads 40 m more from the launch on has that error, is found untrustworthy within seconds, and fails in
/// everything that is flown.
#[test]
fn a_comparison_says_the_error_that_is_there() {
    let (right, _) = compared(&flight(true, 1, |_| 0.0));
    let baro = &right.sensors["baro"];
    assert_eq!((right.launch_s, right.flight.rows, &*baro.trust), (Some(LAUNCH_S), 2_800, "trusted"));
    assert!((right.flight.duration_s - 279.9).abs() < 1e-9);
    assert!((baro.bias_m.unwrap() - BIAS_M).abs() < 0.2, "{baro:?}");
    // Uniform noise of +-0.2 m has a sigma of 0.115 m; the reference's estimate adds to it.
    for rms_m in [baro.captive_rms_m, baro.free_flight_rms_m] {
        assert!((0.1..0.35).contains(&rms_m.unwrap()), "{baro:?}");
    }
    assert_eq!((baro.untrustworthy_after_s, baro.doubtful_after_s, baro.unmonitored_s), (None, None, 0.0));
    let leaps = flight(true, 1, |now| if now.time_s >= LAUNCH_S { 40.0 } else { 0.0 });
    let (wrong, traces) = compared(&leaps);
    let baro = &wrong.sensors["baro"];
    assert!((baro.free_flight_rms_m.unwrap() - 40.0).abs() < 0.3, "{baro:?}");
    assert!((baro.moving_average_end_m.unwrap().abs() - 40.0).abs() < 0.3, "{baro:?}");
    assert!((baro.bias_m.unwrap() - BIAS_M).abs() < 0.2, "{baro:?}");
    assert_eq!(&*baro.trust, "untrustworthy");
    assert!(baro.untrustworthy_after_s.is_some_and(|after_s| (0.0..60.0).contains(&after_s)), "{baro:?}");
    let failures = &wrong.failures;
    let seconds: f64 = failures.by_manoeuvre.iter().map(|all| all.seconds).sum();
    assert!((seconds - 180.0).abs() <= 1.0, "{seconds}");
    for errors in failures.by_manoeuvre.iter().flat_map(|all| &all.sensors).filter_map(|(_, errors)| *errors)
    {
        assert!((errors.mean_m.abs() - 40.0).abs() < 0.3 && (errors.rms_m - 40.0).abs() < 0.3, "{errors:?}");
    }
    for worst in &failures.worst {
        assert!(
            (worst.rms_m - 40.0).abs() < 0.3 && worst.to_s > worst.from_s && worst.to_s <= 181.0,
            "{worst:?}"
        );
        // Errors are alike throughout, so a stretch's share of their squares is its share of the time.
        assert!(
            (worst.share_of_squared_error - (worst.to_s - worst.from_s) / 180.0).abs() < 0.02,
            "{worst:?}"
        );
    }
    assert!(!failures.worst.is_empty());
    assert!(!format!("{traces:?}").is_empty());
}

/// A part of the dynamic pressure is identified with its coefficient, size and range; the remainder is the
/// noise.
#[test]
fn a_static_ports_error_is_identified_with_its_coefficient() {
    let part = -0.1;
    let found = diagnosed(&[flight(true, 2, dynamic_pressure_m(part))]);
    assert_eq!(found.verdict, Verdict::Identified, "{found:?}");
    assert_eq!(found.missing().collect::<Vec<_>>(), ["baro.dynamic_pressure"]);
    let baro = &found.sensors["baro"];
    let facts = &baro.candidates[0];
    assert!(facts.chosen && facts.effect == "baro.dynamic_pressure" && facts.p_value < 1e-6, "{facts:?}");
    assert!(
        (facts.coefficient - part).abs() < 3.0 * facts.sigma && facts.sigma < 0.1 * part.abs(),
        "{facts:?}"
    );
    // From 25 m/s to 45 m/s: 31.9 m to 103.3 m of dynamic pressure.
    let [least, most] = facts.envelope_m;
    assert!((least - 31.9).abs() < 0.5 && (most - 103.3).abs() < 0.5, "{facts:?}");
    // The spread of V^2/(2g) by a sine of the speed: 35 + 10 s squared has a variance of 700^2/2 + 100^2/8.
    let spread_m = (700.0_f64 * 700.0 / 2.0 + 100.0 * 100.0 / 8.0).sqrt() / (2.0 * GRAVITY_MPS2);
    assert!((facts.size_m - 0.1 * spread_m).abs() < 0.15 * 0.1 * spread_m, "{facts:?} {spread_m}");
    let (before_m, after_m) = (facts.rms_before_m.unwrap(), facts.rms_after_m.unwrap());
    assert!(before_m > 1.5 && after_m < 0.3 && after_m < before_m, "{facts:?}");
    let flown = &found.flights[0];
    // The last row is later than the last fix.
    assert_eq!((flown.block_s, flown.unreferenced_readings, flown.refused_readings), (1.0, 1, 0));
    assert!((270..=282).contains(&flown.blocks), "{}", flown.blocks);
    assert!(flown.glitches.is_empty() && flown.fault.is_none());
    // What was not tried lacks columns; nothing is computed from inertial samples here.
    assert!(
        !found.untested.is_empty() && found.untested.iter().all(|one| one.reason.is_none()),
        "{:?}",
        found.untested
    );
}

/// Where nothing acts, nothing is found; where a shape that belongs to no effect acts, something unknown is
/// found.
#[test]
fn nothing_is_found_where_nothing_acts() {
    let found = diagnosed(&[flight(true, 3, |_| 0.0)]);
    assert_eq!(found.missing().count(), 0, "{found:?}");
    assert!(
        matches!(found.verdict, Verdict::NoSignificantMisfit | Verdict::InsufficientExcitation),
        "{found:?}"
    );
    let unknown = diagnosed(&[flight(true, 3, |now| if now.throttle > 0.6 { 4.0 } else { 0.0 })]);
    assert_ne!(unknown.verdict, Verdict::NoSignificantMisfit, "{unknown:?}");
}

/// Without a climb rate from the receiver the path itself must be estimated; the static-port error is found
/// all the same.
#[test]
fn without_a_climb_rate_the_same_is_found() {
    let found = diagnosed(&[flight(false, 4, dynamic_pressure_m(-0.1))]);
    let baro = &found.sensors["baro"];
    let facts = baro.candidates.iter().find(|facts| facts.effect == "baro.dynamic_pressure").unwrap();
    assert!((facts.coefficient + 0.1).abs() < 3.0 * facts.sigma && facts.sigma < 0.05, "{facts:?}");
    assert!(
        found.missing().chain(found.suspects()).any(|effect| effect == "baro.dynamic_pressure"),
        "{found:?}"
    );
    assert!(facts.probability.is_none_or(|probability| probability > 0.5), "{facts:?}");
}

/// A study ends in a problem whose term is the wanted effect.
#[test]
fn a_study_ends_in_the_wanted_effects_problem() {
    let flights = [flight(true, 5, dynamic_pressure_m(-0.1))];
    let model = Model::default();
    let effect = model.effect_named("baro.dynamic_pressure").unwrap();
    let wanted = WantedEffect { effect, time_constant_s: None, since: None };
    let mut progress = || ControlFlow::Continue(());
    let named = named(&flights, &model);
    let (_, problem) = study(&named, &[], wanted, &mut progress, &Inline).unwrap();
    let problem = problem.unwrap();
    // Ten readings a second are a full block.
    assert_eq!(problem.flights[0].full_block[2], 10.0);
    // What a diagnosis has done is not repeated. For an effect that it has tried only in the catalogue's
    // shape, all of it is reused.
    let (_, further) = diagnose_further(&named, &[], &mut progress, &Inline).unwrap();
    let mut steps = 0;
    let mut counted = || {
        steps += 1;
        ControlFlow::Continue(())
    };
    let work = further.unwrap().work;
    let scale = WantedEffect { effect: model.effect_named("baro.scale").unwrap(), ..wanted };
    study_remembering(Some(&work), &named, &[], scale, &mut counted, &Inline).unwrap();
    assert_eq!(steps, 1);
    let (_, again) = study_remembering(Some(&work), &named, &[], wanted, &mut progress, &Inline).unwrap();
    assert!(
        (again.unwrap().facts.coefficient - problem.facts.coefficient).abs() < 0.01 * problem.facts.sigma
    );
    assert_eq!(problem.terms[0].regressor.id, effect);
    // A second term that acts on nothing does not change the first.
    let mut with_another = problem.clone();
    let flight = &mut with_another.flights[0];
    let idle = |block: usize| std::array::from_fn(|i| if i == 2 { (block as f64 / 5.3).sin() } else { 0.0 });
    with_another.terms.push(Term { column: flight.columns.len(), ..with_another.terms[0] });
    flight.columns.push(Arc::new((0..flight.len()).map(idle).collect()));
    let (alone, beside) = (learn(&problem).unwrap(), learn(&with_another).unwrap());
    assert!((beside.coefficient - alone.coefficient).abs() < alone.sigma, "{beside:?} {alone:?}");
    // The flight computer's filter, in single precision, learns the same as the diagnosis' least squares.
    let learned = learn(&problem).unwrap();
    let facts = &problem.facts;
    assert!((learned.coefficient + 0.1).abs() < 3.0 * learned.sigma && learned.sigma < 0.02, "{learned:?}");
    assert!((learned.coefficient - facts.coefficient).abs() < 0.3 * facts.sigma, "{learned:?} {facts:?}");
    assert!(
        (learned.sigma / facts.sigma - 1.0).abs() < 0.2 && learned.filter_sigma <= learned.sigma,
        "{learned:?} {facts:?}"
    );
}

/// A law that is in no catalogue is discovered: the barometer's error is the cube of the throttle.
#[test]
fn a_law_that_nobody_wrote_down_is_discovered() {
    let flights = [flight(true, 6, |now| 12.0 * now.throttle * now.throttle * now.throttle)];
    let mut progress = || ControlFlow::Continue(());
    let found = discover(&named(&flights, &Model::default()), &[], &mut progress, &Inline).unwrap();
    let best = found.laws.first().unwrap();
    assert!(best.regressor.contains("throttle"), "{best:?}");
    let names = ["tas_mps", "throttle"].map(String::from);
    if !best.regressor.contains("tas_mps") {
        assert_eq!(id(best, &names), "baro.throttle");
    }
    let (before_m, after_m) = (best.rms_before_m.unwrap(), best.rms_after_m.unwrap());
    assert!(after_m < 0.5 * before_m, "{best:?}");
}

/// A model that estimates the coefficient in flight has it at the launch, with the envelope of the
/// calibration.
#[test]
fn an_estimated_coefficient_is_the_one_that_acts() {
    let text = "[[effect]]\nid = \"baro.dynamic_pressure\"\nsigma = 0.3\nestimate = true\n";
    let model = Model::parse(text).unwrap();
    let flight = flight(true, 7, dynamic_pressure_m(-0.1));
    let replay = Replay::new(&flight, &model, None).unwrap();
    let (found, _) = compare(&replay, &Options::default(), &mut |_| (), &Inline).unwrap();
    let [effect] = &found.effects[..] else { panic!("{:?}", found.effects) };
    assert!(effect.estimated && effect.effect == "baro.dynamic_pressure");
    assert!((effect.coefficient + 0.1).abs() < 3.0 * effect.sigma && effect.sigma < 0.03, "{effect:?}");
    assert!(found.sensors["baro"].free_flight_rms_m.unwrap() < 0.5, "{:?}", found.sensors["baro"]);
}

/// An effect of the model's own, by a formula, is identified as the catalogue's effects are.
#[test]
fn an_effect_by_formula_is_identified() {
    let text = "[[effect_definition]]\nid = \"baro.wash\"\non = \"baro\"\nregressor = \"throttle^3 * 1[m]\"\nplausible = [-20, 20]\n";
    let model = Model::parse(text).unwrap();
    let flights = [flight(true, 8, |now| 5.0 * now.throttle * now.throttle * now.throttle)];
    let mut progress = || ControlFlow::Continue(());
    let found = diagnose(&named(&flights, &model), &[], &mut progress, &Inline).unwrap();
    let facts = &found.sensors["baro"].candidates.iter().find(|facts| facts.effect == "baro.wash").unwrap();
    assert!((facts.coefficient - 5.0).abs() < 3.0 * facts.sigma && facts.sigma < 0.5, "{facts:?}");
    assert!(found.missing().chain(found.suspects()).any(|effect| effect == "baro.wash"), "{found:?}");
}

/// The same flight a second time halves a coefficient's variance, as far as it is noise: the uncertainty from
/// formulas and signals stays.
#[test]
fn a_planned_flight_adds_its_information() {
    let flights = [flight(true, 9, dynamic_pressure_m(-0.1))];
    let model = Model::default();
    let mut progress = || ControlFlow::Continue(());
    let named = named(&flights, &model);
    let (diagnosis, further) = diagnose_further(&named, &[], &mut progress, &Inline).unwrap();
    let outlook = further.unwrap().planner.outlook(&named[0].replay, &Inline);
    let of = |id: &str| outlook.effects.iter().find(|effect| effect.effect == id).unwrap();
    let own = of("baro.dynamic_pressure");
    let facts = &diagnosis.sensors["baro"].candidates[0];
    assert!(own.is_found && own.is_seen_now && own.is_seen_then && own.is_planned, "{own:?}");
    assert!((own.coefficient.unwrap() - facts.coefficient).abs() < 0.1 * facts.sigma, "{own:?} {facts:?}");
    let (now, then) = (own.sigma_now.unwrap(), own.sigma_then.unwrap());
    assert!((now / facts.sigma - 1.0).abs() < 0.05, "{own:?} {facts:?}");
    assert!(then < now && then > 0.95 * now / 2.0_f64.sqrt(), "{own:?}");
    // For an effect that was not found, nearly all of the variance is noise.
    for other in outlook.effects.iter().filter(|effect| !effect.is_found) {
        if let (Some(now), Some(then)) = (other.sigma_now, other.sigma_then) {
            assert!(then <= now * 1.0001 && then >= 0.6 * now, "{other:?}");
        }
    }
}

/// Where two effects fit alike, the diagnosis names both, and reports how well a planned flight would
/// distinguish them.
#[test]
fn a_set_that_can_not_be_told_apart_has_an_outlook() {
    // A lag of the barometer: with one receiver it cannot be distinguished from a latency of the receiver.
    let flights = [flight(true, 10, |now| -0.35 * now.climb_mps)];
    let model = Model::default();
    let mut progress = || ControlFlow::Continue(());
    let named = named(&flights, &model);
    let (diagnosis, further) = diagnose_further(&named, &[], &mut progress, &Inline).unwrap();
    let outlook = further.unwrap().planner.outlook(&named[0].replay, &Inline);
    assert!(
        diagnosis.missing().chain(diagnosis.suspects()).any(|effect| effect == "baro.lag"),
        "{diagnosis:?}"
    );
    assert!(!outlook.sets.is_empty(), "a lag of the barometer is a latency of the receiver: {diagnosis:?}");
    for set in &outlook.sets {
        assert!(set.members.len() > 1, "{set:?}");
        let sum: f64 = set.members.iter().map(|member| member.probability).sum();
        assert!(sum <= 1.0 + 1e-9, "{set:?}");
        for member in &set.members {
            // The effect that acts is at least as probable with the planned flight as without.
            let then = member.probability_then.unwrap_or(1.0);
            assert!((0.0..=1.0).contains(&then) && then >= member.probability - 1e-9, "{set:?}");
        }
    }
}

/// An effect is learned together with the others that act: a static-port error with a lag.
#[test]
fn an_effect_is_learned_beside_the_others_that_act() {
    let both = |now: Moment| dynamic_pressure_m(-0.1)(now) - 0.8 * now.climb_mps;
    let flights = [flight(true, 11, both)];
    let model = Model::default();
    let effect = model.effect_named("baro.dynamic_pressure").unwrap();
    let wanted = WantedEffect { effect, time_constant_s: None, since: None };
    let mut progress = || ControlFlow::Continue(());
    let (_, problem) = study(&named(&flights, &model), &[], wanted, &mut progress, &Inline).unwrap();
    let problem = problem.unwrap();
    assert_eq!(problem.terms[0].regressor.id, effect);
    assert!(problem.terms.len() >= 2, "{:?}", problem.terms);
    let learned = learn(&problem).unwrap();
    assert!((learned.coefficient + 0.1).abs() < 3.0 * learned.sigma && learned.sigma < 0.02, "{learned:?}");
}
