//! minikalman, set up for `no_std` as its documentation recommends: its macros make the buffers.

use minikalman::prelude::*;
use minikalman::regular::{RegularKalmanBuilder, RegularObservationBuilder};

use crate::problem::{COVARIANCE, Filter, NOISE, OBSERVATION, STATE};

/// The filter and its observations, `ROWS` measurements each.
struct Minikalman<F, O, const ROWS: usize, const TIMES: usize> {
    filter: F,
    observations: [O; TIMES],
}

/// The observation model of `$rows` measurements, starting at `$first`.
macro_rules! observation {
    ($rows:literal, $first:expr) => {{
        impl_buffer_H!(mut h, $rows, 4, f32, 0.0);
        impl_buffer_R!(mut r, $rows, f32, 0.0);
        impl_buffer_z!(z, $rows, f32, 0.0);
        impl_buffer_y!(y, $rows, f32, 0.0);
        impl_buffer_S!(s, $rows, f32, 0.0);
        impl_buffer_K!(k, 4, $rows, f32, 0.0);
        impl_buffer_temp_S_inv!(s_inverse, $rows, f32, 0.0);
        impl_buffer_temp_HP!(hp, $rows, 4, f32, 0.0);
        impl_buffer_temp_PHt!(pht, 4, $rows, f32, 0.0);
        impl_buffer_temp_KHP!(khp, 4, f32, 0.0);
        for row in 0..$rows {
            r.as_matrix_mut().set_at(row, row, NOISE[$first + row]);
            for column in 0..4 {
                h.as_matrix_mut().set_at(row, column, OBSERVATION[$first + row][column]);
            }
        }
        RegularObservationBuilder::new::<4, $rows, f32>(h, z, r, y, s, k, s_inverse, hp, pht, khp)
    }};
}

/// The filter with its prior.
macro_rules! filter {
    () => {{
        impl_buffer_x!(mut x, 4, f32, 0.0);
        impl_buffer_A!(mut a, 4, f32, 0.0);
        impl_buffer_P!(mut p, 4, f32, 0.0);
        impl_buffer_Q_direct!(q, 4, f32, 0.0);
        impl_buffer_temp_x!(x_next, 4, f32, 0.0);
        impl_buffer_temp_P!(p_next, 4, f32, 0.0);
        for row in 0..4 {
            x.as_matrix_mut().set_at(row, 0, STATE[row]);
            a.as_matrix_mut().set_at(row, row, 1.0);
            p.as_matrix_mut().set_at(row, row, COVARIANCE[row]);
        }
        RegularKalmanBuilder::new::<4, f32>(a, x, p, q, x_next, p_next)
    }};
}

/// Four scalar updates a tick.
pub fn scalar() -> impl Filter {
    let observations = [observation!(1, 0), observation!(1, 1), observation!(1, 2), observation!(1, 3)];
    Minikalman::<_, _, 1, 4> { filter: filter!(), observations }
}

/// One update of a 4-vector a tick.
pub fn vector() -> impl Filter {
    Minikalman::<_, _, 4, 1> { filter: filter!(), observations: [observation!(4, 0)] }
}

impl<F, O, const ROWS: usize, const TIMES: usize> Filter for Minikalman<F, O, ROWS, TIMES>
where
    F: KalmanFilterUpdate<4, f32> + KalmanFilterStateVector<4, f32> + KalmanFilterEstimateCovariance<4, f32>,
    O: KalmanFilterObservationCorrectFilter<4, f32> + KalmanFilterObservationVectorMut<ROWS, f32>,
{
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        for (observation, values) in self.observations.iter_mut().zip(measurements.chunks_exact(ROWS)) {
            observation.measurement_vector_mut().as_matrix_mut().apply(|z| {
                for (row, value) in values.iter().enumerate() {
                    z.set_at(row, 0, *value);
                }
            });
            self.filter.correct(observation);
        }
    }

    fn state(&self) -> [f32; 4] {
        let x = self.filter.state_vector().as_matrix();
        core::array::from_fn(|row| x.get_at(row, 0))
    }

    fn variances(&self) -> [f32; 4] {
        let p = self.filter.estimate_covariance().as_matrix();
        core::array::from_fn(|row| p.get_at(row, row))
    }
}
