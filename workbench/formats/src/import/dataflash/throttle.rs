//! Throttle from the outputs, where no message gives it.

use std::collections::BTreeMap;

use super::collect::Collected;
use super::rules::RULES;
use crate::import::table::{Destination, Filling, Samples};
use flight_data::Channel;

/// SERVOn_FUNCTION of a throttle.
const THROTTLE: f64 = 70.0;
/// SERVOn_FUNCTION of motors 1 to 8 and 9 to 12.
const MOTORS: [std::ops::RangeInclusive<f64>; 2] = [33.0..=40.0, 82.0..=85.0];

/// Adds the throttle computed from the outputs: the throttle's, or the mean of the motors', each scaled from
/// its least to its greatest pulse. Returns a note about it, or why it is not possible.
pub fn from_outputs(collected: &Collected, fillings: &mut Vec<Filling<'_>>) -> Option<String> {
    let place = RULES.iter().position(|rule| rule.family == "outputs")?;
    let group = collected.groups.get(&(place, 0))?;
    let parameter = |name: String| collected.parameters.get(&name).copied();
    let of_function = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
        (1..=14).filter(|n| parameter(format!("SERVO{n}_FUNCTION")).is_some_and(wanted)).collect()
    };
    let throttle = of_function(&|function| function == THROTTLE);
    let motors = of_function(&|function| MOTORS.iter().any(|motors| motors.contains(&function)));
    let (outputs, what) = if throttle.is_empty() { (motors, "motors'") } else { (throttle, "throttle's") };
    let ends = |n: &usize| {
        let of_servo = parameter(format!("SERVO{n}_MIN")).zip(parameter(format!("SERVO{n}_MAX")));
        let of_motor = parameter("MOT_PWM_MIN".to_owned()).zip(parameter("MOT_PWM_MAX".to_owned()));
        let (low, high) = if what == "motors'" { of_motor.or(of_servo) } else { of_servo }?;
        (high > low).then_some((*n, low, high))
    };
    let outputs: Vec<(usize, f64, f64)> = outputs.iter().filter_map(ends).collect();
    if outputs.is_empty() {
        return Some(
            "no throttle: no CTUN or THR message, and no parameters that say which output it is".to_owned(),
        );
    }
    let mut sums: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
    for (n, low, high) in &outputs {
        for (stamp, pulse) in group.column(n - 1).filter(|(_, pulse)| !pulse.is_nan()) {
            let sum = sums.entry(stamp).or_default();
            sum.0 += ((f64::from(pulse) - low) / (high - low)).clamp(0.0, 1.0);
            sum.1 += 1;
        }
    }
    let samples = sums.into_iter().map(|(stamp, (sum, count))| (stamp, (sum / f64::from(count)) as f32));
    fillings.push(Filling {
        destination: Destination::Channel(Channel::Throttle),
        samples: Samples::Own(samples.collect()),
    });
    Some(format!(
        "throttle is from the {what} output pulses (RCOU), scaled by the parameters' minimum and maximum"
    ))
}
