//! What there is to say about a flight whose every tick had the same bits.

use chip_models::flown::TruthCounts;
use flight_computer::Part;
use flight_record::{CostUnit, Summary};
use kf_core::latch::LatchRecord;

use super::agreement::Agreement;
use super::consequence::Consequence;
use super::grid::GridReport;

/// What went over the telemetry's line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Downlinked {
    /// The emulated flight computer's: whole frames, without those that still waited at the flight's end.
    pub target: Vec<u8>,
    /// What the host would have sent on a line that is never full.
    pub host: Vec<u8>,
}

/// A flight whose every tick had the same bits on host and target.
#[derive(Clone, Debug, PartialEq)]
pub struct FlyReport {
    /// Ticks flown and compared.
    pub ticks: u32,
    /// What the costs here are counted in: instructions in QEMU; on a board cycles, whatever a cost is
    /// called.
    pub cost_unit: CostUnit,
    /// Instructions of one tick, drivers and mission, mean.
    pub instructions_mean: f64,
    /// The dearest tick's.
    pub instructions_worst: u32,
    /// When that was, microseconds.
    pub worst_time_us: u64,
    /// From one tick to the next, instructions.
    pub tick_period: u32,
    /// How much later on its grid of 5 ms one tick began than another at most, instructions.
    pub start_jitter: u64,
    /// What each part of the ticks took.
    pub parts: Vec<PartReport>,
    /// Timer ticks at which the mission waited for its input.
    pub underruns: u32,
    /// Timer ticks at which it waited for room for its results.
    pub stalls: u32,
    /// Most stack that was ever in use, bytes.
    pub stack_used_bytes: u32,
    /// Stack there is, bytes.
    pub stack_size_bytes: u32,
    /// Flash that the image takes, bytes.
    pub flash_bytes: u64,
    /// RAM that its static variables take, bytes.
    pub static_ram_bytes: u64,
    /// How many polls of sensors failed, the same on both.
    pub sensor_faults: u32,
    /// What there is to say about a flight on chips.
    pub chips: Option<ChipsReport>,
    /// The latched calibration, the same on both; `None` for a flight without launch.
    pub latch: Option<LatchRecord>,
    /// What the firmware logged.
    pub log: Vec<String>,
    /// What went over the telemetry's line, if asked for.
    pub telemetry: Option<Downlinked>,
    /// The flight computer's results as it sent them, if asked for.
    pub record: Option<Vec<u8>>,
}

/// What there is to say about a flight on chips.
#[derive(Clone, Debug, PartialEq)]
pub struct ChipsReport {
    /// What became of the flight's rows.
    pub grid: GridReport,
    /// What could not go through the chips as the flight has it.
    pub truth: TruthCounts,
    /// Fixes that came before the receiver was configured, or too many at a time.
    pub untold_fixes: u32,
    /// How far the latched calibration is from the one of ideal sensors; `None` without a launch, or with
    /// faults planned.
    pub agreement: Option<Agreement>,
    /// What the planned faults did, beside the same flight without them; `None` without any.
    pub consequence: Option<Consequence>,
}

/// What one part of the ticks took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartReport {
    /// Which.
    pub part: Part,
    /// Instructions a tick, mean.
    pub instructions_mean: f64,
    /// The dearest tick's.
    pub instructions_worst: u32,
}

/// What the parts of a flight's ticks took.
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
