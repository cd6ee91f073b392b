//! Charts and tables in a page. Charts are drawn by uPlot, which the page includes; tables are HTML.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Number, Value};

use crate::chart::{Chart, Role};
use crate::table::{Align, Cell, Row, Table, Tone};

/// Defines `pylonCharts`, whose `draw(element, chart)` draws a [`Chart`] given as JSON.
pub const SCRIPT: &str = include_str!("../assets/charts.js");

/// The roles' colours on light and dark backgrounds, as variables of the page's style. The page itself
/// defines `--ink`, `--ground`, `--grid` and `--rule`.
#[must_use]
pub fn style() -> String {
    let mut style = String::from(":root {");
    for role in Role::ALL {
        let ink = role.ink();
        // Writing to a string never fails.
        let _ = write!(style, " --{}: light-dark({}, {});", role.name(), ink.light, ink.dark);
    }
    style + " }\n"
}

/// The diagrams by id as JSON, escaped so that no text in them can end the page element that contains them.
///
/// # Errors
/// Errors of [`serde_json`].
pub fn data<'a>(charts: impl Iterator<Item = &'a Chart>) -> Result<String, serde_json::Error> {
    let charts: BTreeMap<&str, &Chart> = charts.map(|chart| (chart.id.as_str(), chart)).collect();
    let mut charts = serde_json::to_value(&charts)?;
    round(&mut charts, VALUE_FIGURES);
    Ok(serde_json::to_string(&charts)?.replace('<', "\\u003c"))
}

/// A table as an HTML element. Columns of numbers have the class `number`, explanations are a `span` of the
/// class `note`, and toned cells have the class `good`, `doubt` or `bad`; the page's style defines their
/// appearance. The first cell of a row is its heading.
#[must_use]
pub fn table(table: &Table) -> String {
    let mut html = String::from("<table><thead><tr>");
    for column in &table.columns {
        push_cell(&mut html, "th scope=\"col\"", column.align, &Cell::from(column.name.as_str()));
    }
    html.push_str("</tr></thead><tbody>");
    for row in &table.rows {
        html.push_str("<tr>");
        match row {
            Row::Section(title) => {
                // Writing to a string never fails.
                let _ = write!(html, "<th scope=\"colgroup\" colspan=\"{}\">", table.columns.len());
                push_text(&mut html, title);
                html.push_str("</th>");
            }
            Row::Cells(cells) => {
                let empty = Cell::default();
                let cells = cells.iter().chain(std::iter::repeat(&empty));
                for (place, (column, cell)) in table.columns.iter().zip(cells).enumerate() {
                    push_cell(
                        &mut html,
                        if place == 0 { "th scope=\"row\"" } else { "td" },
                        column.align,
                        cell,
                    );
                }
            }
        }
        html.push_str("</tr>");
    }
    html + "</tbody></table>"
}

/// Appends a cell as the element `start`.
fn push_cell(html: &mut String, start: &str, align: Align, cell: &Cell) {
    let number = if align == Align::Right { "number" } else { "" };
    let tone = match cell.tone {
        Tone::Neutral => "",
        Tone::Good => "good",
        Tone::Doubt => "doubt",
        Tone::Bad => "bad",
    };
    html.extend(["<", start]);
    let classes = [number, tone].into_iter().filter(|class| !class.is_empty()).collect::<Vec<_>>().join(" ");
    if !classes.is_empty() {
        html.extend([" class=\"", &classes, "\""]);
    }
    html.push('>');
    push_text(html, &cell.text);
    if !cell.note.is_empty() {
        html.push_str("<span class=\"note\">");
        push_text(html, &cell.note);
        html.push_str("</span>");
    }
    html.extend(["</", start.split(' ').next().unwrap_or(start), ">"]);
}

/// Appends a text, escaped so that it cannot begin an element or a character reference.
fn push_text(html: &mut String, text: &str) {
    for letter in text.chars() {
        match letter {
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '&' => html.push_str("&amp;"),
            letter => html.push(letter),
        }
    }
}

/// Significant figures of a drawn value: centimetres for a kilometre.
const VALUE_FIGURES: i32 = 6;
/// Significant figures of a position on the axis: hundredths of a second for a day.
const PLACE_FIGURES: i32 = 7;

/// Rounds drawn numbers to what can be seen or read off; further digits would be most of a page's size.
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

    #[test]
    fn a_table_is_one_element_whose_texts_are_only_text() {
        let mut sample = Table::new().left("<sensor>").right("error, m");
        sample.row([Cell::explained("baro", "R&D"), Cell::toned("3", Tone::Bad)]);
        sample.section("after launch");
        sample.row(["imu"]);
        let expected = concat!(
            "<table><thead><tr><th scope=\"col\">&lt;sensor&gt;</th><th scope=\"col\" class=\"number\">error, m</th></tr></thead>",
            "<tbody><tr><th scope=\"row\">baro<span class=\"note\">R&amp;D</span></th>",
            "<td class=\"number bad\">3</td></tr>",
            "<tr><th scope=\"colgroup\" colspan=\"2\">after launch</th></tr>",
            "<tr><th scope=\"row\">imu</th><td class=\"number\"></td></tr></tbody></table>",
        );
        assert_eq!(table(&sample), expected);
    }
}
