//! Diagrams in a page: uPlot draws them, which the page brings along.

use std::collections::BTreeMap;
use std::fmt::Write as _;

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
    Ok(serde_json::to_string(&charts)?.replace('<', "\\u003c"))
}

#[cfg(test)]
mod tests {
    use super::*;

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
