//! A flight computer that a test can interrupt.

use core::mem::MaybeUninit;

use drivers::Sensors;
use survival::{MarkWriter, PAYLOAD_BYTES, RestartReport, Start, WordMemory, keep_captive_force};

use crate::computer::{FlightComputer, Step};
use crate::estimation::Retainable;
use crate::onboard::Onboard;
use crate::restart::{ResetFacts, assess_restart, resume_mission};
use crate::retention::{SnapshotKeeper, keep_mark};

/// One run of a flight computer, from one reset to the next. It does everything that an image does to the
/// retained memory in that time: the start, each tick's mark, and the snapshots of the task below the tick.
///
/// To interrupt it, drop it. To interrupt it while it writes, call [`survival::RetainedImage::cut_after`]
/// before [`Self::tick`] or [`Self::start`]; what happens after the cut affects only the dropped run.
///
/// ```ignore
/// let mut memory = RetainedImage::default();
/// let facts = ResetFacts::host(ResetSource::Supply, Some(false));
/// let mut run = Interruptible::start(sensors, mission(), onboard(), &mut memory, model, facts)?;
/// for tick in 1..=100 {
///     run.tick(&mut memory, tick * 5_000);
/// }
/// memory.cut_after(2); // the supply dips in the next tick, after two words of its mark
/// run.tick(&mut memory, 505_000);
/// memory.restore_supply();
/// let facts = ResetFacts::host(ResetSource::Supply, Some(true)); // the wire is open
/// let run = Interruptible::start(sensors, mission(), onboard(), &mut memory, model, facts)?;
/// let first_us = run.report().map_or(0, |report| report.resumed_us);
/// ```
/// `host-tests/tests/interrupted_runs.rs` runs it.
#[derive(Clone, Debug)]
pub struct Interruptible<Suite, Mission> {
    /// The chain of a tick.
    pub computer: FlightComputer<Suite, Mission>,
    marks: MarkWriter,
    keeper: SnapshotKeeper,
    report: Option<RestartReport>,
}

impl<Suite: Sensors, Mission: Retainable> Interruptible<Suite, Mission> {
    /// Starts with the contents of `memory`. The clock continues at the report's `resumed_us`, or at 0.
    /// `onboard` is `None` for a recording's sensors.
    ///
    /// # Errors
    /// The report, if the mission does not continue ([`Start::Standby`]: only with a guard taken out).
    pub fn start(
        sensors: Suite,
        mut mission: Mission,
        mut onboard: Option<Onboard>,
        memory: &mut impl WordMemory,
        model: u64,
        facts: ResetFacts,
    ) -> Result<Self, RestartReport> {
        let mut buffer = [0; PAYLOAD_BYTES];
        let mut assessment = assess_restart(memory, model, &facts, &mut buffer);
        if let Some(report) = assessment.report.filter(|report| report.start == Start::Standby) {
            return Err(report);
        }
        let inertial = resume_mission(&mut mission, memory, model, &mut assessment, &mut buffer);
        let report = assessment.report;
        if let Some(onboard) = &mut onboard {
            onboard.resume(report.as_ref(), inertial.as_ref(), memory);
        }
        Ok(Self {
            computer: FlightComputer { sensors, mission, onboard },
            marks: MarkWriter::find(memory),
            keeper: SnapshotKeeper::new(assessment.order, model),
            report,
        })
    }

    /// How this run started; `None` if nothing was found.
    #[must_use]
    pub const fn report(&self) -> Option<&RestartReport> {
        self.report.as_ref()
    }

    /// Snapshots that could not be kept.
    #[must_use]
    pub const fn lost_snapshots(&self) -> u32 {
        self.keeper.lost()
    }

    /// Runs a tick, and the task below it.
    pub fn tick(&mut self, memory: &mut impl WordMemory, now_us: u64) -> Step {
        let step = self.tick_only(memory, now_us);
        self.keep_snapshot(memory);
        step
    }

    /// Runs a tick without the task below it, as if a reset came between the two. The board's free-running
    /// timer counts microseconds of the mission.
    pub fn tick_only(&mut self, memory: &mut impl WordMemory, now_us: u64) -> Step {
        let step = self.computer.tick(now_us);
        let wire = self.computer.onboard.as_ref().map(|onboard| onboard.launch().wire());
        keep_mark(&mut self.marks, memory, &self.computer.mission, &step, now_us as u32, wire);
        step
    }

    /// Runs the task below the tick: keeps what the force was like under the pylon, and a snapshot, if they
    /// are due.
    pub fn keep_snapshot(&mut self, memory: &mut impl WordMemory) {
        if let Some(force) = self.keeper.captive_force_due(self.computer.onboard.as_ref()) {
            keep_captive_force(memory, force);
        }
        let mut place = MaybeUninit::uninit();
        let due = self.keeper.make_due(&self.computer.mission, self.computer.onboard.as_ref(), &mut place);
        if let Some(due) = due {
            self.keeper.keep(memory, due, &mut [0; PAYLOAD_BYTES]);
        }
    }
}
