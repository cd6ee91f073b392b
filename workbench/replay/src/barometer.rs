//! Checks whether the barometer's column was measured by a barometer, and the UAV's inertial altitude by an
//! inertial unit.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight, Note};

/// A copy differs from the receiver by rounding alone ([`rounding_m`]), and by this much arithmetic error,
/// metres. A barometer also differs by its noise, its lag and the air, however good the receiver is.
const ARITHMETIC_M: f64 = 0.01;
/// Coarsest resolution of a column, metres: larger steps are motion.
const COARSEST_M: f64 = 1.0;
/// Least range of the receiver's altitude, metres: over less, agreement may be chance.
const RANGE_M: f64 = 10.0;
/// A barometer that moved by less than this while the receiver moved by [`RANGE_M`] is stuck, metres.
const STUCK_M: f64 = 0.5;
/// Least number of samples for a verdict.
const LEAST_SAMPLES: usize = 20;

/// What is wrong with an altitude for the whole flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// It repeats one value while the vehicle climbs.
    Stuck,
    /// It is the receiver's altitude, plus a constant.
    Copied {
        /// The constant, metres.
        apart_m: f64,
    },
}

/// Checks the barometer against the receiver.
#[must_use]
pub fn check(flight: &Flight) -> Option<Fault> {
    let pressure = flight.channel(Channel::BaroPa).filter(|column| column.samples().next().is_some());
    let column = pressure.or_else(|| flight.channel(Channel::BaroAltM))?;
    let metres = |value: f32| if pressure.is_some() { pressure_altitude_m(value) } else { Some(value) };
    of_column(flight, column, &metres, rounding_m)
}

/// Checks the UAV's inertial altitude against the receiver. A navigation system that follows the fixes is
/// close to them, so that a copy is allowed the finer of the two roundings only.
#[must_use]
pub fn check_inertial(flight: &Flight) -> Option<Fault> {
    of_column(flight, flight.channel(Channel::ImuSlaveAltM)?, &Some, f64::min)
}

/// `rounding_m`: how much a copy may differ, by the smallest steps of the column and the receiver.
fn of_column(
    flight: &Flight,
    column: &Column,
    metres: &dyn Fn(f32) -> Option<f32>,
    rounding_m: fn(f64, f64) -> f64,
) -> Option<Fault> {
    let receiver = flight.channel(Channel::GpsAltM)?;
    let pairs: Vec<(f64, f64)> = column
        .samples()
        .filter_map(|(row, value)| Some((f64::from(metres(value)?), f64::from(receiver.get(row)?))))
        .filter(|(own, other)| own.is_finite() && other.is_finite())
        .collect();
    // One cell in fifty of either may be wild.
    let ends = |values: &dyn Fn(&(f64, f64)) -> f64| {
        let mut sorted: Vec<f64> = pairs.iter().map(values).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |percent: usize| sorted.get(sorted.len() * percent / 100).copied().unwrap_or(0.0);
        (at(2), at(98))
    };
    let range = |(least, most): (f64, f64)| most - least;
    if pairs.len() < LEAST_SAMPLES || range(ends(&|pair| pair.1)) < RANGE_M {
        return None;
    }
    if range(ends(&|pair| pair.0)) < STUCK_M {
        return Some(Fault::Stuck);
    }
    let apart = ends(&|(own, other)| own - other);
    let rounding_m = rounding_m(step(pairs.iter().map(|pair| pair.0)), step(pairs.iter().map(|pair| pair.1)));
    (range(apart) <= rounding_m + 2.0 * ARITHMETIC_M)
        .then_some(Fault::Copied { apart_m: 0.5 * (apart.0 + apart.1) })
}

/// Largest spread of the differences between two copies of one altitude, apart from a constant, when each is
/// rounded to whole steps: with equal steps the differences are two neighbouring multiples of the step.
fn rounding_m(one_m: f64, other_m: f64) -> f64 {
    if (one_m - other_m).abs() < 1e-3 { one_m } else { one_m + other_m }
}

/// The smallest step between neighbouring values, metres: an upper limit on the column's rounding.
fn step(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let steps = values.clone().zip(values.skip(1)).map(|(one, next)| (next - one).abs());
    // Smaller steps are arithmetic error.
    steps.filter(|step| *step > 1e-3).fold(COARSEST_M, f64::min)
}

impl Fault {
    /// A description for the user.
    #[must_use]
    pub fn sentence(self) -> String {
        match self {
            Self::Stuck => {
                "the barometer is stuck: it repeats one value for the whole flight while the receiver climbs"
                    .to_owned()
            }
            Self::Copied { apart_m } => {
                format!("no barometer: its column is a copy of the receiver's altitude, {apart_m:+.0} m")
            }
        }
    }

    /// The same of the UAV's inertial altitude.
    #[must_use]
    pub fn inertial_sentence(self) -> String {
        match self {
            Self::Stuck => {
                "the inertial altitude is stuck: it repeats one value for the whole flight while the receiver climbs"
                    .to_owned()
            }
            Self::Copied { apart_m } => {
                format!("no inertial altitude: its column is a copy of the receiver's altitude, {apart_m:+.0} m")
            }
        }
    }
}

/// What is wrong with the altitudes of a flight, in words; `None` if nothing is.
#[must_use]
pub fn faults(flight: &Flight) -> Option<String> {
    let faults: Vec<String> =
        [check(flight).map(Fault::sentence), check_inertial(flight).map(Fault::inertial_sentence)]
            .into_iter()
            .flatten()
            .collect();
    (!faults.is_empty()).then(|| faults.join("; "))
}

/// The notes on altitudes that measure nothing: stuck, copied, or dead, without a single finite value.
#[must_use]
pub fn notes(flight: &Flight) -> Vec<Note> {
    let baro = check(flight).map(|fault| format!("{}; no result for baro is valid", fault.sentence()));
    let inertial = check_inertial(flight)
        .map(|fault| format!("{}; no result for imu_slave is valid", fault.inertial_sentence()));
    let dead =
        [Channel::BaroPa, Channel::BaroAltM, Channel::ImuSlaveAltM].into_iter().filter_map(|channel| {
            let column = flight.channel(channel)?;
            let is_dead = column.samples().all(|(_, value)| !value.is_finite());
            is_dead.then(|| format!("{} is dead: it has no reading in the whole log", channel.name()))
        });
    baro.into_iter().chain(inertial).chain(dead).map(Note::new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_data::Column;

    fn flight(baro_m: impl Fn(usize, f32) -> f32) -> Flight {
        let mut flight = Flight::default();
        let (mut receiver, mut baro) = (Column::default(), Column::default());
        for row in 0..300 {
            let altitude_m = 400.0 + (0.7 * row as f32).floor();
            flight.time_s.push(row as f64);
            receiver.push(Some(altitude_m));
            baro.push(Some(baro_m(row, altitude_m)));
        }
        flight.set_channel(Channel::GpsAltM, receiver);
        flight.set_channel(Channel::BaroAltM, baro);
        flight
    }

    #[test]
    fn a_barometer_is_told_from_what_is_none() {
        assert_eq!(check(&flight(|_, altitude_m| altitude_m + 47.0)), Some(Fault::Copied { apart_m: 47.0 }));
        let wild = flight(|row, altitude_m| if row % 60 == 0 { 9_000.0 } else { altitude_m });
        assert_eq!(check(&wild), Some(Fault::Copied { apart_m: 0.0 }));
        assert_eq!(check(&flight(|_, _| 512.0)), Some(Fault::Stuck));
        // An altitude that was rounded separately from the receiver's is still a copy. One with a metre of
        // noise is not, nor is one with a decimetre of it where nothing is rounded.
        let noise_m = |row: usize| 1.2 * (row as f32 * 1.7).sin();
        assert_eq!(check(&flight(|row, altitude_m| (altitude_m + 0.35 + noise_m(row)).round())), None);
        let fine = |noise_m: f32| {
            let mut flight = flight(|_, altitude_m| altitude_m);
            let climb_m = |row: usize| 400.0 + 0.37 * row as f32;
            let of = |value: &dyn Fn(usize) -> f32| {
                let mut column = Column::default();
                (0..300).for_each(|row| column.push(Some(value(row))));
                column
            };
            flight.set_channel(Channel::GpsAltM, of(&climb_m));
            flight.set_channel(
                Channel::BaroAltM,
                of(&|row| climb_m(row) + 47.0 + noise_m * (row as f32 * 1.7).sin()),
            );
            flight
        };
        assert_eq!(check(&fine(0.0)), Some(Fault::Copied { apart_m: 47.0 }));
        assert_eq!(check(&fine(0.5)), None);
        // One that is right except for a drift of 5 m, and one that lags by 3 s.
        assert_eq!(check(&flight(|row, altitude_m| altitude_m + 47.0 + row as f32 / 60.0)), None);
        assert_eq!(
            check(&flight(|row, _| 400.0 + (0.7 * (row as f32 - 3.0) * (row as f32 / 300.0)).floor())),
            None
        );
        assert_eq!(check(&Flight::default()), None);
        assert!(notes(&flight(|_, altitude_m| altitude_m))[0].text().contains("copy of the receiver"));
    }

    /// A flight of this many rows, by the receiver's and the barometer's altitude in each.
    fn pairs(rows: usize, receiver_m: impl Fn(usize) -> f32, baro_m: impl Fn(usize) -> f32) -> Flight {
        let mut flight = Flight { time_s: (0..rows).map(|row| row as f64).collect(), ..Flight::default() };
        let (mut receiver, mut baro) = (Column::default(), Column::default());
        for row in 0..rows {
            receiver.push(Some(receiver_m(row)));
            baro.push(Some(baro_m(row)));
        }
        flight.set_channel(Channel::GpsAltM, receiver);
        flight.set_channel(Channel::BaroAltM, baro);
        flight
    }

    fn is_copy(flight: &Flight) -> bool {
        matches!(check(flight), Some(Fault::Copied { apart_m }) if (apart_m - 47.0).abs() <= 0.51)
    }

    /// A rounded copy differs from the receiver by up to a step of either: by one step where both have the
    /// same, by their sum otherwise. More is a barometer.
    #[test]
    fn a_copy_differs_by_its_rounding() {
        let climb_m = |row: usize| 400.0 + 0.37 * row as f32;
        assert!(is_copy(&pairs(300, climb_m, |row| (climb_m(row) + 47.0).round())));
        assert!(is_copy(&pairs(300, |row| climb_m(row).floor(), |row| (climb_m(row) + 47.0).round())));
        // Whole metres with three different offsets: two steps apart.
        let three = |row: usize| climb_m(row).floor() + 46.0 + (row % 3) as f32;
        assert_eq!(check(&pairs(300, |row| climb_m(row).floor(), three)), None);
        // With steps of 0.37 m and of 1 m the difference is at most 1.37 m.
        let apart =
            |most_m: f32| pairs(300, climb_m, move |row| (climb_m(row) + most_m * (row % 2) as f32).round());
        assert!(check(&apart(0.3)).is_some() && check(&apart(1.0)).is_none());
    }

    /// Fewer than twenty samples give no verdict, nor does a receiver that moves by less than 10 m: both may
    /// agree by chance.
    #[test]
    fn little_is_not_judged() {
        let copied = |rows: usize, range_m: f32| {
            let climb_m = move |row: usize| 400.0 + range_m * row as f32 / (rows - 1) as f32;
            check(&pairs(rows, climb_m, move |row| climb_m(row) + 47.0)).is_some()
        };
        assert!(copied(20, 64.0) && !copied(19, 64.0));
        assert!(copied(300, 16.0) && !copied(300, 8.0));
        // Of twenty samples the highest is the 98th of a hundred: just 10 m.
        assert!(copied(20, 10.0));
    }

    /// Cells that are not finite, in either column, are not compared.
    #[test]
    fn cells_that_are_no_number_do_not_hide_a_copy() {
        let climb_m = |row: usize| 400.0 + 0.5 * row as f32;
        let often = |row: usize, value: f32| if row % 10 == 3 { f32::NAN } else { value };
        assert!(is_copy(&pairs(300, |row| often(row, climb_m(row)), |row| climb_m(row) + 47.0)));
        assert!(is_copy(&pairs(300, climb_m, |row| often(row, climb_m(row) + 47.0))));
    }
}
