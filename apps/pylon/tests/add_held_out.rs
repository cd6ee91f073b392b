//! The verdict of `pylon add` on a held-out flight, over many simulated flights: a true effect passes even if
//! it is as small as the noise, and an effect that does not act there is refused at the rate that the verdict
//! states.
//!
//! `cargo test -p pylon --test add_held_out -- --nocapture` prints the results.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::sync::OnceLock;

use kf_core::effect::EffectId;
use model::Model;
use pylon::diagnose::WantedEffect;
use pylon::flight::Flight;
use pylon::learn::{Addition, HeldOutVerdict, JudgedOn, NamedFlight, Request, add, score};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, scenario, simulate};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use statrs::distribution::{ContinuousCDF as _, Normal};
use time::{Date, Month};

const SEEDS: u64 = 40;
/// How the effect acts on the held-out flight: as on the learning flight, not at all, with the opposite sign.
const ACTS: [f64; 3] = [1.0, 0.0, -1.0];
/// The simulator's id and the core's.
const EFFECTS: [(scenario::EffectId, EffectId); 3] = [
    (scenario::EffectId::BaroDynamicPressure, EffectId::BaroDynamicPressure),
    (scenario::EffectId::BaroLag, EffectId::BaroLag),
    (scenario::EffectId::ImuAccelBias, EffectId::ImuAccelBias),
];

fn flight(injected: Option<(scenario::EffectId, f64)>, seed: u64) -> Flight {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
    let mut scenario = load_scenario(&file).unwrap();
    scenario.effect = injected
        .into_iter()
        .map(|(id, coefficient)| scenario::Effect {
            id,
            coefficient,
            // Integrated effects start at launch.
            phase: if id.name().starts_with("imu") {
                scenario::InjectionPhase::Free
            } else {
                scenario::InjectionPhase::Both
            },
            time_constant_s: None,
            width_m: None,
        })
        .collect();
    simulate(&scenario, seed).unwrap().0
}

fn added(effect: EffectId, learning: &Flight, held_out: Option<&Flight>) -> Addition {
    let request = Request {
        text: "",
        wanted: WantedEffect { effect, time_constant_s: None, since: None },
        estimate: false,
        date: Date::from_calendar_date(2026, Month::November, 21).unwrap(),
        learning: vec![NamedFlight::new("first.csv", learning)],
        held_out: held_out.map(|flight| NamedFlight::new("second.csv", flight)).into_iter().collect(),
    };
    add(&request, &mut || ()).unwrap()
}

/// The coefficient at which the effect's rms in free flight equals the sensor's error without it.
fn coefficient_of_the_noise(injected: scenario::EffectId, effect: EffectId) -> f64 {
    let (clean, dirty) = (flight(None, 1), flight(Some((injected, 1e-3)), 1));
    let name = if effect.name().starts_with("imu") { "imu_slave" } else { "baro" };
    let error_m = |flight: &Flight| {
        let model = Model::default();
        let replay = Replay::new(flight, &model, None).unwrap();
        let mut errors = Vec::new();
        replay
            .run(&mut |_, output| {
                let index = usize::from(name == "baro") + 1;
                let free = output.phase == kf_core::output::Phase::FreeFlight;
                errors.push(output.sensors[index].error_m.filter(|_| free).map(f64::from));
            })
            .unwrap();
        errors
    };
    let (clean_m, dirty_m) = (error_m(&clean), error_m(&dirty));
    let shifts: Vec<f64> =
        clean_m.iter().zip(&dirty_m).filter_map(|(clean, dirty)| Some((*dirty)? - (*clean)?)).collect();
    let shift_m = (shifts.iter().map(|shift| shift * shift).sum::<f64>() / shifts.len() as f64).sqrt();
    let model = Model::default();
    let noise_m =
        score(&Replay::new(&clean, &model, None).unwrap()).unwrap()[name].free_flight_rms_m.unwrap();
    1e-3 * noise_m / shift_m
}

/// These coefficients for all effects, computed once for both tests.
fn coefficients_of_the_noise() -> [f64; 3] {
    static UNITS: OnceLock<[f64; 3]> = OnceLock::new();
    *UNITS.get_or_init(|| EFFECTS.map(|(injected, effect)| coefficient_of_the_noise(injected, effect)))
}

/// The probability that an effect is refused that acts with this multiple of the learned coefficient.
fn stated_rate(verdict: &HeldOutVerdict, times: f64) -> f64 {
    let as_learned = verdict.gain_as_learned / verdict.gain_sigma;
    Normal::new(0.0, 1.0).unwrap().cdf(-1.645 - (2.0 * times - 1.0) * as_learned)
}

#[test]
fn a_small_true_effect_passes_and_an_absent_or_opposite_one_is_refused_at_the_stated_rate() {
    let units = coefficients_of_the_noise();
    let of_seed = |seed: u64| {
        let at = seed as usize % EFFECTS.len();
        let (injected, effect) = EFFECTS[at];
        // From as large as the noise to twice as large.
        let coefficient = units[at] * (1.0 + seed as f64 / (SEEDS - 1) as f64);
        let first = flight(Some((injected, coefficient)), 1000 + seed);
        let trial = |(case, act): (usize, f64)| {
            let acts = act * coefficient;
            let second = flight((acts != 0.0).then_some((injected, acts)), 2000 + 10 * seed + case as u64);
            (case, acts, added(effect, &first, Some(&second)))
        };
        ACTS.into_iter().enumerate().map(trial).collect::<Vec<_>>()
    };
    let trials: Vec<(usize, f64, Addition)> = (0..SEEDS).into_par_iter().flat_map_iter(of_seed).collect();
    let mut refused = [0_u32; 3];
    let mut by_raw_rms = 0;
    let mut expected = [(0.0, 0.0); 3];
    let mut deviates: Vec<f64> = Vec::new();
    for (case, acts, addition) in &trials {
        assert_eq!(addition.judged_on, JudgedOn::HeldOutFlights);
        let verdict = &addition.held_out_verdict;
        refused[*case] += u32::from(verdict.is_worse);
        let times = acts / f64::from(addition.coefficient);
        let rate = stated_rate(verdict, times);
        expected[*case].0 += rate;
        expected[*case].1 += rate * (1.0 - rate);
        deviates.push((verdict.gain - (2.0 * times - 1.0) * verdict.gain_as_learned) / verdict.gain_sigma);
        by_raw_rms += u32::from(*case == 0 && addition.rms_after_m > addition.rms_before_m);
        let is_said = addition.concerns.iter().any(|concern| concern.contains("less likely with it"));
        assert_eq!(is_said, verdict.is_worse, "{:?}", addition.concerns);
    }
    let square = deviates.iter().map(|z| z * z).sum::<f64>() / deviates.len() as f64;
    println!(
        "refused of {SEEDS}: true {} (by the raw rms it would be {by_raw_rms}), absent {}, opposite {}; \
         stated {:.1}, {:.1}, {:.1}; mean square of the deviates {square:.2}",
        refused[0], refused[1], refused[2], expected[0].0, expected[1].0, expected[2].0
    );
    // At least 95 % of the true effects pass.
    assert!(refused[0] * 20 <= SEEDS as u32, "{refused:?}");
    for (case, (mean, variance)) in expected.into_iter().enumerate().skip(1) {
        // If fewer are refused than stated, by four binomial sigmas or one flight, the test has less power
        // than it states.
        let least = mean - (4.0 * f64::sqrt(variance)).max(1.0);
        assert!(f64::from(refused[case]) >= least, "{case}: {refused:?}, stated {mean}");
    }
    // Chi-squared of 120 over 120 is below 1.54 in 99.99 %. The interval attributes more than the noise to
    // chance, so it tends to be below one.
    assert!(square < 1.54, "{square}");
}

/// Without held-out flights, stretches of the learning flight decide: true effects pass.
#[test]
fn stretches_of_the_learning_flight_pass_a_true_effect() {
    let units = coefficients_of_the_noise();
    let is_refused = |seed: u64| {
        let at = seed as usize % EFFECTS.len();
        let (injected, effect) = EFFECTS[at];
        let coefficient = 1.5 * units[at];
        let addition = added(effect, &flight(Some((injected, coefficient)), 3000 + seed), None);
        assert_eq!(addition.judged_on, JudgedOn::HeldOutManoeuvres);
        addition.held_out_verdict.is_worse
    };
    let refused = (0..20_u64).into_par_iter().filter(|seed| is_refused(*seed)).count();
    println!("stretches refused {refused} of 20 true effects");
    // Each is refused with less than 5 %: three or more in 7.5 %, four or more in 1.6 %, five or more in 0.26
    // %.
    assert!(refused <= 4, "{refused}");
}
