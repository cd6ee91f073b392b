//! What is told while the flight computer stands by.

use survival::RestartReport;

use crate::event::Event;
use crate::frame::Frame;

/// The text of a flight computer that stands by after that restart, as the frame of that sequence number. To
/// be sent again and again until it goes on: there is nothing else that tells a ground station why the rest
/// is silent.
#[must_use]
pub fn standby(report: &RestartReport, sequence: u8) -> Frame {
    let RestartReport { cause, pause_us, resumed_us, .. } = *report;
    let at_us = resumed_us.saturating_sub(pause_us);
    Frame::new(&Event::Standby { cause, pause_us }.message(at_us), sequence)
}
