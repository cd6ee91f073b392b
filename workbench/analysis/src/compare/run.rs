//! Flies a model over a flight and compares the two.

use executor::Executor;
use kf_core::config::SecondCorrection;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;
use model::{Model, SECOND_CORRECTION_WANDER_M_PER_SQRT_S};

use super::comparator::{Comparator, MissionEnd};
use super::comparison::{Comparison, FlightFacts};
use super::remedies::{Remedy, RemedyTally};
use super::rules::RuleRequirements;
use super::traces::Traces;
use super::warnings::{effect_warnings, input_warnings};
use flight_data::Channel;
use replay::{
    AnyMission, CalibrationSource, Flown, Observer, Replay, ReplayError, ReplaySummary, Usage, mission,
};

/// Number of rows between reports of progress.
const ROWS_PER_REPORT: u64 = 1 << 14;

/// Options of a comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Keeps the data of charts, each series with at most this many time slots.
    pub trace_slots: Option<usize>,
    /// Criteria for the monitor's rules.
    pub requirements: RuleRequirements,
}

/// Flies the replay's model over its flight and compares the two. `progress` receives the number of rows
/// done.
///
/// The caller fills in the names of the flight's file and of the model. The result does not depend on the
/// executor.
///
/// # Errors
/// [`ReplayError`] if no mission can be made from the model.
pub fn compare(
    replay: &Replay<'_>,
    options: &Options,
    progress: &mut (dyn FnMut(u64) + Send),
    executor: &dyn Executor,
) -> Result<(Comparison, Option<Box<Traces>>), ReplayError> {
    let compared = compare_with(replay, options, progress, Companions::default(), executor)?;
    Ok((compared.comparison, compared.traces))
}

/// Others that observe the flight in the same pass as the comparison.
#[derive(Default)]
pub struct Companions<'a> {
    /// Called with every output of the compared model.
    pub output: Option<&'a mut (dyn FnMut(&TickOutput) + Send)>,
    /// Observers of the ticks.
    pub observers: Vec<&'a mut dyn Observer>,
}

/// A comparison, and its mission's results.
#[derive(Debug)]
pub struct Compared {
    /// The comparison.
    pub comparison: Comparison,
    /// Data of the charts, if it was to be kept.
    pub traces: Option<Box<Traces>>,
    /// Summary of the mission.
    pub summary: ReplaySummary,
}

/// As [`compare`], with others that need the same ticks: one pass over the flight serves all of them.
///
/// # Errors
/// [`ReplayError`] if no mission can be made from the model.
pub fn compare_with(
    replay: &Replay<'_>,
    options: &Options,
    progress: &mut (dyn FnMut(u64) + Send),
    companions: Companions<'_>,
    executor: &dyn Executor,
) -> Result<Compared, ReplayError> {
    let Companions { output: mut on_output, observers: others } = companions;
    let mut comparator = Comparator::new(options.trace_slots);
    let mut tally = RemedyTally::default();
    let mut rows = 0;
    let mut flown = Flown::new(replay.model(), |input, output| {
        comparator.take(input, output);
        tally.take(output);
        if let Some(on_output) = &mut on_output {
            on_output(output);
        }
        rows += 1;
        if rows % ROWS_PER_REPORT == 0 {
            progress(rows);
        }
    })?;
    let mut remedies = remedies(replay)?;
    let mut observers: Vec<&mut dyn Observer> = vec![&mut flown];
    observers.extend(remedies.iter_mut().map(|run| -> &mut dyn Observer { run }));
    observers.extend(others.into_iter().map(|other| -> &mut dyn Observer { other }));
    let inputs = replay.pass(&mut observers, executor);
    let summary = flown.summary(inputs);
    drop(flown);

    let end =
        MissionEnd { latch: summary.latch.as_ref(), counters: &summary.counters, model: replay.model() };
    let (mut comparison, traces) = comparator.finish(&end, &options.requirements, executor);
    comparison.flight = facts(replay);
    comparison.calibration.source = replay.source().to_string();
    let mut warnings = input_warnings(&summary.inputs);
    warnings.append(&mut effect_warnings(replay.model(), replay.flight()));
    warnings.append(&mut comparison.warnings);
    comparison.warnings = warnings;
    let mut figures: Vec<Remedy> = remedies.iter().map(|run| run.tally.figures(run.name)).collect();
    figures.push(tally.figures(name(&replay.model().second_correction)));
    figures.sort_by_key(|remedy| ORDER.iter().position(|name| *name == remedy.second_correction));
    comparison.remedies = figures.into_iter().filter(|remedy| !remedy.sensors.is_empty()).collect();
    Ok(Compared { comparison, traces, summary })
}

fn facts(replay: &Replay<'_>) -> FlightFacts {
    let flight = replay.flight();
    let times = || flight.time_s.iter().copied();
    let last = times().fold(f64::NEG_INFINITY, f64::max);
    let first = times().fold(f64::INFINITY, f64::min);
    FlightFacts {
        file: String::new(),
        vehicle: flight.header.vehicle.clone(),
        source: flight.header.source.clone(),
        rows: flight.rows() as u64,
        duration_s: if last > first { last - first } else { 0.0 },
        usage: Usage::of(replay),
    }
}

const ORDER: [&str; 3] = ["none", "moving_average", "kalman"];

const fn name(correction: &SecondCorrection) -> &'static str {
    match correction {
        SecondCorrection::Off => ORDER[0],
        SecondCorrection::MovingAverage => ORDER[1],
        SecondCorrection::Kalman { .. } => ORDER[2],
    }
}

/// A run with another second correction than the flown one.
struct RemedyRun {
    name: &'static str,
    mission: Box<dyn AnyMission>,
    tally: RemedyTally,
}

impl Observer for RemedyRun {
    fn take(&mut self, ticks: &[TickInput]) {
        for input in ticks {
            self.tally.take(&self.mission.tick(input));
        }
    }
}

/// Section 4's second corrections other than the flown one, side by side over the same ticks.
fn remedies(replay: &Replay<'_>) -> Result<Vec<RemedyRun>, ReplayError> {
    let mut runs = Vec::new();
    if !has_launch(replay) {
        return Ok(runs);
    }
    let flown = name(&replay.model().second_correction);
    let kalman = SecondCorrection::Kalman { wander_m_per_sqrt_s: SECOND_CORRECTION_WANDER_M_PER_SQRT_S };
    for second_correction in [SecondCorrection::Off, SecondCorrection::MovingAverage, kalman] {
        let name = name(&second_correction);
        if name != flown {
            let model = Model { second_correction, ..replay.model().clone() };
            runs.push(RemedyRun { name, mission: mission(&model)?, tally: RemedyTally::default() });
        }
    }
    Ok(runs)
}

/// Whether there is free flight: before launch no second correction does anything.
fn has_launch(replay: &Replay<'_>) -> bool {
    match replay.source() {
        CalibrationSource::LaunchColumn => {
            let launch = replay.flight().channel(Channel::Launch);
            launch.is_some_and(|column| column.samples().any(|(_, value)| value != 0.0))
        }
        CalibrationSource::Given(_) | CalibrationSource::Quiet(_) | CalibrationSource::Calmest(_) => true,
        CalibrationSource::Uncalibrated(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_launched(launch: &str) -> bool {
        let mut csv = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,baro_alt_m\n".to_owned();
        for row in 0..40 {
            let cell = if row == 39 { launch } else { "0" };
            csv += &format!("{row},{cell},{},{}\n", 100 + row % 2, 90 + row % 3);
        }
        let flight = flight_data::parse(csv.as_bytes()).unwrap().0;
        let replay = Replay::new(&flight, &Model::default(), None).unwrap();
        has_launch(&replay)
    }

    /// A launch column that is never set has no launch.
    #[test]
    fn a_column_of_zeros_is_no_launch() {
        assert!(is_launched("1") && !is_launched("0"));
    }
}
