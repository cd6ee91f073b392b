//! A flight's header, as Pylon writes it into the metadata of other programs' formats.

use flight_data::{AltitudeDatum, Header};

/// The header that these keys say, in their order. A damaged file may have line ends where a flight's header can have none.
pub fn own_header(keys: impl IntoIterator<Item = (String, String)>) -> Header {
    let clean = |text: String| text.replace(['\n', '\r'], " ");
    let mut header = Header::default();
    for (key, value) in keys {
        let value = clean(value);
        match key.trim() {
            "vehicle" => header.vehicle = value,
            "source" => header.source = value,
            "altitude_datum" if value == AltitudeDatum::Ellipsoid.name() => {
                header.altitude_datum = AltitudeDatum::Ellipsoid;
            }
            "altitude_datum" | "pylon-flight" | "" => {}
            _ => header.other.push((clean(key).replace(':', " "), value)),
        }
    }
    header
}
