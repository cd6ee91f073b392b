//! The exact bytes on the bus.

use embedded_hal_mock::eh1::spi::{Mock, Transaction};

use super::*;
use crate::bus::expected::{read, written};

const CONFIG: Config =
    Config { accel_range: AccelRange::G8, gyro_range: GyroRange::Dps1000, mounting: Mounting::ALIGNED };

/// Reset, identity, ranges of 8 g and 1000 degrees a second at 1 kHz, read back; then one sample.
fn until_running(sample: &[u8]) -> Vec<Transaction<u8>> {
    [
        written(&[0x76, 0x00]),
        written(&[0x11, 0x01]),
        read(&[0x80 | 0x75], &[0x47]),
        read(&[0x80 | 0x2D], &[0x10]),
        written(&[0x4C, 0x33]),
        written(&[0x4D, 0x51]),
        written(&[0x4F, 0x26]),
        written(&[0x50, 0x26]),
        written(&[0x51, 0x1A]),
        written(&[0x52, 0x77]),
        written(&[0x53, 0x15]),
        written(&[0x4E, 0x0F]),
        read(&[0x80 | 0x4C], &HELD),
        read(&[0x80 | 0x1D], sample),
        read(&[0x80 | 0x4C], &HELD),
    ]
    .concat()
}

/// The configured registers from 0x4C on.
const HELD: [u8; 8] = [0x33, 0x51, 0x0F, 0x26, 0x26, 0x1A, 0x77, 0x15];

/// Temperature 0x0258, then six values, a timestamp and the status.
const SAMPLE: [u8; 17] =
    [0x02, 0x58, 0x10, 0x00, 0xF0, 0x00, 0x00, 0x01, 0x40, 0x00, 0xC0, 0x00, 0xFF, 0xFF, 0x12, 0x34, 0x08];

fn first_outcome(expected: &[Transaction<u8>]) -> (Result<Option<ImuSample>, SensorError>, Option<f32>) {
    let mut driver = Icm42688p::new(Mock::new(expected), CONFIG);
    let outcome = (0..24u64)
        .map(|tick| driver.poll(tick * 5_000))
        .find(|outcome| *outcome != Ok(None))
        .unwrap_or(Ok(None));
    driver.bus_mut().done();
    (outcome, driver.temperature_c())
}

#[test]
fn the_bytes_on_the_bus_are_the_datasheets() {
    let (outcome, temperature_c) = first_outcome(&until_running(&SAMPLE));
    let sample = outcome.unwrap().unwrap();
    // A quarter of a range of 8 g is 0x2000 counts; 0x1000 is 1 g.
    let [ax, ay, az] = sample.accel_mps2;
    assert_eq!([ax, ay], [9.806_65, -9.806_65]);
    assert!((az - 9.806_65 / 4_096.0).abs() < 1e-9);
    // 0x4000 counts are half of 1000 degrees a second.
    let [gx, gy, gz] = sample.gyro_radps;
    assert!((gx - 500f32.to_radians()).abs() < 1e-6 && gy == -gx, "{gx} {gy}");
    assert!((gz + 1_000f32.to_radians() / 32_768.0).abs() < 1e-9);
    assert!((temperature_c.unwrap() - (600.0 / 132.48 + 25.0)).abs() < 1e-5);
}

#[test]
fn another_chip_is_refused() {
    let expected = [written(&[0x76, 0]), written(&[0x11, 1]), read(&[0x80 | 0x75], &[0x68])].concat();
    let mut driver = Icm42688p::new(Mock::new(&expected), CONFIG);
    assert_eq!(driver.poll(0), Ok(None));
    assert_eq!(driver.poll(5_000), Err(SensorError::WrongDevice));
    driver.bus_mut().done();
}

#[test]
fn a_register_that_does_not_hold_is_found() {
    let mut expected = until_running(&SAMPLE);
    expected.truncate(expected.len() - 12);
    // Asked twice.
    for _ in 0..2 {
        expected.extend(read(&[0x80 | 0x4C], &[0x33, 0x51, 0x0F, 0x26, 0x06, 0x1A, 0x77, 0x15]));
    }
    assert_eq!(first_outcome_of(&expected, 14), Err(SensorError::ConfigurationLost));
}

/// A bit that flipped on the way is read again; one that the chip holds is written, and nothing else is.
#[test]
fn what_differs_is_asked_again_and_written() {
    let flipped = [0x33, 0x51, 0x0F, 0x26, 0x06, 0x1A, 0x77, 0x55];
    let sample = read(&[0x80 | 0x1D], &SAMPLE);
    let held = read(&[0x80 | 0x4C], &HELD);
    let expected = [
        until_running(&SAMPLE),
        sample.clone(),
        read(&[0x80 | 0x4C], &flipped),
        held.clone(),
        sample.clone(),
        read(&[0x80 | 0x4C], &flipped),
        read(&[0x80 | 0x4C], &flipped),
        written(&[0x50, 0x26]),
        written(&[0x53, 0x15]),
        sample,
        held,
    ]
    .concat();
    let mut driver = Icm42688p::new(Mock::new(&expected), CONFIG);
    let outcomes: Vec<_> =
        (0..40u64).map(|tick| driver.poll(tick * 5_000)).skip_while(|o| *o == Ok(None)).take(4).collect();
    driver.bus_mut().done();
    let [Ok(Some(first)), second, third, fourth] = outcomes[..] else { panic!("{outcomes:?}") };
    assert_eq!((second, third), (Ok(Some(first)), Err(SensorError::ConfigurationLost)));
    assert_eq!(fourth, Ok(Some(first)));
    let health = driver.health();
    assert_eq!((health.asked_again, health.initialisations), (2, 1));
}

fn first_outcome_of(expected: &[Transaction<u8>], ticks: u64) -> Result<Option<ImuSample>, SensorError> {
    let mut driver = Icm42688p::new(Mock::new(expected), CONFIG);
    let outcome =
        (0..ticks).map(|tick| driver.poll(tick * 5_000)).find(|outcome| *outcome != Ok(None)).unwrap();
    driver.bus_mut().done();
    outcome
}

#[test]
fn the_end_of_a_range_is_no_value() {
    for end in [[0x7F, 0xFF], [0x80, 0x00]] {
        let mut sample = SAMPLE;
        sample[6..8].copy_from_slice(&end);
        assert_eq!(first_outcome(&until_running(&sample)).0, Err(SensorError::Saturated));
    }
}

#[test]
fn axes_are_the_bodys() {
    let mounting = Mounting { forward: ChipAxis::MinusY, right: ChipAxis::PlusX, down: ChipAxis::MinusZ };
    assert_eq!(mounting.to_body([1.0, 2.0, 3.0]), [-2.0, 1.0, -3.0]);
    assert_eq!(Mounting::ALIGNED.to_body([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
}
