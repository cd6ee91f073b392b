//! One trial: fly, search, and compare the laws with the truth on another flight.

use std::path::Path;

use anyhow::Context as _;
use kf_core::formula::{Evaluation, Frame, Signal};
use model::Model;
use model::formula::{Columns, Formula};
use pylon::diagnose::NamedReplay;
use pylon::discover::{Discovery, FoundLaw, discover};
use pylon::flight::{Channel, Flight};
use pylon::replay::Replay;

use super::draw::Case;
use super::fly::{Flown, fly};

/// Result of a trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The case drawn.
    pub case: Case,
    /// Result of the search.
    pub discovery: Discovery,
    /// For each law, its correlation with the truth in free flight of the next flight.
    pub correlations: Vec<f64>,
    /// Effect of the hidden law on the barometer in free flight of the next flight, rms about captive flight,
    /// metres; and the part that the first law leaves.
    pub next_m: Option<[f64; 2]>,
}

/// Writes the search's inputs, for other methods to try: block means of the flight and of the next one, each
/// with a column `true_m`, what the hidden law adds in the block.
///
/// # Errors
/// If the aircraft can't fly the plan, or a file can't be written.
pub fn dump(case: &Case, folder: &Path) -> anyhow::Result<()> {
    for number in 0..2 {
        let flown = fly(case, number)?;
        let model = Model::default();
        let replay = Replay::new(&flown.flight, &model, None)?;
        let mut table = Vec::new();
        pylon::discover::dump(&replay, &mut table)?;
        let table = String::from_utf8(table)?;
        let mut text = String::new();
        let times = &flown.flight.time_s;
        for (k, line) in table.lines().enumerate() {
            let added = if k == 0 {
                "true_m".to_owned()
            } else {
                let time_s: f64 = line.split(',').next().unwrap_or_default().parse()?;
                let [from, to] =
                    [-HALF_BLOCK_S, HALF_BLOCK_S].map(|by| times.partition_point(|t| *t < time_s + by));
                let rows = flown.true_m.get(from..to).unwrap_or_default();
                format!("{:.9e}", rows.iter().sum::<f64>() / rows.len().max(1) as f64)
            };
            text += &format!("{line},{added}\n");
        }
        std::fs::write(folder.join(format!("{}-{number}.csv", case.seed)), text)?;
    }
    Ok(())
}

/// Half of a block's length, seconds.
const HALF_BLOCK_S: f64 = 0.5;

/// Runs a case.
///
/// # Errors
/// If the aircraft can't fly the plan.
pub fn run(case: Case) -> anyhow::Result<Trial> {
    let flown = fly(&case, 0)?;
    let model = Model::default();
    let replay = Replay::new(&flown.flight, &model, None)?;
    let named = NamedReplay::new(format!("laws {}", case.seed), replay);
    let discovery = discover(&[named], &[], &mut || ());
    let mut correlations = Vec::new();
    let mut next_m = None;
    if !discovery.laws.is_empty() {
        let next = fly(&case, 1)?;
        for (k, law) in discovery.laws.iter().enumerate() {
            let predicted = predicted(law, &next.flight)?;
            correlations.push(if &*law.on == "baro" { correlation(&next, &predicted) } else { 0.0 });
            if k == 0 {
                let is_baro = &*law.on == "baro";
                let rest: Vec<f64> = next
                    .true_m
                    .iter()
                    .zip(&predicted)
                    .map(|(a, b)| if is_baro { a - b } else { -b })
                    .collect();
                let before = if is_baro { rms(&next, &next.true_m) } else { 0.0 };
                next_m = Some([before, rms(&next, &rest)]);
            }
        }
    }
    Ok(Trial { case, discovery, correlations, next_m })
}

/// What a law adds to its sensor in a flight, metres, computed by the formulas' own machine.
fn predicted(law: &FoundLaw, flight: &Flight) -> anyhow::Result<Vec<f64>> {
    let mut columns = Columns::default();
    let formula =
        Formula::compile(&law.regressor, &mut columns).map_err(|error| anyhow::anyhow!("{error}"))?;
    let mut evaluation = Evaluation::new(formula.program(), 0.0);
    let mut frame = Frame::default();
    let known: Vec<_> = flight
        .channels
        .iter()
        .filter_map(|(channel, column)| {
            Some((Signal::from_name(channel.name())?.place(), channel.name().ends_with("_c"), column))
        })
        .collect();
    let extra: Vec<_> = columns
        .iter()
        .enumerate()
        .map(|(number, said)| {
            let column =
                flight.extra.iter().find(|(name, _)| name == said.name()).context("a column is missing")?;
            anyhow::Ok((Signal::column_place(number as u8), said, &column.1))
        })
        .collect::<anyhow::Result<_>>()?;
    let launch = flight.channel(Channel::Launch).context("no launch")?;
    let mut metres = Vec::with_capacity(flight.rows());
    let (mut last_m, mut launched, mut last_s) = (0.0, false, 0.0);
    for (row, time_s) in flight.time_s.iter().enumerate() {
        launched |= launch.get(row).is_some_and(|value| value > 0.5);
        let begins = last_s < 10.0 && *time_s >= 10.0;
        frame.begin((time_s - last_s) as f32, launched, begins);
        last_s = *time_s;
        frame.set(Signal::Launch.place(), if launched { 1.0 } else { 0.0 });
        for (place, is_celsius, column) in &known {
            if let Some(value) = column.get(row) {
                frame.set(*place, if *is_celsius { value + 273.15 } else { value });
            }
        }
        let value = |channel: Channel| flight.channel(channel).and_then(|column| column.get(row));
        if let Some(down) = value(Channel::GpsVdMps) {
            frame.set(Signal::ClimbRate.place(), -down);
        }
        if let (Some(north), Some(east)) = (value(Channel::GpsVnMps), value(Channel::GpsVeMps)) {
            frame.set(Signal::GroundSpeed.place(), north.hypot(east));
        }
        if let Some(down) = value(Channel::AccelZMps2) {
            frame.set(Signal::LoadFactor.place(), -down / 9.806_65);
        }
        for (place, said, column) in &extra {
            if let Some(cell) = column.get(row) {
                frame.set(*place, said.si(cell));
            }
        }
        if let Ok(value) = evaluation.step(&frame) {
            last_m = law.coefficient * f64::from(value);
        }
        frame.end();
        metres.push(last_m);
    }
    Ok(metres)
}

/// Rows a second that are used.
const EVERY: usize = 20;

fn free(flown: &Flown) -> impl Iterator<Item = usize> {
    (0..flown.captive.len()).filter(|row| !flown.captive[*row]).step_by(EVERY)
}

/// Correlation in free flight.
fn correlation(flown: &Flown, predicted: &[f64]) -> f64 {
    let rows: Vec<usize> = free(flown).collect();
    let mean = |values: &[f64]| rows.iter().map(|row| values[*row]).sum::<f64>() / rows.len().max(1) as f64;
    let (a, b) = (mean(&flown.true_m), mean(predicted));
    let of = |f: &dyn Fn(usize) -> f64| rows.iter().map(|row| f(*row)).sum::<f64>();
    let product = of(&|row| (flown.true_m[row] - a) * (predicted[row] - b));
    let squares = of(&|row| (flown.true_m[row] - a).powi(2)) * of(&|row| (predicted[row] - b).powi(2));
    if squares > 0.0 { product / squares.sqrt() } else { 0.0 }
}

/// Rms in free flight about the mean in captive flight.
fn rms(flown: &Flown, values: &[f64]) -> f64 {
    let captive: Vec<usize> =
        (0..flown.captive.len()).filter(|row| flown.captive[*row]).step_by(EVERY).collect();
    let origin = captive.iter().map(|row| values[*row]).sum::<f64>() / captive.len().max(1) as f64;
    let squares: Vec<f64> = free(flown).map(|row| (values[row] - origin).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}
