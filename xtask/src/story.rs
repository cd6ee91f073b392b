//! Prints the demo's results on one screen.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use comfy_table::Cell;
use serde::Deserialize;

use crate::table::{plain, right};
use crate::workspace;

/// The paper's results for a sensor.
struct Published {
    name: &'static str,
    bias_m: f64,
    sigma_m: f64,
    /// Both counted from launch; the paper gives the second from the first.
    doubtful_s: f64,
    untrustworthy_s: f64,
    moving_average_m: f64,
}

/// Table 1 and section 4.
const PUBLISHED: [Published; 2] = [
    Published {
        name: "imu_slave",
        bias_m: -72.8909,
        sigma_m: 32.4422,
        doubtful_s: 7.6,
        untrustworthy_s: 7.6 + 1.5,
        moving_average_m: -100.0,
    },
    Published {
        name: "baro",
        bias_m: -121.8691,
        sigma_m: 40.3308,
        doubtful_s: 7.0,
        untrustworthy_s: 7.0 + 2.5,
        moving_average_m: -100.0,
    },
];

/// The part of `pylon fly --json` that is used.
#[derive(Debug, Deserialize)]
pub struct Flown {
    /// Ticks flown, each identical to the host's bits.
    pub ticks: u32,
    /// Mean instructions of a tick.
    pub instructions_mean: f64,
    /// Instructions of the most expensive tick.
    pub instructions_worst: u32,
}

/// The part of `pylon compare --json` that is used.
#[derive(Debug, Deserialize)]
pub struct Comparison {
    flight: Facts,
    launch_s: Option<f64>,
    sensors: BTreeMap<String, Sensor>,
    calibration: Calibration,
}

#[derive(Debug, Deserialize)]
struct Facts {
    duration_s: f64,
}

#[derive(Debug, Deserialize)]
struct Sensor {
    bias_m: Option<f64>,
    bias_sigma_m: Option<f64>,
    residual_sigma_m: Option<f64>,
    moving_average_end_m: Option<f64>,
    doubtful_after_s: Option<f64>,
    untrustworthy_after_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Calibration {
    quality: Option<String>,
    failed_checks: Vec<String>,
}

/// The demo's flight.
#[derive(Debug)]
pub struct Story {
    /// Its run in the emulator.
    pub flown: Flown,
    /// Its comparison with the model.
    pub comparison: Comparison,
    /// Its file.
    pub flight: PathBuf,
    /// Pictures of the comparison.
    pub pictures: Vec<PathBuf>,
}

/// A number, or a dash where there is none.
fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

impl Story {
    /// The paper's numbers next to ours.
    fn table(&self) -> String {
        let ours = |published: &Published| self.comparison.sensors.get(published.name);
        type Ours = fn(&Sensor) -> Option<f64>;
        type Theirs = fn(&Published) -> f64;
        let rows: [(&str, Theirs, Ours, usize); 6] = [
            ("bias latched, m", |paper| paper.bias_m, |sensor| sensor.bias_m, 2),
            ("  its standard error, m", |_| f64::NAN, |sensor| sensor.bias_sigma_m, 2),
            ("sigma of the residual, m", |paper| paper.sigma_m, |sensor| sensor.residual_sigma_m, 2),
            ("doubtful, s after launch", |paper| paper.doubtful_s, |sensor| sensor.doubtful_after_s, 1),
            (
                "untrustworthy, s after launch",
                |paper| paper.untrustworthy_s,
                |sensor| sensor.untrustworthy_after_s,
                1,
            ),
            (
                "moving average at the end, m",
                |paper| paper.moving_average_m,
                |sensor| sensor.moving_average_end_m,
                0,
            ),
        ];
        let header = PUBLISHED.iter().flat_map(|paper| [format!("{}: paper", paper.name), "ours".to_owned()]);
        let mut table = plain([String::new()].into_iter().chain(header).map(right));
        for (what, theirs, ours_of, digits) in rows {
            let cells = PUBLISHED.iter().flat_map(|paper| {
                let theirs = Some(theirs(paper)).filter(|value| value.is_finite());
                [number(theirs, digits), number(ours(paper).and_then(ours_of), digits)]
            });
            table.add_row([Cell::new(what)].into_iter().chain(cells.map(right)));
        }
        table.trim_fmt()
    }

    /// How good the calibration is.
    fn quality(&self) -> String {
        let Calibration { quality, failed_checks } = &self.comparison.calibration;
        let quality = quality.as_deref().unwrap_or("not latched");
        if failed_checks.is_empty() {
            format!("{quality}: every check passed")
        } else {
            format!("{quality}: {} failed", failed_checks.join(", "))
        }
    }
}

impl fmt::Display for Story {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { flown, comparison, flight, pictures } = self;
        let launch_s = comparison.launch_s.unwrap_or(f64::NAN);
        let free_s = comparison.flight.duration_s - launch_s;
        writeln!(
            formatter,
            "
The paper's flight: a reconstruction from its published figures; the telemetry was never published.

  calibrated  {launch_s:.0} s under the mother ship's pylon, the first 10 s ignored
  latched     at launch; calibration {}
  flagged     in {free_s:.0} s of free flight, as the table says
  emulated    {} ticks through the flight computer's image in QEMU, each bit for bit the host's;
              {:.0} instructions a tick, {} at worst
",
            self.quality(),
            flown.ticks,
            flown.instructions_mean,
            flown.instructions_worst,
        )?;
        writeln!(formatter, "{}\n", self.table())?;
        writeln!(formatter, "Pictures, drawn after the paper's Figures 2 to 4:")?;
        for picture in pictures {
            writeln!(formatter, "  {}", workspace::shown(picture))?;
        }
        writeln!(
            formatter,
            "\nWhere and why the model fails: cargo pylon compare {} --model paper",
            workspace::shown(flight)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn story(doubtful: &str) -> String {
        let sensor = format!(
            r#"{{"bias_m": -72.8, "bias_sigma_m": 0.6, "residual_sigma_m": 32.5, "captive_rms_m": 32.5,
                "free_flight_rms_m": 60.0, "moving_average_end_m": -98.0, "doubtful_after_s": {doubtful},
                "untrustworthy_after_s": null, "trust": "untrustworthy"}}"#
        );
        let comparison = format!(
            r#"{{"flight": {{"duration_s": 105.0}}, "launch_s": 80.0, "sensors": {{"imu_slave": {sensor}, "baro": {sensor}}},
                "calibration": {{"quality": "degraded", "failed_checks": ["trimmed_altitude", "reference_drift"]}}}}"#
        );
        Story {
            flown: Flown { ticks: 21_000, instructions_mean: 1923.6, instructions_worst: 14_064 },
            comparison: serde_json::from_str(&comparison).unwrap(),
            flight: workspace::root().join("target/demo/flight.csv"),
            pictures: vec![workspace::root().join("target/demo/pictures/figure-2.svg")],
        }
        .to_string()
    }

    #[test]
    fn says_what_was_calibrated_latched_and_flagged_and_what_it_is() {
        let story = story("7.6");
        for words in [
            "a reconstruction",
            "80 s under",
            "degraded: trimmed_altitude, reference_drift failed",
            "25 s of free flight",
            "21000 ticks",
            "1924 instructions a tick, 14064 at worst",
            "target/demo/pictures/figure-2.svg",
        ] {
            assert!(story.contains(words), "{words} is not in:\n{story}");
        }
        let row = |name: &str| {
            let line = story.lines().find(|line| line.starts_with(name)).unwrap();
            line[name.len()..].split_whitespace().map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(row("bias latched, m"), ["-72.89", "-72.80", "-121.87", "-72.80"]);
        assert_eq!(row("untrustworthy, s after launch"), ["9.1", "-", "9.5", "-"]);
    }

    #[test]
    fn is_one_screen() {
        let story = story("null");
        assert!(story.lines().count() <= 24, "{}", story.lines().count());
        assert!(story.lines().all(|line| line.chars().count() <= 100), "{story}");
    }
}
