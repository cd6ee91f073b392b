//! Chip faults, as a user plans them.

use std::fmt;
use std::str::FromStr;

use chip_models::flown::{Chip, ChipFault, Fault};

use super::fault_names::{FAULTS, parse_fault, possible};
use kf_core::input::TickInput;
use thiserror::Error;

/// A fault of one chip, over an interval of the flight or once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedFault {
    /// The chip and its fault.
    pub fault: ChipFault,
    /// When it begins, seconds of the flight's time.
    pub start_s: f64,
    /// When it ends; `None` for one that occurs once.
    pub end_s: Option<f64>,
}

/// A plan that is not valid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FaultError {
    /// It does not have three words.
    #[error("fault '{0}', expected \"CHIP FAULT START..END\", such as \"baro stuck-low 60..65\"")]
    Form(String),
    /// There is no such chip.
    #[error("fault of '{0}', expected a chip: baro, imu, gps, umbilical or wire{near}", near = nearest(_0, CHIPS.iter().map(|(name, _)| *name)))]
    Chip(String),
    /// There is no such fault.
    #[error("fault '{0}', expected one of {FAULTS}{near}", near = nearest(_0, fault_names()))]
    Fault(String),
    /// The chip cannot have it.
    #[error("{chip} cannot be {fault}: {chip} can be {can}")]
    Impossible {
        /// The chip.
        chip: &'static str,
        /// The fault.
        fault: String,
        /// The faults that it can have.
        can: String,
    },
    /// The time is not valid, or not of the kind that the fault needs.
    #[error("time '{text}' of fault {fault}, expected {expected}")]
    Time {
        /// What was given.
        text: String,
        /// For which fault.
        fault: String,
        /// What it should be.
        expected: &'static str,
    },
    /// Two faults of one chip at a time.
    #[error("two faults of {0} at the same time: give them separate times")]
    Overlap(&'static str),
    /// No tick of the flight is within it.
    #[error("fault at {at_s} s, and the flight goes from {first_s:.3} s to {last_s:.3} s")]
    Outside {
        /// When the fault begins.
        at_s: String,
        /// The flight's first tick.
        first_s: f64,
        /// Its last.
        last_s: f64,
    },
}

const CHIPS: [(&str, Chip); 5] = [
    ("baro", Chip::Baro),
    ("imu", Chip::Imu),
    ("gps", Chip::Gps),
    ("umbilical", Chip::Umbilical),
    ("wire", Chip::Wire),
];

/// Every fault's name with its parameters, out of [`FAULTS`].
fn fault_names() -> impl Iterator<Item = &'static str> {
    let words = FAULTS.split_whitespace().map(|name| name.trim_end_matches([',', ';']));
    words.filter(|name| !name.starts_with('('))
}

/// The name that `text` may be a typing error of, as the end of a message: within a third of its letters, at
/// least one. What follows an equals sign is not part of the name.
fn nearest<'a>(text: &str, names: impl Iterator<Item = &'a str>) -> String {
    let stem = |name: &str| name.split('=').next().unwrap_or_default().to_ascii_lowercase();
    let wanted = stem(text);
    let distances = names.map(|name| (strsim::osa_distance(&wanted, &stem(name)), name));
    let most = (wanted.chars().count() / 3).max(1);
    let best = distances.min_by_key(|(distance, _)| *distance).filter(|(distance, _)| *distance <= most);
    best.map_or_else(String::new, |(_, name)| format!(" (is it '{name}'?)"))
}

fn chip_name(chip: Chip) -> &'static str {
    CHIPS.into_iter().find(|(_, other)| *other == chip).map_or("chip", |(name, _)| name)
}

impl FromStr for PlannedFault {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let [chip, name, time] = words[..] else { return Err(FaultError::Form(text.to_owned())) };
        let chip = CHIPS.into_iter().find(|(other, _)| *other == chip);
        let Some((chip_name, chip)) = chip else { return Err(FaultError::Chip(words[0].to_owned())) };
        let fault = parse_fault(chip, name).ok_or_else(|| FaultError::Fault(name.to_owned()))?;
        if !chip.can(fault) {
            let can = possible(chip);
            return Err(FaultError::Impossible { chip: chip_name, fault: name.to_owned(), can });
        }
        let expected = if fault.is_once() {
            "START in seconds, such as 60: it happens once"
        } else {
            "START..END in seconds, such as 60..65"
        };
        let wrong = || FaultError::Time { text: time.to_owned(), fault: name.to_owned(), expected };
        let seconds = |text: &str| {
            text.trim().parse::<f64>().ok().filter(|time| (0.0..1e12).contains(time)).ok_or_else(wrong)
        };
        let (start_s, end_s) = match (time.split_once(".."), fault.is_once()) {
            (Some((start, end)), false) => (seconds(start)?, Some(seconds(end)?)),
            (None, true) => (seconds(time)?, None),
            _ => return Err(wrong()),
        };
        if end_s.is_some_and(|end_s| end_s <= start_s) {
            return Err(wrong());
        }
        Ok(Self { fault: ChipFault { chip, fault }, start_s, end_s })
    }
}

impl fmt::Display for PlannedFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {:?} from {} s", chip_name(self.fault.chip), self.fault.fault, self.start_s)?;
        self.end_s.map_or(Ok(()), |end_s| write!(formatter, " to {end_s} s"))
    }
}

/// The faults that begin and end at each time, microseconds, in time order.
pub(super) fn schedule(planned: &[PlannedFault]) -> Result<Vec<(u64, ChipFault)>, FaultError> {
    for (index, one) in planned.iter().enumerate() {
        let (start, end) = (one.start_s, one.end_s.unwrap_or(one.start_s));
        for other in planned.iter().skip(index + 1).filter(|other| other.fault.chip == one.fault.chip) {
            if other.start_s <= end && start <= other.end_s.unwrap_or(other.start_s) {
                return Err(FaultError::Overlap(chip_name(one.fault.chip)));
            }
        }
    }
    let microseconds = |time_s: f64| (time_s * 1e6).round() as u64;
    let mut events = Vec::new();
    for PlannedFault { fault, start_s, end_s } in planned {
        events.push((microseconds(*start_s), *fault));
        if let Some(end_s) = end_s {
            events.push((microseconds(*end_s), ChipFault { fault: Fault::None, ..*fault }));
        }
    }
    events.sort_by_key(|(time_us, _)| *time_us);
    Ok(events)
}

/// Checks that every fault begins within the flight.
pub(super) fn check(
    events: &[(u64, ChipFault)],
    mut ticks: impl Iterator<Item = TickInput>,
) -> Result<(), FaultError> {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let Some(first_us) = ticks.next().map(|tick| tick.time_us) else { return Ok(()) };
    let last_us = ticks.last().map_or(first_us, |tick| tick.time_us);
    match events.iter().find(|(at, event)| event.fault != Fault::None && !(first_us..=last_us).contains(at)) {
        None => Ok(()),
        Some((at, _)) => Err(FaultError::Outside {
            at_s: seconds(*at).to_string(),
            first_s: seconds(first_us),
            last_s: seconds(last_us),
        }),
    }
}

/// The items of a flight record, in its order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Item {
    /// A tick.
    Tick(TickInput),
    /// A chip's fault, from the next tick.
    Fault(ChipFault),
}

/// Ticks with faults between them: a fault comes before the first tick that is not earlier than its time.
#[derive(Clone, Debug)]
pub(super) struct Scripted<'a, Ticks: Iterator<Item = TickInput>> {
    ticks: Ticks,
    events: &'a [(u64, ChipFault)],
    held_back: Option<TickInput>,
}

impl<'a, Ticks: Iterator<Item = TickInput>> Scripted<'a, Ticks> {
    pub(super) const fn new(ticks: Ticks, events: &'a [(u64, ChipFault)]) -> Self {
        Self { ticks, events, held_back: None }
    }
}

impl<Ticks: Iterator<Item = TickInput>> Iterator for Scripted<'_, Ticks> {
    type Item = Item;

    fn next(&mut self) -> Option<Item> {
        let tick = self.held_back.take().or_else(|| self.ticks.next())?;
        if let [(time_us, fault), rest @ ..] = self.events
            && *time_us <= tick.time_us
        {
            self.events = rest;
            self.held_back = Some(tick);
            return Some(Item::Fault(*fault));
        }
        Some(Item::Tick(tick))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<PlannedFault, FaultError> {
        text.parse()
    }

    #[test]
    fn reads_what_the_help_says() {
        let planned = parse("baro stuck-low 60..65").unwrap();
        assert_eq!(planned.fault, ChipFault { chip: Chip::Baro, fault: Fault::StuckLow });
        assert_eq!((planned.start_s, planned.end_s), (60.0, Some(65.0)));
        let once = parse("gps lose-bytes=30 12.5").unwrap();
        assert_eq!(once.fault.fault, Fault::LoseBytes { count: 30 });
        assert_eq!((once.start_s, once.end_s), (12.5, None));
        let stranger = parse("umbilical stranger=9000 1..2").unwrap().fault.fault;
        assert_eq!(stranger, Fault::Stranger { system: 42, component: 1, altitude_m: 9_000 });
        let torn = parse("umbilical torn 60..90").unwrap().fault;
        assert_eq!(torn, ChipFault { chip: Chip::Umbilical, fault: Fault::Torn });
        let bounces = parse("wire bounces=20000 1..2").unwrap().fault.fault;
        assert_eq!(bounces, Fault::Bounces { open_us: 20_000, closed_us: 20_000, seed: 20_000 });
        let flipped = parse("imu flip-bits=0x80 1").unwrap().fault.fault;
        assert_eq!(flipped, Fault::FlipBits { after_bytes: 0, mask: 0x80 });
    }

    #[test]
    fn what_is_wrong_is_said_with_what_was_expected() {
        for (text, said) in [
            ("baro", "expected \"CHIP FAULT START..END\""),
            ("radar stuck-low 1..2", "fault of 'radar', expected a chip"),
            ("baro broken 1..2", "fault 'broken', expected one of stuck-low"),
            (
                "gps stuck-low 1..2",
                "gps cannot be stuck-low: gps can be frozen, offset, unplugged, refuses, silent, held",
            ),
            ("barro reset 1", "(is it 'baro'?)"),
            ("IMU reset 1", "(is it 'imu'?)"),
            ("umbillical unplugged 1..2", "(is it 'umbilical'?)"),
            ("baro stuklow 1..2", "(is it 'stuck-low'?)"),
            ("imu stuck-hihg 1..2", "(is it 'stuck-high'?)"),
            ("imu flipbits=3 1", "(is it 'flip-bits=MASK[,AFTER]'?)"),
            ("gps lost-bytes=3 1", "(is it 'lose-bytes=COUNT'?)"),
            ("gps unpluged 1..2", "(is it 'unplugged'?)"),
            ("baro slow 1..2", "(is it 'slow=MICROSECONDS'?)"),
            ("baro flip-bits=256 1", "fault 'flip-bits=256'"),
            ("baro flip-bits=0 1", "fault 'flip-bits=0'"),
            ("baro stuck-low 5", "expected START..END"),
            ("baro stuck-low 5..5", "expected START..END"),
            ("baro reset 5..6", "it happens once"),
            ("baro reset -1", "it happens once"),
            ("baro reset nan", "it happens once"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
        // A text that is close to no name gets no suggestion.
        for text in ["radar stuck-low 1..2", "baro melted 1..2"] {
            let error = parse(text).unwrap_err().to_string();
            assert!(!error.contains("is it"), "{error}");
        }
    }

    #[test]
    fn faults_of_one_chip_may_not_overlap() {
        let plan = |texts: &[&str]| {
            schedule(&texts.iter().map(|text| parse(text).unwrap()).collect::<Vec<_>>())
                .map(|events| events.len())
        };
        assert_eq!(plan(&["baro stuck-low 1..5", "imu reset 3", "baro reset 6"]), Ok(4));
        assert_eq!(plan(&["baro stuck-low 1..5", "baro reset 3"]), Err(FaultError::Overlap("baro")));
    }

    #[test]
    fn a_fault_begins_with_the_first_tick_that_is_not_before_it() {
        let events = schedule(&[parse("baro stuck-low 0.007..0.010").unwrap()]).unwrap();
        let ticks = (0..4).map(|k| TickInput { time_us: k * 5_000, ..TickInput::default() });
        let order: Vec<String> = Scripted::new(ticks, &events)
            .map(|item| match item {
                Item::Tick(tick) => tick.time_us.to_string(),
                Item::Fault(event) => format!("{:?}", event.fault),
            })
            .collect();
        assert_eq!(order, ["0", "5000", "StuckLow", "None", "10000", "15000"]);
    }
}
