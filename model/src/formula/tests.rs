//! The program of a text, refused texts, and the place to which the refusal points.

use kf_core::effect::EffectId;
use kf_core::formula::{Evaluation, Frame, SIGNALS, Signal, Silent};
use proptest::prelude::*;

use super::*;

fn compiled(text: &str) -> Formula {
    Formula::compile(text, &mut Columns::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> FormulaError {
    Formula::compile(text, &mut Columns::default()).expect_err(text)
}

/// The value of a formula at a tick with these signals.
fn value(text: &str, signals: &[(Signal, f32)]) -> Result<f32, Silent> {
    let mut frame = Frame::default();
    frame.begin(0.005, false, false);
    for (signal, value) in signals {
        frame.set(signal.place(), *value);
    }
    Evaluation::new(compiled(text).program(), 10.0).step(&frame)
}

#[test]
fn arithmetic_is_as_it_is_written() {
    for (text, expected) in [
        ("1 + 2*3 - 4/8", 6.5),
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("(1+2)*3", 9.0),
        ("8 - 4 - 2", 2.0),
        ("8 / 4 / 2", 1.0),
        ("-(-3)", 3.0),
        ("2 * -3", -6.0),
        ("1.5e2 + .5", 150.5),
        ("abs(-3) + min(1, 2) + max(1, 2)", 6.0),
        ("clamp(7, 0, 5) + clamp(-7, -2, 5)", 3.0),
        ("sqrt(16) + 16^0.5 + 8^(1/3)", 10.0),
        ("exp(0) + ln(1) + cos(0) + sin(0)", 2.0),
        ("step(1) + step(0) + step(-1)", 1.0),
        ("(1 < 2) + (2 <= 2) + (3 > 2) + (2 >= 3) + (1 == 1) + (1 != 1)", 4.0),
        ("isa_altitude(isa_pressure(1000[m])) / 1[m]", 1000.0),
        ("isa_temperature(0) / 1[K] ", 288.15),
        ("isa_density(0) / 1[Pa s^2/m^2]", 1.225),
        ("tau / 1[s]", 10.0),
        ("2*pi", std::f32::consts::TAU),
    ] {
        let got = value(text, &[]).unwrap();
        assert!((got - expected).abs() <= 1e-4 * expected.abs(), "{text}: {got}, {expected}");
    }
}

#[test]
fn dimensions_come_out() {
    for (text, dimension) in [
        ("tas_mps^2 / (2*g)", "m"),
        ("aoa_rad * tas_mps^2 / (2*g)", "m rad"),
        ("integral2(load_factor) ", "s^2"),
        ("rate(baro_temp_c)", "K/s"),
        ("sqrt(tas_mps)", "m^(1/2)/s^(1/2)"),
        ("baro_pa / (isa_density(altitude_m) * g)", "m"),
        ("tas_mps * (tas_mps > 20[m/s])", "m/s"),
        ("max(0, tas_mps)", "m/s"),
        ("lowpass(delay(throttle, 2), tau)", "1"),
        ("gear_bay_c - captive(gear_bay_c)", "K"),
        ("flap_deg", "rad"),
        ("2*Omega*gps_ve_mps*cos_latitude + (gps_vn_mps^2 + gps_ve_mps^2) / R", "m/s^2"),
    ] {
        assert_eq!(compiled(text).dimension().to_string(), dimension, "{text}");
    }
    for (unit, written) in [
        ("1", "1"),
        ("s^2/m", "s^2/m"),
        ("1/rad", "1/rad"),
        ("m s^-2", "m/s^2"),
        ("m^(1/2)*K", "m^(1/2) K"),
        ("m^0.5", "m^(1/2)"),
    ] {
        assert_eq!(Dimension::of_unit(unit).unwrap().to_string(), written);
    }
    for bad in ["", "q", "m//s", "m/", "m^", "ms", "m^(1/0)"] {
        assert_eq!(Dimension::of_unit(bad), None, "{bad}");
    }
}

#[test]
fn what_is_wrong_is_said_where_it_is() {
    for (text, place, said) in [
        ("tas_mps + baro_temp_c", "tas_mps + baro_temp_c", "a sum of m/s and K"),
        ("throttle * (tas_mps > 20)", "tas_mps > 20", "a number with a unit is 20[m/s]"),
        ("exp(altitude_m)", "altitude_m", "exp of m, expected a plain number"),
        ("tas_mps^throttle", "throttle", "an exponent that changes in flight"),
        ("tas_mps^0.123456", "0.123456", "expected a whole number or a fraction"),
        ("sine(aoa_rad)", "sine(aoa_rad)", "no function 'sine'; nearest: sin"),
        ("2 * sin", "sin", "sin is a function"),
        ("max(1)", "max(1)", "expected 2 arguments"),
        ("delay(throttle, 61)", "61", "up to 60"),
        ("delay(throttle, t)", "t", "a time that changes in flight"),
        ("lowpass(throttle, tas_mps)", "tas_mps", "expected seconds"),
        ("throttle / 0", "throttle / 0", "always a division by zero"),
        ("baro.flop", "baro.flop", "no definition 'baro.flop'"),
        ("sin(tas_mps)", "tas_mps", "expected radians"),
        ("1e39 * throttle", "1e39", "expected a number that f32 holds"),
        ("throttle +", "", "the formula ends here, expected a number, a signal"),
        ("throttle $ 2", "$", "'$' is not expected here, expected an operator"),
        ("(throttle", "", "expected an operator or ')'"),
        ("20[furlong] * throttle", "f", "a unit of m, s, K, Pa, rad"),
        ("a < b < c", "<", "'<' is not expected here"),
        ("a1+a2+a3+a4+a5+a6+a7+a8+a9", "a9", "one column too many"),
        ("", "", "the formula is empty"),
    ] {
        let error = refused(text);
        assert!(error.message.contains(said), "{text}: {}", error.message);
        assert_eq!(text.get(error.span.clone()).unwrap_or(""), place, "{text}: {error}");
    }
    let error = refused("throttle * (tas_mps > 20)");
    let shown = error.to_string();
    let lines: Vec<&str> = shown.lines().collect();
    assert_eq!(lines[1..], ["  throttle * (tas_mps > 20)", "              ^^^^^^^^^^^^"]);
}

#[test]
fn what_is_too_long_says_by_how_much() {
    let long = vec!["throttle"; 40].join(" + ");
    assert!(refused(&long).message.contains("79 operations, the flight computer has room for 48"));
    let deep = format!("{}throttle{}", "(1+".repeat(20), ")".repeat(20));
    assert!(refused(&deep).message.contains("nested too deeply"), "{}", refused(&deep));
    let memory = "delay(throttle,1)+delay(throttle,2)+delay(throttle,3)+delay(throttle,4)";
    assert!(refused(memory).message.contains("84 numbers of memory"), "{}", refused(memory));
    assert!(refused(&"(".repeat(999)).message.contains("expected"));
    assert!(refused(&"(".repeat(1001)).message.contains("expected at most 1000"));
}

#[test]
fn a_unit_must_make_metres() {
    let formula = compiled("aoa_rad * tas_mps^2 / (2*g)");
    assert!(formula.check_unit("1/rad").is_ok());
    let error = formula.check_unit("1").unwrap_err();
    assert!(error.message.contains("is in m rad") && error.message.contains("would be 1/rad"), "{error}");
    assert!(formula.check_unit("parsec").unwrap_err().message.contains("is not valid"));
}

#[test]
fn a_fingerprint_is_of_what_is_said_and_not_of_how() {
    let print = |text: &str| {
        let mut columns = Columns::default();
        Formula::compile(text, &mut columns).unwrap().fingerprint(&columns, &["baro", "1"])
    };
    assert_eq!(print("tas_mps^2/(2*g)*flap"), print("((tas_mps ^ 2) / (2 * g)) * flap"));
    for other in ["tas_mps^2/(2*g)*flaps", "tas_mps^2/(2.5*g)*flap", "tas_mps^3/(2*g)*flap"] {
        assert_ne!(print("tas_mps^2/(2*g)*flap"), print(other));
    }
    let mut columns = Columns::default();
    assert!(columns.declare("flap", Dimension::RADIAN));
    let declared = Formula::compile("tas_mps^2/(2*g)*flap", &mut columns).unwrap();
    assert_ne!(declared.fingerprint(&columns, &["baro", "1"]), print("tas_mps^2/(2*g)*flap"));
    assert_eq!(declared.dimension().to_string(), "m rad");
}

#[test]
fn what_has_no_value_says_why() {
    let throttle = |value| [(Signal::Throttle, value)];
    assert_eq!(value("1/throttle", &throttle(0.0)), Err(Silent::DivisionByZero));
    assert_eq!(value("throttle^-2", &throttle(0.0)), Err(Silent::DivisionByZero));
    assert_eq!(value("sqrt(throttle)", &throttle(-1.0)), Err(Silent::NoRoot));
    assert_eq!(value("ln(throttle)", &throttle(0.0)), Err(Silent::NoRoot));
    assert_eq!(value("throttle^0.3", &throttle(-1.0)), Err(Silent::NoRoot));
    assert_eq!(value("exp(1000*throttle)", &throttle(1.0)), Err(Silent::Overflow));
    assert_eq!(value("sin(1e6*throttle)", &throttle(1.0)), Err(Silent::OutOfRange));
    assert_eq!(value("throttle", &[]), Err(Silent::NotYet));
    // Infinity does not come back as 0.
    assert_eq!(value("1/exp(1000*throttle)", &throttle(1.0)), Err(Silent::Overflow));
    // A comparison with an invalid number has no value.
    assert_eq!(value("(1/throttle) > 2", &throttle(0.0)), Err(Silent::DivisionByZero));
}

#[test]
fn the_catalogue_compiles_and_its_units_are_right() {
    for effect in EffectId::ALL {
        let formula = compiled(of_catalogue(effect).unwrap());
        // The effects from theory are metres by themselves, a warm-up is a plain number times metres.
        formula.check_unit(effect.unit()).unwrap_or_else(|error| panic!("{}: {error}", effect.name()));
        assert_eq!(formula.program().has_time_constant(), effect.has_time_constant(), "{}", effect.name());
    }
}

/// Texts of the grammar, and some invalid ones.
fn formulas() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        prop::sample::select(vec![
            "throttle",
            "tas_mps",
            "t",
            "launch",
            "altitude_m",
            "aoa_rad",
            "baro_temp_c",
            "g",
            "tau",
            "0",
            "1",
            "1e30",
            "2[m/s]",
            "flap",
            "load_factor",
            "baro_pa"
        ])
        .prop_map(str::to_owned),
        (-1e3_f32..1e3).prop_map(|value| value.abs().to_string()),
    ];
    leaf.prop_recursive(5, 24, 3, |inner| {
        let function = prop::sample::select(FUNCTIONS.to_vec());
        prop_oneof![
            (
                inner.clone(),
                prop::sample::select(vec!["+", "-", "*", "/", "^", "<", ">=", "=="]),
                inner.clone()
            )
                .prop_map(|(a, op, b)| format!("({a}){op}({b})")),
            inner.clone().prop_map(|a| format!("-({a})")),
            (function, prop::collection::vec(inner, 1..=3)).prop_map(|(function, arguments)| {
                let count = function.arguments().min(arguments.len());
                format!("{}({})", function.name(), arguments[..count].join(","))
            }),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// For any text and any measurements: no panic, and only finite numbers in result and memory.
    #[test]
    fn no_formula_gives_what_is_no_number(
        text in formulas(),
        samples in prop::collection::vec((0_u8..SIGNALS as u8, prop_oneof![-2.0_f32..2.0, -1e6_f32..1e6, prop::num::f32::ANY]), 0..120),
        tau in prop_oneof![0.0_f32..100.0, prop::num::f32::ANY],
    ) {
        let Ok(formula) = Formula::compile(&text, &mut Columns::default()) else { return Ok(()) };
        let mut evaluation = Evaluation::new(formula.program(), tau);
        let mut frame = Frame::default();
        for (k, chunk) in samples.chunks(4).enumerate() {
            frame.begin(if k == 7 { 0.0 } else { 0.05 }, (10..14).contains(&k) || k > 16, k == 3);
            for (place, value) in chunk {
                frame.set(*place, *value);
            }
            if let Ok(value) = evaluation.step(&frame) {
                prop_assert!(value.is_finite(), "{text}: {value}");
            }
            prop_assert!(evaluation.state().iter().all(|word| word.is_finite()), "{text}: {:?}", evaluation.state());
        }
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,60}", place in 0_usize..60, cut in 0_usize..60) {
        let _ = Formula::compile(&text, &mut Columns::default()).map_err(|error| error.to_string());
        let whole = "tas_mps^2 / (2*g) * lowpass(flap, 2.5[s]) > delay(flap, tau)";
        let (a, b) = (place.min(cut), place.max(cut).min(whole.len()));
        if let Some(part) = whole.get(a.min(whole.len())..b) {
            let _ = Formula::compile(part, &mut Columns::default()).map_err(|error| error.to_string());
        }
    }

    /// A formula written back has the same meaning.
    #[test]
    fn what_is_written_reads_the_same(text in formulas()) {
        if let Ok(tree) = parse(&text) {
            let again = parse(&tree.to_string()).map_err(|error| TestCaseError::fail(error.to_string()))?;
            prop_assert_eq!(tree.to_string(), again.to_string());
        }
    }
}
