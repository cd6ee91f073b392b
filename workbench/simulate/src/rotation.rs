//! Vectors and attitude quaternions in double precision, with `libm` only (a platform's own sine would
//! change a flight's bytes).
//!
//! Quaternions are body to north-east-down, scalar first (Titterton and Weston, section 3.6.4).

/// A vector: north-east-down or body forward-right-down.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: Vector) -> f64 {
    libm::sqrt(dot(a, a))
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scale(a: Vector, k: f64) -> Vector {
    a.map(|x| x * k)
}

/// Attitude: body to north-east-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attitude(pub(super) [f64; 4]);

impl Attitude {
    /// From roll, pitch, yaw (rad), in the aerospace order yaw, pitch, roll.
    pub(super) fn from_euler([roll, pitch, yaw]: Vector) -> Self {
        let (sr, cr) = libm::sincos(0.5 * roll);
        let (sp, cp) = libm::sincos(0.5 * pitch);
        let (sy, cy) = libm::sincos(0.5 * yaw);
        Self([
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ])
    }

    /// Roll, pitch, yaw (rad).
    pub(super) fn euler(self) -> Vector {
        let m = self.matrix();
        [
            libm::atan2(m[2][1], m[2][2]),
            libm::asin((-m[2][0]).clamp(-1.0, 1.0)),
            libm::atan2(m[1][0], m[0][0]),
        ]
    }

    /// The direction cosine matrix of the quaternion, normalised.
    fn matrix(self) -> [Vector; 3] {
        let [w, x, y, z] = self.0;
        let s = 2.0 / (w * w + x * x + y * y + z * z);
        [
            [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
        ]
    }

    pub(super) fn to_ned(self, body: Vector) -> Vector {
        self.matrix().map(|row| dot(row, body))
    }

    pub(super) fn to_body(self, ned: Vector) -> Vector {
        let m = self.matrix();
        [0, 1, 2].map(|j| m[0][j] * ned[0] + m[1][j] * ned[1] + m[2][j] * ned[2])
    }

    /// Rate of change of the quaternion at a body rate (rad/s): q' = q (0, omega) / 2.
    pub(super) fn derivative(self, [p, q, r]: Vector) -> [f64; 4] {
        let [w, x, y, z] = self.0;
        [
            0.5 * (-x * p - y * q - z * r),
            0.5 * (w * p + y * r - z * q),
            0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn euler_angles_survive_the_round_trip() {
        for angles in [[0.1, -0.7, 2.9], [-2.0, 1.2, -3.0], [0.0, 0.0, 0.0], [3.0, -1.4, 0.5]] {
            let back = Attitude::from_euler(angles).euler();
            for (a, b) in angles.into_iter().zip(back) {
                assert!((a - b).abs() < 1e-13, "{angles:?} {back:?}");
            }
        }
    }

    #[test]
    fn nose_up_points_the_body_axis_up_and_right_wing_stays_right() {
        let nose_up = Attitude::from_euler([0.0, 0.3, 0.0]);
        assert!(nose_up.to_ned([1.0, 0.0, 0.0])[2] < 0.0);
        let banked_right = Attitude::from_euler([0.3, 0.0, 0.0]);
        assert!(banked_right.to_ned([0.0, 1.0, 0.0])[2] > 0.0);
        let east = Attitude::from_euler([0.0, 0.0, core::f64::consts::FRAC_PI_2]);
        assert!((east.to_ned([1.0, 0.0, 0.0])[1] - 1.0).abs() < 1e-15);
        let body = nose_up.to_body(nose_up.to_ned([1.0, 2.0, 3.0]));
        assert!(norm(minus(body, [1.0, 2.0, 3.0])) < 1e-14);
    }
}
