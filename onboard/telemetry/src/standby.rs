//! The message sent while the flight computer stands by.

use survival::RestartReport;

use crate::event::Event;
use crate::frame::Frame;

/// The text of a flight computer that stands by after that restart, as the frame with that sequence number.
/// It is to be sent repeatedly until the mission continues: nothing else tells a ground station why the other
/// messages stopped.
#[must_use]
pub fn standby(report: &RestartReport, sequence: u8) -> Frame {
    let RestartReport { cause, pause_us, resumed_us, .. } = *report;
    let at_us = resumed_us.saturating_sub(pause_us);
    Frame::new(&Event::Standby { cause, pause_us }.message(at_us), sequence)
}
