//! Free flight second by second, and the stretches in which the model fails.

use std::ops::Range;

use kf_core::input::TickInput;
use kf_core::output::TickOutput;
use kf_core::sensor::{SENSORS, Sensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kinematics::{MotionSources, SignalMeans, SignalReader, motions};
use super::manoeuvre::{Manoeuvre, Motion};
use crate::name::Name;

/// Length of the shortest run of one manoeuvre, seconds. Shorter ones join the run before them.
const SHORTEST_RUN: usize = 2;
/// Longest piece of a run, seconds.
const LONGEST_PIECE: usize = 5;
/// A stretch extends over neighbouring pieces of one manoeuvre whose rms error is at least this share of its
/// worst piece's.
const SIMILAR_SHARE: f64 = 0.7;

/// Sums of one sensor's errors.
#[derive(Clone, Copy, Debug, Default)]
struct ErrorSums {
    count: u64,
    sum: f64,
    squares: f64,
}

impl ErrorSums {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    fn figures(&self) -> Option<ErrorFigures> {
        let count = self.count as f64;
        (self.count > 0)
            .then(|| ErrorFigures { mean_m: self.sum / count, rms_m: (self.squares / count).sqrt() })
    }
}

/// Errors of one sensor in one stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ErrorFigures {
    /// Mean, metres.
    pub mean_m: f64,
    /// Root mean square, metres.
    pub rms_m: f64,
}

#[derive(Clone, Debug, Default)]
struct Second {
    errors: [ErrorSums; SENSORS],
    signals: SignalMeans,
}

/// Errors and signals of every second since `start_us`.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    start_us: Option<u64>,
    seconds: Vec<Second>,
    reader: SignalReader,
}

/// A stretch of flight with one manoeuvre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Stretch {
    /// Start and end, seconds after launch.
    pub from_s: f64,
    /// See [`Self::from_s`].
    pub to_s: f64,
    /// The manoeuvre.
    pub doing: Manoeuvre,
    /// How it moved, on average.
    pub motion: Motion,
    /// The sensor.
    pub sensor: Name,
    /// Mean error, metres.
    pub mean_m: f64,
    /// Root mean square error, metres.
    pub rms_m: f64,
    /// Share of the sensor's squared error over all of free flight.
    pub share_of_squared_error: f64,
}

/// Errors in all stretches of one manoeuvre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ManoeuvreErrors {
    /// The manoeuvre.
    pub doing: Manoeuvre,
    /// Total duration, seconds.
    pub seconds: f64,
    /// How it moved, on average.
    pub motion: Motion,
    /// Errors of the sensors that flew, by name.
    pub sensors: Vec<(Name, Option<ErrorFigures>)>,
}

/// Where the model fails.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Failures {
    /// For each sensor the stretches of largest rms error, worst first.
    pub worst: Vec<Stretch>,
    /// Errors by manoeuvre, in the order of [`Manoeuvre`].
    pub by_manoeuvre: Vec<ManoeuvreErrors>,
    /// The signals from which the motion was read.
    pub sources: MotionSources,
    /// Signals that the flight would need for the unknown quantities.
    pub missing: Vec<String>,
}

impl Timeline {
    /// Takes one tick of free flight; ticks must come in order of time.
    #[inline]
    pub(super) fn take(&mut self, input: &TickInput, output: &TickOutput) {
        let start_us = *self.start_us.get_or_insert(input.time_us);
        let index = (input.time_us.saturating_sub(start_us) / 1_000_000) as usize;
        if index >= self.seconds.len() {
            self.seconds.resize_with(index + 1, Second::default);
        }
        let Some(second) = self.seconds.get_mut(index) else { return };
        for (sums, sensor) in second.errors.iter_mut().zip(&output.sensors) {
            if let Some(error_m) = sensor.error_m.map(f64::from) {
                sums.count += 1;
                sums.sum += error_m;
                sums.squares += error_m * error_m;
            }
        }
        self.reader.take(input, &mut second.signals);
    }

    /// The `worst_of` worst stretches of each sensor, and the errors by manoeuvre.
    pub(super) fn failures(&self, worst_of: usize) -> Failures {
        let signals: Vec<SignalMeans> = self.seconds.iter().map(|second| second.signals).collect();
        let (motions, sources) = motions(&signals);
        let names = without_short_runs(motions.iter().map(Manoeuvre::of).collect());
        let has_error =
            |sensor: Sensor| self.seconds.iter().any(|second| second.errors[sensor.index()].count > 0);
        let sensors = || Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free() && has_error(*sensor));
        let pieces = pieces(&names);

        let mut worst = Vec::new();
        for sensor in sensors() {
            let total: f64 = self.seconds.iter().map(|second| second.errors[sensor.index()].squares).sum();
            let rms: Vec<f64> = pieces
                .iter()
                .map(|piece| self.sum(piece.clone(), sensor).figures().map_or(0.0, |figures| figures.rms_m))
                .collect();
            worst.extend(worst_stretches(&pieces, &names, &rms, worst_of).into_iter().filter_map(
                |stretch| {
                    let sums = self.sum(stretch.clone(), sensor);
                    let ErrorFigures { mean_m, rms_m } = sums.figures()?;
                    Some(Stretch {
                        from_s: stretch.start as f64,
                        to_s: stretch.end as f64,
                        doing: names[stretch.start],
                        motion: mean_motion(stretch.clone().map(|second| &motions[second])),
                        sensor: sensor.name().into(),
                        mean_m,
                        rms_m,
                        share_of_squared_error: if total > 0.0 { sums.squares / total } else { 0.0 },
                    })
                },
            ));
        }

        let mut kinds = names.clone();
        kinds.sort_unstable();
        kinds.dedup();
        let by_manoeuvre = kinds
            .into_iter()
            .map(|doing| {
                let of_kind = || (0..names.len()).filter(|second| names[*second] == doing);
                let errors = |sensor: Sensor| {
                    let mut sums = ErrorSums::default();
                    of_kind().for_each(|second| sums.add(&self.seconds[second].errors[sensor.index()]));
                    (sensor.name().into(), sums.figures())
                };
                ManoeuvreErrors {
                    doing,
                    seconds: of_kind().count() as f64,
                    motion: mean_motion(of_kind().map(|second| &motions[second])),
                    sensors: sensors().map(errors).collect(),
                }
            })
            .collect();
        Failures { worst, by_manoeuvre, missing: sources.missing(), sources }
    }

    fn sum(&self, run: Range<usize>, sensor: Sensor) -> ErrorSums {
        let mut sums = ErrorSums::default();
        self.seconds[run].iter().for_each(|second| sums.add(&second.errors[sensor.index()]));
        sums
    }
}

/// Joins runs shorter than [`SHORTEST_RUN`] to the run before them.
pub(super) fn without_short_runs(mut names: Vec<Manoeuvre>) -> Vec<Manoeuvre> {
    let mut start = 0;
    while start < names.len() {
        let length = names[start..].iter().take_while(|name| **name == names[start]).count();
        if length < SHORTEST_RUN && start > 0 {
            let before = names[start - 1];
            names[start..start + length].fill(before);
        }
        start += length;
    }
    names
}

/// Runs of one manoeuvre, cut into pieces of nearly equal length no longer than [`LONGEST_PIECE`].
fn pieces(names: &[Manoeuvre]) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let mut start = 0;
    while start < names.len() {
        let length = names[start..].iter().take_while(|name| **name == names[start]).count();
        let parts = length.div_ceil(LONGEST_PIECE);
        pieces.extend(
            (0..parts).map(|part| start + length * part / parts..start + length * (part + 1) / parts),
        );
        start += length;
    }
    pieces
}

/// The `count` worst pieces, each extended over its neighbours of the same manoeuvre and similar error; worst
/// first.
fn worst_stretches(
    pieces: &[Range<usize>],
    names: &[Manoeuvre],
    rms: &[f64],
    count: usize,
) -> Vec<Range<usize>> {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by(|a, b| rms[*b].total_cmp(&rms[*a]));
    let mut taken = vec![false; pieces.len()];
    let mut stretches = Vec::new();
    for seed in order {
        if stretches.len() == count {
            break;
        }
        if taken[seed] {
            continue;
        }
        let belongs = |piece: usize| {
            !taken[piece]
                && names[pieces[piece].start] == names[pieces[seed].start]
                && rms[piece] >= SIMILAR_SHARE * rms[seed]
        };
        let first = (0..seed).rev().take_while(|piece| belongs(*piece)).last().unwrap_or(seed);
        let last = (seed + 1..pieces.len()).take_while(|piece| belongs(*piece)).last().unwrap_or(seed);
        taken[first..=last].fill(true);
        stretches.push(pieces[first].start..pieces[last].end);
    }
    stretches
}

fn mean_motion<'a>(motions: impl Iterator<Item = &'a Motion> + Clone) -> Motion {
    let mean = |quantity: fn(&Motion) -> Option<f64>| {
        let (sum, count) =
            motions.clone().filter_map(quantity).fold((0.0, 0_u32), |(sum, count), x| (sum + x, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    Motion {
        climb_rate_mps: mean(|motion| motion.climb_rate_mps),
        speed_mps: mean(|motion| motion.speed_mps),
        acceleration_mps2: mean(|motion| motion.acceleration_mps2),
        load_factor: mean(|motion| motion.load_factor),
        turn_rate_radps: mean(|motion| motion.turn_rate_radps),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Manoeuvre::{Climb, Dive, LevelFlight};

    #[test]
    fn short_runs_join_the_one_before() {
        let names = vec![Climb, LevelFlight, LevelFlight, Dive, LevelFlight, LevelFlight, Dive, Dive];
        assert_eq!(
            without_short_runs(names),
            vec![Climb, LevelFlight, LevelFlight, LevelFlight, LevelFlight, LevelFlight, Dive, Dive]
        );
    }

    #[test]
    fn long_runs_are_cut_without_loss() {
        let mut names = vec![LevelFlight; 71];
        names.extend([Dive; 5]);
        let pieces = pieces(&names);
        assert_eq!(pieces[0].start, 0);
        assert!(pieces.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!(pieces.last(), Some(&(71..76)));
        assert!(pieces.iter().all(|piece| (4..=LONGEST_PIECE).contains(&piece.len())));
    }

    #[test]
    fn a_stretch_grows_over_similar_neighbours_of_one_manoeuvre() {
        let names = [[Climb; 2], [LevelFlight; 2], [LevelFlight; 2], [LevelFlight; 2], [Dive; 2]].concat();
        let pieces: Vec<Range<usize>> = (0..5).map(|k| 2 * k..2 * k + 2).collect();
        let found = worst_stretches(&pieces, &names, &[9.0, 8.0, 10.0, 2.0, 9.5], 3);
        assert_eq!(found, vec![2..6, 8..10, 0..2]);
    }
}
