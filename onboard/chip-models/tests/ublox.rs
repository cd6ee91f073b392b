//! The u-blox driver against the receiver's model.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::source::Held;
use chip_models::ublox::{ReceiverModel, Solution};
use drivers::ublox::{ATTEMPTS, Config, Datum, MAX_POLL_BYTES, Ublox};
use drivers::{SatelliteReceiver, SensorError};
use embedded_io::{Read, Write};
use kf_core::input::GpsFix;
use proptest::prelude::*;

const TICK_US: u64 = 5_000;
const PERIOD_MS: u16 = 100;
/// Ticks from one solution to the next.
const PERIOD_TICKS: u32 = 20;
const BAUD: u32 = 115_200;
const CONFIG: Config = Config { datum: Datum::MeanSeaLevel, period_ms: PERIOD_MS, baud: BAUD };
const CRUISE: Solution = Solution {
    ellipsoid_m: 3_047.123,
    mean_sea_level_m: 3_000.456,
    velocity_ned_mps: [61.5, -12.25, 0.125],
    vertical_accuracy_m: 2.5,
    speed_accuracy_mps: 0.25,
    satellites: 17,
    fix_type: 3,
};

struct Bench {
    driver: Ublox<ReceiverModel<Held<Option<Solution>>>>,
    now_us: u64,
}

impl Bench {
    fn new(generation: u8, config: Config, solution: Solution) -> Self {
        Self {
            driver: Ublox::new(ReceiverModel::new(generation, config.baud, Held(Some(solution))), config),
            now_us: 0,
        }
    }

    /// A bench whose receiver is configured and delivers.
    fn running(generation: u8) -> Self {
        let mut bench = Self::new(generation, CONFIG, CRUISE);
        for _ in 0..1_000 {
            bench.poll().unwrap();
        }
        assert!(bench.driver.is_configured());
        bench
    }

    fn model(&mut self) -> &mut ReceiverModel<Held<Option<Solution>>> {
        self.driver.port_mut()
    }

    /// One tick. Checks that the poll moves no more than its bytes, and that the flight computer keeps up.
    fn poll(&mut self) -> Result<Option<GpsFix>, SensorError> {
        self.now_us += TICK_US;
        let now_us = self.now_us;
        self.model().set_time(now_us);
        let before = self.driver.link_counts().bytes;
        let outcome = self.driver.poll(now_us);
        let taken = self.driver.link_counts().bytes - before;
        assert!(taken as usize <= MAX_POLL_BYTES, "{taken} bytes in one poll");
        assert_eq!(self.model().line.overrun_bytes, 0);
        outcome
    }

    fn next(&mut self, ticks: u32) -> Result<GpsFix, SensorError> {
        for _ in 0..ticks {
            if let Some(fix) = self.poll()? {
                return Ok(fix);
            }
        }
        panic!("neither a fix nor an error in {ticks} ticks: {:?}", self.driver.link_counts())
    }

    fn next_error(&mut self, ticks: u32) -> SensorError {
        (0..ticks).find_map(|_| self.poll().err()).unwrap()
    }

    /// Correct fixes at the full rate again after this many ticks.
    fn assert_recovers(&mut self, ticks: u32) {
        for _ in 0..ticks {
            let _ = self.poll();
        }
        let fixes: Vec<_> = (0..10 * PERIOD_TICKS).filter_map(|_| self.poll().unwrap()).collect();
        assert_eq!(fixes.len(), 10);
        for pair in fixes.windows(2) {
            assert_eq!(pair[1].fix_time_us.unwrap() - pair[0].fix_time_us.unwrap(), 100_000);
            assert!((pair[1].altitude_m - CRUISE.mean_sea_level_m).abs() < 0.001);
        }
    }
}

#[test]
fn a_solution_becomes_a_fix() {
    for (datum, altitude_m) in [(Datum::MeanSeaLevel, 3_000.456), (Datum::Ellipsoid, 3_047.123)] {
        let mut bench = Bench::new(9, Config { datum, ..CONFIG }, CRUISE);
        let fix = bench.next(1_000).unwrap();
        assert_eq!(
            fix,
            GpsFix {
                altitude_m,
                velocity_north_mps: Some(61.5),
                velocity_east_mps: Some(-12.25),
                velocity_down_mps: Some(0.125),
                vertical_accuracy_m: Some(2.5),
                satellites: Some(17),
                fix_time_us: fix.fix_time_us,
            }
        );
        // Time of week of the epoch, the latency before this tick and a line's delay.
        let age_us = 200_000_000_000 + bench.now_us - fix.fix_time_us.unwrap();
        assert!((50_000..=50_000 + 9_000 + TICK_US).contains(&age_us), "{age_us}");
    }
}

proptest! {
    /// What goes in comes out to the millimetre over any flight's range.
    #[test]
    fn what_goes_in_comes_out(
        ellipsoid_m in -500f32..16_000.0,
        velocity_ned_mps in prop::array::uniform3(-300f32..300.0),
        vertical_accuracy_m in 0f32..1_000.0,
    ) {
        let solution = Solution { ellipsoid_m, velocity_ned_mps, vertical_accuracy_m, ..CRUISE };
        let mut bench = Bench::new(9, Config { datum: Datum::Ellipsoid, ..CONFIG }, solution);
        let fix = bench.next(1_000).unwrap();
        // Half a millimetre, and f32's rounding on the way in and out.
        let close = |found: f32, set: f32| (found - set).abs() <= 0.000_5 + set.abs() * 2.0 * f32::EPSILON;
        prop_assert!(close(fix.altitude_m, ellipsoid_m), "{} {ellipsoid_m}", fix.altitude_m);
        prop_assert!(close(fix.velocity_north_mps.unwrap(), velocity_ned_mps[0]));
        prop_assert!(close(fix.velocity_east_mps.unwrap(), velocity_ned_mps[1]));
        prop_assert!(close(fix.velocity_down_mps.unwrap(), velocity_ned_mps[2]));
        prop_assert!(close(fix.vertical_accuracy_m.unwrap(), vertical_accuracy_m));
    }

    /// Any bytes at any place: no panic, and correct fixes at the full rate when they end.
    #[test]
    fn garbage_is_left_behind(
        garbage in prop::collection::vec(prop_oneof![any::<u8>(), Just(0xB5), Just(0x62)], 0..300),
        after_ticks in 0u32..40,
    ) {
        let mut bench = Bench::running(9);
        for _ in 0..after_ticks {
            bench.poll().unwrap();
        }
        bench.model().inject(&garbage);
        // A false frame can hold back 256 bytes, less than three solutions.
        bench.assert_recovers(5 * PERIOD_TICKS);
    }
}

#[test]
fn both_generations_are_configured() {
    for (generation, sent, refused) in [(9, 1, 0), (8, 5, 1)] {
        let mut bench = Bench::running(generation);
        let counts = bench.driver.link_counts();
        // One or more messages were sent before the receiver had booted.
        assert_eq!((counts.refused, counts.sent - counts.timeouts), (refused, sent), "{generation}");
        bench.assert_recovers(0);
    }
}

#[test]
fn a_lost_byte_costs_its_fix_and_no_more() {
    for lost in [1, 3, 50, 99] {
        let mut bench = Bench::running(9);
        while bench.poll().unwrap().is_none() {}
        bench.model().line.faults.lose_bytes = lost;
        // A frame that lost its beginning leaves nothing in which an error can be found.
        let mut errors = (0..3 * PERIOD_TICKS).filter_map(|_| bench.poll().err());
        assert!(errors.all(|error| error == SensorError::Check), "{lost}");
        bench.assert_recovers(0);
        let counts = bench.driver.link_counts();
        assert_eq!(counts.frames, 1 + (bench.driver.health().samples), "{counts:?}");
    }
}

#[test]
fn a_frame_cut_short_is_counted_and_the_next_one_is_whole() {
    let mut bench = Bench::running(9);
    while bench.poll().unwrap().is_none() {}
    // The header of a frame that announces 92 bytes, and nothing after it: the next frame is taken for its
    // payload.
    bench.model().inject(&[0xB5, 0x62, 0x01, 0x07, 92, 0]);
    bench.assert_recovers(0);
    assert_eq!(bench.driver.link_counts().bad_frames, 1);
}

#[test]
fn a_flipped_bit_is_an_error() {
    for after in [6, 40, 91, 99] {
        let mut bench = Bench::running(9);
        while bench.poll().unwrap().is_none() {}
        bench.model().line.faults.flip_bits = Some((after, 0x10));
        assert_eq!(bench.next_error(3 * PERIOD_TICKS), SensorError::Check, "{after}");
        bench.assert_recovers(2 * PERIOD_TICKS);
    }
}

#[test]
fn silence_is_stale_and_ends() {
    let mut bench = Bench::running(9);
    while bench.poll().unwrap().is_none() {}
    bench.model().line.faults.unplugged = true;
    let ticks = (1..).find(|_| bench.poll().is_err()).unwrap();
    assert_eq!(bench.driver.health().last_error, Some(SensorError::Stale));
    // Two periods and a half.
    assert_eq!(ticks, 51);
    for _ in 0..2_000 {
        let _ = bench.poll();
    }
    bench.model().line.faults.unplugged = false;
    bench.assert_recovers(400);
}

#[test]
fn a_reset_of_the_receiver_heals() {
    let mut bench = Bench::running(8);
    bench.model().power_dip();
    assert_eq!(bench.next_error(300), SensorError::Stale);
    bench.assert_recovers(400);
    assert_eq!(bench.driver.health().initialisations, 2);
}

/// It costs the half second of the start and no further half second. A sound receiver takes two periods.
#[test]
fn a_reset_of_the_receiver_costs_half_a_second_beyond_its_start() {
    for (generation, baud) in [(9, BAUD), (8, BAUD), (9, 38_400), (8, 38_400)] {
        for after_ticks in 0..PERIOD_TICKS {
            let mut bench = Bench::new(generation, Config { baud, ..CONFIG }, CRUISE);
            for _ in 0..1_000 + after_ticks {
                bench.poll().unwrap();
            }
            bench.model().power_dip();
            let ticks = (1..).find(|_| matches!(bench.poll(), Ok(Some(_)))).unwrap();
            assert!(ticks <= 200, "generation {generation} at {baud}: {ticks} ticks");
        }
    }
}

/// A flipped setting costs at most half a second.
#[test]
fn a_setting_that_flips_is_mended() {
    for (generation, setting) in [(9, 0), (8, 0), (9, 1), (8, 1)] {
        let mut bench = Bench::new(generation, Config { baud: 38_400, ..CONFIG }, CRUISE);
        for _ in 0..1_000 {
            bench.poll().unwrap();
        }
        assert!(bench.model().flip_setting(setting));
        for _ in 0..100 {
            let _ = bench.poll();
        }
        bench.assert_recovers(0);
        let latest_us = 200_000_000_000 + bench.now_us;
        let fix = bench.next(PERIOD_TICKS).unwrap();
        assert!(latest_us.abs_diff(fix.fix_time_us.unwrap()) < 200_000, "generation {generation}, {setting}");
    }
}

/// Even before a second solution gives the interval between two, recovery is no later than afterwards.
#[test]
fn a_setting_that_flips_after_the_first_solution_is_mended_as_soon() {
    for generation in [9, 8] {
        let mut bench = Bench::new(generation, CONFIG, CRUISE);
        while !bench.driver.is_configured() {
            let _ = bench.poll();
        }
        bench.next(2 * PERIOD_TICKS).unwrap();
        assert!(bench.model().flip_setting(0));
        let ticks = (1..).find(|_| matches!(bench.poll(), Ok(Some(_)))).unwrap();
        assert!(ticks <= 100, "generation {generation}: {ticks} ticks");
    }
}

/// A receiver's default output fills a line of 38,400 baud at six solutions a second, and would make a fix at
/// 10 Hz late.
#[test]
fn nothing_but_solutions_comes_on_a_slow_line() {
    for generation in [8, 9] {
        let mut bench = Bench::new(generation, Config { baud: 38_400, ..CONFIG }, CRUISE);
        for _ in 0..1_000 {
            bench.poll().unwrap();
        }
        let before = bench.driver.link_counts();
        for _ in 0..10 * PERIOD_TICKS {
            if let Some(fix) = bench.poll().unwrap() {
                // The receiver's latency, 26 ms of line, a tick.
                let age_us = 200_000_000_000 + bench.now_us - fix.fix_time_us.unwrap();
                assert!(age_us < 50_000 + 27_000 + TICK_US, "generation {generation}: {age_us}");
            }
        }
        let counts = bench.driver.link_counts();
        assert_eq!((counts.frames - before.frames, counts.bytes - before.bytes), (10, 1_000), "{generation}");
        assert_eq!(bench.model().line.unsent_bytes, 0, "generation {generation}");
    }
}

/// Shows why a receiver must not keep its NMEA, as generation 8 did.
#[test]
fn sentences_beside_the_solutions_make_them_late() {
    let mut model = ReceiverModel::new(8, 38_400, Held(Some(CRUISE)));
    model.set_time(600_000);
    let frame = |id: u8, payload: &[u8]| {
        let mut frame = vec![0xB5, 0x62, 0x06, id, u8::try_from(payload.len()).unwrap(), 0];
        frame.extend(payload);
        let sums = frame[2..].iter().fold((0u8, 0u8), |(a, b), byte| {
            let a = a.wrapping_add(*byte);
            (a, b.wrapping_add(a))
        });
        frame.extend([sums.0, sums.1]);
        frame
    };
    model.write(&frame(0x01, &[0x01, 0x07, 1])).unwrap();
    model.write(&frame(0x08, &[100, 0, 1, 0, 1, 0])).unwrap();
    let mut late_us = Vec::new();
    let mut received = Vec::new();
    for tick in 121..=2_120u64 {
        model.set_time(tick * TICK_US);
        let mut bytes = [0; 128];
        let count = model.read(&mut bytes).unwrap();
        received.extend_from_slice(&bytes[..count]);
        while let Some(place) = received.windows(6).position(|head| head == [0xB5, 0x62, 0x01, 0x07, 92, 0])
            && received.len() >= place + 100
        {
            let time = &received[place + 6..place + 10];
            let epoch_ms = u64::from(u32::from_le_bytes(time.try_into().unwrap())) - 200_000_000;
            late_us.push(tick * TICK_US - epoch_ms * 1_000);
            received.drain(..place + 100);
        }
    }
    // 746 bytes an epoch, ten times a second, on a line that carries 3,840 bytes a second.
    assert!(late_us.iter().skip(20).all(|late_us| *late_us > 200_000), "{late_us:?}");
    assert!(model.line.unsent_bytes > 10_000);
}

#[test]
fn a_refusal_is_an_error() {
    let mut bench = Bench::new(9, CONFIG, CRUISE);
    bench.model().faults.refuses = true;
    let errors: Vec<_> = (0..2_000).filter_map(|_| bench.poll().err()).collect();
    assert!(errors.contains(&SensorError::NotAcknowledged), "{errors:?}");
    bench.model().faults.refuses = false;
    bench.assert_recovers(1_000);
}

#[test]
fn a_missing_acknowledgement_is_an_error_after_all_attempts() {
    let mut bench = Bench::new(9, CONFIG, CRUISE);
    bench.model().faults.silent = true;
    let mut errors = Vec::new();
    let mut fixes = 0;
    // Two rounds of attempts, and less than a third round.
    for _ in 0..450 {
        match bench.poll() {
            Ok(fix) => fixes += u32::from(fix.is_some()),
            Err(error) => errors.push(error),
        }
    }
    assert_eq!(errors, [SensorError::Timeout; 2]);
    assert_eq!(bench.driver.link_counts().timeouts, 2 * u32::from(ATTEMPTS));
    // The receiver obeyed all the same: its fixes are delivered.
    assert!(fixes > 12, "{fixes}");
    bench.model().faults.silent = false;
    bench.assert_recovers(400);
    assert!(bench.driver.is_configured());
}

#[test]
fn a_solution_that_is_no_fix_is_counted() {
    let mut bench = Bench::running(9);
    for fix_type in [0, 1, 2, 5] {
        while bench.poll().unwrap().is_none() {}
        bench.model().solutions.0 = Some(Solution { fix_type, ..CRUISE });
        let before = bench.driver.link_counts().no_fix;
        for _ in 0..10 * PERIOD_TICKS {
            assert_eq!(bench.poll(), Ok(None), "{fix_type}");
        }
        assert_eq!(bench.driver.link_counts().no_fix - before, 10);
        bench.model().solutions.0 = Some(Solution { fix_type: 3, ..CRUISE });
    }
    bench.assert_recovers(0);
}

#[test]
fn the_week_ends_and_time_goes_on() {
    let mut bench = Bench::new(9, CONFIG, CRUISE);
    bench.model().time_of_week_ms = 604_800_000 - 3_000;
    bench.next(1_000).unwrap();
    bench.assert_recovers(0);
    bench.assert_recovers(600);
    assert!(bench.next(PERIOD_TICKS).unwrap().fix_time_us.unwrap() > 604_800_000_000);
}
