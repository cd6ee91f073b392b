//! The sheet that a figure is drawn on: its title, and its panels one above the other.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::DrawingError;
use super::panel::Panel;

/// The backend rounds to whole pixels; drawing three times as large makes the rounding invisible.
pub(super) const SCALE: i32 = 3;
/// Width of a figure in CSS pixels.
const WIDTH: i32 = 960;
/// Height of one panel, if there are several, and if there are one or two.
const PANEL_HEIGHT: i32 = 215;
const TALL_PANEL_HEIGHT: i32 = 310;
/// Height of the title.
const TITLE_HEIGHT: i32 = 72;
const DARK_GREY: RGBColor = RGBColor(90, 90, 90);
/// Longest subtitle, characters: longer ones are cut.
const SUBTITLE_CHARACTERS: usize = 150;

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws a title, two lines below it, and the panels. Lines that do not fit are cut.
///
/// # Errors
/// [`DrawingError`].
pub fn sheet(title: &str, subtitles: [String; 2], panels: &[Panel<'_>]) -> Result<String, DrawingError> {
    let subtitles = subtitles.map(shortened);
    let panel_height = if panels.len() > 2 { PANEL_HEIGHT } else { TALL_PANEL_HEIGHT };
    let height = TITLE_HEIGHT + panel_height * panels.len() as i32 + 8;
    let size = ((WIDTH * SCALE) as u32, (height * SCALE) as u32);
    let mut svg = String::new();
    {
        let sheet = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        lay_out(&sheet, title, &subtitles, panels)?;
        sheet.present()?;
    }
    Ok(at_true_size(&svg, size, height))
}

fn lay_out(
    sheet: &Area<'_>,
    title: &str,
    subtitles: &[String; 2],
    panels: &[Panel<'_>],
) -> Result<(), DrawingError> {
    sheet.fill(&WHITE)?;
    let (head, body) = sheet.split_vertically(TITLE_HEIGHT * SCALE);
    let centred = |size: i32, colour: &'static RGBColor| {
        let style = TextStyle::from(("sans-serif", size * SCALE).into_font());
        style.color(colour).pos(Pos::new(HPos::Center, VPos::Center))
    };
    let middle = WIDTH * SCALE / 2;
    head.draw_text(title, &centred(17, &BLACK), (middle, 18 * SCALE))?;
    for (line, text) in subtitles.iter().enumerate() {
        head.draw_text(text, &centred(12, &DARK_GREY), (middle, (40 + 17 * line as i32) * SCALE))?;
    }
    for (panel, area) in panels.iter().zip(body.split_evenly((panels.len(), 1))) {
        panel.draw(&area)?;
    }
    Ok(())
}

fn shortened(text: String) -> String {
    if text.chars().count() <= SUBTITLE_CHARACTERS {
        return text;
    }
    let cut: String = text.chars().take(SUBTITLE_CHARACTERS - 1).collect();
    format!("{cut}…")
}

/// Shows the drawing at its true size; its coordinates do not change.
fn at_true_size(svg: &str, size: (u32, u32), height: i32) -> String {
    let drawn = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    svg.replacen(&drawn, &format!("width=\"{WIDTH}\" height=\"{height}\""), 1)
}
