//! Missions on synthetic readings: each bad input has its defined outcome.

use super::*;
use crate::config::{
    ClimbRate, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource,
};
use crate::effect::{EffectId, EffectTerm};
use crate::input::{GpsFix, Signals};
use crate::quality::{Check, FailedChecks};

/// Biases of the three sensors, metres.
const BIASES_M: [f32; 3] = [5.0, -20.0, 30.0];
const TICK_US: u64 = 5_000;

fn config<const E: usize>(climb_rate: bool) -> MissionConfig<E> {
    let sensor = |sigma_m| SensorConfig {
        sigma_m,
        correlation_time_s: 0.0,
        prior_bias_m: 0.0,
        prior_sigma_m: 100.0,
        wander_m_per_sqrt_s: 0.0,
    };
    MissionConfig {
        settling_s: 2.0,
        reference: ReferenceConfig {
            sigma_m: 2.0,
            correlation_time_s: 0.0,
            prior_altitude_m: None,
            prior_sigma_m: 50.0,
            climb_rate: climb_rate.then_some(ClimbRate { sigma_mps: 0.2, correlation_time_s: 2.0 }),
            lost_after_s: 2.0,
        },
        latitude_deg: 45.0,
        sensors: [sensor(2.0), sensor(2.0), sensor(1.0)],
        monitor: MonitorConfig {
            sigma: SigmaSource::Residual,
            multiplier: 4.0,
            window_s: 2.0,
            persistence_s: 1.25,
            reference_check: true,
        },
        second_correction: SecondCorrection::Off,
        quality: QualityConfig {
            minimum_duration_s: 10.0,
            trimmed_altitude_m: 5.0,
            trimmed_airspeed_mps: 3.0,
            reference_drift_m: 4.0,
            minimum_satellites: 5,
            vertical_accuracy_m: 10.0,
            bias_drift_sigmas: 1.0,
            implausible_share: 0.02,
        },
        estimated_effects: [EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.2); E],
        constant_effects: heapless::Vec::new(),
    }
}

/// A captive flight of 30 s at 2,000 m and 60 m/s, then 10 s of free flight; gps at 5 Hz, sensors at 50 Hz,
/// 200 ticks a second; uniform noise of about the configured sigmas.
struct Flight {
    seed: u32,
    /// Factor on every noise.
    noise: f32,
}

impl Flight {
    fn uniform(&mut self) -> f32 {
        self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((self.seed >> 8) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6 * self.noise
    }

    fn tick(&mut self, k: u64) -> TickInput {
        let time_us = k * TICK_US;
        let altitude_m = 2_000.0;
        let mut input = TickInput { time_us, launch: time_us >= 30_000_000, ..TickInput::default() };
        if k.is_multiple_of(40) {
            input.gps = Some(GpsFix {
                altitude_m: altitude_m + 2.0 * self.uniform(),
                velocity_north_mps: Some(60.0 + 0.1 * self.uniform()),
                velocity_east_mps: Some(0.1 * self.uniform()),
                velocity_down_mps: Some(0.1 * self.uniform()),
                vertical_accuracy_m: Some(3.0),
                satellites: Some(11),
                fix_time_us: None,
            });
        }
        if k.is_multiple_of(4) {
            input.imu_master_altitude_m = Some(altitude_m + BIASES_M[0] + self.uniform());
            input.imu_slave_altitude_m = Some(altitude_m + BIASES_M[1] + self.uniform());
            input.baro = Some(BaroReading::AltitudeM(altitude_m + BIASES_M[2] + self.uniform()));
            input.signals =
                Signals { true_airspeed_mps: Some(60.0 + 0.1 * self.uniform()), ..Signals::default() };
        }
        input
    }
}

type Dense = Mission<0, 4, 0>;

/// Flies 40 s; `change` edits each tick before it is processed, `see` gets each output.
fn fly<const H: usize, const T: usize, const E: usize>(
    config: &MissionConfig<E>,
    mut change: impl FnMut(u64, &mut TickInput),
    mut see: impl FnMut(u64, &TickOutput),
) -> Mission<H, T, E> {
    let mut mission = Mission::<H, T, E>::new(config).unwrap();
    let mut flight = Flight { seed: 7, noise: 1.0 };
    for k in 0..8_000 {
        let mut input = flight.tick(k);
        change(k, &mut input);
        see(k, &mission.tick(&input));
    }
    mission
}

fn failed<const H: usize, const T: usize, const E: usize>(mission: &Mission<H, T, E>) -> Vec<&'static str> {
    FailedChecks::from_bits(mission.latch().unwrap().failed_checks).iter().map(Check::name).collect()
}

#[test]
fn a_healthy_flight_is_calibrated_latched_and_trusted() {
    let mut latched = 0;
    let mut phases = Vec::new();
    let mut last = None;
    let mission = fly::<0, 4, 0>(
        &config(true),
        |_, _| {},
        |_, output| {
            latched += u32::from(output.latched_now);
            if phases.last() != Some(&output.phase) {
                phases.push(output.phase);
            }
            last = Some(output.clone());
        },
    );
    assert_eq!(phases, [Phase::Settling, Phase::Calibrating, Phase::FreeFlight]);
    assert_eq!(latched, 1);
    assert_eq!(failed(&mission), [""; 0]);
    let latch = mission.latch().unwrap();
    assert_eq!(latch.time_us, 30_000_000);
    assert!((latch.duration_s - 28.0).abs() < 0.01);
    for (sensor, bias_m) in latch.sensors.iter().zip(BIASES_M) {
        assert!((sensor.bias_m - bias_m).powi(2) < 16.0 * sensor.bias_variance_m2, "{sensor:?} {bias_m}");
        // The residual is the sensor's unit noise and the reference's of 2 m: sqrt(5), from 1,400 readings of
        // 140 fixes.
        assert!((sensor.residual_sigma_m() - 5.0_f32.sqrt()).abs() < 4.0 * 2.2 / 16.7, "{sensor:?}");
        assert_eq!(sensor.readings, 1_400);
    }
    let last = last.unwrap();
    assert_eq!(last.sensors.map(|sensor| sensor.trust), [Trust::Unmonitored, Trust::Trusted, Trust::Trusted]);
    let counters = mission.counters();
    assert_eq!((counters.ticks, counters.out_of_order), (8_000, 0));
    assert_eq!(counters.gps, SourceCounters { accepted: 200, ..SourceCounters::default() });
}

#[test]
fn nothing_changes_in_the_calibration_after_the_latch() {
    let mut at_latch = None;
    fly::<0, 4, 0>(
        &config(true),
        |_, _| {},
        |k, output| {
            let calibration =
                output.sensors.map(|sensor| (sensor.bias_m.to_bits(), sensor.bias_variance_m2.to_bits()));
            if k >= 6_000 {
                assert_eq!(*at_latch.get_or_insert(calibration), calibration, "tick {k}");
            }
        },
    );
}

#[test]
fn both_shapes_agree_where_both_apply() {
    let (mut sparse, mut dense) = (Vec::new(), Vec::new());
    fly::<3, 1, 0>(&config(false), |_, _| {}, |_, output| sparse.push(output.clone()));
    fly::<0, 4, 0>(&config(false), |_, _| {}, |_, output| dense.push(output.clone()));
    for (s, d) in sparse.iter().zip(&dense) {
        for i in 0..3 {
            assert!((s.sensors[i].bias_m - d.sensors[i].bias_m).abs() < 1e-3);
            assert_eq!(s.sensors[i].trust, d.sensors[i].trust);
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused_counted_and_degrade_the_calibration() {
    let healthy = fly::<0, 4, 0>(&config(true), |_, _| {}, |_, _| {});
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mission = fly::<0, 4, 0>(
            &config(true),
            |k, input| match k {
                2_001 => input.baro = Some(BaroReading::AltitudeM(bad)),
                2_002 => input.baro = Some(BaroReading::PressurePa(bad)),
                2_003 => input.imu_slave_altitude_m = Some(bad),
                2_005 => input.gps = Some(GpsFix { altitude_m: bad, ..GpsFix::default() }),
                2_006 => input.signals.true_airspeed_mps = Some(bad),
                _ => {}
            },
            |_, output| {
                for sensor in output.sensors {
                    assert!(sensor.bias_m.is_finite() && sensor.bias_variance_m2 > 0.0);
                }
            },
        );
        let counters = mission.counters();
        assert_eq!(counters.sensors[2].not_finite, 2);
        assert_eq!(counters.sensors[1].not_finite, 1);
        assert_eq!(counters.gps.not_finite, 1);
        assert_eq!(counters.signals_not_finite, 1);
        assert_eq!(failed(&mission), ["inputs_valid"]);
        // They came in addition to the good readings and left no trace in the estimate.
        let biases = |mission: &Dense| mission.latch().unwrap().sensors.map(|sensor| sensor.bias_m);
        assert_eq!(biases(&mission), biases(&healthy));
    }
}

#[test]
fn repeated_and_backward_times_are_ignored_and_counted() {
    let mut ignored = Vec::new();
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| match k {
            3_000 => input.time_us = 2_999 * TICK_US,
            3_004 => input.time_us = 0,
            _ => {}
        },
        |k, output| {
            if output.out_of_order {
                ignored.push(k);
            }
        },
    );
    assert_eq!(ignored, [3_000, 3_004]);
    assert_eq!(mission.counters().out_of_order, 2);
    assert_eq!(failed(&mission), ["inputs_valid"]);
}

#[test]
fn a_stuck_sensor_is_recognised_and_left_out() {
    let mut rejected = 0;
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if k >= 3_000 && input.baro.is_some() {
                input.baro = Some(BaroReading::AltitudeM(2_031.0));
            }
        },
        |_, output| rejected += u32::from(output.sensors[2].rejection == Some(Rejection::Stuck)),
    );
    assert!(rejected > 1_000);
    assert_eq!(mission.counters().sensors[2].stuck, rejected);
    assert!(failed(&mission).contains(&"sensors_alive"));
}

#[test]
fn a_frozen_reference_is_one_measurement_and_leaves_the_sensors_unmonitored() {
    let mut held = None;
    let mut trust = Vec::new();
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if k == 6_200 {
                held = input.gps;
            }
            if k > 6_200 && input.gps.is_some() {
                input.gps = held;
            }
        },
        |k, output| {
            if k > 6_200 + 400 {
                trust.push(output.sensors[2].trust);
            }
        },
    );
    assert!(trust.iter().all(|t| *t == Trust::Unmonitored));
    assert_eq!(mission.counters().gps.held, 44);
}

#[test]
fn a_reference_lost_in_captive_flight_is_a_failed_check() {
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if (2_000..3_000).contains(&k) {
                input.gps = None
            }
        },
        |_, _| {},
    );
    assert_eq!(failed(&mission), ["reference_fresh"]);
    let (latch, biases) = (mission.latch().unwrap(), BIASES_M);
    assert!((latch.sensors[2].bias_m - biases[2]).abs() < 4.0 * latch.sensors[2].bias_variance_m2.sqrt());
}

/// A receiver that has not reported yet is not lost, although the altitude is known without it.
#[test]
fn a_reference_that_comes_late_was_not_lost() {
    let mut knowing = config(true);
    knowing.reference.prior_altitude_m = Some(2_000.0);
    let change = |k, input: &mut TickInput| {
        if k < 1_600 {
            input.gps = None
        }
    };
    assert_eq!(failed(&fly::<0, 4, 0>(&knowing, change, |_, _| {})), [""; 0]);
}

#[test]
fn a_launch_too_early_is_latched_as_what_it_is() {
    // Before settling; and after settling, but before the calibration was long enough.
    for (launch_us, expected) in [(1_000_000, "settled"), (7_000_000, "long_enough")] {
        let mission =
            fly::<0, 4, 0>(&config(true), |_, input| input.launch = input.time_us >= launch_us, |_, _| {});
        assert!(failed(&mission).contains(&expected), "{:?}", failed(&mission));
        assert_eq!(mission.latch().unwrap().time_us, launch_us);
    }
    // In the very first tick: nothing was ever measured, so nothing can be monitored.
    let mut trust = None;
    let mission = fly::<0, 4, 0>(
        &config(true),
        |_, input| input.launch = true,
        |_, output| trust = Some(output.sensors[2].trust),
    );
    assert_eq!(trust, Some(Trust::Unmonitored));
    assert!(failed(&mission).contains(&"settled") && failed(&mission).contains(&"sensors_alive"));
}

#[test]
fn the_first_launch_counts_and_further_edges_are_counted() {
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| input.launch = (4_000..4_500).contains(&k) || k >= 5_000,
        |_, _| {},
    );
    assert_eq!(mission.latch().unwrap().time_us, 20_000_000);
    assert_eq!(mission.counters().launch_repeats, 2);
}

#[test]
fn without_a_launch_nothing_is_latched() {
    let mission = fly::<0, 4, 0>(
        &config(true),
        |_, input| input.launch = false,
        |_, output| {
            assert_ne!(output.phase, Phase::FreeFlight);
        },
    );
    assert_eq!(mission.latch(), None);
}

#[test]
fn an_error_after_launch_is_flagged_and_a_correction_takes_it_off() {
    let drift = |k: u64, input: &mut TickInput| {
        if let (true, Some(BaroReading::AltitudeM(altitude_m))) = (k >= 6_000, input.baro) {
            input.baro = Some(BaroReading::AltitudeM(altitude_m + (k - 6_000) as f32 * 0.015));
        }
    };
    let mut times = [None; 2];
    fly::<0, 4, 0>(&config(true), drift, |k, output| {
        for (time, trust) in times.iter_mut().zip([Trust::Doubtful, Trust::Untrustworthy]) {
            if output.sensors[2].trust == trust {
                time.get_or_insert((k - 6_000) as f32 * 0.005);
            }
        }
        assert_ne!(output.sensors[1].trust, Trust::Doubtful);
    });
    // 3 m/s against an alarm limit of 4 sqrt(5) = 8.9 m: reached after 3 s, earlier with the noise (at most
    // 5.2 m, uniform); by the average half a window later, at the latest.
    let [doubtful, untrustworthy] = times.map(Option::unwrap);
    assert!((1.2..3.3).contains(&doubtful), "{doubtful}");
    assert!(untrustworthy > doubtful && (3.2..4.6).contains(&untrustworthy), "{untrustworthy}");

    for correction in [SecondCorrection::MovingAverage, SecondCorrection::Kalman { wander_m_per_sqrt_s: 3.0 }]
    {
        let mut corrected = config(true);
        corrected.second_correction = correction;
        let mut last = None;
        fly::<0, 4, 0>(&corrected, drift, |_, output| last = output.sensors[2].moving_average_m.or(last));
        assert!(last.unwrap().abs() < 5.0, "{correction:?}: {last:?}");
    }
}

#[test]
fn a_known_effect_is_taken_off_and_an_estimated_one_is_a_state() {
    // 60 m/s captive, 90 m/s free: the port error is a tenth of the dynamic pressure.
    let faster = |k: u64, input: &mut TickInput| {
        let speed = if k < 6_000 { 60.0 } else { 90.0 };
        input.signals.true_airspeed_mps = Some(speed);
        if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
            let head = 0.1 * speed * speed / (2.0 * 9.806_65);
            input.baro = Some(BaroReading::AltitudeM(altitude_m + head));
        }
    };
    let error_end = |config: &MissionConfig<0>| {
        let mut last = None;
        fly::<0, 4, 0>(config, faster, |_, output| last = output.sensors[2].moving_average_m.or(last));
        last.unwrap()
    };
    // Unmodelled: 0.1 (90^2 - 60^2) / 2g = 22.9 m. The average is over 10 fixes of 2 m, and the
    // calibration over 140.
    assert!((error_end(&config(true)) - 22.94).abs() < 5.0 * 0.7);
    let mut known = config(true);
    known.constant_effects.push(EffectTerm::new(EffectId::BaroDynamicPressure, 0.1, 0.01)).unwrap();
    assert!(error_end(&known).abs() < 5.0 * 0.7);

    // As a state it is latched at its prior (a trimmed flight cannot show it) and used from then on.
    let mut estimated = config::<1>(true);
    estimated.estimated_effects[0].coefficient = 0.1;
    estimated.estimated_effects[0].sigma = 0.01;
    let mut last = None;
    let mission =
        fly::<0, 5, 1>(&estimated, faster, |_, output| last = output.sensors[2].moving_average_m.or(last));
    assert!(last.unwrap().abs() < 5.0 * 0.7, "{last:?}");
    assert_eq!(mission.latch().unwrap().state.len(), 5);
    assert_eq!(mission.counters().effects_without_signal, 0);
}

#[test]
fn an_effect_whose_signal_is_missing_is_counted() {
    let mut known = config(false);
    known.constant_effects.push(EffectTerm::new(EffectId::BaroDynamicPressure, 0.1, 0.01)).unwrap();
    let mission = fly::<3, 1, 0>(
        &known,
        |_, input| {
            input.signals.true_airspeed_mps = None;
            if let Some(fix) = &mut input.gps {
                fix.velocity_north_mps = None;
            }
        },
        |_, _| {},
    );
    assert_eq!(mission.counters().effects_without_signal, 2_000);
}

/// Bias variance of the barometer at the latch, and the mean NIS of its readings.
fn variance_and_nis(config: &MissionConfig<0>) -> (f32, f32) {
    let (mut sum, mut count) = (0.0, 0.0);
    let mission = fly::<0, 4, 0>(
        config,
        |_, _| {},
        |k, output| {
            if let (true, Some(nis)) = (k > 1_000, output.sensors[2].signed_nis) {
                sum += nis.abs();
                count += 1.0;
            }
        },
    );
    (mission.latch().unwrap().sensors[2].bias_variance_m2, sum / count)
}

#[test]
fn an_error_that_keeps_its_sign_is_worth_less_but_no_larger() {
    // White: 4/140 of the fixes and 1/1,400 of the readings.
    let (white, nis) = variance_and_nis(&config(false));
    assert!((white / (4.0 / 140.0 + 1.0 / 1_400.0) - 1.0).abs() < 0.05, "{white}");
    // NIS of uniform noise: mean 1, variance 0.8; 1,250 readings.
    assert!((nis - 1.0).abs() < 5.0 * (0.8_f32 / 1_250.0).sqrt(), "{nis}");
    // Correlated over 1 s: a fix every 0.2 s counts as one with 2 tau / dt = 10 times the variance; the first
    // in full, which at 0.286 against 4 is 7 %.
    let mut correlated = config(false);
    correlated.reference.correlation_time_s = 1.0;
    let (variance, nis) = variance_and_nis(&correlated);
    assert!((variance / (1.0 / (1.0 / 4.0 + 139.0 / 40.0) + 1.0 / 1_400.0) - 1.0).abs() < 0.05, "{variance}");
    assert!((0.5..1.2).contains(&nis), "{nis}");
    let mut correlated = config(false);
    correlated.sensors[2].correlation_time_s = 1.0;
    let (_, nis) = variance_and_nis(&correlated);
    // The barometer is weighted with R = 100, but its innovation is judged by its own 1.
    assert!((nis - 1.0).abs() < 0.2, "{nis}");
}

#[test]
fn the_noise_floor_keeps_a_bias_from_becoming_too_sure() {
    let mut wandering = config(false);
    wandering.sensors[2].wander_m_per_sqrt_s = 0.5;
    let (variance, _) = variance_and_nis(&wandering);
    // Steady state of a random walk seen through white noise of density r: sqrt(q r), with r = 4 * 0.2 s of
    // the fixes (the altitude itself is claimed constant, so less of it counts).
    assert!((0.05..0.5).contains(&variance), "{variance}");
    assert!(variance > 1.5 * variance_and_nis(&config(false)).0);
}

#[test]
fn the_climb_rates_error_bounds_what_is_known_of_the_altitude() {
    let mut variance = 0.0;
    fly::<0, 4, 0>(
        &config(true),
        |_, _| {},
        |k, output| {
            if k < 6_000 {
                variance = output.altitude_variance_m2;
            }
        },
    );
    // Steady state of a random walk of 2 sigma^2 tau = 0.16 m^2/s seen through the calibrated sensors,
    // variances 4, 4 and 1 m^2 every 0.02 s: sqrt(0.16 * 0.02 / 1.5) = 0.046. The biases' common part is
    // known from 140 fixes of 4 m^2 only: 0.029 more.
    assert!((variance / (0.046 + 0.029) - 1.0).abs() < 0.15, "{variance}");
}

#[test]
fn a_reference_that_is_still_converging_is_noticed() {
    // Cold start: the altitude converges by 15 m with a time constant of 20 s, Doppler does not.
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if let Some(fix) = &mut input.gps {
                fix.altitude_m += 15.0 * (-(k as f32) * 0.005 / 20.0).exp();
            }
        },
        |_, _| {},
    );
    assert!(failed(&mission).contains(&"reference_converged"), "{:?}", failed(&mission));
}

#[test]
fn a_drifting_sensor_an_untrimmed_flight_and_a_wrong_sigma_have_names() {
    let drifting = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
                input.baro = Some(BaroReading::AltitudeM(altitude_m + k as f32 * 0.002));
            }
        },
        |_, _| {},
    );
    assert!(failed(&drifting).contains(&"biases_stationary"), "{:?}", failed(&drifting));

    let climbing = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            let climbed_m = k as f32 * 0.005;
            if let Some(fix) = &mut input.gps {
                fix.altitude_m += climbed_m;
                fix.velocity_down_mps = fix.velocity_down_mps.map(|down| down - 1.0);
            }
            if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
                input.baro = Some(BaroReading::AltitudeM(altitude_m + climbed_m));
            }
            for altitude_m in
                [&mut input.imu_slave_altitude_m, &mut input.imu_master_altitude_m].into_iter().flatten()
            {
                *altitude_m += climbed_m;
            }
            input.signals.true_airspeed_mps = input.signals.true_airspeed_mps.map(|v| v + climbed_m);
        },
        |_, _| {},
    );
    assert_eq!(failed(&climbing), ["trimmed_altitude", "trimmed_airspeed"]);

    let mut optimistic = config(true);
    optimistic.sensors[2].sigma_m = 0.1;
    optimistic.reference.sigma_m = 0.3;
    let implausible = fly::<0, 4, 0>(&optimistic, |_, _| {}, |_, _| {});
    assert!(failed(&implausible).contains(&"innovations_plausible"), "{:?}", failed(&implausible));
}

#[test]
fn a_calibration_shorter_than_the_references_wander_promises_less() {
    let bound = |correlation_time_s| {
        let mut wandering = config(true);
        wandering.reference.correlation_time_s = correlation_time_s;
        fly::<0, 4, 0>(&wandering, |_, _| {}, |_, _| {}).latch().unwrap().sensors[2]
    };
    // A white reference: four times the spread, as configured.
    let white = bound(0.0);
    assert!((white.bound_m() / (4.0 * white.residual_sigma_m()) - 1.0).abs() < 1e-5);
    // 28 s of a wander of 2 m over 60 s: nearly all of it is in the bias and none in the spread.
    let wandering = bound(60.0);
    let a = 28.0_f32 / 60.0;
    let unseen = 4.0 * 2.0 / a * (1.0 - (1.0 - (-a).exp()) / a);
    let expected = 16.0 * (wandering.residual_variance_m2 + 2.0 * unseen);
    assert!((wandering.bound_m2 / expected - 1.0).abs() < 1e-4, "{wandering:?}");
}

#[test]
fn a_drift_that_the_references_wander_can_make_is_no_sensors() {
    let drifting = |correlation_time_s, slope_m: f32| {
        let mut wandering = config(true);
        wandering.reference.correlation_time_s = correlation_time_s;
        let mission = fly::<0, 4, 0>(
            &wandering,
            |k, input| {
                if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
                    input.baro = Some(BaroReading::AltitudeM(altitude_m + k as f32 * 0.005 * slope_m));
                }
            },
            |_, _| {},
        );
        failed(&mission).contains(&"biases_stationary")
    };
    // 28 s of 2 m over 60 s can drift by 2 sqrt(0.93) = 1.9 m (1 sigma).
    assert!(!drifting(60.0, 4.0 / 28.0), "two sigmas");
    assert!(drifting(60.0, 9.0 / 28.0), "nearly five");
    assert!(drifting(0.0, 4.0 / 28.0), "and a white reference does not wander");
}

/// A drift is allowed as many of the residual's own sigmas as are configured.
#[test]
fn a_drift_within_the_sigmas_that_are_allowed_it_is_none() {
    const DRIFT_M: f32 = 9.0;
    let drifting = |allowed_sigmas| {
        let mut allowing = config(true);
        allowing.quality.bias_drift_sigmas = allowed_sigmas;
        let mission = fly::<0, 4, 0>(
            &allowing,
            |k, input| {
                if let Some(BaroReading::AltitudeM(altitude_m)) = input.baro {
                    input.baro = Some(BaroReading::AltitudeM(altitude_m + k as f32 * 0.005 * DRIFT_M / 28.0));
                }
            },
            |_, _| {},
        );
        let sigma_m = mission.latch().unwrap().sensors[2].residual_sigma_m();
        (failed(&mission).contains(&"biases_stationary"), sigma_m)
    };
    let (is_drift, sigma_m) = drifting(1.0);
    // A ramp of 9 m alone has a spread of 9 / sqrt(12) m, so it is at most 3.5 of its sigmas; noise reduces
    // the number.
    assert!(is_drift && sigma_m > DRIFT_M / 12f32.sqrt(), "{sigma_m}");
    assert!(drifting(0.8 * DRIFT_M / sigma_m).0);
    assert!(!drifting(1.2 * DRIFT_M / sigma_m).0);
}

#[test]
fn a_configuration_out_of_range_is_refused() {
    let refuse = |change: &dyn Fn(&mut MissionConfig<0>)| {
        let mut bad = config(true);
        change(&mut bad);
        Dense::new(&bad).err()
    };
    assert_eq!(refuse(&|_| {}), None);
    for change in [
        &(|c: &mut MissionConfig<0>| c.settling_s = f32::NAN) as &dyn Fn(&mut MissionConfig<0>),
        &|c| c.reference.sigma_m = 0.0,
        &|c| c.reference.lost_after_s = 0.0,
        &|c| c.reference.correlation_time_s = -1.0,
        &|c| c.reference.climb_rate = Some(ClimbRate { sigma_mps: 0.0, correlation_time_s: 2.0 }),
        &|c| c.reference.climb_rate = Some(ClimbRate { sigma_mps: 0.2, correlation_time_s: 0.0 }),
        &|c| c.sensors[1].sigma_m = f32::INFINITY,
        &|c| c.sensors[1].prior_bias_m = f32::NAN,
        &|c| c.sensors[0].wander_m_per_sqrt_s = -1.0,
        &|c| c.monitor.window_s = 0.0,
        &|c| c.monitor.multiplier = f32::NAN,
        &|c| c.second_correction = SecondCorrection::Kalman { wander_m_per_sqrt_s: f32::NAN },
    ] {
        assert_eq!(refuse(change), Some(ConfigError::OutOfRange));
    }
    assert_eq!(Mission::<3, 1, 0>::new(&config(true)).err(), Some(ConfigError::ClimbRateNeedsDenseFilter));
    assert_eq!(Mission::<0, 4, 1>::new(&config(true)).err(), Some(ConfigError::Shape));
}

mod effects;
mod interrupted;
mod outliers;
mod reference;
mod resume;
mod suspicion;
