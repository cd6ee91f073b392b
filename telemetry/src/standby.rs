//! What is told without a mission.

use survival::RestartReport;

use crate::event::Event;
use crate::frame::Frame;

/// The text of a flight computer that stands by after that restart, as the frame of that sequence number. To be sent again and
/// again: there is nothing else that tells a ground station why the rest is silent.
#[must_use]
pub fn standby(report: &RestartReport, sequence: u8) -> Frame {
    Frame::new(&Event::Standby(report.cause).message(report.resumed_us), sequence)
}
