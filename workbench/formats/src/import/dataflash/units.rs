//! Units and multipliers, as given by FMTU, UNIT and MULT messages.
//!
//! Source: ArduPilot, `libraries/AP_Logger/LogStructure.h`, `log_Units` and `log_Multipliers`.

use std::collections::BTreeMap;

/// A quantity in a flight's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Metres.
    Length,
    /// m/s.
    Speed,
    /// m/s^2.
    Acceleration,
    /// Radians.
    Angle,
    /// Degrees, as latitude and longitude are.
    Degrees,
    /// rad/s.
    AngularRate,
    /// Pascals.
    Pressure,
    /// Degrees Celsius.
    Temperature,
    /// A number, a count or a share.
    Plain,
}

/// Units by their identifiers: label, quantity, and factor to the flight's unit.
const UNITS: [(char, &str, Quantity, f64); 15] = [
    ('m', "m", Quantity::Length, 1.0),
    ('n', "m/s", Quantity::Speed, 1.0),
    ('N', "km/h", Quantity::Speed, 1.0 / 3.6),
    ('o', "m/s/s", Quantity::Acceleration, 1.0),
    ('d', "deg", Quantity::Angle, std::f64::consts::PI / 180.0),
    ('h', "degheading", Quantity::Angle, std::f64::consts::PI / 180.0),
    ('r', "rad", Quantity::Angle, 1.0),
    ('D', "deglatitude", Quantity::Degrees, 1.0),
    ('U', "deglongitude", Quantity::Degrees, 1.0),
    ('k', "deg/s", Quantity::AngularRate, std::f64::consts::PI / 180.0),
    ('E', "rad/s", Quantity::AngularRate, 1.0),
    ('P', "Pa", Quantity::Pressure, 1.0),
    ('O', "degC", Quantity::Temperature, 1.0),
    ('%', "%", Quantity::Plain, 0.01),
    ('S', "satellites", Quantity::Plain, 1.0),
];

/// Multipliers by their identifiers.
const MULTIPLIERS: [(char, f64); 16] = [
    ('-', 1.0),
    ('?', 1.0),
    ('2', 1e2),
    ('1', 1e1),
    ('0', 1.0),
    ('A', 1e-1),
    ('B', 1e-2),
    ('C', 1e-3),
    ('D', 1e-4),
    ('E', 1e-5),
    ('F', 1e-6),
    ('G', 1e-7),
    ('I', 1e-9),
    ('!', 3.6),
    ('/', 3600.0),
    ('\0', 1.0),
];

/// A log's definitions of its units.
#[derive(Clone, Debug, Default)]
pub struct Units {
    /// Unit and multiplier identifiers of a type's fields.
    of_type: BTreeMap<u8, (Vec<char>, Vec<char>)>,
    /// Labels that the log assigns to identifiers.
    labels: BTreeMap<char, String>,
    /// Multipliers that the log assigns to identifiers.
    multipliers: BTreeMap<char, f64>,
}

/// How to convert a field's number to the flight's unit.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Multiply by this factor.
    By(f64),
    /// The log gives no unit, or an unknown one.
    Unsaid,
    /// The log gives a unit of another quantity.
    Other(String),
}

impl Units {
    /// Adds the content of a FMTU message.
    pub fn of_type(&mut self, kind: u8, units: &str, multipliers: &str) {
        self.of_type.insert(kind, (units.chars().collect(), multipliers.chars().collect()));
    }

    /// Adds the content of a UNIT message.
    pub fn label(&mut self, id: char, label: String) {
        self.labels.insert(id, label);
    }

    /// Adds the content of a MULT message. The log stores multipliers with seven digits.
    pub fn multiplier(&mut self, id: char, multiplier: f64) {
        self.multipliers.insert(id, multiplier);
    }

    /// The field with a type's instance, if the log names one.
    pub fn instance_field(&self, kind: u8) -> Option<usize> {
        self.of_type.get(&kind)?.0.iter().position(|id| *id == '#')
    }

    /// Whether a field is in per cent.
    pub fn is_percent(&self, kind: u8, index: usize) -> bool {
        self.of_type.get(&kind).is_some_and(|(units, _)| units.get(index) == Some(&'%'))
    }

    /// How to convert a field to a quantity of a flight; `is_scaled`: its letter has a scale of its own.
    pub fn scale(&self, kind: u8, index: usize, is_scaled: bool, quantity: Quantity) -> Scale {
        let Some((units, multipliers)) = self.of_type.get(&kind) else { return Scale::Unsaid };
        let Some(id) = units.get(index).filter(|id| !matches!(id, '-' | '?' | '#' | '\0')) else {
            return Scale::Unsaid;
        };
        let label = self.labels.get(id).map(String::as_str);
        let known = |(own, name, ..): &&(char, &str, Quantity, f64)| match label {
            Some(label) => label == *name,
            None => own == id,
        };
        let Some((_, name, found, factor)) = UNITS.iter().find(known) else { return Scale::Unsaid };
        if *found != quantity {
            return Scale::Other((*name).to_owned());
        }
        let multiplier =
            if is_scaled { 1.0 } else { multipliers.get(index).map_or(1.0, |id| self.value(*id)) };
        Scale::By(factor * multiplier)
    }

    /// A multiplier's value: ArduPilot's for that identifier, else the log's. A single flipped bit in the
    /// log's value would scale a whole flight.
    fn value(&self, id: char) -> f64 {
        let known = MULTIPLIERS.iter().find_map(|(known, value)| (*known == id).then_some(*value));
        let given = self.multipliers.get(&id).copied().filter(|value| value.is_finite() && *value > 0.0);
        known.or(given).unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_and_its_multiplier_scale_a_field() {
        let mut units = Units::default();
        // Time, then centimetres a second as an integer, degrees in a scaled letter, hectopascals.
        units.of_type(7, "sndP#", "FBB2-");
        assert_eq!(units.scale(7, 1, false, Quantity::Speed), Scale::By(0.01));
        assert_eq!(units.scale(7, 2, true, Quantity::Angle), Scale::By(1_f64.to_radians()));
        assert_eq!(units.scale(7, 3, false, Quantity::Pressure), Scale::By(100.0));
        assert_eq!(units.scale(7, 3, false, Quantity::Length), Scale::Other("Pa".to_owned()));
        assert_eq!(units.scale(7, 4, false, Quantity::Plain), Scale::Unsaid);
        assert_eq!(units.scale(7, 9, false, Quantity::Plain), Scale::Unsaid);
        assert_eq!(units.scale(8, 1, false, Quantity::Speed), Scale::Unsaid);
        assert_eq!(units.instance_field(7), Some(4));
    }

    #[test]
    fn a_logs_own_labels_count_and_its_damaged_multipliers_do_not() {
        let mut units = Units::default();
        units.of_type(7, "xn", "xB");
        units.label('x', "rad/s".to_owned());
        units.multiplier('x', 2.0);
        units.multiplier('B', 1e30);
        assert_eq!(units.scale(7, 0, false, Quantity::AngularRate), Scale::By(2.0));
        assert_eq!(units.scale(7, 1, false, Quantity::Speed), Scale::By(0.01));
    }
}
