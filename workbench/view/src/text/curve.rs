//! Draws charts in characters: the curve of each in braille, one above the other over a common axis.

use std::fmt::Write as _;

use crate::chart::Chart;

/// Width of a picture, characters; each has two by four dots.
const ACROSS: usize = 64;

/// Draws the first curve of each chart, this many characters high; the axis, with its moments, is that of the
/// last chart. Two charts give a text of their heights plus four lines. A chart without values is left empty.
#[must_use]
pub fn stack(charts: &[(&Chart, usize)]) -> String {
    let mut text = String::new();
    for (chart, down) in charts {
        let _ = writeln!(text, "  {}", chart.y_name);
        let values = sampled(chart);
        let range = extremes(chart.lines.first().map_or(&[][..], |line| &line.y));
        let rows = dots(&values, range, *down);
        for (row, line) in rows.iter().enumerate() {
            let label = match row {
                0 => format!("{:.1}", range[1]),
                row if row + 1 == rows.len() => format!("{:.1}", range[0]),
                _ => String::new(),
            };
            let _ = writeln!(text, "{label:>10} ┤{line}");
        }
    }
    if let Some((chart, _)) = charts.last() {
        axis(&mut text, chart);
    }
    text
}

/// The axis and, below it, its ends and the names of its moments.
fn axis(text: &mut String, chart: &Chart) {
    let [start, end] = ends(chart);
    let unit = chart.x_name.rsplit_once(", ").map_or("", |(_, unit)| unit);
    let letter = |x: f64| ((x - start) / (end - start) * ACROSS as f64) as usize;
    let is_moment = |place: usize| chart.moments.iter().any(|moment| letter(moment.x) == place);
    let ticks: String = (0..ACROSS).map(|place| if is_moment(place) { '┴' } else { '─' }).collect();
    let _ = writeln!(text, "{:>10} └{ticks}", "");
    let mut labels = [' '; ACROSS];
    let mut put = |from: usize, label: &str| {
        for (place, letter) in labels.iter_mut().skip(from).zip(label.chars()) {
            *place = letter;
        }
    };
    for moment in &chart.moments {
        put(letter(moment.x).saturating_sub(moment.name.chars().count() / 2), &moment.name);
    }
    put(0, &format!("{start:.0} {unit}"));
    let last = format!("{end:.0} {unit}");
    put(ACROSS.saturating_sub(last.chars().count()), &last);
    let labels: String = labels.into_iter().collect();
    let _ = writeln!(text, "{:>12}{}", "", labels.trim_end());
}

/// Start and end of the axis; never equal.
fn ends(chart: &Chart) -> [f64; 2] {
    let of_data = [chart.x.first().copied().unwrap_or(0.0), chart.x.last().copied().unwrap_or(0.0)];
    let [start, end] = chart.x_range.unwrap_or(of_data);
    if end > start { [start, end] } else { [start, start + 1.0] }
}

/// The first curve's value at each column of dots: the last one at or before it.
fn sampled(chart: &Chart) -> Vec<Option<f64>> {
    let Some(line) = chart.lines.first() else { return Vec::new() };
    let [start, end] = ends(chart);
    let columns = 2 * ACROSS;
    let value = |column: usize| {
        let x = start + (end - start) * column as f64 / (columns - 1) as f64;
        let after = chart.x.partition_point(|place| *place <= x);
        line.y.iter().take(after).rev().find_map(|value| *value)
    };
    (0..columns).map(value).collect()
}

/// Minimum and maximum; never equal.
fn extremes(values: &[Option<f64>]) -> [f64; 2] {
    let present = || values.iter().flatten().copied();
    let (least, most) =
        (present().fold(f64::INFINITY, f64::min), present().fold(f64::NEG_INFINITY, f64::max));
    match (least, most) {
        _ if most > least => [least, most],
        _ if most == least => [least - 0.5, least + 0.5],
        _ => [0.0, 1.0],
    }
}

/// A curve in braille.
fn dots(values: &[Option<f64>], [least, most]: [f64; 2], down: usize) -> Vec<String> {
    /// The bit of each dot, by column and row.
    const BITS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
    let mut cells = vec![[0_u32; ACROSS]; down];
    let height = (4 * down).saturating_sub(1) as f64;
    let dot = |value: f64| ((most - value) / (most - least) * height).round().clamp(0.0, height) as usize;
    let mut before: Option<usize> = None;
    for (column, value) in values.iter().enumerate() {
        let Some(now) = value.map(dot) else { continue };
        // Fills the gaps of a steep curve.
        let (top, bottom) = match before {
            Some(before) if before < now => (before + 1, now),
            Some(before) if before > now => (now, before - 1),
            _ => (now, now),
        };
        for row in top..=bottom {
            if let (Some(line), Some(bits)) = (cells.get_mut(row / 4), BITS.get(column % 2))
                && let (Some(cell), Some(bit)) = (line.get_mut(column / 2), bits.get(row % 4))
            {
                *cell |= bit;
            }
        }
        before = Some(now);
    }
    let letter = |bits: &u32| char::from_u32(0x2800 + bits).unwrap_or(' ');
    cells.iter().map(|line| line.iter().map(letter).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Moment, Role};

    fn ramp() -> Chart {
        let x: Vec<f64> = (0..=128).map(f64::from).collect();
        let y = x.iter().map(|x| Some(*x)).collect();
        let mut chart = Chart::new(String::new(), String::new(), "time, s", "height, m".to_owned(), x).line(
            "",
            Role::Measured,
            y,
        );
        chart.moments.push(Moment { name: "launch".to_owned(), role: Role::Event, x: 64.0 });
        chart
    }

    #[test]
    fn a_ramp_rises_from_the_lower_left_to_the_upper_right() {
        let chart = ramp();
        let text = stack(&[(&chart, 2)]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 5, "{text}");
        assert_eq!(lines[0], "  height, m");
        let curve = |line: &str| line.split('┤').nth(1).unwrap().chars().collect::<Vec<_>>();
        let (upper, lower) = (curve(lines[1]), curve(lines[2]));
        assert!(lines[1].trim_start().starts_with("128.0 ┤") && lines[2].trim_start().starts_with("0.0 ┤"));
        // Eight rows of dots for 128 columns: half of the characters below, half above.
        let drawn = |line: &[char]| line.iter().filter(|letter| **letter != '\u{2800}').count();
        assert_eq!((drawn(&lower[..32]), drawn(&lower[33..])), (32, 0), "{text}");
        assert_eq!((drawn(&upper[..31]), drawn(&upper[32..])), (0, 32), "{text}");
    }

    #[test]
    fn the_axis_marks_moments_where_they_are() {
        let chart = ramp();
        let text = stack(&[(&chart, 2)]);
        let [.., axis, labels] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        let place = axis.chars().position(|letter| letter == '┴').unwrap();
        // Half way along 64 characters that begin in column 12.
        assert_eq!(place, 12 + 32);
        let name = labels.find("launch").unwrap();
        assert!((name..name + 6).contains(&place), "{text}");
        assert!(labels.trim_start().starts_with("0 s") && labels.ends_with("128 s"), "{text}");
    }

    #[test]
    fn a_step_has_no_hole_and_gaps_are_spanned() {
        let x: Vec<f64> = (0..128).map(f64::from).collect();
        let y = (0..128).map(|k| (k % 3 != 1).then(|| f64::from(u8::from(k >= 64)))).collect();
        let chart =
            Chart::new(String::new(), String::new(), "", String::new(), x).line("", Role::Measured, y);
        let text = stack(&[(&chart, 3)]);
        let column: Vec<char> =
            text.lines().skip(1).take(3).filter_map(|line| line.chars().nth(12 + 32)).collect();
        assert_eq!(column.len(), 3);
        assert!(column.iter().all(|letter| *letter != '\u{2800}'), "{text}");
    }

    #[test]
    fn an_empty_chart_is_an_empty_picture() {
        let chart = Chart::new(String::new(), String::new(), "time, s", "none".to_owned(), Vec::new());
        let text = stack(&[(&chart, 1)]);
        assert!(text.lines().nth(1).unwrap().ends_with(&"\u{2800}".repeat(ACROSS)), "{text}");
        assert_eq!(stack(&[]), "");
    }
}
