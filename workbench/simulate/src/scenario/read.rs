//! Reads a scenario; every error is one line.

use std::fmt;

use super::Scenario;
use super::problem::ScenarioProblem;

/// An error in a scenario: where it is, what it is, and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct ScenarioError {
    /// The file's name.
    pub file: String,
    /// Line of the file, where it is known.
    pub line: Option<usize>,
    /// What is wrong.
    #[source]
    pub problem: ScenarioProblem,
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl Scenario {
    /// Reads a scenario from text; `file` is the name used in errors.
    ///
    /// # Errors
    /// When the text is not TOML, has an unknown key or lacks one, or asks for something that cannot be
    /// simulated.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|error| ScenarioError {
            file: file.to_owned(),
            line: error.span().map(|span| line_of(text, span.start)),
            problem: ScenarioProblem::Syntax {
                hint: with_nearest_name(error.message()),
                source: Box::new(error),
            },
        })?;
        scenario.check().map_err(|problem| ScenarioError { file: file.to_owned(), line: None, problem })?;
        Ok(scenario)
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
}

/// Turns serde's "unknown field `x`, expected one of `a`, `b`" into a hint at the nearest name, if there is
/// one; always one line.
fn with_nearest_name(message: &str) -> String {
    let message = message.lines().map(str::trim).collect::<Vec<_>>().join("; ");
    if !message.starts_with("unknown ") {
        return message;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let Some(wrong) = quoted.next() else { return message };
    // At most a third of the letters may be wrong for a misspelling.
    let reach = (wrong.len() / 3).max(2);
    let nearest = quoted
        .map(|name| (strsim::damerau_levenshtein(wrong, name), name))
        .filter(|(distance, _)| *distance <= reach)
        .min_by_key(|(distance, _)| *distance);
    match (nearest, message.split_once(", expected")) {
        (Some((_, name)), Some((head, _))) => format!("{head}; did you mean `{name}`?"),
        _ => message,
    }
}

#[cfg(test)]
mod tests {
    use super::super::EffectId;
    use super::*;

    const MINIMAL: &str = "name = \"t\"\n[captive]\nduration_s = 1\naltitude_m = 500\nairspeed_mps = 28\n";

    fn error_of(text: &str) -> String {
        let error = Scenario::from_toml(text, "x.toml").unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    }

    #[test]
    fn the_shortest_scenario_is_valid() {
        let scenario = Scenario::from_toml(MINIMAL, "x.toml").unwrap();
        assert_eq!(scenario.launch_s(), None);
        assert_eq!(scenario.duration_s().to_bits(), 1.0_f64.to_bits());
    }

    #[test]
    fn errors_say_where_what_and_what_was_expected() {
        for (extra, expected) in [
            ("durashun = 3", "x.toml:6: unknown field `durashun`, expected one of `duration_s`, "),
            ("airspeed_mp = 3", "x.toml:6: unknown field `airspeed_mp`; did you mean `airspeed_mps`?"),
            (
                "[[effect]]\nid = \"baro.dynamic_presure\"\ncoefficient = 1",
                "x.toml:7: unknown variant `baro.dynamic_presure`; did you mean `baro.dynamic_pressure`?",
            ),
            ("[[effect]]\nid = \"baro.lag\"", "x.toml:6: missing field `coefficient`"),
            (
                "[[effect]]\nid = \"baro.warm_up\"\ncoefficient = 1",
                "x.toml: `effect[0]`: baro.warm_up needs `time_constant_s`",
            ),
            (
                "[[effect]]\nid = \"baro.lag\"\ncoefficient = nan",
                "x.toml: `effect[0].coefficient` is NaN: expected a finite number",
            ),
            (
                "[[effect]]\nid = \"baro.lag\"\ncoefficient = 1\nwidth_m = 2",
                "x.toml: `effect[0]`: baro.lag has no `width_m`",
            ),
            (
                "[sensors.baro.sampling]\nrate_hz = 400",
                "x.toml: `sensors.baro.sampling.rate_hz` is 400: expected at most the rows' 200 Hz",
            ),
            ("[sensors.gps.sampling]\nlatency_s = 1", "x.toml:6: missing field `rate_hz`"),
            (
                "[sensors.gps.noise]\nwander = 1",
                "x.toml: `sensors.gps.noise.wander_time_s` is 0: expected a number above 0",
            ),
            (
                "[[free_flight]]\nmanoeuvre = \"dive\"\nduration_s = 3",
                "x.toml: `free_flight[0]`: a dive needs `flight_path_deg` below 0",
            ),
            (
                "[[free_flight]]\nmanoeuvre = \"barrel_roll\"\nduration_s = 3",
                "x.toml:7: unknown variant `barrel_roll`, expected one of ",
            ),
            ("[captive]", "x.toml:6: duplicate key"),
            ("x = ", "x.toml:6: "),
        ] {
            let error = error_of(&format!("{MINIMAL}{extra}\n"));
            assert!(error.starts_with(expected), "{error}");
        }
        assert!(error_of("").starts_with("x.toml:1: missing field `name`"), "{}", error_of(""));
    }

    #[test]
    fn every_effect_can_be_named() {
        for id in EffectId::ALL {
            let extra = match id.name() {
                "baro.warm_up" | "gps.convergence" => "time_constant_s = 30",
                "baro.hysteresis" => "width_m = 5",
                _ => "",
            };
            let text = format!("{MINIMAL}[[effect]]\nid = \"{}\"\ncoefficient = 1\n{extra}\n", id.name());
            assert_eq!(Scenario::from_toml(&text, "x").unwrap().effect[0].id, *id);
        }
    }
}
