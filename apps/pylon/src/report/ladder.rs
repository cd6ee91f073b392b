//! The errors of every revision of the model on every flight, as diagrams of the page.

use kf_core::sensor::Sensor;
use view::{Chart, Role, Values};

use super::table::rounded;
use crate::learn::{Ladder, LadderRevision, SensorScore};

/// Limit on the revisions whose names are shown: with more they would overlap.
const MOST_NAMES: usize = 6;
/// Margin beside the first and the last revision.
const MARGIN: f64 = 0.3;

/// A revision, and the scores of the sensors that flew free.
pub(super) type Step<'a> = (&'a LadderRevision, Vec<(&'a str, &'a SensorScore)>);

/// One flight of the ladder.
#[derive(Clone, Debug)]
pub(super) struct LadderFlight<'a> {
    /// The file.
    pub(super) file: &'a str,
    /// Every revision, oldest first.
    pub(super) steps: Vec<Step<'a>>,
    /// The rms errors, if there is more than one revision and a sensor flew free.
    pub(super) chart: Option<Chart>,
}

/// The ladder flight by flight, in its own order.
pub(super) fn flights(ladder: &Ladder) -> Vec<LadderFlight<'_>> {
    let Some(first) = ladder.revisions.first() else { return Vec::new() };
    first
        .flights
        .iter()
        .enumerate()
        .map(|(at, flight)| {
            let steps: Vec<Step<'_>> = ladder
                .revisions
                .iter()
                .filter_map(|revision| {
                    let scores = revision.flights.get(at)?.sensors.iter();
                    let free = scores.filter(|(_, score)| score.free_flight_rms_m.is_some());
                    Some((revision, free.map(|(name, score)| (&**name, score)).collect()))
                })
                .collect();
            LadderFlight { file: &flight.file, chart: chart(at, &steps), steps }
        })
        .collect()
}

/// What a revision is called.
pub(super) fn name(revision: &LadderRevision) -> String {
    match (revision.number, &revision.effect) {
        (0, _) => "at first".to_owned(),
        (number, Some(effect)) => format!("{number}: {effect}"),
        (number, None) => number.to_string(),
    }
}

fn chart(flight: usize, steps: &[Step<'_>]) -> Option<Chart> {
    let sensors: Vec<(Sensor, Role)> = [(Sensor::Baro, Role::Measured), (Sensor::ImuSlave, Role::Modelled)]
        .into_iter()
        .filter(|(sensor, _)| {
            steps.iter().any(|(_, scores)| scores.iter().any(|(name, _)| *name == sensor.name()))
        })
        .collect();
    if steps.len() < 2 || sensors.is_empty() {
        return None;
    }
    let last = (steps.len() - 1) as f64;
    let places = (0..steps.len()).map(|at| at as f64);
    let x = std::iter::once(-MARGIN).chain(places.clone()).chain([last + MARGIN]).collect();
    let id = format!("ladder-{}", flight + 1);
    let mut chart =
        Chart::new(id, String::new(), "revision of the model", "rms error in free flight, m".to_owned(), x);
    chart.x_ticks = places
        .zip(steps)
        .map(|(place, (revision, _))| {
            let name = if steps.len() > MOST_NAMES { revision.number.to_string() } else { name(revision) };
            (place, name)
        })
        .collect();
    let mut greatest: f64 = 0.0;
    for (sensor, role) in sensors {
        let rms_m = |(_, scores): &Step<'_>| -> Option<f64> {
            let (_, score) = scores.iter().find(|(name, _)| *name == sensor.name())?;
            score.free_flight_rms_m.map(rounded)
        };
        let values: Values = std::iter::once(None).chain(steps.iter().map(rms_m)).chain([None]).collect();
        greatest = values.iter().flatten().fold(greatest, |greatest, value| greatest.max(*value));
        chart = chart.line(sensor.name(), role, values);
        if let Some(line) = chart.lines.last_mut() {
            line.knots = true;
        }
    }
    // The axis starts at zero, so that heights are proportional to errors.
    chart.y_range = Some([0.0, rounded(1.1 * greatest.max(1e-3))]);
    Some(chart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::RevisionFlight;

    fn revision(number: u32, effect: Option<&'static str>, rms_m: [Option<f64>; 2]) -> LadderRevision {
        let flight = |file: &str, rms_m: Option<f64>| {
            let score = SensorScore { free_flight_rms_m: rms_m, ..SensorScore::default() };
            RevisionFlight { file: file.to_owned(), sensors: [("baro".into(), score)].into() }
        };
        LadderRevision {
            number,
            effect: effect.map(Into::into),
            date: None,
            effects: Vec::new(),
            flights: vec![flight("a.csv", rms_m[0]), flight("b.csv", rms_m[1])],
        }
    }

    #[test]
    fn every_flight_has_its_steps_in_order() {
        let ladder = Ladder {
            version: Ladder::VERSION,
            model: "ours.toml".to_owned(),
            revisions: vec![
                revision(0, None, [Some(4.0), None]),
                revision(1, Some("baro.lag"), [Some(3.0), None]),
                revision(3, None, [Some(1.0), None]),
            ],
        };
        let [a, b] = &flights(&ladder)[..] else { panic!("two flights") };
        let chart = a.chart.as_ref().unwrap();
        assert_eq!(chart.x, [-0.3, 0.0, 1.0, 2.0, 2.3]);
        assert_eq!(chart.lines[0].y, [None, Some(4.0), Some(3.0), Some(1.0), None]);
        let names: Vec<&str> = chart.x_ticks.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["at first", "1: baro.lag", "3"]);
        assert_eq!(chart.y_range, Some([0.0, 4.4]));
        // This flight had no launch.
        assert!(b.chart.is_none() && b.steps.iter().all(|(_, scores)| scores.is_empty()));
        assert_eq!(b.file, "b.csv");

        // A model without revisions has nothing to compare with.
        let single = Ladder { revisions: ladder.revisions[..1].to_vec(), ..ladder };
        assert!(flights(&single)[0].chart.is_none());
    }
}
