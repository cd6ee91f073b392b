//! Converts a recording to a flight and the notes on it.

use kf_core::output::TickOutput;
use kf_core::quality::{Check, FailedChecks};
use kf_core::sensor::Sensor;
use survival::{RestartReport, Start};

use super::frames::Losses;
use super::recording::{AsFlown, Begins, CHANNELS, Left, Recording, Started};
use crate::import::ImportError;
use flight_data::{Channel, Flight, Header, Note};

/// Ticks are missing between two that are farther apart than this many of the usual intervals.
const GAP_INTERVALS: f64 = 1.5;

/// Why a record contains no flight.
pub fn without_ticks(begins: &Begins, losses: &Losses) -> ImportError {
    let report = begins.reports.last();
    let said = match (report, &begins.header) {
        (Some(report), _) => Some(format!("the flight computer reported: {}", restart_words(report))),
        (None, None) if losses.undecodable > 0 => {
            Some("no header gives its version, which may differ".to_owned())
        }
        (None, _) => None,
    };
    let Losses { frames, damaged, undecodable, .. } = *losses;
    ImportError::NoTick { frames, damaged, undecodable, said }
}

/// The flight and its notes, beginning with what was lost.
pub fn convert(
    recording: Recording,
    left: Left,
    losses: &Losses,
) -> Result<(Flight, Vec<Note>), ImportError> {
    let ticks = recording.time_us.len();
    let mut notes = Notes::default();
    notes.losses(losses, &left, &recording);
    notes.starts(&recording);
    let (header, time_s) = (header(&recording, losses), recording.time_us.iter().map(|us| *us as f64 / 1e6));
    let mut flight = Flight { header, time_s: time_s.collect(), ..Flight::default() };
    notes.as_flown(&recording);
    flight.set_channel(Channel::Launch, recording.launch);
    if recording.has_doubt {
        flight.set_channel(Channel::LaunchDoubt, recording.doubt);
    }
    for (channel, column) in CHANNELS.into_iter().zip(recording.columns) {
        if column.samples().next().is_some() {
            flight.set_channel(channel, column);
        }
    }
    if flight.channel(Channel::GpsAltM).is_none() {
        return Err(ImportError::NoFixInRecord { ticks });
    }
    Ok((flight, notes.0))
}

fn seconds(time_us: u64) -> f64 {
    time_us as f64 / 1e6
}

/// The header: the source, what was lost, and the calibration as flown.
fn header(recording: &Recording, losses: &Losses) -> Header {
    let source = match (recording.is_inputs(), recording.is_on_chips()) {
        (true, _) => "imported flight record (inputs for a flight computer)",
        (false, true) => "imported flight record (results of a flight computer, sensors' chips and drivers)",
        (false, false) => "imported flight record (results of a flight computer, ideal sensors)",
    };
    let mut other = vec![("log_format".to_owned(), "flight record".to_owned())];
    let mut key = |key: &str, value: String| other.push((key.to_owned(), value));
    if let Some(header) = &recording.header {
        key("flown_model_fingerprint", format!("{:016x}", header.model));
    }
    for (name, count) in [
        ("record_damaged_stretches", losses.damaged as u64),
        ("record_missing_frames", losses.missing),
        ("record_undecodable_frames", losses.undecodable as u64),
        ("record_restarts", restarts(recording) as u64),
    ] {
        if count > 0 {
            key(name, count.to_string());
        }
    }
    as_flown(&recording.as_flown, &mut key);
    Header {
        vehicle: "Pylon flight computer".to_owned(),
        source: source.to_owned(),
        other,
        ..Header::default()
    }
}

fn restarts(recording: &Recording) -> usize {
    recording.starts.iter().filter(|started| started.row > 0).count()
}

/// The flight computer's own results, as keys of the header.
fn as_flown(as_flown: &AsFlown, key: &mut impl FnMut(&str, String)) {
    let launch_s = as_flown.launch.as_ref().map(|tick| seconds(tick.time_us));
    if let Some(launch_s) = launch_s {
        key("flown_launch_decided_s", launch_s.to_string());
    }
    let failed_checks = match (&as_flown.latch, &as_flown.launch) {
        (Some(latch), _) => Some(latch.failed_checks),
        (None, Some(tick)) => Some(tick.failed_checks),
        (None, None) => None,
    };
    if let Some(latch) = &as_flown.latch {
        key("flown_latched_s", seconds(latch.time_us).to_string());
        key("flown_calibration_duration_s", latch.duration_s.to_string());
    }
    if let Some(bits) = failed_checks {
        let failed = FailedChecks::from_bits(bits);
        key("flown_quality", if failed.is_empty() { "good" } else { "degraded" }.to_owned());
        let names: Vec<&str> = failed.iter().map(Check::name).collect();
        if !names.is_empty() {
            key("flown_failed_checks", names.join(", "));
        }
    }
    for sensor in Sensor::ALL {
        let (name, index) = (sensor.name(), sensor.index());
        if let Some(latch) = &as_flown.latch {
            let latched = &latch.sensors[index];
            if latched.readings > 0 {
                key(&format!("flown_{name}_bias_m"), latched.bias_m.to_string());
                key(&format!("flown_{name}_bias_sigma_m"), latched.bias_variance_m2.sqrt().to_string());
                key(&format!("flown_{name}_residual_sigma_m"), latched.residual_sigma_m().to_string());
                key(&format!("flown_{name}_bound_m"), latched.bound_m().to_string());
            }
        } else if let Some(TickOutput { sensors, .. }) = &as_flown.launch {
            key(&format!("flown_{name}_bias_m"), sensors[index].bias_m.to_string());
            key(&format!("flown_{name}_bias_sigma_m"), sensors[index].bias_variance_m2.sqrt().to_string());
        }
        for (flag, time_us) in
            [("doubtful", as_flown.doubtful_us[index]), ("untrustworthy", as_flown.untrustworthy_us[index])]
        {
            if let Some(time_us) = time_us {
                key(&format!("flown_{name}_{flag}_s"), seconds(time_us).to_string());
            }
        }
    }
}

fn restart_words(report: &RestartReport) -> String {
    let after = report.cause.name();
    match report.start {
        Start::Cold => format!("cold start, after {after}"),
        start => format!("restart {} ({}) after {after}", report.restarts, start.name()),
    }
}

#[derive(Default)]
struct Notes(Vec<Note>);

impl Notes {
    fn note(&mut self, text: impl Into<String>) {
        self.0.push(Note::new(text));
    }

    fn count(&mut self, count: u64, what: &str) {
        if count > 0 {
            self.note(format!("{what}: {count}"));
        }
    }

    fn losses(&mut self, losses: &Losses, left: &Left, recording: &Recording) {
        if losses.damaged > 0 {
            let Losses { damaged, damaged_bytes, .. } = losses;
            self.note(format!("stretches that are not frames (torn, flipped, or of something else), left out: {damaged}, of {damaged_bytes} bytes"));
        }
        self.count(losses.missing, "frames missing between those received");
        self.count(losses.undecodable as u64, "frames that do not decode, left out");
        self.count(losses.unknown as u64, "frames of a kind that this version does not know, left out");
        self.count(losses.repeated as u64, "frames that came twice, left out once");
        if losses.begins_in_the_middle {
            let version = flight_record::FORMAT_VERSION;
            self.note(format!(
                "recorded from the middle of a stream: no header gives its version, {version} is assumed"
            ));
        }
        if losses.is_cut {
            self.note("the last frame is cut off");
        }
        self.count(left.impossible_times as u64, "ticks at a time beyond 9e9 s, left out");
        if left.flights > 0 {
            let Left { flights, ticks, .. } = left;
            self.note(format!(
                "other flights in the record (the flight computer restarted, and its clock too): {flights}, of {ticks} ticks; \
                 the longest is used"
            ));
        }
        self.count(
            recording.fix_times_left_out as u64,
            "fixes whose time is 12 days from the first one's, kept without it",
        );
        self.gaps(recording);
        let promised = recording.promised_inputs.map(u64::from);
        if let Some(promised) = promised.filter(|promised| *promised != recording.time_us.len() as u64) {
            self.note(format!("the record declares {promised} inputs, but has {}", recording.time_us.len()));
        }
        if recording.is_inputs() && recording.promised_inputs.is_none() {
            self.note("the record of inputs has no end: it was cut");
        }
        if let Some(summary) = &recording.summary {
            self.count(summary.lost_results.into(), "results that the flight computer lost for lack of room");
            self.count(summary.sensor_faults.into(), "polls of sensors that failed in flight");
        }
    }

    /// Notes ticks that are missing by their times, except those of a restart.
    fn gaps(&mut self, recording: &Recording) {
        let times = &recording.time_us;
        let interval = |row: usize| Some(times.get(row)?.saturating_sub(*times.get(row.checked_sub(1)?)?));
        let mut intervals: Vec<u64> = (1..times.len()).filter_map(interval).collect();
        let middle = intervals.len() / 2;
        if !recording.is_on_chips() || intervals.is_empty() {
            return;
        }
        let usual_us = (*intervals.select_nth_unstable(middle).1).max(1) as f64;
        let is_restart = |row: usize| recording.starts.iter().any(|started| started.row == row);
        let gaps: Vec<(usize, u64)> = (1..times.len())
            .filter(|row| !is_restart(*row))
            .filter_map(|row| Some((row, interval(row)?)))
            .filter(|(_, gap_us)| *gap_us as f64 > GAP_INTERVALS * usual_us)
            .collect();
        if let Some((row, longest_us)) = gaps.iter().max_by_key(|(_, gap_us)| *gap_us) {
            let missing: f64 = gaps.iter().map(|(_, gap_us)| (*gap_us as f64 / usual_us).round() - 1.0).sum();
            let before_us = times.get(row - 1).copied().unwrap_or(0);
            self.note(format!(
                "ticks that are missing by their times (usually every {:.1} ms): {missing}, in {} gaps, the longest {:.3} s after \
                 {:.3} s",
                usual_us / 1e3,
                gaps.len(),
                *longest_us as f64 / 1e6,
                seconds(before_us),
            ));
        }
    }

    fn starts(&mut self, recording: &Recording) {
        for Started { row, report } in &recording.starts {
            let (row, report) = (*row, report.as_ref());
            let words = report.map_or_else(|| "a restart whose report was lost".to_owned(), restart_words);
            let before_us = row.checked_sub(1).and_then(|row| recording.time_us.get(row));
            match (before_us, recording.time_us.get(row)) {
                (Some(before_us), Some(after_us)) => {
                    let gap_s = seconds(after_us.saturating_sub(*before_us));
                    self.note(format!(
                        "{words}: {gap_s:.3} s without ticks after {:.3} s; {}",
                        seconds(*before_us),
                        afterwards(report, seconds(*after_us))
                    ));
                }
                (None, _) => self.note(format!("at its start the flight computer reported: {words}")),
                (Some(before_us), None) => {
                    self.note(format!("{words} after {:.3} s: no tick followed", seconds(*before_us)));
                }
            }
        }
    }

    fn as_flown(&mut self, recording: &Recording) {
        if recording.chip_faults > 0 {
            self.note(format!(
                "faults of chips that these inputs were to be flown with, which are not in the readings: {}",
                recording.chip_faults
            ));
        }
        let as_flown = &recording.as_flown;
        if as_flown.latch.is_some() || as_flown.launch.is_some() {
            self.note("the calibration and the flags as flown are in the header (flown_*); what else was estimated is left out");
        }
        if as_flown.latch.is_none() && as_flown.launch.is_some() {
            self.note(
                "the frame of the latched calibration is missing: the biases are those of the launch's tick",
            );
        }
    }
}

/// Effect of a restart on a comparison, which does not know about restarts.
fn afterwards(report: Option<&RestartReport>, after_s: f64) -> String {
    match report.map(|report| report.start) {
        Some(Start::Captive) => format!(
            "the flight computer calibrated again from {after_s:.3} s on, `compare` calibrates on all of the captive flight"
        ),
        Some(Start::Lost) => {
            "the flight computer's calibration was lost, `compare` has the one from before".to_owned()
        }
        _ => {
            "the flight computer continued, and so does the flight: `compare` treats this as a gap".to_owned()
        }
    }
}
