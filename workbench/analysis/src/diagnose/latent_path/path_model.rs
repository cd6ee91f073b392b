//! How a path moves, and how two altitudes show it.
//!
//! ```text
//! h' = v, v' = a, a' = -a / t_a + white          Singer's manoeuvre model
//! receiver = h + u + white(r_g)                  u: Gauss-Markov, what a receiver's own filter makes of its noise
//! sensor   = h + d + white(r_s)                  d: a random walk, the bias and all that is slow
//! ```
//! R. A. Singer, "Estimating optimal tracking filter performance for manned maneuvering targets", IEEE
//! Transactions on Aerospace and Electronic Systems 6, 1970.

/// Altitude, climb rate, acceleration, the receiver's error, the sensor's offset.
pub const STATES: usize = 5;
/// One value per state.
pub type State = [f64; STATES];
/// Number of the model's parameters that are fitted.
pub const PARAMETERS: usize = 7;

/// Centre of the prior of each of the model's parameters, in the order of [`PathModel::of`], and the sigma of
/// its logarithm: orders of magnitude, from gliders to multicopters, and from altitudes in whole metres to
/// filtered ones.
const CENTRES: [f64; PARAMETERS] = [1.0, 5.0, 1.0, 0.5, 0.05, 1.0, 8.0];
const ORDERS: [f64; PARAMETERS] = [1.0, 0.7, 1.0, 1.0, 1.4, 1.0, 0.7];

/// Sigma of the initial climb rate, m/s, and of an altitude's initial offset, metres.
const FIRST_CLIMB_MPS: f64 = 10.0;
const FIRST_OFFSET_M: f64 = 100.0;

/// Nodes and weights of the five-point Gauss-Legendre rule on (0, 1).
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_095),
    (0.230_765_344_947_158, 0.239_314_335_249_683),
    (0.5, 0.284_444_444_444_444),
    (0.769_234_655_052_842, 0.239_314_335_249_683),
    (0.953_089_922_969_332, 0.118_463_442_528_095),
];

/// Number of time constants after which an acceleration has decayed: to 4e-18 of its value.
const BENT: u32 = 40;

/// A path's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathModel {
    acceleration_mps2: f64,
    acceleration_s: f64,
    /// White noise of a fix, metres.
    pub reference_m: f64,
    /// White noise of the sensor's mean about a fix, metres.
    pub sensor_m: f64,
    walk_m_per_root_s: f64,
    receiver_m: f64,
    receiver_s: f64,
}

/// How a state changes over some time: `x' = F x + w`, w of covariance Q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// The time, seconds.
    pub elapsed_s: f64,
    /// F.
    pub matrix: [State; STATES],
    /// Q.
    pub noise: [State; STATES],
}

impl PathModel {
    /// The model of these parameters: logarithms over the centres.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let number = |k: usize| CENTRES[k] * libm::exp(values.get(k).copied().unwrap_or(0.0));
        Self {
            acceleration_mps2: number(0),
            acceleration_s: number(1),
            reference_m: number(2),
            sensor_m: number(3),
            walk_m_per_root_s: number(4),
            receiver_m: number(5),
            receiver_s: number(6),
        }
    }

    /// Twice the negative logarithm of the prior's density, up to a constant.
    #[must_use]
    pub fn twice_prior(values: &[f64]) -> f64 {
        values.iter().zip(ORDERS).map(|(value, order)| (value / order) * (value / order)).sum()
    }

    /// State and covariance when only a receiver's altitude and a sensor's have been seen, metres.
    #[must_use]
    pub fn first(&self, reference_m: f64, sensor_m: Option<f64>) -> (State, [State; STATES]) {
        let mut covariance = [[0.0; STATES]; STATES];
        let offset_m = sensor_m.map_or(0.0, |sensor_m| sensor_m - reference_m);
        let sigmas =
            [FIRST_OFFSET_M, FIRST_CLIMB_MPS, self.acceleration_mps2, self.receiver_m, FIRST_OFFSET_M];
        for (k, sigma) in sigmas.into_iter().enumerate() {
            covariance[k][k] = sigma * sigma;
        }
        ([reference_m, 0.0, 0.0, 0.0, offset_m], covariance)
    }

    /// The transition over this many seconds.
    #[must_use]
    pub fn over(&self, elapsed_s: f64) -> Transition {
        let (moved_m, gained_mps, kept) = self.response(elapsed_s);
        let mut matrix = [[0.0; STATES]; STATES];
        matrix[0] = [1.0, elapsed_s, moved_m, 0.0, 0.0];
        matrix[1] = [0.0, 1.0, gained_mps, 0.0, 0.0];
        matrix[2][2] = kept;
        matrix[3][3] = libm::exp(-elapsed_s / self.receiver_s);
        matrix[4][4] = 1.0;
        let mut noise = [[0.0; STATES]; STATES];
        let density = 2.0 * self.acceleration_mps2 * self.acceleration_mps2 / self.acceleration_s;
        for (from_s, length_s) in self.panels(elapsed_s) {
            for (node, weight) in NODES {
                let (moved_m, gained_mps, kept) = self.response(from_s + node * length_s);
                let response = [moved_m, gained_mps, kept];
                for (row, left) in noise.iter_mut().zip(response) {
                    for (entry, right) in row.iter_mut().zip(response) {
                        *entry += density * weight * length_s * left * right;
                    }
                }
            }
        }
        let kept = matrix[3][3];
        noise[3][3] = self.receiver_m * self.receiver_m * (1.0 - kept * kept);
        noise[4][4] = self.walk_m_per_root_s * self.walk_m_per_root_s * elapsed_s;
        Transition { elapsed_s, matrix, noise }
    }

    /// Parts of a time that the five-point rule integrates: it is exact to ten digits over one time constant,
    /// and where an acceleration has decayed, the rest is straight. Start and length, seconds.
    fn panels(&self, elapsed_s: f64) -> impl Iterator<Item = (f64, f64)> {
        let time_s = self.acceleration_s;
        let bent = f64::from(BENT).min((elapsed_s / time_s).floor()) as u32;
        let rest_s = f64::from(bent) * time_s;
        (0..bent).map(move |k| (f64::from(k) * time_s, time_s)).chain([(rest_s, elapsed_s - rest_s)])
    }

    /// The altitude, climb rate and acceleration that an acceleration of 1 m/s^2 causes after some time.
    fn response(&self, elapsed_s: f64) -> (f64, f64, f64) {
        let gained = -self.acceleration_s * libm::expm1(-elapsed_s / self.acceleration_s);
        (self.acceleration_s * (elapsed_s - gained), gained, libm::exp(-elapsed_s / self.acceleration_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(left: &[State; STATES], right: &[State; STATES]) -> [State; STATES] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..STATES).map(|k| left[i][k] * right[k][j]).sum()))
    }

    fn transposed(matrix: &[State; STATES]) -> [State; STATES] {
        std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]))
    }

    /// The transition over a time is that of its parts one after the other: `F(a + b) = F(b) F(a)` and
    /// `Q(a + b) = F(b) Q(a) F(b)' + Q(b)`, below a time constant of the acceleration and beyond many.
    #[test]
    fn a_time_does_what_its_parts_do() {
        for values in [[0.0; 7], [0.3, -0.5, 0.2, 0.1, -0.4, 0.6, -0.2]] {
            let model = PathModel::of(&values);
            for (one_s, other_s) in
                [(0.2, 0.3), (1.0, 4.0), (7.0, 60.0), (model.acceleration_s, 3.0 * model.acceleration_s)]
            {
                let (one, other, both) =
                    (model.over(one_s), model.over(other_s), model.over(one_s + other_s));
                let matrix = times(&other.matrix, &one.matrix);
                let carried = times(&times(&other.matrix, &one.noise), &transposed(&other.matrix));
                for i in 0..STATES {
                    for j in 0..STATES {
                        let (found, wanted) = (both.matrix[i][j], matrix[i][j]);
                        assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "F {one_s} {i} {j}");
                        // The five-point rule is accurate to ten digits.
                        let (found, wanted) = (both.noise[i][j], carried[i][j] + other.noise[i][j]);
                        let size = (both.noise[i][i] * both.noise[j][j]).sqrt();
                        assert!((found - wanted).abs() <= 1e-7 * size, "Q {one_s} {i} {j} {found} {wanted}");
                    }
                }
            }
        }
    }

    /// After a long time the acceleration has its stationary variance again, whatever it was; the parts of a
    /// time add up to it.
    #[test]
    fn an_acceleration_keeps_its_variance() {
        let model = PathModel::of(&[0.4, 0.2]);
        let long = model.over(50.0 * model.acceleration_s);
        let wanted = model.acceleration_mps2 * model.acceleration_mps2;
        // The last of the panels is the straight rest, in which the acceleration has decayed.
        assert!((long.noise[2][2] / wanted - 1.0).abs() < 1e-6, "{} {wanted}", long.noise[2][2]);
        for elapsed_s in [0.1, 5.0, 100.0, 1_000.0] {
            let mut end_s = 0.0;
            for (from_s, length_s) in model.panels(elapsed_s) {
                assert!((from_s - end_s).abs() < 1e-9, "{elapsed_s}");
                end_s = from_s + length_s;
            }
            assert!((end_s - elapsed_s).abs() < 1e-9, "{elapsed_s} {end_s}");
        }
    }

    /// The parameters are logarithms over their centres, and the prior's density is normal in them.
    #[test]
    fn numbers_are_logarithms_over_their_centres() {
        let (none, twice) = (PathModel::of(&[]), PathModel::of(&[std::f64::consts::LN_2; 7]));
        for (one, other) in [
            (none.acceleration_mps2, twice.acceleration_mps2),
            (none.acceleration_s, twice.acceleration_s),
            (none.reference_m, twice.reference_m),
            (none.sensor_m, twice.sensor_m),
            (none.walk_m_per_root_s, twice.walk_m_per_root_s),
            (none.receiver_m, twice.receiver_m),
            (none.receiver_s, twice.receiver_s),
        ] {
            assert!((other / one - 2.0).abs() < 1e-12);
        }
        assert_eq!(PathModel::twice_prior(&[0.0; 7]), 0.0);
        // Each parameter at two of its sigmas: four each.
        assert!(
            (PathModel::twice_prior(&ORDERS.map(|order| 2.0 * order)) - 4.0 * ORDERS.len() as f64).abs()
                < 1e-12
        );
    }
}
