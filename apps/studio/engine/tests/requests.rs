//! A page's requests and their answers, on a simulated flight with a hidden static-port error.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

use serde_json::{Value, json};
use studio_engine::{Engine, Reply};

fn asked(engine: &mut Engine, call: &str, of: Value, bytes: &[u8]) -> Reply {
    let request = json!({ "call": call, "of": of }).to_string();
    engine.ask(request.as_bytes(), bytes, &mut |_, _, _| {})
}

/// An answer, whose arrays are found by their path in it.
struct Answer {
    json: Value,
    numbers: Vec<f64>,
}

impl Answer {
    fn of(engine: &mut Engine, call: &str, of: Value) -> Self {
        let reply = asked(engine, call, of, &[]);
        let json: Value = serde_json::from_str(&reply.json).unwrap();
        assert!(json.get("ok").is_some(), "{call}: {}", reply.json);
        Self { json: json["ok"].clone(), numbers: reply.numbers }
    }

    fn array(&self, at: &str) -> &[f64] {
        let place = |key: &str| self.json.pointer(at).unwrap()[key].as_u64().unwrap() as usize;
        &self.numbers[place("start")..place("start") + place("length")]
    }
}

fn error(reply: &Reply) -> String {
    let json: Value = serde_json::from_str(&reply.json).unwrap();
    json["error"].as_str().unwrap_or_else(|| panic!("{}", reply.json)).to_owned()
}

#[test]
fn a_file_that_is_no_log_is_refused_in_the_importers_own_words_and_nothing_is_lost() {
    let mut engine = Engine::new(&executor::Inline);
    let open = |file: &str| json!({ "flight": "one", "file": file });
    let csv = b"# pylon-flight: 1\n# vehicle: <script>alert(1)</script>\ntime_s,gps_alt_m,baro_alt_m\n0,1,2\n0.5,1,2\n";
    let reply = asked(&mut engine, "open", open("one.csv"), csv);
    let opened: Value = serde_json::from_str(&reply.json).unwrap();
    assert_eq!(opened["ok"]["vehicle"], "<script>alert(1)</script>");
    for (bytes, says) in [
        (&b""[..], "empty"),
        (b"PK\x03\x04rest", "ZIP archive"),
        (b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "writetable"),
        (b"# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,1,2\nx,1,2\n", "row"),
        (b"\x00\x01\x02\x03\x04\x05\x06\x07", "expected"),
    ] {
        let reply = asked(&mut engine, "open", open("bad.bin"), bytes);
        let why = error(&reply);
        assert!(why.starts_with("bad.bin: ") && why.contains(says) && !why.contains('\n'), "{why}");
    }
    // The flight that was open under that name still is.
    let reply = asked(&mut engine, "flight", json!({ "flight": "one", "times": {} }), &[]);
    assert!(reply.json.contains("one.csv"), "{}", reply.json);
    let why = error(&asked(&mut engine, "flight", json!({ "flight": "two", "times": {} }), &[]));
    assert_eq!(why, "flight 'two' is not open");
    assert!(error(&asked(&mut engine, "nonsense", json!({}), &[])).contains("nonsense"));
}

#[test]
fn an_effect_is_found_added_and_the_error_falls_as_its_prediction_said() {
    let mut engine = Engine::new(&executor::Inline);
    let flight = json!("f");
    let default = json!({ "name": "ours.toml", "text": "" });
    Answer::of(&mut engine, "open_sample", json!({ "flight": flight, "sample": "hidden-static-port" }));

    let of = json!({ "flights": [flight], "hold_outs": [], "model": default, "times": {} });
    let diagnosed = Answer::of(&mut engine, "diagnose", of).json;
    let baro = &diagnosed["diagnosis"]["sensors"]["baro"];
    assert_eq!(baro["missing"], json!(["baro.dynamic_pressure"]));
    let sentence = diagnosed["headline"]["sentence"].as_str().unwrap();
    assert!(
        sentence.starts_with("Your barometer reads up to ") && sentence.contains("static-port error"),
        "{sentence}"
    );
    assert!(
        sentence.contains(" m/s") && sentence.contains(" ± ") && sentence.contains("the error falls from"),
        "{sentence}"
    );

    let add = json!({
        "effect": "baro.dynamic_pressure", "flights": [flight], "hold_outs": [], "model": default, "times": {},
        "estimate": false, "time_constant_s": null, "since": null, "date": "2026-01-31"
    });
    let added = Answer::of(&mut engine, "add", add).json;
    let coefficient = added["addition"]["coefficient"].as_f64().unwrap();
    let text = added["model"]["text"].as_str().unwrap();
    assert!(text.contains("baro.dynamic_pressure") && text.contains("2026-01-31"), "{text}");

    let acting = json!({ "effect": "baro.dynamic_pressure", "coefficient": coefficient, "time_constant_s": null, "since": null });
    let series = |engine: &mut Engine, model: &Value, pixels: u32| {
        let noise = &diagnosed["diagnosis"]["noise"];
        let found = if *model == default { json!([acting]) } else { json!([]) };
        let signals = json!([
            { "signal": "error", "sensor": "baro" },
            { "signal": "effect", "of": acting },
            { "signal": "beyond_reference", "sensor": "baro", "noise": noise, "found": found }
        ]);
        let of = json!({
            "flight": "f", "model": model, "times": {}, "signals": signals, "from_s": null, "to_s": null, "pixels": pixels
        });
        Answer::of(engine, "series", of)
    };
    let (before, after) = (series(&mut engine, &default, 400), series(&mut engine, &added["model"], 400));
    assert_eq!(before.array("/time_s"), after.array("/time_s"));
    let rms = |values: &[f64]| {
        let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        (known.iter().map(|value| value * value).sum::<f64>() / known.len() as f64).sqrt()
    };
    let free = 200..400;
    let error = |answer: &Answer| answer.array("/curves/0/least")[free.clone()].to_vec();
    assert!(
        rms(&error(&after)) < 0.6 * rms(&error(&before)),
        "{} {}",
        rms(&error(&after)),
        rms(&error(&before))
    );
    // The error before less the error after is the prediction, except that the calibration estimates a
    // different bias.
    let predicted = &before.array("/curves/1/least")[free.clone()];
    let left: Vec<f64> =
        error(&before).iter().zip(&error(&after)).zip(predicted).map(|((b, a), p)| b - a - p).collect();
    assert!(rms(&left) < 0.25 * rms(predicted), "{} {}", rms(&left), rms(predicted));
    // The error beyond the reference is smaller, and its sigma is that of a wander of metres.
    let beyond = &after.array("/curves/2/least")[free.clone()];
    assert!(rms(beyond) < rms(&error(&after)), "{} {}", rms(beyond), rms(&error(&after)));
    let sigma = after.array("/curves/2/sigma");
    assert!(sigma.iter().all(|sigma| sigma.is_nan() || (0.0..20.0).contains(sigma)));

    let ribbons = Answer::of(&mut engine, "ribbons", json!({ "flight": "f", "model": default, "times": {} }));
    assert_eq!(ribbons.json["phases"][0]["what"], "settling");
    assert_eq!(ribbons.json["phases"][2]["what"], "free_flight");
    assert!(ribbons.json["bounds_m"]["baro"].as_f64().unwrap() > 0.0);
    let spans = ribbons.json["manoeuvres"].as_array().unwrap();
    assert!(spans.windows(2).all(|pair| pair[0]["to_s"] == pair[1]["from_s"]), "{spans:?}");

    let scatter = json!({
        "flight": "f", "model": default, "times": {}, "x": { "signal": "column", "name": "tas_mps" },
        "y": { "signal": "error", "sensor": "baro" }, "from_s": null, "to_s": null, "at_most": 500
    });
    let points = Answer::of(&mut engine, "scatter", scatter);
    assert!(points.array("/x").len() <= 500 && points.array("/x").len() == points.array("/y").len());
    assert_eq!((&points.json["x_unit"], &points.json["y_unit"]), (&json!("m/s"), &json!("m")));

    let correlation = json!({
        "flight": "f", "model": default, "times": {}, "signal": { "signal": "error", "sensor": "baro" }, "with": null,
        "from_s": null, "to_s": null, "longest_lag_s": 20.0
    });
    let found = Answer::of(&mut engine, "correlation", correlation);
    assert!((found.array("/correlation")[0] - 1.0).abs() < 1e-12);

    let ladder = json!({ "flights": ["f"], "model": added["model"], "times": {} });
    let revisions = Answer::of(&mut engine, "ladder", ladder).json;
    let rms_of = |revision: usize| {
        revisions["revisions"][revision]["flights"][0]["sensors"]["baro"]["free_flight_rms_m"]
            .as_f64()
            .unwrap()
    };
    assert!(rms_of(1) < rms_of(0), "{revisions}");

    formulas(&mut engine, &default, coefficient);
}

/// The same effect by the user's own formula.
fn formulas(engine: &mut Engine, default: &Value, learned: f64) {
    let check = |engine: &mut Engine, on: &str, regressor: &str| {
        let of = json!({
            "model": default, "id": null, "on": on, "regressor": regressor, "largest": null, "about": "", "flight": "f",
            "times": {}, "error": { "signal": "error", "sensor": "baro" }, "from_s": null
        });
        Answer::of(engine, "formula", of)
    };
    for (text, says, place) in [
        ("1 + tas_mps", "m/s", "tas_mps"),
        ("2 * \u{e9}flap", "", ""),
        ("tas_mps * flap", "This flight has no column 'flap'", "flap"),
        ("7", "cannot determine", "7"),
    ] {
        let checked = check(engine, "baro", text).json;
        let problem = &checked["problem"];
        assert!(problem["message"].as_str().unwrap().contains(says), "{checked}");
        assert!(checked["definition"].is_null(), "{checked}");
        let span = problem["from"].as_u64().unwrap() as usize..problem["to"].as_u64().unwrap() as usize;
        let units: Vec<u16> = text.encode_utf16().collect();
        assert!(String::from_utf16(&units[span]).unwrap().contains(place), "{checked}");
    }
    let own = check(engine, "baro", "tas_mps^2 / (2*g)");
    let definition = &own.json["definition"];
    let coefficient = definition["coefficient"].as_f64().unwrap();
    // The fit for display, which ignores the noise and other effects, is near the learned coefficient.
    assert!((coefficient - learned).abs() < 0.4 * learned.abs(), "{coefficient} {learned}");
    assert!(definition["explained"].as_f64().unwrap() > 0.4, "{definition}");
    assert_eq!(
        (&definition["effect"], &definition["unit"]),
        (&json!("baro.tas_mps"), &json!("1")),
        "{definition}"
    );
    let (x, y) = (own.array("/definition/x"), own.array("/definition/y"));
    assert!(x.len() == y.len() && x.len() > 100 && x.len() <= 400, "{}", x.len());

    // What if: the definition's curve equals the catalogue's.
    let curve = |engine: &mut Engine, model: &Value, effect: &str| {
        let acting = json!({ "effect": effect, "coefficient": 1.0, "time_constant_s": null, "since": null });
        let of = json!({
            "flight": "f", "model": model, "times": {}, "signals": [{ "signal": "effect", "of": acting }],
            "from_s": null, "to_s": null, "pixels": 400
        });
        Answer::of(engine, "series", of).array("/curves/0/least").to_vec()
    };
    let same = curve(engine, &definition["model"], "baro.tas_mps");
    let catalogue = curve(engine, default, "baro.dynamic_pressure");
    assert!(same.iter().zip(&catalogue).all(|(a, b)| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-3));
    assert!(same.iter().filter(|value| value.is_finite()).count() > 200);

    // An error of the reference has the opposite sign; an error of every sensor is its negative.
    let on = |engine: &mut Engine, on: &str| {
        let checked = check(engine, on, "tas_mps^2 / (2*g)").json;
        checked["definition"]["coefficient"].as_f64().unwrap()
    };
    let (gps, every) = (on(engine, "gps"), on(engine, "every sensor"));
    assert!((gps + coefficient).abs() < 1e-6 && (every - coefficient).abs() < 1e-6, "{gps} {every}");
}
