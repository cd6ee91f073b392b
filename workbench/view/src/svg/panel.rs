//! One diagram of a figure.

use std::ops::Range;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::{Area, SCALE};
use super::{DrawingError, legend};

pub use plotters::style::BLACK;

/// Colour of an estimate.
pub const BLUE: RGBColor = RGBColor(0, 90, 160);
/// Colour of a dense series.
pub const LIGHT_BLUE: RGBColor = RGBColor(95, 155, 210);
/// Colour of the band around an estimate.
pub const PALE_BLUE: RGBColor = RGBColor(205, 224, 241);
/// Colour of an average.
pub const GREEN: RGBColor = RGBColor(0, 150, 60);
/// Colour of a limit.
pub const GREY: RGBColor = RGBColor(120, 120, 120);
/// Colour of a bound: dark enough to be visible over a dense blue series.
pub const ORANGE: RGBColor = RGBColor(150, 45, 0);
/// Colour of the area within a limit.
pub const PALE_GREY: RGBColor = RGBColor(238, 238, 238);
/// Colour of a moment of the flight.
pub const MAGENTA: RGBColor = RGBColor(214, 0, 170);

/// Height of the legend above a diagram, CSS pixels.
pub(super) const LEGEND_HEIGHT: i32 = 24;
/// Length of a dash, and of the gap after it.
pub(super) const DASH: i32 = 7 * SCALE;
pub(super) const GAP: i32 = 5 * SCALE;

/// Radius of a dot.
pub(super) const DOT: i32 = 2 * SCALE;

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Layers, drawn in this order, with bands below everything else. Their names appear in the legend, unless
/// empty.
#[derive(Clone, Debug)]
pub enum Layer<'a> {
    /// A filled area between two curves.
    Band {
        /// One edge.
        from: Vec<(f64, f64)>,
        /// The other.
        to: Vec<(f64, f64)>,
        /// Its colour.
        colour: RGBColor,
        /// Its name.
        name: &'a str,
    },
    /// A curve.
    Curve {
        /// The points that it passes through.
        points: Vec<(f64, f64)>,
        /// Its colour.
        colour: RGBColor,
        /// Its width, half CSS pixels.
        width: i32,
        /// Its name.
        name: &'a str,
    },
    /// A dashed horizontal line.
    Level {
        /// Its value.
        value: f64,
        /// Its colour.
        colour: RGBColor,
        /// Its name.
        name: &'a str,
    },
    /// Dots.
    Dots {
        /// Their positions.
        points: Vec<(f64, f64)>,
        /// Their colour.
        colour: RGBColor,
        /// Their name.
        name: &'a str,
    },
    /// A named position on the horizontal axis; with these, the axis has no numbers.
    Place {
        /// Its position.
        at: f64,
        /// Its name.
        name: &'a str,
    },
    /// A vertical line.
    Moment {
        /// Its position.
        at: f64,
        /// Its colour.
        colour: RGBColor,
        /// Its name.
        name: String,
    },
}

impl Layer<'_> {
    /// The name in the legend; empty if it has none.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Band { name, .. } | Self::Curve { name, .. } | Self::Level { name, .. } => name,
            Self::Dots { name, .. } => name,
            Self::Moment { name, .. } => name,
            Self::Place { .. } => "",
        }
    }
}

/// A diagram: layers over axes.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Range of the horizontal axis.
    pub x_range: Range<f64>,
    /// Range of the vertical axis; anything outside is cut off.
    pub y_range: Range<f64>,
    /// Name of the horizontal axis, with its unit.
    pub x_name: &'a str,
    /// Name of the vertical axis, with its unit.
    pub y_name: String,
    /// The layers.
    pub layers: Vec<Layer<'a>>,
    /// Whether the panel has a legend above it.
    pub has_legend: bool,
}

impl Panel<'_> {
    pub(super) fn draw(&self, area: &Area<'_>) -> Result<(), DrawingError> {
        let mut chart = ChartBuilder::on(area)
            .margin_left(8 * SCALE)
            .margin_right(18 * SCALE)
            .margin_top(if self.has_legend { LEGEND_HEIGHT * SCALE } else { 4 * SCALE })
            .margin_bottom(6 * SCALE)
            .x_label_area_size(36 * SCALE)
            .y_label_area_size(62 * SCALE)
            .build_cartesian_2d(self.x_range.clone(), self.y_range.clone())?;
        for layer in self.layers.iter().filter(|layer| matches!(layer, Layer::Band { .. })) {
            self.draw_layer(area, &mut chart, layer)?;
        }
        let text = |size: i32| ("sans-serif", size * SCALE).into_font();
        let decimals = if self.y_range.end - self.y_range.start < 4.0 { 1 } else { 0 };
        let has_places = self.layers.iter().any(|layer| matches!(layer, Layer::Place { .. }));
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(215, 215, 215).stroke_width(SCALE as u32 / 2))
            .axis_style(RGBColor(60, 60, 60).stroke_width(SCALE as u32))
            .set_all_tick_mark_size(4 * SCALE)
            .x_labels(11)
            .y_labels(6)
            .x_desc(self.x_name)
            .y_desc(&self.y_name)
            .axis_desc_style(text(13))
            .label_style(text(12))
            .y_label_formatter(&|value| format!("{:.decimals$}", value + 0.0))
            .x_label_formatter(&|value| {
                if has_places { String::new() } else { format!("{}", (value * 1e3).round() / 1e3) }
            })
            .draw()?;
        for layer in self.layers.iter().filter(|layer| !matches!(layer, Layer::Band { .. })) {
            self.draw_layer(area, &mut chart, layer)?;
        }
        if self.has_legend {
            legend::draw(area, &self.layers)?;
        }
        Ok(())
    }

    fn draw_layer(
        &self,
        sheet: &Area<'_>,
        chart: &mut Chart<'_, '_>,
        layer: &Layer<'_>,
    ) -> Result<(), DrawingError> {
        match layer {
            Layer::Band { from, to, colour, .. } => {
                let mut outline = self.clamped(from);
                outline.extend(self.clamped(to).into_iter().rev());
                chart.draw_series([Polygon::new(outline, colour.filled())])?;
            }
            Layer::Curve { points, colour, width, .. } => {
                let style = colour.stroke_width((*width * SCALE / 2) as u32);
                for part in clipped(points, &self.y_range) {
                    chart.draw_series(LineSeries::new(part, style))?;
                }
            }
            Layer::Level { value, colour, .. } => {
                let line = [(self.x_range.start, *value), (self.x_range.end, *value)];
                let style = colour.stroke_width(2 * SCALE as u32);
                chart.draw_series(DashedLineSeries::new(line, DASH, GAP, style))?;
            }
            Layer::Dots { points, colour, .. } => {
                let inside = points.iter().filter(|(_, y)| self.y_range.contains(y));
                let dot = |point: &(f64, f64)| Circle::new(*point, DOT, colour.filled());
                chart.draw_series(inside.map(dot))?;
            }
            Layer::Place { at, name } => {
                let below = (at - self.x_range.start) / (self.x_range.end - self.x_range.start);
                let area = chart.plotting_area();
                // Both are in pixels of the whole sheet; text is positioned within the panel.
                let (across, down) = (area.get_x_axis_pixel_range(), area.get_y_axis_pixel_range());
                let (left, top) = sheet.get_base_pixel();
                let x = across.start + (below * f64::from(across.end - across.start)) as i32 - left;
                let style = TextStyle::from(("sans-serif", 12 * SCALE).into_font());
                let style = style.pos(Pos::new(HPos::Center, VPos::Top));
                let y = down.start.max(down.end) + 7 * SCALE - top;
                sheet.draw_text(name, &style, (x, y))?;
            }
            Layer::Moment { at, colour, .. } => {
                let line = [(*at, self.y_range.start), (*at, self.y_range.end)];
                chart.draw_series(LineSeries::new(line, colour.stroke_width(2 * SCALE as u32)))?;
            }
        }
        Ok(())
    }

    /// Limits points to the diagram, because the backend does not clip.
    fn clamped(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let y = |value: f64| value.clamp(self.y_range.start, self.y_range.end);
        points.iter().map(|&(x, value)| (x, y(value))).collect()
    }
}

/// The parts of a line that lie within the range, cut at its limits.
fn clipped(points: &[(f64, f64)], range: &Range<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut is_open = false;
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        // Fractions of the segment at which it enters and leaves the range.
        let (mut enter, mut leave) = (0.0, 1.0);
        if y0 == y1 {
            if !(range.start..=range.end).contains(&y0) {
                is_open = false;
                continue;
            }
        } else {
            let at = |level: f64| (level - y0) / (y1 - y0);
            let (low, high) = (at(range.start), at(range.end));
            enter = f64::max(enter, low.min(high));
            leave = f64::min(leave, low.max(high));
        }
        if enter >= leave {
            is_open = false;
            continue;
        }
        let point = |share: f64| (x0 + share * (x1 - x0), y0 + share * (y1 - y0));
        if !is_open || enter > 0.0 {
            parts.push(vec![point(enter)]);
        }
        if let Some(part) = parts.last_mut() {
            part.push(point(leave));
        }
        is_open = leave == 1.0;
    }
    parts
}

/// Range of the finite values, with a margin; never empty.
pub fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (least, greatest) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), value| {
            (least.min(value), greatest.max(value))
        });
    if least > greatest {
        return -1.0..1.0;
    }
    let margin = (0.06 * (greatest - least)).max(0.05);
    least - margin..greatest + margin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_where_they_leave_the_diagram() {
        let line = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, 0.0), (4.0, -4.0), (5.0, -4.0), (6.0, 4.0)];
        assert_eq!(
            clipped(&line, &(-1.0..1.0)),
            vec![
                vec![(0.0, 0.0), (0.5, 1.0)],
                vec![(1.5, 1.0), (2.0, 0.0), (3.0, 0.0), (3.25, -1.0)],
                vec![(5.375, -1.0), (5.625, 1.0)],
            ]
        );
        assert_eq!(clipped(&[(0.0, 9.0), (1.0, 8.0)], &(-1.0..1.0)), Vec::<Vec<(f64, f64)>>::new());
    }

    #[test]
    fn ranges_are_never_empty() {
        assert_eq!(range(std::iter::empty()), -1.0..1.0);
        let one = range([5.0, f64::NAN].into_iter());
        assert!(one.start < 5.0 && one.end > 5.0);
    }
}
