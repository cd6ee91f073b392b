//! Draws a described diagram as a panel.

use std::ops::Range;

use plotters::style::RGBColor;

use super::panel::{Layer, Panel, range};
use crate::chart::{Chart, Level, Role, Values};

/// Which panels of a sheet have a legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legends {
    /// Only the first: the others have the same layers.
    First,
    /// Every panel.
    Each,
}

/// Diagrams over one horizontal axis, whose name is below the last.
#[must_use]
pub fn stack(charts: &[Chart], legends: Legends) -> Vec<Panel<'_>> {
    let mut panels: Vec<Panel<'_>> = charts.iter().map(Panel::of).collect();
    let last = panels.len().saturating_sub(1);
    for (place, panel) in panels.iter_mut().enumerate() {
        panel.has_legend = legends == Legends::Each || place == 0;
        if place != last {
            panel.x_name = "";
        }
    }
    panels
}

impl<'a> Panel<'a> {
    /// The layers of a described diagram, drawn in this order: bands, limits, curves, sigmas (a dense curve
    /// would hide them), moments.
    #[must_use]
    pub fn of(chart: &'a Chart) -> Self {
        let levels = |is_wanted: fn(Role) -> bool| {
            let wanted = chart.levels.iter().filter(move |level| is_wanted(level.role));
            wanted.map(|Level { name, role, y }| Layer::Level { value: *y, colour: line(*role), name })
        };
        let y_range = y_range(chart);
        let mut layers = Vec::new();
        layers.extend(chart.shades.iter().map(|shade| {
            let edge = |y: f64| vec![(shade.from, y), (shade.to, y)];
            Layer::Band {
                from: edge(y_range.start),
                to: edge(y_range.end),
                colour: area(Role::Shade),
                name: &shade.name,
            }
        }));
        layers.extend(chart.bands.iter().map(|band| Layer::Band {
            from: points(chart, &band.from),
            to: points(chart, &band.to),
            colour: area(band.role),
            name: &band.name,
        }));
        layers.extend(levels(|role| role != Role::Sigma));
        for drawn in &chart.lines {
            let (points, colour) = (points(chart, &drawn.y), line(drawn.role));
            if drawn.dots || drawn.knots {
                let name = if drawn.dots { drawn.name.as_str() } else { "" };
                layers.push(Layer::Dots { points: points.clone(), colour, name });
            }
            if !drawn.dots {
                layers.push(Layer::Curve {
                    points,
                    colour,
                    width: drawn.role.ink().width,
                    name: &drawn.name,
                });
            }
        }
        layers.extend(levels(|role| role == Role::Sigma));
        layers.extend(chart.moments.iter().map(|moment| Layer::Moment {
            at: moment.x,
            colour: line(moment.role),
            name: moment.name.clone(),
        }));
        layers.extend(chart.x_ticks.iter().map(|(at, name)| Layer::Place { at: *at, name }));
        Self {
            x_range: x_range(chart),
            y_range,
            x_name: &chart.x_name,
            y_name: chart.y_name.clone(),
            layers,
            has_legend: true,
        }
    }
}

/// The points of a column that have values: a curve is straight between them.
fn points(chart: &Chart, values: &Values) -> Vec<(f64, f64)> {
    chart.x.iter().zip(values).filter_map(|(x, y)| Some((*x, (*y)?))).collect()
}

fn x_range(chart: &Chart) -> Range<f64> {
    match (chart.x_range, chart.x.first(), chart.x.last()) {
        (Some([from, to]), _, _) => from..to,
        (None, Some(from), Some(to)) if from < to => *from..*to,
        _ => range(chart.x.iter().copied()),
    }
}

fn y_range(chart: &Chart) -> Range<f64> {
    if let Some([from, to]) = chart.y_range {
        return from..to;
    }
    let lines = chart.lines.iter().map(|line| &line.y);
    let columns = lines.chain(chart.bands.iter().flat_map(|band| [&band.from, &band.to]));
    range(columns.flatten().flatten().copied().chain(chart.levels.iter().map(|level| level.y)))
}

const fn line(role: Role) -> RGBColor {
    let [red, green, blue] = role.ink().line;
    RGBColor(red, green, blue)
}

const fn area(role: Role) -> RGBColor {
    let [red, green, blue] = role.ink().area;
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Moment, Shade};
    use crate::svg::sheet;

    /// One of everything.
    fn chart() -> Chart {
        let values = vec![Some(1.0), None, Some(2.0), Some(-1.0)];
        let mut chart =
            Chart::new("a".into(), "g".into(), "time, s", "error, m".into(), vec![0.0, 1.0, 2.0, 3.0])
                .band("spread", Role::Average, values.clone(), values.clone())
                .line("curve", Role::Modelled, values.clone())
                .line("dots", Role::Measured, values.clone())
                .line("knots", Role::Effect, values)
                .bound("limit", Role::Bound, Some(5.0))
                .bound("one sigma", Role::Sigma, Some(0.5));
        chart.lines[1].dots = true;
        chart.lines[2].knots = true;
        chart.moments.push(Moment { name: "launch".into(), role: Role::Event, x: 1.5 });
        chart.shades.push(Shade { name: "dive".into(), from: 0.5, to: 1.0 });
        chart.x_ticks = vec![(0.0, "at first".into()), (3.0, "at last".into())];
        chart
    }

    #[test]
    fn all_that_is_described_is_drawn() {
        let chart = chart();
        let panel = Panel::of(&chart);
        assert_eq!((panel.x_range.clone(), panel.y_range.start < -5.0), (0.0..3.0, true));
        let svg = sheet("Title", [String::new(), String::new()], &[panel]).unwrap();
        for text in [
            "Title",
            "time, s",
            "error, m",
            "spread",
            "curve",
            "dots",
            "knots",
            "limit",
            "one sigma",
            "launch",
            "dive",
            "at first",
            "at last",
        ] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text} in {svg}");
        }
        for role in [Role::Modelled, Role::Effect, Role::Bound, Role::Sigma, Role::Event] {
            let [red, green, blue] = role.ink().line;
            assert!(svg.contains(&format!("#{red:02X}{green:02X}{blue:02X}")), "{role:?}");
        }
        // Three dots and three knots, and one sample dot in the legend.
        assert_eq!(svg.matches("<circle").count(), 7, "{svg}");
    }

    #[test]
    fn named_places_stand_below_their_own_panel() {
        let charts = [chart(), chart()];
        let svg = sheet("", [String::new(), String::new()], &stack(&charts, Legends::First)).unwrap();
        // Vertical positions of the two panels' names, in the drawing's own pixels.
        let heights: Vec<f64> = svg
            .split("<text")
            .filter(|text| text.contains("\nat first\n"))
            .filter_map(|text| text.split(" y=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        let [above, below] = heights[..] else { panic!("{heights:?}") };
        // Two tall panels share the sheet below the title and its margin.
        let panel = 3.0 * (310.0 + 8.0 / 2.0);
        assert!((below - above - panel).abs() < 3.0, "{heights:?}");
    }

    #[test]
    fn a_curve_spans_places_where_it_has_no_value() {
        let chart = chart();
        let curves = Panel::of(&chart).layers.into_iter().find_map(|layer| match layer {
            Layer::Curve { points, .. } => Some(points),
            _ => None,
        });
        assert_eq!(curves.unwrap(), [(0.0, 1.0), (2.0, 2.0), (3.0, -1.0)]);
    }

    #[test]
    fn a_stack_has_one_axis_and_the_legends_that_were_asked_for() {
        let charts = [chart(), chart()];
        let told = |legends| {
            let panels = stack(&charts, legends);
            panels.iter().map(|panel| (panel.x_name.to_owned(), panel.has_legend)).collect::<Vec<_>>()
        };
        let (above, below) = (String::new(), "time, s".to_owned());
        assert_eq!(told(Legends::First), [(above.clone(), true), (below.clone(), false)]);
        assert_eq!(told(Legends::Each), [(above, true), (below, true)]);
    }
}
