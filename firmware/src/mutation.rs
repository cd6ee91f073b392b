//! Planted errors and planted load, to prove that errors are found and load is withstood. There are none
//! unless the build asks for them (`PYLON_MUTATE`, see `build.rs`).

use drivers::{Device, Faults, Sensors};
use kf_core::input::TickInput;
use telemetry::Frame;

use crate::downlink::FramesOut;

/// Sensors whose samples are mutated on their way to the estimator.
pub struct Mutated<Suite>(pub Suite);

impl<Suite: Sensors> Sensors for Mutated<Suite> {
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        mutated(self.0.poll_each(now_us, polled))
    }

    fn faults(&self) -> Faults {
        self.0.faults()
    }

    fn wire(&self) -> Option<bool> {
        self.0.wire()
    }

    fn decided(&mut self, has_left: bool) {
        self.0.decided(has_left);
    }
}

/// The unchanged input.
#[cfg(not(any(pylon_mutate = "ulp", pylon_mutate = "panic", pylon_mutate = "fault")))]
const fn mutated(input: TickInput) -> TickInput {
    input
}

/// The input with the barometer one unit in the last place off, which the comparison with the host must find.
#[cfg(pylon_mutate = "ulp")]
fn mutated(mut input: TickInput) -> TickInput {
    use kf_core::input::BaroReading;

    input.baro = input.baro.map(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => BaroReading::PressurePa(pressure_pa.next_up()),
        BaroReading::AltitudeM(altitude_m) => BaroReading::AltitudeM(altitude_m.next_up()),
    });
    input
}

/// A panic in the middle of a tick.
#[cfg(pylon_mutate = "panic")]
#[expect(clippy::panic, reason = "planted")]
fn mutated(input: TickInput) -> TickInput {
    if input.time_us > 0 {
        panic!("planted");
    }
    input
}

/// A fault of the core in the middle of a tick.
#[cfg(pylon_mutate = "fault")]
fn mutated(input: TickInput) -> TickInput {
    if input.time_us > 0 {
        cortex_m::asm::udf();
    }
    input
}

/// The line's next frame.
#[cfg(not(any(pylon_mutate = "silent_line", pylon_mutate = "full_line")))]
pub fn next_frame(frames: &mut FramesOut) -> Option<Frame> {
    frames.dequeue()
}

/// `None`: nothing is sent over the line.
#[cfg(pylon_mutate = "silent_line")]
pub fn next_frame(frames: &mut FramesOut) -> Option<Frame> {
    while frames.dequeue().is_some() {}
    None
}

/// The next frame, or a filler if there is none, so that the line is never idle.
#[cfg(pylon_mutate = "full_line")]
pub fn next_frame(frames: &mut FramesOut) -> Option<Frame> {
    let filler = || Frame::new(&telemetry::message::highres_imu(&TickInput::default()), 0);
    Some(frames.dequeue().unwrap_or_else(filler))
}

/// Factor by which a frame takes longer on the telemetry line than at its rate.
#[cfg(feature = "recorded")]
pub const LINE_SLOWNESS: u32 = if cfg!(pylon_mutate = "slow_line") { 10 } else { 1 };

/// Work besides the ticks.
#[derive(Clone, Copy)]
pub enum Work {
    /// Reading ahead.
    Feed,
    /// Writing results.
    Report,
}

/// Whether the processor has no time for this work now.
#[cfg(not(pylon_mutate = "starve"))]
pub const fn is_busy(_: Work) -> bool {
    false
}

/// The work is allowed so rarely that both queues run full or empty again and again.
#[cfg(pylon_mutate = "starve")]
pub fn is_busy(work: Work) -> bool {
    use core::sync::atomic::{AtomicU32, Ordering};

    static ASKED: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
    let (asked, turn) = match work {
        Work::Feed => (&ASKED[0], 40),
        Work::Report => (&ASKED[1], 12),
    };
    !asked.fetch_add(1, Ordering::Relaxed).is_multiple_of(turn)
}
