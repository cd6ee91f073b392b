//! Shared by importers' tests: parts of an imported log, and damage that costs one message and no more.

use flight_data::{Channel, Flight};

/// The flight and its notes.
pub fn import(log: &[u8]) -> (Flight, Vec<String>) {
    let (flight, notes) = super::import(log).unwrap();
    (flight, notes.iter().map(|note| note.text().to_owned()).collect())
}

/// The flight in a log that gives no notes, as Pylon's own CSV.
pub fn written(log: &[u8]) -> String {
    let (flight, notes) = super::import(log).unwrap();
    assert_eq!(notes, []);
    let mut written = Vec::new();
    flight_data::to_writer(&mut written, &flight).unwrap();
    String::from_utf8(written).unwrap()
}

/// A channel's samples; empty if it is missing.
pub fn samples(flight: &Flight, channel: Channel) -> Vec<f32> {
    flight.channel(channel).map_or_else(Vec::new, |column| column.samples().map(|(_, value)| value).collect())
}

/// A signal's samples, as [`samples`].
pub fn signal(flight: &Flight, name: &str) -> Vec<f32> {
    let found = flight.extra.iter().find(|(found, _)| found == name);
    found.map_or_else(Vec::new, |(_, column)| column.samples().map(|(_, value)| value).collect())
}

/// A signal's samples with every digit, as [`samples`].
pub fn doubles(flight: &Flight, name: &str) -> Vec<f64> {
    let found = flight.extra.iter().find(|(found, _)| found == name);
    found.map_or_else(Vec::new, |(_, column)| column.samples_f64().map(|(_, value)| value).collect())
}

/// Whether a note contains these words.
pub fn said(notes: &[String], words: &str) -> bool {
    notes.iter().any(|note| note.contains(words))
}

/// Checks the first sample of each channel and its number of samples.
pub fn assert_channels(flight: &Flight, expected: &[(Channel, usize, f32)]) {
    for &(channel, count, first) in expected {
        let found = samples(flight, channel);
        assert_eq!(found.len(), count, "{}", channel.name());
        assert!((found[0] - first).abs() <= 1e-6 * first.abs().max(1.0), "{}: {}", channel.name(), found[0]);
    }
}

/// Flips bits in each byte of a log and checks that this costs at most the damaged message. `places` gives
/// the message at a byte; data begin at `first`: pressures about 950 hPa.
pub fn assert_any_byte_costs_its_message(
    log: &[u8],
    places: impl Fn(usize) -> (usize, String),
    first: usize,
) {
    let clean = import(log).0;
    let all = samples(&clean, Channel::BaroPa).len();
    for at in 0..log.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = log.to_vec();
            bytes[at] ^= flip;
            let Ok((flight, _)) = super::import(&bytes) else {
                assert!(at < first, "byte {at} ^ {flip:#x} makes the log unusable");
                continue;
            };
            if at < first {
                continue;
            }
            let (start, name) = places(at);
            let what = format!("byte {} of {name} ^ {flip:#x}", at - start);
            // No message follows the last one; a time within seconds of the others may be its own.
            assert!(flight.time_s.last().unwrap() - clean.time_s.last().unwrap() <= 5.0, "{what}");
            let found = samples(&flight, Channel::BaroPa);
            assert!(found.len() + 2 >= all, "{what}: {} of {all}", found.len());
            let moved = found.iter().filter(|pa| !(94_000.0..96_000.0).contains(*pa)).count();
            assert!(moved <= 1, "{what}: {moved}");
        }
    }
}

/// Meaningless bytes between two messages are reported, and nothing else is lost.
pub fn assert_garbage_costs_nothing_else(log: &[u8], at: usize, garbage: &[u8]) {
    let clean = import(log).0;
    let mut bytes = log.to_vec();
    bytes.splice(at..at, garbage.iter().copied());
    let (flight, notes) = import(&bytes);
    assert_eq!(samples(&flight, Channel::BaroPa), samples(&clean, Channel::BaroPa));
    assert_eq!(flight.time_s, clean.time_s);
    let words = format!("damaged: 1 stretch, {} of the file's {} bytes", garbage.len(), bytes.len());
    assert!(said(&notes, &words) && said(&notes, &format!("the first at byte {at}")), "{notes:?}");
}

/// `count` meaningless bytes, always the same.
pub fn garbage(count: u32) -> Vec<u8> {
    (0..count).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
}
