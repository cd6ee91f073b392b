//! An angle of attack that was found as its parts.
//!
//! Lift is the dynamic pressure q times the angle of attack beyond that of zero lift, `n W = q S c (a - a0)`,
//! so the error `k q a` of an angle of attack is `k W n / (S c) + k a0 q`: a part that follows the load factor
//! n and one that follows q. Where the angle was not measured, or not well, the search finds these two as an
//! acceleration and a dynamic pressure. Neither need act then.

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;

use super::Judge;
use crate::diagnose::physical_range::range;
use crate::diagnose::rivals::Rivals;
use crate::diagnose::search::Explanation;

/// The largest angle between the zero-lift line and the line from which an angle of attack counts, rad: 5
/// degrees, that of a strongly cambered section (Abbott and von Doenhoff, *Theory of Wing Sections*, appendix
/// IV). docs/blind-trials-history.md says what flights with and without such an angle need.
const ZERO_LIFT_RAD: f64 = 0.087;

/// The smallest part of an angle of attack that carries the aircraft in level flight, rad: a lift coefficient
/// of 0.1 at 5 per radian.
const LIFTING_RAD: f64 = 0.02;

impl Judge<'_> {
    /// Effects that may be parts of one angle of attack become rivals of it: an acceleration and an angle of
    /// attack that were both chosen, and a dynamic pressure beside an acceleration.
    pub(super) fn merge_lift(&self, explanation: &Explanation, rivals: &mut [Rivals]) {
        let place = |effect: EffectId| {
            explanation.columns.iter().position(|column| self.candidates[*column].effect() == effect)
        };
        let Some(load) = place(EffectId::BaroAcceleration) else { return };
        if let Some(angle) = place(EffectId::BaroAngleOfAttack) {
            let columns = [rivals[load].column, rivals[angle].column];
            rivals[load].add(columns[1], 1.0);
            rivals[angle].add(columns[0], 1.0);
        }
        if let Some(pressure) = place(EffectId::BaroDynamicPressure)
            && self.may_be_one_angle(explanation, load, pressure)
        {
            rivals[pressure].is_part_of_lift = true;
        }
    }

    /// Whether the coefficients of an acceleration and a dynamic pressure (at these places) may come from one
    /// angle of attack.
    fn may_be_one_angle(&self, explanation: &Explanation, load: usize, pressure: usize) -> bool {
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let solution = information.solve(&self.suspects.positions(&explanation.columns));
        let Some((load_m, of_pressure)) =
            solution.map(|solution| (solution.coefficients[load], solution.coefficients[pressure]))
        else {
            return false;
        };
        let [_, most] = range(EffectId::BaroAngleOfAttack, self.has_climb_rate);
        let head_m = self.head_m(explanation.columns[pressure]);
        zero_lift_rad(load_m, of_pressure, head_m, most) <= ZERO_LIFT_RAD
    }

    /// Mean of a dynamic pressure's column, metres of air.
    fn head_m(&self, column: usize) -> f64 {
        let on = Sensor::Baro.index();
        let (mut sum, mut count) = (0.0, 0_u32);
        for series in self.epochs.iter().map(|epochs| &epochs.series) {
            for block in (0..series.len()).filter(|block| series.readings[*block][on] > 0) {
                sum += series.columns[column][block][on].abs();
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }
}

/// The smallest angle of zero lift, rad, with which one angle of attack makes an acceleration's coefficient
/// (metres a g) and a dynamic pressure's (1), at a dynamic pressure of this many metres in level flight, if its
/// own coefficient is this many per radian at most.
///
/// In level flight, the part of the angle that lifts, `b`, makes `load_m = k b head_m`; the zero-lift part
/// makes `of_pressure = k a0`. So `a0 = b of_pressure head_m / load_m`, and `b` is not smaller than `most`
/// allows.
fn zero_lift_rad(load_m: f64, of_pressure: f64, head_m: f64, most: f64) -> f64 {
    let lifting_rad = LIFTING_RAD.max(load_m.abs() / (most * head_m));
    lifting_rad * (of_pressure * head_m / load_m).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An angle of attack of 3 per radian, 46 m of dynamic pressure, 4 degrees that lift and 3 of zero lift:
    /// its two parts give the angle back, or a smaller one where less of it may lift.
    #[test]
    fn the_parts_of_an_angle_are_one() {
        let (k, head_m, lifting, zero) = (3.0, 46.0, 4.0_f64.to_radians(), 3.0_f64.to_radians());
        let (load_m, of_pressure) = (k * lifting * head_m, k * zero);
        // The coefficient is at its limit: there is only one way.
        assert!((zero_lift_rad(load_m, of_pressure, head_m, k) - zero).abs() < 1e-12);
        let other = zero_lift_rad(load_m, -of_pressure, head_m, 7.9);
        assert!(other < zero && other > 0.0, "{other}");
    }

    /// A dynamic pressure of 0.6 beside an acceleration of 2 m a g would need a zero lift at 16 degrees: it
    /// acts by itself.
    #[test]
    fn a_large_dynamic_pressure_is_no_part_of_it() {
        assert!(zero_lift_rad(2.0, 0.6, 46.0, 7.9) > ZERO_LIFT_RAD);
        assert!(zero_lift_rad(2.0, 0.1, 46.0, 7.9) < ZERO_LIFT_RAD);
    }
}
