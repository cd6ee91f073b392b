//! A mapping file.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use serde::Deserialize;

use super::error::{MappingError, SignalError};
use super::quantity::Quantity;
use super::table::{Layout, Separator};
use flight_data::{AltitudeDatum, is_altitude, unit_slip};

/// The content of a mapping file (TOML).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// The format's version; 1.
    #[serde(rename = "pylon-mapping")]
    version: u32,
    /// The layout of the file; what is not given is detected.
    #[serde(default)]
    file: FileSection,
    /// The flight's own properties.
    #[serde(default)]
    pub flight: FlightSection,
    /// The time base.
    pub time: Option<TimeBase>,
    /// Signals of the flight by their names.
    #[serde(default)]
    pub signals: BTreeMap<String, Signal>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSection {
    separator: Option<String>,
    decimal: Option<String>,
    names_line: Option<usize>,
    first_line: Option<usize>,
}

/// The flight's properties in a mapping.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlightSection {
    /// The vehicle.
    #[serde(default)]
    pub vehicle: String,
    /// `msl` or `ellipsoid`.
    altitude_datum: Option<String>,
}

/// A column by its name, or by its index from 1.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum ColumnName {
    /// Index from 1.
    Place(usize),
    /// Name in the line of names.
    Name(String),
}

/// The source of the time.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeBase {
    /// The column; times of day and dates are detected.
    pub column: Option<ColumnName>,
    /// Its unit, if it is a number.
    pub unit: Option<String>,
    /// Without a column: rows a second.
    pub rate_hz: Option<f64>,
}

/// The source of a signal. Its value is the cell times `scale` plus `offset`, in `unit`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// The column.
    pub column: ColumnName,
    /// Its unit; by default the signal's own.
    pub unit: Option<String>,
    /// Factor applied before the unit.
    pub scale: Option<f64>,
    /// Offset added before the unit.
    pub offset: Option<f64>,
    /// Datum of an altitude, if it is not that of `[flight]`: `msl`, `ellipsoid` or `pressure`.
    datum: Option<String>,
    /// Whether the column repeats a sample until the next one; then only a value that differs from the row
    /// before is a sample.
    #[serde(default)]
    pub held: bool,
}

impl Mapping {
    /// Reads a mapping file's text.
    ///
    /// # Errors
    /// [`MappingError`], with the line where it is known.
    pub fn parse(text: &str) -> Result<Self, MappingError> {
        let mapping: Self = toml::from_str(text).map_err(|error| {
            if error.message().contains("missing field `pylon-mapping`") {
                return MappingError::NotAMapping;
            }
            let before = error.span().map(|span| text.get(..span.start).unwrap_or(text));
            let line = before.map(|before| NonZeroUsize::MIN.saturating_add(before.matches('\n').count()));
            MappingError::Syntax { line, source: Box::new(error) }
        })?;
        mapping.check()?;
        Ok(mapping)
    }

    fn check(&self) -> Result<(), MappingError> {
        if self.version != 1 {
            return Err(MappingError::Version(self.version));
        }
        self.datum()?;
        match &self.time {
            None => return Err(MappingError::NoTimeBase),
            Some(TimeBase { column: None, rate_hz: None, .. }) => return Err(MappingError::EmptyTimeBase),
            Some(TimeBase { column: Some(_), rate_hz: Some(_), .. }) => {
                return Err(MappingError::TwoTimeBases);
            }
            Some(TimeBase { rate_hz: Some(rate_hz), .. }) if !(*rate_hz > 0.0 && *rate_hz <= 1e5) => {
                return Err(MappingError::Rate(*rate_hz));
            }
            Some(TimeBase { unit: Some(unit), .. }) if Quantity::Time.unit(unit).is_none() => {
                return Err(MappingError::TimeUnit(unit.clone()));
            }
            Some(_) => {}
        }
        for (name, signal) in &self.signals {
            signal.check(name)?;
        }
        Ok(())
    }

    /// Datum of the altitudes.
    ///
    /// # Errors
    /// [`MappingError::Datum`].
    pub fn datum(&self) -> Result<AltitudeDatum, MappingError> {
        match self.flight.altitude_datum.as_deref() {
            None | Some("msl") => Ok(AltitudeDatum::Msl),
            Some("ellipsoid") => Ok(AltitudeDatum::Ellipsoid),
            Some(other) => Err(MappingError::Datum(other.to_owned())),
        }
    }

    /// Datums of single altitudes that have their own.
    pub fn datums(&self) -> impl Iterator<Item = (&str, AltitudeDatum)> {
        let own = |signal: &Signal| signal.datum.as_deref().and_then(AltitudeDatum::from_name);
        self.signals.iter().filter_map(move |(name, signal)| Some((name.as_str(), own(signal)?)))
    }

    /// Whether it gives the layout of the text.
    pub const fn says_layout(&self) -> bool {
        let file = &self.file;
        file.separator.is_some()
            || file.decimal.is_some()
            || file.names_line.is_some()
            || file.first_line.is_some()
    }

    /// The detected layout, overridden by what the mapping gives itself.
    ///
    /// # Errors
    /// A separator or decimal sign that does not exist; a layout that is neither detected nor given.
    pub fn layout(&self, found: Option<Layout>) -> Result<Layout, MappingError> {
        let file = &self.file;
        let separator = match file.separator.as_deref() {
            Some(name) => {
                Some(Separator::from_name(name).ok_or_else(|| MappingError::Separator(name.to_owned()))?)
            }
            None => None,
        };
        let decimal_comma = match file.decimal.as_deref() {
            Some(",") => Some(true),
            Some(".") => Some(false),
            Some(other) => return Err(MappingError::Decimal(other.to_owned())),
            None => None,
        };
        let names_line = file.names_line;
        let first_line = file.first_line.or_else(|| names_line.map(|line| line + 1));
        if names_line.zip(first_line).is_some_and(|(names, first)| names >= first) {
            return Err(MappingError::NamesLine);
        }
        let layout = found.map(|found| Layout {
            separator: separator.unwrap_or(found.separator),
            decimal_comma: decimal_comma.unwrap_or(found.decimal_comma),
            names_line: names_line.unwrap_or(found.names_line),
            first_line: if file.first_line.is_some() || found.first_line <= names_line.unwrap_or(0) {
                first_line.unwrap_or(found.first_line)
            } else {
                found.first_line
            },
        });
        let said = || {
            Some(Layout {
                separator: separator?,
                decimal_comma: decimal_comma.unwrap_or(false),
                names_line: names_line.unwrap_or(0),
                first_line: first_line?,
            })
        };
        layout.or_else(said).ok_or(MappingError::NoLayout)
    }
}

impl Signal {
    fn check(&self, name: &str) -> Result<(), MappingError> {
        let is_a_name = name.trim() == name && !name.is_empty() && !name.contains(['\n', '\r', '\0']);
        if !is_a_name {
            return Err(MappingError::SignalName(name.to_owned()));
        }
        self.check_conversion(name)
            .map_err(|source| MappingError::Signal { name: name.to_owned(), source: Box::new(source) })
    }

    fn check_conversion(&self, name: &str) -> Result<(), SignalError> {
        if name == "time_s" {
            return Err(SignalError::IsTime);
        }
        let quantity = Quantity::of(name);
        if let (None, Some(known)) = (quantity, unit_slip(name)) {
            return Err(SignalError::OtherUnit { known });
        }
        if let Some(unit) = &self.unit {
            match quantity {
                None => return Err(SignalError::UnitOfOwn),
                Some(Quantity::Count) => return Err(SignalError::UnitOfCount),
                Some(quantity) if quantity.unit(unit).is_none() => {
                    return Err(SignalError::Unit { unit: unit.clone(), quantity });
                }
                Some(_) => {}
            }
        }
        if let Some(datum) = &self.datum
            && (AltitudeDatum::from_name(datum).is_none() || !is_altitude(name))
        {
            return Err(SignalError::Datum(datum.clone()));
        }
        if let Some(scale) = self.scale.filter(|scale| !scale.is_finite() || *scale == 0.0) {
            return Err(SignalError::Scale(scale));
        }
        if let Some(offset) = self.offset.filter(|offset| !offset.is_finite()) {
            return Err(SignalError::Offset(offset));
        }
        Ok(())
    }

    /// Factor and offset from a cell to the signal of that name.
    pub fn conversion(&self, name: &str) -> (f64, f64) {
        let unit =
            Quantity::of(name).zip(self.unit.as_deref()).and_then(|(quantity, unit)| quantity.unit(unit));
        let (factor, more) = unit.map_or((1.0, 0.0), |unit| (unit.factor, unit.offset));
        (self.scale.unwrap_or(1.0) * factor, self.offset.unwrap_or(0.0) * factor + more)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "pylon-mapping = 1\n[time]\ncolumn = \"t\"\nunit = \"ms\"\n[signals]\n";

    #[test]
    fn a_mapping_is_read_and_its_conversions_are_right() {
        let text = format!(
            "{GOOD}baro_pa = {{ column = 3, unit = \"hPa\", scale = 2.0, offset = 1.0 }}\noat_c = {{ column = \"T\", unit = \
             \"K\" }}\nflap = {{ column = \"F\" }}\n"
        );
        let mapping = Mapping::parse(&text).unwrap();
        assert_eq!(mapping.signals["baro_pa"].column, ColumnName::Place(3));
        assert_eq!(mapping.signals["baro_pa"].conversion("baro_pa"), (200.0, 100.0));
        assert_eq!(mapping.signals["oat_c"].conversion("oat_c"), (1.0, -273.15));
        assert_eq!(mapping.signals["flap"].conversion("flap"), (1.0, 0.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_was_expected() {
        for (text, words) in [
            ("", "no 'pylon-mapping = 1' in it"),
            ("pylon-mapping = 2\n", "version 2"),
            ("pylon-mapping = 1\n", "no [time]"),
            ("pylon-mapping = 1\n[time]\n", "neither column nor rate_hz"),
            ("pylon-mapping = 1\n[time]\nrate_hz = 0\n", "expected rows per second"),
            ("pylon-mapping = 1\n[time]\ncolumn = \"t\"\nunit = \"m\"\n", "unit 'm', expected one of s, ms"),
            ("pylon-mapping = 1\n[tme]\n", "line 2: unknown field `tme`"),
            (&format!("{GOOD}baro_hpa = {{ column = 1 }}\n"), "looks like baro_pa in another unit"),
            (&format!("{GOOD}baro_pa = {{ column = 1, unit = \"m\" }}\n"), "expected one of Pa, hPa"),
            (&format!("{GOOD}flap = {{ column = 1, unit = \"m\" }}\n"), "expected scale and offset"),
            (&format!("{GOOD}gps_sats = {{ column = 1, unit = \"1\" }}\n"), "expected no unit"),
            (
                &format!("{GOOD}flap = {{ column = 1, scale = 0 }}\n"),
                "scale is 0, expected a number other than 0",
            ),
            (&format!("{GOOD}flap = {{ columm = 1 }}\n"), "line 6: "),
            (&format!("{GOOD}time_s = {{ column = 1 }}\n"), "belongs under [time]"),
        ] {
            let error = Mapping::parse(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
