//! What comes of flying the plan that is advised for a set of effects: the same aircraft flies it in other
//! air, and both flights are diagnosed together.

use std::fmt::Write as _;

use model::Model;
use pylon::diagnose::{Diagnosis, NamedReplay, diagnose};
use pylon::flight::Flight;
use pylon::plan::{self, suggest};
use pylon::replay::Replay;

use super::draw::Case;
use super::flight::fly_as;
use super::score::Share;

/// What became of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The effect that acts is identified and no other of the set, or, where none of the set acts, none is
    /// reported any more.
    Resolved,
    /// Some of the set, with the effect that acts, are still a set.
    Open,
    /// What acts is no longer reported.
    Lost,
    /// An effect of the set is identified that does not act.
    Wrong,
}

/// A set, and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct AdvisedSet {
    /// Its effects.
    pub effects: Vec<String>,
    /// Whether one of them acts.
    pub has_cause: bool,
    /// Whether the flights record the signals of all of them: otherwise no flight resolves it.
    pub is_recorded: bool,
    /// The probability with which the plan was to resolve it.
    pub promised: f64,
    /// What became of it; `None` where the aircraft could not fly the plan.
    pub outcome: Option<Outcome>,
}

/// The plan that was advised for a trial's sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Advised {
    /// Length of its free flight, seconds.
    pub free_s: f64,
    /// The sets.
    pub sets: Vec<AdvisedSet>,
    /// What the diagnosis of both flights says, in short.
    pub said: String,
}

/// Plans the next flight from a trial's, flies it and diagnoses both; `None` where the diagnosis has no set
/// that a plan could resolve, or no plan can be flown. `truth` are the ids of the effects that act.
///
/// # Errors
/// If no mission can be made of a flight.
pub fn advised(case: &Case, flight: &Flight, truth: &[&str]) -> anyhow::Result<Option<Advised>> {
    let model = Model::default();
    let named = |name: &str, flight| -> anyhow::Result<NamedReplay<'_>> {
        Ok(NamedReplay::new(name.to_owned(), Replay::new(flight, &model, None)?))
    };
    let (_, further) = plan::diagnose(&[named("first", flight)?], &[], &mut || ());
    let Some(further) = further else { return Ok(None) };
    let Some((found, _)) = suggest(&further.planner, &[flight], &model, &mut || ()) else { return Ok(None) };
    let outlook = &found.flown.outlook;
    if outlook.sets.is_empty() {
        return Ok(None);
    }
    // Number 2: number 1 is the flight that `improvement.rs` evaluates on.
    let both = match fly_as(case, 2, Some(&found.flown.scenario)) {
        Ok(next) => Some(diagnose(&[named("first", flight)?, named("next", &next.flight)?], &[], &mut || ())),
        Err(_) => None,
    };
    let sets = outlook.sets.iter().map(|set| {
        let effects: Vec<String> = set.members.iter().map(|member| member.effect.to_string()).collect();
        AdvisedSet {
            has_cause: effects.iter().any(|effect| truth.contains(&effect.as_str())),
            is_recorded: set.members.iter().all(|member| member.identified.is_some()),
            promised: set.resolved,
            outcome: both.as_ref().map(|both| outcome(both, &effects, truth)),
            effects,
        }
    });
    let free_s = found.flown.scenario.free_flight.iter().map(|segment| segment.duration_s).sum();
    let said = both.as_ref().map_or_else(String::new, |both| {
        let missing: Vec<&str> = both.missing().collect();
        let sets = both.sensors.values().flat_map(|sensor| &sensor.indistinguishable);
        let sets: Vec<String> = sets.map(|set| format!("{{{}}}", set.join(" "))).collect();
        format!("{} {}", missing.join(" "), sets.join(" "))
    });
    let sets = sets.collect();
    Ok(Some(Advised { free_s, sets, said }))
}

fn outcome(both: &Diagnosis, effects: &[String], truth: &[&str]) -> Outcome {
    let is_of_set = |effect: &&str| effects.iter().any(|own| own == effect);
    let acts = |effect: &&str| truth.contains(effect);
    let identified: Vec<&str> = both.missing().filter(is_of_set).collect();
    let suspects: Vec<&str> = both.suspects().filter(is_of_set).collect();
    let has_cause = effects.iter().any(|effect| truth.contains(&effect.as_str()));
    if identified.iter().any(|effect| !acts(effect)) {
        Outcome::Wrong
    } else if suspects.is_empty() && has_cause != identified.is_empty() {
        Outcome::Resolved
    } else if suspects.iter().chain(&identified).any(acts) || !has_cause {
        Outcome::Open
    } else {
        Outcome::Lost
    }
}

/// The outcomes of many trials, as lines of a table.
#[must_use]
pub fn lines(advised: &[Advised]) -> String {
    let sets = || advised.iter().flat_map(|advised| &advised.sets);
    let mut text = String::new();
    let mut share = |what: &str, of: &dyn Fn(&AdvisedSet) -> bool, wanted: &str| {
        let mut share = Share::default();
        for set in sets().filter(|set| of(set)) {
            if let Some(outcome) = set.outcome {
                share.count(outcome == Outcome::Resolved);
            }
        }
        text += &share.line(what, 68, wanted);
    };
    share("sets that hold the cause: resolved by flying the advised plan once", &|set| set.has_cause, "");
    share(
        "  those of which every effect's signals were recorded",
        &|set| set.has_cause && set.is_recorded,
        "",
    );
    share(
        "  those that the plan was to resolve with 90 %",
        &|set| set.has_cause && set.promised >= plan::RESOLVED,
        ">= 85 %",
    );
    share(
        "  those that it was to resolve with 50 to 90 %",
        &|set| set.has_cause && (0.5..plan::RESOLVED).contains(&set.promised),
        "",
    );
    share("  those that it was to resolve with less", &|set| set.has_cause && set.promised < 0.5, "");
    share("sets without the cause: no longer reported", &|set| !set.has_cause, "");
    let count = |outcome| sets().filter(|set| set.outcome == Some(outcome)).count();
    let mut seconds: Vec<f64> = advised.iter().map(|advised| advised.free_s).collect();
    seconds.sort_by(f64::total_cmp);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  still a set {}, a wrong effect {}, no longer reported {}, plans that the aircraft can't fly {}; median of {:.0} s",
        count(Outcome::Open),
        count(Outcome::Wrong),
        count(Outcome::Lost),
        sets().filter(|set| set.outcome.is_none()).count(),
        seconds.get(seconds.len() / 2).copied().unwrap_or(0.0),
    );
    text
}
