//! The estimation problem of eqs 9 to 15, with effects: its states, their units, and each measurement's row
//! of H.
//!
//! State as seen from outside: `x = [h, b_1..b_S, theta_1..theta_E]`. Stored order: biases, coefficients,
//! altitude, so that U stays sparse. Altitudes are stored as deviations from a fixed reference altitude in
//! units of [`UNIT_M`], coefficients in units that make them of the same order.

use crate::config::MissionConfig;
use crate::error::FilterError;
use crate::latch::{MAX_COVARIANCE, collected};
use crate::sensor::{SENSORS, Sensor};
use crate::ud::{Gate, Innovation, NoiseVariance, Row, UdFilter};

/// Unit of the filter's altitudes, metres: biases of tens to hundreds of metres become O(1). A power of two,
/// so that scaling does not round.
pub const UNIT_M: f32 = 64.0;

/// Why an estimator cannot be made from a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// `HEAD + TAIL` is not three biases, the estimated effects and the altitude, or `HEAD` is
    /// neither 0 nor the number of biases.
    Shape,
    /// A climb rate puts process noise on the altitude, which needs a filter with `HEAD = 0`.
    ClimbRateNeedsDenseFilter,
    /// A number is not finite, or a sigma, time or window is not positive where it must be.
    OutOfRange,
}

impl From<FilterError> for ConfigError {
    fn from(_: FilterError) -> Self {
        Self::OutOfRange
    }
}

/// The filter of the paper's problem: biases, effects' coefficients, altitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimator<const HEAD: usize, const TAIL: usize, const E: usize> {
    filter: UdFilter<HEAD, TAIL>,
    /// Origin of the stored altitudes, metres.
    origin_m: f32,
    /// Size of one unit of each stored coefficient, in the coefficient's own unit.
    coefficient_unit: [f32; E],
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Estimator<HEAD, TAIL, E> {
    const ALTITUDE: usize = TAIL.saturating_sub(1);

    /// Starts with the prior of eq. 3: `altitude_m` with `config.reference.prior_sigma_m`, biases and
    /// coefficients with theirs.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn new(config: &MissionConfig<E>, altitude_m: f32) -> Result<Self, ConfigError> {
        if (HEAD != 0 && HEAD != SENSORS) || HEAD + TAIL != SENSORS + E + 1 {
            return Err(ConfigError::Shape);
        }
        let mut state = [(0.0, 0.0); SENSORS];
        for (state, sensor) in state.iter_mut().zip(&config.sensors) {
            *state = (sensor.prior_bias_m / UNIT_M, square(sensor.prior_sigma_m / UNIT_M));
        }
        let coefficient_unit =
            config.estimated_effects.map(|effect| UNIT_M / effect.id().typical_regressor_m());
        let mut head = [0.0; HEAD];
        let mut head_variance = [0.0; HEAD];
        let mut tail = [0.0; TAIL];
        let mut tail_variance = [0.0; TAIL];
        for (i, (bias, variance)) in state.into_iter().enumerate() {
            let (values, variances) = if HEAD == 0 {
                (&mut tail[..], &mut tail_variance[..])
            } else {
                (&mut head[..], &mut head_variance[..])
            };
            set(values, i, bias);
            set(variances, i, variance);
        }
        for (j, (effect, unit)) in config.estimated_effects.iter().zip(coefficient_unit).enumerate() {
            set(&mut tail, Self::coefficient_index(j), effect.coefficient / unit);
            set(&mut tail_variance, Self::coefficient_index(j), square(effect.sigma / unit));
        }
        set(&mut tail_variance, Self::ALTITUDE, square(config.reference.prior_sigma_m / UNIT_M));
        if !altitude_m.is_finite() {
            return Err(ConfigError::OutOfRange);
        }
        let filter = UdFilter::new(head, head_variance, tail, tail_variance)?;
        Ok(Self { filter, origin_m: altitude_m, coefficient_unit })
    }

    /// Position of a coefficient in the tail.
    const fn coefficient_index(effect: usize) -> usize {
        SENSORS - HEAD + effect
    }

    /// Position of a sensor's bias, head first.
    const fn bias_index(sensor: usize) -> usize {
        sensor
    }

    /// Takes a fix of the reference: `y = h + sum_j theta_j phi_j + v`.
    ///
    /// `regressors_m` are the phi of the effects on the reference, metres per unit of coefficient; zero for
    /// any other.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`]; the state is then unchanged.
    #[inline(always)]
    pub fn update_reference(
        &mut self,
        altitude_m: f32,
        regressors_m: &[f32; E],
        noise: MeasurementNoise,
    ) -> Result<Innovation, FilterError> {
        let altitude = self.scaled(altitude_m);
        if has_any(regressors_m) {
            let row = self.affected_reference_row(regressors_m);
            return self.take(&row, altitude, noise, None);
        }
        self.take(&Self::reference_row(), altitude, noise, None)
    }

    #[inline(always)]
    fn take(
        &mut self,
        row: &Row<TAIL>,
        measurement: f32,
        noise: MeasurementNoise,
        gate: Option<Gate>,
    ) -> Result<Innovation, FilterError> {
        if HEAD == 0 && row.first < Self::ALTITUDE {
            return self.filter.take_by_columns(row, measurement, noise.0, gate);
        }
        self.filter.take::<true>(row, measurement, noise.0, gate)
    }

    /// Takes a reading of a sensor: `y = h + b + sum_j theta_j phi_j + v`.
    ///
    /// `regressors_m` are the phi of this sensor, metres per unit of coefficient; zero for an effect on
    /// another sensor. Without a gate, every innovation is accepted.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`], [`FilterError::Gated`]; the state is then unchanged.
    #[inline(always)]
    pub fn update_sensor(
        &mut self,
        sensor: Sensor,
        reading_m: f32,
        regressors_m: &[f32; E],
        noise: MeasurementNoise,
        gate: Option<Gate>,
    ) -> Result<Innovation, FilterError> {
        let row = self.sensor_row(sensor.index(), regressors_m);
        self.take(&row, self.scaled(reading_m), noise, gate)
    }

    /// Takes a tick at which the reference and every sensor are new, and folds. It does what
    /// [`Self::update_reference`], each [`Self::update_sensor`] and [`Self::fold`] do, but all or nothing,
    /// which lets the state stay in registers.
    ///
    /// `reference_regressors_m[effect]` as for [`Self::update_reference`], `regressors_m[sensor][effect]` as
    /// for [`Self::update_sensor`]. `admits` is called last, with the sensors' innovations.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`], [`FilterError::Refused`]; nothing of the tick has then been taken.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)] // All inputs of eq. 6.
    pub fn update_together(
        &mut self,
        altitude_m: f32,
        reference_regressors_m: &[f32; E],
        altitude_noise: MeasurementNoise,
        readings_m: &[f32; SENSORS],
        regressors_m: &[[f32; E]; SENSORS],
        noise: &[MeasurementNoise; SENSORS],
        admits: impl FnOnce(&[Innovation; SENSORS]) -> bool,
    ) -> Result<(Innovation, [Innovation; SENSORS]), FilterError> {
        let mut filter = self.filter.clone();
        let scaled = readings_m.map(|reading_m| self.scaled(reading_m));
        let altitude = self.scaled(altitude_m);
        let reference = if has_any(reference_regressors_m) {
            let row = self.affected_reference_row(reference_regressors_m);
            filter.take::<false>(&row, altitude, altitude_noise.0, None)?
        } else {
            filter.take::<false>(&Self::reference_row(), altitude, altitude_noise.0, None)?
        };
        let sensors = [
            filter.take::<false>(&self.sensor_row(0, &regressors_m[0]), scaled[0], noise[0].0, None)?,
            filter.take::<false>(&self.sensor_row(1, &regressors_m[1]), scaled[1], noise[1].0, None)?,
            filter.take::<false>(&self.sensor_row(2, &regressors_m[2]), scaled[2], noise[2].0, None)?,
        ];
        filter.fold();
        let variances = sensors.iter().fold(reference.variance, |sum, sensor| sum + sensor.variance);
        if !filter.is_finite_after(variances) {
            return Err(FilterError::NotFinite);
        }
        if !admits(&sensors) {
            return Err(FilterError::Refused);
        }
        self.filter = filter;
        Ok((reference, sensors))
    }

    #[inline(always)]
    fn reference_row() -> Row<TAIL> {
        let mut tail = [0.0; TAIL];
        tail[Self::ALTITUDE] = 1.0;
        Row { head: None, tail, first: Self::ALTITUDE }
    }

    /// The reference's row with effects on it; separate from [`Self::reference_row`], whose zeros the filter
    /// skips.
    fn affected_reference_row(&self, regressors_m: &[f32; E]) -> Row<TAIL> {
        let mut tail = [0.0; TAIL];
        for (j, (regressor_m, unit)) in regressors_m.iter().zip(&self.coefficient_unit).enumerate() {
            set(&mut tail, Self::coefficient_index(j), regressor_m * unit * (1.0 / UNIT_M));
        }
        set(&mut tail, Self::ALTITUDE, 1.0);
        Row { head: None, tail, first: Self::coefficient_index(0) }
    }

    #[inline(always)]
    fn sensor_row(&self, sensor: usize, regressors_m: &[f32; E]) -> Row<TAIL> {
        let mut tail = [0.0; TAIL];
        let (head, first) = if HEAD == 0 {
            set(&mut tail, Self::bias_index(sensor), 1.0);
            (None, Self::bias_index(sensor))
        } else {
            (Some(sensor), 0)
        };
        for j in 0..E {
            tail[Self::coefficient_index(j)] = regressors_m[j] * self.coefficient_unit[j] * (1.0 / UNIT_M);
        }
        tail[Self::ALTITUDE] = 1.0;
        Row { head, tail, first }
    }

    /// A reading in the filter's unit.
    #[inline(always)]
    fn scaled(&self, reading_m: f32) -> f32 {
        (reading_m - self.origin_m) * (1.0 / UNIT_M)
    }

    /// Carries the altitude on by `climb_m` metres, whose error has the variance `variance_m2` (eqs 4 and 5).
    ///
    /// # Errors
    /// [`FilterError`]; [`FilterError::Shape`] if `HEAD > 0` and the variance is not zero.
    pub fn climb(&mut self, climb_m: f32, variance_m2: f32) -> Result<(), FilterError> {
        if variance_m2 != 0.0 {
            self.filter.diffuse_by_columns(Self::ALTITUDE, variance_m2 / square(UNIT_M))?;
        }
        self.filter.shift_tail(Self::ALTITUDE, climb_m / UNIT_M)
    }

    /// Lets a bias wander by that variance (the noise floor).
    ///
    /// # Errors
    /// [`FilterError`].
    pub fn wander(&mut self, sensor: Sensor, variance_m2: f32) -> Result<(), FilterError> {
        let variance = variance_m2 / square(UNIT_M);
        if HEAD == 0 {
            self.filter.diffuse_by_columns(Self::bias_index(sensor.index()), variance)
        } else {
            self.filter.add_head_noise(sensor.index(), variance)
        }
    }

    /// Ends a tick; see [`UdFilter::fold`].
    #[inline(always)]
    pub fn fold(&mut self) {
        self.filter.fold();
    }

    /// Estimated altitude of the reference, metres.
    #[must_use]
    #[inline]
    pub fn altitude_m(&self) -> f32 {
        get(self.filter.tail(), Self::ALTITUDE) * UNIT_M + self.origin_m
    }

    /// Its variance, square metres.
    #[must_use]
    pub fn altitude_variance_m2(&self) -> f32 {
        self.filter.variance(HEAD + Self::ALTITUDE) * square(UNIT_M)
    }

    /// Estimated bias, metres.
    #[must_use]
    #[inline]
    pub fn bias_m(&self, sensor: Sensor) -> f32 {
        let states: &[f32] = if HEAD == 0 { self.filter.tail() } else { self.filter.head() };
        get(states, Self::bias_index(sensor.index())) * UNIT_M
    }

    /// Its variance, square metres.
    #[must_use]
    pub fn bias_variance_m2(&self, sensor: Sensor) -> f32 {
        self.filter.variance(Self::bias_index(sensor.index())) * square(UNIT_M)
    }

    /// Estimated coefficients, each in its effect's unit.
    #[must_use]
    #[inline]
    pub fn coefficients(&self) -> [f32; E] {
        let mut coefficients = self.coefficient_unit;
        for (j, coefficient) in coefficients.iter_mut().enumerate() {
            *coefficient *= get(self.filter.tail(), Self::coefficient_index(j));
        }
        coefficients
    }

    /// Variance of one coefficient, in its effect's unit squared; zero if there is no such effect.
    #[must_use]
    pub fn coefficient_variance(&self, effect: usize) -> f32 {
        let unit = get(&self.coefficient_unit, effect);
        self.filter.variance(HEAD + Self::coefficient_index(effect)) * square(unit)
    }

    /// Variances of altitude, biases and coefficients: the same values as one by one, but cheaper.
    #[inline]
    pub(crate) fn variances(&self) -> (f32, [f32; SENSORS], [f32; E]) {
        if HEAD > 0 {
            return (
                self.altitude_variance_m2(),
                Sensor::ALL.map(|sensor| self.bias_variance_m2(sensor)),
                core::array::from_fn(|effect| self.coefficient_variance(effect)),
            );
        }
        let stored = self.filter.tail_variances();
        (
            get(&stored, Self::ALTITUDE) * square(UNIT_M),
            core::array::from_fn(|sensor| get(&stored, Self::bias_index(sensor)) * square(UNIT_M)),
            core::array::from_fn(|effect| {
                get(&stored, Self::coefficient_index(effect)) * square(get(&self.coefficient_unit, effect))
            }),
        )
    }

    /// Covariance of two states in metres and coefficient units, in the paper's order: altitude,
    /// biases, coefficients.
    #[must_use]
    pub fn covariance(&self, row: usize, column: usize) -> f32 {
        let (row, row_unit) = self.stored(row);
        let (column, column_unit) = self.stored(column);
        self.filter.covariance(row, column) * row_unit * column_unit
    }

    /// The upper triangle of [`Self::covariance`], row by row.
    #[inline(never)]
    pub(crate) fn covariance_triangle(&self) -> heapless::Vec<f32, MAX_COVARIANCE> {
        let states = 1 + SENSORS + E;
        let altitude = HEAD + Self::ALTITUDE;
        let mut triangle = collected(core::iter::repeat_n(0.0, states * (states + 1) / 2));
        // Stored entries come row by row. They are in the triangle's order except for the altitude's, which
        // are the first row outside.
        let mut next = states;
        self.filter.for_each_covariance(|one, other, entry| {
            let scaled = entry * self.unit(one) * self.unit(other);
            let place = if other < altitude {
                next += 1;
                next - 1
            } else if one < altitude {
                1 + one
            } else {
                0
            };
            set(&mut triangle, place, scaled);
        });
        triangle
    }

    /// Unit of a stored state.
    #[inline(always)]
    fn unit(&self, stored: usize) -> f32 {
        match stored.checked_sub(SENSORS) {
            Some(effect) if effect < E => get(&self.coefficient_unit, effect),
            _ => UNIT_M,
        }
    }

    /// Stored position and unit of a state given in the paper's order.
    fn stored(&self, index: usize) -> (usize, f32) {
        match index.checked_sub(1) {
            None => (HEAD + Self::ALTITUDE, UNIT_M),
            Some(bias) if bias < SENSORS => (Self::bias_index(bias), UNIT_M),
            Some(other) => {
                let effect = other - SENSORS;
                (HEAD + Self::coefficient_index(effect), get(&self.coefficient_unit, effect))
            }
        }
    }
}

/// Variance of a measurement's noise in the filter's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasurementNoise(NoiseVariance);

impl MeasurementNoise {
    /// From a variance in square metres.
    ///
    /// # Errors
    /// [`FilterError`] if it is not positive and finite.
    pub fn from_variance_m2(variance_m2: f32) -> Result<Self, FilterError> {
        NoiseVariance::new(variance_m2 / square(UNIT_M)).map(Self)
    }

    /// The gate of a measurement that is weighted by this noise and judged by that of `single`: its NIS is at
    /// most `limit`.
    #[inline(always)]
    pub(crate) fn gate(self, limit: f32, single: Self, only_judges: bool) -> Gate {
        Gate { limit, excess: self.0.get() - single.0.get(), only_judges }
    }

    /// The variance in square metres.
    #[must_use]
    pub fn variance_m2(self) -> f32 {
        self.0.get() * square(UNIT_M)
    }
}

/// Whether any regressor is not zero.
#[inline(always)]
fn has_any<const E: usize>(regressors_m: &[f32; E]) -> bool {
    E > 0 && regressors_m.iter().any(|regressor_m| *regressor_m != 0.0)
}

const fn square(x: f32) -> f32 {
    x * x
}

/// `values[index]`, for an index that the shape's invariant (checked in `new`) keeps in range.
#[inline(always)]
fn get(values: &[f32], index: usize) -> f32 {
    values.get(index).copied().unwrap_or(0.0)
}

/// As [`get`].
fn set(values: &mut [f32], index: usize, value: f32) {
    if let Some(slot) = values.get_mut(index) {
        *slot = value;
    }
}

#[cfg(test)]
mod tests;
