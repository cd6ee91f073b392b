//! Scores many columns at once under a fixed noise: what each would gain in twice the log likelihood, alone
//! with what is known.

use executor::Executor;
use kf_core::sensor::SENSORS;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::diagnose::parts::{BySensor, LANES, Noise, Problem, whiten_by_groups};

/// Number of columns that are whitened in one pass.
const CHUNK: usize = 64;
/// A column whose projection keeps less than this share of its square is already known.
const COLLINEAR: f64 = 1e-6;

/// Which residuals a law acts on, and with what sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// One sensor.
    Sensor(usize),
    /// The reference, and so, with the opposite sign, all sensors.
    Reference,
}

impl Subject {
    /// A block's values by sensor.
    #[must_use]
    pub fn spread(self, value: f64) -> BySensor {
        match self {
            Self::Sensor(sensor) => std::array::from_fn(|i| if i == sensor { value } else { 0.0 }),
            Self::Reference => [-value; SENSORS],
        }
    }
}

/// The score of one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Its gain in twice the log likelihood.
    pub gain: f64,
    /// Its information: the inverse of the variance of its coefficient.
    pub information: f64,
}

/// Column of one candidate by flight and block.
pub type Column = Vec<Vec<f64>>;

/// Number of stretches of free flight that are left out in turn when a law's length is chosen. Ten is usual
/// in cross-validation: with fewer, the laws of the rest differ too much from those of all (Hastie,
/// Tibshirani and Friedman, "The Elements of Statistical Learning", 2009, 7.10).
pub const STRETCHES: usize = 10;

/// Score and information of one column by stretch of free flight; captive flight comes last.
pub type ByStretch = [[f64; 2]; STRETCHES + 1];

/// What is known and already whitened: the residuals, biases, and the effects estimated with a law.
pub struct Screen<'a> {
    problem: &'a Problem<'a>,
    noise: Noise,
    picks: Vec<usize>,
    subject: Subject,
    /// For each flight: its own columns that have readings, the factor of their products, and their products
    /// with residual and picks.
    flights: Vec<Own>,
    /// Factor of the picks' products, and their products with the residual.
    common: Option<(Cholesky<f64, Dyn>, DVector<f64>)>,
}

struct Own {
    present: Vec<usize>,
    factor: Option<Cholesky<f64, Dyn>>,
    /// The own columns' products with the residual and the picks, multiplied by the inverse of their own
    /// products.
    solved: DMatrix<f64>,
}

/// Products of the known columns (the residual first) and of candidates over some blocks.
#[derive(Clone)]
struct StretchProducts {
    known: usize,
    made: usize,
    base: Vec<f64>,
    crosses: Vec<f64>,
    squares: Vec<f64>,
}

impl StretchProducts {
    fn new(known: usize, made: usize) -> Self {
        Self {
            known,
            made,
            base: vec![0.0; known * known],
            crosses: vec![0.0; known * made],
            squares: vec![0.0; made],
        }
    }

    fn add(&mut self, known: &[f64], made: &[f64]) {
        for (b, value) in known.iter().enumerate() {
            for (sum, other) in self.base[b * self.known..].iter_mut().zip(known) {
                *sum += value * other;
            }
            for (sum, other) in self.crosses[b * self.made..].iter_mut().zip(made) {
                *sum += value * other;
            }
        }
        for (sum, value) in self.squares.iter_mut().zip(made) {
            *sum += value * value;
        }
    }

    fn base(&self, b: usize, c: usize) -> f64 {
        self.base[b * self.known + c]
    }

    fn cross(&self, b: usize, made: usize) -> f64 {
        self.crosses[b * self.made + made]
    }

    fn square(&self, made: usize) -> f64 {
        self.squares[made]
    }
}

/// Judges each column of a chunk.
type Judge<'a, T> = dyn Fn(&[Option<Column>]) -> Vec<Option<T>> + Sync + 'a;

/// Results of `judge` for the columns that `column` makes, in order; the executor processes one chunk at a
/// time.
fn by_chunks<T: Clone + Send>(
    columns: usize,
    column: &(dyn Fn(usize) -> Option<Column> + Sync),
    executor: &dyn Executor,
    judge: &Judge<'_, T>,
) -> Vec<Option<T>> {
    let jobs = (0..columns.div_ceil(CHUNK)).map(|chunk| {
        move || {
            let made: Vec<Option<Column>> =
                (chunk * CHUNK..columns.min((chunk + 1) * CHUNK)).map(column).collect();
            judge(&made)
        }
    });
    executor::map(executor, jobs).concat()
}

impl<'a> Screen<'a> {
    /// With the effects of `picks`, under a noise, for laws on a subject.
    #[must_use]
    pub fn new(problem: &'a Problem<'a>, noise: Noise, picks: &[usize], subject: Subject) -> Self {
        let own = problem.own();
        let outer: Vec<usize> = std::iter::once(0).chain(1 + own..1 + own + picks.len()).collect();
        let n = picks.len();
        let mut sum = DMatrix::zeros(n + 1, n + 1);
        let mut flights = Vec::new();
        for flight in problem.flights {
            let products =
                problem.products(flight, &noise, &problem.columns(flight, picks), &|_| true).products;
            let present: Vec<usize> = (1..=own).filter(|b| products[(*b, *b)] > 0.0).collect();
            let factor = products.select_rows(&present).select_columns(&present).cholesky();
            let cross = products.select_rows(&present).select_columns(&outer);
            let solved = factor.as_ref().map_or_else(|| cross.clone() * 0.0, |factor| factor.solve(&cross));
            sum += products.select_rows(&outer).select_columns(&outer) - cross.tr_mul(&solved);
            flights.push(Own { present, factor, solved });
        }
        let common = (n > 0)
            .then(|| sum.view((1, 1), (n, n)).clone_owned().cholesky())
            .flatten()
            .map(|factor| (factor, sum.view((1, 0), (n, 1)).column(0).clone_owned()));
        Self { problem, noise, picks: picks.to_vec(), subject, flights, common }
    }

    /// The scores of columns that `column` makes, in order; `None` where it makes none.
    pub fn scores(
        &self,
        columns: usize,
        column: &(dyn Fn(usize) -> Option<Column> + Sync),
        executor: &dyn Executor,
    ) -> Vec<Option<Score>> {
        by_chunks(columns, column, executor, &|made| self.chunk(made))
    }

    /// The scores by stretch of columns that `column` makes, in order; what is known is subtracted using all
    /// blocks.
    pub fn by_stretch(
        &self,
        columns: usize,
        column: &(dyn Fn(usize) -> Option<Column> + Sync),
        executor: &dyn Executor,
    ) -> Vec<Option<ByStretch>> {
        by_chunks(columns, column, executor, &|made| self.stretches_of(made))
    }

    fn stretches_of(&self, made: &[Option<Column>]) -> Vec<Option<ByStretch>> {
        let n = self.picks.len();
        let residual_by_picks = self.common.as_ref().map(|(factor, residual)| factor.solve(residual));
        // The products of all blocks first: what is known is common to all stretches.
        let parts: Vec<Vec<StretchProducts>> = self
            .problem
            .flights
            .iter()
            .enumerate()
            .map(|(at, flight)| self.products_by_stretch(flight, at, made))
            .collect();
        let score = |k: usize| {
            made[k].as_ref()?;
            let mut with_picks = DVector::<f64>::zeros(n);
            let mut with_own = Vec::new();
            for (own, parts) in self.flights.iter().zip(&parts) {
                let cross = |b: usize| parts.iter().map(|part| part.cross(b, k)).sum::<f64>();
                let own_cross =
                    DVector::from_iterator(own.present.len(), own.present.iter().map(|b| cross(*b)));
                let first_pick = parts.first().map_or(0, |part| part.known) - n;
                for pick in 0..n {
                    with_picks[pick] +=
                        cross(first_pick + pick) - own_cross.dot(&own.solved.column(1 + pick));
                }
                with_own.push(own_cross);
            }
            let by_picks = self
                .common
                .as_ref()
                .map_or_else(|| DVector::zeros(n), |(factor, _)| factor.solve(&with_picks));
            let mut sums: ByStretch = [[0.0; 2]; STRETCHES + 1];
            for ((own, parts), own_cross) in self.flights.iter().zip(&parts).zip(&with_own) {
                let known = parts.first().map_or(0, |part| part.known);
                // Coefficients of the known columns in the candidate and in the residual; the residual itself
                // is column 0.
                let (mut of_law, mut of_residual) = (vec![0.0; known], vec![0.0; known]);
                let own_law = own.factor.as_ref().map(|factor| factor.solve(own_cross));
                for (at, b) in own.present.iter().enumerate() {
                    of_law[*b] = own_law.as_ref().map_or(0.0, |law| law[at]);
                    of_residual[*b] = own.solved[(at, 0)];
                    for pick in 0..n {
                        of_law[*b] -= own.solved[(at, 1 + pick)] * by_picks[pick];
                        let residual = residual_by_picks.as_ref().map_or(0.0, |values| values[pick]);
                        of_residual[*b] -= own.solved[(at, 1 + pick)] * residual;
                    }
                }
                for pick in 0..n {
                    of_law[known - n + pick] = by_picks[pick];
                    of_residual[known - n + pick] =
                        residual_by_picks.as_ref().map_or(0.0, |values| values[pick]);
                }
                for (sum, part) in sums.iter_mut().zip(parts) {
                    let (mut score, mut information) = (part.cross(0, k), part.square(k));
                    let coefficients = || of_residual.iter().zip(&of_law).enumerate().skip(1);
                    for (b, (residual, law)) in coefficients() {
                        score -= residual * part.cross(b, k) + law * part.base(0, b);
                        information -= 2.0 * law * part.cross(b, k);
                        for (c, (other_residual, other_law)) in coefficients() {
                            score += law * other_residual * part.base(b, c);
                            information += law * other_law * part.base(b, c);
                        }
                    }
                    sum[0] += score;
                    sum[1] += information;
                }
            }
            Some(sums)
        };
        (0..made.len()).map(score).collect()
    }

    /// Products of the known columns and of candidates in a flight, by stretch.
    fn products_by_stretch(
        &self,
        flight: &crate::diagnose::parts::Series,
        at: usize,
        made: &[Option<Column>],
    ) -> Vec<StretchProducts> {
        let candidates = self.candidates(at, flight.len(), made);
        let mut columns = self.problem.columns(flight, &self.picks);
        let known = columns.len();
        let zero = vec![[0.0; SENSORS]; flight.len()];
        let groups = known.div_ceil(LANES);
        columns.resize(groups * LANES, &zero);
        columns.extend(candidates.iter().map(Vec::as_slice));
        let mut parts = vec![StretchProducts::new(known, made.len()); STRETCHES + 1];
        let first_free = flight.free.iter().position(|free| *free).unwrap_or(flight.len());
        let free = flight.len() - first_free;
        whiten_by_groups(flight, &self.noise, &columns, &|_| true, &mut |block, _, row| {
            let stretch = match block.checked_sub(first_free) {
                Some(since) => (since * STRETCHES / free.max(1)).min(STRETCHES - 1),
                None => STRETCHES,
            };
            let (base, candidates) = row.split_at(groups);
            parts[stretch].add(&base.as_flattened()[..known], &candidates.as_flattened()[..made.len()]);
        });
        parts
    }

    fn candidates(&self, at: usize, blocks: usize, made: &[Option<Column>]) -> Vec<Vec<BySensor>> {
        made.iter()
            .map(|column| match column.as_ref().and_then(|column| column.get(at)) {
                Some(column) => column.iter().map(|value| self.subject.spread(*value)).collect(),
                None => vec![[0.0; SENSORS]; blocks],
            })
            .collect()
    }

    fn chunk(&self, made: &[Option<Column>]) -> Vec<Option<Score>> {
        let n = self.picks.len();
        // For each candidate over all flights: its square, its product with the residual and those with the
        // picks.
        let mut sums = vec![DVector::<f64>::zeros(n + 2); made.len()];
        let mut raw = vec![0.0; made.len()];
        for (at, (flight, own)) in self.problem.flights.iter().zip(&self.flights).enumerate() {
            let candidates = self.candidates(at, flight.len(), made);
            let mut columns = self.problem.columns(flight, &self.picks);
            let known = columns.len();
            let zero = vec![[0.0; SENSORS]; flight.len()];
            // Candidates begin with a group of their own.
            let groups = known.div_ceil(LANES);
            columns.resize(groups * LANES, &zero);
            columns.extend(candidates.iter().map(Vec::as_slice));
            let own_groups = candidates.len().div_ceil(LANES);
            let mut crosses = vec![[[0.0_f64; LANES]; CHUNK / LANES]; known];
            let mut squares = [[0.0_f64; LANES]; CHUNK / LANES];
            whiten_by_groups(flight, &self.noise, &columns, &|_| true, &mut |_, _, row| {
                let (base, candidates) = row.split_at(groups);
                for (base, crosses) in base.as_flattened().iter().zip(&mut crosses) {
                    for (cross, values) in crosses.iter_mut().zip(candidates) {
                        for (cross, value) in cross.iter_mut().zip(values) {
                            *cross += base * value;
                        }
                    }
                }
                for (square, values) in squares.iter_mut().zip(candidates) {
                    for (square, value) in square.iter_mut().zip(values) {
                        *square += value * value;
                    }
                }
            });
            debug_assert!(own_groups <= CHUNK / LANES);
            let first_pick = known - n;
            for k in 0..made.len() {
                let cross = |b: usize| crosses[b][k / LANES][k % LANES];
                let with_own =
                    DVector::from_iterator(own.present.len(), own.present.iter().map(|b| cross(*b)));
                let square = squares[k / LANES][k % LANES];
                raw[k] += square;
                let taken = own.factor.as_ref().map_or(0.0, |factor| with_own.dot(&factor.solve(&with_own)));
                let sum = &mut sums[k];
                sum[0] += square - taken;
                sum[1] += cross(0) - with_own.dot(&own.solved.column(0));
                for pick in 0..n {
                    sum[2 + pick] += cross(first_pick + pick) - with_own.dot(&own.solved.column(1 + pick));
                }
            }
        }
        let score = |(k, sum): (usize, &DVector<f64>)| {
            made[k].as_ref()?;
            let (mut information, mut product) = (sum[0], sum[1]);
            if let Some((factor, residual)) = &self.common {
                let with_picks = sum.rows(2, n).clone_owned();
                let solved = factor.solve(&with_picks);
                information -= solved.dot(&with_picks);
                product -= solved.dot(residual);
            }
            let is_new = information.is_finite() && information > COLLINEAR * raw[k] && raw[k] > 0.0;
            is_new.then(|| Score { gain: product * product / information, information })
        };
        sums.iter().enumerate().map(score).collect()
    }
}

#[cfg(test)]
mod tests {
    use executor::Inline;

    use super::*;
    use crate::discover::small_flights::{BARO, WHITE, WHITE_M, flight, noise, problem};

    /// The remainder of a column after a fit of others.
    fn rest(target: &[f64], columns: &[Vec<f64>]) -> DVector<f64> {
        let target = DVector::from_column_slice(target);
        let matrix = DMatrix::from_fn(target.len(), columns.len(), |row, column| columns[column][row]);
        let solved = matrix.clone().svd(true, true).solve(&target, 1e-12).unwrap();
        target - matrix * solved
    }

    /// Least squares of some columns: the remaining square of the residual, and the last column's own square
    /// after the others are projected out.
    fn least_squares(residual: &[f64], columns: &[Vec<f64>]) -> (f64, f64) {
        let rest = |target: &[f64], columns: &[Vec<f64>]| rest(target, columns).norm_squared();
        let (last, others) = columns.split_last().unwrap();
        (rest(residual, others) - rest(residual, columns), rest(last, others))
    }

    /// Two flights of different lengths and biases in which a known effect and a law act, with the columns of
    /// the law and of two others.
    fn flights() -> (Vec<crate::diagnose::parts::Series>, Vec<Column>) {
        let mut random = noise(5);
        let mut made = Vec::new();
        let mut columns = vec![Column::new(); 3];
        for (count, bias_m) in [(90, 7.0), (150, -3.0)] {
            let known: Vec<f64> = (0..count).map(|k| libm::sin(0.11 * f64::from(k))).collect();
            let law: Vec<f64> = (0..count).map(|k| libm::cos(0.07 * f64::from(k)) + 0.3 * random()).collect();
            let other: Vec<f64> = (0..count).map(|_| random()).collect();
            let errors: Vec<f64> = known
                .iter()
                .zip(&law)
                .map(|(known, law)| bias_m + 2.0 * known + 0.8 * law + 0.5 * random())
                .collect();
            made.push(flight(&errors, &[&known]));
            columns[2].push(known.iter().map(|value| 3.0 * value + 1.0).collect());
            columns[0].push(law);
            columns[1].push(other);
        }
        (made, columns)
    }

    /// The sums of a law's score and information over the stretches.
    fn sum(stretches: &ByStretch) -> [f64; 2] {
        [0, 1].map(|k| stretches.iter().map(|stretch| stretch[k]).sum())
    }

    /// Under white noise a column gains the reduction of the sum of squares, with a bias in each flight and
    /// the known effects included, over the noise's variance; its information is what is left of its own
    /// square. The stretches add up to both. A column that is a known one plus a bias adds nothing new.
    #[test]
    fn a_score_is_what_a_column_takes_off_the_squares() {
        let (flights, columns) = flights();
        let problem = problem(&flights);
        let residual: Vec<f64> =
            flights.iter().flat_map(|flight| flight.residual_m.iter().map(|errors| errors[BARO])).collect();
        for picks in [&[0][..], &[]] {
            let screen = Screen::new(&problem, WHITE, picks, Subject::Sensor(BARO));
            let made = |k: usize| columns.get(k).cloned();
            let scores = screen.scores(4, &made, &Inline);
            let by_stretch = screen.by_stretch(4, &made, &Inline);
            assert!(scores[3].is_none() && by_stretch[3].is_none(), "no column is made of the fourth");
            assert_eq!(scores[2].is_none(), !picks.is_empty(), "it is the known one");
            for k in [0, 1] {
                let ends = [0, flights[0].len(), residual.len()];
                let bias = |flight: usize| -> Vec<f64> {
                    (0..residual.len())
                        .map(|at| f64::from(u8::from((ends[flight]..ends[flight + 1]).contains(&at))))
                        .collect()
                };
                let mut all = vec![bias(0), bias(1)];
                if !picks.is_empty() {
                    all.push(
                        flights
                            .iter()
                            .flat_map(|flight| flight.columns[0].iter().map(|column| column[BARO]))
                            .collect(),
                    );
                }
                all.push(columns[k].concat());
                let (gain, information) = least_squares(&residual, &all);
                let score = scores[k].unwrap();
                let variance = WHITE_M * WHITE_M;
                // Rounding of a few hundred products.
                assert!((score.gain * variance / gain - 1.0).abs() < 1e-6, "{k} {score:?} {gain}");
                assert!((score.information * variance / information - 1.0).abs() < 1e-6, "{k} {score:?}");
                let [product, whole] = sum(by_stretch[k].as_ref().unwrap());
                assert!((product * product / whole / score.gain - 1.0).abs() < 1e-6, "{k} {product}");
                assert!((whole / score.information - 1.0).abs() < 1e-6, "{k} {whole}");
                // In a stretch it is the products of the remainders of both there.
                let (law, others) = all.split_last().unwrap();
                let (left, own) = (rest(&residual, others), rest(law, others));
                let is_in = |at: usize, stretch: usize| {
                    let (flight, block) = if at < ends[1] { (0, at) } else { (1, at - ends[1]) };
                    let count = ends[flight + 1] - ends[flight];
                    let since = block.checked_sub(count / 3);
                    since.map_or(STRETCHES, |since| since * STRETCHES / (count - count / 3)) == stretch
                };
                for stretch in 0..=STRETCHES {
                    let there = || (0..residual.len()).filter(|at| is_in(*at, stretch));
                    let product: f64 = there().map(|at| left[at] * own[at]).sum();
                    let square: f64 = there().map(|at| own[at] * own[at]).sum();
                    let [found_product, found_square] = by_stretch[k].as_ref().unwrap()[stretch];
                    assert!((found_product * variance - product).abs() < 1e-6 * gain.sqrt(), "{k} {stretch}");
                    assert!((found_square * variance - square).abs() < 1e-6 * information, "{k} {stretch}");
                }
            }
        }
    }

    /// Free flight is ten stretches of equal length, captive flight is the last: a column that alternates in
    /// one tenth, which no bias explains, has its information there alone.
    #[test]
    fn a_stretch_is_a_tenth_of_free_flight() {
        let mut random = noise(9);
        let errors: Vec<f64> = (0..300).map(|_| random()).collect();
        let flights = [flight(&errors, &[])];
        let problem = problem(&flights);
        let screen = Screen::new(&problem, WHITE, &[], Subject::Sensor(BARO));
        for stretch in 0..=STRETCHES {
            let blocks = if stretch == STRETCHES { 0..100 } else { 100 + 20 * stretch..120 + 20 * stretch };
            let column = |at: usize| {
                let sign = if at.is_multiple_of(2) { 1.0 } else { -1.0 };
                if blocks.contains(&at) { sign } else { 0.0 }
            };
            let made = vec![(0..300).map(column).collect::<Vec<f64>>()];
            let found = screen.by_stretch(1, &|_| Some(made.clone()), &Inline)[0].unwrap();
            let wanted = blocks.len() as f64 / (WHITE_M * WHITE_M);
            for (at, [_, information]) in found.into_iter().enumerate() {
                let own = if at == stretch { wanted } else { 0.0 };
                assert!((information - own).abs() < 1e-6 * wanted, "{stretch} {at} {information}");
            }
        }
    }

    /// A law on the reference is in all sensors' residuals with the opposite sign; one on a sensor only in
    /// that one's.
    #[test]
    fn a_subject_says_where_a_law_acts() {
        assert_eq!(Subject::Reference.spread(2.0), [-2.0; SENSORS]);
        let spread = Subject::Sensor(BARO).spread(2.0);
        assert_eq!((spread[BARO], spread.iter().sum::<f64>()), (2.0, 2.0));
    }

    /// More columns than a chunk holds come out in their order.
    #[test]
    fn chunks_keep_the_order() {
        let (flights, columns) = flights();
        let problem = problem(&flights);
        let screen = Screen::new(&problem, WHITE, &[0], Subject::Sensor(BARO));
        let count = 2 * CHUNK + 3;
        let scores = screen.scores(count, &|k| columns.get(usize::from(k % 5 == 0)).cloned(), &Inline);
        assert_eq!(scores.len(), count);
        for (k, score) in scores.iter().enumerate() {
            assert_eq!(score, &scores[usize::from(k % 5 != 0)], "{k}");
        }
    }
}
