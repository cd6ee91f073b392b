//! Real flight logs, if present, with known effects added to their measurements. See SOURCES.md beside them.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use kf_core::atmosphere::STANDARD_GRAVITY_MPS2;
use model::Model;
use pylon::diagnose::{Diagnosis, NamedReplay, diagnose};
use pylon::flight::{Channel, Column, Flight};
use pylon::import::import_file;
use pylon::replay::Replay;

/// A sailplane, 6.8 hours over 3.9 km.
pub const OPTLONG: &str = "goigc_optlong.igc";
/// A sailplane, some minutes.
pub const SHORT: &str = "goigc_short1.igc";
/// A sailplane with its true airspeed and the air's temperature.
pub const NEW_ZEALAND: &str = "igclib_new_zealand.igc";
/// A paraglider that lands midway.
pub const LANDING: &str = "igclib_flight_with_middle_landing.igc";
/// A paraglider.
pub const PARAGLIDER: &str = "aerofiles_skytraxx21-2023-04-15.igc";

/// Path of a log, if it is present.
#[must_use]
pub fn path(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/flights/real/igc").join(name);
    path.exists().then_some(path)
}

/// A log as a flight; `None`, and a line `skipped`, if it is absent.
///
/// # Errors
/// If a log can't be read.
pub fn flight(name: &str) -> anyhow::Result<Option<Flight>> {
    let Some(path) = path(name) else {
        println!("skipped: {name}");
        return Ok(None);
    };
    Ok(Some(import_file(&path)?.0))
}

/// Diagnosis of a log with the default model, with or without a quiet stretch to calibrate on.
///
/// # Errors
/// If a flight can't be replayed.
pub fn diagnosis(flight: &Flight) -> anyhow::Result<Diagnosis> {
    let model = Model::default();
    let replay = Replay::to_diagnose(flight, &model, None)?;
    Ok(diagnose(&[NamedReplay::new("log".to_owned(), replay)], &[], &mut || ()))
}

/// A known effect, and its coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// `baro.scale`, on the height that the barometer itself measures.
    Scale(f64),
    /// `baro.dynamic_pressure`; needs the airspeed in the log.
    DynamicPressure(f64),
    /// `baro.drift`, m/s, from the first row on.
    Drift(f64),
    /// `baro.warm_up`, m, from the first row on, with this time constant, s.
    WarmUp(f64, f64),
    /// `baro.lag`, s: the age of the barometer's reading.
    Lag(f64),
    /// `baro.lag`, s, as in a tube: a first-order low pass with that time constant.
    LagLowPass(f64),
    /// `gps.latency`, s.
    Latency(f64),
    /// `gps.convergence`, m, with this time constant, s.
    Convergence(f64, f64),
}

impl Injection {
    /// The effect's id.
    #[must_use]
    pub const fn effect(self) -> &'static str {
        match self {
            Self::Scale(_) => "baro.scale",
            Self::DynamicPressure(_) => "baro.dynamic_pressure",
            Self::Drift(_) => "baro.drift",
            Self::WarmUp(..) => "baro.warm_up",
            Self::Lag(_) | Self::LagLowPass(_) => "baro.lag",
            Self::Latency(_) => "gps.latency",
            Self::Convergence(..) => "gps.convergence",
        }
    }

    /// Its coefficient.
    #[must_use]
    pub const fn coefficient(self) -> f64 {
        match self {
            Self::Scale(value)
            | Self::DynamicPressure(value)
            | Self::Drift(value)
            | Self::WarmUp(value, _)
            | Self::Lag(value)
            | Self::LagLowPass(value)
            | Self::Latency(value)
            | Self::Convergence(value, _) => value,
        }
    }

    /// The same with the coefficient multiplied by a factor.
    #[must_use]
    pub const fn times(self, factor: f64) -> Self {
        match self {
            Self::Scale(value) => Self::Scale(factor * value),
            Self::DynamicPressure(value) => Self::DynamicPressure(factor * value),
            Self::Drift(value) => Self::Drift(factor * value),
            Self::WarmUp(value, time_s) => Self::WarmUp(factor * value, time_s),
            Self::Lag(value) => Self::Lag(factor * value),
            Self::LagLowPass(value) => Self::LagLowPass(factor * value),
            Self::Latency(value) => Self::Latency(factor * value),
            Self::Convergence(value, time_s) => Self::Convergence(factor * value, time_s),
        }
    }

    /// Adds it to a log.
    ///
    /// # Errors
    /// If the log lacks a signal that it needs.
    pub fn inject(self, flight: &mut Flight) -> anyhow::Result<()> {
        let start_s = flight.time_s.first().copied().unwrap_or(0.0);
        let times_s = flight.time_s.clone();
        let since_s = |row: usize| times_s[row] - start_s;
        match self {
            Self::Scale(scale) => {
                add(flight, Channel::BaroAltM, &|_, altitude_m| scale * f64::from(altitude_m))
            }
            Self::DynamicPressure(share) => {
                let airspeed = flight.channel(Channel::TasMps).context("no airspeed")?.clone();
                let mut speed_mps = 0.0;
                let head_m: Vec<f64> = (0..airspeed.len())
                    .map(|row| {
                        speed_mps = airspeed.get(row).map_or(speed_mps, f64::from);
                        speed_mps * speed_mps / (2.0 * f64::from(STANDARD_GRAVITY_MPS2))
                    })
                    .collect();
                add(flight, Channel::BaroAltM, &|row, _| share * head_m[row])
            }
            Self::Drift(rate) => add(flight, Channel::BaroAltM, &|row, _| rate * since_s(row)),
            Self::WarmUp(size_m, time_s) => {
                add(flight, Channel::BaroAltM, &|row, _| size_m * (1.0 - (-since_s(row) / time_s).exp()))
            }
            Self::Lag(by_s) => delay(flight, Channel::BaroAltM, by_s),
            Self::LagLowPass(time_s) => low_pass(flight, Channel::BaroAltM, time_s),
            Self::Latency(by_s) => delay(flight, Channel::GpsAltM, by_s),
            Self::Convergence(size_m, time_s) => {
                add(flight, Channel::GpsAltM, &|row, _| size_m * (-since_s(row) / time_s).exp())
            }
        }
    }
}

/// Adds metres, computed from the row and the value, to a channel.
fn add(flight: &mut Flight, channel: Channel, metres: &dyn Fn(usize, f32) -> f64) -> anyhow::Result<()> {
    let column = flight.channel(channel).with_context(|| channel.name())?;
    let mut changed = Column::with_capacity(column.len());
    for row in 0..column.len() {
        changed.push(column.get(row).map(|value| (f64::from(value) + metres(row, value)) as f32));
    }
    flight.set_channel(channel, changed);
    Ok(())
}

/// Delays a channel: every sample shows the value of that time ago, interpolated linearly between samples.
fn delay(flight: &mut Flight, channel: Channel, by_s: f64) -> anyhow::Result<()> {
    let column = flight.channel(channel).with_context(|| channel.name())?;
    let samples: Vec<(f64, f32)> = column.samples().map(|(row, value)| (flight.time_s[row], value)).collect();
    let at = |time_s: f64| {
        let after = samples.partition_point(|(sample_s, _)| *sample_s < time_s);
        match (after.checked_sub(1).and_then(|before| samples.get(before)), samples.get(after)) {
            (Some((a_s, a)), Some((b_s, b))) => a + (b - a) * ((time_s - a_s) / (b_s - a_s)) as f32,
            (Some((_, value)), None) | (None, Some((_, value))) => *value,
            (None, None) => f32::NAN,
        }
    };
    let mut changed = Column::with_capacity(column.len());
    for row in 0..column.len() {
        changed.push(column.get(row).map(|_| at(flight.time_s[row] - by_s)));
    }
    flight.set_channel(channel, changed);
    Ok(())
}

/// Passes a channel through a first-order low pass, with straight lines between samples.
fn low_pass(flight: &mut Flight, channel: Channel, time_s: f64) -> anyhow::Result<()> {
    let column = flight.channel(channel).with_context(|| channel.name())?;
    let mut changed = Column::with_capacity(column.len());
    let mut last: Option<(f64, f64, f64)> = None;
    for row in 0..column.len() {
        let passed = column.get(row).map(|value| {
            let (now_s, value) = (flight.time_s[row], f64::from(value));
            let passed = match last {
                Some((last_s, before, passed)) if now_s > last_s => {
                    // A ramp is delayed by the time constant; the previous difference decays.
                    let slope = (value - before) / (now_s - last_s);
                    let keep = (-(now_s - last_s) / time_s).exp();
                    value - slope * time_s + keep * (passed - before + slope * time_s)
                }
                _ => value,
            };
            last = Some((now_s, value, passed));
            passed as f32
        });
        changed.push(passed);
    }
    flight.set_channel(channel, changed);
    Ok(())
}
