//! Every importer on bytes that are not meant as a log: no panic, no hang, and any flight can be written.
#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use pylon::flight::{self, Flight};
use pylon::import::mapping::{self, Layout, LoggedTable};
use pylon::import::{self, guess, import};

/// The beginning of each kind of log; some continue with a line or two.
const BEGINNINGS: [&[u8]; 10] = [
    b"",
    b"ULog\x01\x12\x35\x01\x00\x00\x00\x00\x00\x00\x00\x00",
    b"\xa3\x95\x80\x80\x59FMT\x00BBnNZ\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00Type,Length,Name,Format,Columns",
    b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 150, 30, GPS, QBIHBcLLef, TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd\n",
    b"AXXX001\r\nHFDTE150423\r\nB1101355206343N00006198WA0058700558\r\n",
    b"#version,serial,flight,call,time,state,state_name,acceleration,pressure,altitude\n6,1,2,X,0.1,3,boost,1.0,86334,1330\n",
    b"\x00\x05\xd7\x1c\x8a\x3b\x50\x00\xfe\x09\x00\x01\x01\x00",
    b"\xfd\x09\x00\x00\x00\x01\x01\x00\x00\x00",
    b"\x89MCAP0\r\n",
    b"time_s,gps_alt_m,baro_pa\n0,100,100000\n0.1,101,99990\n0.2,102,99980\n",
];

/// Anything that was read can be written, whatever its source.
fn assert_writable(flight: &Flight) {
    let mut written = Vec::new();
    flight::to_writer(&mut written, flight).unwrap();
}

fn assert_survives(bytes: &[u8]) {
    if let Ok((flight, _)) = import(bytes) {
        assert_writable(&flight);
    }
    // Each importer is called directly too, because another may have been the first to recognise the bytes.
    for importer in import::IMPORTERS {
        if let Ok((flight, _)) = importer.import(bytes) {
            assert_writable(&flight);
        }
    }
    if let Some(layout) = Layout::find(bytes) {
        let draft = guess::guess(&LoggedTable::read(bytes, layout));
        let text = draft.text("log.csv", "mapping.toml");
        if let Ok(mapping) = mapping::Mapping::parse(&text)
            && let Ok((flight, _)) = mapping::import(bytes, &mapping, "mapping.toml")
        {
            assert_writable(&flight);
        }
        assert!(!draft.explanation().is_empty());
    }
}

/// Lines that look like tables, with everything that can go wrong in them.
fn table() -> impl Strategy<Value = Vec<u8>> {
    let cell = prop_oneof![
        any::<f32>().prop_map(|value| value.to_string()),
        (-1_000_i32..1_000).prop_map(|value| value.to_string()),
        "[0-9]{1,2}:[0-9]{2}:[0-9]{2}(\\.[0-9])?",
        "20[0-9]{2}-[01][0-9]-[0-3][0-9][ T][0-2][0-9]:[0-5][0-9]:[0-5][0-9](Z|[+-][0-9]{2}:?[0-9]{0,2})?",
        "[a-z \"é]{0,6}",
        Just(String::new()),
    ];
    let names = "(time|t|lat|lon|gps_alt|alt|press|baro_pa|vn|ve|vd|climb|acc_[xyz]|gyro_[xyz]|roll|pitch|tas|temp)( \\[(m|ft|s|ms|hPa|K)\\])?";
    (2_usize..8, prop_oneof![Just(','), Just(';'), Just('\t'), Just(' ')]).prop_flat_map(
        move |(width, separator)| {
            let row = prop::collection::vec(cell.clone(), width - 1..=width);
            (prop::collection::vec(names, width), prop::collection::vec(row, 0..60)).prop_map(
                move |(names, rows)| {
                    let mut text = names.join(&separator.to_string());
                    for (place, row) in rows.iter().enumerate() {
                        // In half of them time runs forward.
                        let time = if width % 2 == 0 {
                            format!("{}{separator}", place * 100)
                        } else {
                            String::new()
                        };
                        text += &format!("\n{time}{}", row.join(&separator.to_string()));
                    }
                    text.into_bytes()
                },
            )
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_that_begins_as_a_log_and_goes_on_as_anything_panics(
        beginning in 0..BEGINNINGS.len(),
        rest in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        assert_survives(&[BEGINNINGS[beginning], &rest].concat());
    }

    #[test]
    fn nothing_that_begins_as_a_log_and_goes_on_as_text_panics(
        beginning in 0..BEGINNINGS.len(),
        rest in "([A-Z]{1,4}[0-9, .:N\\-]{0,40}\r?\n){0,20}",
    ) {
        assert_survives(&[BEGINNINGS[beginning], rest.as_bytes()].concat());
    }

    #[test]
    fn no_table_makes_a_guess_or_its_mapping_panic(table in table()) {
        assert_survives(&table);
    }
}

/// A stream of MAVLink frames under ten million bytes of damage.
#[test]
fn ten_million_bytes_of_damaged_stream_are_read_through() {
    let mut state = 0x9e37_79b9_u32;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    let mut stream = Vec::with_capacity(10_000_000);
    while stream.len() < 10_000_000 {
        // Microsecond timestamps and the start markers of both versions, in between noise that begins like
        // frames.
        stream.extend((1_600_000_000_000_000_u64 + stream.len() as u64 * 10).to_be_bytes());
        stream.push(if next() & 1 == 0 { 0xfe } else { 0xfd });
        let length = (next() % 40) as u8;
        stream.push(length);
        stream.extend((0..u32::from(length) + 12).map(|_| (next() >> 7) as u8));
    }
    if let Ok((flight, _)) = import(&stream) {
        assert_writable(&flight);
    }
    let tlog = import::tlog::Tlog;
    if let Ok((flight, _)) = import::Importer::import(&tlog, &stream) {
        assert_writable(&flight);
    }
}
