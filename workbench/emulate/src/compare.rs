//! Compares host and target, to the bit.

use std::fmt;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use flight_computer::Step;
use flight_record::MAX_FRAME;
use kf_core::input::{BaroReading, GpsFix, ImuSample, Signals, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::output::{CoefficientOutput, SensorOutput, TickOutput};
use kf_core::sensor::Sensor;
use serde::Serialize;

/// The first difference between the host's mission and the target's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Index of the tick, from 0.
    pub tick: u64,
    /// Its time, microseconds.
    pub time_us: u64,
    /// The field, as a path in Rust's notation.
    pub field: String,
    /// The host's value.
    pub host: String,
    /// The target's value.
    pub target: String,
    /// Total number of ticks that differ; 0 for a difference in the latch alone.
    pub ticks_that_differ: u64,
    /// Number of ticks.
    pub ticks: u64,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tick, time_us, field, host, target, ticks_that_differ, ticks } = self;
        let time_s = *time_us as f64 * 1e-6;
        write!(
            formatter,
            "first at tick {tick} ({time_s:.3} s), {field}: {target} on the target, {host} on the host; \
             {ticks_that_differ} of {ticks} ticks differ"
        )
    }
}

/// A named value that differs: field, host's, target's.
pub(super) type FieldDifference = (String, String, String);

/// Whether two values have the same bits (NaNs included), by their wire form.
pub(super) fn same_bits<T: Serialize>(host: &T, target: &T) -> bool {
    let mut buffers = ([0; MAX_FRAME], [0; MAX_FRAME]);
    match (postcard::to_slice(host, &mut buffers.0), postcard::to_slice(target, &mut buffers.1)) {
        (Ok(host), Ok(target)) => host == target,
        // A value that came over the wire fits into a frame; one that does not is different.
        _ => false,
    }
}

/// Whether two ticks have the same input and output, to the bit.
pub(super) fn same_step(host: &Step, target: &Step) -> bool {
    same_bits(&host.input, &target.input) && same_bits(&host.output, &target.output)
}

/// A check over all the bits of a tick, NaNs included: two ticks with different bits have different checks,
/// except one pair in 2^64.
pub(super) fn check_of(step: &Step) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut buffer = [0; MAX_FRAME];
    postcard::to_slice(&step.input, &mut buffer).map(|bytes| bytes.hash(&mut hasher)).ok();
    postcard::to_slice(&step.output, &mut buffer).map(|bytes| bytes.hash(&mut hasher)).ok();
    hasher.finish()
}

/// The first field in which two ticks differ: of their input, or else of their output.
pub(super) fn tick_difference(host: &Step, target: &Step) -> FieldDifference {
    if same_bits(&host.input, &target.input) {
        first_difference(tick_fields(&host.output), tick_fields(&target.output))
    } else {
        first_difference(input_fields(&host.input), input_fields(&target.input))
    }
}

/// The first field in which two latches differ.
pub(super) fn latch_difference(host: Option<&LatchRecord>, target: Option<&LatchRecord>) -> FieldDifference {
    match (host, target) {
        (Some(host), Some(target)) => first_difference(latch_fields(host), latch_fields(target)),
        (host, target) => {
            let said = |latch: Option<&LatchRecord>| latch.map_or("none", |_| "one").to_owned();
            ("latch".to_owned(), said(host), said(target))
        }
    }
}

type Fields = Vec<(String, String)>;

fn first_difference(host: Fields, target: Fields) -> FieldDifference {
    let lengths = (host.len(), target.len());
    host.into_iter()
        .zip(target)
        .find_map(|((field, host), (_, target))| (host != target).then_some((field, host, target)))
        .unwrap_or_else(|| ("number of fields".to_owned(), lengths.0.to_string(), lengths.1.to_string()))
}

/// A number and its bits: the shortest decimal form is exact, but NaNs all look the same.
fn bits(value: f32) -> String {
    format!("{value:?} (0x{:08x})", value.to_bits())
}

fn optional(value: Option<f32>) -> String {
    value.map_or_else(|| "none".to_owned(), bits)
}

/// Every field of a tick's input. The patterns name every field, so that a new one cannot be forgotten here.
fn input_fields(input: &TickInput) -> Fields {
    let TickInput {
        time_us,
        launch,
        launch_doubt,
        gps,
        baro,
        imu_master_altitude_m,
        imu_slave_altitude_m,
        imu,
        signals,
        // No flight computer has any.
        columns: _,
    } = input;
    let Signals {
        true_airspeed_mps,
        angle_of_attack_rad,
        sideslip_rad,
        throttle,
        outside_air_temperature_c,
        baro_temperature_c,
        attitude_rad,
    } = signals;
    let mut fields = vec![
        ("input.time_us".to_owned(), time_us.to_string()),
        ("input.launch".to_owned(), launch.to_string()),
        ("input.launch_doubt".to_owned(), format!("{launch_doubt:?}")),
        ("input.gps".to_owned(), gps.map_or("none", |_| "a fix").to_owned()),
    ];
    if let Some(fix) = gps {
        let GpsFix {
            altitude_m,
            velocity_north_mps,
            velocity_east_mps,
            velocity_down_mps,
            vertical_accuracy_m,
            satellites,
            fix_time_us,
        } = fix;
        fields.extend([
            ("input.gps.altitude_m".to_owned(), bits(*altitude_m)),
            ("input.gps.velocity_north_mps".to_owned(), optional(*velocity_north_mps)),
            ("input.gps.velocity_east_mps".to_owned(), optional(*velocity_east_mps)),
            ("input.gps.velocity_down_mps".to_owned(), optional(*velocity_down_mps)),
            ("input.gps.vertical_accuracy_m".to_owned(), optional(*vertical_accuracy_m)),
            ("input.gps.satellites".to_owned(), format!("{satellites:?}")),
            ("input.gps.fix_time_us".to_owned(), format!("{fix_time_us:?}")),
        ]);
    }
    fields.push((
        "input.baro".to_owned(),
        match baro {
            None => "none".to_owned(),
            Some(BaroReading::PressurePa(pressure_pa)) => format!("{} Pa", bits(*pressure_pa)),
            Some(BaroReading::AltitudeM(altitude_m)) => format!("{} m", bits(*altitude_m)),
        },
    ));
    fields.extend([
        ("input.imu_master_altitude_m".to_owned(), optional(*imu_master_altitude_m)),
        ("input.imu_slave_altitude_m".to_owned(), optional(*imu_slave_altitude_m)),
    ]);
    let (accel, gyro) = imu
        .map(|ImuSample { accel_mps2, gyro_radps }| (accel_mps2, gyro_radps))
        .map_or((None, None), |(accel, gyro)| (Some(accel), Some(gyro)));
    for (name, values) in [
        ("input.imu.accel_mps2", accel),
        ("input.imu.gyro_radps", gyro),
        ("input.signals.attitude_rad", *attitude_rad),
    ] {
        for axis in 0..3 {
            fields.push((format!("{name}[{axis}]"), optional(values.map(|values| values[axis]))));
        }
    }
    for (name, value) in [
        ("true_airspeed_mps", true_airspeed_mps),
        ("angle_of_attack_rad", angle_of_attack_rad),
        ("sideslip_rad", sideslip_rad),
        ("throttle", throttle),
        ("outside_air_temperature_c", outside_air_temperature_c),
        ("baro_temperature_c", baro_temperature_c),
    ] {
        fields.push((format!("input.signals.{name}"), optional(*value)));
    }
    fields
}

/// Every field of a tick. The patterns name every field, so that a new one cannot be forgotten here.
fn tick_fields(output: &TickOutput) -> Fields {
    let TickOutput {
        time_us,
        out_of_order,
        phase,
        latched_now,
        failed_checks,
        altitude_m,
        altitude_variance_m2,
        gps_innovation_m,
        gps_signed_nis,
        gps_rejection,
        sensors,
        extrapolated,
        cross_check,
        bridged_us,
        coefficients,
    } = output;
    let mut fields = vec![
        ("time_us".to_owned(), time_us.to_string()),
        ("out_of_order".to_owned(), out_of_order.to_string()),
        ("phase".to_owned(), format!("{phase:?}")),
        ("latched_now".to_owned(), latched_now.to_string()),
        ("failed_checks".to_owned(), format!("{failed_checks:#b}")),
        ("altitude_m".to_owned(), bits(*altitude_m)),
        ("altitude_variance_m2".to_owned(), bits(*altitude_variance_m2)),
        ("gps_innovation_m".to_owned(), optional(*gps_innovation_m)),
        ("gps_signed_nis".to_owned(), optional(*gps_signed_nis)),
        ("gps_rejection".to_owned(), format!("{gps_rejection:?}")),
    ];
    for (sensor, output) in Sensor::ALL.into_iter().zip(sensors) {
        let SensorOutput {
            bias_m,
            bias_variance_m2,
            innovation_m,
            signed_nis,
            error_m,
            moving_average_m,
            trust,
            rejection,
        } = output;
        let name = sensor.name();
        fields.extend([
            (format!("{name}.bias_m"), bits(*bias_m)),
            (format!("{name}.bias_variance_m2"), bits(*bias_variance_m2)),
            (format!("{name}.innovation_m"), optional(*innovation_m)),
            (format!("{name}.signed_nis"), optional(*signed_nis)),
            (format!("{name}.error_m"), optional(*error_m)),
            (format!("{name}.moving_average_m"), optional(*moving_average_m)),
            (format!("{name}.trust"), trust.name().to_owned()),
            (format!("{name}.rejection"), format!("{rejection:?}")),
        ]);
    }
    fields.push(("extrapolated".to_owned(), format!("{extrapolated:#b}")));
    let agreement = cross_check.map(|check| check.agreement.name());
    fields.push(("cross_check.agreement".to_owned(), agreement.unwrap_or("none").to_owned()));
    fields.extend([
        ("cross_check.difference_m".to_owned(), optional(cross_check.map(|check| check.difference_m))),
        (
            "cross_check.moving_average_m".to_owned(),
            optional(cross_check.map(|check| check.moving_average_m)),
        ),
        ("bridged_us".to_owned(), format!("{bridged_us:?}")),
    ]);
    for (index, CoefficientOutput { coefficient, variance }) in coefficients.iter().enumerate() {
        fields.push((format!("coefficients[{index}].coefficient"), bits(*coefficient)));
        fields.push((format!("coefficients[{index}].variance"), bits(*variance)));
    }
    fields
}

/// Every field of a latch.
fn latch_fields(latch: &LatchRecord) -> Fields {
    let LatchRecord { time_us, duration_s, failed_checks, sensors, state, covariance } = latch;
    let mut fields = vec![
        ("latch.time_us".to_owned(), time_us.to_string()),
        ("latch.duration_s".to_owned(), bits(*duration_s)),
        ("latch.failed_checks".to_owned(), format!("{failed_checks:#b}")),
    ];
    for (sensor, latched) in Sensor::ALL.into_iter().zip(sensors) {
        // A struct of numbers only: its own form is exact except for NaN's bits.
        fields.push((format!("latch.{}", sensor.name()), format!("{latched:?}")));
    }
    fields.extend(state.iter().enumerate().map(|(i, value)| (format!("latch.state[{i}]"), bits(*value))));
    let entries = covariance.iter().enumerate();
    fields.extend(entries.map(|(i, value)| (format!("latch.covariance[{i}]"), bits(*value))));
    fields
}

#[cfg(test)]
mod tests {
    use kf_core::output::{Phase, Trust};

    use super::*;

    fn output() -> TickOutput {
        let sensor = SensorOutput {
            bias_m: 1.0,
            bias_variance_m2: 2.0,
            innovation_m: Some(0.5),
            signed_nis: None,
            error_m: None,
            moving_average_m: None,
            trust: Trust::Calibrating,
            rejection: None,
        };
        TickOutput {
            time_us: 5_000,
            out_of_order: false,
            phase: Phase::Calibrating,
            latched_now: false,
            failed_checks: 0,
            altitude_m: 2_000.0,
            altitude_variance_m2: 1.0,
            gps_innovation_m: None,
            gps_signed_nis: None,
            gps_rejection: None,
            sensors: [sensor; 3],
            extrapolated: 0,
            cross_check: None,
            bridged_us: None,
            coefficients: heapless::Vec::new(),
        }
    }

    fn step() -> Step {
        Step { input: TickInput::default(), output: output() }
    }

    #[test]
    fn one_unit_in_the_last_place_is_a_difference_with_a_name() {
        let host = step();
        let mut target = step();
        assert!(same_step(&host, &target));
        target.output.sensors[2].innovation_m = Some(0.5_f32.next_up());
        assert!(!same_step(&host, &target));
        let (field, host, target) = tick_difference(&host, &target);
        assert_eq!(field, "baro.innovation_m");
        assert_eq!(host, "0.5 (0x3f000000)");
        assert_eq!(target, "0.50000006 (0x3f000001)");
    }

    #[test]
    fn signs_of_zero_and_bits_of_nan_count() {
        let mut host = step();
        let mut target = step();
        host.output.altitude_m = 0.0;
        target.output.altitude_m = -0.0;
        assert!(!same_step(&host, &target));
        assert_eq!(tick_difference(&host, &target).0, "altitude_m");
        host.output.altitude_m = f32::from_bits(0x7fc0_0000);
        target.output.altitude_m = f32::from_bits(0x7fc0_0000);
        assert!(same_step(&host, &target));
        target.output.altitude_m = f32::from_bits(0x7fc0_0001);
        assert!(!same_step(&host, &target));
        assert_eq!(tick_difference(&host, &target).2, "NaN (0x7fc00001)");
    }

    #[test]
    fn what_a_tick_saw_is_compared_too() {
        let host = step();
        let mut target = step();
        target.input.baro = Some(BaroReading::PressurePa(1.0));
        assert!(!same_step(&host, &target));
        assert_eq!(tick_difference(&host, &target).0, "input.baro");
        target = step();
        target.input.gps = Some(GpsFix::default());
        assert_eq!(tick_difference(&host, &target).0, "input.gps");
        target = step();
        target.input.signals.attitude_rad = Some([0.0, 0.0, -0.0]);
        assert_eq!(tick_difference(&host, &target).0, "input.signals.attitude_rad[0]");
    }

    #[test]
    fn a_coefficient_more_is_a_difference() {
        let host = step();
        let mut target = step();
        target.output.coefficients.push(CoefficientOutput { coefficient: 0.0, variance: 0.0 }).unwrap();
        assert!(!same_step(&host, &target));
        assert_eq!(tick_difference(&host, &target).0, "number of fields");
    }
}
