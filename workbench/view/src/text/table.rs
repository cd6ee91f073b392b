//! A table in characters.

use std::borrow::Cow;

use unicode_width::UnicodeWidthStr as _;

use super::printable::one_line;
use crate::table::{Align, Row, Table, Tone};

/// The SGR code for bold.
const BOLD: &str = "1";

/// The table's lines, without a line break at the end: the headings, a rule, the rows. With `colour`,
/// headings are bold and cells have the colours of their tones, by ANSI codes (ECMA-48, SGR); the characters
/// are otherwise the same. All control characters are escaped, including line breaks and tabs, so that a row
/// is a line.
#[must_use]
pub fn table(table: &Table, colour: bool) -> String {
    let style = |code: &'static str| if colour { code } else { "" };
    let headings = table.columns.iter().map(|column| (one_line(&column.name), style(BOLD))).collect();
    let rows = table.rows.iter().map(|row| match row {
        Row::Section(title) => vec![(one_line(title), style(BOLD))],
        Row::Cells(cells) => {
            cells.iter().map(|cell| (one_line(&cell.text), style(code(cell.tone)))).collect()
        }
    });
    let lines: Vec<Vec<(Cow<'_, str>, &str)>> = std::iter::once(headings).chain(rows).collect();
    let widths: Vec<usize> = (0..table.columns.len())
        .map(|k| lines.iter().filter_map(|line| line.get(k)).map(|(text, _)| text.width()).max().unwrap_or(0))
        .collect();
    let mut drawn: Vec<String> = lines.iter().map(|line| line_of(table, &widths, line)).collect();
    // A column, two spaces before it and one after it, and one at the end of the line.
    drawn.insert(1, "─".repeat(1 + widths.iter().map(|width| width + 3).sum::<usize>()));
    drawn.join("\n")
}

/// The colour's SGR code; none for [`Tone::Neutral`].
const fn code(tone: Tone) -> &'static str {
    match tone {
        Tone::Neutral => "",
        Tone::Good => "32",
        Tone::Doubt => "35",
        Tone::Bad => "31",
    }
}

/// One line, without trailing spaces.
fn line_of(table: &Table, widths: &[usize], cells: &[(Cow<'_, str>, &str)]) -> String {
    let mut line = String::new();
    let mut owed = 0;
    for ((column, width), (text, style)) in table.columns.iter().zip(widths).zip(cells) {
        let room = width.saturating_sub(text.width());
        let (before, after) = match column.align {
            Align::Left => (0, room),
            Align::Right => (room, 0),
        };
        owed += 2 + before;
        let shown = text.trim_end_matches(' ');
        if !shown.is_empty() {
            line.extend(std::iter::repeat_n(' ', owed));
            owed = text.len() - shown.len();
            if style.is_empty() {
                line.push_str(shown);
            } else {
                line.extend(["\x1b[", style, "m", shown, "\x1b[0m"]);
            }
        } else {
            owed += text.width();
        }
        owed += after + 1;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Cell;

    fn sample() -> Table {
        let mut sample = Table::new().left("sensor").right("error, m").left("");
        sample.row(["  baro", "12.5", "±"]);
        sample.section("a section that is longer than its column");
        sample.row([Cell::from("  imu"), Cell::toned("−1", Tone::Bad), Cell::from("")]);
        sample
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut sample = Table::new().left("sensor").right("error, m").left("");
        sample.row(["baro", "12.5", "±"]);
        sample.row(["imu_slave", "−1 ", ""]);
        sample.row(["Å\u{65e5}"]);
        let expected = concat!(
            "  sensor      error, m\n",
            "────────────────────────────\n",
            "  baro            12.5   ±\n",
            "  imu_slave        −1\n",
            "  Å\u{65e5}",
        );
        assert_eq!(table(&sample, false), expected);
    }

    /// With the colours stripped, the output is the same as without colours.
    #[test]
    fn colours_change_no_letter() {
        let coloured = table(&sample(), true);
        assert!(
            coloured.contains("\x1b[31m−1\x1b[0m") && coloured.contains("\x1b[1msensor\x1b[0m"),
            "{coloured:?}"
        );
        let mut stripped = coloured;
        for code in ["\x1b[0m", "\x1b[1m", "\x1b[31m"] {
            stripped = stripped.replace(code, "");
        }
        assert_eq!(stripped, table(&sample(), false));
    }

    #[test]
    fn no_text_leaves_its_row_or_reaches_the_terminal() {
        let mut hostile = Table::new().left("a\x1b[2J").right("b");
        hostile.row(["one\ntwo\x1b]0;title\x07", "3\t4"]);
        let text = table(&hostile, false);
        assert_eq!(text.lines().count(), 3, "{text}");
        assert!(!text.chars().any(|letter| letter.is_control() && letter != '\n'), "{text:?}");
        assert!(text.contains("one\\ntwo\\u{1b}]0;title\\u{7}") && text.contains("3\\t4"), "{text}");
    }

    #[test]
    fn a_table_without_rows_is_its_headings() {
        assert_eq!(table(&Table::new().left("a").right("b"), false), "  a   b\n─────────");
    }
}
