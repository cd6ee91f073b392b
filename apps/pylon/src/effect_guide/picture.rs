//! A small picture of an effect: the error that it causes in a simulated flight.

use kf_core::effect::EffectId;
use view::{Chart, Moment, Role};

use crate::simulate::scenario::{self, Effect, InjectionPhase};
use crate::simulate::{Scenario, regressor, simulate};

/// The flight that effects are shown on.
const FLIGHT: &str = include_str!("../../../../flights/quickstart.toml");
/// Name of that flight.
const FLIGHT_NAME: &str = "flights/quickstart.toml";
/// Share of the largest plausible coefficient that is shown.
const SHARE: f64 = 0.1;
/// Time constant for effects that have one, seconds.
const TIME_CONSTANT_S: f64 = 40.0;
/// Limit on the points of a picture.
const POINTS: usize = 600;
/// Height of the charts as text, lines.
const DOWN: usize = 8;
const DOWN_ALTITUDE: usize = 4;

/// One effect on a simulated flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The effect.
    pub effect: EffectId,
    /// The coefficient shown, in the effect's own unit.
    pub coefficient: f64,
    /// When the aircraft was launched, seconds.
    pub launch_s: f64,
    /// Time of each point, seconds.
    pub time_s: Vec<f64>,
    /// The altitude, metres.
    pub altitude_m: Vec<f64>,
    /// The error that the effect adds, metres, less its mean before launch, which the calibration removes.
    pub error_m: Vec<f64>,
}

impl Picture {
    /// Flies the effect; `None` for one that the simulator lacks, which the tests rule out.
    #[must_use]
    pub fn of(effect: EffectId) -> Option<Self> {
        let id = scenario::EffectId::ALL.iter().copied().find(|id| id.name() == effect.name())?;
        let [least, most] = effect.plausible().map(f64::from);
        let coefficient = SHARE * if most.abs() >= least.abs() { most } else { least };
        let mut scenario = Scenario::from_toml(FLIGHT, FLIGHT_NAME).ok()?;
        let injected = Effect {
            id,
            coefficient,
            // An inertial altitude is aligned until launch.
            phase: if effect.name().starts_with("imu.") {
                InjectionPhase::Free
            } else {
                InjectionPhase::Both
            },
            time_constant_s: effect.has_time_constant().then_some(TIME_CONSTANT_S),
            width_m: None,
        };
        scenario.effect.clear();
        let (_, truth) = simulate(&scenario, scenario.seed).ok()?;
        let launch_s = truth.launch_s?;
        let added = regressor(&injected, &truth.trajectory, scenario.latitude_deg);
        let before = truth.trajectory.iter().take_while(|sample| sample.captive).count().max(1);
        let mean = added.iter().take(before).sum::<f64>() / before as f64;
        let stride = truth.trajectory.len().div_ceil(POINTS).max(1);
        let kept = || truth.trajectory.iter().step_by(stride);
        Some(Self {
            effect,
            coefficient,
            launch_s,
            time_s: kept().map(|sample| sample.time_s).collect(),
            altitude_m: kept().map(|sample| sample.altitude_m).collect(),
            error_m: added.iter().step_by(stride).map(|value| coefficient * (value - mean)).collect(),
        })
    }

    /// What is shown, in words.
    #[must_use]
    pub fn caption(&self) -> String {
        let unit = if self.effect.unit() == "1" { String::new() } else { format!(" {}", self.effect.unit()) };
        let tau = if self.effect.has_time_constant() {
            format!(" and a time constant of {TIME_CONSTANT_S} s")
        } else {
            String::new()
        };
        format!(
            "A simulated flight ({FLIGHT_NAME}), not a measured one, with a coefficient of {}{unit}{tau}; launch at {:.0} s. \
             The bias that was calibrated before launch is subtracted.",
            // The coefficient to three digits, written as short as possible.
            format!("{:.2e}", self.coefficient).parse::<f64>().unwrap_or(self.coefficient),
            self.launch_s
        )
    }

    /// The sensor whose altitude has the error.
    #[must_use]
    pub fn subject(&self) -> &'static str {
        self.effect.subject().name()
    }

    /// The altitude and, below it, the error, over the time of the flight.
    #[must_use]
    pub fn charts(&self) -> [Chart; 2] {
        let end_s = self.time_s.last().copied().unwrap_or(1.0).max(1.0);
        let chart = |values: &[f64], y_name: String, role| {
            let column = values.iter().copied().map(Some).collect();
            let mut chart = Chart::new(String::new(), String::new(), "time, s", y_name, self.time_s.clone())
                .line("", role, column);
            chart.moments.push(Moment { name: "launch".to_owned(), role: Role::Event, x: self.launch_s });
            chart.x_range = Some([0.0, end_s]);
            let range = view::svg::range(values.iter().copied());
            chart.y_range = Some([range.start, range.end]);
            chart
        };
        [
            chart(&self.altitude_m, "altitude, m".to_owned(), Role::Measured),
            chart(&self.error_m, format!("error of {}, m", self.subject()), Role::Effect),
        ]
    }

    /// The same charts as text.
    #[must_use]
    pub fn text(&self) -> String {
        let [altitude, error] = self.charts();
        view::text::stack(&[(&altitude, DOWN_ALTITUDE), (&error, DOWN)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_a_picture_and_no_two_are_alike() {
        let mut seen: Vec<(EffectId, Vec<f64>)> = Vec::new();
        for effect in EffectId::ALL {
            let picture = Picture::of(effect).unwrap();
            let least = picture.error_m.iter().copied().fold(f64::INFINITY, f64::min);
            let most = picture.error_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(most > least && picture.error_m.iter().any(|error| error.abs() > 1e-6), "{effect:?}");
            let size = least.abs().max(most.abs());
            let shape: Vec<f64> = picture.error_m.iter().map(|error| error / size).collect();
            let twin = seen
                .iter()
                .find(|(_, other)| other.iter().zip(&shape).all(|(one, other)| (one - other).abs() < 1e-3));
            // These effects differ only in whose altitude has the error.
            let name = effect.name();
            assert!(
                twin.is_none() || ["gps.latency", "imu.velocity_error", "gps.convergence"].contains(&name),
                "{name} {twin:?}"
            );
            seen.push((effect, shape));
            let text = picture.text();
            assert_eq!(text.lines().count(), DOWN + DOWN_ALTITUDE + 4, "{text}");
            assert!(picture.caption().contains("simulated"));
        }
    }

    /// A barometer that lags reads too low in climbs and too high in descents, by the lag times the climb
    /// rate.
    #[test]
    fn a_lag_is_low_in_climbs_and_high_in_descents() {
        let picture = Picture::of(EffectId::BaroLag).unwrap();
        let at = |from_s: f64, to_s: f64| {
            let rows: Vec<usize> = (0..picture.time_s.len())
                .filter(|row| (from_s..to_s).contains(&picture.time_s[*row]))
                .collect();
            let (first, last) = (rows[0], rows[rows.len() - 1]);
            let climb = (picture.altitude_m[last] - picture.altitude_m[first])
                / (picture.time_s[last] - picture.time_s[first]);
            let mean = rows.iter().map(|row| picture.error_m[*row]).sum::<f64>() / rows.len() as f64;
            (climb, mean)
        };
        // The dive and the pull-up of the standard flight, and level flight at its end.
        for (from_s, to_s, least) in [(128.0, 136.0, 10.0), (149.0, 152.0, 3.0), (235.0, 245.0, 0.0)] {
            let (climb, mean) = at(from_s, to_s);
            assert!(climb.abs() >= least, "{from_s}: {climb}");
            assert!(
                (mean + picture.coefficient * climb).abs() < 0.2 * mean.abs() + 0.3,
                "{from_s}: {climb} {mean}"
            );
        }
    }
}
