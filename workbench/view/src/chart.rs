//! Describes one diagram. `svg` draws it for paper; in a page, `assets/charts.js` draws it from its JSON.

use serde::Serialize;

/// A column of values; null where there is none, which curves and areas span.
pub type Values = Vec<Option<f64>>;

/// What a line or an area means; `palette.rs` gives each its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// As measured.
    Measured,
    /// Predicted by the model.
    Modelled,
    /// Measured minus modelled.
    Residual,
    /// A moving average of residuals.
    Average,
    /// The effect of a physical cause on a sensor.
    Effect,
    /// A limit that should not be exceeded.
    Bound,
    /// One standard deviation.
    Sigma,
    /// When a sensor became doubtful.
    Doubtful,
    /// When it became untrustworthy.
    Untrustworthy,
    /// A moment of the flight.
    Event,
    /// A stretch in which the model fails.
    Shade,
}

/// A diagram over a common axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chart {
    /// Its identifier among the diagrams of a page.
    pub id: String,
    /// Diagrams of one group share their zoom and cursor.
    pub group: String,
    /// Name of the horizontal axis, with its unit.
    pub x_name: String,
    /// Name of the vertical axis, with its unit.
    pub y_name: String,
    /// Unit of the values, for the read-out.
    pub unit: &'static str,
    /// Positions on the horizontal axis, ascending.
    pub x: Vec<f64>,
    /// Named positions, shown instead of the axis' numbers.
    pub x_ticks: Vec<(f64, String)>,
    /// Curves.
    pub lines: Vec<Line>,
    /// Areas between two curves.
    pub bands: Vec<Band>,
    /// Horizontal lines.
    pub levels: Vec<Level>,
    /// Vertical lines.
    pub moments: Vec<Moment>,
    /// Shaded stretches, where the model fails.
    pub shades: Vec<Shade>,
    /// Start and end of the horizontal axis, instead of the first and the last of `x`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_range: Option<[f64; 2]>,
    /// Start and end of the vertical axis; data outside can still be reached by zooming.
    pub y_range: Option<[f64; 2]>,
}

/// A curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// Its meaning.
    pub role: Role,
    /// Its values.
    pub y: Values,
    /// Whether the values are drawn as dots instead.
    pub dots: bool,
    /// Whether the values are marked on the curve.
    pub knots: bool,
}

/// An area.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Its name.
    pub name: String,
    /// Its meaning.
    pub role: Role,
    /// Its lower edge.
    pub from: Values,
    /// Its upper edge.
    pub to: Values,
}

/// A horizontal line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Level {
    /// Its name.
    pub name: String,
    /// Its meaning.
    pub role: Role,
    /// Its value on the vertical axis.
    pub y: f64,
}

/// A vertical line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Its name.
    pub name: String,
    /// Its meaning.
    pub role: Role,
    /// Its position on the horizontal axis.
    pub x: f64,
}

/// A shaded stretch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shade {
    /// What the aircraft was doing.
    pub name: String,
    /// Where it starts.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
}

impl Chart {
    /// An empty diagram.
    #[must_use]
    pub fn new(id: String, group: String, x_name: &str, y_name: String, x: Vec<f64>) -> Self {
        Self {
            id,
            group,
            x_name: x_name.to_owned(),
            y_name,
            unit: "m",
            x,
            x_ticks: Vec::new(),
            lines: Vec::new(),
            bands: Vec::new(),
            levels: Vec::new(),
            moments: Vec::new(),
            shades: Vec::new(),
            x_range: None,
            y_range: None,
        }
    }

    /// Adds a curve.
    #[must_use]
    pub fn line(mut self, name: &str, role: Role, y: Values) -> Self {
        self.lines.push(Line { name: name.to_owned(), role, y, dots: false, knots: false });
        self
    }

    /// Adds an area.
    #[must_use]
    pub fn band(mut self, name: &str, role: Role, from: Values, to: Values) -> Self {
        self.bands.push(Band { name: name.to_owned(), role, from, to });
        self
    }

    /// Adds two lines at plus and minus a bound, if there is one.
    #[must_use]
    pub fn bound(mut self, name: &str, role: Role, bound: Option<f64>) -> Self {
        if let Some(bound) = bound {
            self.levels.push(Level { name: name.to_owned(), role, y: bound });
            self.levels.push(Level { name: String::new(), role, y: -bound });
        }
        self
    }
}
