//! How a sensor's error depends on one signal: dots, and their mean and spread by bin.

use view::{Chart, Role, Values};

use super::signals::Signal;
use super::table::rounded;

/// Limit on the dots drawn; the computed values use all blocks.
const MOST_DOTS: usize = 600;
/// Least number of blocks in a bin, and largest number of bins.
const SMALLEST_BIN: usize = 8;
const MOST_BINS: usize = 20;

/// A sensor's error against a signal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dependence {
    /// The signal, with its unit.
    pub(super) name: String,
    /// Share of the error's variance that lies between the bins' means, corrected for their number: 0 if the
    /// error does not depend on the signal, 1 if the signal explains all of it.
    pub(super) share: f64,
    /// Signal and error of every block, by rising signal.
    pairs: Vec<(f64, f64)>,
    /// The bins, by rising signal.
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bin {
    signal: f64,
    mean: f64,
    spread: f64,
}

impl Dependence {
    /// The dependence of an error on a signal, block by block; `None` if there are too few blocks, or the
    /// signal is constant.
    pub(super) fn of(error_m: &[Option<f64>], signal: &Signal) -> Option<Self> {
        let mut pairs: Vec<(f64, f64)> =
            signal.values.iter().zip(error_m).filter_map(|(x, y)| Some(((*x)?, (*y)?))).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (lowest, highest) = (pairs.first()?.0, pairs.last()?.0);
        let bins = (pairs.len() / SMALLEST_BIN).min(MOST_BINS);
        if bins < 2 || highest - lowest <= 1e-9 * highest.abs().max(lowest.abs()) {
            return None;
        }
        // The same number of blocks in each bin, so that all means are equally certain.
        let bins: Vec<Bin> = (0..bins)
            .filter_map(|index| {
                let bin = pairs.get(pairs.len() * index / bins..pairs.len() * (index + 1) / bins)?;
                let count = bin.len() as f64;
                let mean = |value: fn(&(f64, f64)) -> f64| bin.iter().map(value).sum::<f64>() / count;
                let (signal, error) = (mean(|pair| pair.0), mean(|pair| pair.1));
                let squares: f64 = bin.iter().map(|pair| (pair.1 - error).powi(2)).sum();
                Some(Bin { signal, mean: error, spread: (squares / (count - 1.0)).sqrt() })
            })
            .collect();
        let unit = if signal.unit.is_empty() { String::new() } else { format!(", {}", signal.unit) };
        Some(Self { name: format!("{}{unit}", signal.name), share: share(&pairs, bins.len()), pairs, bins })
    }

    /// The diagram.
    pub(super) fn chart(&self, id: String, sensor: &str) -> Chart {
        enum Place<'a> {
            Dot(f64),
            Bin(&'a Bin),
        }
        let step = self.pairs.len().div_ceil(MOST_DOTS).max(1);
        let dots = self.pairs.iter().step_by(step).map(|(x, y)| (*x, Place::Dot(*y)));
        let mut places: Vec<(f64, Place<'_>)> =
            dots.chain(self.bins.iter().map(|bin| (bin.signal, Place::Bin(bin)))).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let dot = |place: &Place<'_>| match place {
            Place::Dot(y) => Some(rounded(*y)),
            Place::Bin(_) => None,
        };
        let bin = |place: &Place<'_>, sign: f64| match place {
            Place::Dot(_) => None,
            Place::Bin(bin) => Some(rounded(bin.mean + sign * bin.spread)),
        };
        let column = |value: &dyn Fn(&Place<'_>) -> Option<f64>| -> Values {
            places.iter().map(|(_, place)| value(place)).collect()
        };
        let x = places.iter().map(|(x, _)| significant(*x)).collect();
        let y_name = format!("error of {sensor}, m");
        let mut chart = Chart::new(id, String::new(), &self.name, y_name, x)
            .band(
                "± 1 sigma",
                Role::Average,
                column(&|place| bin(place, -1.0)),
                column(&|place| bin(place, 1.0)),
            )
            .line("error", Role::Residual, column(&dot));
        if let Some(line) = chart.lines.last_mut() {
            line.dots = true;
        }
        chart.line("mean", Role::Average, column(&|place| bin(place, 0.0)))
    }
}

/// Five significant digits, because signals have units of every size.
fn significant(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let scale = 10.0_f64.powi(4 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale + 0.0
}

/// Squared correlation ratio, corrected for the number of bins as Ezekiel's adjusted R^2 is.
fn share(pairs: &[(f64, f64)], bins: usize) -> f64 {
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / count;
    let total: f64 = pairs.iter().map(|pair| (pair.1 - mean).powi(2)).sum();
    if total <= 0.0 {
        return 0.0;
    }
    let within: f64 = (0..bins)
        .filter_map(|index| pairs.get(pairs.len() * index / bins..pairs.len() * (index + 1) / bins))
        .map(|bin| {
            let mean = bin.iter().map(|pair| pair.1).sum::<f64>() / bin.len() as f64;
            bin.iter().map(|pair| (pair.1 - mean).powi(2)).sum::<f64>()
        })
        .sum();
    (1.0 - within / total * (count - 1.0) / (count - bins as f64)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// Uniform between -0.5 and 0.5.
    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| generator.random::<f64>() - 0.5).collect()
    }

    fn signal(values: impl Iterator<Item = f64>) -> Signal {
        Signal { name: "airspeed".to_owned(), unit: "m/s", values: values.map(Some).collect() }
    }

    #[test]
    fn an_error_that_goes_with_a_signal_is_told_from_one_that_does_not() {
        let speed = signal(noise(2_000, 1).into_iter().map(|noise| 30.0 + 10.0 * noise));
        let follows: Vec<_> = speed.values.iter().map(|speed| speed.map(|v| (v - 30.0).powi(2))).collect();
        let free: Vec<_> = noise(2_000, 2).into_iter().map(Some).collect();
        let strong = Dependence::of(&follows, &speed).unwrap();
        let none = Dependence::of(&free, &speed).unwrap();
        assert!(strong.share > 0.97, "{}", strong.share);
        // Its standard error: sqrt(2 * 19) / 2000.
        assert!(none.share < 4.0 * 38.0_f64.sqrt() / 2_000.0, "{}", none.share);
        assert_eq!(strong.name, "airspeed, m/s");
        // The bins' means follow the parabola.
        for bin in &strong.bins {
            assert!((bin.mean - (bin.signal - 30.0).powi(2)).abs() < 0.3, "{bin:?}");
        }
    }

    #[test]
    fn a_chart_has_dots_bins_and_rising_places() {
        let speed = signal(noise(5_000, 3).into_iter().map(|noise| noise * 1e-3));
        let error: Vec<_> = (0..5_000).map(|index| Some(f64::from(index % 7))).collect();
        let chart = Dependence::of(&error, &speed).unwrap().chart("c".into(), "baro");
        assert!(chart.x.is_sorted() && chart.x.len() <= MOST_DOTS + MOST_BINS);
        let count = |values: &Values| values.iter().flatten().count();
        assert_eq!(count(&chart.bands[0].from), MOST_BINS);
        assert_eq!(count(&chart.lines[1].y), MOST_BINS);
        assert!(count(&chart.lines[0].y) > 500);
        assert!(chart.lines[0].dots && !chart.lines[1].dots);
    }

    #[test]
    fn a_constant_or_short_signal_is_none() {
        let error = vec![Some(1.0); 100];
        assert_eq!(Dependence::of(&error, &signal((0..100).map(|_| 4.0))), None);
        assert_eq!(Dependence::of(&error[..15], &signal((0..15).map(f64::from))), None);
        assert_eq!(Dependence::of(&[], &signal(std::iter::empty())), None);
    }

    #[test]
    fn digits_follow_the_size() {
        assert_eq!(significant(123.456_789), 123.46);
        assert_eq!(significant(-0.000_123_456_7), -0.000_123_46);
        assert_eq!(significant(0.0), 0.0);
    }
}
