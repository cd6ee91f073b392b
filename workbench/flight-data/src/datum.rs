//! Altitude datums.

use super::{Channel, Header};

/// Datum of an altitude: what it is measured from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AltitudeDatum {
    /// Mean sea level.
    #[default]
    Msl,
    /// The WGS-84 ellipsoid.
    Ellipsoid,
    /// The level of 1013.25 hPa in the standard atmosphere: a pressure altitude. Only for single columns.
    Pressure,
}

/// Header key of a column's own datum: this, a space and the column's name.
pub(super) const KEY: &str = "altitude_datum";

impl AltitudeDatum {
    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Msl => "msl",
            Self::Ellipsoid => "ellipsoid",
            Self::Pressure => "pressure",
        }
    }

    /// The datum of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Msl, Self::Ellipsoid, Self::Pressure].into_iter().find(|datum| datum.name() == name)
    }

    /// For a sentence, after a column's name.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Msl => "above mean sea level",
            Self::Ellipsoid => "above the ellipsoid",
            Self::Pressure => "above 1013.25 hPa",
        }
    }
}

/// Whether a column of that name is an altitude.
#[must_use]
pub fn is_altitude(column: &str) -> bool {
    column.ends_with("alt_m") || column.ends_with("altitude_m")
}

/// The column whose datum a header key gives.
pub(super) fn column_of(key: &str) -> Option<&str> {
    key.trim().strip_prefix(KEY)?.strip_prefix(' ').map(str::trim)
}

impl Header {
    /// Datum of a column's altitudes: the value of its own key, `altitude_datum COLUMN`; else pressure for a
    /// barometric altitude, and [`Header::altitude_datum`] for any other.
    #[must_use]
    pub fn datum_of(&self, column: &str) -> AltitudeDatum {
        let own = self.other.iter().find(|(key, _)| column_of(key) == Some(column));
        own.and_then(|(_, value)| AltitudeDatum::from_name(value.trim())).unwrap_or_else(|| {
            if column == Channel::BaroAltM.name() { AltitudeDatum::Pressure } else { self.altitude_datum }
        })
    }

    /// Sets the datum of one column's altitudes.
    pub fn set_datum(&mut self, column: &str, datum: AltitudeDatum) {
        self.other.retain(|(key, _)| column_of(key) != Some(column));
        if self.datum_of(column) != datum {
            self.other.push((format!("{KEY} {column}"), datum.name().to_owned()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_its_own_datum_or_the_flights() {
        let mut header = Header { altitude_datum: AltitudeDatum::Ellipsoid, ..Header::default() };
        let of = |header: &Header, column| header.datum_of(column).name();
        assert_eq!(of(&header, "gps_alt_m"), "ellipsoid");
        assert_eq!(of(&header, "baro_alt_m"), "pressure");
        header.set_datum("imu_master_alt_m", AltitudeDatum::Msl);
        header.set_datum("baro_alt_m", AltitudeDatum::Msl);
        header.set_datum("gps_2_alt_m", AltitudeDatum::Ellipsoid);
        assert_eq!(header.other.len(), 2, "what is the flight's needs no key: {:?}", header.other);
        let all =
            ["gps_alt_m", "gps_2_alt_m", "imu_master_alt_m", "baro_alt_m"].map(|name| of(&header, name));
        assert_eq!(all, ["ellipsoid", "ellipsoid", "msl", "msl"]);
        header.set_datum("imu_master_alt_m", AltitudeDatum::Ellipsoid);
        assert_eq!(header.other, [("altitude_datum baro_alt_m".to_owned(), "msl".to_owned())]);
    }
}
