//! An engine's memory of a diagnosis changes no addition; it only makes it faster.

#![expect(clippy::unwrap_used, reason = "a test")]

use serde_json::{Value, json};
use studio_engine::Engine;

fn asked(engine: &mut Engine, call: &str, of: Value) -> Value {
    let request = json!({ "call": call, "of": of }).to_string();
    serde_json::from_str(&engine.ask(request.as_bytes(), &[], &mut |_, _, _| {}).json).unwrap()
}

fn opened(samples: &[&str]) -> Engine {
    let mut engine = Engine::new(&executor::Inline);
    for sample in samples {
        let answer = asked(&mut engine, "open_sample", json!({ "flight": sample, "sample": sample }));
        assert!(answer["error"].is_null(), "{answer}");
    }
    engine
}

fn add(effect: &str, model: &Value, learned: &[&str], held: &[&str]) -> Value {
    json!({
        "effect": effect, "flights": learned, "hold_outs": held, "model": model, "times": {},
        "estimate": false, "time_constant_s": null, "since": null, "date": "2026-01-31"
    })
}

/// The acting effect; one with other shapes of a lag; one with a time constant; one of the reference; one
/// that another explains; and one that was added before.
#[test]
fn an_addition_after_a_diagnosis_is_that_of_an_engine_that_has_made_none() {
    let (learned, held) = (["hidden-static-port"], ["hidden-static-port-second"]);
    let both = ["hidden-static-port", "hidden-static-port-second"];
    let default = json!({ "name": "ours.toml", "text": "" });
    let diagnose =
        |model: &Value| json!({ "flights": learned, "hold_outs": held, "model": model, "times": {} });
    let mut engine = opened(&both);
    asked(&mut engine, "diagnose", diagnose(&default));
    asked(&mut engine, "ladder", json!({ "flights": both, "model": default, "times": {} }));
    let mut model = Value::Null;
    for effect in ["baro.dynamic_pressure", "baro.lag", "baro.warm_up", "gps.latency", "baro.carrier_field"] {
        let of = add(effect, &default, &learned, &held);
        let after = asked(&mut engine, "add", of.clone());
        assert_eq!(after, asked(&mut opened(&both), "add", of), "{effect}");
        if effect == "baro.dynamic_pressure" {
            model = after["ok"]["model"].clone();
            let ladder = json!({ "flights": both, "model": model, "times": {} });
            let flown = asked(&mut opened(&both), "ladder", ladder);
            assert_eq!(after["ok"]["ladder"], flown["ok"]);
            assert_eq!(flown["ok"]["revisions"].as_array().unwrap().len(), 2);
        }
    }
    asked(&mut engine, "diagnose", diagnose(&model));
    for effect in ["baro.dynamic_pressure", "baro.angle_of_attack"] {
        let of = add(effect, &model, &learned, &held);
        assert_eq!(
            asked(&mut engine, "add", of.clone()),
            asked(&mut opened(&both), "add", of),
            "{effect} again"
        );
    }
}
