//! Time updates: eqs 4 and 5.

use super::UdFilter;
use crate::error::FilterError;

impl<const HEAD: usize, const TAIL: usize> UdFilter<HEAD, TAIL> {
    /// Adds process noise of this variance to one head state.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`], [`FilterError::NotPositive`] for a negative variance,
    /// [`FilterError::Shape`] if there is no such state.
    pub fn add_head_noise(&mut self, index: usize, variance: f32) -> Result<(), FilterError> {
        check_variance(variance)?;
        let d = self.head_d.get_mut(index).ok_or(FilterError::Shape)?;
        let sum = *d + variance;
        if !sum.is_finite() {
            return Err(FilterError::NotFinite);
        }
        *d = sum;
        Ok(())
    }

    /// Adds process noise of this variance to one tail state (rank-one update of Agee and Turner; Bierman
    /// 1977, ch. III.7). For one direction at a time this is eq. 5 with A = I.
    ///
    /// # Errors
    /// As [`Self::add_head_noise`]; [`FilterError::Shape`] also if there are head states, because noise on
    /// the tail would couple them.
    pub fn add_tail_noise(&mut self, index: usize, variance: f32) -> Result<(), FilterError> {
        check_variance(variance)?;
        if HEAD > 0 || index >= TAIL {
            return Err(FilterError::Shape);
        }
        if variance == 0.0 {
            return Ok(());
        }
        // An overflow of any D is refused before anything is written: no D grows by more than this.
        if !(self.variance(HEAD + index) + variance).is_finite() {
            return Err(FilterError::NotFinite);
        }
        let mut direction = [0.0_f32; TAIL];
        direction[index] = 1.0;
        let mut weight = variance;
        for j in (0..=index).rev() {
            let a = direction[j];
            let old = self.tail_d[j];
            let new = old + weight * a * a;
            if new <= 0.0 {
                // A state known exactly, in a direction that the noise does not affect.
                continue;
            }
            let inverse = 1.0 / new;
            let beta = weight * a * inverse;
            for (factors, part) in self.factor.iter_mut().zip(&mut direction).take(j) {
                *part -= a * factors[j];
                factors[j] += beta * *part;
            }
            weight *= old * inverse;
            self.tail_d[j] = new;
        }
        Ok(())
    }
}

impl<const N: usize> UdFilter<0, N> {
    /// The general propagation of eqs 4 and 5: `x = A x + B u`, `P = A P A^T + G Q G^T`, Q diagonal
    /// (Thornton's modified weighted Gram-Schmidt; Bierman 1977, ch. VI.4). Pending steps are propagated with
    /// the state.
    ///
    /// `transition` is A `[N x N]`, `input` is the product `B u` `[N]`, `noise_input` is G `[N x M]`,
    /// `noise_variance` the diagonal of Q `[M]`. A correlated Q is `U_q D_q U_q^T`: pass `G U_q`, D_q.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`] if any number is or becomes not finite; [`FilterError::NotPositive`] for a
    /// negative noise variance. The filter is then unchanged.
    pub fn propagate<const M: usize>(
        &mut self,
        transition: &[[f32; N]; N],
        input: &[f32; N],
        noise_input: &[[f32; M]; N],
        noise_variance: &[f32; M],
    ) -> Result<(), FilterError> {
        for &variance in noise_variance {
            check_variance(variance)?;
        }
        let mut next = self.clone();
        // Rows of W = [A U, G].
        let mut own = [[0.0; N]; N];
        let mut noise = *noise_input;
        for i in 0..N {
            let mut state = 0.0;
            let mut step = input[i];
            for j in 0..N {
                state += transition[i][j] * self.tail_state[j];
                step += transition[i][j] * self.tail_step[j];
                let mut sum = transition[i][j];
                for k in 0..j {
                    sum += transition[i][k] * self.factor[k][j];
                }
                own[i][j] = sum;
            }
            next.tail_state[i] = state;
            next.tail_step[i] = step;
        }
        for j in (0..N).rev() {
            let d = weighted_product(&own[j], &own[j], &self.tail_d)
                + weighted_product(&noise[j], &noise[j], noise_variance);
            next.tail_d[j] = d;
            for i in 0..j {
                let product = weighted_product(&own[i], &own[j], &self.tail_d)
                    + weighted_product(&noise[i], &noise[j], noise_variance);
                // d = 0: row j of W has no weight, so the state is known exactly and uncorrelated.
                let u = if d > 0.0 { product / d } else { 0.0 };
                next.factor[i][j] = u;
                for k in 0..N {
                    own[i][k] -= u * own[j][k];
                }
                for k in 0..M {
                    noise[i][k] -= u * noise[j][k];
                }
            }
        }
        let numbers = next.tail_state.iter().chain(&next.tail_step).chain(&next.tail_d);
        if !numbers.chain(next.factor.iter().flatten()).all(|x| x.is_finite()) {
            return Err(FilterError::NotFinite);
        }
        *self = next;
        Ok(())
    }

    /// The same for a unit upper triangular A without noise: every state is driven by later ones only. Then A
    /// U is the new U and D stays, which costs a sixth of the general propagation, and less with every zero.
    ///
    /// `transition` is the first `ROWS` rows of A, of which only the part right of the diagonal is read;
    /// below them A is the identity.
    ///
    /// # Errors
    /// [`FilterError::Shape`] for more rows than states. [`FilterError::NotFinite`]; the filter is then
    /// unusable, because no copy of it is kept.
    pub fn propagate_upper<const ROWS: usize>(
        &mut self,
        transition: &[[f32; N]; ROWS],
    ) -> Result<(), FilterError> {
        if ROWS > N {
            return Err(FilterError::Shape);
        }
        // Row after row: the rows below are still the old ones.
        for (i, by) in transition.iter().enumerate() {
            self.propagate_row(i, by)?;
        }
        Ok(())
    }

    /// One row of [`Self::propagate_upper`]. All rows of A one after the other, from the first on, are the
    /// whole propagation; the time between them does not matter.
    ///
    /// # Errors
    /// As there.
    pub fn propagate_row(&mut self, i: usize, by: &[f32; N]) -> Result<(), FilterError> {
        if i >= N {
            return Err(FilterError::Shape);
        }
        let (above, below) = self.factor.split_at_mut(i + 1);
        let row = &mut above[i];
        for (k, lower) in (i + 1..N).zip(&*below) {
            let a = by[k];
            if a == 0.0 {
                continue;
            }
            self.tail_state[i] += a * self.tail_state[k];
            self.tail_step[i] += a * self.tail_step[k];
            row[k] += a;
            for (new, old) in row[k + 1..].iter_mut().zip(&lower[k + 1..]) {
                *new += a * old;
            }
        }
        // Not finite if any number written is not finite.
        let sum = row[i + 1..].iter().fold(self.tail_state[i] + self.tail_step[i], |sum, new| sum + new);
        if sum.is_finite() { Ok(()) } else { Err(FilterError::NotFinite) }
    }
}

/// `sum_k a_k b_k weight_k`.
fn weighted_product(a: &[f32], b: &[f32], weight: &[f32]) -> f32 {
    a.iter().zip(b).zip(weight).map(|((a, b), w)| a * b * w).sum()
}

pub(super) fn check_variance(variance: f32) -> Result<(), FilterError> {
    if !variance.is_finite() {
        Err(FilterError::NotFinite)
    } else if variance < 0.0 {
        Err(FilterError::NotPositive)
    } else {
        Ok(())
    }
}
