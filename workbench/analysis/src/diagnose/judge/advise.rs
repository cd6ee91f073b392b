//! What to fly or record next.

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;

use super::{Findings, Judge, Set, is_lift};
use crate::diagnose::advice;
use crate::diagnose::diagnosis::{SensorDiagnosis, Verdict};
use crate::diagnose::manoeuvres::Trim;

impl Judge<'_> {
    pub(super) fn advise(
        &self,
        findings: &Findings,
        subject: Option<Sensor>,
        diagnosis: &SensorDiagnosis,
    ) -> String {
        let noise = &findings.explanation.fit.noise;
        let trim = self.trim();
        match diagnosis.verdict {
            Verdict::NoSignificantMisfit => String::new(),
            Verdict::Identified => {
                let first = diagnosis.missing.first().map_or("", |first| &**first);
                let caveat = self.untestable(findings, diagnosis);
                format!("Add {first} to the model (pylon add {first}) and check it on another flight.{caveat}")
            }
            Verdict::Indistinguishable => self.advise_separation(findings, subject, &trim),
            Verdict::InsufficientExcitation => {
                let unseen = self.excitation(findings, subject).unseen;
                let names: Vec<&str> =
                    unseen.iter().take(4).map(|column| self.candidates[*column].effect().name()).collect();
                let found = advice::to_see(self.problem, noise, self.candidates, &unseen, &trim);
                found.map_or_else(String::new, |advice| {
                    format!(
                        "This flight could not show effects such as {}. Fly {}.",
                        names.join(", "),
                        advice.manoeuvre
                    )
                })
            }
            Verdict::UnknownEffect if self.beyond(findings, subject).is_some() => {
                self.beyond(findings, subject).unwrap_or_default()
            }
            Verdict::UnknownEffect => match diagnosis.follows.first() {
                Some(first) => format!(
                    "Nothing in the catalogue explains this sensor. Its residual follows {} (lag {:.0} s): look for a cause there.",
                    first.signal, first.lag_s
                ),
                None => "Nothing in the catalogue explains this sensor, and its residual follows no recorded signal: look at the installation, and record more signals.".to_owned(),
            },
        }
    }

    /// The condition of an identified effect: that no effect acts which the flight's columns cannot
    /// distinguish from it.
    fn untestable(&self, findings: &Findings, diagnosis: &SensorDiagnosis) -> String {
        let is_slow = |effect: &EffectId| matches!(effect, EffectId::BaroDrift | EffectId::BaroWarmUp);
        let slow = diagnosis.missing.iter().filter_map(|id| EffectId::from_name(id)).find(is_slow);
        let has_temperature = self.candidates.iter().enumerate().any(|(column, candidate)| {
            candidate.effect() == EffectId::BaroTemperature && self.suspects.position(column).is_some()
        });
        match slow.filter(|_| findings.posterior.is_some() && !has_temperature) {
            Some(slow) => format!(
                " No column has the barometer's temperature (baro_temp_c): a temperature that moves like {} would look the same.",
                slow.name()
            ),
            None => String::new(),
        }
    }

    /// The coefficient that the nearest effect of the catalogue would need, where it is outside the physical
    /// range.
    fn beyond(&self, findings: &Findings, subject: Option<Sensor>) -> Option<String> {
        findings.posterior.as_ref()?;
        let columns = &findings.explanation.columns;
        let solution = findings.information.solve(&self.suspects.positions(columns))?;
        let k = (0..columns.len())
            .find(|k| self.candidates[columns[*k]].sensor() == subject && self.is_beyond(findings, *k))?;
        let effect = self.candidates[columns[k]].effect();
        let [least, most] = effect.plausible();
        let unit = if effect.unit() == "1" { String::new() } else { format!(" {}", effect.unit()) };
        Some(format!(
            "The best fit is {} of {:+.3}{unit}, but its plausible range is {least} to {most}{unit}: look for another cause, such as a \
             wrong clock, setting or unit.",
            effect.name(),
            solution.coefficients[k],
        ))
    }

    fn advise_separation(&self, findings: &Findings, subject: Option<Sensor>, trim: &Trim) -> String {
        let explanation = &findings.explanation;
        for rivals in findings.rivals.iter().chain(&findings.weak) {
            let set = self.set(rivals);
            if set.is_identified || !set.concerns(subject) {
                continue;
            }
            let Set { effects, nothing, .. } = set;
            let set: Vec<EffectId> = effects.into_iter().map(|(effect, _)| effect).collect();
            if let [effect] = set.as_slice() {
                return self.advise_decision(findings, rivals.column, *effect, trim);
            }
            let is_listed = |column: &usize| set.contains(&self.candidates[*column].effect());
            let columns: Vec<usize> = std::iter::once(rivals.column)
                .chain(rivals.others.iter().copied())
                .filter(is_listed)
                .collect();
            let hidden: Vec<&str> = set
                .iter()
                .filter(|effect| !columns.iter().any(|column| self.candidates[*column].effect() == **effect))
                .flat_map(|effect| effect.needs().iter().copied())
                .collect();
            let record = if hidden.is_empty() {
                String::new()
            } else {
                format!(" Record {} as well.", hidden.join(" and "))
            };
            let chosen = &explanation.columns;
            let sizes: Option<Vec<f64>> = columns
                .iter()
                .map(|column| {
                    let others = chosen.iter().copied().filter(|other| *other != rivals.column);
                    let picks: Vec<usize> = others.chain([*column]).collect();
                    findings.information.solve(&self.suspects.positions(&picks))?.coefficients.last().copied()
                })
                .collect();
            let shared = rivals.others.first().and_then(|other| {
                let others = chosen.iter().copied().filter(|c| *c != rivals.column).collect::<Vec<_>>();
                findings.information.shared(
                    self.suspects.position(rivals.column)?,
                    self.suspects.position(*other)?,
                    &self.suspects.positions(&others),
                )
            });
            let why = shared.map_or_else(String::new, |shared| {
                format!(" Their regressors are correlated by {:.3} on these flights.", shared.sqrt())
            });
            let is_lift = hidden.is_empty() && is_lift(&set);
            let found = sizes.filter(|_| columns.len() > 1 && !is_lift).and_then(|sizes| {
                advice::to_separate(
                    self.problem,
                    &explanation.fit.noise,
                    self.candidates,
                    &columns,
                    &sizes,
                    trim,
                )
            });
            let names: Vec<&str> = set.iter().map(|effect| effect.name()).collect();
            let unseparated = if is_lift {
                " No manoeuvre separates them: lift couples one to the other, and a vane responds later than an accelerometer."
            } else {
                ""
            };
            let fly = found.map_or_else(
                || unseparated.to_owned(),
                |advice| {
                    if advice.sigmas >= 3.0 {
                        format!(
                            " To separate them fly {} (they would differ by {:.0} sigma).",
                            advice.manoeuvre, advice.sigmas
                        )
                    } else if advice.sigmas >= 0.5 {
                        format!(
                            " No single manoeuvre separates them well; the best is {} ({:.1} sigma).",
                            advice.manoeuvre, advice.sigmas
                        )
                    } else {
                        " No manoeuvre separates them.".to_owned()
                    }
                },
            );
            // An error that only one sensor shows may be its own or the reference's.
            let is_of_reference = |effect: &&EffectId| effect.subject().name() == "gps";
            let sensors = Sensor::ALL.iter().filter(|s| self.epochs.iter().any(|e| e.series.has(s.index())));
            let other = if sensors.count() == 1 && set.iter().any(|effect| is_of_reference(&effect)) {
                " Record another altitude sensor: an error that both show is the reference's."
            } else {
                ""
            };
            let or_nothing = if nothing.is_some() { ", or nothing does" } else { "" };
            return format!("One of {} acts{or_nothing}.{why}{fly}{other}{record}", names.join(", "));
        }
        String::new()
    }

    /// What would show whether the only effect in a place acts.
    fn advise_decision(&self, findings: &Findings, column: usize, effect: EffectId, trim: &Trim) -> String {
        let solution = findings.information.solve(&self.beside(findings, column));
        let size = solution.and_then(|solution| solution.coefficients.last().copied());
        let noise = &findings.explanation.fit.noise;
        let found =
            size.and_then(|size| advice::to_show(self.problem, noise, self.candidates, column, size, trim));
        let fly = match found {
            Some(advice) if advice.sigmas >= 3.0 => format!(
                "To find out fly {} (an effect of this size would show by {:.0} sigma).",
                advice.manoeuvre, advice.sigmas
            ),
            _ => "No short manoeuvre would show it: diagnose this flight together with others.".to_owned(),
        };
        format!("Either {} acts, or nothing does. {fly}", effect.name())
    }

    /// The trim from which a manoeuvre begins.
    pub(crate) fn trim(&self) -> Trim {
        let mean = |signal: usize| {
            let values = self.epochs.iter().flat_map(|e| e.signals.iter()).map(|block| block[signal]);
            let known: Vec<f64> = values.filter(|value| value.is_finite()).collect();
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
        };
        Trim {
            speed_mps: mean(0).or(mean(18)).filter(|speed| *speed > 5.0).unwrap_or(40.0),
            altitude_m: mean(2).unwrap_or(1000.0),
            angle_of_attack_rad: mean(8).filter(|angle| angle.abs() > 0.005).unwrap_or(0.05),
        }
    }
}
