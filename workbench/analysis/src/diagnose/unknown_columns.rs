//! What a remainder may follow: functions of signals with a lag, their integrals since launch, a play on the
//! altitude, jumps; and their columns.

use statistics::Moments;

use super::epochs::Epochs;
use super::series::BySensor;
use super::signals::CLIMBED;

/// Lags of the low passes that are tried, seconds.
pub const LAGS_S: [f64; 3] = [0.0, 2.0, 8.0];
/// Half-widths of the plays that are tried, metres: those of aneroids and pressure cells (some metres), and
/// those due to a sticking capsule or a kinked hose.
pub const PLAYS_M: [f64; 4] = [4.0, 10.0, 25.0, 60.0];

/// What is tested: a function of a signal with a lag, a play on the altitude, or a permanent jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// A function of a signal, through a low pass.
    Signal { signal: usize, shape: Shape, lag_s: f64 },
    /// A signal about its mean in captive flight, integrated once or twice since launch: this is how an
    /// inertial altitude shows an error of its velocity or of its acceleration.
    Integral { signal: usize, times: Times },
    /// Elastic hysteresis: the sensor follows only when the altitude has moved on by the half-width.
    Play { half_width_m: f64 },
    /// A permanent jump, in this block of this flight.
    Jump { flight: usize, block: usize },
}

/// How often a signal is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    Once,
    Twice,
}

impl Times {
    pub const ALL: [Self; 2] = [Self::Once, Self::Twice];
}

/// A function of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Value,
    Magnitude,
    Square,
    Rate,
}

impl Shape {
    pub const ALL: [Self; 4] = [Self::Value, Self::Magnitude, Self::Square, Self::Rate];

    fn describe(self, signal: &str) -> String {
        match self {
            Self::Value => signal.to_owned(),
            Self::Magnitude => format!("|{signal} - its mean|"),
            Self::Square => format!("({signal} - its mean)^2"),
            Self::Rate => format!("rate of {signal}"),
        }
    }
}

impl Test {
    /// Number of columns. A jump within a block has two: the block's own share, and the rest.
    pub const fn width(self) -> usize {
        match self {
            Self::Signal { .. } | Self::Integral { .. } | Self::Play { .. } => 1,
            Self::Jump { .. } => 2,
        }
    }

    pub fn describe(self, epochs: &[Epochs]) -> (String, f64) {
        let name = |signal: usize| {
            epochs.first().and_then(|first| first.signal_names.get(signal)).map_or("?", String::as_str)
        };
        match self {
            Self::Signal { signal, shape, lag_s } => (shape.describe(name(signal)), lag_s),
            Self::Integral { signal, times } => {
                let integral = match times {
                    Times::Once => "integral",
                    Times::Twice => "double integral",
                };
                (format!("the {integral} of {} since launch", name(signal)), 0.0)
            }
            Self::Play { half_width_m } => {
                (format!("altitude with a play of +-{half_width_m:.0} m (hysteresis)"), 0.0)
            }
            Self::Jump { flight, block } => {
                let time_s =
                    epochs.get(flight).and_then(|e| e.series.time_s.get(block)).copied().unwrap_or(0.0);
                (format!("a lasting jump at {time_s:.0} s"), 0.0)
            }
        }
    }
}

/// Extra columns, by flight: one per test.
pub type Extra = Vec<Vec<Vec<BySensor>>>;

/// The columns of tests on one sensor.
pub fn extra_columns(epochs: &[Epochs], tests: &[Test], sensor: usize) -> Extra {
    let of_flight = |(flight, epochs): (usize, &Epochs)| {
        let values = |test: &Test| match *test {
            Test::Signal { signal, shape, lag_s } => vec![signal_values(epochs, signal, shape, lag_s)],
            Test::Integral { signal, times } => vec![integral(epochs, signal, times)],
            Test::Play { half_width_m } => {
                let altitudes_m = epochs.signals.iter().map(|block| block[CLIMBED]);
                vec![play(altitudes_m, half_width_m)]
            }
            Test::Jump { flight: jumps, block } => {
                let from = |first: usize| {
                    (0..epochs.series.len())
                        .map(|b| f64::from(u8::from(flight == jumps && b >= first)))
                        .collect()
                };
                vec![from(block + 1), from(block)]
            }
        };
        let on_sensor = |value: f64| std::array::from_fn(|i| if i == sensor { value } else { 0.0 });
        let columns = tests.iter().flat_map(values);
        columns.map(|column: Vec<f64>| column.into_iter().map(on_sensor).collect()).collect()
    };
    epochs.iter().enumerate().map(of_flight).collect()
}

/// A function of a signal about its mean; zero where a flight lacks the signal.
fn signal_values(epochs: &Epochs, signal: usize, shape: Shape, lag_s: f64) -> Vec<f64> {
    let times = &epochs.series.time_s;
    let values: Vec<f64> = epochs.signals.iter().map(|block| block[signal]).collect();
    let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if known.len() * 10 < values.len() * 9 {
        return vec![0.0; values.len()];
    }
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let centred: Vec<f64> =
        values.iter().map(|value| if value.is_finite() { value - mean } else { 0.0 }).collect();
    let slow = low_pass(times, &centred, lag_s);
    let shaped = centred.iter().zip(&slow).map(|(now, slow)| match shape {
        Shape::Value => *slow,
        Shape::Magnitude => slow.abs(),
        Shape::Square => slow * slow,
        Shape::Rate => (now - slow) / lag_s,
    });
    shaped.collect()
}

/// A signal about its mean in captive flight, or in the whole flight where captive flight lacks it, integrated
/// since launch; zero where the flight lacks the signal. A block's value is that at its middle.
fn integral(epochs: &Epochs, signal: usize, times: Times) -> Vec<f64> {
    let series = &epochs.series;
    let values: Vec<f64> = epochs.signals.iter().map(|block| block[signal]).collect();
    let (mut captive, mut all) = (Moments::default(), Moments::default());
    for (value, free) in values.iter().zip(&series.free).filter(|(value, _)| value.is_finite()) {
        all.push(*value);
        if !*free {
            captive.push(*value);
        }
    }
    let Some(mean) = captive.mean().or(all.mean()) else { return vec![0.0; values.len()] };
    let (mut once, mut twice) = (0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    let integrals = values.iter().zip(&series.time_s).zip(&series.free).map(|((value, time_s), free)| {
        if !*free {
            return 0.0;
        }
        let now = if value.is_finite() { value - mean } else { last.map_or(0.0, |(value, _)| value) };
        // The first block in free flight begins at launch.
        let (before, step_s) = last.map_or((now, 0.5 * series.block_s), |(value, s)| (value, time_s - s));
        let gained = 0.5 * (before + now) * step_s;
        twice += (once + 0.5 * gained) * step_s;
        once += gained;
        last = Some((now, *time_s));
        match times {
            Times::Once => once,
            Times::Twice => twice,
        }
    });
    integrals.collect()
}

/// What a play adds to altitudes, metres; zero where there is no altitude.
fn play(altitudes_m: impl Iterator<Item = f64>, half_width_m: f64) -> Vec<f64> {
    let mut centre_m = None;
    let lags = altitudes_m.map(|altitude_m| {
        if !altitude_m.is_finite() {
            return 0.0;
        }
        let centre_m: &mut f64 = centre_m.get_or_insert(altitude_m);
        *centre_m = centre_m.clamp(altitude_m - half_width_m, altitude_m + half_width_m);
        *centre_m - altitude_m
    });
    lags.collect()
}

/// First-order low pass.
fn low_pass(times: &[f64], values: &[f64], time_s: f64) -> Vec<f64> {
    let mut state = values.first().copied().unwrap_or(0.0);
    let mut last_s = times.first().copied().unwrap_or(0.0);
    let filtered = times.iter().zip(values).map(|(now_s, value)| {
        let keep = if time_s > 0.0 { libm::exp(-(now_s - last_s) / time_s) } else { 0.0 };
        last_s = *now_s;
        state = keep * state + (1.0 - keep) * value;
        state
    });
    filtered.collect()
}

/// Standard deviation of an extra column over all blocks of all flights.
pub fn spread(columns: &Extra, k: usize) -> f64 {
    let values: Vec<f64> = columns
        .iter()
        .flat_map(|flight| flight[k].iter().map(|by| by.iter().copied().fold(0.0, pick)))
        .collect();
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n).sqrt()
}

/// The value of the sensor that has one.
fn pick(a: f64, b: f64) -> f64 {
    if a == 0.0 { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::series::Series;

    #[test]
    fn a_play_follows_only_when_the_altitude_has_gone_on_by_its_half_width() {
        let up_and_down = [100.0, 105.0, 110.0, 130.0, 125.0, 112.0, 105.0, f64::NAN, 110.0];
        let lags = play(up_and_down.into_iter(), 10.0);
        // Up to 110 within the play; at 130 dragged to 120; at 110 again from 110 downwards; at 105 dragged
        // to 115.
        assert_eq!(lags, [0.0, -5.0, -10.0, -10.0, -5.0, 8.0, 10.0, 0.0, 5.0]);
    }

    /// A signal of 3 in captive flight, and of 3 + 2 t at t after launch: of its change, t^2 and t^3 / 3. A block
    /// without the signal is bridged by the value before.
    #[test]
    fn integrals_begin_at_launch_and_leave_out_what_captive_flight_had() {
        let (captive, free, block_s) = (4, 20, 0.5);
        let since_launch_s = |block: usize| (block as f64 - captive as f64 + 0.5) * block_s;
        let of = |signal: &dyn Fn(usize) -> f64| Epochs {
            series: Series {
                time_s: (0..captive + free).map(|block| 100.0 + block as f64 * block_s).collect(),
                free: (0..captive + free).map(|block| block >= captive).collect(),
                block_s,
                ..Series::default()
            },
            available: Vec::new(),
            column_noise_m2: Vec::new(),
            climb_noise_m2: 0.0,
            signals: (0..captive + free).map(|block| vec![signal(block)]).collect(),
            signal_names: vec!["roll_rad".to_owned()],
            glitches: Vec::new(),
            steps: Vec::new(),
            unreferenced: 0,
            refused: 0,
        };
        let epochs = of(&|block| 3.0 + 2.0 * since_launch_s(block).max(0.0));
        let (once, twice) = (integral(&epochs, 0, Times::Once), integral(&epochs, 0, Times::Twice));
        for block in 0..captive + free {
            let t = since_launch_s(block).max(0.0);
            // The first half block is taken as constant, which adds 1/16; that and the trapezoids add t / 16 and
            // t / 24 to the double integral.
            assert!((once[block] - t * t).abs() < 0.063, "{t}: {}", once[block]);
            assert!((twice[block] - t * t * t / 3.0).abs() < 0.105 * t + 0.02, "{t}: {}", twice[block]);
        }
        assert_eq!(once[..captive], [0.0; 4]);

        let unknown = of(&|_| f64::NAN);
        assert_eq!(integral(&unknown, 0, Times::Twice), vec![0.0; captive + free]);
        let gap = of(&|block| match block {
            0..4 => 3.0,
            10 => f64::NAN,
            _ => 4.0,
        });
        let last = integral(&gap, 0, Times::Once)[captive + free - 1];
        assert!((last - since_launch_s(captive + free - 1)).abs() < 1e-9, "{last}");
    }

    /// A low pass follows a step exponentially; without a time constant it is the signal itself.
    #[test]
    fn a_low_pass_is_exact_for_a_step() {
        let (times, values) = ([100.0, 101.0, 104.0], [0.0, 1.0, 1.0]);
        let passed = low_pass(&times, &values, 2.0);
        for (found, since_s) in passed.iter().zip([0.0, 1.0, 4.0]) {
            assert!((found - (1.0 - libm::exp(-since_s / 2.0))).abs() < 1e-12, "{passed:?}");
        }
        assert_eq!(low_pass(&times, &values, 0.0), values);
    }
}
