//! Vectors in body axes, and the direction of down in them.

use super::sum::Sum;

pub(super) type Vector = [f32; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a - b`. (Written out, as [`scaled`] and [`sum`] are: for a closure over an axis the compiler cannot prove
/// that the axis is valid.)
pub(super) const fn difference([a, b, c]: Vector, [x, y, z]: Vector) -> Vector {
    [a - x, b - y, c - z]
}

pub(super) const fn sum([a, b, c]: Vector, [x, y, z]: Vector) -> Vector {
    [a + x, b + y, c + z]
}

pub(super) const fn scaled([a, b, c]: Vector, by: f32) -> Vector {
    [a * by, b * by, c * by]
}

/// The local vertical in body axes: the third row of the direction cosine matrix from body to
/// north-east-down.
///
/// This row is closed under rotation (`c' = c x omega`, D. H. Titterton and J. L. Weston, "Strapdown Inertial
/// Navigation Technology", 2nd edition, IEE 2004, section 3.6.3), and it is the only part of the attitude
/// that the vertical channel needs: the heading is not used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Down([Sum; 3]);

impl Down {
    /// From the specific force of unaccelerated flight; `None` outside half to one and a half times gravity.
    pub(super) fn from_specific_force(force: Vector, gravity: f32) -> Option<Self> {
        let mut down = force.map(|part| -part / gravity);
        if !(0.25..2.25).contains(&dot(down, down)) {
            return None;
        }
        // Newton's iteration for the unit vector: without a square root, with quadratic convergence from
        // anywhere in that range.
        for _ in 0..6 {
            let scale = 1.5 - 0.5 * dot(down, down);
            down = down.map(|part| part * scale);
        }
        Some(Self(down.map(Sum::new)))
    }

    /// A direction of length 1.
    pub(super) const fn from_unit([x, y, z]: Vector) -> Self {
        Self([Sum::new(x), Sum::new(y), Sum::new(z)])
    }

    /// Moves the direction by a small perpendicular vector.
    pub(super) fn shift(&mut self, by: Vector) {
        for (part, by) in self.0.iter_mut().zip(by) {
            part.add(by);
        }
    }

    pub(super) fn get(&self) -> Vector {
        self.0.map(Sum::value)
    }

    /// Rotates the vector (rad, body axes) and keeps its length at 1.
    ///
    /// The rotation is exact to the seventh power of the angle: the two functions of the squared angle are
    /// its series (Titterton and Weston, section 11.2.1), so there is no square root and no division.
    pub(super) fn rotate(&mut self, angle: Vector) {
        let squared = dot(angle, angle);
        let sine = 1.0 - squared * (1.0 / 6.0 - squared * (1.0 / 120.0 - squared / 5_040.0));
        let versine = 0.5 - squared * (1.0 / 24.0 - squared * (1.0 / 720.0 - squared / 40_320.0));
        let down = self.get();
        let first = cross(angle, down);
        let second = cross(angle, first);
        let shrink = 0.5 * (1.0 - dot(down, down));
        for axis in 0..3 {
            self.0[axis].add(sine * first[axis] + versine * second[axis] + shrink * down[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_a_turn() {
        let mut down = Down::from_specific_force([0.0, 0.0, -12.0], 9.8).unwrap();
        assert!((down.get()[2] - 1.0).abs() < 1e-6, "{:?}", down.get());
        // The vector turned by +90 degrees about x, in steps of a tick at 1 rad/s: z goes to -y.
        for _ in 0..1_000 {
            down.rotate([core::f32::consts::FRAC_PI_2 / 1_000.0, 0.0, 0.0]);
        }
        for (found, wanted) in down.get().into_iter().zip([0.0, -1.0, 0.0]) {
            assert!((found - wanted).abs() < 2e-6, "{:?}", down.get());
        }
    }

    #[test]
    fn one_large_step_is_exact() {
        let mut down = Down::from_specific_force([0.0, 0.0, -9.8], 9.8).unwrap();
        down.rotate([0.3, 0.0, 0.0]);
        assert!((down.get()[1] + 0.3f32.sin()).abs() < 1e-6 && (down.get()[2] - 0.3f32.cos()).abs() < 1e-6);
    }

    #[test]
    fn the_length_stays() {
        let mut down = Down::from_specific_force([1.0, -2.0, -9.0], 9.8).unwrap();
        for tick in 0..200_000 {
            let phase = tick as f32 * 0.01;
            down.rotate([0.02 * phase.sin(), 0.015 * phase.cos(), 0.01]);
        }
        assert!((dot(down.get(), down.get()) - 1.0).abs() < 1e-6, "{:?}", down.get());
    }

    #[test]
    fn free_fall_has_no_vertical() {
        assert_eq!(Down::from_specific_force([0.0, 0.0, -4.0], 9.8), None);
        assert_eq!(Down::from_specific_force([0.0, 0.0, -15.0], 9.8), None);
        assert_eq!(Down::from_specific_force([0.0, 0.0, f32::NAN], 9.8), None);
    }
}
