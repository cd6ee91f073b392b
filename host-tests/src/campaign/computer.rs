//! The flight computer on the host, with memory that survives a reset, and a supply that dips.

use std::cell::Cell;
use std::rc::Rc;

use anyhow::{Context as _, Result, anyhow};
use chip_models::flown::{Chip, ChipFault, Fault, ModelledSuite};
use chip_models::metered::WorkObserver;
use flight_computer::{Interruptible, Onboard, ResetFacts, Step};
use kf_core::config::MissionConfig;
use kf_core::input::TickInput;
use kf_core::launch::LaunchConfig;
use kf_core::mission::Mission;
use kf_core::strapdown;
use survival::{Cause, CrashRecord, ResetSource, RestartReport, RetainedImage, keep_crash};

use super::fault::{Boundary, Dip};

/// The default model's mission.
pub type FlownMission = Mission<0, 4, 0>;

/// Any value will do: there is only one model.
const FINGERPRINT: u64 = 0x5a5a;

/// Counts the operations on the chips' ports.
#[derive(Clone, Debug, Default)]
pub struct Work(Rc<Cell<u32>>);

impl Work {
    /// Returns the operations since the last call.
    pub fn take(&self) -> u32 {
        self.0.replace(0)
    }
}

impl WorkObserver for Work {
    fn begin(&mut self) -> u32 {
        self.0.set(self.0.get().saturating_add(1));
        0
    }

    fn end(&mut self, _begun: u32) {}
}

/// The flight computer and its retained memory.
pub struct Computer {
    /// Operations on ports.
    pub work: Work,
    config: MissionConfig<0>,
    memory: RetainedImage,
    /// `None` once it has no mission any more.
    run: Option<Interruptible<ModelledSuite<Work>, FlownMission>>,
}

impl Computer {
    /// Makes a computer that is switched on for the first time.
    ///
    /// # Errors
    /// The model does not make a mission.
    pub fn new(config: &MissionConfig<0>) -> Result<Self> {
        let work = Work::default();
        let sensors = ModelledSuite::new(&work);
        let mut computer = Self { work, config: config.clone(), memory: RetainedImage::default(), run: None };
        computer.start(sensors, ResetSource::Supply, Some(false))?;
        Ok(computer)
    }

    fn start(
        &mut self,
        sensors: ModelledSuite<Work>,
        source: ResetSource,
        wire_is_open: Option<bool>,
    ) -> Result<Option<RestartReport>> {
        let mission = FlownMission::new(&self.config).map_err(|error| anyhow!("the model: {error:?}"))?;
        let onboard = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS)
            .map_err(|error| anyhow!("the launch's limits: {error:?}"))?;
        let facts = ResetFacts::host(source, wire_is_open);
        let run = Interruptible::start(sensors, mission, Some(onboard), &mut self.memory, FINGERPRINT, facts);
        Ok(match run {
            Ok(run) => {
                let report = run.report().copied();
                self.run = Some(run);
                report
            }
            Err(report) => {
                self.run = None;
                Some(report)
            }
        })
    }

    /// The mission, if there is one.
    #[must_use]
    pub fn mission(&self) -> Option<&FlownMission> {
        self.run.as_ref().map(|run| &run.computer.mission)
    }

    /// Begins or ends a fault of a chip.
    pub fn inject(&mut self, event: ChipFault) {
        if let Some(run) = &mut self.run {
            run.computer.sensors.inject(event);
        }
    }

    /// Sets the lead of the receiver's clock over the flight computer's, microseconds.
    pub fn set_receivers_lead(&mut self, lead_us: i64) {
        if let Some(run) = &mut self.run {
            run.computer.sensors.set_receivers_lead(lead_us);
        }
    }

    /// Runs one tick and the task below it that keeps a snapshot; with a dip, only up to the dip.
    pub fn tick(&mut self, input: &TickInput, dip: Option<&Dip>) -> Option<Step> {
        let Self { memory, run, .. } = self;
        let run = run.as_mut()?;
        run.computer.sensors.load(input);
        let Some(dip) = dip else { return Some(run.tick(memory, input.time_us)) };
        match dip.boundary {
            Boundary::BeforeMark => memory.cut_after(0),
            Boundary::InMark(words) => memory.cut_after(words),
            Boundary::BeforeSnapshot | Boundary::InSnapshot(_) | Boundary::AtEnd => {}
        }
        let step = run.tick_only(memory, input.time_us);
        match dip.boundary {
            Boundary::BeforeSnapshot => memory.cut_after(0),
            Boundary::InSnapshot(words) => memory.cut_after(words),
            _ => {}
        }
        run.keep_snapshot(memory);
        Some(step)
    }

    /// Starts the flight computer after the supply has come back, or a crash has reset the processor.
    ///
    /// # Errors
    /// The model does not make a mission, or there is no mission any more.
    pub fn restart(&mut self, wire_is_open: Option<bool>, after: &Dip) -> Result<Option<RestartReport>> {
        self.memory.restore_supply();
        let Dip { with_chips, is_crash, .. } = *after;
        if is_crash {
            let last_us = self.mission().map_or(0, FlownMission::last_us);
            keep_crash(
                &mut self.memory,
                CrashRecord { count: last_us as u32, ..CrashRecord::new(Cause::Panic) },
            );
        }
        let source = if is_crash { ResetSource::Software } else { ResetSource::Supply };
        let mut sensors = self.run.take().context("the board stands by for ever")?.computer.sensors;
        if with_chips {
            for chip in [Chip::Baro, Chip::Imu, Chip::Gps] {
                sensors.inject(ChipFault { chip, fault: Fault::Reset });
            }
        }
        sensors.restart();
        self.start(sensors, source, wire_is_open)
    }
}
