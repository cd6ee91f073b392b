//! The telemetry of this image: its line's rate, what that line carries, and what is told of each tick.

use flight_computer::Step;
use heapless::spsc::{Consumer, Producer};
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::output::{Phase, TickOutput};
use telemetry::{ComputerStatus, FrameQueue, Link, Rates, Said, Telemetry};

use crate::flown_model;

include!(concat!(env!("OUT_DIR"), "/telemetry.rs"));

/// The fullest rate table that the line carries; a line that carries none does not compile.
const RATES: Rates = match Rates::for_line(BAUD) {
    Ok(rates) => rates,
    Err(_) => panic!("PYLON_TELEMETRY_BAUD is too slow for any rate table"),
};

/// The frames between what tells of the ticks and the line.
pub type Frames = FrameQueue;

/// The teller's end of them.
pub type FramesIn = Producer<'static, telemetry::Frame>;

/// The line's.
pub type FramesOut = Consumer<'static, telemetry::Frame>;

/// What there is to tell of a tick.
pub struct Told {
    /// What it took and said.
    step: Step,
    /// What the mission had counted by its end.
    counters: Counters,
    /// What the flight computer had.
    computer: ComputerStatus,
}

/// Between the tick and the task that tells of it, which has all of the time between two: room for one.
#[derive(Default)]
pub struct Mailbox {
    told: Option<Told>,
    is_new: bool,
}

impl Mailbox {
    /// Puts a tick into it, field by field where it stays. Whether the one before it had been taken out; it is lost else.
    pub fn put(&mut self, step: &Step, counters: &Counters, computer: ComputerStatus) -> bool {
        let was_taken = !self.is_new;
        self.is_new = true;
        match &mut self.told {
            Some(told) => {
                told.step.input = step.input;
                copy(&step.output, &mut told.step.output);
                told.counters = *counters;
                told.computer = computer;
            }
            None => self.told = Some(Told { step: step.clone(), counters: *counters, computer }),
        }
        was_taken
    }

    /// Changes what has been put into it since the last time for what came out of it then, and says whether there is any.
    pub fn change(&mut self, told: &mut Option<Told>) -> bool {
        let is_new = core::mem::take(&mut self.is_new);
        if is_new {
            core::mem::swap(&mut self.told, told);
        }
        is_new
    }
}

/// As `clone_from`, whose derived form makes a copy first and moves it.
fn copy(from: &TickOutput, to: &mut TickOutput) {
    let TickOutput {
        time_us,
        out_of_order,
        phase,
        latched_now,
        failed_checks,
        altitude_m,
        altitude_variance_m2,
        gps_innovation_m,
        gps_signed_nis,
        gps_rejection,
        sensors,
        extrapolated,
        cross_check,
        bridged_us,
        coefficients,
    } = from;
    to.time_us = *time_us;
    to.out_of_order = *out_of_order;
    to.phase = *phase;
    to.latched_now = *latched_now;
    to.failed_checks = *failed_checks;
    to.altitude_m = *altitude_m;
    to.altitude_variance_m2 = *altitude_variance_m2;
    to.gps_innovation_m = *gps_innovation_m;
    to.gps_signed_nis = *gps_signed_nis;
    to.gps_rejection = *gps_rejection;
    to.sensors = *sensors;
    to.extrapolated = *extrapolated;
    to.cross_check = *cross_check;
    to.bridged_us = *bridged_us;
    to.coefficients.clone_from(coefficients);
}

/// What makes the messages, below the tick.
pub struct Downlink {
    telemetry: Telemetry<'static>,
    /// The tick that is told of.
    pub told: Option<Told>,
    latch: Option<LatchRecord>,
}

impl Downlink {
    /// Telemetry of the model that was compiled in.
    pub fn new(frames: FramesIn) -> Self {
        Self {
            telemetry: Telemetry::new(Link::new(frames), RATES, &flown_model::effects()),
            told: None,
            latch: None,
        }
    }

    /// Whether the calibration has been latched by the end of the tick and is not known here.
    pub fn lacks_latch(&self) -> bool {
        let is_free = |told: &Told| told.step.output.phase == Phase::FreeFlight;
        self.latch.is_none() && self.told.as_ref().is_some_and(is_free)
    }

    /// The latched calibration, which never changes.
    pub fn take_latch(&mut self, latch: Option<LatchRecord>) {
        self.latch = latch;
    }

    /// Tells of the tick.
    pub fn tell(&mut self) {
        let Some(Told { step, counters, computer }) = &self.told else { return };
        let said = Said { input: &step.input, output: &step.output, latch: self.latch.as_ref(), counters };
        self.telemetry.tick(&said, computer);
    }
}
