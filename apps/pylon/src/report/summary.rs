//! A flight's summary, for a reader who does not know Pylon.

use crate::compare::text::number::{metres, seconds, signed_m};
use crate::compare::words::Words;
use crate::compare::{Comparison, SensorComparison, Stretch};

/// A sensor's final trust, with an explanation.
pub(super) struct Outcome {
    /// Pylon's word for this `trust`.
    pub(super) word: &'static str,
    /// A sign that distinguishes the outcomes without colour.
    pub(super) sign: &'static str,
    /// Its meaning.
    pub(super) meaning: &'static str,
}

/// The outcome for a sensor's trust at the flight's end.
pub(super) fn outcome(trust: &str) -> Outcome {
    let (word, sign, meaning) = match trust {
        "trusted" => ("trusted", "✓", "its error never exceeded the alarm limit"),
        "doubtful" => ("doubtful", "?", "its error exceeded the alarm limit, its average did not"),
        "untrustworthy" => ("untrustworthy", "✗", "its error and then its average exceeded the alarm limit"),
        "unmonitored" => ("unmonitored", "–", "there was no reference to compare it with at the end"),
        _ => ("calibrating", "…", "it was never launched"),
    };
    Outcome { word, sign, meaning }
}

/// The result of the calibration.
pub(super) fn calibration(comparison: &Comparison) -> String {
    let facts = &comparison.calibration;
    let length = seconds(facts.duration_s);
    let Words { beforehand, .. } = comparison.words();
    match facts.quality.as_deref() {
        None => format!("Nothing was calibrated: {}.", facts.source),
        Some("good") => format!(
            "{beforehand} the sensors were compared with gps for {length}; every check of that calibration passed."
        ),
        Some(_) => format!(
            "{beforehand} the sensors were compared with gps for {length}, but that calibration is poor: {} of its \
             checks failed. Read what follows with care.",
            facts.failed_checks.len()
        ),
    }
}

/// A sensor's behaviour, in sentences.
pub(super) fn sensor(name: &str, found: &SensorComparison, comparison: &Comparison) -> Vec<String> {
    let mut said = Vec::new();
    let words = comparison.words();
    let Words { after, event, meanwhile, .. } = words;
    if let Some(bias_m) = found.bias_m {
        let side = if bias_m < 0.0 { "low" } else { "high" };
        let sure =
            found.bias_sigma_m.map_or_else(String::new, |sigma| format!(" (± {})", metres(Some(sigma))));
        said.push(format!("{meanwhile} {name} read {} too {side}{sure}.", metres(Some(bias_m.abs()))));
    }
    if comparison.launch_s.is_none() {
        return said;
    }
    let Some(rms_m) = found.free_flight_rms_m else {
        said.push(format!("No reading in {after} had a reference to be compared with."));
        return said;
    };
    let bound = found
        .bound_m
        .map_or_else(String::new, |bound| format!("; the monitor's alarm limit is {}", metres(Some(bound))));
    said.push(format!("With that subtracted, its error in {after} was {} rms{bound}.", metres(Some(rms_m))));
    said.push(match (found.doubtful_after_s, found.untrustworthy_after_s) {
        (Some(doubtful), Some(untrustworthy)) => format!(
            "It became doubtful {} after {event} and untrustworthy {} later.",
            seconds(Some(doubtful)),
            seconds(Some(untrustworthy - doubtful))
        ),
        (Some(doubtful), None) => {
            format!("It became doubtful {} after {event}, and never untrustworthy.", seconds(Some(doubtful)))
        }
        _ => "It was never doubtful.".to_owned(),
    });
    if let Some(worst) = comparison.failures.worst.iter().find(|stretch| stretch.sensor == name) {
        said.push(worst_stretch(worst, words));
    }
    said
}

fn worst_stretch(stretch: &Stretch, Words { event, .. }: Words) -> String {
    format!(
        "It was worst {}, {:.0} to {:.0} s after {event}: {} on average.",
        stretch.doing.phrase(),
        stretch.from_s,
        stretch.to_s,
        signed_m(Some(stretch.mean_m))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flown() -> (SensorComparison, Comparison) {
        let sensor = SensorComparison {
            flies_free: true,
            bias_m: Some(-121.5),
            bias_sigma_m: Some(1.25),
            free_flight_rms_m: Some(70.0),
            bound_m: Some(40.0),
            doubtful_after_s: Some(7.0),
            untrustworthy_after_s: Some(9.5),
            ..SensorComparison::default()
        };
        (sensor, Comparison { launch_s: Some(80.0), ..Comparison::default() })
    }

    #[test]
    fn a_sensor_is_told_in_sentences() {
        let (found, mut comparison) = flown();
        comparison.flight.usage.has_launch = true;
        assert_eq!(
            sensor("baro", &found, &comparison),
            [
                "Under the pylon baro read 121.5 m too low (± 1.25 m).",
                "With that subtracted, its error in free flight was 70.00 m rms; the monitor's alarm limit is 40.00 m.",
                "It became doubtful 7.00 s after launch and untrustworthy 2.50 s later.",
            ]
        );
    }

    #[test]
    fn who_was_never_launched_is_not_told_about_launches() {
        let (found, comparison) = flown();
        let told = sensor("baro", &found, &comparison).join(" ");
        assert!(told.starts_with("While it was calibrated baro read 121.5 m too low"), "{told}");
        assert!(
            !told.contains("launch") && !told.contains("pylon") && !told.contains("free flight"),
            "{told}"
        );
    }

    #[test]
    fn without_a_launch_only_the_bias_is_told() {
        let (found, comparison) = flown();
        let comparison = Comparison { launch_s: None, ..comparison };
        assert_eq!(sensor("baro", &found, &comparison).len(), 1);
    }

    #[test]
    fn every_trust_has_its_own_sign() {
        let signs: std::collections::BTreeSet<&str> =
            ["calibrating", "trusted", "doubtful", "untrustworthy", "unmonitored"]
                .map(|trust| outcome(trust).sign)
                .into();
        assert_eq!(signs.len(), 5);
    }
}
