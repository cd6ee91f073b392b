//! Report of a flight that was the same bit by bit at every tick.

use chip_models::flown::TruthCounts;
use flight_computer::Part;
use flight_record::{CostUnit, Summary};
use kf_core::latch::LatchRecord;

use super::agreement::Agreement;
use super::consequence::Consequence;
use super::grid::GridReport;

/// The bytes sent over the telemetry line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Downlinked {
    /// From the emulated flight computer: whole frames, without those that still waited at the flight's end.
    pub target: Vec<u8>,
    /// What the host would have sent on a line that is never full.
    pub host: Vec<u8>,
}

/// A flight that was the same bit by bit at every tick on host and target.
#[derive(Clone, Debug, PartialEq)]
pub struct FlyReport {
    /// Ticks flown and compared.
    pub ticks: u32,
    /// Unit of the costs here: instructions in QEMU; cycles on a board, although the fields are called
    /// instructions.
    pub cost_unit: CostUnit,
    /// Instructions of one tick, drivers and mission, mean.
    pub instructions_mean: f64,
    /// Instructions of the most expensive tick.
    pub instructions_worst: u32,
    /// Time of that tick, microseconds.
    pub worst_time_us: u64,
    /// Period of the ticks, instructions.
    pub tick_period: u32,
    /// Largest difference between how late two ticks began on their grid of 5 ms, instructions.
    pub start_jitter: u64,
    /// Cost of each part of the ticks.
    pub parts: Vec<PartReport>,
    /// Timer ticks at which the mission waited for its input.
    pub underruns: u32,
    /// Timer ticks at which it waited for room for its results.
    pub stalls: u32,
    /// Largest use of the stack, bytes.
    pub stack_used_bytes: u32,
    /// Size of the stack, bytes.
    pub stack_size_bytes: u32,
    /// Flash that the image takes, bytes.
    pub flash_bytes: u64,
    /// RAM that its static variables take, bytes.
    pub static_ram_bytes: u64,
    /// Failed polls of sensors, the same on both.
    pub sensor_faults: u32,
    /// Report of a flight on chips.
    pub chips: Option<ChipsReport>,
    /// The latched calibration, the same on both; `None` for a flight without launch.
    pub latch: Option<LatchRecord>,
    /// What the firmware logged.
    pub log: Vec<String>,
    /// The bytes sent over the telemetry line, if requested.
    pub telemetry: Option<Downlinked>,
    /// The flight computer's results as it sent them, if requested.
    pub record: Option<Vec<u8>>,
}

/// Report of a flight on chips.
#[derive(Clone, Debug, PartialEq)]
pub struct ChipsReport {
    /// What became of the flight's rows.
    pub grid: GridReport,
    /// Values that could not pass through the chips as the flight has them.
    pub truth: TruthCounts,
    /// Fixes that came before the receiver was configured, or too many at a time.
    pub untold_fixes: u32,
    /// Difference between the latched calibration and that of ideal sensors; `None` without a launch or with
    /// planned faults.
    pub agreement: Option<Agreement>,
    /// Effect of the planned faults, against the same flight without them; `None` without any.
    pub consequence: Option<Consequence>,
}

/// Cost of one part of the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReport {
    /// The part.
    pub part: Part,
    /// Instructions a tick, mean.
    pub instructions_mean: f64,
    /// Instructions of the most expensive tick.
    pub instructions_worst: u32,
}

/// Costs of the parts of a flight's ticks.
pub(crate) fn parts(summary: &Summary) -> Vec<PartReport> {
    let costs = Part::ALL.into_iter().zip(&summary.parts);
    let ticks = f64::from(summary.ticks.max(1));
    costs
        .map(|(part, cost)| PartReport {
            part,
            instructions_mean: cost.sum as f64 / ticks,
            instructions_worst: cost.worst,
        })
        .collect()
}
