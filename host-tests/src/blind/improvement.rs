//! How much adding the identified effects reduces the error of the next flight, compared with knowing the
//! truth.

use std::fmt::Write as _;

use anyhow::Context as _;
use kf_core::effect::{EffectId, EffectSubject};
use model::Model;
use pylon::diagnose::WantedEffect;
use pylon::flight::Flight;
use pylon::learn::{NamedFlight, Request, add, pooled_rms_m, score};
use pylon::replay::Replay;
use pylon::simulate::scenario::{Effect, InjectionPhase};
use time::{Date, Month};

/// Root mean square errors in free flight of the sensors concerned, on a flight that was not learned from,
/// metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Improvement {
    /// With the model without the effects.
    pub before_m: f64,
    /// With what `pylon add` learned from the first flight.
    pub after_m: f64,
    /// With every injected effect at its true coefficient.
    pub oracle_m: f64,
    /// Whether every injected effect was identified.
    pub is_complete: bool,
    /// Why `pylon add` refuses to add an identified effect unless forced, for each that it refuses; they were
    /// not added.
    pub refused: Vec<String>,
}

impl Improvement {
    /// Ratio of the learned model's error to the oracle's.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.after_m / self.oracle_m
    }
}

/// Learns the identified effects from one flight, one by one, and flies another flight with them.
///
/// # Errors
/// If no mission can be made of a flight or model.
pub fn improvement(
    learning: &Flight,
    next: &Flight,
    identified: &[&str],
    injected: &[Effect],
) -> anyhow::Result<Improvement> {
    let mut text = String::new();
    let mut refused = Vec::new();
    for name in identified {
        let effect = EffectId::from_name(name).with_context(|| format!("{name} is not in the catalogue"))?;
        let request = Request {
            text: &text,
            wanted: WantedEffect { effect, time_constant_s: None, since: None },
            estimate: false,
            date: Date::from_calendar_date(2026, Month::November, 21)?,
            learning: vec![NamedFlight::new("first", learning)],
            held_out: Vec::new(),
        };
        match add(&request, &mut || ()) {
            Ok(addition) if addition.concerns.is_empty() => text = addition.text,
            Ok(addition) => refused.push(format!("{name}: {}", addition.concerns.join("; "))),
            Err(error) => refused.push(format!("{name}: {error}")),
        }
    }
    let rms_m = |text: &str| -> anyhow::Result<f64> {
        let model = Model::parse(text)?;
        let scores = score(&Replay::new(next, &model, None)?)?;
        let subjects: Vec<EffectSubject> = injected
            .iter()
            .filter_map(|effect| Some(EffectId::from_name(effect.id.name())?.subject()))
            .collect();
        // An error of the reference is in every sensor; otherwise only the sensors with an effect count.
        let concerned = scores.into_iter().filter(|(sensor, _)| {
            subjects.iter().any(|subject| match subject {
                EffectSubject::Gps => true,
                EffectSubject::Sensor(own) => own.name() == *sensor,
            })
        });
        let concerned = concerned.collect();
        pooled_rms_m([&concerned], EffectSubject::Gps).context("no sensor has an error in free flight")
    };
    let is_complete = injected.iter().all(|effect| identified.contains(&effect.id.name()));
    Ok(Improvement {
        before_m: rms_m("")?,
        after_m: rms_m(&text)?,
        oracle_m: rms_m(&oracle(injected))?,
        is_complete,
        refused,
    })
}

/// The model with the true coefficients.
fn oracle(injected: &[Effect]) -> String {
    let mut text = String::new();
    for effect in injected {
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "[[effect]]\nid = \"{}\"\ncoefficient = {}", effect.id.name(), effect.coefficient);
        if let Some(time_constant_s) = effect.time_constant_s {
            let since = if effect.phase == InjectionPhase::Free { "launch" } else { "start" };
            let _ = writeln!(text, "time_constant_s = {time_constant_s}\nsince = \"{since}\"");
        }
    }
    text
}

/// The improvements of many trials, as lines of a table.
#[must_use]
pub fn lines(improvements: &[Improvement]) -> String {
    let mut text = String::new();
    let complete: Vec<Improvement> = improvements.iter().filter(|i| i.is_complete).cloned().collect();
    for (what, some) in
        [("an effect identified", improvements), ("every injected effect identified", complete.as_slice())]
    {
        let mut ratios: Vec<f64> = some.iter().map(Improvement::ratio).collect();
        if ratios.is_empty() {
            continue;
        }
        ratios.sort_by(f64::total_cmp);
        let within = ratios.iter().filter(|ratio| **ratio <= 1.15).count();
        let total = |of: &dyn Fn(&Improvement) -> f64| {
            (some.iter().map(|i| of(i).powi(2)).sum::<f64>() / some.len() as f64).sqrt()
        };
        let _ = writeln!(
            text,
            "{what}: {} trials; rms on the next flight {:.2} m, after `add` {:.2} m, oracle {:.2} m;\n  \
             `add` over oracle: median {:.3}, within 1.15 in {within} of {} (<= 1.15 is promised); `add` refused {}",
            some.len(),
            total(&|i| i.before_m),
            total(&|i| i.after_m),
            total(&|i| i.oracle_m),
            ratios[ratios.len() / 2],
            ratios.len(),
            some.iter().map(|i| i.refused.len()).sum::<usize>(),
        );
    }
    text
}
