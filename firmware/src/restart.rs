//! Log messages about a start.

use survival::{Refusal, RestartReport, Start};

/// Logs why there is no mission for a while.
pub fn log_standby(report: &RestartReport) {
    defmt::error!(
        "standby of {=u64} us: it keeps crashing, the last time by {=str}",
        report.pause_us,
        report.cause.name()
    );
}

/// Logs the outcome of the start.
pub fn log(report: &RestartReport) {
    defmt::error!(
        "restart {=u32} ({=str}) after {=str}; the clock continues at {=u64} us",
        report.restarts,
        report.start.name(),
        report.cause.name(),
        report.resumed_us
    );
    if let Some(crash) = &report.crash {
        defmt::error!(
            "it was at {=u32:#010x}, called from {=u32:#010x}, in exception {=u16}; cfsr {=u32:#010x}, hfsr {=u32:#010x}, mmfar {=u32:#010x}, bfar {=u32:#010x}, late {=u8:#b}, {=str}:{=u32}",
            crash.pc,
            crash.lr,
            crash.exception,
            crash.cfsr,
            crash.hfsr,
            crash.mmfar,
            crash.bfar,
            crash.late,
            crash.file(),
            crash.line
        );
    }
    for (copy, refusal) in report.refused.iter().enumerate() {
        if let Some(refusal) = refusal.filter(|refusal| *refusal != Refusal::Empty) {
            defmt::error!("copy {=usize} of the snapshot is {=str}", copy, refusal.name());
        }
    }
    match report.start {
        Start::Lost => defmt::error!("the latched calibration is lost"),
        Start::Captive => defmt::warn!("the calibration starts again"),
        Start::Standby => defmt::error!("too many crashes: the mission does not continue"),
        Start::Cold => defmt::warn!("no kept state is used: a new flight"),
        Start::Suspected => defmt::warn!("a launch was suspected: the calibration is held"),
        Start::Resumed => {}
    }
}
