//! Faults of the umbilical on the models of the whole board, and what the sensors then report.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::flown::{Chip, ChipFault, Fault, ModelledSuite};
use drivers::Sensors;
use kf_core::input::TickInput;

const TICK_US: u64 = 5_000;
/// Ticks from one altitude of the mother ship to the next.
const EVERY: u64 = 10;
const ALTITUDE_M: f32 = 2_000.0;

struct Bench {
    suite: ModelledSuite<()>,
    tick: u64,
}

/// What arrived in a stretch of time.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    altitudes: Vec<f32>,
    open: u32,
    unreadable: u32,
    failed_polls: u32,
}

impl Bench {
    fn new() -> Self {
        Self { suite: ModelledSuite::new(&()), tick: 0 }
    }

    fn run(&mut self, ticks: u64, has_left: bool) -> Seen {
        let mut seen = Seen::default();
        let before = self.suite.faults().count;
        for _ in 0..ticks {
            self.tick += 1;
            let now_us = self.tick * TICK_US;
            self.suite.load(&TickInput {
                time_us: now_us,
                launch: has_left,
                imu_master_altitude_m: self.tick.is_multiple_of(EVERY).then_some(ALTITUDE_M),
                ..TickInput::default()
            });
            seen.altitudes.extend(self.suite.poll(now_us).imu_master_altitude_m);
            match self.suite.wire() {
                Some(is_open) => seen.open += u32::from(is_open),
                None => seen.unreadable += 1,
            }
        }
        seen.failed_polls = self.suite.faults().count - before;
        seen
    }

    fn fail(&mut self, chip: Chip, fault: Fault) {
        self.suite.inject(ChipFault { chip, fault });
    }
}

#[test]
fn each_fault_of_the_mother_ship_is_what_its_name_says() {
    let mut bench = Bench::new();
    bench.run(100, false);
    let sound = bench.run(100, false);
    assert_eq!((sound.altitudes.as_slice(), sound.failed_polls), ([ALTITUDE_M; 10].as_slice(), 0));

    bench.fail(Chip::Umbilical, Fault::Lies { by_m: 300 });
    bench.run(10, false);
    assert_eq!(bench.run(100, false).altitudes, [ALTITUDE_M + 300.0; 10]);
    bench.fail(Chip::Umbilical, Fault::Holds);
    bench.run(10, false);
    assert_eq!(bench.run(100, false).altitudes, [ALTITUDE_M + 300.0; 10], "the last that was sent");
    for fault in [Fault::Silent, Fault::Unplugged, Fault::Garbage { seed: 1 }] {
        bench.fail(Chip::Umbilical, fault);
        bench.run(10, false);
        assert_eq!(bench.run(150, false).altitudes, [] as [f32; 0], "{fault:?}");
    }
    bench.fail(Chip::Umbilical, Fault::None);
    bench.run(20, false);
    assert_eq!(bench.run(100, false).altitudes, [ALTITUDE_M; 10]);
    assert_eq!(bench.suite.counts().impossible_faults, 0);
    bench.fail(Chip::Wire, Fault::Reset);
    assert_eq!(bench.suite.counts().impossible_faults, 1);
}

#[test]
fn the_wire_is_what_its_fault_says_and_not_what_the_flight_has() {
    let mut bench = Bench::new();
    bench.run(100, false);
    for (fault, open, unreadable) in
        [(Fault::Open, 40, 0), (Fault::Shorted, 0, 0), (Fault::Unreadable, 0, 40), (Fault::None, 0, 0)]
    {
        bench.fail(Chip::Wire, fault);
        let seen = bench.run(40, false);
        assert_eq!((seen.open, seen.unreadable), (open, unreadable), "{fault:?}");
    }
    bench.fail(Chip::Wire, Fault::Shorted);
    assert_eq!(bench.run(40, true).open, 0);
    bench.fail(Chip::Wire, Fault::None);
    assert_eq!(bench.run(40, true).open, 40);
}

#[test]
fn a_torn_cable_opens_the_wire_and_silences_the_line_at_the_same_tick() {
    let mut bench = Bench::new();
    bench.run(100, false);
    bench.fail(Chip::Umbilical, Fault::Torn);
    let torn = bench.run(100, false);
    assert_eq!((torn.open, torn.altitudes.len()), (100, 0));
    bench.fail(Chip::Umbilical, Fault::None);
    bench.run(20, false);
    let whole = bench.run(100, false);
    assert_eq!((whole.open, whole.altitudes.len()), (0, 10));
}
