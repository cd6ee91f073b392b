use super::*;
use crate::export::parquet::write;
use flight_data::parse;

const FLIGHT: &str = "# pylon-flight: 1\n# vehicle: test\n# source: made for a test\n# altitude_datum: ellipsoid\n# zone: UTC\n# campaign: \
    x\ntime_s,launch,gps_alt_m,gps_sats,baro_alt_m,flap_deg\n0,0,100.125,9,101.1,\n0.005,,,,nan,3\n0.01,1,,,102.3,\n0.01,1,,,102.4,\n\
    0.02,,,,,\n0.015,1,99,,102.5,\n";

fn exported() -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, &parse(FLIGHT.as_bytes()).unwrap().0).unwrap();
    bytes
}

/// Start of the footer.
fn footer(file: &[u8]) -> usize {
    let length = u32::from_le_bytes(file[file.len() - 8..file.len() - 4].try_into().unwrap());
    file.len() - 8 - length as usize
}

#[test]
fn what_was_exported_comes_back_byte_for_byte() {
    assert_eq!(crate::import::testing::written(&exported()), FLIGHT);
}

#[test]
fn one_that_is_cut_or_changed_never_panics_and_says_which_column_it_costs() {
    let whole = exported();
    for cut in 0..whole.len() {
        assert!(Parquet.import(&whole[..cut]).is_err());
        let _ = table(&whole[..cut]);
    }
    let (mut refused, mut said_so, mut changed) = (0, 0, 0);
    let (clean, _) = flight(&whole).unwrap();
    for at in 0..whole.len() {
        for flip in [1, 0x10, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            let _ = table(&bytes);
            match flight(&bytes) {
                Err(_) => refused += 1,
                Ok((flight, notes)) => {
                    assert!(flight.rows() <= clean.rows());
                    said_so += usize::from(!notes.is_empty());
                    changed += usize::from(notes.is_empty());
                }
            }
        }
    }
    assert!(refused > 100 && said_so > 100 && changed > 100, "{refused} {said_so} {changed}");
}

#[test]
fn a_page_that_says_more_than_it_has_is_refused_before_room_is_taken_for_it() {
    let leaf =
        footer::Leaf { name: "x".to_owned(), kind: footer::Kind::Plain, is_repeated: false, width: Some(8) };
    let chunk = |values, codec| footer::Chunk { start: 4, length: 0, values, codec };
    // Fields 1 (kind), 2 (whole size), 3 (packed size), 5 (a data page: values, plain encoding).
    let page = |whole: &[u8], values: &[u8]| {
        [&[0x15, 0, 0x15][..], whole, &[0x15, 0x10, 0x2c, 0x15], values, &[0x15, 0, 0, 0], &[0; 8]].concat()
    };
    for codec in [0, 1] {
        pages::check(&page(&[0x10], &[2]), &leaf, &chunk(1, codec)).unwrap();
    }
    let refused = |bytes: &[u8], values, codec, words: &str| {
        let error = pages::check(bytes, &leaf, &chunk(values, codec)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    // A page of one number that decompresses to a gigabyte.
    refused(&page(&[0x80, 0x80, 0x80, 0x80, 8], &[2]), 1, 1, "a page of 1 values declares 1073741824 bytes");
    refused(&page(&[0x10], &[4]), 1, 0, "more values than the column");
    refused(&page(&[0x10], &[2]), 2, 0, "a page's head is damaged");
    refused(&page(&[0x10], &[2])[..14], 1, 0, "a page declares a wrong length");
    refused(&page(&[0x10], &[2]), 1, 2, "compressed by gzip, expected one of none, snappy, zstd, lz4");
}

#[test]
fn more_rows_than_there_can_be_are_refused() {
    let mut bytes = exported();
    let start = footer(&bytes);
    // Six rows (zigzag 12) as the last field of the row group: in their place, 2^31 of them.
    let at = bytes[start..].windows(2).rposition(|pair| pair == [0x16, 12]).unwrap() + start;
    bytes.splice(at + 1..at + 2, [0x80, 0x80, 0x80, 0x80, 0x10]);
    let length = (bytes.len() - 8 - start) as u32;
    let end = bytes.len();
    bytes[end - 8..end - 4].copy_from_slice(&length.to_le_bytes());
    let error = flight(&bytes).unwrap_err();
    assert!(matches!(error, ParquetError::TooMany { rows: 2_147_483_648, columns: 6, .. }), "{error}");
}
