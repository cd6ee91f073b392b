//! Combines several estimates with their own sigmas into one, and finds those that do not fit the others.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;

use super::distributions::student_above;
use super::standard_normal::standard_normal;

/// Probability of naming any outlier among estimates that all fit together.
const FALSE_ALARM: f64 = 0.05;
/// Least number of estimates for finding an outlier: without it, three must be left, because of two neither
/// can be called the odd one.
const FEWEST: usize = 4;
/// Largest number of outliers: if more do not fit, the others are in doubt.
const MOST_OUTLIERS: usize = 6;
/// Simulated tables for a limit: they resolve a probability of one in two hundred.
const TABLES: usize = 199;
/// Fixed, so that the tables are always the same.
const SEED: u64 = 1;
/// Steps of the bisection: 2^-40 of the widest possible spread.
const STEPS: usize = 40;

/// An estimate and one sigma of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// One sigma; above zero.
    pub sigma: f64,
}

/// Combination of several estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct Pooled {
    /// Their mean, without the outliers.
    pub mean: f64,
    /// One sigma of it.
    pub sigma: f64,
    /// Spread of the true value from one estimate to the next, 1 sigma; 0 where the estimates' own sigmas
    /// explain all of the scatter.
    pub spread: f64,
    /// The estimates that do not fit the others, the most unlikely first.
    pub outliers: Vec<Outlier>,
}

/// An estimate that does not fit the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Its index.
    pub place: usize,
    /// Probability that, if all fit together, any of this many estimates deviates as far: this one, or one
    /// found after it that it had hidden.
    pub p_value: f64,
}

/// Combines estimates by a random-effects model: they scatter about one mean by their own sigmas and by one
/// additional spread, which is estimated by Paule and Mandel's equation (DerSimonian and Kacker,
/// "Random-effects model for meta-analysis of clinical trials: an update", Contemp. Clin. Trials 28 (2007)
/// 105, section 2). `None` without an estimate.
///
/// Outliers are found as by the generalised extreme studentised deviates (Rosner, Technometrics 25 (1983)
/// 165). The estimate that is least likely by a prediction from all others (Higgins, Thompson and
/// Spiegelhalter, J. R. Stat. Soc. A 172 (2009) 137, section 3) is removed, repeatedly, up to a third of
/// them. All those up to the last one beyond the limit are outliers, so that two that hide each other are
/// found. Published tables of limits assume equal sigmas and no spread; with the sigmas of flights, one table
/// in six of twelve estimates would name an outlier wrongly. So each table has its own limit: the one
/// exceeded by one in twenty tables simulated with its own sigmas, mean and spread (a parametric bootstrap;
/// Davison and Hinkley, "Bootstrap Methods", section 4.2).
#[must_use]
pub fn pooled(estimates: &[Estimate]) -> Option<Pooled> {
    let mut taken = oddest(estimates);
    // If no step is unlikely enough by itself, simulating the tables is not worth the time.
    let is_any_odd = taken.iter().any(|outlier| outlier.p_value < FALSE_ALARM);
    let made = if is_any_odd { least_chances(estimates)? } else { Vec::new() };
    let mut found = 0;
    for (place, outlier) in taken.iter_mut().enumerate() {
        let as_odd = made.iter().filter(|least| **least <= outlier.p_value).count();
        outlier.p_value = (1 + as_odd) as f64 / (1 + made.len()) as f64;
        if is_any_odd && outlier.p_value <= FALSE_ALARM {
            found = place + 1;
        }
    }
    taken.truncate(found);
    // Of two that hide each other, the first gets the second's lower probability.
    let mut least = 1.0_f64;
    for outlier in taken.iter_mut().rev() {
        least = least.min(outlier.p_value);
        outlier.p_value = least;
    }
    let is_kept = |place: usize| !taken.iter().any(|outlier| outlier.place == place);
    let kept: Vec<Estimate> =
        estimates.iter().enumerate().filter(|(place, _)| is_kept(*place)).map(|(_, one)| *one).collect();
    let (mean, sigma, spread) = together(&kept)?;
    Some(Pooled { mean, sigma, spread, outliers: taken })
}

/// The most unlikely estimate, the most unlikely of the rest, and so on, each with its probability times the
/// number of estimates that it was chosen from.
fn oddest(estimates: &[Estimate]) -> Vec<Outlier> {
    let mut left: Vec<(usize, Estimate)> = estimates.iter().copied().enumerate().collect();
    let mut taken = Vec::new();
    for _ in 0..(estimates.len() / 3).min(MOST_OUTLIERS) {
        if left.len() < FEWEST {
            break;
        }
        let chances = left.iter().enumerate().filter_map(|(index, (_, estimate))| {
            let others: Vec<Estimate> = left
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != index)
                .map(|(_, (_, one))| *one)
                .collect();
            Some((index, chance(*estimate, &others)?))
        });
        let Some((index, chance)) = chances.min_by(|one, other| one.1.total_cmp(&other.1)) else { break };
        let (place, _) = left.remove(index);
        taken.push(Outlier { place, p_value: (chance * (left.len() + 1) as f64).min(1.0) });
    }
    taken
}

/// The least probability of any step in each of the tables simulated with these sigmas, their mean and their
/// spread, without outliers.
fn least_chances(estimates: &[Estimate]) -> Option<Vec<f64>> {
    let (mean, _, spread) = together(estimates)?;
    let mut generator = ChaCha8Rng::seed_from_u64(SEED);
    let tables = (0..TABLES).map(|_| {
        let made: Vec<Estimate> = estimates
            .iter()
            .map(|one| {
                let noise = standard_normal(&mut generator);
                Estimate { value: mean + libm::hypot(one.sigma, spread) * noise, ..*one }
            })
            .collect();
        oddest(&made).iter().map(|outlier| outlier.p_value).fold(1.0, f64::min)
    });
    Some(tables.collect())
}

/// Probability of an estimate at least as far from the prediction of all others.
fn chance(estimate: Estimate, others: &[Estimate]) -> Option<f64> {
    let (mean, sigma, spread) = together(others)?;
    let expected = (estimate.sigma.powi(2) + spread.powi(2) + sigma.powi(2)).sqrt();
    let degrees = others.len().checked_sub(2).filter(|degrees| *degrees > 0)? as f64;
    Some(2.0 * student_above(degrees, ((estimate.value - mean) / expected).abs()))
}

/// Mean, its sigma, and the spread beyond the estimates' own sigmas.
fn together(estimates: &[Estimate]) -> Option<(f64, f64, f64)> {
    let mean = |spread: f64| {
        let weights = estimates.iter().map(|one| 1.0 / (one.sigma.powi(2) + spread.powi(2)));
        let (sum, weight) = estimates
            .iter()
            .zip(weights)
            .fold((0.0, 0.0), |(sum, all), (one, weight)| (sum + weight * one.value, all + weight));
        (sum / weight, weight.sqrt().recip())
    };
    let excess = |spread: f64| {
        let (mean, _) = mean(spread);
        let squares =
            estimates.iter().map(|one| (one.value - mean).powi(2) / (one.sigma.powi(2) + spread.powi(2)));
        squares.sum::<f64>() - (estimates.len() as f64 - 1.0)
    };
    if estimates.is_empty() {
        return None;
    }
    let values = estimates.iter().map(|one| one.value);
    let (least, most) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
    let (mut low, mut high) = (0.0, (most - least) * (estimates.len() as f64).sqrt());
    if excess(0.0) <= 0.0 {
        high = 0.0;
    }
    for _ in 0..STEPS {
        let middle = f64::midpoint(low, high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let (mean, sigma) = mean(high);
    (mean.is_finite() && sigma.is_finite()).then_some((mean, sigma, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt as _;

    /// Estimates of values that differ by `spread`, with sigmas from 0.1 to 2.
    fn made(generator: &mut ChaCha8Rng, count: usize, spread: f64) -> Vec<Estimate> {
        (0..count)
            .map(|_| {
                let sigma = 10_f64.powf(generator.random_range(-1.0..0.3));
                let mut noise = || standard_normal(generator);
                Estimate { value: 3.0 + spread * noise() + sigma * noise(), sigma }
            })
            .collect()
    }

    #[test]
    fn the_mean_and_the_spread_are_those_that_were_put_in() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        for spread in [0.0, 0.5, 3.0] {
            let (mean, sigma, found) = together(&made(&mut generator, 400, spread)).unwrap();
            assert!((mean - 3.0).abs() < 4.0 * sigma, "{mean} {sigma}");
            assert!((found - spread).abs() < 0.15 * spread.max(0.5), "{found} {spread}");
        }
        let one = pooled(&[Estimate { value: 2.0, sigma: 0.5 }]).unwrap();
        assert_eq!((one.mean, one.sigma, one.spread), (2.0, 0.5, 0.0));
        assert_eq!(pooled(&[]), None);
    }

    /// How often an outlier is named among estimates that fit together: one table in twenty.
    #[test]
    fn one_table_in_twenty_names_an_outlier_that_is_none() {
        let mut generator = ChaCha8Rng::seed_from_u64(2);
        for (count, spread) in [(5, 1.0), (6, 0.0), (6, 1.0), (12, 1.0)] {
            let tables = 200;
            let named = (0..tables)
                .filter(|_| !pooled(&made(&mut generator, count, spread)).unwrap().outliers.is_empty())
                .count();
            // Ninety-nine in a hundred counts with that probability are at most this.
            assert!(named <= 18, "{count}, {spread}: {named} of {tables}");
        }
    }

    #[test]
    fn two_that_are_off_alike_do_not_hide_each_other() {
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let mut found = 0;
        for _ in 0..100 {
            let mut estimates = made(&mut generator, 12, 0.5);
            estimates[3] = Estimate { value: 13.0, sigma: 0.3 };
            estimates[7] = Estimate { value: 13.5, sigma: 0.3 };
            let mut places: Vec<usize> =
                pooled(&estimates).unwrap().outliers.iter().map(|outlier| outlier.place).collect();
            places.sort_unstable();
            found += usize::from(places == [3, 7]);
        }
        assert!(found >= 85, "{found}");
    }

    #[test]
    fn of_three_none_is_the_odd_one() {
        let estimates = [0.0, 0.1, 50.0].map(|value| Estimate { value, sigma: 0.1 });
        assert_eq!(pooled(&estimates).unwrap().outliers, []);
    }
}
