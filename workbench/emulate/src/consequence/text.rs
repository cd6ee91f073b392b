//! The consequence as text.

use std::fmt::{self, Write as _};

use super::{AltitudeDifference, BiasChange, CleanAndFaulty, Consequence, Name};

/// Width of the name column on the left.
const NAME: usize = 19;
/// A silence longer than this gets a line, seconds: more than a tick.
const SILENCE_S: f64 = 0.0075;

impl fmt::Display for Consequence {
    /// Lines indented by four spaces or more, the first by two.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            formatter,
            "  the fault            compared with the same flight without it, flown on the host:"
        )?;
        if self.ticks_that_differ == 0 {
            return writeln!(
                formatter,
                "    nothing            every tick is the same; {}",
                polls(&self.polls_failed)
            );
        }
        let mut lines = String::new();
        self.calibration(&mut lines)?;
        self.launch(&mut lines)?;
        self.flags(&mut lines)?;
        self.altitude(&mut lines)?;
        self.delivery(&mut lines)?;
        formatter.write_str(&lines)
    }
}

fn line(lines: &mut String, name: &str, text: &str) -> fmt::Result {
    writeln!(lines, "{}", format!("    {name:<NAME$}{text}").trim_end())
}

/// The value with the fault; the clean value too if it differs.
fn instead(with_fault: &str, clean: &str) -> String {
    if with_fault == clean {
        format!("{with_fault}, as without the fault")
    } else {
        format!("{with_fault}; {clean} without the fault")
    }
}

fn polls(polls: &CleanAndFaulty<u32>) -> String {
    format!("{} polls failed, {} without the fault", polls.with_fault, polls.clean)
}

/// Millimetre precision; two significant digits for a value that would round to zero.
fn metres(value_m: f64) -> String {
    if value_m != 0.0 && value_m.abs() < 0.000_5 {
        format!("{value_m:.1e} m")
    } else {
        format!("{value_m:.3} m")
    }
}

fn at(time_s: Option<f64>) -> String {
    time_s.map_or_else(|| "never".to_owned(), |time_s| format!("at {time_s:.3} s"))
}

fn after(time_s: Option<f64>) -> String {
    time_s.map_or_else(|| "never".to_owned(), |time_s| format!("{time_s:.3} s after launch"))
}

impl Consequence {
    fn calibration(&self, lines: &mut String) -> fmt::Result {
        let calibration = &self.calibration;
        let quality = |quality: &Option<Name>, failed: &[Name]| match quality {
            None => "nothing was latched".to_owned(),
            Some(quality) if failed.is_empty() => quality.to_string(),
            Some(quality) => format!("{quality} ({} failed)", failed.join(", ")),
        };
        let with_fault = quality(&calibration.quality.with_fault, &calibration.failed_checks.with_fault);
        let clean = quality(&calibration.quality.clean, &calibration.failed_checks.clean);
        line(lines, "calibration", &instead(&with_fault, &clean))?;
        for (sensor, bias) in &calibration.sensors {
            line(lines, &format!("  {sensor}"), &bias_words(bias))?;
        }
        Ok(())
    }

    fn launch(&self, lines: &mut String) -> fmt::Result {
        let latched = &self.calibration.latched_s;
        line(lines, "latched", &instead(&at(latched.with_fault), &at(latched.clean)))?;
        let decided = &self.launch_decided_s;
        line(lines, "launch decided", &instead(&at(decided.with_fault), &at(decided.clean)))
    }

    fn flags(&self, lines: &mut String) -> fmt::Result {
        line(lines, "flags", "")?;
        for (sensor, flags) in &self.flags {
            for (flag, times) in
                [("doubtful", &flags.doubtful_after_s), ("untrustworthy", &flags.untrustworthy_after_s)]
            {
                let mut text = format!("{flag} {}", instead(&after(times.with_fault), &after(times.clean)));
                if let (Some(with_fault), Some(clean)) = (times.with_fault, times.clean)
                    && with_fault != clean
                {
                    let later_s = with_fault - clean;
                    let word = if later_s > 0.0 { "later" } else { "earlier" };
                    write!(text, " ({:.3} s {word})", later_s.abs())?;
                }
                line(lines, &format!("  {sensor}"), &text)?;
            }
            let unmonitored = &flags.unmonitored_s;
            if unmonitored.with_fault != unmonitored.clean {
                let text = format!(
                    "not monitored for {:.3} s of free flight, {:.3} s without the fault",
                    unmonitored.with_fault, unmonitored.clean
                );
                line(lines, &format!("  {sensor}"), &text)?;
            }
        }
        Ok(())
    }

    fn altitude(&self, lines: &mut String) -> fmt::Result {
        let words = |difference: &AltitudeDifference| {
            if difference.peak_m == 0.0 {
                "the same to the bit".to_owned()
            } else {
                let AltitudeDifference { rms_m, peak_m, peak_s, .. } = difference;
                format!(
                    "{} rms from the clean run's, {} at most (at {peak_s:.3} s)",
                    metres(*rms_m),
                    metres(*peak_m)
                )
            }
        };
        line(lines, "altitude", "")?;
        if let Some(captive) = &self.captive_altitude {
            line(lines, "  captive flight", &format!("as estimated, {}", words(captive)))?;
        }
        for (sensor, free) in &self.free_flight_altitude {
            line(lines, &format!("  {sensor}"), &format!("as calibrated, in free flight, {}", words(free)))?;
        }
        Ok(())
    }

    fn delivery(&self, lines: &mut String) -> fmt::Result {
        let silent: Vec<String> = self
            .not_delivering_s
            .iter()
            .filter(|(_, silent_s)| **silent_s > SILENCE_S)
            .map(|(source, silent_s)| format!("{source} for {silent_s:.3} s"))
            .collect();
        let silent = if silent.is_empty() {
            "none, compared with the clean run".to_owned()
        } else {
            silent.join(", ")
        };
        line(lines, "not delivering", &silent)?;
        for (source, refused) in
            self.readings_refused.iter().filter(|(_, refused)| refused.clean != refused.with_fault)
        {
            let text = format!("{} of {source}, {} without the fault", refused.with_fault, refused.clean);
            line(lines, "readings refused", &text)?;
        }
        line(lines, "polls", &polls(&self.polls_failed))
    }
}

fn bias_words(bias: &BiasChange) -> String {
    let moved = if bias.difference_m == 0.0 {
        "not moved".to_owned()
    } else {
        let sign = if bias.difference_m > 0.0 { '+' } else { '-' };
        format!(
            "moved by {sign}{}, {:.2} of its own sigma ({})",
            metres(bias.difference_m.abs()),
            bias.difference_in_sigmas.abs(),
            metres(bias.bias_sigma_m.with_fault)
        )
    };
    let bound = |bound_m: f64| if bound_m > 0.0 { metres(bound_m) } else { "none".to_owned() };
    format!(
        "bias {}, {moved}; alarm limit {}",
        metres(bias.bias_m.with_fault),
        instead(&bound(bias.bound_m.with_fault), &bound(bias.bound_m.clean))
    )
}

#[cfg(test)]
mod tests {
    use super::super::{CalibrationChange, FlagsChange};
    use super::*;

    fn same<T: Clone>(value: T) -> CleanAndFaulty<T> {
        CleanAndFaulty { clean: value.clone(), with_fault: value }
    }

    fn consequence() -> Consequence {
        let bias = BiasChange {
            bias_m: CleanAndFaulty { clean: 13.5, with_fault: 13.75 },
            difference_m: 0.25,
            difference_in_sigmas: 0.5,
            bias_sigma_m: same(0.5),
            bound_m: CleanAndFaulty { clean: 4.0, with_fault: 4.125 },
            readings: same(6_000),
        };
        let still = BiasChange {
            bias_m: same(-7.5),
            difference_m: 0.0,
            difference_in_sigmas: 0.0,
            bound_m: same(6.0),
            ..bias
        };
        let flags = FlagsChange {
            doubtful_after_s: same(Some(4.25)),
            untrustworthy_after_s: CleanAndFaulty { clean: Some(6.0), with_fault: Some(7.5) },
            unmonitored_s: CleanAndFaulty { clean: 0.0, with_fault: 2.0 },
        };
        let lost = FlagsChange {
            doubtful_after_s: CleanAndFaulty { clean: Some(9.0), with_fault: None },
            ..FlagsChange::default()
        };
        let moved = AltitudeDifference { rms_m: 0.125, peak_m: 1.5, peak_s: 70.25, ticks: 100 };
        Consequence {
            calibration: CalibrationChange {
                latched_s: same(Some(120.0)),
                quality: CleanAndFaulty { clean: Some("good".into()), with_fault: Some("degraded".into()) },
                failed_checks: CleanAndFaulty {
                    clean: vec![],
                    with_fault: vec!["sensors_alive".into(), "biases_stationary".into()],
                },
                sensors: [("baro".into(), bias), ("imu_slave".into(), still)].into(),
            },
            launch_decided_s: CleanAndFaulty { clean: Some(120.25), with_fault: Some(120.5) },
            flags: [("baro".into(), flags), ("imu_slave".into(), lost)].into(),
            captive_altitude: Some(AltitudeDifference { rms_m: 0.000_02, ..moved }),
            free_flight_altitude: [
                ("baro".into(), moved),
                ("imu_slave".into(), AltitudeDifference::default()),
            ]
            .into(),
            not_delivering_s: [("baro".into(), 5.0), ("imu".into(), 0.0)].into(),
            readings_refused: [
                ("baro".into(), CleanAndFaulty { clean: 0, with_fault: 3 }),
                ("gps".into(), same(1)),
            ]
            .into(),
            polls_failed: CleanAndFaulty { clean: 0, with_fault: 84 },
            ticks_that_differ: 9_000,
        }
    }

    #[test]
    fn says_what_changed_and_what_did_not() {
        let expected = "  the fault            compared with the same flight without it, flown on the host:
    calibration        degraded (sensors_alive, biases_stationary failed); good without the fault
      baro             bias 13.750 m, moved by +0.250 m, 0.50 of its own sigma (0.500 m); alarm limit 4.125 m; 4.000 m without the fault
      imu_slave        bias -7.500 m, not moved; alarm limit 6.000 m, as without the fault
    latched            at 120.000 s, as without the fault
    launch decided     at 120.500 s; at 120.250 s without the fault
    flags
      baro             doubtful 4.250 s after launch, as without the fault
      baro             untrustworthy 7.500 s after launch; 6.000 s after launch without the fault (1.500 s later)
      baro             not monitored for 2.000 s of free flight, 0.000 s without the fault
      imu_slave        doubtful never; 9.000 s after launch without the fault
      imu_slave        untrustworthy never, as without the fault
    altitude
      captive flight   as estimated, 2.0e-5 m rms from the clean run's, 1.500 m at most (at 70.250 s)
      baro             as calibrated, in free flight, 0.125 m rms from the clean run's, 1.500 m at most (at 70.250 s)
      imu_slave        as calibrated, in free flight, the same to the bit
    not delivering     baro for 5.000 s
    readings refused   3 of baro, 0 without the fault
    polls              84 polls failed, 0 without the fault
";
        assert_eq!(consequence().to_string(), expected);
    }

    #[test]
    fn a_fault_without_consequence_is_two_lines() {
        let nothing = Consequence { ticks_that_differ: 0, polls_failed: same(0), ..consequence() };
        assert_eq!(
            nothing.to_string(),
            "  the fault            compared with the same flight without it, flown on the host:
    nothing            every tick is the same; 0 polls failed, 0 without the fault
"
        );
    }

    #[test]
    fn keys_say_their_units() {
        let json = serde_json::to_value(consequence()).unwrap();
        assert_eq!(json["calibration"]["sensors"]["baro"]["difference_m"], 0.25);
        assert_eq!(json["flags"]["baro"]["untrustworthy_after_s"]["with_fault"], 7.5);
        assert_eq!(json["not_delivering_s"]["baro"], 5.0);
        assert_eq!(json["free_flight_altitude"]["baro"]["rms_m"], 0.125);
        assert_eq!(json["calibration"]["quality"]["clean"], "good");
        assert_eq!(serde_json::from_value::<Consequence>(json).unwrap(), consequence());
    }
}
