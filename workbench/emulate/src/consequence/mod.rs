//! What a chip's fault did to a flight, compared with the same flight without it.
//!
//! Both are flown on the host, whose bits are the target's. The comparison covers the purpose of the flight
//! computer: the calibration that it latches, when it decides the launch, the flags that it raises, the
//! altitudes that it publishes, and for how long a sensor delivers nothing.

mod silence;
mod text;

use std::borrow::Cow;
use std::collections::BTreeMap;

use chip_models::flown::ChipFault;
use drivers::Sensors as _;
use flight_computer::Step;
use flight_record::SensorSource;
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::output::{Phase, Trust};
use kf_core::quality::FailedChecks;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;
use replay::reading_m;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::FlyError;
use super::fault_script::{Item, Scripted};
use super::grid::{OnGrid, TICK_US};
use super::host;

/// The name of a sensor, a check or a verdict: a built-in one, or one read from a file.
pub type Name = Cow<'static, str>;

/// A value without the fault, and with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CleanAndFaulty<T> {
    /// Value of the flight without the fault.
    pub clean: T,
    /// Value of the flight with the fault.
    pub with_fault: T,
}

/// What a fault did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Consequence {
    /// The calibration.
    pub calibration: CalibrationChange,
    /// When the launch was decided, seconds of the flight's time; null without one.
    pub launch_decided_s: CleanAndFaulty<Option<f64>>,
    /// The flags, by sensor in free flight.
    pub flags: BTreeMap<Name, FlagsChange>,
    /// The reference altitude as estimated in captive flight; null where both flights have none.
    pub captive_altitude: Option<AltitudeDifference>,
    /// Each sensor's altitude in free flight, as calibrated: reading less latched bias.
    pub free_flight_altitude: BTreeMap<Name, AltitudeDifference>,
    /// For how long each source delivered nothing while it did without the fault, seconds.
    pub not_delivering_s: BTreeMap<Name, f64>,
    /// Readings that the estimator refused, by sensor, `gps` among them.
    pub readings_refused: BTreeMap<Name, CleanAndFaulty<u32>>,
    /// Polls of sensors that failed.
    pub polls_failed: CleanAndFaulty<u32>,
    /// Number of ticks at which the flight computer's input or output has different bits.
    pub ticks_that_differ: usize,
}

/// Two calibrations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibrationChange {
    /// When they were latched: the launch's first edge, seconds of the flight's time; null without a launch.
    pub latched_s: CleanAndFaulty<Option<f64>>,
    /// `good`, `degraded`, or null when nothing was latched.
    pub quality: CleanAndFaulty<Option<Name>>,
    /// Names of the checks that failed.
    pub failed_checks: CleanAndFaulty<Vec<Name>>,
    /// The biases of the sensors that were calibrated in both.
    pub sensors: BTreeMap<Name, BiasChange>,
}

/// A sensor's calibration in both flights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BiasChange {
    /// Latched bias, metres.
    pub bias_m: CleanAndFaulty<f64>,
    /// Change of the bias due to the fault, metres.
    pub difference_m: f64,
    /// The same in standard deviations of the bias with the fault, as the filter states them.
    pub difference_in_sigmas: f64,
    /// Standard deviation of the bias, metres.
    pub bias_sigma_m: CleanAndFaulty<f64>,
    /// The monitor's alarm limit, metres.
    pub bound_m: CleanAndFaulty<f64>,
    /// Readings used.
    pub readings: CleanAndFaulty<u32>,
}

/// A sensor's flags in both flights: seconds after the launch's first edge, or null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlagsChange {
    /// When it became doubtful.
    pub doubtful_after_s: CleanAndFaulty<Option<f64>>,
    /// When it became untrustworthy.
    pub untrustworthy_after_s: CleanAndFaulty<Option<f64>>,
    /// Time in free flight without monitoring, seconds.
    pub unmonitored_s: CleanAndFaulty<f64>,
}

/// Distance of two altitudes, over the ticks that have both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AltitudeDifference {
    /// Root mean square, metres.
    pub rms_m: f64,
    /// Largest, metres.
    pub peak_m: f64,
    /// Time of the largest, seconds of the flight's time.
    pub peak_s: f64,
    /// Number of ticks.
    pub ticks: usize,
}

/// What delivers: four devices, and the altitude that is computed from the inertial unit's samples or
/// delivered by a device of its own.
const SOURCES: [&str; 5] = ["baro", "imu", "gps", "umbilical", "imu_slave"];

/// Flies the rows on chips with and without the faults.
///
/// # Errors
/// As [`super::fly_on_host`].
pub(super) fn of(
    rows: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    events: &[(u64, ChipFault)],
) -> Result<Consequence, FlyError> {
    let clean = Flown::new(OnGrid::new(rows.clone()).map(Item::Tick), model)?;
    let with_fault = Flown::new(Scripted::new(OnGrid::new(rows), events), model)?;
    Ok(beside(&clean, &with_fault))
}

/// A flight on the host, with what is compared.
struct Flown {
    ticks: Vec<Tick>,
    latch: Option<LatchRecord>,
    decided_us: Option<u64>,
    doubtful_us: [Option<u64>; SENSORS],
    untrustworthy_us: [Option<u64>; SENSORS],
    unmonitored_ticks: [u32; SENSORS],
    /// For `gps` and the sensors.
    refused: [u32; 1 + SENSORS],
    polls_failed: u32,
}

struct Tick {
    time_us: u64,
    /// A bit for each of [`SOURCES`].
    delivered: u8,
    /// The estimated altitude in captive flight, metres.
    estimated_m: Option<f32>,
    /// Each sensor's calibrated altitude in free flight, metres.
    calibrated_m: [Option<f32>; SENSORS],
    /// A checksum of all bits of the tick's input and output.
    check: u64,
}

impl Tick {
    fn of(step: &Step) -> Self {
        let Step { input, output } = step;
        let delivers = [
            input.baro.is_some(),
            input.imu.is_some(),
            input.gps.is_some(),
            input.imu_master_altitude_m.is_some(),
            input.imu_slave_altitude_m.is_some(),
        ];
        let delivered = delivers.iter().rev().fold(0, |bits, delivers| bits << 1 | u8::from(*delivers));
        let is_free = output.phase == Phase::FreeFlight;
        let mut calibrated_m = Sensor::ALL.map(|sensor| reading_m(sensor, input));
        for (altitude_m, sensor) in calibrated_m.iter_mut().zip(&output.sensors) {
            *altitude_m = altitude_m.filter(|_| is_free).map(|altitude_m| altitude_m - sensor.bias_m);
        }
        Self {
            time_us: output.time_us,
            delivered,
            estimated_m: (!is_free).then_some(output.altitude_m),
            calibrated_m,
            check: super::compare::check_of(step),
        }
    }
}

impl Flown {
    fn new(items: impl Iterator<Item = Item>, model: &Model) -> Result<Self, FlyError> {
        let mut computer = host::computer(model, SensorSource::Chips, false)?;
        let mut flown = Self {
            ticks: Vec::new(),
            latch: None,
            decided_us: None,
            doubtful_us: [None; SENSORS],
            untrustworthy_us: [None; SENSORS],
            unmonitored_ticks: [0; SENSORS],
            refused: [0; 1 + SENSORS],
            polls_failed: 0,
        };
        for item in items {
            match item {
                Item::Fault(fault) => {
                    computer.sensors.recorded.inject(fault);
                }
                Item::Tick(input) => {
                    computer.sensors.recorded.load(&input);
                    flown.take(&computer.tick(input.time_us));
                }
            }
        }
        flown.latch = computer.mission.latch().cloned();
        let counters = computer.mission.counters();
        let sources = [&counters.gps].into_iter().chain(&counters.sensors);
        for (refused, source) in flown.refused.iter_mut().zip(sources) {
            // A held sample is not a reading, and a reading that was used was not refused.
            *refused = source.not_finite + source.stuck + source.variance;
        }
        flown.polls_failed = computer.sensors.faults().count;
        Ok(flown)
    }

    fn take(&mut self, step: &Step) {
        let output = &step.output;
        if output.latched_now {
            self.decided_us.get_or_insert(output.time_us);
        }
        for (sensor, output_of) in output.sensors.iter().enumerate() {
            if matches!(output_of.trust, Trust::Doubtful | Trust::Untrustworthy) {
                self.doubtful_us[sensor].get_or_insert(output.time_us);
            }
            if output_of.trust == Trust::Untrustworthy {
                self.untrustworthy_us[sensor].get_or_insert(output.time_us);
            }
            let is_unmonitored = output.phase == Phase::FreeFlight && output_of.trust == Trust::Unmonitored;
            self.unmonitored_ticks[sensor] += u32::from(is_unmonitored);
        }
        self.ticks.push(Tick::of(step));
    }

    /// Seconds after the launch's first edge.
    fn after_s(&self, time_us: Option<u64>) -> Option<f64> {
        let launched_us = self.latch.as_ref()?.time_us;
        time_us.map(|time_us| time_us.saturating_sub(launched_us) as f64 / 1e6)
    }

    fn failed_checks(&self) -> Vec<Name> {
        let bits = self.latch.as_ref().map_or(0, |latch| latch.failed_checks);
        FailedChecks::from_bits(bits).iter().map(|check| check.name().into()).collect()
    }

    fn quality(&self) -> Option<Name> {
        self.latch.as_ref().map(|latch| if latch.failed_checks == 0 { "good" } else { "degraded" }.into())
    }
}

fn beside(clean: &Flown, with_fault: &Flown) -> Consequence {
    let free = || Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
    let flags = free().map(|sensor| (sensor.name().into(), flags(clean, with_fault, sensor.index())));
    let pairs = || clean.ticks.iter().zip(&with_fault.ticks);
    let captive = pairs().map(|(one, other)| (one.time_us, one.estimated_m, other.estimated_m));
    let altitudes = free().filter_map(|sensor| {
        let of = |tick: &Tick| tick.calibrated_m[sensor.index()];
        Some((
            sensor.name().into(),
            difference(pairs().map(|(one, other)| (one.time_us, of(one), of(other))))?,
        ))
    });
    let silent = SOURCES.into_iter().enumerate().filter_map(|(bit, name)| {
        let delivers =
            |flown: &Flown| flown.ticks.iter().map(|tick| tick.delivered >> bit & 1 == 1).collect::<Vec<_>>();
        let ticks = silence::ticks(&delivers(clean), &delivers(with_fault))?;
        Some((name.into(), (ticks as u64 * TICK_US) as f64 / 1e6))
    });
    let names = ["gps"].into_iter().chain(Sensor::ALL.map(Sensor::name));
    let refused = clean.refused.iter().zip(&with_fault.refused);
    Consequence {
        calibration: CalibrationChange {
            latched_s: both(clean, with_fault, |flown| {
                flown.latch.as_ref().map(|latch| latch.time_us as f64 / 1e6)
            }),
            quality: both(clean, with_fault, Flown::quality),
            failed_checks: both(clean, with_fault, Flown::failed_checks),
            sensors: biases(clean, with_fault),
        },
        launch_decided_s: both(clean, with_fault, |flown| {
            flown.decided_us.map(|time_us| time_us as f64 / 1e6)
        }),
        flags: flags.collect(),
        captive_altitude: difference(captive),
        free_flight_altitude: altitudes.collect(),
        not_delivering_s: silent.collect(),
        readings_refused: names
            .map(Name::from)
            .zip(refused.map(|(clean, with_fault)| CleanAndFaulty { clean: *clean, with_fault: *with_fault }))
            .collect(),
        polls_failed: both(clean, with_fault, |flown| flown.polls_failed),
        ticks_that_differ: pairs().filter(|(one, other)| one.check != other.check).count(),
    }
}

fn both<T>(clean: &Flown, with_fault: &Flown, of: impl Fn(&Flown) -> T) -> CleanAndFaulty<T> {
    CleanAndFaulty { clean: of(clean), with_fault: of(with_fault) }
}

fn flags(clean: &Flown, with_fault: &Flown, sensor: usize) -> FlagsChange {
    FlagsChange {
        doubtful_after_s: both(clean, with_fault, |flown| flown.after_s(flown.doubtful_us[sensor])),
        untrustworthy_after_s: both(clean, with_fault, |flown| flown.after_s(flown.untrustworthy_us[sensor])),
        unmonitored_s: both(clean, with_fault, |flown| {
            f64::from(flown.unmonitored_ticks[sensor]) * TICK_US as f64 / 1e6
        }),
    }
}

fn biases(clean: &Flown, with_fault: &Flown) -> BTreeMap<Name, BiasChange> {
    let (Some(clean), Some(with_fault)) = (&clean.latch, &with_fault.latch) else { return BTreeMap::new() };
    let pairs = Sensor::ALL.into_iter().zip(clean.sensors.iter().zip(&with_fault.sensors));
    pairs
        .filter(|(_, (clean, with_fault))| clean.readings > 0 && with_fault.readings > 0)
        .map(|(sensor, (clean, with_fault))| {
            let difference_m = f64::from(with_fault.bias_m) - f64::from(clean.bias_m);
            let sigma_m = |variance_m2: f32| f64::from(variance_m2).sqrt();
            let bias_sigma_m = CleanAndFaulty {
                clean: sigma_m(clean.bias_variance_m2),
                with_fault: sigma_m(with_fault.bias_variance_m2),
            };
            let bias = BiasChange {
                bias_m: CleanAndFaulty { clean: clean.bias_m.into(), with_fault: with_fault.bias_m.into() },
                difference_m,
                difference_in_sigmas: difference_m / bias_sigma_m.with_fault,
                bias_sigma_m,
                bound_m: CleanAndFaulty {
                    clean: clean.bound_m().into(),
                    with_fault: with_fault.bound_m().into(),
                },
                readings: CleanAndFaulty { clean: clean.readings, with_fault: with_fault.readings },
            };
            (sensor.name().into(), bias)
        })
        .collect()
}

fn difference(
    altitudes: impl Iterator<Item = (u64, Option<f32>, Option<f32>)>,
) -> Option<AltitudeDifference> {
    let mut found = AltitudeDifference::default();
    let mut sum_m2 = 0.0;
    for (time_us, clean_m, with_fault_m) in altitudes {
        let (Some(clean_m), Some(with_fault_m)) = (clean_m, with_fault_m) else { continue };
        let apart_m = (f64::from(with_fault_m) - f64::from(clean_m)).abs();
        sum_m2 += apart_m * apart_m;
        if apart_m > found.peak_m {
            (found.peak_m, found.peak_s) = (apart_m, time_us as f64 / 1e6);
        }
        found.ticks += 1;
    }
    (found.ticks > 0).then(|| AltitudeDifference { rms_m: (sum_m2 / found.ticks as f64).sqrt(), ..found })
}
