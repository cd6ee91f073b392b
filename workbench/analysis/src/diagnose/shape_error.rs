//! How much of the evidence for one explanation over another may come from errors of the regressors' shapes.
//!
//! An effect's regressor is computed from measured signals by a formula that leaves terms out. Scale errors,
//! lags and offsets of the signals, and the terms left out, turn it into another combination of a few shapes:
//! the true one is `x + e`. The part of `e` that is like `x` is absorbed by its coefficient. The rest stays
//! in the residual, and may look like another effect's regressor.
//!
//! Two explanations, the worse and the better, differ by what the better one has beyond the worse: a
//! direction `w` of length one in the whitened readings. The squares that the better one gains are those of
//! the residual along it. If the worse one is right, chance contributes a variance of one there, and its
//! effects' errors that of `e w`. An error is assumed to be a share `S`, in squares, of what the effects
//! contribute to a sensor in a tenth of a flight. It has any shape there, and a different one in the next
//! tenth and on the next sensor. Then by Cauchy and Schwarz
//!
//! `var(e w) <= S sum over tenths and sensors of E W`,
//!
//! with the squares `E` that the effects contribute there and the share `W` of `w` that lies there. Where
//! both are spread over n tenths that is `S E / n`. An error is no larger in metres either: it is a share `S`
//! of the squares `M` that the effects make there in metres. The whitener treats slow errors as wander, so a
//! fast effect of a few metres has more squares than a slow one of tens of metres; but an error of its shape
//! cannot be these tens of metres. An error of that size in metres contributes at most `S M H` along `w`,
//! with the squares `H` of the weights that `w` gives the readings there ([`super::score::weights`]; Cauchy
//! and Schwarz again). The smaller of the two counts:
//!
//! `var(e w) <= S sum over tenths and sensors of min(E W, M H)`.
//!
//! What effects do to another sensor, or at another time than where the two explanations differ, does not
//! count.

use kf_core::sensor::SENSORS;
use nalgebra::{DMatrix, DVector};

use super::information::{Information, own_factor};
use super::noise::Noise;
use super::problem::{Problem, combined};
use super::repeatability::PARTS;
use super::score::weights;
use super::series::{BySensor, Series};
use super::suspects::Suspects;
use super::whitener::whiten;

/// For each column of `kept`, the squares of its effect where the direction lies in which `kept` with `added`
/// differs from `kept` alone (the mean over that direction). Multiplied by the column's `S`, this is the
/// variance that the error of its shape leaves in that direction. `None` where the columns cannot be told
/// apart.
fn exposure(problem: &Problem<'_>, noise: &Noise, kept: &[usize], added: &[usize]) -> Option<Vec<f64>> {
    let picks: Vec<usize> = kept.iter().chain(added).copied().collect();
    let normal = Normal::new(problem, noise, picks);
    let (of_kept, all): (Vec<usize>, Vec<usize>) =
        ((0..kept.len()).collect(), (0..normal.picks.len()).collect());
    let mut put = normal.information.solve(&of_kept)?.coefficients;
    put.resize(normal.picks.len(), 0.0);
    let mut beyond = normal.information.solve(&all)?.coefficients;
    beyond[..kept.len()].fill(0.0);
    let (length, mut sums) = normal.exposed(problem, noise, &of_kept, beyond, &put)?;
    sums.truncate(kept.len());
    Some(sums.into_iter().map(|sum| sum / length).collect())
}

/// A variance of an effect's coefficient, in its unit squared, by where it comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByOrigin {
    /// The effect itself: a share of its coefficient, which vanishes where the effect does not act.
    pub own: f64,
    /// The other effects, which remain where this one does not act.
    pub others: f64,
}

/// The variance that the errors of the shapes of some columns give the last one's coefficient. `None` where
/// they cannot be told apart.
///
/// The coefficient is the residual along what the others leave of the column, `x`, over the squares of `x`.
/// So the error of a shape moves it by `e x / (x x)`, of which the module's bound holds along `x`. Where one
/// effect alone is spread evenly over a flight, that is a share `S / 10` of the coefficient's square.
#[must_use]
pub fn variance_of_coefficient(
    problem: &Problem<'_>,
    suspects: &Suspects<'_>,
    noise: &Noise,
    columns: &[usize],
) -> Option<ByOrigin> {
    let normal = Normal::new(problem, noise, columns.to_vec());
    let all: Vec<usize> = (0..columns.len()).collect();
    let put = normal.information.solve(&all)?.coefficients;
    let others = all.split_last()?.1;
    let mut own = vec![0.0; others.len()];
    own.push(1.0);
    let (length, sums) = normal.exposed(problem, noise, others, own, &put)?;
    let shapes = normal.picks.iter().zip(sums).map(|(column, sum)| suspects.shape(*column) * sum);
    let mut shapes: Vec<f64> = shapes.map(|shape| shape / (length * length)).collect();
    let own = shapes.pop()?;
    Some(ByOrigin { own, others: shapes.into_iter().sum() })
}

/// The normal equations of some picks.
struct Normal {
    picks: Vec<usize>,
    products: Vec<DMatrix<f64>>,
    information: Information,
}

impl Normal {
    fn new(problem: &Problem<'_>, noise: &Noise, picks: Vec<usize>) -> Self {
        let products: Vec<DMatrix<f64>> = problem
            .flights
            .iter()
            .map(|flight| {
                problem.products(flight, noise, &problem.columns(flight, &picks), &|_| true).products
            })
            .collect();
        let mut information = Information::new(1 + picks.len());
        for products in &products {
            information.add_flight(products, problem.own(), 0, 0.0);
        }
        Self { picks, products, information }
    }

    /// The squares of what some kept picks (by position) leave of a direction, and for each pick the squares
    /// of its effect where that lies, with these coefficients: the sums over tenths and sensors of the
    /// smaller of the two bounds, times the direction's squares.
    fn exposed(
        &self,
        problem: &Problem<'_>,
        noise: &Noise,
        kept: &[usize],
        mut direction: Vec<f64>,
        put: &[f64],
    ) -> Option<(f64, Vec<f64>)> {
        let picks = self.picks.len();
        for (k, share) in kept.iter().zip(self.information.regression(&direction, kept)?) {
            direction[*k] -= share;
        }
        let mut length = 0.0;
        let mut sums = vec![0.0; picks];
        for (flight, products) in problem.flights.iter().zip(&self.products) {
            let columns = problem.columns(flight, &self.picks);
            let combination =
                |picks: &[f64]| combined(&columns, beside_own(products, problem.own(), picks).as_slice());
            let of_effects = put.iter().enumerate().map(|(k, coefficient)| {
                let mut one = vec![0.0; picks];
                one[k] = *coefficient;
                combination(&one)
            });
            let made: Vec<Vec<BySensor>> =
                std::iter::once(combination(&direction)).chain(of_effects).collect();
            for parts in squares(flight, noise, &made) {
                length += parts.direction;
                for (sum, effect) in sums.iter_mut().zip(&parts.effects) {
                    *sum += (parts.direction * effect.whitened).min(parts.weights * effect.metres);
                }
            }
        }
        (length > 0.0).then_some((length, sums))
    }
}

/// Squares of one sensor in one tenth of a flight.
#[derive(Clone)]
struct Part {
    /// Squares of the direction, whitened.
    direction: f64,
    /// Squares of the weights that the direction gives the readings, 1/m^2.
    weights: f64,
    effects: Vec<Effect>,
}

/// Squares of an effect in that part.
#[derive(Clone, Copy, Default)]
struct Effect {
    whitened: f64,
    /// Squares in metres, m^2.
    metres: f64,
}

/// The squares of the direction (the first of these columns) and of the effects (the others).
fn squares(flight: &Series, noise: &Noise, made: &[Vec<BySensor>]) -> Vec<Part> {
    let effects = vec![Effect::default(); made.len() - 1];
    let mut parts = vec![Part { direction: 0.0, weights: 0.0, effects }; PARTS * SENSORS];
    let part = |block: usize| (block * PARTS / flight.len().max(1)).min(PARTS - 1);
    let columns: Vec<&[BySensor]> = made.iter().map(Vec::as_slice).collect();
    whiten(flight, noise, &columns, &|_| true, &mut |block, sensor, row| {
        let here = &mut parts[part(block) * SENSORS + sensor];
        here.direction += row[0] * row[0];
        for (k, effect) in here.effects.iter_mut().enumerate() {
            let metres = columns[1 + k][block][sensor];
            effect.whitened += row[1 + k] * row[1 + k];
            effect.metres += metres * metres;
        }
    });
    weights(flight, noise, &columns[..1], &mut |block, sensor, row| {
        parts[part(block) * SENSORS + sensor].weights += row[0] * row[0];
    });
    parts
}

/// The variance, relative to that of chance, that the errors of the shapes of `kept` leave in the direction
/// in which `added` differs from them. `None` where they cannot be told apart.
#[must_use]
pub fn variance(
    problem: &Problem<'_>,
    suspects: &Suspects<'_>,
    noise: &Noise,
    kept: &[usize],
    added: &[usize],
) -> Option<f64> {
    let exposure = exposure(problem, noise, kept, added)?;
    Some(kept.iter().zip(exposure).map(|(column, exposure)| suspects.shape(*column) * exposure).sum())
}

/// A combination of the picks less the part that a flight's own columns (biases first) absorb, over all of
/// its columns.
fn beside_own(products: &DMatrix<f64>, own: usize, picks: &[f64]) -> DVector<f64> {
    let mut vector = DVector::zeros(products.nrows());
    for (k, value) in picks.iter().enumerate() {
        vector[1 + own + k] = *value;
    }
    if let Some((present, factor)) = own_factor(products, own) {
        let right = products.select_rows(&present) * &vector;
        for (at, value) in present.iter().zip(factor.solve(&right).iter()) {
            vector[*at] = -value;
        }
    }
    vector
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use kf_core::effect::{Clock, EffectId, Regressor};

    use super::super::candidates::Candidate;
    use super::super::noise::{GaussMarkov, NoisePrior, SensorNoise};
    use super::super::physical_range::Bounds;
    use super::super::suspects::Regressors;
    use super::*;

    /// White noise in each block, metres.
    const WHITE_M: f64 = 0.5;

    fn noise(wander_m: f64) -> Noise {
        let none = GaussMarkov { sigma_m: 1e-6, time_s: 30.0 };
        let sensor = SensorNoise {
            wander: GaussMarkov { sigma_m: wander_m, time_s: 30.0 },
            captive_white_m: WHITE_M,
            free_white_m: WHITE_M,
            free_flight_factor: 1.0,
        };
        Noise { reference: none, slow: none, fix_sigma_m: 1e-6, sensors: [sensor; SENSORS] }
    }

    /// A wander of a millionth of the white noise.
    const NONE_M: f64 = 1e-6;

    const BLOCKS: u32 = 120;
    const INERTIAL: usize = 1;
    const BARO: usize = 2;

    /// Two patterns of ones that are orthogonal to each other and to a bias in every tenth of the flight.
    fn kept(block: u32) -> f64 {
        if block % 4 < 2 { 1.0 } else { -1.0 }
    }

    fn added(block: u32) -> f64 {
        if block.is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    /// The exposure of an effect that contributes three times the first column to a sensor, towards a second
    /// column on the barometer.
    fn towards(sensor: usize, first: impl Fn(u32) -> f64, second: impl Fn(u32) -> f64) -> f64 {
        beside_wander(NONE_M, sensor, first, second)
    }

    /// The same with a wander of this many metres.
    fn beside_wander(
        wander_m: f64,
        sensor: usize,
        first: impl Fn(u32) -> f64,
        second: impl Fn(u32) -> f64,
    ) -> f64 {
        let series = two_columns(sensor, first, second);
        with(series, |problem| exposure(problem, &noise(wander_m), &[0], &[1]).unwrap()[0])
    }

    /// A flight whose residual is three times the first column, on a sensor, and 0.2 times the second, on the
    /// barometer.
    fn two_columns(sensor: usize, first: impl Fn(u32) -> f64, second: impl Fn(u32) -> f64) -> Series {
        let mut series = Series {
            block_s: 1.0,
            full_block: [10.0; SENSORS],
            columns: vec![Arc::default(); 2],
            ..Series::default()
        };
        for block in 0..BLOCKS {
            let on =
                |sensor: usize, value: f64| std::array::from_fn(|i| if i == sensor { value } else { 0.0 });
            let columns: [[f64; SENSORS]; 2] = [on(sensor, first(block)), on(BARO, second(block))];
            series.time_s.push(f64::from(block));
            series.fixes.push(5.0);
            series.free.push(true);
            series.readings.push([0, 10, 10]);
            series.residual_m.push(std::array::from_fn(|i| {
                if i == 0 { f64::NAN } else { 3.0 * columns[0][i] + 0.2 * columns[1][i] }
            }));
            for (all, column) in series.columns.iter_mut().zip(columns) {
                Arc::make_mut(all).push(column);
            }
        }
        series
    }

    fn with<R>(series: Series, of: impl Fn(&Problem<'_>) -> R) -> R {
        let flights = [series];
        let model = model::Model::default();
        let prior = NoisePrior::new(&flights, &model.reference, &model.sensors);
        of(&Problem::new(&flights, prior, Vec::new(), &executor::Inline))
    }

    /// Squares of three metres in each of this many blocks.
    fn squares(blocks: u32) -> f64 {
        f64::from(blocks) * 9.0 / (WHITE_M * WHITE_M)
    }

    fn assert_is(exposure: f64, expected: f64) {
        assert!((exposure - expected).abs() < 1e-4 * (1.0 + expected), "{exposure}, expected {expected}");
    }

    /// E spread evenly over ten tenths counts as a tenth of it.
    #[test]
    fn an_effect_over_all_of_a_flight_counts_by_its_tenths() {
        assert_is(towards(BARO, kept, added), squares(BLOCKS) / 10.0);
    }

    /// The relative variance that the first column's coefficient has by errors of shapes, with shares of one
    /// in a hundred. It is the last of these columns.
    fn relative_variance(
        first: impl Fn(u32) -> f64,
        second: impl Fn(u32) -> f64,
        columns: &[usize],
    ) -> ByOrigin {
        let candidates = [EffectId::BaroLag, EffectId::BaroScale]
            .map(|id| Candidate::of(Regressor { id, time_constant_s: 0.0, since: Clock::Launch }));
        let bounds =
            Bounds { range: [-10.0, 10.0], scale: 0.0, consistent: [f64::NEG_INFINITY, f64::INFINITY] };
        let regressors = Regressors {
            noise_m2: vec![0.0; 2],
            attenuating_m2: vec![0.0; 2],
            shape: vec![0.01; 2],
            bounds: vec![bounds; 2],
        };
        let suspects = Suspects::new(&candidates, regressors, vec![0, 1]);
        let variance = with(two_columns(BARO, first, second), |problem| {
            variance_of_coefficient(problem, &suspects, &noise(NONE_M), columns)
        });
        let ByOrigin { own, others } = variance.unwrap();
        ByOrigin { own: own / 9.0, others: others / 9.0 }
    }

    /// An effect that is spread evenly has a tenth of `S`; one in a single tenth has all of it.
    #[test]
    fn a_coefficient_is_uncertain_by_its_shape() {
        let none = |_| 0.0;
        let even = relative_variance(kept, none, &[0]);
        assert_eq!(even.others, 0.0);
        assert!((even.own - 0.01 / 10.0).abs() < 1e-5, "{even:?}");
        let within = |block: u32| if (36..48).contains(&block) { kept(block) } else { 0.0 };
        let one = relative_variance(within, none, &[0]);
        assert!((one.own - 0.01).abs() < 1e-4, "{one:?}");
    }

    /// Beside a column that is like it in half of the flight, the two halves show the coefficient by 1 : 5, and
    /// the errors of both effects count: a third more than a tenth of `S`.
    #[test]
    fn a_coefficient_is_more_uncertain_beside_a_column_like_it() {
        let like = |block| if block < 60 { kept(block) } else { added(block) };
        let beside = relative_variance(kept, like, &[1, 0]);
        let expected = 0.01 / 10.0 * 4.0 / 3.0;
        assert!((beside.own / expected - 1.0).abs() < 1e-4, "{beside:?} {expected}");
        let expected = expected * (0.2_f64 / 3.0).powi(2);
        assert!((beside.others / expected - 1.0).abs() < 1e-4, "{beside:?} {expected}");
    }

    /// All of the effect lies in the fourth tenth, where half of the direction lies; the other half lies in
    /// the eighth.
    #[test]
    fn what_counts_is_where_the_direction_lies() {
        let within = |value: f64, block: u32, tenths: [u32; 2]| {
            if tenths.contains(&(block / 12)) { value } else { 0.0 }
        };
        let first = |block| within(kept(block), block, [3, 3]);
        assert_is(towards(BARO, first, |block| within(added(block), block, [3, 7])), squares(12) / 2.0);
        assert_is(towards(BARO, first, |block| within(added(block), block, [6, 7])), 0.0);
    }

    #[test]
    fn what_an_effect_does_to_another_sensor_does_not_count() {
        assert_is(towards(INERTIAL, kept, added), 0.0);
    }

    /// Only what the kept column leaves of the added one is a direction. Where the added column equals the
    /// kept one in the first half and differs in the second, the direction is both, five tenths each.
    #[test]
    fn the_direction_is_what_the_kept_columns_leave() {
        let second = |block| if block < 60 { kept(block) } else { 3.0 * added(block) };
        // The kept column is spread evenly, so the direction's place does not matter to it. Alone it absorbs
        // half of the added one's 0.2 as well: 3.1.
        assert_is(towards(BARO, kept, second), (3.1_f64 / 3.0).powi(2) * squares(BLOCKS) / 10.0);
        // The kept column in the first half alone absorbs everything there: nothing is left where it acts.
        assert_is(towards(BARO, |block| if block < 60 { kept(block) } else { 0.0 }, second), 0.0);
    }

    /// A fast effect and a slow direction in a wander, written down with the dense covariance: in some parts
    /// the metres bound the error, and the bound is less than a tenth of what whitened squares alone would
    /// give.
    #[test]
    fn a_fast_effects_error_is_no_larger_in_metres_towards_a_slow_direction() {
        const WANDER_M: f64 = 5.0;
        let slow = |block: u32| (std::f64::consts::TAU * f64::from(block) / f64::from(BLOCKS)).sin();
        let n = BLOCKS as usize;
        let covariance = DMatrix::from_fn(n, n, |r, c| {
            let wander = WANDER_M * WANDER_M * (-(r.abs_diff(c) as f64) / 30.0).exp();
            wander + if r == c { WHITE_M * WHITE_M } else { 0.0 }
        });
        let factor = covariance.cholesky().unwrap();
        // What other columns leave of a column, and its coefficient on each of them.
        let beside = |column: &DVector<f64>, others: &[&DVector<f64>]| {
            let others =
                DMatrix::from_columns(&others.iter().map(|other| (*other).clone()).collect::<Vec<_>>());
            let weighted = factor.solve(&others).transpose();
            let shares = (&weighted * &others).lu().solve(&(&weighted * column)).unwrap();
            (column - &others * &shares, shares)
        };
        let column = |of: &dyn Fn(u32) -> f64| DVector::from_iterator(n, (0..BLOCKS).map(of));
        let (one, fast, added) = (column(&|_| 1.0), column(&kept), column(&slow));
        let residual = 3.0 * &fast + 0.2 * &added;
        let put = beside(&residual, &[&one, &fast]).1[1];
        let effect = put * beside(&fast, &[&one]).0;
        let direction = beside(&added, &[&one, &fast]).0;
        let whitened = |column: &DVector<f64>| factor.l().solve_lower_triangular(column).unwrap();
        let (white_effect, white_direction) = (whitened(&effect), whitened(&direction));
        let weights = factor.solve(&direction);
        let (mut expected, mut by_whitened) = (0.0, 0.0);
        for part in 0..PARTS {
            let squares = |column: &DVector<f64>| column.rows(part * n / PARTS, n / PARTS).norm_squared();
            let bound = squares(&white_effect) * squares(&white_direction);
            by_whitened += bound;
            expected += bound.min(squares(&effect) * squares(&weights));
        }
        let length = white_direction.norm_squared();
        assert!(expected < 0.1 * by_whitened);
        assert_is(beside_wander(WANDER_M, BARO, kept, slow), expected / length);
        // Without a wander, metres and whitened squares are equivalent.
        assert!(towards(BARO, kept, slow) > 0.9 * squares(BLOCKS) / 10.0);
    }
}
