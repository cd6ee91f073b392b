//! Finds the unit that matches a measured factor.

use super::names::Hint;
use crate::import::mapping::quantity::Quantity;

/// A slope within this ratio of a unit's factor may mean it: half of the distance between metres a second and
/// knots.
const NEAR: f64 = 1.25;
/// If two units are both near, the slope must be this close to one of them to decide between them.
const CLOSE: f64 = 1.03;

/// A unit that matches a slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meant {
    /// Its name in mapping files.
    pub unit: &'static str,
    /// Its factor.
    pub factor: f64,
    /// Whether no other unit is possible.
    pub is_sure: bool,
    /// Whether the column's name gives the same unit; `None` if it gives none.
    pub is_as_named: Option<bool>,
}

/// The unit of a column if its values are worth `slope` of Pylon's unit each, whatever the sign; `None`
/// without a unit of such a factor.
pub fn meant(quantity: Quantity, slope: f64, hint: &Hint) -> Option<Meant> {
    let off = |factor: f64| (slope.abs() / factor).ln().abs();
    let mut near: Vec<_> = quantity.units().filter(|unit| off(unit.factor) < NEAR.ln()).collect();
    near.sort_by(|one, other| off(one.factor).total_cmp(&off(other.factor)));
    let named = hint.unit_of(quantity);
    if let Some(unit) = near.iter().find(|unit| Some(unit.name) == named) {
        return Some(Meant { unit: unit.name, factor: unit.factor, is_sure: true, is_as_named: Some(true) });
    }
    let first = near.first()?;
    let is_alone = near.len() == 1 || off(first.factor) < CLOSE.ln();
    Some(Meant {
        unit: first.name,
        factor: first.factor,
        is_sure: is_alone && named.is_none(),
        is_as_named: named.map(|_| false),
    })
}

/// What the unit in the name adds to the evidence.
pub fn name_agrees(meant: &Meant, hint: &Hint) -> String {
    match meant.is_as_named {
        Some(true) => ", as its name says".to_owned(),
        Some(false) => format!(", but its name says {}", hint.unit.as_deref().unwrap_or("another one")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_means_a_unit_and_the_name_decides_between_near_ones() {
        let meant = |slope, name: &str| meant(Quantity::Speed, slope, &Hint::new(name, ""));
        let unit = |slope, name| meant(slope, name).map(|meant| (meant.unit, meant.is_sure));
        assert_eq!(unit(0.98, "vn"), Some(("m/s", true)));
        assert_eq!(unit(-0.5, "vn"), Some(("kt", true)));
        assert_eq!(unit(0.47, "vn"), Some(("mph", false)));
        assert_eq!(unit(0.48, "vn_kt"), Some(("kt", true)));
        assert_eq!(unit(1.0, "vn_kt"), Some(("m/s", false)));
        assert_eq!(unit(3.0, "vn"), None);
    }
}
