//! Units of a mapping, and their conversion to Pylon's.

use flight_data::Channel;

/// The quantity that a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// In metres.
    Length,
    /// In pascals.
    Pressure,
    /// In metres a second.
    Speed,
    /// In metres a second squared.
    Acceleration,
    /// In radians.
    Angle,
    /// In radians a second.
    Rate,
    /// In degrees Celsius.
    Temperature,
    /// In seconds.
    Time,
    /// In degrees.
    Position,
    /// From 0 to 1.
    Share,
    /// A number without a unit.
    Count,
}

/// A unit: a value in Pylon's unit is `factor` times the value in this one, plus `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its name in mapping files.
    pub name: &'static str,
    /// Its quantity.
    pub quantity: Quantity,
    /// In Pylon's unit.
    pub factor: f64,
    /// Offset added after the factor.
    pub offset: f64,
    /// Other spellings, in lower case and without spaces.
    spellings: &'static [&'static str],
}

const fn unit(
    quantity: Quantity,
    name: &'static str,
    factor: f64,
    spellings: &'static [&'static str],
) -> Unit {
    Unit { name, quantity, factor, offset: 0.0, spellings }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Standard gravity (BIPM, the international system of units, 9th edition, 2019).
pub const GRAVITY: f64 = 9.806_65;
const FOOT: f64 = 0.304_8;
const KNOT: f64 = 1_852.0 / 3_600.0;

/// Every unit; for each quantity, Pylon's own comes first.
pub const UNITS: &[Unit] = &[
    unit(Quantity::Length, "m", 1.0, &["meter", "meters", "metre", "metres"]),
    unit(Quantity::Length, "ft", FOOT, &["feet", "foot"]),
    unit(Quantity::Length, "km", 1_000.0, &[]),
    unit(Quantity::Length, "cm", 0.01, &[]),
    unit(Quantity::Length, "mm", 0.001, &[]),
    unit(Quantity::Length, "FL", 100.0 * FOOT, &["fl"]),
    unit(Quantity::Pressure, "Pa", 1.0, &["pa", "pascal", "pascals"]),
    unit(Quantity::Pressure, "hPa", 100.0, &["hpa", "mbar", "mb", "millibar"]),
    unit(Quantity::Pressure, "kPa", 1_000.0, &["kpa"]),
    unit(Quantity::Pressure, "bar", 1e5, &[]),
    unit(Quantity::Pressure, "inHg", 3_386.389, &["inhg"]),
    unit(Quantity::Pressure, "mmHg", 133.322_387, &["mmhg", "torr"]),
    unit(Quantity::Pressure, "psi", 6_894.757, &[]),
    unit(Quantity::Pressure, "atm", 101_325.0, &[]),
    unit(Quantity::Speed, "m/s", 1.0, &["mps", "ms", "m_s", "ms-1", "m/sec", "meters/second"]),
    unit(Quantity::Speed, "km/h", 1.0 / 3.6, &["kmh", "kph", "km_h"]),
    unit(Quantity::Speed, "kt", KNOT, &["kts", "knot", "knots", "kn"]),
    unit(Quantity::Speed, "mph", 0.447_04, &[]),
    unit(Quantity::Speed, "ft/s", FOOT, &["fps", "ft_s"]),
    unit(Quantity::Speed, "ft/min", FOOT / 60.0, &["fpm", "ft_min"]),
    unit(Quantity::Speed, "cm/s", 0.01, &["cm_s", "cmps"]),
    unit(Quantity::Speed, "mm/s", 0.001, &["mm_s", "mmps"]),
    unit(
        Quantity::Acceleration,
        "m/s2",
        1.0,
        &["mps2", "m_s2", "ms2", "mss", "m/s/s", "m/s^2", "m/s\u{b2}", "ms-2"],
    ),
    unit(Quantity::Acceleration, "g", GRAVITY, &["gs", "gee"]),
    unit(Quantity::Acceleration, "mg", GRAVITY / 1_000.0, &[]),
    unit(Quantity::Acceleration, "ft/s2", FOOT, &["ft_s2", "ft/s^2", "fps2"]),
    unit(Quantity::Acceleration, "cm/s2", 0.01, &["cm_s2", "cm/s^2"]),
    unit(Quantity::Angle, "rad", 1.0, &["rads", "radian", "radians"]),
    unit(Quantity::Angle, "deg", DEGREE, &["\u{b0}", "degs", "degree", "degrees"]),
    unit(Quantity::Angle, "mrad", 0.001, &[]),
    unit(Quantity::Angle, "cdeg", DEGREE / 100.0, &["centideg"]),
    unit(Quantity::Rate, "rad/s", 1.0, &["radps", "rad_s", "rads", "rad/sec", "rad"]),
    unit(
        Quantity::Rate,
        "deg/s",
        DEGREE,
        &["dps", "degps", "deg_s", "\u{b0}/s", "degs", "deg/sec", "degrees/s", "deg"],
    ),
    unit(Quantity::Rate, "mrad/s", 0.001, &["mrad_s", "mradps"]),
    unit(Quantity::Rate, "mdeg/s", DEGREE / 1_000.0, &["mdps"]),
    unit(Quantity::Rate, "rpm", std::f64::consts::TAU / 60.0, &[]),
    unit(Quantity::Temperature, "C", 1.0, &["c", "degc", "\u{b0}c", "celsius", "deg_c"]),
    Unit { offset: -273.15, ..unit(Quantity::Temperature, "K", 1.0, &["k", "kelvin"]) },
    Unit {
        offset: -32.0 / 1.8,
        ..unit(Quantity::Temperature, "F", 1.0 / 1.8, &["f", "degf", "\u{b0}f", "fahrenheit"])
    },
    unit(Quantity::Temperature, "cC", 0.01, &["cdegc", "centidegc"]),
    unit(Quantity::Time, "s", 1.0, &["sec", "secs", "second", "seconds"]),
    unit(Quantity::Time, "ms", 1e-3, &["msec", "millis", "milliseconds", "millisecond"]),
    unit(Quantity::Time, "us", 1e-6, &["usec", "micros", "microseconds", "\u{b5}s", "\u{3bc}s"]),
    unit(Quantity::Time, "ns", 1e-9, &["nsec", "nanos", "nanoseconds"]),
    unit(Quantity::Time, "min", 60.0, &["minute", "minutes", "mins"]),
    unit(Quantity::Time, "h", 3_600.0, &["hour", "hours", "hr"]),
    unit(Quantity::Position, "deg", 1.0, &["\u{b0}", "degree", "degrees"]),
    unit(Quantity::Position, "rad", 1.0 / DEGREE, &["radian", "radians"]),
    unit(Quantity::Position, "degE7", 1e-7, &["dege7", "1e-7deg", "e7"]),
    unit(Quantity::Share, "1", 1.0, &["norm", "ratio"]),
    unit(Quantity::Share, "%", 0.01, &["percent", "pct"]),
];

impl Quantity {
    /// The quantity of a destination of that name; `None` for a separate signal, whose unit is not converted.
    pub fn of(destination: &str) -> Option<Self> {
        if matches!(destination, "latitude_deg" | "longitude_deg") {
            return Some(Self::Position);
        }
        use Channel as C;
        Some(match Channel::from_name(destination)? {
            C::GpsAltM | C::GpsVaccM | C::BaroAltM | C::ImuMasterAltM | C::ImuSlaveAltM => Self::Length,
            C::GpsVnMps | C::GpsVeMps | C::GpsVdMps | C::TasMps => Self::Speed,
            C::GpsTimeS => Self::Time,
            C::BaroPa => Self::Pressure,
            C::BaroTempC | C::OatC => Self::Temperature,
            C::AccelXMps2 | C::AccelYMps2 | C::AccelZMps2 => Self::Acceleration,
            C::GyroXRadps | C::GyroYRadps | C::GyroZRadps => Self::Rate,
            C::RollRad | C::PitchRad | C::YawRad | C::AoaRad | C::SideslipRad => Self::Angle,
            C::Throttle => Self::Share,
            C::Launch | C::LaunchDoubt | C::GpsSats => Self::Count,
        })
    }

    /// A unit of it by any of its spellings.
    pub fn unit(self, text: &str) -> Option<Unit> {
        let plain: String = text.trim().to_lowercase().split_whitespace().collect();
        let matching = |unit: &&Unit| {
            unit.quantity == self
                && (unit.name.to_lowercase() == plain || unit.spellings.contains(&plain.as_str()))
        };
        UNITS.iter().find(matching).copied()
    }

    /// Its units, Pylon's own first.
    pub fn units(self) -> impl Iterator<Item = &'static Unit> {
        UNITS.iter().filter(move |unit| unit.quantity == self)
    }

    /// Names of its units, for a message.
    pub fn unit_names(self) -> String {
        self.units().map(|unit| unit.name).collect::<Vec<_>>().join(", ")
    }
}

/// Bounds of a destination's values in any plausible flight, in its own unit.
pub fn plausible(destination: &str) -> Option<(f64, f64)> {
    Some(match Quantity::of(destination)? {
        Quantity::Pressure => (500.0, 120_000.0),
        Quantity::Length => (-1_000.0, 60_000.0),
        Quantity::Temperature => (-100.0, 150.0),
        Quantity::Speed => (-1_500.0, 1_500.0),
        Quantity::Acceleration => (-2_000.0, 2_000.0),
        Quantity::Rate => (-100.0, 100.0),
        Quantity::Angle => (-7.0, 7.0),
        Quantity::Position if destination == "latitude_deg" => (-90.0, 90.0),
        Quantity::Position => (-180.0, 360.0),
        Quantity::Share => (-0.01, 1.01),
        Quantity::Time | Quantity::Count => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_has_a_quantity_and_its_own_unit_comes_first() {
        for channel in Channel::ALL {
            let quantity = Quantity::of(channel.name()).unwrap();
            if quantity != Quantity::Count {
                assert_eq!(quantity.units().next().unwrap().factor, 1.0, "{}", channel.name());
            }
        }
        assert_eq!(Quantity::of("flap"), None);
    }

    #[test]
    fn units_are_found_by_their_spellings() {
        let factor = |quantity: Quantity, text: &str| quantity.unit(text).map(|unit| unit.factor);
        assert_eq!(factor(Quantity::Pressure, " mBar "), Some(100.0));
        assert_eq!(factor(Quantity::Speed, "ms"), Some(1.0));
        assert_eq!(factor(Quantity::Time, "ms"), Some(1e-3));
        assert_eq!(factor(Quantity::Acceleration, "m/s²"), Some(1.0));
        assert_eq!(factor(Quantity::Length, "Pa"), None);
        let kelvin = Quantity::Temperature.unit("K").unwrap();
        assert_eq!(300.0 * kelvin.factor + kelvin.offset, 300.0 - 273.15);
        let fahrenheit = Quantity::Temperature.unit("°F").unwrap();
        assert!((212.0 * fahrenheit.factor + fahrenheit.offset - 100.0).abs() < 1e-9);
    }
}
