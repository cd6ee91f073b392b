//! One signal against another.

use crate::curve::{Curve, Flown, curve};
use crate::engine::{Attachments, Engine, Progress, Refused, refused};
use crate::protocol::{Paired, ScatterRequest};

/// The points of one signal against another.
pub fn pairs(
    engine: &mut Engine,
    request: &ScatterRequest,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<Paired, Refused> {
    if request.at_most == 0 {
        return Err(refused("at most 0 points, expected 1 or more"));
    }
    let flown = Flown { flight: &request.flight, model: &request.model, times: request.times };
    let x = curve(engine, &flown, &request.x, progress)?;
    let y = curve(engine, &flown, &request.y, progress)?;
    let from_s = request.from_s.unwrap_or(f64::NEG_INFINITY);
    let to_s = request.to_s.unwrap_or(f64::INFINITY);
    let (points, unpaired) = paired(&x, &y, from_s, to_s);
    let every = points.len().div_ceil(request.at_most as usize).max(1);
    let shown = || points.iter().step_by(every);
    Ok(Paired {
        time_s: attachments.put(shown().map(|[time_s, ..]| *time_s)),
        x: attachments.put(shown().map(|[_, x, _]| *x)),
        y: attachments.put(shown().map(|[_, _, y]| *y)),
        x_unit: x.unit.to_owned(),
        y_unit: y.unit.to_owned(),
        of: points.len() as u32,
        unpaired,
    })
}

/// Time, x and y of every value of y for which x has a value, and the number of values of y for which it has
/// none.
pub fn paired(x: &Curve, y: &Curve, from_s: f64, to_s: f64) -> (Vec<[f64; 3]>, u32) {
    let whole = x.range(f64::NEG_INFINITY, f64::INFINITY);
    let gap_s = x.gap_s(whole.clone()).unwrap_or(f64::INFINITY);
    let mut of_x = Vec::new();
    x.each(whole, &mut |_, time_s, value| of_x.push((time_s, value)));
    let (mut points, mut unpaired, mut next) = (Vec::new(), 0, 0);
    y.each(y.range(from_s, to_s), &mut |_, time_s, value| {
        while of_x.get(next).is_some_and(|(at_s, _)| *at_s < time_s) {
            next += 1;
        }
        match between(&of_x, next, time_s, gap_s) {
            Some(x) => points.push([time_s, x, value]),
            None => unpaired += 1,
        }
    });
    (points, unpaired)
}

/// The value at a time, interpolated linearly between the value at `next` and the one before it.
fn between(values: &[(f64, f64)], next: usize, time_s: f64, gap_s: f64) -> Option<f64> {
    let (after_s, after) = *values.get(next)?;
    if after_s == time_s {
        return Some(after);
    }
    let (before_s, before) = *values.get(next.checked_sub(1)?)?;
    let share = (time_s - before_s) / (after_s - before_s);
    (after_s - before_s <= gap_s).then_some(before + share * (after - before))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_is_taken_between_its_values_and_not_over_a_gap() {
        let x = Curve::own(vec![0.0, 1.0, 2.0, 3.0, 30.0, 31.0], vec![0.0, 10.0, 20.0, 30.0, 0.0, 0.0], "m");
        let y = Curve::own(vec![-1.0, 0.5, 2.0, 10.0, 30.5, 40.0], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "m");
        let (points, unpaired) = paired(&x, &y, -10.0, 35.0);
        assert_eq!(points, [[0.5, 5.0, 2.0], [2.0, 20.0, 3.0], [30.5, 0.0, 5.0]]);
        assert_eq!(unpaired, 2);
    }
}
