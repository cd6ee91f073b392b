//! The umbilical's driver against the mother ship's model.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::mother_ship::MotherShipModel;
use drivers::umbilical::{SILENT_AFTER_US, Sender, Umbilical};
use drivers::{AltitudeLink, SensorError};
use proptest::prelude::*;

const TICK_US: u64 = 5_000;
/// Ticks from one altitude to the next.
const EVERY: u64 = 4;

struct Bench {
    driver: Umbilical<MotherShipModel>,
    tick: u64,
}

impl Bench {
    fn new() -> Self {
        Self { driver: Umbilical::new(MotherShipModel::new(1, 115_200), Sender::FIRST_AUTOPILOT), tick: 0 }
    }

    /// One tick. At every fourth the mother ship sends its altitude, which rises by a metre a second.
    fn poll(&mut self) -> Result<Option<f32>, SensorError> {
        self.tick += 1;
        let now_us = self.tick * TICK_US;
        let model = self.driver.port_mut();
        model.set_time(now_us);
        if self.tick.is_multiple_of(EVERY) {
            model.navigate(2_000.0 + now_us as f32 * 1e-6);
        }
        assert_eq!((model.line.overrun_bytes, model.line.unsent_bytes), (0, 0));
        self.driver.poll(now_us)
    }

    fn altitudes(&mut self, ticks: u32) -> Vec<f32> {
        (0..ticks).filter_map(|_| self.poll().unwrap()).collect()
    }
}

#[test]
fn every_altitude_arrives_as_it_was_sent_and_other_messages_are_passed_over() {
    let mut bench = Bench::new();
    let altitudes = bench.altitudes(1_000);
    // The last one is still on the line.
    assert_eq!(altitudes.len(), 1_000 / 4 - 1);
    for (altitude_m, k) in altitudes.into_iter().zip(1_u64..) {
        assert_eq!(altitude_m, 2_000.0 + (k * EVERY * TICK_US) as f32 * 1e-6);
    }
    let counts = bench.driver.link_counts();
    // A heartbeat has 21 bytes; there were five.
    assert_eq!((counts.other_bytes, counts.bad_frames, counts.superseded), (5 * 21, 0, 0));
}

/// A link that has not delivered yet cannot fall silent; one that has is reported once a second.
#[test]
fn silence_is_a_fault_while_attached_and_none_after_launch() {
    let mut bench = Bench::new();
    bench.driver.port_mut().line.faults.unplugged = true;
    assert!((0..1_000).all(|_| bench.poll() == Ok(None)), "nothing was ever heard");
    bench.driver.port_mut().line.faults.unplugged = false;
    assert!(!bench.altitudes(20).is_empty());
    bench.driver.port_mut().line.faults.unplugged = true;
    let outcomes: Vec<_> = (0..SILENT_AFTER_US * 3 / TICK_US + 10).map(|_| bench.poll()).collect();
    assert_eq!(outcomes.iter().filter(|outcome| **outcome == Err(SensorError::Stale)).count(), 3);
    bench.driver.set_attached(false);
    assert!((0..2_000).all(|_| bench.poll() == Ok(None)));
    // A plug that still touches: its altitudes are no longer this vehicle's.
    bench.driver.port_mut().line.faults.unplugged = false;
    assert!((0..12).all(|_| bench.poll() == Ok(None)));
    // The discrete had only bounced.
    bench.driver.set_attached(true);
    bench.poll().unwrap();
    assert!(!bench.altitudes(20).is_empty());
}

/// A false start of a frame swallows the real frame that follows, until its checksum is found wrong.
#[test]
fn a_frame_inside_what_looked_like_one_is_found() {
    let mut bench = Bench::new();
    for byte in [0xFD, 32, 0, 0, 0, 1, 1, 141, 0, 0] {
        bench.driver.port_mut().line.send(byte);
    }
    bench.driver.port_mut().navigate(1_234.5);
    let outcomes: Vec<_> = (0..4).map(|_| bench.poll()).collect();
    assert!(outcomes.contains(&Ok(Some(1_234.5))), "{outcomes:?}");
    assert_eq!(bench.driver.link_counts().bad_frames, 1);
}

proptest! {
    /// Whatever precedes a frame, the first whole frame after it is found, and nothing else is.
    #[test]
    fn a_frame_after_garbage_is_found(garbage in prop::collection::vec(prop_oneof![any::<u8>(), Just(0xFD)], 0..120)) {
        let mut bench = Bench::new();
        let model = bench.driver.port_mut();
        garbage.iter().for_each(|&byte| model.line.send(byte));
        let found: Vec<f32> = (0..60).filter_map(|_| bench.poll().ok().flatten()).collect();
        // The garbage takes 11 ms at most; the altitudes of ticks 4 to 56 follow.
        prop_assert_eq!(found.len(), 14);
        prop_assert!(found.iter().all(|altitude_m| (2_000.0..2_001.0).contains(altitude_m)));
    }

    /// A corrupted byte costs one altitude at most, and never becomes another altitude.
    #[test]
    fn a_damaged_byte_never_becomes_an_altitude(after in 0u32..400, mask in 1u8..) {
        let mut bench = Bench::new();
        bench.driver.port_mut().line.faults.flip_bits = Some((after, mask));
        let mut found = Vec::new();
        for _ in 0..200 {
            if let Ok(Some(altitude_m)) = bench.poll() {
                found.push(altitude_m);
            }
        }
        prop_assert!((48..=49).contains(&found.len()), "{}", found.len());
        let sent = |k: u64| 2_000.0 + (k * EVERY * TICK_US) as f32 * 1e-6;
        prop_assert!(found.iter().all(|altitude_m| (1..=50).any(|k| sent(k) == *altitude_m)));
    }
}
