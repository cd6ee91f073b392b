//! The consequences of a fault that `pylon fly --fault` reports, for flights on the host: no emulator is
//! needed.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::sync::OnceLock;

use model::Model;
use pylon::flight::{Channel, Flight};
use pylon::fly::{Consequence, PlannedFault, consequence};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};

/// Launch of the flight, seconds.
const LAUNCH_S: f64 = 60.0;

/// The quickstart's flight, with a minute of captive flight and a dive.
fn flight() -> &'static Flight {
    static FLIGHT: OnceLock<Flight> = OnceLock::new();
    FLIGHT.get_or_init(|| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
        let mut scenario = load_scenario(&file).unwrap();
        scenario.captive.duration_s = LAUNCH_S;
        scenario.free_flight.truncate(3);
        simulate(&scenario, scenario.seed).unwrap().0
    })
}

fn of(fault: &str) -> (Consequence, String) {
    of_flight(flight(), fault)
}

fn of_flight(flight: &Flight, fault: &str) -> (Consequence, String) {
    let model = Model::default();
    let replay = Replay::new(flight, &model, None).unwrap();
    let fault: PlannedFault = fault.parse().unwrap();
    let found = consequence(replay.inputs(), replay.model(), &[fault]).unwrap();
    let text = found.to_string();
    println!("{text}");
    (found, text)
}

/// The first line that begins with this name.
fn line<'a>(text: &'a str, name: &str) -> &'a str {
    text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{name}: {text}"))
}

#[test]
fn a_bit_flipped_in_one_frame_of_the_receiver_does_nothing_that_matters() {
    let (found, text) = of("gps flip-bits=0x10 30");
    assert!(found.ticks_that_differ > 0, "{text}");
    assert_eq!(found.calibration.quality.clean, found.calibration.quality.with_fault);
    assert!(line(&text, "calibration").ends_with("as without the fault"), "{text}");
    assert_eq!(line(&text, "launch decided").matches("as without the fault").count(), 1, "{text}");
    // One fix of about 300: a few hundredths of a sigma.
    for (sensor, bias) in &found.calibration.sensors {
        assert!(bias.difference_m != 0.0 && bias.difference_in_sigmas.abs() < 0.5, "{sensor}: {bias:?}");
    }
    assert!(found.captive_altitude.unwrap().peak_m < 1.0, "{text}");
    for flags in found.flags.values() {
        assert_eq!(flags.unmonitored_s.clean, flags.unmonitored_s.with_fault);
    }
}

#[test]
fn a_barometer_stuck_in_free_flight_is_silent_and_leaves_the_calibration_alone() {
    let (found, text) = of("baro stuck-low 65..70");
    let silent_s = found.not_delivering_s["baro"];
    // Its initialisation takes some tenths of a second in addition.
    assert!((5.0..6.0).contains(&silent_s), "{silent_s}");
    assert!(line(&text, "not delivering").contains(&format!("baro for {silent_s:.3} s")), "{text}");
    assert_eq!(found.not_delivering_s["imu"], 0.0);
    for (sensor, bias) in &found.calibration.sensors {
        assert_eq!(bias.difference_m, 0.0, "{sensor}");
        assert!(line(&text, sensor).contains("not moved"), "{text}");
    }
    assert_eq!(found.captive_altitude.unwrap().peak_m, 0.0);
    assert_eq!(found.free_flight_altitude["imu_slave"].peak_m, 0.0, "nobody else is touched");
    assert!(found.polls_failed.with_fault > 0);
    assert!(found.ticks_that_differ > 900);
}

#[test]
fn an_inertial_unit_that_resets_in_captive_flight_is_said_with_what_its_altitude_lost() {
    // The inertial altitude is then computed from the unit's samples.
    let mut flight = flight().clone();
    flight.channels.retain(|(channel, _)| *channel != Channel::ImuSlaveAltM);
    let (found, text) = of_flight(&flight, "imu reset 30");
    let silent_s = found.not_delivering_s["imu"];
    assert!((0.005..0.5).contains(&silent_s), "{silent_s}");
    assert!(line(&text, "not delivering").contains("imu for"), "{text}");
    assert_eq!(found.not_delivering_s["baro"], 0.0);
    assert!(found.calibration.sensors["imu_slave"].difference_m != 0.0, "{text}");
    assert!(line(&text, "captive flight").contains("rms from the clean run's"), "{text}");
}
