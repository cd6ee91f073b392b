//! The whole sequence on simulated flights: a hidden effect raises a flag, the diagnosis names it, `add`
//! learns it, and the flag is not raised again: at the desk and, bit for bit, in the emulated flight
//! computer.
//!
//! Needs qemu-system-arm and the Rust target, as `qemu_flight.rs`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use kf_core::effect::EffectId;
use model::Model;
use pylon::diagnose::{NamedReplay, Verdict, WantedEffect, diagnose};
use pylon::flight::Flight;
use pylon::fly::{FlyOptions, fly};
use pylon::learn::{Addition, NamedFlight, Request, add, pooled_rms_m, score};
use pylon::replay::Replay;
use pylon::simulate::{Scenario, simulate};
use time::{Date, Month};

/// The plan of the flights that are learned from.
const PLAN: &str = include_str!("../../flights/clean.toml");
/// Another plan: slower, lower, with other manoeuvres in another order.
const OTHER_PLAN: &str = r#"
name = "another day"
seed = 1
latitude_deg = 47.0
[vehicle]
name = "simulated 12 kg UAV"
vibration_mps2 = 0.5
[captive]
duration_s = 120.0
altitude_m = 1700.0
airspeed_mps = 27.0
heading_deg = 210.0
phugoid_amplitude_m = 3.0
phugoid_period_s = 22.0
settling_s = 10.0
[wind]
north_mps = -2.0
east_mps = 4.0
[turbulence]
horizontal_sigma_mps = 0.6
vertical_sigma_mps = 0.4
[[free_flight]]
manoeuvre = "turn"
duration_s = 18.0
bank_deg = -35.0
[[free_flight]]
manoeuvre = "accelerate"
duration_s = 20.0
airspeed_mps = 40.0
[[free_flight]]
manoeuvre = "dive"
duration_s = 10.0
flight_path_deg = -18.0
airspeed_mps = 42.0
[[free_flight]]
manoeuvre = "level_off"
duration_s = 15.0
airspeed_mps = 30.0
[[free_flight]]
manoeuvre = "climb"
duration_s = 20.0
flight_path_deg = 7.0
airspeed_mps = 28.0
[[free_flight]]
manoeuvre = "straight"
duration_s = 20.0
"#;

fn flight(plan: &str, effect: EffectId, coefficient: f64, seed: u64) -> Flight {
    // The integrals start at launch. An accelerometer that had a bias for minutes before would also have a
    // velocity error, which is another effect.
    let phase = if effect.name().starts_with("imu") { "phase = \"free\"\n" } else { "" };
    let text =
        format!("{plan}\n[[effect]]\nid = \"{}\"\ncoefficient = {coefficient}\n{phase}", effect.name());
    simulate(&Scenario::from_toml(&text, "story").unwrap(), seed).unwrap().0
}

fn added(text: &str, effect: EffectId, learning: &Flight, held_out: &Flight, estimate: bool) -> Addition {
    let request = Request {
        text,
        wanted: WantedEffect { effect, time_constant_s: None, since: None },
        estimate,
        date: Date::from_calendar_date(2026, Month::November, 21).unwrap(),
        learning: vec![NamedFlight::new("first.csv", learning)],
        held_out: vec![NamedFlight::new("second.csv", held_out)],
    };
    add(&request, &mut || ()).unwrap()
}

/// The held-out error with the simulator's coefficient.
fn oracle_rms_m(effect: EffectId, coefficient: f64, flight: &Flight) -> f64 {
    let text = format!("[[effect]]\nid = \"{}\"\ncoefficient = {coefficient}\n", effect.name());
    let oracle = Model::parse(&text).unwrap();
    let scores = score(&Replay::new(flight, &oracle, None).unwrap()).unwrap();
    pooled_rms_m([&scores], effect.subject()).unwrap()
}

/// Number of pairs of flights.
const SEEDS: u64 = 10;
/// Largest allowed ratio of the held-out error to the oracle's.
const OVER_ORACLE: f64 = 1.15;

fn has_flag(flight: &Flight, model: &Model) -> bool {
    let scores = score(&Replay::new(flight, model, None).unwrap()).unwrap();
    scores["baro"].doubtful_after_s.is_some()
}

#[test]
fn a_flag_of_the_old_model_is_not_raised_with_the_improved_one_at_the_desk_or_in_the_aircraft() {
    let effect = EffectId::BaroDynamicPressure;
    let first = flight(PLAN, effect, 0.12, 11);
    let second = flight(OTHER_PLAN, effect, 0.12, 12);
    let old = Model::default();
    assert!(has_flag(&first, &old) && has_flag(&second, &old));

    let named = NamedReplay::new("first".to_owned(), Replay::new(&first, &old, None).unwrap());
    let diagnosis = diagnose(&[named], &[], &mut || ());
    assert_eq!(diagnosis.verdict, Verdict::Identified);
    assert_eq!(diagnosis.sensors["baro"].missing, [effect.name()]);

    for estimate in [false, true] {
        let addition = added("", effect, &first, &second, estimate);
        assert!(addition.concerns.is_empty() && addition.warnings.is_empty(), "{addition:?}");
        assert!((f64::from(addition.coefficient) - 0.12).abs() < 4.0 * f64::from(addition.sigma));
        // What remains on the second flight is the reference's own wander, which no model removes: the
        // oracle's error.
        let oracle_m = oracle_rms_m(effect, 0.12, &second);
        assert!(addition.rms_after_m.unwrap() < OVER_ORACLE * oracle_m, "{addition:?} {oracle_m}");
        assert!(addition.rms_before_m.unwrap() > OVER_ORACLE * oracle_m, "{addition:?} {oracle_m}");
        let improved = Model::parse(&addition.text).unwrap();
        assert_eq!(improved.estimated_effects().count(), usize::from(estimate));
        for flight in [&first, &second] {
            assert!(!has_flag(flight, &improved), "{addition:?}");
            let replay = Replay::new(flight, &improved, None).unwrap();
            let report = fly(&replay, &FlyOptions::default()).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(report.ticks as usize, flight.rows());
            assert_eq!(report.latch, replay.run(&mut |_, _| ()).unwrap().latch);
        }
    }
}

/// What was learned from one flight is nearly as good as the truth on another.
///
/// `cargo test -p host-tests --test improved_model -- --nocapture` prints how good.
#[test]
fn after_add_the_held_out_error_is_within_15_per_cent_of_the_oracles() {
    let cases =
        [(EffectId::BaroDynamicPressure, 0.06), (EffectId::BaroLag, 0.8), (EffectId::ImuAccelBias, 0.01)];
    for (effect, coefficient) in cases {
        let mut worst: f64 = 0.0;
        let [mut after, mut oracle, mut before] = [0.0; 3];
        let mut sigma = 0.0;
        for seed in 0..SEEDS {
            let first = flight(PLAN, effect, coefficient, 100 + seed);
            let second = flight(OTHER_PLAN, effect, coefficient, 200 + seed);
            let addition = added("", effect, &first, &second, false);
            let oracle_m = oracle_rms_m(effect, coefficient, &second);
            let after_m = addition.rms_after_m.unwrap();
            worst = worst.max(after_m / oracle_m);
            after += after_m * after_m;
            oracle += oracle_m * oracle_m;
            before += addition.rms_before_m.unwrap().powi(2);
            sigma += f64::from(addition.sigma) / (coefficient * SEEDS as f64);
        }
        let together = (after / oracle).sqrt();
        // A coefficient that is off by a share d adds d f to an error e that the oracle has too, where f is
        // the effect's own size: (e + d f)^2 is larger by 2 d <e f> + d^2 f^2. Over the flights the first
        // term is normal with at most 2 sigma |e| |f| / sqrt(flights), of which four sigmas are allowed for;
        // and |f| is at most |before| + |e|.
        let size = (before / oracle).sqrt() + 1.0;
        let chance = sigma * sigma * size * size + 4.0 * 2.0 * sigma * size / (SEEDS as f64).sqrt();
        println!(
            "{:>22}: held-out rms over the oracle's {together:.3} (chance: {:.3}), at worst {worst:.3}; without the effect {:.3}",
            effect.name(),
            (1.0 + chance).sqrt(),
            size - 1.0
        );
        assert!(worst < OVER_ORACLE, "{}: {worst}", effect.name());
        assert!(together < (1.0 + chance).sqrt(), "{}: {together}, {chance}", effect.name());
    }
}
