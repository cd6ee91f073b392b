//! Guesses which columns are accelerations, rates and attitude.

use super::board::{Board, Guess};
use super::names::Role;
use super::relate::{Line, quantile};
use super::units::meant;
use crate::import::mapping::quantity::{GRAVITY, Quantity};
use crate::import::signs::windows;

/// Largest rate of an aircraft's gyro, rad/s: 2000 degrees a second.
const FASTEST_RADPS: f64 = 35.0;
/// Largest relative deviation of specific force from one g, at rest and at the median of a flight.
const NEAR_G: f64 = 0.08;
const ACCELERATIONS: [&str; 3] = ["accel_x_mps2", "accel_y_mps2", "accel_z_mps2"];
const RATES: [&str; 3] = ["gyro_x_radps", "gyro_y_radps", "gyro_z_radps"];
const ANGLES: [(Role, &str); 3] =
    [(Role::Roll, "roll_rad"), (Role::Pitch, "pitch_rad"), (Role::Yaw, "yaw_rad")];

/// Finds the inertial unit and the attitude.
pub fn find(board: &mut Board<'_>) {
    let axes = accelerations(board);
    attitude(board);
    rates(board, axes);
}

/// The first three columns of a role, one for each axis, that have the same words otherwise.
fn triple(board: &Board<'_>, role: Role) -> Option<[usize; 3]> {
    let named = board.named(role);
    let of_axis = |words: &[String], axis: usize, is_alone: bool| {
        let mut found = named.iter().copied().filter(|column| {
            let hint = board.hint(*column);
            hint.axis == Some(axis) && (hint.words == words || (is_alone && hint.words.len() == words.len()))
        });
        found.next()
    };
    // "gyro_x" and "gyro_y" have the same words, "ax" and "ay" the same number of words.
    [false, true].into_iter().find_map(|is_alone| {
        named.iter().find_map(|first| {
            let words = board.hint(*first).words;
            Some([
                of_axis(&words, 0, is_alone)?,
                of_axis(&words, 1, is_alone)?,
                of_axis(&words, 2, is_alone)?,
            ])
        })
    })
}

/// Rows in which all three columns have a number.
fn vectors(board: &Board<'_>, columns: [usize; 3]) -> Vec<[f64; 3]> {
    let [x, y, z] = columns.map(|column| board.table.values(column));
    let rows = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]);
    rows.filter(|row| row.iter().all(|value| value.is_finite())).collect()
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Mounting of an inertial unit, as shown by its accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axes {
    /// z points down, as in Pylon, or there is no evidence against it.
    Down,
    /// z points up.
    Up,
    /// Another axis points up or down.
    Other,
}

/// Guesses the accelerometer and returns how it is mounted.
fn accelerations(board: &mut Board<'_>) -> Axes {
    let Some(columns) = triple(board, Role::Accelerometer) else { return Axes::Down };
    let vectors = vectors(board, columns);
    let Some(usual) = quantile(vectors.iter().map(|vector| norm(*vector)), 0.5).filter(|usual| *usual > 0.0)
    else {
        return Axes::Other;
    };
    let hint = board.hint(columns[0]);
    let named = hint.unit_of(Quantity::Acceleration);
    let near = |unit: f64| (usual * unit / GRAVITY - 1.0).abs() < NEAR_G;
    let unit = Quantity::Acceleration.units().find(|unit| near(unit.factor));
    // Raw counts: a power of two for one g.
    let counts = usual.log2().round().exp2();
    let is_counts =
        unit.is_none() && (256.0..=32_768.0).contains(&counts) && (usual / counts - 1.0).abs() < NEAR_G;
    let mean = |axis: usize| {
        let sum: f64 = vectors.iter().filter_map(|vector| vector.get(axis)).sum();
        sum / vectors.len() as f64 / usual
    };
    let (x, y, z) = (mean(0), mean(1), mean(2));
    let names = columns.map(|column| board.quoted(column)).join(", ");
    let (unit_name, scale, mut is_sure, mut evidence) = match (unit, named) {
        (Some(unit), named) => (
            unit.name,
            1.0,
            named.is_none_or(|named| named == unit.name),
            format!(
                "{names}: their median length is {usual:.4}, one g in {}{}",
                unit.name,
                named.map_or_else(String::new, |named| if named == unit.name {
                    ", as the name says".to_owned()
                } else {
                    format!(", but the name says {named}")
                })
            ),
        ),
        (None, _) if is_counts => (
            "g",
            1.0 / counts,
            true,
            format!("{names}: their median length is {usual:.0}, one g at {counts:.0} counts per g"),
        ),
        (None, Some(named)) => (
            named,
            1.0,
            false,
            format!("{names}: the name says {named}, but their median length is {usual:.4}, not one g"),
        ),
        (None, None) => {
            ("m/s2", 1.0, false, format!("{names}: their median length is {usual:.4}, one g in no unit"))
        }
    };
    let axes = match z {
        z if z < -0.7 => Axes::Down,
        z if z > 0.7 => Axes::Up,
        _ => Axes::Other,
    };
    let signs = match axes {
        Axes::Down => {
            evidence +=
                "; z shows -1 g: it points down, as Pylon's does (no value shows that x points forward)";
            [1.0; 3]
        }
        Axes::Up => {
            is_sure = false;
            evidence += "; z shows +1 g: it points up, but Pylon's points down: if x points forward and y to the left, y and z must \
                         be reversed, as here";
            [1.0, -1.0, -1.0]
        }
        Axes::Other => {
            is_sure = false;
            evidence += &format!(
                "; on average they show {x:+.2}, {y:+.2}, {z:+.2} g: z does not point down, as Pylon's does. Give the axes that \
                 point forward, right and down"
            );
            [1.0; 3]
        }
    };
    for ((column, destination), sign) in columns.into_iter().zip(ACCELERATIONS).zip(signs) {
        board.add(Guess {
            destination: destination.to_owned(),
            column,
            unit: Some(unit_name),
            scale: Some(scale * sign).filter(|scale| *scale != 1.0),
            offset: None,
            held: false,
            is_sure,
            evidence: evidence.clone(),
        });
    }
    axes
}

fn attitude(board: &mut Board<'_>) {
    let columns: Vec<(usize, &str)> = ANGLES
        .into_iter()
        .filter_map(|(role, destination)| Some((*board.named(role).first()?, destination)))
        .collect();
    // All three have the same unit, which the largest of them shows.
    let largest = columns
        .iter()
        .flat_map(|(column, _)| board.numbers(*column))
        .fold(0.0, |largest: f64, value| largest.max(value.abs()));
    for (column, destination) in columns {
        let name = board.quoted(column);
        let hint = board.hint(column);
        let named = hint.unit_of(Quantity::Angle);
        let (unit, is_sure, why) = match named {
            Some("rad") if largest > 6.5 => {
                ("deg", false, format!("its name says rad, but values reach {largest:.1}"))
            }
            Some(named) => (named, true, format!("its name says {named}, values reach {largest:.1}")),
            None if largest > 450.0 && largest <= 36_000.0 => {
                ("cdeg", false, format!("values reach {largest:.0}: hundredths of a degree"))
            }
            None if largest > 6.5 => (
                "deg",
                true,
                format!("values of the attitude reach {largest:.1}, beyond a full turn in radians"),
            ),
            None if largest > 2.8 => (
                "rad",
                true,
                format!("values of the attitude reach {largest:.2} and no more, half a turn in radians"),
            ),
            None => (
                "rad",
                false,
                format!(
                    "values of the attitude reach {largest:.2}: radians, or degrees of a flight without a turn"
                ),
            ),
        };
        board.add_plain(destination, column, Some(unit), is_sure, format!("{name}: {why}"));
    }
}

fn rates(board: &mut Board<'_>, axes: Axes) {
    let Some(columns) = triple(board, Role::Gyro) else { return };
    let hint = board.hint(columns[0]);
    let named = hint.unit_of(Quantity::Rate);
    let largest = columns
        .iter()
        .flat_map(|column| board.numbers(*column))
        .fold(0.0, |largest: f64, value| largest.max(value.abs()));
    // The attitude's change against the rate's integral, for each axis; yaw is left out because it wraps.
    let lines: Vec<(usize, Line)> = columns
        .into_iter()
        .zip(["roll_rad", "pitch_rad"])
        .enumerate()
        .filter_map(|(axis, (column, angle))| {
            let mut pairs = windows(&board.samples(column), &board.converted(angle));
            pairs.retain(|(_, change)| change.abs() < 2.0);
            Some((axis, Line::through(&pairs).filter(Line::is_sound)?))
        })
        .collect();
    let is_attitude_sure = board.guess("roll_rad").is_some_and(|guess| guess.is_sure);
    let by_attitude =
        lines.first().and_then(|(_, line)| Some((*line, meant(Quantity::Rate, line.slope, &hint)?)));
    let names = columns.map(|column| board.quoted(column)).join(", ");
    let (unit, mut is_sure, mut evidence) = match (by_attitude, named) {
        (Some((line, rate)), _) => (
            rate.unit,
            rate.is_sure && (is_attitude_sure || rate.is_as_named == Some(true)),
            format!(
                "{names}: the attitude turns by {:.4} rad per unit of the first's integral (correlation {:+.2}): {}{}",
                line.slope.abs(),
                line.correlation,
                rate.unit,
                super::units::name_agrees(&rate, &hint)
            ),
        ),
        (None, Some("rad/s")) if largest > FASTEST_RADPS => (
            "deg/s",
            false,
            format!("{names}: the name says rad/s, but values reach {largest:.0}, more than aircraft turn"),
        ),
        (None, Some(named)) => {
            (named, true, format!("{names}: the name says {named}, values reach {largest:.2}"))
        }
        (None, None) if largest > FASTEST_RADPS && largest < 2_500.0 => {
            ("deg/s", true, format!("{names}: values reach {largest:.0}, more than aircraft turn in rad/s"))
        }
        (None, None) => {
            ("rad/s", false, format!("{names}: values reach {largest:.2}: rad/s, or deg/s of a calm flight"))
        }
    };
    // The axes shown by the attitude have priority over those shown by the accelerometer's z.
    let mut signs = if axes == Axes::Up { [1.0, -1.0, -1.0] } else { [1.0; 3] };
    for (axis, line) in &lines {
        if let Some(sign) = signs.get_mut(*axis) {
            *sign = 1.0_f64.copysign(line.slope);
        }
    }
    if let [(0, roll), (1, pitch)] = lines.as_slice() {
        // The sign of z follows from those of x and y.
        signs[2] = 1.0_f64.copysign(roll.slope * pitch.slope);
        evidence += "; roll and pitch give the signs of x and y, and those give z's";
    } else if axes != Axes::Down {
        is_sure = false;
        evidence += "; its axes are no clearer than the accelerometer's";
    }
    for ((column, destination), sign) in columns.into_iter().zip(RATES).zip(signs) {
        board.add(Guess {
            destination: destination.to_owned(),
            column,
            unit: Some(unit),
            scale: Some(sign).filter(|sign| *sign != 1.0),
            offset: None,
            held: false,
            is_sure,
            evidence: evidence.clone(),
        });
    }
}
