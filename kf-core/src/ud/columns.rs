//! The updates of a filter without a head, each in one function for every row of H, column by column.
//!
//! The results equal, to the bit, those of [`UdFilter::take`], which is written for inlining with a constant
//! row. Here the row is not constant, but the column's number is: every inner loop has a known length and is
//! unrolled, and the values that a column needs from earlier ones stay in registers. That takes half the
//! instructions for eight states, and there is only one copy of it.

// No column precedes the first.
#![allow(clippy::absurd_extreme_comparisons, clippy::reversed_empty_ranges)]

use super::time_update::check_variance;
use super::{Gate, Innovation, NoiseVariance, Row, UdFilter};
use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::error::FilterError;
use crate::sensor::SENSORS;

/// States of the largest filter that these updates are for: biases, coefficients, altitude.
const MAX_COLUMNS: usize = SENSORS + MAX_ESTIMATED_EFFECTS + 1;
const _: () = assert!(MAX_COLUMNS == 12, "every column is named below");

/// Less than half a unit in the last place of the largest number (2^103): smaller noise makes no finite
/// variance infinite.
const LARGEST_NOISE: f32 = 5e30;

/// Does the work for each existing column, with its number as a constant.
macro_rules! upwards {
    ($column:ident, $work:block) => { each!($column, $work, 0 1 2 3 4 5 6 7 8 9 10 11) };
}
macro_rules! downwards {
    ($column:ident, $work:block) => { each!($column, $work, 11 10 9 8 7 6 5 4 3 2 1 0) };
}
macro_rules! each {
    ($column:ident, $work:block, $($number:literal)*) => {
        $({
            const $column: usize = $number;
            if $column < TAIL $work
        })*
    };
}

impl<const HEAD: usize, const TAIL: usize> UdFilter<HEAD, TAIL> {
    /// [`Self::take`], checked, without a head.
    ///
    /// # Errors
    /// As [`Self::take`].
    #[inline(never)]
    pub(crate) fn take_by_columns(
        &mut self,
        row: &Row<TAIL>,
        measurement: f32,
        noise: NoiseVariance,
        gate: Option<Gate>,
    ) -> Result<Innovation, FilterError> {
        const { assert!(TAIL > 0) };
        if HEAD > 0 || TAIL > MAX_COLUMNS || row.head.is_some() || row.first >= TAIL {
            return Err(FilterError::Shape);
        }
        let first = row.first;
        let mut f = [0.0; TAIL];
        let mut v = [0.0; TAIL];
        let mut alpha = [0.0; TAIL];
        let mut value = measurement;
        let mut variance = noise.0;
        upwards!(J, {
            if J >= first {
                let mut sum = row.tail[J];
                for k in 0..J {
                    sum += row.tail[k] * self.factor[k][J];
                }
                f[J] = sum;
                v[J] = self.tail_d[J] * sum;
                variance += v[J] * sum;
                alpha[J] = variance;
                value -= row.tail[J] * self.tail_state[J];
            }
        });
        upwards!(J, {
            value -= row.tail[J] * self.tail_step[J];
        });
        // As in `take`: the variance can only fail by being NaN or infinite.
        let is_finite = value.abs() + variance <= f32::MAX;
        if !is_finite {
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
        // Before the first column the gain is zero, so a factor multiplied with it does not change.
        let mut gain = [0.0; TAIL];
        let mut before = noise.0;
        let mut inverse = 0.0;
        upwards!(J, {
            if J >= first && J + 1 < TAIL {
                let lambda = -f[J] * inverse;
                for k in 0..J {
                    let old = self.factor[k][J];
                    self.factor[k][J] = old + lambda * gain[k];
                    gain[k] += v[J] * old;
                }
                gain[J] = v[J];
                inverse = 1.0 / alpha[J];
                self.tail_d[J] *= before * inverse;
                before = alpha[J];
            }
            if J + 1 == TAIL {
                // The last column's part of the gain goes directly into the steps: no later column needs it.
                let lambda = -f[J] * inverse;
                let last_step = v[J] * weighted;
                for k in 0..J {
                    let old = self.factor[k][J];
                    self.factor[k][J] = old + lambda * gain[k];
                    self.tail_step[k] = self.tail_step[k] + gain[k] * weighted + old * last_step;
                }
                self.tail_step[J] += last_step;
                self.tail_d[J] *= before * inverse_variance;
            }
        });
        Ok(innovation)
    }

    /// [`Self::add_tail_noise`] to the bit, except that noise that might overflow is refused by its size
    /// alone.
    ///
    /// # Errors
    /// As there; [`FilterError::NotFinite`] from [`LARGEST_NOISE`] on.
    #[inline(never)]
    #[allow(unused_assignments)] // The last column leaves a weight for none.
    pub(crate) fn diffuse_by_columns(&mut self, index: usize, variance: f32) -> Result<(), FilterError> {
        check_variance(variance)?;
        if HEAD > 0 || TAIL > MAX_COLUMNS || index >= TAIL {
            return Err(FilterError::Shape);
        }
        if variance >= LARGEST_NOISE {
            return Err(FilterError::NotFinite);
        }
        if variance == 0.0 {
            return Ok(());
        }
        let mut direction = [0.0; TAIL];
        let mut weight = variance;
        downwards!(J, {
            if J <= index {
                let a = if J == index { 1.0 } else { direction[J] };
                let old = self.tail_d[J];
                let new = old + weight * a * a;
                // Otherwise the state is known exactly, in a direction that the noise does not affect.
                if new > 0.0 {
                    let inverse = 1.0 / new;
                    let beta = weight * a * inverse;
                    for k in 0..J {
                        let factor = self.factor[k][J];
                        direction[k] -= a * factor;
                        self.factor[k][J] = factor + beta * direction[k];
                    }
                    self.tail_d[J] = new;
                    weight *= old * inverse;
                }
            }
        });
        Ok(())
    }

    /// [`Self::variance`] of every tail state, to the bit.
    #[inline(never)]
    pub(crate) fn tail_variances(&self) -> [f32; TAIL] {
        if TAIL > MAX_COLUMNS {
            return core::array::from_fn(|state| self.variance(HEAD + state));
        }
        let mut squares = [0.0; TAIL];
        upwards!(J, {
            let d = self.tail_d[J];
            for k in 0..J {
                let factor = self.factor[k][J];
                squares[k] += factor * factor * d;
            }
        });
        core::array::from_fn(|state| self.tail_d[state] + squares[state])
    }
}
