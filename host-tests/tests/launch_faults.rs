//! One fault of the umbilical, of a chip, or of both, on the whole chain from the chips' registers to the
//! mission: no such fault is a launch while the vehicle hangs under its pylon, and none hides a release.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::flown::{Chip, ChipFault, Fault, ModelledSuite};
use flight_computer::{FlightComputer, Interruptible, Onboard, ResetFacts};
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, TickInput};
use kf_core::launch::{LaunchConfig, WireCondition};
use kf_core::output::{Phase, TickOutput};
use kf_core::quality::{Check, FailedChecks};
use kf_core::strapdown;
use model::Model;
use pylon::replay::{AnyMission, mission};
use survival::{ResetSource, RetainedImage, Start};

const TICK_US: u64 = 5_000;
const FIRST_US: u64 = 1_000_000;
/// Times at which faults begin and the vehicle is released, seconds.
const FAULT_S: f32 = 25.0;
const RELEASE_S: f32 = 45.0;
const END_S: f32 = 55.0;

/// White noise of unit variance: uniform, from Numerical Recipes' 32-bit generator.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((self.0 >> 8) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6
    }
}

/// Level flight under the pylon, in light turbulence; from the release on a fall at a load factor, until a
/// second later the vehicle flies on its own wings.
fn flight(released: bool, load: f32) -> Vec<TickInput> {
    flight_until(END_S, released, load)
}

fn flight_until(end_s: f32, released: bool, load: f32) -> Vec<TickInput> {
    let mut noise = Noise(11);
    let (mut altitude_m, mut climb_mps, mut gust) = (2_000.0_f32, 0.0_f32, 0.0_f32);
    (0..(end_s * 200.0) as u64)
        .map(|k| {
            let time_s = k as f32 * 0.005;
            let is_free = released && time_s >= RELEASE_S;
            // Gusts lasting half a second, 0.03 g.
            gust += 0.03 * 0.14 * noise.next() - 0.01 * gust;
            let load = if is_free && time_s < RELEASE_S + 1.0 { load } else { 1.0 + gust };
            climb_mps += (load - 1.0) * 9.81 * 0.005;
            altitude_m += climb_mps * 0.005;
            let shake = if is_free { 0.6 } else { 0.2 };
            TickInput {
                time_us: FIRST_US + k * TICK_US,
                launch: is_free,
                gps: k.is_multiple_of(20).then(|| GpsFix {
                    altitude_m: altitude_m + noise.next(),
                    velocity_north_mps: Some(30.0),
                    velocity_east_mps: Some(0.0),
                    velocity_down_mps: Some(0.1 * noise.next() - climb_mps),
                    vertical_accuracy_m: Some(1.5),
                    satellites: Some(15),
                    fix_time_us: None,
                }),
                baro: k.is_multiple_of(4).then(|| {
                    BaroReading::PressurePa(79_495.0 - (altitude_m - 2_000.0) * 9.87 + 3.0 * noise.next())
                }),
                imu_master_altitude_m: k.is_multiple_of(4).then(|| altitude_m + 12.0 + noise.next()),
                imu: Some(ImuSample {
                    accel_mps2: [
                        shake * noise.next(),
                        shake * noise.next(),
                        -9.81 * load + shake * noise.next(),
                    ],
                    gyro_radps: [0.01 * noise.next(), 0.01 * noise.next(), 0.01 * noise.next()],
                }),
                ..TickInput::default()
            }
        })
        .collect()
}

/// The result of a flight.
#[derive(Debug)]
struct Outcome {
    /// Time of the reported launch, seconds.
    launched_s: Option<f32>,
    checks: Option<FailedChecks>,
    /// Ticks in which no calibration data was taken.
    held: u32,
    masters_after_fault: u32,
    wire: WireCondition,
    last: TickOutput,
}

type Computer = FlightComputer<ModelledSuite<()>, Box<dyn AnyMission>>;

fn fly(flight: &[TickInput], faults: &[(f32, Chip, Fault)]) -> Outcome {
    let model = Model { settling_s: 2.0, ..Model::default() };
    let onboard = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS).unwrap();
    let mut computer: Computer =
        FlightComputer::on_board(ModelledSuite::new(&()), mission(&model).unwrap(), onboard);
    let mut outcome = (None, 0, 0);
    let mut last = None;
    for (k, input) in flight.iter().enumerate() {
        let time_s = k as f32 * 0.005;
        for &(_, chip, fault) in faults.iter().filter(|(at_s, ..)| (at_s - time_s).abs() < 0.001) {
            computer.sensors.inject(ChipFault { chip, fault });
        }
        computer.sensors.load(input);
        let step = computer.tick(input.time_us);
        if step.input.launch {
            outcome.0.get_or_insert(time_s);
        }
        outcome.1 += u32::from(step.input.launch_doubt == LaunchDoubt::Suspected);
        let is_later = (FAULT_S + 1.0..RELEASE_S).contains(&time_s);
        outcome.2 += u32::from(is_later && step.input.imu_master_altitude_m.is_some());
        last = Some(step.output);
    }
    assert_eq!(computer.sensors.counts().impossible_faults, 0);
    Outcome {
        launched_s: outcome.0,
        checks: computer.mission.latch().map(|latch| FailedChecks::from_bits(latch.failed_checks)),
        held: outcome.1,
        masters_after_fault: outcome.2,
        wire: computer.onboard.as_ref().unwrap().launch().wire(),
        last: last.unwrap(),
    }
}

const BOUNCES: Fault = Fault::Bounces { open_us: 60_000, closed_us: 100_000, seed: 3 };
const STRANGER: Fault = Fault::Stranger { system: 9, component: 1, altitude_m: 9_000 };

/// All faults of the umbilical, and those of the accelerometer that could be mistaken for a launch.
const FAULTS: [(Chip, Fault); 15] = [
    (Chip::Wire, Fault::Open),
    (Chip::Wire, Fault::Shorted),
    (Chip::Wire, Fault::Unreadable),
    (Chip::Wire, BOUNCES),
    (Chip::Umbilical, Fault::Torn),
    (Chip::Umbilical, Fault::Unplugged),
    (Chip::Umbilical, Fault::Silent),
    (Chip::Umbilical, Fault::Garbage { seed: 5 }),
    (Chip::Umbilical, STRANGER),
    (Chip::Umbilical, Fault::Lies { by_m: 100_000 }),
    (Chip::Umbilical, Fault::NotANumber),
    (Chip::Imu, Fault::StuckLow),
    (Chip::Imu, Fault::StuckHigh),
    (Chip::Imu, Fault::Stalled),
    (Chip::Imu, Fault::BusError),
];

#[test]
fn no_single_fault_is_a_launch() {
    let captive = flight(false, 1.0);
    for (chip, fault) in FAULTS {
        let outcome = fly(&captive, &[(FAULT_S, chip, fault)]);
        assert_eq!(outcome.launched_s, None, "{chip:?} {fault:?}: {outcome:?}");
        assert_ne!(outcome.last.phase, Phase::FreeFlight);
    }
}

/// A broken wire costs the calibration a moment, and the mother ship's altitude nothing.
#[test]
fn a_broken_wire_is_found_and_the_mother_ship_goes_on_being_heard() {
    let captive = flight(false, 1.0);
    let sound = fly(&captive, &[]);
    let broken = fly(&captive, &[(FAULT_S, Chip::Wire, Fault::Open)]);
    assert_eq!(broken.wire, WireCondition::Broken);
    // Until a message arrives after the window of 0.25 s.
    assert!((50..60).contains(&broken.held), "{broken:?}");
    assert_eq!((broken.masters_after_fault, sound.held), (sound.masters_after_fault, 0));
}

/// Two faults: the wire and another chip, or the wire and the rest of the umbilical.
#[test]
fn a_wire_that_breaks_with_another_fault_is_no_launch() {
    let captive = flight(false, 1.0);
    for (chip, fault) in FAULTS.into_iter().filter(|(chip, _)| *chip != Chip::Wire) {
        for (first_s, second_s) in [(FAULT_S, FAULT_S + 5.0), (FAULT_S + 5.0, FAULT_S), (FAULT_S, FAULT_S)] {
            let outcome = fly(&captive, &[(first_s, Chip::Wire, Fault::Open), (second_s, chip, fault)]);
            assert_eq!(outcome.launched_s, None, "{chip:?} {fault:?} {first_s}: {outcome:?}");
        }
    }
}

/// A torn cable with a dead inertial unit is not a launch while the receiver's climb rate shows none. If
/// nothing is left that could contradict it, it is a launch, clearly reported as unconfirmed.
#[test]
fn a_torn_cable_without_a_witness_is_not_confirmed() {
    let captive = flight(false, 1.0);
    for fault in [Fault::Stalled, Fault::StuckLow, Fault::Frozen, Fault::Garbage { seed: 7 }] {
        let two = [(FAULT_S - 5.0, Chip::Imu, fault), (FAULT_S, Chip::Umbilical, Fault::Torn)];
        let outcome = fly(&captive, &two);
        assert_eq!(outcome.launched_s, None, "{fault:?}: {outcome:?}");
        let outcome = fly(&captive, &[two[0], two[1], (FAULT_S, Chip::Gps, Fault::Unplugged)]);
        assert!(outcome.checks.is_some_and(|failed| failed.contains(Check::LaunchConfirmed)), "{outcome:?}");
    }
}

/// A missing receiver is not a missing witness: a vehicle that leaves the pylon feels it.
#[test]
fn a_torn_cable_is_no_launch_without_a_receiver_either() {
    let torn = [(FAULT_S - 5.0, Chip::Gps, Fault::Unplugged), (FAULT_S, Chip::Umbilical, Fault::Torn)];
    let outcome = fly(&flight(false, 1.0), &torn);
    assert_eq!(outcome.launched_s, None, "{outcome:?}");
    // A release without a receiver is detected.
    let released = fly(&flight(true, 0.4), &[(FAULT_S, Chip::Gps, Fault::Unplugged)]);
    assert!(released.launched_s.is_some_and(|at_s| at_s < RELEASE_S + 1.0), "{released:?}");
}

/// A release with a fall is found through every fault but a shorted wire. A release of a vehicle that flies
/// on its own wings also needs a wire that can be read, and a cable that was whole. If its inertial unit is
/// dead too, only the wire shows the release, and it is accepted after a minute.
#[test]
fn no_single_fault_hides_a_release() {
    for (load, name) in [(0.4, "falls"), (1.0, "carries itself")] {
        let flight = flight_until(RELEASE_S + 61.0, true, load);
        let sound = fly(&flight, &[]);
        assert!(sound.launched_s.is_some_and(|at_s| at_s < RELEASE_S + 1.0), "{name}: {sound:?}");
        assert!(sound.checks.is_some_and(|failed| !failed.contains(Check::LaunchConfirmed)));
        for (chip, fault) in FAULTS {
            let outcome = fly(&flight, &[(FAULT_S, chip, fault)]);
            // Without a fall, an unreadable wire or a torn cable leaves no evidence.
            let says_nothing = matches!(fault, Fault::Shorted | Fault::Unreadable | Fault::Torn);
            if fault == Fault::Shorted || (load == 1.0 && says_nothing) {
                continue;
            }
            let is_unshown = load == 1.0 && chip == Chip::Imu;
            let latest_s = RELEASE_S + if is_unshown { 60.1 } else { 3.1 };
            assert!(
                outcome.launched_s.is_some_and(|at_s| (RELEASE_S..latest_s).contains(&at_s)),
                "{name} {chip:?} {fault:?}: {outcome:?}"
            );
        }
    }
}

/// Noise on the open line after a launch has no effect.
#[test]
fn a_line_that_floats_after_a_launch_is_not_read() {
    let flight = flight(true, 0.4);
    let sound = fly(&flight, &[]);
    let floating = fly(&flight, &[(RELEASE_S + 2.0, Chip::Umbilical, Fault::Garbage { seed: 1 })]);
    assert_eq!(sound.last, floating.last);
    assert_eq!(sound.launched_s, floating.launched_s);
}

/// A cable that tore under the pylon, and a minute later a dip of the supply: what opened before the dip is
/// no evidence of a release during it. A wire that opens during the dip is.
#[test]
fn a_dip_of_the_supply_makes_no_launch_of_a_wire_that_was_known_to_be_broken() {
    let flight = flight(false, 1.0);
    let dip = (40.0 * 200.0) as usize;
    for (tears_s, is_launch) in [(FAULT_S, false), (40.2, true)] {
        let mut memory = RetainedImage::default();
        let mut sensors = ModelledSuite::new(&());
        let (mut next, mut now_us, mut launched) = (0, FIRST_US, false);
        for (end, source) in [(dip, None), (flight.len(), Some(true))] {
            let model = Model { settling_s: 2.0, ..Model::default() };
            let onboard = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS).unwrap();
            let facts = ResetFacts::host(ResetSource::Supply, source.or(Some(false)));
            memory.restore_supply();
            sensors.restart();
            let mission = mission(&model).unwrap();
            let mut run =
                Interruptible::start(sensors, mission, Some(onboard), &mut memory, 7, facts).unwrap();
            if let Some(report) = run.report() {
                assert_eq!(report.start, Start::Captive, "{report:?}");
                now_us = now_us.max(report.resumed_us);
            }
            for (k, input) in flight.iter().enumerate().take(end).skip(next) {
                if (k as f32 * 0.005 - tears_s).abs() < 0.001 {
                    run.computer.sensors.inject(ChipFault { chip: Chip::Umbilical, fault: Fault::Torn });
                }
                now_us += TICK_US;
                run.computer.sensors.load(&TickInput { time_us: now_us, ..*input });
                launched |= run.tick(&mut memory, now_us).input.launch;
            }
            // The supply is away for 0.2 s.
            next = end + 40;
            sensors = run.computer.sensors;
        }
        assert_eq!(launched, is_launch, "torn at {tears_s} s");
    }
}
