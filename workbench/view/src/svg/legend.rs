//! The names of a diagram's layers, in one line above it, where they cover nothing.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::DrawingError;
use super::canvas::{Area, SCALE};
use super::panel::{DASH, DOT, GAP, LEGEND_HEIGHT, Layer};

/// Length of a line's sample.
const SAMPLE: i32 = 20 * SCALE;
/// Space between a sample and its name, and between a name and the next sample.
const SPACE: i32 = 6 * SCALE;
const BETWEEN: i32 = 20 * SCALE;
/// Font size of the names, and the mean width of a character at that size.
const TEXT: i32 = 12 * SCALE;
const CHARACTER: i32 = TEXT * 56 / 100;
/// Right margin, the same as the diagram's.
const RIGHT: i32 = 18 * SCALE;

/// Draws the names of the layers that have one, right-aligned at the top of the area.
pub(super) fn draw(area: &Area<'_>, layers: &[Layer<'_>]) -> Result<(), DrawingError> {
    let named: Vec<&Layer<'_>> = layers.iter().filter(|layer| !layer.name().is_empty()).collect();
    let width_of = |layer: &Layer<'_>| SAMPLE + SPACE + CHARACTER * layer.name().chars().count() as i32;
    let width: i32 = named.iter().map(|layer| width_of(layer) + BETWEEN).sum::<i32>() - BETWEEN;
    let mut x = area.dim_in_pixel().0 as i32 - RIGHT - width;
    let y = LEGEND_HEIGHT * SCALE / 2;
    let style = TextStyle::from(("sans-serif", TEXT).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
    for layer in named {
        sample(area, layer, x, y)?;
        area.draw_text(layer.name(), &style, (x + SAMPLE + SPACE, y))?;
        x += width_of(layer) + BETWEEN;
    }
    Ok(())
}

fn sample(area: &Area<'_>, layer: &Layer<'_>, x: i32, y: i32) -> Result<(), DrawingError> {
    match layer {
        Layer::Band { colour, .. } => {
            let corners = [(x, y - 5 * SCALE), (x + SAMPLE, y + 5 * SCALE)];
            area.draw(&Rectangle::new(corners, colour.filled()))?;
        }
        Layer::Curve { colour, width, .. } => {
            let style = colour.stroke_width((*width * SCALE / 2) as u32);
            area.draw(&PathElement::new([(x, y), (x + SAMPLE, y)], style))?;
        }
        Layer::Level { colour, .. } => {
            for from in [x, x + DASH + GAP] {
                let to = (from + DASH).min(x + SAMPLE);
                area.draw(&PathElement::new([(from, y), (to, y)], colour.stroke_width(2 * SCALE as u32)))?;
            }
        }
        Layer::Dots { colour, .. } => {
            area.draw(&Circle::new((x + SAMPLE / 2, y), DOT, colour.filled()))?;
        }
        // Its name is on the axis itself.
        Layer::Place { .. } => {}
        Layer::Moment { colour, .. } => {
            let line = [(x + SAMPLE / 2, y - 7 * SCALE), (x + SAMPLE / 2, y + 7 * SCALE)];
            area.draw(&PathElement::new(line, colour.stroke_width(2 * SCALE as u32)))?;
        }
    }
    Ok(())
}
