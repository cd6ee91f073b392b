//! Recognised logs of other makers that cannot be imported: they have no receiver altitude.

/// Bits of a record's kind in a CATS log that give the sensor's number.
const SENSOR: u32 = 0xf;
/// This many records in a row are not a coincidence.
const LEAST_RECORDS: usize = 16;
/// Longest version text at the beginning of a CATS log.
const LONGEST_VERSION: usize = 48;

/// Describes a recognised log without a receiver's altitude, and what to do.
pub fn without_receiver(log: &[u8]) -> Option<&'static str> {
    if is_cats(log) {
        return Some(
            "a flight log of a CATS flight computer: it has the receiver's latitude, longitude and satellites, but no altitude",
        );
    }
    is_blue_raven(log).then_some(
        "CSV of a Featherweight Blue Raven: it has no receiver; add the altitude of one that flew along as a column \
         gps_alt_m, then 'pylon import TABLE --guess' reads it",
    )
}

/// A CATS log (`.cfl`): the firmware's version, a zero, and records of a time, a kind and the data of that
/// kind, without a checksum (<https://github.com/catsystems/cats-embedded>, `flash/recorder.hpp`).
fn is_cats(log: &[u8]) -> bool {
    let head = log.get(..LONGEST_VERSION).unwrap_or(log);
    let Some(end) = head.iter().position(|byte| *byte == 0) else { return false };
    let version = head.get(..end).unwrap_or_default();
    if version.is_empty() || !version.iter().all(u8::is_ascii_graphic) {
        return false;
    }
    let mut rest = log.get(end + 1..).unwrap_or_default();
    for _ in 0..LEAST_RECORDS {
        let Some((kind, _)) = rest.get(4..).and_then(|bytes| bytes.split_first_chunk()) else { return false };
        let length = match u32::from_le_bytes(*kind) & !SENSOR {
            // Inertial; height, speed and acceleration.
            0x10 | 0x40 => 12,
            // Pressure and temperature; attitude; filtered; event.
            0x20 | 0x80 | 0x100 | 0x400 => 8,
            // State; error.
            0x200 | 0x800 => 4,
            // Position; voltage.
            0x1000 => 9,
            0x2000 => 2,
            _ => return false,
        };
        let Some(next) = rest.get(8 + length..) else { return false };
        rest = next;
    }
    true
}

/// Blue Raven's low-rate and high-rate tables, as exported by the app; with a column of a receiver they are
/// ordinary tables.
fn is_blue_raven(log: &[u8]) -> bool {
    let line = log.split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    let has = |name: &[u8]| memchr::memmem::find(line, name).is_some();
    has(b"Flight_Time_(s)") && (has(b"Baro_Press_(") || has(b"Accel_X")) && !has(b"gps") && !has(b"GPS")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_without_a_receivers_altitude_are_known_by_what_is_in_them() {
        let mut cats = b"3.0.1\0".to_vec();
        for k in 0..40_u32 {
            let (kind, length) = [(0x10_u32, 12), (0x21, 8), (0x1000, 9)][k as usize % 3];
            cats.extend((k * 10).to_le_bytes());
            cats.extend(kind.to_le_bytes());
            cats.resize(cats.len() + length, 7);
        }
        assert!(without_receiver(&cats).is_some_and(|what| what.contains("CATS")));
        // One invalid record.
        cats[6 + 4] = 0;
        assert_eq!(without_receiver(&cats), None);
        let names = "Year,Month,Day,Time,Flight_Time_(s),Sync,Temperature_(F),Baro_Press_(atm),Baro_Altitude_ASL_(feet)";
        assert!(without_receiver(names.as_bytes()).is_some_and(|what| what.contains("Blue Raven")));
        assert_eq!(without_receiver(format!("{names},gps_alt_m\n").as_bytes()), None);
        assert_eq!(without_receiver(b""), None);
    }
}
