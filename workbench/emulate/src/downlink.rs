//! The flight computer's telemetry, made on the host by the same code.

use heapless::spsc::Consumer;
use kf_core::effect::EffectId;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;
use model::Model;
use survival::RestartReport;
use telemetry::{ComputerStatus, Frame, FrameQueue, Link, Rates, Telemetry, TickReport};

use replay::AnyMission;

/// Telemetry of a flight on a line that is never full.
pub struct Downlink<'a> {
    telemetry: Telemetry<'a>,
    line: Consumer<'a, Frame>,
    bytes: Vec<u8>,
}

impl<'a> Downlink<'a> {
    /// Telemetry of a model at these rates, passed through a queue.
    #[must_use]
    pub fn new(queue: &'a mut FrameQueue, model: &Model, rates: Rates) -> Self {
        let (frames, line) = queue.split();
        let effects: Vec<EffectId> = model.estimated_effects().map(|effect| effect.term.id()).collect();
        Self { telemetry: Telemetry::new(Link::new(frames), rates, &effects), line, bytes: Vec::new() }
    }

    /// Sends how the flight computer started.
    pub fn note_start(&mut self, report: &RestartReport) {
        self.telemetry.note_start(report);
    }

    /// Sends the telemetry of a tick.
    pub fn tell(
        &mut self,
        input: &TickInput,
        output: &TickOutput,
        mission: &dyn AnyMission,
        computer: &ComputerStatus,
    ) {
        let report = TickReport { input, output, latch: mission.latch(), counters: mission.counters() };
        self.telemetry.tick(&report, computer);
        while let Some(frame) = self.line.dequeue() {
            self.bytes.extend_from_slice(frame.bytes());
        }
    }

    /// The bytes sent over the line.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}
