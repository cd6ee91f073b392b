//! Checks whether a column's values can be in the unit that its name states.
//!
//! A pressure of 950 Pa is really 950 hPa under the wrong name. Nothing is converted here: contradictions are
//! reported, with the unit that would fit.

use flight_data::{Channel, Column, Flight, Note};
use kf_core::atmosphere::pressure_altitude_m;

use super::quantity::{Quantity, Unit, plausible};
use super::signs;

/// Least number of samples for a report.
const LEAST_SAMPLES: usize = 20;
/// Lowest plausible pressure, Pa: no aircraft spends most of a flight at less.
const LEAST_PA: f64 = 2_000.0;
/// Least range of both altitudes, metres: over less, their scales cannot be compared.
const RANGE_M: f64 = 30.0;
/// Least correlation of two altitudes that are compared.
const CORRELATION: f64 = 0.98;
/// Largest number of fixes that are compared.
const MOST_PAIRS: usize = 2_000;
/// Largest time between a barometer's sample and a fix, seconds.
const NEAR_S: f64 = 1.0;
/// Rows beside a fix that are searched for a sample: a logger writes some hundred a second.
const NEAR_ROWS: usize = 500;
/// Largest relative error of a barometer's metre, in air that is far from the standard's temperature.
const METRE: f64 = 0.12;

/// Notes on columns whose values contradict their unit.
#[must_use]
pub fn notes(flight: &Flight) -> Vec<Note> {
    let of_columns = flight.channels.iter().filter_map(|(channel, column)| of_column(*channel, column));
    of_columns.chain(of_altitudes(flight)).map(Note::new).collect()
}

/// The 2nd and 98th percentiles: values beyond them may be wild cells.
fn ends(mut values: Vec<f64>) -> Option<(f64, f64)> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let at = |percent: usize| values.get(values.len() * percent / 100).copied();
    if values.len() < LEAST_SAMPLES { None } else { Some((at(2)?, at(98)?)) }
}

fn of_column(channel: Channel, column: &Column) -> Option<String> {
    let quantity = Quantity::of(channel.name())?;
    let (mut least, most) = plausible(channel.name())?;
    if quantity == Quantity::Pressure {
        least = LEAST_PA;
    }
    // Nearly every column is plausible: checked in one pass, without a copy.
    let is_plausible = |value: f32| !value.is_finite() || (least..=most).contains(&f64::from(value));
    if column.samples().all(|(_, value)| is_plausible(value)) {
        return None;
    }
    let (low, high) = ends(column.samples().map(|(_, value)| f64::from(value)).collect())?;
    let fits = |unit: &Unit| {
        let is_inside = |value: f64| (least..=most).contains(&(value * unit.factor + unit.offset));
        is_inside(low) && is_inside(high)
    };
    // A fast climb may reach almost zero pressure; most of such a flight is still lower.
    let contradicts = match quantity {
        Quantity::Pressure => high < least || low > most,
        _ => low < least || high > most,
    };
    if !contradicts {
        return None;
    }
    let own = quantity.units().next()?.name;
    let others: Vec<&str> =
        quantity.units().skip(1).filter(|unit| fits(unit)).map(|unit| unit.name).collect();
    let meant = if others.is_empty() {
        "they would be in no known unit".to_owned()
    } else {
        format!("they would be in {}", others.join(" or "))
    };
    Some(format!(
        "{}: values from {} to {} are not plausible in {own}; {meant}. Nothing is converted: write them in {own}, or read the \
         table with a mapping that gives their unit",
        channel.name(),
        low as f32,
        high as f32
    ))
}

/// The sample nearest to a row, within a second.
fn near(flight: &Flight, column: &Column, row: usize) -> Option<f32> {
    let time_s = *flight.time_s.get(row)?;
    let at = |row: usize| {
        let is_near = (flight.time_s.get(row)? - time_s).abs() <= NEAR_S;
        column.get(row).filter(|_| is_near)
    };
    (0..NEAR_ROWS).find_map(|away| row.checked_sub(away).and_then(at).or_else(|| at(row + away)))
}

/// Note on two altitudes of which one is not in metres.
fn of_altitudes(flight: &Flight) -> Option<String> {
    let has =
        |channel: &Channel| flight.channel(*channel).is_some_and(|column| column.samples().next().is_some());
    let own = [Channel::BaroPa, Channel::BaroAltM].into_iter().find(has)?;
    let (baro, column) = (own.name(), flight.channel(own)?);
    let metres = |pascals_or_metres: f32| match own {
        Channel::BaroPa => pressure_altitude_m(pascals_or_metres),
        _ => Some(pascals_or_metres),
    };
    let receiver = flight.channel(Channel::GpsAltM)?;
    // Some thousand fixes are as good as all.
    let stride = receiver.samples().count() / MOST_PAIRS + 1;
    let pairs: Vec<(f64, f64)> = receiver
        .samples()
        .step_by(stride)
        .filter_map(|(row, altitude)| {
            Some((f64::from(metres(near(flight, column, row)?)?), f64::from(altitude)))
        })
        .filter(|(own, other)| own.is_finite() && other.is_finite())
        .collect();
    let (low, high) = ends(pairs.iter().map(|pair| pair.0).collect())?;
    let (gps_low, gps_high) = ends(pairs.iter().map(|pair| pair.1).collect())?;
    if high - low < RANGE_M || signs::correlation(&pairs) < CORRELATION {
        return None;
    }
    let slope = (gps_high - gps_low) / (high - low);
    let is_near = |factor: f64| (slope * factor - 1.0).abs() < METRE;
    let units = || Quantity::Length.units().skip(1);
    let (name, unit) = match units().find(|unit| is_near(unit.factor)) {
        Some(unit) => ("gps_alt_m", unit),
        None => (baro, units().find(|unit| baro == "baro_alt_m" && is_near(1.0 / unit.factor))?),
    };
    Some(format!(
        "gps_alt_m changes {slope:.2} times as much as {baro}: {name} looks like {}, not metres. Nothing is converted: write it in m, \
         or read the table with a mapping that gives its unit",
        unit.name
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes on a climb of 120 m, with the columns that `text` makes from the altitude.
    fn said(names: &str, cells: impl Fn(f64) -> String) -> Vec<String> {
        let mut text = format!("# pylon-flight: 1\ntime_s,{names}\n");
        (0..600).for_each(|k| {
            text += &format!("{:.1},{}\n", f64::from(k) * 0.2, cells(500.0 + 0.2 * f64::from(k)))
        });
        let flight = flight_data::parse(text.as_bytes()).unwrap().0;
        notes(&flight).iter().map(|note| note.text().to_owned()).collect()
    }

    fn pressure_pa(metres: f64) -> f64 {
        101_325.0 * (1.0 - 2.255_77e-5 * metres).powf(5.255_88)
    }

    #[test]
    fn values_that_contradict_their_unit_are_said_with_the_one_that_fits() {
        let hectopascals = said("gps_alt_m,baro_pa", |m| format!("{m},{}", pressure_pa(m) / 100.0));
        let words = "are not plausible in Pa; they would be in hPa.";
        assert!(hectopascals.len() == 1 && hectopascals[0].contains(words), "{hectopascals:?}");
        let degrees = said("gps_alt_m,baro_alt_m,yaw_rad", |m| format!("{m},{m},{}", m % 360.0));
        assert!(degrees.len() == 1 && degrees[0].starts_with("yaw_rad: values from "), "{degrees:?}");
        assert!(degrees[0].contains("they would be in deg or mrad or cdeg"), "{degrees:?}");
        let kelvin = said("gps_alt_m,baro_alt_m,baro_temp_c", |m| format!("{m},{m},288.15"));
        assert!(
            kelvin.len() == 1 && kelvin[0].contains("not plausible in C; they would be in K"),
            "{kelvin:?}"
        );
    }

    #[test]
    fn an_altitude_in_feet_is_said_and_which_one() {
        let gps = said("gps_alt_m,baro_pa", |m| format!("{},{}", m / 0.3048, pressure_pa(m)));
        assert!(
            gps.len() == 1 && gps[0].contains("3.28 times") && gps[0].contains("gps_alt_m looks like ft"),
            "{gps:?}"
        );
        let baro = said("gps_alt_m,baro_alt_m", |m| format!("{m},{}", m / 0.3048));
        assert!(
            baro.len() == 1 && baro[0].contains("0.30 times") && baro[0].contains("baro_alt_m looks like ft"),
            "{baro:?}"
        );
    }

    #[test]
    fn what_is_as_it_should_be_is_not_talked_about() {
        let cells = |m: f64| format!("{m},{},{},0.5,-3.1,15,-9.8,2", pressure_pa(1.08 * m), m % 6.2);
        let names = "gps_alt_m,baro_pa,yaw_rad,throttle,roll_rad,oat_c,accel_z_mps2,gyro_x_radps";
        assert_eq!(said(names, cells), Vec::<String>::new());
        // Hardly any climb; one wild cell; no barometer at all.
        assert_eq!(
            said("gps_alt_m,baro_alt_m", |m| format!("{},{}", 3.28 * 0.1 * m, 0.1 * m)),
            Vec::<String>::new()
        );
        let wild = |m: f64| {
            if (m - 550.0).abs() < 1e-6 { format!("{m},950") } else { format!("{m},{}", pressure_pa(m)) }
        };
        assert_eq!(said("gps_alt_m,baro_pa", wild), Vec::<String>::new());
    }
}
