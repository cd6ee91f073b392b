//! Signals as curves: times and values, whatever their source.

use std::ops::Range;
use std::rc::Rc;

use analysis::compare::Motion;
use analysis::diagnose::prediction;
use flight_data::{Channel, Column};
use kf_core::effect::{Clock, EffectSubject, Regressor};
use kf_core::sensor::Sensor;
use model::Model;
use replay::Replay;

use crate::beyond;
use crate::engine::{Engine, Progress, Refused, parsed, refused, replay};
use crate::protocol::{Acting, ModelText, Signal, Times};
use crate::recording::{Recording, SensorTrack};

/// Two values have a gap between them if they are further apart than this many of their usual intervals, as
/// in the diagnosis for fixes.
const GAP_INTERVALS: f64 = 4.0;
/// Limit on the intervals over which the median is taken as the usual one.
const INTERVALS: usize = 2_048;

/// The quantity of a recording that a curve shows.
#[derive(Clone, Copy)]
enum Of {
    Reference,
    Estimate,
    Measured(usize),
    Modelled(usize),
    Error(usize),
    Average(usize),
}

enum Points {
    /// Values at the ticks of a recording.
    Recorded(Rc<Recording>, Of),
    /// Values at their own times, increasing.
    Own(Vec<f64>, Vec<f64>),
}

/// A curve.
pub struct Curve {
    points: Points,
    /// One sigma of each value, for values at their own times.
    pub sigma: Option<Vec<f64>>,
    /// The unit.
    pub unit: &'static str,
}

impl Curve {
    /// A curve of values at their own times.
    pub fn own(time_s: Vec<f64>, values: Vec<f64>, unit: &'static str) -> Self {
        Self { points: Points::Own(time_s, values), sigma: None, unit }
    }

    /// The same curve with one sigma of each value.
    pub fn with_sigma(self, sigma: Vec<f64>) -> Self {
        Self { sigma: Some(sigma), ..self }
    }

    fn times(&self) -> &[f64] {
        match &self.points {
            Points::Recorded(recording, _) => &recording.time_s,
            Points::Own(time_s, _) => time_s,
        }
    }

    /// Indices of the values between two times.
    pub fn range(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let times = self.times();
        times.partition_point(|time_s| *time_s < from_s)..times.partition_point(|time_s| *time_s <= to_s)
    }

    /// Passes each value in a range of indices to `take`, with its index and its time.
    pub fn each(&self, range: Range<usize>, take: &mut dyn FnMut(usize, f64, f64)) {
        let times = self.times();
        let mut each = |value: &dyn Fn(usize) -> f64| {
            for place in range.clone() {
                let (Some(time_s), value) = (times.get(place), value(place)) else { continue };
                if value.is_finite() {
                    take(place, *time_s, value);
                }
            }
        };
        let at = |values: &[f32], place: usize| values.get(place).map_or(f64::NAN, |value| f64::from(*value));
        match &self.points {
            Points::Own(_, values) => each(&|place| values.get(place).copied().unwrap_or(f64::NAN)),
            Points::Recorded(recording, of) => {
                let sensor = |index: usize| recording.sensors.get(index);
                let of_sensor = |index: usize, values: fn(&SensorTrack) -> &[f32], place: usize| {
                    sensor(index).map_or(f64::NAN, |track| at(values(track), place))
                };
                match *of {
                    Of::Reference => each(&|place| at(&recording.reference_m, place)),
                    Of::Estimate => each(&|place| at(&recording.estimate_m, place)),
                    Of::Measured(index) => each(&|place| of_sensor(index, |track| &track.measured_m, place)),
                    Of::Error(index) => each(&|place| of_sensor(index, |track| &track.error_m, place)),
                    Of::Average(index) => each(&|place| of_sensor(index, |track| &track.average_m, place)),
                    Of::Modelled(index) => each(&|place| {
                        of_sensor(index, |track| &track.measured_m, place)
                            - of_sensor(index, |track| &track.error_m, place)
                    }),
                }
            }
        }
    }

    /// Values longer apart than this have a gap between them, seconds; `None` for fewer than three values.
    pub fn gap_s(&self, range: Range<usize>) -> Option<f64> {
        let every = (range.len() / INTERVALS).max(1);
        let (mut intervals, mut last, mut count) = (Vec::new(), None, 0_usize);
        self.each(range, &mut |_, time_s, _| {
            if let Some(last_s) = last.replace(time_s)
                && count.is_multiple_of(every)
            {
                intervals.push(time_s - last_s);
            }
            count += 1;
        });
        let middle = intervals.len().checked_sub(1)? / 2;
        let median_s = *intervals.select_nth_unstable_by(middle, f64::total_cmp).1;
        (intervals.len() > 1).then_some(GAP_INTERVALS * median_s)
    }
}

/// A flight, a model that flies it, and where to calibrate.
pub struct Flown<'a> {
    /// The flight.
    pub flight: &'a str,
    /// The model.
    pub model: &'a ModelText,
    /// Where to calibrate.
    pub times: Times,
}

/// The curve of a signal.
pub fn curve(
    engine: &mut Engine,
    flown: &Flown<'_>,
    signal: &Signal,
    progress: &mut Progress<'_>,
) -> Result<Rc<Curve>, Refused> {
    let name = serde_json::to_string(signal).map_err(refused)?;
    engine
        .curve((flown.flight, flown.model, flown.times), name, |engine| made(engine, flown, signal, progress))
}

fn made(
    engine: &mut Engine,
    flown: &Flown<'_>,
    signal: &Signal,
    progress: &mut Progress<'_>,
) -> Result<Curve, Refused> {
    let of = match signal {
        Signal::Column { name } => return column(engine, flown, name),
        Signal::Effect { of } => return effect(engine, flown, of),
        Signal::BeyondReference { sensor, noise, found } => {
            return beyond::curve(engine, flown, self::sensor(sensor)?, (noise, found), progress);
        }
        Signal::Reference => Of::Reference,
        Signal::Estimate => Of::Estimate,
        Signal::Measured { sensor } => Of::Measured(self::sensor(sensor)?.index()),
        Signal::Modelled { sensor } => Of::Modelled(self::sensor(sensor)?.index()),
        Signal::Error { sensor } => Of::Error(self::sensor(sensor)?.index()),
        Signal::MovingAverage { sensor } => Of::Average(self::sensor(sensor)?.index()),
        Signal::ClimbRate => return motion(engine, flown, progress, |motion| motion.climb_rate_mps, "m/s"),
        Signal::Speed => return motion(engine, flown, progress, |motion| motion.speed_mps, "m/s"),
        Signal::LoadFactor => return motion(engine, flown, progress, |motion| motion.load_factor, "g"),
        Signal::TurnRate => {
            return motion(engine, flown, progress, |motion| motion.turn_rate_radps, "rad/s");
        }
    };
    let recording = engine.recording(flown.flight, flown.model, flown.times, progress)?;
    Ok(Curve { points: Points::Recorded(recording, of), sigma: None, unit: "m" })
}

/// Finds a sensor by its name.
pub fn sensor(name: &str) -> Result<Sensor, Refused> {
    let found = Sensor::ALL.into_iter().find(|sensor| sensor.name() == name);
    found.ok_or_else(|| refused(format!("no sensor '{name}', expected baro, imu_slave or imu_master")))
}

/// A column as it was logged. Rows whose time is not later than all before them are left out, as in the
/// estimator.
fn column(engine: &Engine, flown: &Flown<'_>, name: &str) -> Result<Curve, Refused> {
    let open = engine.flight(flown.flight)?;
    let flight = &open.flight;
    let extra = || flight.extra.iter().find_map(|(other, column)| (other == name).then_some(column));
    let column: &Column = Channel::from_name(name)
        .and_then(|channel| flight.channel(channel))
        .or_else(extra)
        .ok_or_else(|| refused(format!("{}: no column '{name}'", open.file)))?;
    let (mut times, mut values) = (Vec::new(), Vec::new());
    let mut last_s = f64::NEG_INFINITY;
    for (row, value) in column.samples_f64() {
        let Some(time_s) = flight.time_s.get(row).copied().filter(|time_s| *time_s > last_s) else {
            continue;
        };
        last_s = time_s;
        times.push(time_s);
        values.push(value);
    }
    Ok(Curve::own(times, values, unit(name)))
}

/// A column's unit, according to its name.
fn unit(column: &str) -> &'static str {
    const UNITS: [(&str, &str); 9] = [
        ("_mps2", "m/s²"),
        ("_radps", "rad/s"),
        ("_mps", "m/s"),
        ("_rad", "rad"),
        ("_pa", "Pa"),
        ("_c", "°C"),
        ("_m", "m"),
        ("_s", "s"),
        ("_deg", "°"),
    ];
    UNITS.iter().find_map(|(end, unit)| column.ends_with(end).then_some(*unit)).unwrap_or("")
}

/// An effect with its constants.
pub fn regressor(of: &Acting, model: &Model) -> Result<Regressor, Refused> {
    let id = model
        .effect_named(&of.effect)
        .ok_or_else(|| refused(format!("no effect '{}' in the catalogue or the model", of.effect)))?;
    let since = match of.since.as_deref() {
        None | Some("launch") => Clock::Launch,
        Some("start") => Clock::Start,
        Some(other) => return Err(refused(format!("no clock '{other}', expected launch or start"))),
    };
    let base = Regressor::new(id);
    let time_constant_s = of.time_constant_s.map_or(base.time_constant_s, |seconds| seconds as f32);
    Ok(Regressor { time_constant_s, since, ..base })
}

fn effect(engine: &Engine, flown: &Flown<'_>, of: &Acting) -> Result<Curve, Refused> {
    let replay = replay(engine.flight(flown.flight)?, flown.model, flown.times)?;
    let predicted = in_error(&replay, regressor(of, &parsed(flown.model)?)?, of.coefficient);
    let (times, values) = predicted.into_iter().unzip();
    Ok(Curve::own(times, values, "m"))
}

/// What an effect adds to the error of its sensor, seconds and metres. An error of the reference appears in
/// the errors of all sensors with the opposite sign.
pub fn in_error(replay: &Replay<'_>, regressor: Regressor, coefficient: f64) -> Vec<(f64, f64)> {
    let sign = match regressor.id.subject() {
        EffectSubject::Gps => -1.0,
        EffectSubject::Sensor(_) => 1.0,
    };
    let points = prediction(replay, regressor, coefficient);
    points.into_iter().map(|(time_us, metres)| (time_us as f64 * 1e-6, sign * metres)).collect()
}

fn motion(
    engine: &mut Engine,
    flown: &Flown<'_>,
    progress: &mut Progress<'_>,
    quantity: fn(&Motion) -> Option<f64>,
    unit: &'static str,
) -> Result<Curve, Refused> {
    let recording = engine.recording(flown.flight, flown.model, flown.times, progress)?;
    let start_s = recording.motion.start_us as f64 * 1e-6;
    let motions = recording.motion.motions.iter().enumerate();
    let (times, values) = motions
        .map(|(second, motion)| (start_s + second as f64 + 0.5, quantity(motion).unwrap_or(f64::NAN)))
        .unzip();
    Ok(Curve::own(times, values, unit))
}
