//! `pylon report`: one page that shows flights, where the model holds and where it fails.
//!
//! The page is one HTML file that needs no network: it contains the style, uPlot and all data. Long flights
//! are thinned out (least, greatest and mean of each time slot), so that it stays small.

mod dependence;
mod figures;
mod ladder;
mod page;
mod recording;
mod signals;
mod summary;
mod table;

use kf_core::sensor::Sensor;
use model::Model;

use crate::batch::Batch;
use crate::compare::{Comparison, Traces};
use crate::diagnose::Diagnosis;
use crate::learn::Ladder;
use crate::replay::Replay;
use dependence::Dependence;
use recording::{ERROR, Recording};
use signals::{Blocks, signals};

pub use page::file_name;
pub use view::{Band, Chart, Level, Line, Moment, Role, Shade, Values};

/// What the page shows of one flight.
#[derive(Clone, Debug)]
pub struct FlightReport {
    /// Its id in the page.
    id: String,
    comparison: Comparison,
    calibration: Vec<Chart>,
    residuals: Vec<Chart>,
    free_flight: Vec<Chart>,
    /// Measured against modelled, by sensor.
    measured: Vec<(&'static str, Vec<Chart>)>,
    dependences: Vec<SensorDependences>,
    /// Whether its diagrams are on the page.
    is_drawn: bool,
}

/// Time slots of a chart's series: four times the pixels of a wide chart, so that zooming in shows more.
pub const TRACE_SLOTS: usize = 6_000;

/// Limit on the flights with diagrams on a page: the oddest and the worst. The diagrams of an hour take 1.7
/// MB, and a page that is mailed should take at most 5.
pub const MOST_DRAWN: usize = 2;

/// A sensor's error against every signal of the flight.
#[derive(Clone, Debug)]
struct SensorDependences {
    sensor: &'static str,
    /// Length of the blocks that were averaged over, seconds.
    block_s: f64,
    /// The charts and their shares, by falling share.
    charts: Vec<(f64, Chart)>,
    /// Names of the signals that did not change enough to show a dependence.
    quiet: Vec<String>,
}

/// All inputs of a page.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The flights, in the user's order.
    pub flights: &'a [FlightReport],
    /// The model that was flown.
    pub model: &'a Model,
    /// Its name: a preset or a file.
    pub model_name: &'a str,
    /// What the model lacks, according to all flights together.
    pub diagnosis: &'a Diagnosis,
    /// Every revision of the model on the flights and on the held-out ones.
    pub ladder: &'a Ladder,
    /// The flights one by one, if there are several.
    pub batch: Option<&'a Batch>,
}

impl FlightReport {
    /// Gathers what is drawn. `index` distinguishes the flights of one page; `comparison` and `traces` are
    /// those of the replay, the traces with [`TRACE_SLOTS`].
    #[must_use]
    pub fn new(index: usize, replay: &Replay<'_>, comparison: Comparison, traces: &Traces) -> Self {
        let id = format!("flight-{}", index + 1);
        let recording = Recording::of(traces, &comparison);
        Self {
            calibration: figures::calibration(&id, &recording),
            residuals: figures::residuals(&id, &recording, &comparison),
            free_flight: figures::free_flight(&id, &recording, &comparison),
            measured: figures::measured(&id, &recording, &comparison),
            dependences: dependences(&id, replay, &recording, &comparison),
            is_drawn: true,
            comparison,
            id,
        }
    }

    /// The largest error of its sensors in free flight, rms, metres.
    fn worst_rms_m(&self) -> f64 {
        let sensors = self.comparison.sensors.values();
        sensors.filter_map(|sensor| sensor.free_flight_rms_m).fold(0.0, f64::max)
    }

    /// Removes the diagrams.
    fn undraw(&mut self) {
        self.is_drawn = false;
        self.calibration.clear();
        self.residuals.clear();
        self.free_flight.clear();
        self.measured.clear();
        self.dependences.clear();
    }

    /// Every diagram of the flight.
    pub fn charts(&self) -> impl Iterator<Item = &Chart> {
        let measured = self.measured.iter().flat_map(|(_, charts)| charts);
        let dependences =
            self.dependences.iter().flat_map(|found| found.charts.iter().map(|(_, chart)| chart));
        self.calibration
            .iter()
            .chain(&self.residuals)
            .chain(&self.free_flight)
            .chain(measured)
            .chain(dependences)
    }

    /// The comparison that the flight's text is taken from.
    #[must_use]
    pub const fn comparison(&self) -> &Comparison {
        &self.comparison
    }
}

/// If there are more than [`MOST_DRAWN`] flights, keeps only the diagrams of those that do not belong with
/// the others (`odd`) and of those with the largest errors. A page with diagrams of forty similar flights
/// would be unreadable, and too large to open.
pub fn keep_most_telling(flights: &mut [FlightReport], odd: &[&str]) {
    let mut order: Vec<usize> = (0..flights.len()).collect();
    let rank = |place: &usize| {
        let Some(flight) = flights.get(*place) else { return (usize::MAX, 0.0) };
        let odd = odd.iter().position(|file| *file == flight.comparison.flight.file);
        (odd.unwrap_or(usize::MAX), -flight.worst_rms_m())
    };
    order.sort_by(|one, other| {
        let ((one, one_m), (other, other_m)) = (rank(one), rank(other));
        one.cmp(&other).then(one_m.total_cmp(&other_m))
    });
    for place in order.into_iter().skip(MOST_DRAWN) {
        if let Some(flight) = flights.get_mut(place) {
            flight.undraw();
        }
    }
}

impl Report<'_> {
    /// The page, as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        page::page(self)
    }
}

/// Dependences of the sensors that fly free, in free flight; without a launch, of all sensors in captive
/// flight.
fn dependences(
    flight: &str,
    replay: &Replay<'_>,
    recording: &Recording,
    comparison: &Comparison,
) -> Vec<SensorDependences> {
    let times = || replay.times_s().iter().copied();
    let end_s = times().fold(0.0, f64::max);
    let start_s = comparison.launch_s.unwrap_or_else(|| times().fold(end_s, f64::min));
    let blocks = Blocks::between(start_s, end_s);
    let time = if comparison.launch_s.is_some() { "time after launch" } else { "time from the start" };
    let signals = signals(replay.flight(), &blocks, time);
    let sensors =
        Sensor::ALL.into_iter().filter(|sensor| comparison.launch_s.is_none() || sensor.flies_free());
    sensors
        .filter(|sensor| comparison.sensors.contains_key(sensor.name()))
        .map(|sensor| {
            let table = &recording.whole[sensor.index()];
            let errors = table.mean(ERROR);
            let timed = table.times_s(0).into_iter().zip(errors).filter_map(|(time_s, y)| Some((time_s, y?)));
            let error_m = blocks.means(timed);
            let mut found = Vec::new();
            let mut quiet = Vec::new();
            for signal in &signals {
                match Dependence::of(&error_m, signal) {
                    Some(dependence) => found.push(dependence),
                    None => quiet.push(signal.name.clone()),
                }
            }
            found.sort_by(|a, b| b.share.total_cmp(&a.share));
            let charts = found.iter().enumerate().map(|(rank, dependence)| {
                let id = format!("{flight}-signal-{}-{rank}", sensor.name());
                (dependence.share, dependence.chart(id, sensor.name()))
            });
            SensorDependences {
                sensor: sensor.name(),
                block_s: blocks.length_s(),
                charts: charts.collect(),
                quiet,
            }
        })
        .collect()
}
