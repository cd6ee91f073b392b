//! How often the diagnosis is right.

use pylon::diagnose::Verdict;

use super::draw::{Kind, Plan};
use super::trial::Trial;

/// Number of hits among the trials that it applies to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Number of hits.
    pub hits: usize,
    /// Number of those trials.
    pub of: usize,
}

impl Share {
    pub(crate) fn count(&mut self, hit: bool) {
        self.hits += usize::from(hit);
        self.of += 1;
    }

    /// As a share; one if there is no trial.
    #[must_use]
    pub fn value(&self) -> f64 {
        if self.of == 0 { 1.0 } else { self.hits as f64 / self.of as f64 }
    }

    /// A line of the score: its name, padded to this many characters, its percentage, and the target. Without
    /// trials there is no percentage.
    pub(crate) fn line(&self, what: &str, width: usize, wanted: &str) -> String {
        let rate = if self.of == 0 { "-".to_owned() } else { format!("{:.1} %", 100.0 * self.value()) };
        format!("{what:<width$} {rate:>8}  ({} of {})  {wanted}\n", self.hits, self.of)
    }
}

/// The rates that the project promises.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Strongest effect identified or in a set, among flights in which it moves the residual by more than
    /// twice its noise.
    pub strongest_held: Share,
    /// Of those, identified outright.
    pub strongest_identified: Share,
    /// The same two, without the flights that did not record a signal that the strongest effect needs: there,
    /// to call it unknown is right.
    pub testable_held: Share,
    /// See [`Self::testable_held`].
    pub testable_identified: Share,
    /// The same two, of those on rich flights.
    pub rich_held: Share,
    /// See [`Self::rich_held`].
    pub rich_identified: Share,
    /// Sets with "or nothing" that contain an effect that acts.
    pub perhaps: Share,
    /// The number that should, by the probabilities of their effects.
    pub perhaps_expected: f64,
    /// A wrong effect reported as identified, among all trials.
    pub wrong: Share,
    /// A set without any effect that acts, among all trials.
    pub set_without: Share,
    /// The same, but where no effect acts a set that says "or nothing" is right.
    pub set_without_truth: Share,
    /// Null flights and flights with a glitch that are reported as quiet.
    pub null_quiet: Share,
    /// Causes outside the catalogue, more than twice the noise, reported as unknown.
    pub outside_unknown: Share,
    /// Causes outside the catalogue taken for one inside.
    pub outside_wrong: Share,
    /// Coefficients within 1.96 sigma of the truth.
    pub covered: Share,
    /// Receivers that filter their altitude, where any identified effect is the receiver's.
    pub smoothed_on_gps: Share,
}

impl Score {
    /// Counts these trials.
    #[must_use]
    pub fn of(trials: &[Trial]) -> Self {
        let mut score = Self::default();
        for trial in trials {
            score.wrong.count(trial.is_wrong());
            score.set_without.count(trial.sets().iter().any(|set| !trial.has_cause(set)));
            score.set_without_truth.count(trial.sets().iter().any(|set| !trial.has_truth(set)));
            let verdict = trial.diagnosis.verdict;
            match &trial.case.kind {
                Kind::Null | Kind::Glitch(_) => score.null_quiet.count(verdict < Verdict::Identified),
                Kind::Effects(_) => {
                    if let Some((id, _)) = trial.truth.first().filter(|(_, size)| *size > 2.0)
                        && trial.case.plan != Plan::Level
                    {
                        score.strongest_held.count(trial.holds(id));
                        score.strongest_identified.count(trial.identified().contains(id));
                        if trial.could_test(id) {
                            score.testable_held.count(trial.holds(id));
                            score.testable_identified.count(trial.identified().contains(id));
                            if trial.case.plan == Plan::Rich {
                                score.rich_held.count(trial.holds(id));
                                score.rich_identified.count(trial.identified().contains(id));
                            }
                        }
                    }
                }
                Kind::Outside(_, size) => {
                    score.outside_wrong.count(trial.is_wrong());
                    if *size > 2.0 && trial.case.plan != Plan::Level {
                        score.outside_unknown.count(trial.has_verdict(Verdict::UnknownEffect));
                    }
                }
                Kind::SmoothedGps(_) => {
                    score.smoothed_on_gps.count(!trial.is_wrong());
                }
            }
            for (probability, acts) in trial.perhaps() {
                score.perhaps.count(acts);
                score.perhaps_expected += probability;
            }
            for deviation in &trial.deviations {
                score.covered.count(deviation.is_covered());
            }
        }
        score
    }
}

/// The score as a table.
#[must_use]
pub fn table(trials: &[Trial]) -> String {
    let score = Score::of(trials);
    let mut text = String::new();
    for (what, share, promise) in [
        ("strongest effect (over twice the noise) identified or in a set", score.strongest_held, ">= 95 %"),
        ("  of those identified outright", score.strongest_identified, ""),
        ("the same where its signals were recorded: identified or in a set", score.testable_held, ">= 96 %"),
        ("  of those identified outright", score.testable_identified, ""),
        ("of those, on rich flights: identified or in a set", score.rich_held, ""),
        ("  of those identified outright", score.rich_identified, ""),
        ("a wrong effect identified, of all trials", score.wrong, "<= 1 %"),
        ("a set without any effect that acts, of all trials", score.set_without, "<= 1 %"),
        ("  counting \"or nothing\" as right where nothing acts", score.set_without_truth, ""),
        ("null flights and glitches called quiet", score.null_quiet, ">= 97 %"),
        ("outside the catalogue (over twice the noise) called unknown", score.outside_unknown, ">= 80 %"),
        ("outside the catalogue, a wrong effect identified", score.outside_wrong, "<= 5 %"),
        ("coefficients within 1.96 sigma", score.covered, "92 to 98 %"),
        ("filtered receivers without a wrong effect", score.smoothed_on_gps, ""),
    ] {
        text += &share.line(what, 68, promise);
    }
    let expected = format!("{:.1} by their probabilities", score.perhaps_expected);
    text += &score.perhaps.line("sets with \"or nothing\" that contain an effect that acts", 68, &expected);
    text
}
