//! Compensated sums.

use serde::{Deserialize, Serialize};

/// A sum that keeps the rounding error of each addition (Kahan): hours of increments of a millionth of the
/// sum still move it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sum {
    value: f32,
    lost: f32,
}

impl Sum {
    pub(super) const fn new(value: f32) -> Self {
        Self { value, lost: 0.0 }
    }

    pub(super) const fn value(self) -> f32 {
        self.value
    }

    pub(super) fn add(&mut self, step: f32) {
        let step = step + self.lost;
        let sum = self.value + step;
        self.lost = step - (sum - self.value);
        self.value = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_steps_are_not_lost() {
        let (mut sum, mut plain) = (Sum::new(4_000.0), 4_000f32);
        for _ in 0..1_000_000 {
            sum.add(1e-4);
            plain += 1e-4;
        }
        assert!((sum.value() - 4_100.0).abs() < 1e-3, "{}", sum.value());
        assert!((plain - 4_100.0).abs() > 50.0, "a plain sum would do: {plain}");
    }
}
