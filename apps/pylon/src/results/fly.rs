//! `pylon fly --json`.

use std::collections::BTreeMap;

use analysis::name::Name;
use emulate::{ChipsReport, Consequence, CostUnit, Difference, FlyReport};
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::VERSION;

/// A flight through the firmware, compared with the host.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum FlyResult {
    /// Every bit is the same.
    Agrees(Box<FlyAgreement>),
    /// Bits differ.
    Differs(FlyDifference),
}

impl<'de> Deserialize<'de> for FlyResult {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let agrees = value.get("bit_for_bit").and_then(Value::as_bool) == Some(true);
        let result = if agrees {
            FlyAgreement::deserialize(value).map(|agreement| Self::Agrees(Box::new(agreement)))
        } else {
            FlyDifference::deserialize(value).map(Self::Differs)
        };
        result.map_err(D::Error::custom)
    }
}

/// Bits that differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlyDifference {
    /// Version of these keys.
    pub version: u32,
    /// `false`.
    pub bit_for_bit: bool,
    /// Ticks flown and compared.
    pub ticks: u64,
    /// Ticks that differ; 0 for a difference in the latch alone.
    pub ticks_that_differ: u64,
    /// The first difference.
    pub first: FirstDifference,
}

/// Where the bits differ first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FirstDifference {
    /// The tick, from 0.
    pub tick: u64,
    /// Its time, seconds of the flight's clock.
    pub time_s: f64,
    /// The field, as a path in Rust's notation.
    pub field: String,
    /// The host's value.
    pub host: String,
    /// The target's value.
    pub target: String,
}

impl From<&Difference> for FlyDifference {
    fn from(difference: &Difference) -> Self {
        Self {
            version: VERSION,
            bit_for_bit: false,
            ticks: difference.ticks,
            ticks_that_differ: difference.ticks_that_differ,
            first: FirstDifference {
                tick: difference.tick,
                time_s: difference.time_us as f64 * 1e-6,
                field: difference.field.clone(),
                host: difference.host.clone(),
                target: difference.target.clone(),
            },
        }
    }
}

/// A flight on which every tick had the same bits. Costs are in instructions if QEMU flew it, in cycles if a
/// board did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlyAgreement {
    /// Version of these keys.
    pub version: u32,
    /// `true`.
    pub bit_for_bit: bool,
    /// Ticks flown and compared.
    pub ticks: u32,
    /// Cost of a tick, drivers and mission together.
    #[serde(flatten, deserialize_with = "analysis::json::whole")]
    pub cost: PartCost,
    /// Cost of each part of a tick, by name.
    pub parts: BTreeMap<Name, PartCost>,
    /// When the most expensive tick was, seconds of the flight's clock.
    pub worst_time_s: f64,
    /// From one tick to the next, instructions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tick_period_instructions: Option<u32>,
    /// The same on a board, cycles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tick_period_cycles: Option<u32>,
    /// Largest difference between the starts of two ticks relative to their grid of 5 ms, instructions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_jitter_instructions: Option<u64>,
    /// The same on a board, cycles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_jitter_cycles: Option<u64>,
    /// Largest stack use, bytes.
    pub stack_used_bytes: u32,
    /// Size of the stack, bytes.
    pub stack_size_bytes: u32,
    /// Flash that the image takes, bytes.
    pub flash_bytes: u64,
    /// RAM that its static variables take, bytes.
    pub static_ram_bytes: u64,
    /// Polls of sensors that failed; the same number on both.
    pub sensor_faults: u32,
    /// Facts of a flight on chips; null with ideal sensors.
    pub chips: Option<ChipsResult>,
    /// Timer ticks on which the mission waited for its input.
    pub underruns: u32,
    /// Timer ticks on which the mission waited for room for its results.
    pub stalls: u32,
    /// When the calibration was latched, seconds of the flight's clock; null without a launch.
    pub latched_s: Option<f64>,
    /// What the firmware logged.
    pub log: Vec<String>,
}

/// Cost of a tick, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartCost {
    /// Mean, instructions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions_mean: Option<f64>,
    /// The most expensive tick's, instructions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions_worst: Option<u32>,
    /// Mean, cycles of a board.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycles_mean: Option<f64>,
    /// The most expensive tick's, cycles of a board.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycles_worst: Option<u32>,
}

impl PartCost {
    fn new(unit: CostUnit, mean: f64, worst: u32) -> Self {
        match unit {
            CostUnit::Instructions => {
                Self { instructions_mean: Some(mean), instructions_worst: Some(worst), ..Self::default() }
            }
            CostUnit::Cycles => {
                Self { cycles_mean: Some(mean), cycles_worst: Some(worst), ..Self::default() }
            }
        }
    }
}

impl From<&FlyReport> for FlyAgreement {
    fn from(report: &FlyReport) -> Self {
        let unit = report.cost_unit;
        let is_emulated = matches!(unit, CostUnit::Instructions);
        let parts = report.parts.iter().map(|part| {
            let cost = PartCost::new(unit, part.instructions_mean, part.instructions_worst);
            (part.part.name().into(), cost)
        });
        Self {
            version: VERSION,
            bit_for_bit: true,
            ticks: report.ticks,
            cost: PartCost::new(unit, report.instructions_mean, report.instructions_worst),
            parts: parts.collect(),
            worst_time_s: report.worst_time_us as f64 * 1e-6,
            tick_period_instructions: is_emulated.then_some(report.tick_period),
            tick_period_cycles: (!is_emulated).then_some(report.tick_period),
            start_jitter_instructions: is_emulated.then_some(report.start_jitter),
            start_jitter_cycles: (!is_emulated).then_some(report.start_jitter),
            stack_used_bytes: report.stack_used_bytes,
            stack_size_bytes: report.stack_size_bytes,
            flash_bytes: report.flash_bytes,
            static_ram_bytes: report.static_ram_bytes,
            sensor_faults: report.sensor_faults,
            chips: report.chips.as_ref().map(ChipsResult::from),
            underruns: report.underruns,
            stalls: report.stalls,
            latched_s: report.latch.as_ref().map(|latch| latch.time_us as f64 * 1e-6),
            log: report.log.clone(),
        }
    }
}

/// A flight on models of the sensors' chips, with counts of what could not pass through them unchanged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChipsResult {
    /// Rows of the flight.
    pub rows: u64,
    /// Ticks of 5 ms to which the rows were assigned.
    pub ticks: u64,
    /// Rows that share a tick with the row before.
    pub rows_that_share_a_tick: u64,
    /// Samples that a later one at the same tick replaced.
    pub samples_superseded: u64,
    /// Rows earlier than the row before them, not flown.
    pub late_rows: u64,
    /// Values that are NaN or infinite.
    pub not_finite: u32,
    /// Values beyond the barometer's range.
    pub baro_beyond_range: u32,
    /// Values beyond the inertial unit's range.
    pub imu_beyond_range: u32,
    /// Values beyond the receiver's range.
    pub gps_beyond_range: u32,
    /// Barometer readings without a temperature: 25 degrees Celsius assumed.
    pub assumed_temperatures: u32,
    /// Fixes without a satellite count: 12 assumed.
    pub assumed_satellites: u32,
    /// Fixes with an incomplete velocity, which was not used.
    pub partial_velocities: u32,
    /// Fixes that were held, sent once.
    pub held_fixes: u32,
    /// Altitudes of the mother ship after launch, not sent.
    pub after_launch: u32,
    /// Ticks at an impossible time.
    pub impossible_times: u32,
    /// Fixes while the receiver was starting, not sent.
    pub untold_fixes: u32,
    /// What the planned faults did; null without any.
    pub fault: Option<Consequence>,
    /// The latched calibration compared with that of ideal sensors, by sensor; null without a launch, or with
    /// faults.
    pub agreement: Option<BTreeMap<Name, SensorAgreementResult>>,
}

/// A sensor's latched bias on chips and with ideal sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorAgreementResult {
    /// With ideal sensors, metres.
    pub ideal_bias_m: f32,
    /// On chips, metres.
    pub chips_bias_m: f32,
    /// On chips less ideal, metres.
    pub difference_m: f64,
    /// Largest difference that the chips' resolution and delays explain, metres.
    pub bound_m: f64,
    /// Whether they explain it.
    pub within_bound: bool,
}

impl From<&ChipsReport> for ChipsResult {
    fn from(chips: &ChipsReport) -> Self {
        let ChipsReport { grid, truth, untold_fixes, agreement, consequence } = chips;
        let agreement = agreement.as_ref().map(|agreement| {
            let sensors = agreement.sensors.iter().map(|sensor| {
                let result = SensorAgreementResult {
                    ideal_bias_m: sensor.ideal_bias_m,
                    chips_bias_m: sensor.chips_bias_m,
                    difference_m: sensor.difference_m(),
                    bound_m: sensor.bound_m,
                    within_bound: sensor.is_within_bound(),
                };
                (sensor.sensor.name().into(), result)
            });
            sensors.collect()
        });
        Self {
            rows: grid.rows,
            ticks: grid.ticks,
            rows_that_share_a_tick: grid.shared,
            samples_superseded: grid.superseded_samples,
            late_rows: grid.late_rows,
            not_finite: truth.not_finite,
            baro_beyond_range: truth.baro_beyond_range,
            imu_beyond_range: truth.imu_beyond_range,
            gps_beyond_range: truth.gps_beyond_range,
            assumed_temperatures: truth.assumed_temperatures,
            assumed_satellites: truth.assumed_satellites,
            partial_velocities: truth.partial_velocities,
            held_fixes: truth.held_fixes,
            after_launch: truth.after_launch,
            impossible_times: truth.impossible_times,
            untold_fixes: *untold_fixes,
            fault: consequence.clone(),
            agreement,
        }
    }
}
