//! Every transient of every chip of the board costs its sensor no more than its own duration and half a
//! second, and the samples after it are correct.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::flown::{Chip, ChipFault, Fault, ModelledSuite, Quantity};
use drivers::Sensors;
use kf_core::input::{BaroReading, GpsFix, ImuSample, TickInput};

const TICK_US: u64 = 5_000;
/// Ticks in a second.
const SECOND: u64 = 200;
/// Largest cost of a fault beyond its duration, ticks.
const BEYOND: u64 = SECOND / 2;
/// Ticks from one fix to the next.
const FIX_EVERY: u64 = 20;
const PRESSURE_PA: f32 = 79_500.0;
const ALTITUDE_M: f32 = 2_000.0;
const FORCE_MPS2: f32 = -9.806_65;

struct Bench {
    suite: ModelledSuite<()>,
    tick: u64,
}

impl Bench {
    /// A bench on which everything delivers.
    fn running() -> Self {
        let mut bench = Self { suite: ModelledSuite::new(&()), tick: 0 };
        for _ in 0..5 * SECOND {
            bench.tick();
        }
        bench
    }

    fn tick(&mut self) -> TickInput {
        self.tick += 1;
        let time_us = self.tick * TICK_US;
        let fix = GpsFix {
            altitude_m: ALTITUDE_M,
            velocity_north_mps: Some(60.0),
            velocity_east_mps: Some(0.0),
            velocity_down_mps: Some(0.0),
            vertical_accuracy_m: Some(2.0),
            satellites: Some(15),
            fix_time_us: Some(time_us),
        };
        self.suite.load(&TickInput {
            time_us,
            gps: self.tick.is_multiple_of(FIX_EVERY).then_some(fix),
            baro: Some(BaroReading::PressurePa(PRESSURE_PA)),
            imu: Some(ImuSample { accel_mps2: [0.0, 0.0, FORCE_MPS2], gyro_radps: [0.0; 3] }),
            imu_master_altitude_m: self.tick.is_multiple_of(10).then_some(ALTITUDE_M),
            ..TickInput::default()
        });
        self.suite.poll(time_us)
    }

    fn inject(&mut self, chip: Chip, fault: Fault) {
        self.suite.inject(ChipFault { chip, fault });
    }
}

/// Whether that chip has delivered the true value.
fn is_right(chip: Chip, input: &TickInput) -> bool {
    let near = |value: f32, true_value: f32| (value - true_value).abs() < 0.1;
    match chip {
        Chip::Baro => {
            matches!(input.baro, Some(BaroReading::PressurePa(pressure)) if near(pressure, PRESSURE_PA))
        }
        Chip::Imu => input.imu.is_some_and(|imu| near(imu.accel_mps2[2], FORCE_MPS2)),
        Chip::Gps => input.gps.is_some_and(|fix| near(fix.altitude_m, ALTITUDE_M)),
        Chip::Umbilical | Chip::Wire => input.imu_master_altitude_m.is_some(),
    }
}

/// Most ticks between two correct samples of a chip without a fault.
const fn usual(chip: Chip) -> u64 {
    match chip {
        Chip::Baro => 4,
        Chip::Imu => 1,
        _ => FIX_EVERY,
    }
}

/// Faults of a chip, lasting or momentary, each with the ticks that a power dip itself takes.
fn faults(chip: Chip) -> Vec<(Fault, u64)> {
    let force = Quantity::Force(2);
    let mut all: Vec<(Fault, u64)> = [
        Fault::StuckLow,
        Fault::StuckHigh,
        Fault::BusError,
        Fault::Stalled,
        Fault::Frozen,
        Fault::Slow { by_us: 3_000 },
        Fault::Slow { by_us: 2_000_000 },
        Fault::LoseConversions { count: 3 },
        Fault::Unplugged,
        Fault::LoseBytes { count: 1 },
        Fault::LoseBytes { count: 150 },
        Fault::Refuses,
        Fault::Silent,
        Fault::Held,
        Fault::NoFix,
        Fault::FlipProm { byte: 3, mask: 0x18 },
        Fault::Offset { quantity: Quantity::Pressure, by_milli: 2_000_000_000 },
        Fault::Offset { quantity: force, by_milli: -2_000_000_000 },
        Fault::Offset { quantity: Quantity::Altitude, by_milli: 50_000 },
        Fault::Spike { quantity: Quantity::Pressure, by_milli: -20_000_000, results: 1 },
        Fault::Spike { quantity: force, by_milli: 50_000, results: 5 },
        Fault::FlipData { quantity: Quantity::Pressure, mask: 1 << 23, results: 2 },
        Fault::FlipData { quantity: Quantity::Temperature, mask: 3 << 21, results: 1 },
        Fault::FlipData { quantity: force, mask: 1 << 15, results: 3 },
        Fault::FlipData { quantity: Quantity::Altitude, mask: 1 << 20, results: 2 },
    ]
    .into_iter()
    .map(|fault| (fault, 0))
    .collect();
    all.extend((0..40).map(|seed| (Fault::Garbage { seed }, 0)));
    all.extend((0..60).map(|after_bytes| (Fault::FlipBits { after_bytes, mask: 0xA4 }, 0)));
    all.extend((0..128).map(|address| (Fault::FlipRegister { address, mask: 0x11 }, 0)));
    all.extend((0..128).map(|address| (Fault::FlipRegister { address, mask: 0x06 }, 0)));
    // A receiver takes half a second to start.
    all.push((Fault::Reset, if chip == Chip::Gps { SECOND / 2 } else { 0 }));
    all.retain(|(fault, _)| chip.can(*fault));
    all
}

#[test]
fn a_transient_costs_what_it_lasts_and_half_a_second() {
    for chip in [Chip::Baro, Chip::Imu, Chip::Gps, Chip::Umbilical] {
        let mut worst = (0, Fault::None, 0);
        for (fault, itself) in faults(chip) {
            for lasts in if fault.is_once() { vec![0] } else { vec![1, 30, 100, SECOND - 1] } {
                for phase in [0, 7, 13] {
                    let mut bench = Bench::running();
                    for _ in 0..phase {
                        bench.tick();
                    }
                    bench.inject(chip, fault);
                    for _ in 0..lasts {
                        bench.tick();
                    }
                    if lasts > 0 {
                        bench.inject(chip, Fault::None);
                    }
                    // `recovered`: the last tick that ended a gap between correct samples longer than usual.
                    let (mut since, mut recovered) = (0, 0);
                    for tick in 1..=4 * SECOND {
                        since += 1;
                        if is_right(chip, &bench.tick()) {
                            if since > usual(chip) {
                                recovered = tick;
                            }
                            since = 0;
                        }
                    }
                    assert!(since <= usual(chip), "{chip:?} {fault:?} for {lasts} ticks is for ever");
                    let cost = recovered.saturating_sub(itself);
                    if cost > worst.0 {
                        worst = (cost, fault, lasts);
                    }
                    assert!(cost <= BEYOND, "{chip:?} {fault:?} for {lasts} ticks: {recovered} ticks beyond");
                }
            }
        }
        println!("{chip:?}: at worst {} ticks beyond, {:?} for {} ticks", worst.0, worst.1, worst.2);
    }
}
