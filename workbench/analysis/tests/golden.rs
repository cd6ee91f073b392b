//! Golden results: the results of some whole flights stay as they are, number for number.
//!
//! The other tests check what is right. These show what has changed: a number of any result that moves by
//! more than its fourth digit is detected, read by the author of the change, and accepted
//! (`cargo insta review`, or `INSTA_UPDATE=always cargo test -p analysis --test golden`) or not. The flights
//! are generated here, from sines and a generator of random numbers, so the results are the same on every
//! machine.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::ops::ControlFlow;

use analysis::batch::batch;
use analysis::compare::{Options, compare};
use analysis::diagnose::{Diagnosis, NamedReplay, WantedEffect, diagnose, diagnose_further};
use analysis::discover::discover;
use analysis::learn::{NamedFlight, Request, add, ladder};
use analysis::overview::Overview;
use executor::Inline;
use flight_data::Flight;
use kf_core::effect::EffectId;
use model::Model;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use replay::Replay;
use serde::Serialize;
use serde_json::{Number, Value};

const GRAVITY_MPS2: f64 = 9.806_65;
const LAUNCH_S: f64 = 80.0;

/// Pseudo-random numbers between -1 and 1.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || random.random_range(-1.0..1.0)
}

/// The true state of the aircraft.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    altitude_m: f64,
    climb_mps: f64,
    /// Upwards, without gravity.
    acceleration_mps2: f64,
    airspeed_mps: f64,
    roll_rad: f64,
    heading_rad: f64,
}

impl Moment {
    fn at(time_s: f64) -> Self {
        let free = (time_s - LAUNCH_S).max(0.0);
        let (slow, fast) = (time_s / 17.0, free / 5.0);
        Self {
            time_s,
            altitude_m: 1_200.0 + 60.0 * (1.0 - libm::cos(slow)) + 20.0 * (1.0 - libm::cos(fast)),
            climb_mps: 60.0 / 17.0 * libm::sin(slow) + 4.0 * libm::sin(fast),
            acceleration_mps2: 60.0 / 289.0 * libm::cos(slow)
                + if free > 0.0 { 0.8 * libm::cos(fast) } else { 0.0 },
            airspeed_mps: 32.0 + 8.0 * libm::sin(free / 11.0) + 2.0 * libm::sin(time_s / 3.0),
            roll_rad: 0.7 * libm::sin(free / 8.0),
            heading_rad: 0.3 + free / 40.0,
        }
    }

    fn load_factor(&self) -> f64 {
        (1.0 + self.acceleration_mps2 / GRAVITY_MPS2) / libm::cos(self.roll_rad)
    }

    fn dynamic_pressure_m(&self) -> f64 {
        self.airspeed_mps * self.airspeed_mps / (2.0 * GRAVITY_MPS2)
    }

    fn free_s(&self) -> f64 {
        (self.time_s - LAUNCH_S).max(0.0)
    }
}

/// Errors of the sensors of a flight, metres: the barometer's and the inertial altitude's, and the delay of
/// the receiver, seconds.
struct Errors<'a> {
    baro_m: &'a dyn Fn(Moment) -> f64,
    inertial_m: &'a dyn Fn(Moment) -> f64,
    late_s: f64,
}

const NONE: Errors<'_> = Errors { baro_m: &|_| 0.0, inertial_m: &|_| 0.0, late_s: 0.0 };

/// A flight under a mother ship and on its own with every column, at 10 Hz with five fixes a second.
fn flight(seed: u64, errors: &Errors<'_>) -> Flight {
    let mut random = random(seed);
    let mut csv = "# pylon-flight: 1\n# vehicle: golden\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m,baro_temp_c,\
        imu_master_alt_m,imu_slave_alt_m,accel_x_mps2,accel_y_mps2,accel_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps,roll_rad,\
        pitch_rad,yaw_rad,tas_mps,aoa_rad,sideslip_rad,throttle,oat_c\n"
        .to_owned();
    let mut wander_m = 0.0;
    for row in 0..2_600_u32 {
        let time_s = f64::from(row) * 0.1;
        let now = Moment::at(time_s);
        let launch = u8::from(time_s >= LAUNCH_S);
        wander_m += 0.05 * random() - 0.002 * wander_m;
        let fix = if row % 2 == 0 {
            let seen = Moment::at(time_s - errors.late_s);
            let north_mps = seen.airspeed_mps * libm::cos(seen.heading_rad) + 3.0;
            let east_mps = seen.airspeed_mps * libm::sin(seen.heading_rad) - 2.0;
            format!(
                "{:.3},{north_mps:.3},{east_mps:.3},{:.3}",
                seen.altitude_m + wander_m + 0.2 * random(),
                -seen.climb_mps + 0.03 * random()
            )
        } else {
            ",,,".to_owned()
        };
        let baro_m = now.altitude_m + 4.0 + (errors.baro_m)(now) + 0.3 * random();
        let temperature_c = 20.0 - 8.0 * (1.0 - libm::exp(-time_s / 90.0));
        let master =
            if launch == 0 { format!("{:.3}", now.altitude_m - 2.0 + 0.4 * random()) } else { String::new() };
        let inertial_m = now.altitude_m - 7.0 + (errors.inertial_m)(now) + 0.2 * random();
        let load = now.load_factor() * GRAVITY_MPS2;
        let pitch_rad = now.climb_mps / now.airspeed_mps + 0.04;
        let angle_rad = 0.04 * now.load_factor() * (32.0 / now.airspeed_mps) * (32.0 / now.airspeed_mps);
        let _ = writeln!(
            csv,
            "{time_s:.1},{launch},{fix},{baro_m:.3},{temperature_c:.3},{master},{inertial_m:.3},{:.3},{:.3},{:.3},{:.4},{:.4},{:.4},{:.4},\
             {pitch_rad:.4},{:.4},{:.3},{angle_rad:.5},{:.5},{:.4},{:.2}",
            0.3 * libm::sin(time_s / 6.0),
            0.1 * random(),
            -load + 0.1 * random(),
            0.7 / 8.0 * libm::cos(now.free_s() / 8.0) + 0.02 * random(),
            0.01 * random(),
            1.0 / 40.0,
            now.roll_rad,
            now.heading_rad,
            now.airspeed_mps + 0.1 * random(),
            0.01 * libm::sin(time_s / 4.0),
            0.5 + 0.3 * libm::sin(time_s / 13.0),
            15.0 - 0.0065 * now.altitude_m,
        );
    }
    flight_data::parse(csv.as_bytes()).unwrap().0
}

/// A glider's log: a quarter of an hour at 1 Hz without a launch or a climb rate, on the ground for its first
/// two minutes.
fn glider(seed: u64, late_s: f64, scale: f64) -> Flight {
    let mut random = random(seed);
    let mut csv = "# pylon-flight: 1\ntime_s,gps_alt_m,gps_vn_mps,gps_ve_mps,baro_alt_m\n".to_owned();
    let height_m = |time_s: f64| {
        let airborne = (time_s - 120.0).max(0.0);
        600.0 * (1.0 - libm::cos(airborne / 180.0)) + 40.0 * (1.0 - libm::cos(airborne / 21.0))
    };
    let mut wander_m = 0.0;
    for row in 0..900_u32 {
        let time_s = f64::from(row);
        wander_m += 0.3 * random() - 0.02 * wander_m;
        let speed_mps = if time_s < 120.0 { 0.0 } else { 28.0 + 3.0 * libm::sin(time_s / 15.0) };
        let _ = writeln!(
            csv,
            "{time_s},{:.1},{:.2},{:.2},{:.1}",
            410.0 + height_m(time_s) + wander_m,
            speed_mps * libm::cos(time_s / 60.0),
            speed_mps * libm::sin(time_s / 60.0),
            400.0 + (1.0 + scale) * height_m(time_s - late_s) + 0.5 * random()
        );
    }
    flight_data::parse(csv.as_bytes()).unwrap().0
}

fn static_port(now: Moment) -> f64 {
    0.12 * (now.dynamic_pressure_m() - 52.0)
}

fn accelerometer_bias(now: Moment) -> f64 {
    0.5 * 0.002 * now.free_s() * now.free_s()
}

/// Rounds numbers to four digits, so that a smaller change is not a change.
fn rounded(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(rounded),
        Value::Object(values) => values.values_mut().for_each(rounded),
        Value::Number(number) if number.is_f64() => {
            let short: f64 = format!("{:.3e}", number.as_f64().unwrap()).parse().unwrap();
            *number = Number::from_f64(short).unwrap();
        }
        _ => {}
    }
}

/// Compares a result with the one that is kept under that name.
fn assert_golden(name: &str, result: &impl Serialize) {
    let mut value = serde_json::to_value(result).unwrap();
    rounded(&mut value);
    insta::assert_snapshot!(name, serde_json::to_string_pretty(&value).unwrap());
}

fn go_on() -> impl FnMut() -> ControlFlow<()> {
    || ControlFlow::Continue(())
}

fn named<'a>(flights: &'a [Flight], model: &Model) -> Vec<NamedReplay<'a>> {
    let replays = flights.iter().enumerate().map(|(k, flight)| {
        NamedReplay::new(format!("{k}.csv"), Replay::to_diagnose(flight, model, None).unwrap())
    });
    replays.collect()
}

fn diagnosed(model: &Model, flights: &[Flight], held_out: &[Flight]) -> Diagnosis {
    diagnose(&named(flights, model), &named(held_out, model), &mut go_on(), &Inline).unwrap()
}

const KNOWN: &str = "[[effect]]\nid = \"baro.dynamic_pressure\"\ncoefficient = 0.1\nsigma = 0.01\n\n\
    [[revision]]\nnumber = 1\neffect = \"baro.dynamic_pressure\"\ncoefficient = 0.1\nsigma = 0.01\n";

#[test]
fn two_sensors_effects_on_one_flight() {
    let errors = Errors { baro_m: &static_port, inertial_m: &accelerometer_bias, ..NONE };
    assert_golden("two_sensors_effects", &diagnosed(&Model::default(), &[flight(1, &errors)], &[]));
}

#[test]
fn a_late_receiver() {
    let errors = Errors { late_s: 0.5, ..NONE };
    assert_golden("a_late_receiver", &diagnosed(&Model::default(), &[flight(2, &errors)], &[]));
}

#[test]
fn effects_that_one_flight_does_not_tell_apart() {
    let baro_m = |now: Moment| 0.5 * (20.0 - 8.0 * (1.0 - libm::exp(-now.time_s / 90.0)) - 14.0);
    let inertial_m = |now: Moment| 0.03 * now.free_s();
    let errors = Errors { baro_m: &baro_m, inertial_m: &inertial_m, ..NONE };
    assert_golden("sets", &diagnosed(&Model::default(), &[flight(3, &errors)], &[]));
}

#[test]
fn what_no_effect_is_and_what_nothing_is() {
    let steps = |now: Moment| if now.free_s() > 60.0 && now.free_s() < 110.0 { 6.0 } else { 0.0 };
    let errors = Errors { baro_m: &steps, ..NONE };
    let found = [&errors, &NONE].map(|errors| diagnosed(&Model::default(), &[flight(4, errors)], &[]));
    assert_golden("unknown_and_nothing", &found);
}

#[test]
fn two_flights_together_and_one_held_out() {
    let errors = Errors { baro_m: &|now| static_port(now) - 0.4 * now.climb_mps, ..NONE };
    let flights = [5, 6].map(|seed| flight(seed, &errors));
    assert_golden("together", &diagnosed(&Model::default(), &flights, &[flight(7, &errors)]));
}

#[test]
fn a_flight_under_a_model_that_has_an_effect_already() {
    let errors = Errors { baro_m: &|now| static_port(now) + 0.004 * (now.altitude_m - 1_200.0), ..NONE };
    assert_golden("known_effect", &diagnosed(&Model::parse(KNOWN).unwrap(), &[flight(8, &errors)], &[]));
}

#[test]
fn a_log_without_a_climb_rate() {
    assert_golden("glider", &diagnosed(&Model::default(), &[glider(9, 2.0, 0.03)], &[glider(10, 2.0, 0.03)]));
}

#[test]
fn flights_one_by_one_and_their_vehicles() {
    let ports = [0.08, 0.09, 0.10, 0.2];
    let flights: Vec<Flight> = ports
        .iter()
        .zip(20..)
        .map(|(port, seed)| flight(seed, &Errors { baro_m: &|now| port / 0.12 * static_port(now), ..NONE }))
        .collect();
    let model = Model::default();
    let replays = named(&flights, &model);
    let together = diagnose(&replays, &[], &mut go_on(), &Inline).unwrap();
    assert_golden("batch", &batch(&replays, Some(&together), &|| (), &Inline));
}

#[test]
fn a_comparison() {
    let errors = Errors { baro_m: &|now| static_port(now) + 0.1 * now.free_s(), ..NONE };
    let flight = flight(11, &errors);
    let options = Options { trace_slots: Some(20), ..Options::default() };
    for (name, text) in [("comparison", ""), ("comparison_known_effect", KNOWN)] {
        let replay = Replay::new(&flight, &Model::parse(text).unwrap(), None).unwrap();
        let (comparison, _) = compare(&replay, &options, &mut |_| (), &Inline).unwrap();
        assert_golden(name, &comparison);
    }
    assert_golden("overview", &Overview::new("a.csv", "pylon", &flight, &[], None));
}

#[test]
fn an_addition_and_its_ladder() {
    let errors = Errors { baro_m: &static_port, ..NONE };
    let (learning, held_out) = (flight(12, &errors), flight(13, &errors));
    let wanted = WantedEffect { effect: EffectId::BaroDynamicPressure, time_constant_s: None, since: None };
    for (name, text, held) in [("addition", "", false), ("addition_held_out", KNOWN, true)] {
        let request = Request {
            text,
            wanted,
            estimate: held,
            date: time::Date::from_calendar_date(2026, time::Month::November, 26).unwrap(),
            learning: vec![NamedFlight::new("a.csv", &learning)],
            held_out: if held { vec![NamedFlight::new("b.csv", &held_out)] } else { Vec::new() },
        };
        assert_golden(name, &add(&request, &mut go_on(), &Inline).unwrap());
    }
    let flights = [NamedFlight::new("a.csv", &learning), NamedFlight::new("b.csv", &held_out)];
    assert_golden("ladder", &ladder(&Model::parse(KNOWN).unwrap(), &flights, &mut |_| ()).unwrap());
}

#[test]
fn a_law_that_the_catalogue_lacks() {
    let baro_m = |now: Moment| 6.0 * now.roll_rad * now.roll_rad;
    let flights = [flight(14, &Errors { baro_m: &baro_m, ..NONE })];
    let model = Model::default();
    assert_golden("law", &discover(&named(&flights, &model), &[], &mut go_on(), &Inline).unwrap());
}

#[test]
fn a_plan() {
    let errors = Errors { baro_m: &|now| 0.03 * now.free_s(), ..NONE };
    let (flights, next) = ([flight(16, &errors)], flight(17, &NONE));
    let model = Model::default();
    let replays = named(&flights, &model);
    let (_, further) = diagnose_further(&replays, &[], &mut go_on(), &Inline).unwrap();
    let planned = Replay::to_diagnose(&next, &model, None).unwrap();
    assert_golden("plan", &further.unwrap().planner.outlook(&planned, &Inline));
}
