//! The Kalman filter in UD-factorised form: `P = U D U^T`, U unit upper triangular, D diagonal.
//!
//! Measurements are taken one scalar at a time (G. J. Bierman, "Factorization Methods for Discrete
//! Sequential Estimation", Academic Press 1977, ch. V): the only divisor is the scalar innovation
//! variance, there is no square root, and D stays positive whatever the rounding.
//!
//! # Shape
//! The states are a *head* of `HEAD` states and a *tail* of `TAIL` states, in that order. Given the tail,
//! head states are independent of each other: their block of U is the identity and is not stored. That holds
//! for sensor biases as long as each measurement touches one of them and the tail gets no process noise; it
//! makes the paper's problem (three biases, the altitude last) cheap. A filter without such structure has
//! `HEAD = 0`; eqs 4 to 8 in full generality are its [`UdFilter::propagate`] and [`whitening::Whitening`].
//!
//! # Compensated state
//! Each update changes a small `step`; [`UdFilter::fold`] adds the steps of a tick to the state and keeps the
//! rounding error of the addition (Kahan), so that gains of one part in millions still change the state.

mod columns;
mod covariance;
mod factorise;
mod time_update;
pub mod whitening;

use crate::error::FilterError;

/// The row of H for one scalar measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const TAIL: usize> {
    /// The single head state in the measurement, with coefficient 1.
    pub head: Option<usize>,
    /// Coefficients of the tail states.
    pub tail: [f32; TAIL],
    /// The first tail state whose coefficient may be nonzero; all coefficients before it are zero.
    pub first: usize,
}

/// Variance of one scalar measurement: positive and finite, checked once, here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseVariance(f32);

impl NoiseVariance {
    /// A variance, in the measurement's unit squared.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`], [`FilterError::NotPositive`].
    pub fn new(variance: f32) -> Result<Self, FilterError> {
        if !variance.is_finite() {
            Err(FilterError::NotFinite)
        } else if variance <= 0.0 {
            Err(FilterError::NotPositive)
        } else {
            Ok(Self(variance))
        }
    }

    /// The variance.
    #[must_use]
    pub const fn get(self) -> f32 {
        self.0
    }
}

/// Largest innovation before a measurement is an outlier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// Largest normalised innovation squared.
    pub limit: f32,
    /// Part of the innovation's variance that exceeds one measurement's own error: correlated noise is
    /// weighted as larger white noise, but an innovation is judged by the error of one measurement.
    pub excess: f32,
    /// A measurement within the gate is also only judged and changes nothing.
    pub only_judges: bool,
}

impl Gate {
    /// Whether an innovation is within the gate: the comparison of the quotient without a division.
    #[inline(always)]
    pub(crate) fn admits(&self, innovation: &Innovation) -> bool {
        innovation.value * innovation.value <= self.limit * (innovation.variance - self.excess)
    }
}

/// Result of a scalar update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Measurement minus its prediction.
    pub value: f32,
    /// Variance of the innovation under the filter: `H P H^T + R`.
    pub variance: f32,
}

impl Innovation {
    /// Normalised innovation squared: chi-square with one degree of freedom if the model holds.
    #[must_use]
    pub fn nis(&self) -> f32 {
        self.value * self.value / self.variance
    }
}

/// A Kalman filter of `HEAD + TAIL` states; see the module's documentation.
#[derive(Clone, Debug, PartialEq)]
pub struct UdFilter<const HEAD: usize, const TAIL: usize> {
    head_state: [f32; HEAD],
    tail_state: [f32; TAIL],
    /// Steps not yet folded, with the rounding errors of earlier folds.
    head_step: [f32; HEAD],
    tail_step: [f32; TAIL],
    head_d: [f32; HEAD],
    tail_d: [f32; TAIL],
    /// Rows of U of the head states, tail columns.
    cross: [[f32; TAIL]; HEAD],
    /// Rows of U of the tail states; only the strict upper triangle is used.
    factor: [[f32; TAIL]; TAIL],
}

impl<const HEAD: usize, const TAIL: usize> UdFilter<HEAD, TAIL> {
    /// A filter with uncorrelated states.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`] for a state or variance that is not finite, [`FilterError::NotPositive`]
    /// for a negative variance. A variance of zero is a state known exactly.
    pub fn new(
        head: [f32; HEAD],
        head_variance: [f32; HEAD],
        tail: [f32; TAIL],
        tail_variance: [f32; TAIL],
    ) -> Result<Self, FilterError> {
        let mut values = head.iter().chain(&tail);
        let mut variances = head_variance.iter().chain(&tail_variance);
        if !values.all(|x| x.is_finite()) || !variances.clone().all(|d| d.is_finite()) {
            return Err(FilterError::NotFinite);
        }
        if variances.any(|&d| d < 0.0) {
            return Err(FilterError::NotPositive);
        }
        Ok(Self {
            head_state: head,
            tail_state: tail,
            head_step: [0.0; HEAD],
            tail_step: [0.0; TAIL],
            head_d: head_variance,
            tail_d: tail_variance,
            cross: [[0.0; TAIL]; HEAD],
            factor: [[0.0; TAIL]; TAIL],
        })
    }

    /// [`Self::new`] with all states at zero, for constants: the caller must write variances that are finite
    /// and not negative.
    pub(crate) const fn at_zero(head_variance: [f32; HEAD], tail_variance: [f32; TAIL]) -> Self {
        Self {
            head_state: [0.0; HEAD],
            tail_state: [0.0; TAIL],
            head_step: [0.0; HEAD],
            tail_step: [0.0; TAIL],
            head_d: head_variance,
            tail_d: tail_variance,
            cross: [[0.0; TAIL]; HEAD],
            factor: [[0.0; TAIL]; TAIL],
        }
    }

    /// Takes one scalar measurement (eqs 6 to 8, one row of H at a time; Bierman's update).
    ///
    /// `row` gives `y = x_head + tail . x_tail + v`, `noise` the variance of v. The state's new value is
    /// visible after [`Self::fold`]; later updates before that already use it.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`] if the measurement or row is not finite or overflows,
    /// [`FilterError::Shape`] if the row names a state that does not exist. The filter is then unchanged.
    #[inline(always)]
    pub fn update(
        &mut self,
        row: &Row<TAIL>,
        measurement: f32,
        noise: NoiseVariance,
    ) -> Result<Innovation, FilterError> {
        self.take::<true>(row, measurement, noise, None)
    }

    /// [`Self::update`] of a measurement that is refused beyond the gate ([`FilterError::Gated`]). If it is
    /// not `CHECKED`, numbers that are not finite pass; the caller detects them afterwards with
    /// [`Self::is_finite_after`] and discards the filter.
    #[inline(always)]
    pub(crate) fn take<const CHECKED: bool>(
        &mut self,
        row: &Row<TAIL>,
        measurement: f32,
        noise: NoiseVariance,
        gate: Option<Gate>,
    ) -> Result<Innovation, FilterError> {
        let (first, head) = (row.first, row.head);
        if first >= TAIL || head.is_some_and(|i| i >= HEAD) {
            return Err(FilterError::Shape);
        }
        let last = TAIL - 1;

        // Reads only: f = U^T h, the running innovation variance alpha, and the innovation. Nothing is
        // written before the last of them is known to be finite.
        let mut value = measurement;
        let mut head_alpha = noise.0;
        if let Some(i) = head {
            value -= self.head_state[i];
            value -= self.head_step[i];
            head_alpha += self.head_d[i];
        }
        let mut f = [0.0; TAIL];
        let mut v = [0.0; TAIL];
        let mut alpha = [0.0; TAIL];
        let mut variance = head_alpha;
        for j in first..TAIL {
            let mut sum = row.tail[j];
            if let Some(i) = head {
                sum += self.cross[i][j];
            }
            for k in first..j {
                sum += row.tail[k] * self.factor[k][j];
            }
            f[j] = sum;
            v[j] = self.tail_d[j] * sum;
            variance += v[j] * sum;
            alpha[j] = variance;
            value -= row.tail[j] * self.tail_state[j];
        }
        for j in first..TAIL {
            value -= row.tail[j] * self.tail_step[j];
        }
        // D >= 0 and the noise is positive, so the variance is at least the noise: it can only fail by being
        // NaN or infinite. The sum is finite only if both are.
        let is_finite = value.abs() + variance <= f32::MAX;
        if CHECKED && !is_finite {
            return Err(FilterError::NotFinite);
        }
        let innovation = Innovation { value, variance };
        if let Some(gate) = gate {
            if !gate.admits(&innovation) {
                return Err(FilterError::Gated { above: value > 0.0 });
            }
            if gate.only_judges {
                return Ok(innovation);
            }
        }
        let inverse_variance = 1.0 / variance;
        let weighted = value * inverse_variance;

        // Writes: D, U, and the unnormalised gain, column by column. The last column's part of the gain goes
        // directly into the step, because no later column needs it.
        let mut head_gain = [0.0; HEAD];
        let mut tail_gain = [0.0; TAIL];
        let mut before = head_alpha;
        let mut inverse = 0.0;
        if let Some(i) = head {
            inverse = 1.0 / head_alpha;
            head_gain[i] = self.head_d[i];
            self.head_d[i] *= noise.0 * inverse;
        }
        for j in first..last {
            // In the first column only the measured head state has a gain yet; rows without one keep their U.
            let lambda = -f[j] * inverse;
            for m in 0..HEAD {
                let old = self.cross[m][j];
                if j > first || head == Some(m) {
                    self.cross[m][j] = old + lambda * head_gain[m];
                    head_gain[m] += v[j] * old;
                } else {
                    head_gain[m] = v[j] * old;
                }
            }
            for k in 0..j {
                let old = self.factor[k][j];
                if j > first {
                    self.factor[k][j] = old + lambda * tail_gain[k];
                    tail_gain[k] += v[j] * old;
                } else {
                    tail_gain[k] = v[j] * old;
                }
            }
            tail_gain[j] = v[j];
            inverse = 1.0 / alpha[j];
            self.tail_d[j] *= before * inverse;
            before = alpha[j];
        }
        let lambda = -f[last] * inverse;
        let last_step = v[last] * weighted;
        for m in 0..HEAD {
            let old = self.cross[m][last];
            if last > first || head == Some(m) {
                self.cross[m][last] = old + lambda * head_gain[m];
                self.head_step[m] += head_gain[m] * weighted;
            }
            self.head_step[m] += old * last_step;
        }
        for k in 0..last {
            let old = self.factor[k][last];
            if last > first {
                self.factor[k][last] = old + lambda * tail_gain[k];
                self.tail_step[k] += tail_gain[k] * weighted;
            }
            self.tail_step[k] += old * last_step;
        }
        self.tail_step[last] += last_step;
        self.tail_d[last] *= before * inverse_variance;
        Ok(innovation)
    }

    /// Whether unchecked updates with innovation variances that add up to `variances`, and a fold after them,
    /// used finite numbers only: an innovation that is not finite reaches the last state whatever its gain (0
    /// times infinity is NaN), and the state never recovers.
    #[inline(always)]
    pub(crate) fn is_finite_after(&self, variances: f32) -> bool {
        self.tail_state.last().is_some_and(|state| state.abs() + variances <= f32::MAX)
    }

    /// Adds the pending steps to the state and keeps the rounding errors for the next fold.
    ///
    /// Called once a tick; updates and [`Self::shift_tail`] leave their steps pending until then.
    #[inline(always)]
    pub fn fold(&mut self) {
        for (state, step) in self.head_state.iter_mut().zip(&mut self.head_step) {
            fold_one(state, step);
        }
        for (state, step) in self.tail_state.iter_mut().zip(&mut self.tail_step) {
            fold_one(state, step);
        }
    }

    /// Head states; the rounding error of the last fold is below their resolution.
    #[must_use]
    pub const fn head(&self) -> &[f32; HEAD] {
        &self.head_state
    }

    /// Tail states; see [`Self::head`].
    #[must_use]
    pub const fn tail(&self) -> &[f32; TAIL] {
        &self.tail_state
    }

    /// Pending steps of tail states; right after [`Self::fold`], its rounding errors.
    pub(crate) const fn pending_tail(&self) -> &[f32; TAIL] {
        &self.tail_step
    }

    /// Moves a tail state by a known amount (`B u` of eq. 4). Pending until [`Self::fold`].
    ///
    /// # Errors
    /// [`FilterError::NotFinite`].
    pub fn shift_tail(&mut self, index: usize, amount: f32) -> Result<(), FilterError> {
        match self.tail_step.get_mut(index) {
            Some(step) if amount.is_finite() => {
                *step += amount;
                Ok(())
            }
            Some(_) => Err(FilterError::NotFinite),
            None => Err(FilterError::Shape),
        }
    }
}

/// Kahan's addition: `state + step`, with the rounding error left in `step`.
#[inline(always)]
fn fold_one(state: &mut f32, step: &mut f32) {
    let sum = *state + *step;
    *step -= sum - *state;
    *state = sum;
}

#[cfg(test)]
mod tests;
