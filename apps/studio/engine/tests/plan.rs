//! A plan's predictions hold in the flight: its scenario is flown with the effect that was found, and
//! diagnosed.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

use serde_json::{Value, json};
use simulate::{Scenario, simulate};
use studio_engine::Engine;

fn asked(engine: &mut Engine, call: &str, of: Value, bytes: &[u8]) -> Result<Value, String> {
    let request = json!({ "call": call, "of": of }).to_string();
    let reply = engine.ask(request.as_bytes(), bytes, &mut |_, _, _| {});
    let json: Value = serde_json::from_str(&reply.json).unwrap();
    match json.get("ok") {
        Some(answer) => Ok(answer.clone()),
        None => Err(json["error"].as_str().unwrap().to_owned()),
    }
}

/// Simulates a scenario and opens it as a log.
fn open(engine: &mut Engine, flight: &str, scenario: &str, seed: u64) {
    let scenario = Scenario::from_toml(scenario, "a test").unwrap();
    let (made, _) = simulate(&scenario, seed).unwrap();
    let mut csv = Vec::new();
    flight_data::to_writer(&mut csv, &made).unwrap();
    asked(engine, "open", json!({ "flight": flight, "file": format!("{flight}.csv") }), &csv).unwrap();
}

fn of(flights: &[&str]) -> Value {
    json!({ "flights": flights, "hold_outs": [], "model": { "name": "ours.toml", "text": "" }, "times": {} })
}

fn planned(engine: &mut Engine, flights: &[&str], plan: &Value) -> Result<Value, String> {
    let mut request = of(flights);
    request["plan"] = plan.clone();
    asked(engine, "plan", request, &[])
}

fn effect<'a>(outlook: &'a Value, id: &str) -> &'a Value {
    let all = outlook["effects"].as_array().unwrap();
    all.iter().find(|effect| effect["effect"] == id).unwrap_or_else(|| panic!("no {id} in {outlook}"))
}

fn candidate(diagnosed: &Value, sensor: &str, id: &str) -> Value {
    let all = diagnosed["diagnosis"]["sensors"][sensor]["candidates"].as_array().unwrap();
    all.iter().find(|candidate| candidate["effect"] == id).unwrap_or_else(|| panic!("no {id}")).clone()
}

fn plan(leg: Value) -> Value {
    json!({ "speed_mps": 28.0, "altitude_m": 1200.0, "calibration_s": 60.0, "legs": [leg] })
}

/// A short flight that is faster from the release on: it shows that an effect acts, but not whether the cause
/// is the speed or the release.
const POOR: &str = "name = \"poor\"
[captive]
duration_s = 60.0
altitude_m = 1200.0
airspeed_mps = 28.0
[[free_flight]]
manoeuvre = \"accelerate\"
duration_s = 40.0
airspeed_mps = 36.0
[[effect]]
id = \"baro.dynamic_pressure\"
coefficient = 0.08
";

/// A flight that clearly shows the acting effect.
const PLAIN: &str = "name = \"plain\"
[captive]
duration_s = 60.0
altitude_m = 1200.0
airspeed_mps = 28.0
[[free_flight]]
manoeuvre = \"dive\"
duration_s = 12.0
flight_path_deg = -15.0
airspeed_mps = 42.0
[[free_flight]]
manoeuvre = \"level_off\"
duration_s = 15.0
airspeed_mps = 28.0
[[effect]]
id = \"baro.dynamic_pressure\"
coefficient = 0.08
";

#[test]
fn the_interval_that_a_plan_promises_is_the_one_that_its_flight_brings() {
    let mut engine = Engine::new(&executor::Inline);
    open(&mut engine, "first", POOR, 3);
    let diagnosed = asked(&mut engine, "diagnose", of(&["first"]), &[]).unwrap();
    let sweep = json!({ "manoeuvre": "speed_sweep", "amount": 8.0, "duration_s": 20.0, "times": 2 });
    let answer = planned(&mut engine, &["first"], &plan(sweep)).unwrap();
    let promised = effect(&answer["outlook"], "baro.dynamic_pressure");
    let now = candidate(&diagnosed, "baro", "baro.dynamic_pressure");
    assert_eq!(promised["sigma_now"], now["sigma"], "what is said to be now is what the diagnosis says");
    assert_eq!(promised["coefficient"], now["coefficient"]);

    // The saved scenario, with the acting effect.
    let scenario = answer["scenario"].as_str().unwrap().to_owned()
        + "\n[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.08\n";
    let promised = promised["sigma_then"].as_f64().unwrap();
    for seed in [11, 12] {
        open(&mut engine, "second", &scenario, seed);
        let both = asked(&mut engine, "diagnose", of(&["first", "second"]), &[]).unwrap();
        let then = candidate(&both, "baro", "baro.dynamic_pressure");
        let (sigma, off) = (then["sigma"].as_f64().unwrap(), then["coefficient"].as_f64().unwrap() - 0.08);
        // The variance is proportional to that of the wander, which the first flight determines from about
        // ten of its correlation times: a factor of (2/10)^1/2, and twice that is 0.1 to 1.9 of it, or 0.3 to
        // 1.4 of the sigma. With the second flight the wander is estimated again, and so is the inflation for
        // what does not repeat.
        assert!((0.3..2.0).contains(&(sigma / promised)), "promised {promised}, came {sigma}");
        assert!(off.abs() < 4.0 * promised, "off by {off}, promised {promised}");
    }
    assert!(promised < 0.6 * now["sigma"].as_f64().unwrap(), "{promised} after {now}");
}

#[test]
fn what_moves_nothing_narrows_nothing() {
    let mut engine = Engine::new(&executor::Inline);
    open(&mut engine, "first", PLAIN, 3);
    let share = |engine: &mut Engine, leg: Value| {
        let answer = planned(engine, &["first"], &plan(leg)).unwrap();
        let of = effect(&answer["outlook"], "baro.dynamic_pressure").clone();
        of["sigma_then"].as_f64().unwrap() / of["sigma_now"].as_f64().unwrap()
    };
    let level =
        share(&mut engine, json!({ "manoeuvre": "level", "amount": 0.0, "duration_s": 60.0, "times": 1 }));
    let sweep = share(
        &mut engine,
        json!({ "manoeuvre": "speed_sweep", "amount": 8.0, "duration_s": 20.0, "times": 2 }),
    );
    // More of the same adds almost nothing; no plan removes information.
    assert!((0.9..=1.0 + 1e-9).contains(&level), "{level}");
    assert!(sweep < 0.85 * level, "{sweep} against {level}");
}

#[test]
fn a_set_is_told_apart_by_the_flight_that_was_planned_for_it() {
    let mut engine = Engine::new(&executor::Inline);
    open(&mut engine, "first", POOR, 3);
    let suggested = planned(&mut engine, &["first"], &Value::Null).unwrap();
    let sets = suggested["outlook"]["sets"].as_array().unwrap();
    let members = |set: &Value| -> Vec<String> {
        let all = set["members"].as_array().unwrap();
        all.iter().map(|member| member["effect"].as_str().unwrap().to_owned()).collect()
    };
    let set = sets.iter().find(|set| members(set).iter().any(|id| id == "baro.dynamic_pressure"));
    let set = set.unwrap_or_else(|| panic!("the flight was to be poor: {}", suggested["outlook"]));
    let truth =
        set["members"].as_array().unwrap().iter().find(|one| one["effect"] == "baro.dynamic_pressure");
    let truth = truth.unwrap();
    assert!(members(set).len() > 1, "{set}");
    assert!(truth["probability_then"].as_f64().unwrap() > 0.99, "{truth}");
    assert!(truth["probability"].as_f64().unwrap() < 0.97, "{truth}");
    assert_eq!(truth["left"], 1);
    assert!(set["resolved"].as_f64().unwrap() >= 0.9, "{set}");
    let gains =
        suggested["offers"].as_array().unwrap().iter().map(|offer| {
            offer["gain"]["tells_apart"].as_f64().unwrap_or_else(|| panic!("{offer} can be flown"))
        });
    assert!(gains.is_sorted_by(|one, next| one >= next), "the best comes first");

    let scenario = suggested["scenario"].as_str().unwrap().to_owned()
        + "\n[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.08\n";
    open(&mut engine, "second", &scenario, 11);
    let both = asked(&mut engine, "diagnose", of(&["first", "second"]), &[]).unwrap();
    assert_eq!(both["diagnosis"]["sensors"]["baro"]["missing"], json!(["baro.dynamic_pressure"]), "{both}");
}

#[test]
fn a_plan_that_can_not_be_flown_is_refused_in_words() {
    let mut engine = Engine::new(&executor::Inline);
    open(&mut engine, "first", POOR, 3);
    for (leg, says) in [
        (
            json!({ "manoeuvre": "speed_sweep", "amount": 90.0, "duration_s": 20.0, "times": 1 }),
            "expected 1 to 11",
        ),
        (
            json!({ "manoeuvre": "turns", "amount": 45.0, "duration_s": 0.0, "times": 1 }),
            "a duration, s, is 0",
        ),
        (json!({ "manoeuvre": "turns", "amount": 45.0, "duration_s": 10.0, "times": 0 }), "the times is 0"),
        (
            json!({ "manoeuvre": "long_climb", "amount": 25.0, "duration_s": 600.0, "times": 5 }),
            "the plan's length",
        ),
    ] {
        let why = planned(&mut engine, &["first"], &plan(leg)).unwrap_err();
        assert!(why.contains(says) && !why.contains('\n'), "{why}");
    }
    let low = json!({ "speed_mps": 28.0, "altitude_m": 10.0, "calibration_s": 60.0,
        "legs": [{ "manoeuvre": "climbs", "amount": 20.0, "duration_s": 2.0, "times": 1 },
                 { "manoeuvre": "pull_ups", "amount": 3.0, "duration_s": 30.0, "times": 3 }] });
    let why = planned(&mut engine, &["first"], &low).unwrap_err();
    assert!(why.starts_with("the flight "), "{why}");
    let nothing = planned(&mut engine, &[], &Value::Null).unwrap_err();
    assert!(nothing.starts_with("no flight to learn from"), "{nothing}");
}
