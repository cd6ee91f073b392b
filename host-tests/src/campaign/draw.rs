//! Draws the faults of a run from its seed.

use chip_models::flown::{Chip, ChipFault, Fault, Quantity};
use rand::{Rng, RngExt as _};
use survival::{CRASHES_AT_ONCE, History};

use super::fault::{Boundary, Dip, DipTick, Drawn, Phase, Place, SECOND, TRANSIENT_TICKS};
use super::flight::TICK_US;
use super::plan::Plan;

/// Draws the faults of a run: one fault in four of five runs, two in the others, never two in one place.
pub fn draw(plan: &Plan, random: &mut impl Rng) -> Vec<Drawn> {
    let mut faults = vec![one(plan, random)];
    if random.random_bool(0.2) {
        loop {
            let other = one(plan, random);
            if faults.iter().all(|fault| fault.place != other.place) {
                faults.push(other);
                break;
            }
        }
    }
    faults
}

/// A random tick of that phase.
fn tick_of(phase: Phase, plan: &Plan, random: &mut impl Rng) -> usize {
    let separation = plan.separation();
    let range = match phase {
        Phase::Settling => 20..10 * SECOND,
        Phase::Calibrating => 10 * SECOND..separation - 5 * SECOND,
        Phase::BeforeLaunch => separation - 5 * SECOND..separation - SECOND / 10,
        Phase::Release => separation - SECOND / 10..separation + SECOND / 2,
        Phase::EarlyFree => separation + SECOND / 2..separation + 8 * SECOND,
        Phase::LateFree => separation + 15 * SECOND..plan.ticks() - 2 * SECOND,
    };
    random.random_range(range)
}

/// End tick of a fault: two in five are transients, one in five lasts.
fn length(from: usize, plan: &Plan, random: &mut impl Rng) -> usize {
    let ticks = match random.random_range(0..5) {
        0 | 1 => random.random_range(1..=TRANSIENT_TICKS),
        2 | 3 => random.random_range(TRANSIENT_TICKS..15 * SECOND),
        _ => plan.ticks(),
    };
    (from + ticks).min(plan.ticks())
}

fn one(plan: &Plan, random: &mut impl Rng) -> Drawn {
    let phase = Phase::ALL[random.random_range(0..Phase::ALL.len())];
    let from = tick_of(phase, plan, random);
    let to = length(from, plan, random);
    let mut fault = Drawn {
        name: "",
        place: Place::Baro,
        phase,
        from,
        to,
        events: Vec::new(),
        dips: Vec::new(),
        step_us: 0,
    };
    match random.random_range(0..100) {
        0..22 => of_barometer(&mut fault, random),
        22..44 => of_inertial_unit(&mut fault, random),
        44..62 => of_receiver(&mut fault, plan, random),
        62..72 => of_mother_ship(&mut fault, plan, random),
        72..83 => of_wire(&mut fault, plan, random),
        83..96 => of_supply(&mut fault, plan, random),
        96..98 => of_program(&mut fault, plan, random),
        _ => {
            fault.place = Place::Clock;
            fault.to = from + 1;
            (fault.name, fault.step_us) = if random.random_bool(0.6) {
                ("clock: leaps forward", (10f64.powf(random.random_range(3.5..7.0))) as i64)
            } else {
                ("clock: runs back", -(10f64.powf(random.random_range(3.5..6.0)) as i64))
            };
        }
    }
    fault
}

/// A mask with one bit, or with some.
fn mask(is_single: bool, random: &mut impl Rng) -> u8 {
    if is_single { 1 << random.random_range(0..8) } else { random.random_range(3..=255) }
}

fn lasts(fault: &mut Drawn, chip: Chip, what: Fault) {
    fault.events = vec![
        (fault.from, ChipFault { chip, fault: what }),
        (fault.to, ChipFault { chip, fault: Fault::None }),
    ];
}

fn once(fault: &mut Drawn, chip: Chip, what: Fault) {
    fault.to = fault.from + 1;
    fault.events = vec![(fault.from, ChipFault { chip, fault: what })];
}

/// Several flipped bits, one event each, over the fault's length but at most a second.
fn flips(fault: &mut Drawn, chip: Chip, bytes: u32, random: &mut impl Rng) {
    let count = random.random_range(2..12);
    fault.to = fault.to.min(fault.from + SECOND);
    let span = fault.to - fault.from;
    fault.events = (0..count)
        .map(|_| {
            let what = Fault::FlipBits {
                after_bytes: random.random_range(0..bytes),
                mask: mask(random.random_bool(0.5), random),
            };
            (fault.from + random.random_range(0..span.max(1)), ChipFault { chip, fault: what })
        })
        .collect();
    fault.events.sort_by_key(|(tick, _)| *tick);
    fault.events.push((fault.to, ChipFault { chip, fault: Fault::None }));
}

/// A size between two powers of ten, of either sign.
fn size(from: f64, to: f64, random: &mut impl Rng) -> i32 {
    let size = 10f64.powf(random.random_range(from..to)) as i32;
    if random.random_bool(0.5) { size } else { -size }
}

/// A mask of one bit out of this many, or of several.
fn bits(width: u32, random: &mut impl Rng) -> u32 {
    let one = |random: &mut dyn FnMut() -> u32| 1 << (random() % width);
    let mut draw = || random.random::<u32>();
    let first = one(&mut draw);
    if draw() % 3 > 0 { first } else { first | one(&mut draw) | one(&mut draw) }
}

/// Limit on the ticks until the barometer's chip has delivered that many results. A temperature comes once in
/// eight conversions, 16 ticks at 100 conversions a second. A pressure out of the chip's range is followed by
/// a pause, a reset and a temperature, which takes ten ticks (`drivers::ms5611`).
fn conversions_ticks(quantity: Quantity, results: u32) -> usize {
    let each = if quantity == Quantity::Temperature { 16 } else { 10 };
    each * results as usize
}

/// Number of wrong results, at most half a second of the inertial unit's.
fn results(random: &mut impl Rng) -> u32 {
    if random.random_bool(0.5) { 1 } else { random.random_range(2..100) }
}

/// Draws a fault that any chip on SPI can have; returns whether it did.
fn of_bus(fault: &mut Drawn, chip: Chip, random: &mut impl Rng) {
    let name = |baro, imu| if chip == Chip::Baro { baro } else { imu };
    match random.random_range(0..9) {
        0 => {
            fault.name = name("baro: a bit flips on the bus", "imu: a bit flips on the bus");
            let mask = 1 << random.random_range(0..8);
            once(fault, chip, Fault::FlipBits { after_bytes: random.random_range(0..40), mask });
        }
        1 => {
            fault.name = name("baro: bits flip on the bus", "imu: bits flip on the bus");
            flips(fault, chip, 20, random);
        }
        2 => {
            fault.name = name("baro: line stuck low", "imu: line stuck low");
            lasts(fault, chip, Fault::StuckLow);
        }
        3 => {
            fault.name = name("baro: line stuck high", "imu: line stuck high");
            lasts(fault, chip, Fault::StuckHigh);
        }
        4 => {
            fault.name = name("baro: bus errors", "imu: bus errors");
            lasts(fault, chip, Fault::BusError);
        }
        5 => {
            fault.name = name("baro: noise on the bus", "imu: noise on the bus");
            lasts(fault, chip, Fault::Garbage { seed: random.random() });
        }
        6 => {
            fault.name = name("baro: repeats itself", "imu: repeats itself");
            lasts(fault, chip, Fault::Frozen);
        }
        7 => {
            fault.name = name("baro: stalled", "imu: stalled");
            lasts(fault, chip, Fault::Stalled);
        }
        _ => {
            fault.name = name("baro: reset", "imu: reset");
            once(fault, chip, Fault::Reset);
        }
    }
}

fn of_barometer(fault: &mut Drawn, random: &mut impl Rng) {
    fault.place = Place::Baro;
    let chip = Chip::Baro;
    let quantity = if random.random_bool(0.75) { Quantity::Pressure } else { Quantity::Temperature };
    match random.random_range(0..16) {
        0..3 => {
            fault.name = "baro: data bits flip";
            let mask = bits(24, random);
            let results = results(random);
            once(fault, chip, Fault::FlipData { quantity, mask, results });
            fault.to = fault.from + conversions_ticks(quantity, results);
        }
        3..5 => {
            fault.name = "baro: spike";
            // From a pascal to a whole atmosphere; from a thousandth of a degree to a hundred.
            let by_milli = size(3.0, 8.0, random);
            let results = results(random).min(25);
            once(fault, chip, Fault::Spike { quantity, by_milli, results });
            fault.to = fault.from + conversions_ticks(quantity, results);
        }
        5 => {
            fault.name = "baro: offset";
            lasts(
                fault,
                chip,
                Fault::Offset { quantity: Quantity::Pressure, by_milli: size(3.0, 8.0, random) },
            );
        }
        6 => {
            fault.name = "baro: slow conversions";
            lasts(fault, chip, Fault::Slow { by_us: random.random_range(500..40_000) });
        }
        7 => {
            fault.name = "baro: conversions lost";
            let count = random.random_range(1..8);
            once(fault, chip, Fault::LoseConversions { count });
            // Until the last of them times out.
            fault.to = fault.from + 20 * count as usize;
        }
        8 => {
            // The memory is read only after a reset.
            fault.name = "baro: calibration memory flips";
            fault.to = fault.to.max(fault.from + 2);
            let flip = Fault::FlipProm {
                byte: random.random_range(0..16),
                mask: mask(random.random_bool(0.5), random),
            };
            fault.events = vec![
                (fault.from, ChipFault { chip, fault: Fault::Reset }),
                (fault.from + 1, ChipFault { chip, fault: flip }),
                (fault.to, ChipFault { chip, fault: Fault::None }),
            ];
        }
        _ => of_bus(fault, chip, random),
    }
}

fn of_inertial_unit(fault: &mut Drawn, random: &mut impl Rng) {
    fault.place = Place::Imu;
    let chip = Chip::Imu;
    let axis = random.random_range(0..3);
    let quantity = if random.random_bool(0.6) { Quantity::Force(axis) } else { Quantity::Rate(axis) };
    match random.random_range(0..17) {
        0..2 => {
            fault.name = "imu: data bits flip";
            once(fault, chip, Fault::FlipData { quantity, mask: bits(16, random), results: results(random) });
            fault.to = fault.from + SECOND / 2;
        }
        2..4 => {
            fault.name = "imu: a register flips";
            let fault_of_register = Fault::FlipRegister {
                address: random.random_range(0..128),
                mask: mask(random.random_bool(0.7), random),
            };
            once(fault, chip, fault_of_register);
        }
        4 => {
            fault.name = "imu: configuration flips";
            let address =
                [0x4c, 0x4d, 0x4e, 0x4f, 0x50, 0x51, 0x52, 0x53, 0x11, 0x14][random.random_range(0..10)];
            once(fault, chip, Fault::FlipRegister { address, mask: mask(true, random) });
        }
        5..7 => {
            fault.name = "imu: spike";
            once(
                fault,
                chip,
                Fault::Spike { quantity, by_milli: size(2.0, 5.3, random), results: results(random) },
            );
            fault.to = fault.from + SECOND / 2;
        }
        9 | 10 => {
            fault.name = "imu: reads free fall";
            fault.to = fault.to.clamp(fault.from + 2 * SECOND, fault.from + 8 * SECOND);
            let by_milli = random.random_range(8_500..10_500);
            lasts(fault, chip, Fault::Offset { quantity: Quantity::Force(2), by_milli });
        }
        7 => {
            fault.name = "imu: saturated";
            lasts(fault, chip, Fault::Offset { quantity, by_milli: size(6.0, 7.0, random) });
        }
        8 => {
            fault.name = "imu: shaken";
            lasts(
                fault,
                chip,
                Fault::Vibration {
                    quantity,
                    frequency_mhz: random.random_range(20_000..400_000),
                    amplitude_milli: random.random_range(100..15_000),
                },
            );
        }
        _ => of_bus(fault, chip, random),
    }
}

fn of_receiver(fault: &mut Drawn, plan: &Plan, random: &mut impl Rng) {
    fault.place = Place::Gps;
    let chip = Chip::Gps;
    match random.random_range(0..18) {
        0 => {
            fault.name = "gps: bits flip on the line";
            flips(fault, chip, 300, random);
        }
        1 => {
            fault.name = "gps: unplugged";
            lasts(fault, chip, Fault::Unplugged);
        }
        2 => {
            fault.name = "gps: bytes lost";
            let count = random.random_range(1..400);
            once(fault, chip, Fault::LoseBytes { count });
            // Until that many have been sent, 100 of them a fix.
            fault.to = fault.from + (count as usize).div_ceil(100) * plan.fix_ticks;
        }
        3 => {
            fault.name = "gps: reset";
            once(fault, chip, Fault::Reset);
            // From power to the first byte.
            fault.to = fault.from + SECOND / 2;
        }
        4 => {
            fault.name = "gps: acknowledges nothing";
            lasts(fault, chip, if random.random_bool(0.5) { Fault::Silent } else { Fault::Refuses });
        }
        5..8 => {
            fault.name = "gps: altitude jumps";
            lasts(
                fault,
                chip,
                Fault::Offset { quantity: Quantity::Altitude, by_milli: size(3.7, 6.5, random) },
            );
        }
        8 => {
            fault.name = "gps: single fixes are off";
            let by_milli = size(3.7, 6.5, random);
            once(
                fault,
                chip,
                Fault::Spike { quantity: Quantity::Altitude, by_milli, results: random.random_range(1..4) },
            );
            fault.to = fault.from + SECOND / 2;
        }
        9 => {
            fault.name = "gps: repeats its fix";
            lasts(fault, chip, if random.random_bool(0.5) { Fault::Held } else { Fault::Frozen });
        }
        10 => {
            fault.name = "gps: velocity is wrong";
            let quantity = Quantity::Velocity(random.random_range(0..3));
            lasts(fault, chip, Fault::Offset { quantity, by_milli: size(3.0, 4.5, random) });
        }
        11 => {
            fault.name = "gps: no fix";
            lasts(fault, chip, Fault::NoFix);
        }
        12 => {
            fault.name = "gps: noise on the line";
            lasts(fault, chip, Fault::Garbage { seed: random.random() });
        }
        13 => {
            fault.name = "gps: data bits flip";
            let what = Fault::FlipData {
                quantity: Quantity::Altitude,
                mask: bits(32, random),
                results: random.random_range(1..4),
            };
            once(fault, chip, what);
            fault.to = fault.from + SECOND / 2;
        }
        14 => {
            fault.name = "gps: a setting flips";
            once(fault, chip, Fault::FlipRegister { address: random.random_range(0..3), mask: 1 });
        }
        15 => {
            fault.name = "gps: a receiver of generation 8";
            fault.to = plan.ticks();
            fault.events = vec![(
                fault.from,
                ChipFault {
                    chip,
                    fault: Fault::Generation8 { baud: [9_600, 38_400][random.random_range(0..2)] },
                },
            )];
        }
        _ => {
            fault.name = "gps: converges";
            lasts(
                fault,
                chip,
                Fault::ColdStart {
                    error_mm: size(3.7, 4.8, random),
                    decay_s: random.random_range(5..30),
                    is_honest: random.random_bool(0.5),
                },
            );
        }
    }
}

fn of_mother_ship(fault: &mut Drawn, plan: &Plan, random: &mut impl Rng) {
    fault.place = Place::Master;
    let chip = Chip::Umbilical;
    match random.random_range(0..10) {
        0 => {
            fault.name = "mother ship: bits flip";
            flips(fault, chip, 200, random);
        }
        1 => {
            fault.name = "mother ship: line dead";
            lasts(fault, chip, Fault::Unplugged);
        }
        2 => {
            fault.name = "mother ship: bytes lost";
            once(fault, chip, Fault::LoseBytes { count: random.random_range(1..90) });
            // Until that many have been sent: two messages.
            fault.to = fault.from + 2 * plan.master_ticks;
        }
        3 => {
            fault.name = "mother ship: stops";
            lasts(fault, chip, Fault::Silent);
        }
        4 | 5 => {
            fault.name = "mother ship: lies";
            let size_m = 10f64.powf(random.random_range(0.7..4.0)) as i32;
            let by_m = if random.random_bool(0.5) { size_m } else { -size_m };
            lasts(fault, chip, Fault::Lies { by_m });
        }
        6 => {
            fault.name = "mother ship: sends NaN";
            lasts(fault, chip, Fault::NotANumber);
        }
        7 => {
            fault.name = "mother ship: repeats itself";
            lasts(fault, chip, Fault::Holds);
        }
        8 => {
            fault.name = "mother ship: noise on the line";
            lasts(fault, chip, Fault::Garbage { seed: random.random() });
        }
        _ => {
            fault.name = "mother ship: a stranger";
            let (system, component) = (random.random_range(2..=255), random.random_range(1..=255));
            let altitude_m = random.random_range(-500..9_000);
            lasts(fault, chip, Fault::Stranger { system, component, altitude_m });
        }
    }
}

fn of_wire(fault: &mut Drawn, plan: &Plan, random: &mut impl Rng) {
    fault.place = Place::Wire;
    match random.random_range(0..6) {
        0 => {
            fault.name = "wire: broken";
            lasts(fault, Chip::Wire, Fault::Open);
        }
        1 => {
            fault.name = "wire: shorted";
            lasts(fault, Chip::Wire, Fault::Shorted);
        }
        2 => {
            fault.name = "wire: bounces";
            let mut mean_us = |largest: f64| 10f64.powf(random.random_range(2.5..largest)) as u32;
            let (open_us, closed_us) = (mean_us(5.0), mean_us(6.0));
            lasts(fault, Chip::Wire, Fault::Bounces { open_us, closed_us, seed: random.random() });
        }
        3 => {
            fault.name = "wire: unreadable";
            lasts(fault, Chip::Wire, Fault::Unreadable);
        }
        4 => {
            fault.name = "wire: broken for good";
            fault.to = plan.ticks();
            lasts(fault, Chip::Wire, Fault::Open);
        }
        _ => {
            fault.name = "wire: cable torn";
            fault.to = plan.ticks();
            lasts(fault, Chip::Umbilical, Fault::Torn);
        }
    }
}

/// Crashes, each as soon as the program runs again: from the fourth in a row on, it stands by before it
/// continues (`survival::History`).
fn of_program(fault: &mut Drawn, plan: &Plan, random: &mut impl Rng) {
    fault.place = Place::Program;
    let count = random.random_range(1..=6_usize);
    fault.name =
        if count > CRASHES_AT_ONCE as usize { "program: crashes in a row" } else { "program: crashes" };
    let mut tick = fault.from;
    for _ in 0..count {
        let boundary = if random.random_bool(0.5) { Boundary::BeforeMark } else { Boundary::AtEnd };
        // A restart takes three ticks.
        let crash = Dip { tick: DipTick::At(tick), ticks: 3, boundary, with_chips: false, is_crash: true };
        fault.dips.push(crash);
        tick += 3 + random.random_range(4..400);
    }
    let pauses_us: u64 =
        (1..=count as u32).map(|crashes| History { crashes, ..History::default() }.pause_us()).sum();
    fault.to = (tick + (pauses_us / TICK_US) as usize).min(plan.ticks());
}

fn of_supply(fault: &mut Drawn, plan: &Plan, random: &mut impl Rng) {
    fault.place = Place::Supply;
    let is_series = random.random_bool(0.35);
    let at_launch = random.random_bool(0.3);
    let with_chips = random.random_bool(0.6);
    let count = if is_series { random.random_range(2..8) } else { 1 };
    let mut tick = fault.from;
    let mut last_end = tick;
    for k in 0..count {
        let boundary = match random.random_range(0..5) {
            0 => Boundary::BeforeMark,
            1 => Boundary::InMark(random.random_range(1..5)),
            2 => Boundary::BeforeSnapshot,
            3 => Boundary::InSnapshot(random.random_range(1..400)),
            _ => Boundary::AtEnd,
        };
        let when = match (at_launch && k == 0, random.random_range(0..2)) {
            (true, 0) => DipTick::Edge(random.random_range(0..6)),
            (true, _) => DipTick::Latch(random.random_range(0..3)),
            _ => DipTick::At(tick),
        };
        let ticks = random.random_range(1..40);
        fault.dips.push(Dip { tick: when, ticks, boundary, with_chips, is_crash: false });
        // The fault ends with the last dip; a receiver that has lost its power takes another half second to
        // boot.
        last_end = tick + ticks + if with_chips { SECOND / 2 } else { 0 };
        tick += ticks + random.random_range(4..400);
    }
    fault.to = tick.max(last_end).min(plan.ticks());
    fault.name = match (is_series, at_launch) {
        (true, _) => "supply: dips in series",
        (false, true) => "supply: dips at the launch",
        (false, false) => "supply: dips",
    };
    if at_launch {
        fault.phase = Phase::Release;
        fault.from = plan.separation();
        fault.to = fault.to.clamp(fault.from + SECOND, plan.ticks());
    } else if !is_series {
        fault.to = last_end;
    }
}
