//! Guesses which column is the time, and its unit.

use super::board::{Board, TimeGuess};
use super::names::Role;
use super::relate::quantile;
use crate::import::mapping::quantity::Quantity;
use crate::import::mapping::{EPOCH_S, middle, past_midnight};

/// Plausible step from one row to the next, seconds: no logger of flights writes faster or slower.
const PACE_S: std::ops::RangeInclusive<f64> = 0.000_2..=20.0;
/// Plausible length of a flight, seconds: a little more than a day at most.
const SPAN_S: std::ops::RangeInclusive<f64> = 5.0..=100_000.0;
/// Plausible fastest climb or descent of a flight, m/s: neither a balloon in calm air nor a shell.
const CLIMB_MPS: std::ops::RangeInclusive<f64> = 0.03..=700.0;
/// Units of clocks.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// A column that runs forward.
struct Clock {
    column: usize,
    /// Share of rows whose time is later than that of the row before.
    forward: f64,
    /// The usual step, in its own unit.
    step: f64,
    span: f64,
    is_counter: bool,
    /// Whether it has times of day or dates.
    is_written: bool,
}

/// Finds the time base.
pub fn find(board: &mut Board<'_>) {
    let mut clocks: Vec<Clock> =
        (0..board.table.columns.len()).filter_map(|column| clock(board, column)).collect();
    // Priority has a name that means time but not a receiver's; then the column that steps in every row; then
    // the one with the finest steps.
    let rank = |board: &Board<'_>, clock: &Clock| {
        let role = board.role(clock.column);
        let named = if role == Some(Role::Time) { 2 } else { i32::from(clock.is_written) };
        (named, -i32::from(clock.is_counter), (clock.forward * 50.0) as i32, -(clock.column as i64))
    };
    clocks.retain(|clock| {
        !matches!(board.role(clock.column), Some(role) if !matches!(role, Role::Time | Role::Counter | Role::ReceiverTime))
    });
    clocks.sort_by_key(|clock| std::cmp::Reverse(rank(board, clock)));
    let Some(best) = clocks.first() else { return };
    let others: Vec<usize> =
        clocks.iter().skip(1).filter(|clock| clock.forward > 0.9).map(|clock| clock.column).collect();
    let guess = if best.is_written { written(board, best) } else { counted(board, best) };
    board.time_s = seconds(board, &guess);
    board.time = Some(guess);
    for column in others {
        let why =
            if board.role(column) == Some(Role::Counter) { "counts the rows" } else { "is a second clock" };
        if board.role(column) != Some(Role::ReceiverTime) {
            board.set_aside(column, format!("runs forward in every row: {why}"));
        }
    }
}

/// A column as a clock; `None` if it is not one.
fn clock(board: &Board<'_>, column: usize) -> Option<Clock> {
    let cells = board.table.columns.get(column)?;
    let is_written = cells.clocks + cells.dates > cells.numbers + cells.words;
    if cells.words > cells.numbers + cells.clocks + cells.dates {
        return None;
    }
    let rows = cells.values.len();
    let values = if cells.clocks > cells.numbers + cells.dates {
        past_midnight(&cells.values)
    } else {
        cells.values.clone()
    };
    let values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    if values.len() < 10 || values.len() * 10 < rows * 9 {
        return None;
    }
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let share =
        |is: fn(&f64) -> bool| steps.iter().filter(|step| is(step)).count() as f64 / steps.len() as f64;
    // A clock that occasionally goes back has jumped; one that often does is not a clock.
    if share(|step| *step < 0.0) > 0.01 {
        return None;
    }
    let step = middle(steps.iter().copied().filter(|step| *step > 0.0))?;
    let span = quantile(values.iter().copied(), 0.99)? - quantile(values.iter().copied(), 0.01)?;
    let forward = share(|step| *step > 0.0);
    let is_counter = share(|step| *step == 1.0) > 0.999 && board.role(column) != Some(Role::Time);
    // A value that climbs through the whole flight also runs forward, but with steps of every size, and it
    // usually also rests.
    let is_regular = steps.iter().filter(|own| (**own / step - 1.0).abs() < 0.5 || **own == 0.0).count() * 10
        > steps.len() * 7;
    let is_named = matches!(board.role(column), Some(Role::Time));
    (is_named || is_written || (is_regular && forward > 0.2)).then_some(Clock {
        column,
        forward,
        step,
        span,
        is_counter,
        is_written,
    })
}

fn written(board: &Board<'_>, clock: &Clock) -> TimeGuess {
    let column = clock.column;
    let is_date = board.table.columns.get(column).is_some_and(|cells| cells.dates > 0);
    let kind = if is_date { "dates with a time" } else { "times of day" };
    let forward = clock.forward * 100.0;
    TimeGuess {
        column,
        unit: None,
        is_sure: true,
        evidence: format!(
            "column {} has {kind} that run forward in {forward:.0} % of the rows, by {:.3} s from one to the next",
            board.quoted(column),
            clock.step
        ),
    }
}

fn counted(board: &Board<'_>, clock: &Clock) -> TimeGuess {
    let Clock { column, step, span, .. } = *clock;
    let hint = board.hint(column);
    let name = board.quoted(column);
    let runs = format!("column {name} runs forward in {:.0} % of the rows", clock.forward * 100.0);
    let pace_of = |factor: f64| step * clock.forward * factor;
    let fits = |factor: f64| PACE_S.contains(&pace_of(factor)) && SPAN_S.contains(&(span * factor));
    let fitting: Vec<(&'static str, f64)> = UNITS.into_iter().filter(|(_, factor)| fits(*factor)).collect();
    let described =
        |factor: f64| format!("{:.0} s in all, a row every {:.3} s", span * factor, step * factor);
    let guess = |unit, is_sure, evidence| TimeGuess { column, unit: Some(unit), is_sure, evidence };
    // The magnitude of a date as a number shows its unit.
    let center = middle(board.numbers(column)).unwrap_or(0.0);
    let since_1970 = UNITS.into_iter().find(|(_, factor)| EPOCH_S.contains(&(center * factor)));
    if let Some((unit, factor)) = since_1970.filter(|(_, factor)| fits(*factor)) {
        let what = described(factor);
        return guess(unit, true, format!("{runs}, and counts from 1970 if its unit is {unit}: {what}"));
    }
    let named = hint.unit_of(Quantity::Time);
    if let Some(unit) = named {
        let factor = Quantity::Time.unit(unit).map_or(1.0, |unit| unit.factor);
        let what = described(factor);
        if fits(factor) {
            return guess(
                unit,
                hint.role == Some(Role::Time) || !clock.is_counter,
                format!("{runs}, its name says {unit}: {what}"),
            );
        }
        return guess(unit, false, format!("{runs}; its name says {unit}, but that would be {what}"));
    }
    let climbing: Vec<(&'static str, f64)> = fitting
        .iter()
        .copied()
        .filter(|(_, factor)| climbs_as_aircraft_do(board, column, *factor) != Some(false))
        .collect();
    let is_clock = !clock.is_counter;
    match (fitting.as_slice(), climbing.as_slice()) {
        ([(unit, factor)], _) => guess(
            unit,
            is_clock,
            format!("{runs}; plausible for a flight only in {unit}: {}", described(*factor)),
        ),
        (_, [(unit, factor)]) => guess(
            unit,
            is_clock && climbs_as_aircraft_do(board, column, *factor) == Some(true),
            format!(
                "{runs}; of the units, only with {unit} does it climb as aircraft do: {}",
                described(*factor)
            ),
        ),
        ([], _) => {
            guess("s", false, format!("{runs}, but its steps are not those of a flight's log in any unit"))
        }
        ([(unit, factor), ..], _) => {
            let names: Vec<&str> = fitting.iter().map(|(unit, _)| *unit).collect();
            guess(
                unit,
                false,
                format!("{runs}; its unit may be {}; in {unit}: {}", names.join(" or "), described(*factor)),
            )
        }
    }
}

/// Whether altitude or pressure changes as fast as an aircraft's if time has that unit; `None` without
/// either.
fn climbs_as_aircraft_do(board: &Board<'_>, time: usize, factor: f64) -> Option<bool> {
    let is_height = |role: Role| {
        matches!(
            role,
            Role::Pressure
                | Role::GpsAltitude
                | Role::BaroAltitude
                | Role::Altitude
                | Role::SlaveAltitude
                | Role::MasterAltitude
        )
    };
    let column = board.free().into_iter().find(|column| {
        *column != time && board.role(*column).is_some_and(is_height) && !board.is_constant(*column)
    })?;
    let values = board.table.values(column);
    let center = middle(values.iter().copied())?;
    // A pascal is about a twelfth of a metre; any unit of pressure is scaled by its value at the ground.
    let metres =
        if board.role(column) == Some(Role::Pressure) { 8_400.0 / center.abs().max(1e-9) } else { 1.0 };
    let timed: Vec<(f64, f64)> = board
        .table
        .values(time)
        .iter()
        .zip(values)
        .filter(|(time, value)| time.is_finite() && value.is_finite())
        .map(|(time, value)| (time * factor, value * metres))
        .collect();
    // Over a fiftieth of the flight, noise is small compared with a climb.
    let stride = (timed.len() / 50).max(1);
    let rates = timed.iter().zip(timed.iter().skip(stride)).filter(|(one, other)| other.0 > one.0);
    let fastest = quantile(rates.map(|(one, other)| ((other.1 - one.1) / (other.0 - one.0)).abs()), 0.9)?;
    Some(CLIMB_MPS.contains(&fastest))
}

/// Time of each row, seconds.
fn seconds(board: &Board<'_>, guess: &TimeGuess) -> Vec<f64> {
    let Some(cells) = board.table.columns.get(guess.column) else { return Vec::new() };
    let factor = guess.unit.and_then(|unit| Quantity::Time.unit(unit)).map_or(1.0, |unit| unit.factor);
    let values = if guess.unit.is_none() && cells.clocks > cells.dates {
        past_midnight(&cells.values)
    } else {
        cells.values.clone()
    };
    let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    // Counted from the first row: dates in microseconds would lose digits.
    values.into_iter().map(|value| (value - first) * factor).collect()
}
