//! Diagrams in a page: uPlot draws them, which the page brings along.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Number, Value};

use crate::chart::{Chart, Role};

/// Defines `pylonCharts`, whose `draw(element, chart)` draws a [`Chart`], given as its JSON.
pub const SCRIPT: &str = include_str!("../assets/charts.js");

/// The roles' colours on light and dark ground, as variables of the page's style. The page itself defines `--ink`, `--ground`,
/// `--grid` and `--rule`.
#[must_use]
pub fn style() -> String {
    let mut style = String::from(":root {");
    for role in Role::ALL {
        let ink = role.ink();
        // To a string, which never fails.
        let _ = write!(style, " --{}: light-dark({}, {});", role.name(), ink.light, ink.dark);
    }
    style + " }\n"
}

/// The diagrams by id as JSON, such that no text in them can end the element of the page that they stand in.
///
/// # Errors
/// What [`serde_json`] says.
pub fn data<'a>(charts: impl Iterator<Item = &'a Chart>) -> Result<String, serde_json::Error> {
    let charts: BTreeMap<&str, &Chart> = charts.map(|chart| (chart.id.as_str(), chart)).collect();
    let mut charts = serde_json::to_value(&charts)?;
    round(&mut charts, VALUE_FIGURES);
    Ok(serde_json::to_string(&charts)?.replace('<', "\\u003c"))
}

/// Figures of a value that is drawn: of a kilometre, centimetres.
const VALUE_FIGURES: i32 = 6;
/// Figures of a place on the axis: of a day, hundredths of a second.
const PLACE_FIGURES: i32 = 7;

/// Rounds what is drawn to what can be seen or read off; the digits beyond would be most of a page.
fn round(value: &mut Value, figures: i32) {
    match value {
        Value::Number(number) => {
            if let Some(rounded) = number.as_f64().and_then(|of| Number::from_f64(rounded(of, figures))) {
                *number = rounded;
            }
        }
        Value::Array(all) => all.iter_mut().for_each(|value| round(value, figures)),
        Value::Object(keys) => {
            for (key, value) in keys.iter_mut() {
                round(value, if key == "x" { PLACE_FIGURES } else { figures });
            }
        }
        _ => {}
    }
}

fn rounded(value: f64, figures: i32) -> f64 {
    if value == 0.0 {
        return value;
    }
    let decimals = figures - 1 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(decimals);
    if scale.is_finite() && scale > 0.0 { (value * scale).round() / scale } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_is_read_off() {
        assert_eq!(rounded(-1_234.567_89, 6).to_string(), "-1234.57");
        assert_eq!(rounded(0.000_123_456_789, 6).to_string(), "0.000123457");
        assert_eq!(rounded(86_400.017_5, 7).to_string(), "86400.02");
        assert_eq!([0.0, -3.0].map(|value| rounded(value, 6)), [0.0, -3.0]);
        let mut chart = Chart::new("a".to_owned(), String::new(), "t", String::new(), vec![86_400.017_5]);
        chart.y_range = Some([0.123_456_789, 1.0]);
        let read: Value = serde_json::from_str(&data([&chart].into_iter()).unwrap()).unwrap();
        assert_eq!((&read["a"]["x"][0], &read["a"]["y_range"][0]), (&86_400.02.into(), &0.123_457.into()));
    }

    #[test]
    fn no_text_ends_the_element_that_it_stands_in() {
        let name = "</script><script>alert(1)</script>";
        let chart = Chart::new("a".to_owned(), String::new(), name, String::new(), vec![0.0]);
        let data = data([&chart].into_iter()).unwrap();
        assert!(!data.contains('<'), "{data}");
        let read: serde_json::Value = serde_json::from_str(&data).unwrap();
        assert_eq!(read["a"]["x_name"], name);
    }
}
