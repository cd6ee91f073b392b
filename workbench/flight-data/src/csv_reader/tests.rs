use proptest::prelude::*;

use super::rows::{SHORTEST_PART, split_at_lines};
use super::*;
use crate::{Channel, Column, MAX_TIME_S, to_writer};

const HEAD: &str = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_pa,launch,flap\n";

/// Reads in this many parts, the last one first.
struct Parts(usize);

impl Executor for Parts {
    fn width(&self) -> usize {
        self.0
    }

    fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).rev().for_each(job);
    }
}

fn read_rows(rows: &str) -> Flight {
    parse(format!("{HEAD}{rows}").as_bytes()).unwrap().0
}

fn message(text: &str) -> String {
    let message = parse(text.as_bytes()).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn rows_message(rows: &str) -> String {
    message(&format!("{HEAD}{rows}"))
}

#[test]
fn reads_header_columns_and_cells() {
    let text = "\u{feff}# pylon-flight: 1\r\n# vehicle: drop model\r\n# source: by hand\r\n# altitude_datum: ellipsoid\r\n\
                # site: here: there\r\n# remark\r\n\r\nbaro_pa , time_s,gps_alt_m,flap\r\n101325, 0 ,2100.5,\r\n\r\n,1.5,,-.25\r\n";
    let (flight, notes) = parse(text.as_bytes()).unwrap();
    assert_eq!(notes, []);
    assert_eq!(flight.header.vehicle, "drop model");
    assert_eq!(flight.header.source, "by hand");
    assert_eq!(flight.header.altitude_datum, AltitudeDatum::Ellipsoid);
    let other = [("site", "here: there"), ("", "remark")];
    assert_eq!(flight.header.other, other.map(|(key, value)| (key.to_owned(), value.to_owned())));
    assert_eq!(flight.time_s, [0.0, 1.5]);
    let cells = |channel| {
        let column = flight.channel(channel).unwrap();
        [column.get(0), column.get(1)]
    };
    assert_eq!(cells(Channel::BaroPa), [Some(101_325.0), None]);
    assert_eq!(cells(Channel::GpsAltM), [Some(2100.5), None]);
    assert_eq!(flight.extra[0].0, "flap");
    assert_eq!([flight.extra[0].1.get(0), flight.extra[0].1.get(1)], [None, Some(-0.25)]);
}

/// Line feeds, carriage returns or both give the same flight: no header value may contain a line end.
#[test]
fn any_line_end_ends_a_line_of_the_header_too() {
    let text = "# pylon-flight: 1\n# vehicle: drop model\n# remark\n\ntime_s,gps_alt_m,baro_alt_m\n0,2100.5,2090\n1,2100,2089\n";
    for end in ["\n", "\r\n", "\r"] {
        let (flight, notes) = parse(text.replace('\n', end).as_bytes()).unwrap();
        assert_eq!(flight.header.vehicle, "drop model", "{end:?}");
        assert_eq!(flight.header.other, [(String::new(), "remark".to_owned())], "{end:?}");
        assert_eq!((flight.time_s, notes), (vec![0.0, 1.0], vec![]), "{end:?}");
    }
}

#[test]
fn nan_and_infinite_cells_are_samples() {
    let flight = read_rows("0,nan,inf,0,-inf\n1,NaN,-Infinity,1,\n");
    let gps = flight.channel(Channel::GpsAltM).unwrap();
    assert!(gps.get(0).unwrap().is_nan() && gps.get(1).unwrap().is_nan());
    let baro = flight.channel(Channel::BaroPa).unwrap();
    assert_eq!([baro.get(0), baro.get(1)], [Some(f32::INFINITY), Some(f32::NEG_INFINITY)]);
}

#[test]
fn times_may_repeat_and_run_backward() {
    assert_eq!(read_rows("5,1,1,0,\n5,1,1,0,\n4,1,1,0,\n").time_s, [5.0, 5.0, 4.0]);
}

#[test]
fn quoted_numbers_are_numbers() {
    let flight = read_rows("\"0\",\"2100\",\"101325\",\"0\",\"1.5\"\n");
    assert_eq!(flight.extra[0].1.get(0), Some(1.5));
}

#[test]
fn says_what_is_wrong_with_a_file() {
    assert!(message("").starts_with("the file is empty"));
    assert!(message(" \n\r\n").starts_with("the file is empty"));
    assert!(message("time_s,gps_alt_m,baro_pa\n0,1,2\n").starts_with("no '# pylon-flight: 1' line"));
    assert!(message("\u{0}\u{1}\n").starts_with("no '# pylon-flight: 1' line"));
    assert!(message("# pylon-flight: 2\n").starts_with("row 1: pylon-flight version '2'"));
    assert!(
        message("# pylon-flight: 1\n# altitude_datum: agl\n").contains("'agl', expected msl or ellipsoid")
    );
    assert!(
        message("# pylon-flight: 1\n# source: a\n# source: b\n").starts_with("row 3: header key 'source'")
    );
    assert!(message("# pylon-flight: 1\n\n").starts_with("no row of column names"));
    assert!(
        message("# pylon-flight: 1\ntime_s;gps_alt_m;baro_pa\n").contains("by semicolons, expected commas")
    );
    assert!(
        message("# pylon-flight: 1\ntime_s,gps_alt_ft,baro_pa\n0,1,2\n")
            .starts_with("row 2, column gps_alt_ft")
    );
    assert!(rows_message("").starts_with("no row after the column names"));
    let not_text = parse(b"# pylon-flight: 1\n# vehicle: \xff\n").unwrap_err().to_string();
    assert!(not_text.starts_with("row 2: not UTF-8"), "{not_text}");
}

#[test]
fn says_what_is_wrong_with_a_row() {
    let good = "0,1,1,0,\n";
    for (rows, expected) in [
        ("1,2,3\n", "row 4: 3 cells, expected 5; the row is cut after column baro_pa"),
        ("1,2,3,0,4,5\n", "row 4: 6 cells, expected 5 as in the row of column names"),
        ("1,2,abc,0,\n", "row 4, column baro_pa: 'abc', expected a number or an empty cell"),
        ("1,2,1,0,1e\n", "row 4, column flap: '1e', expected a number or an empty cell"),
        ("1,2,1,0.5,\n", "row 4, column launch: '0.5', expected 0 or 1"),
        ("1,2,1,nan,\n", "row 4, column launch: 'nan', expected 0 or 1"),
        ("x,2,1,0,\n", "row 4, column time_s: 'x', expected seconds from 0 on (up to 9e9)"),
        (",2,1,0,\n", "row 4, column time_s: '', expected seconds from 0 on (up to 9e9)"),
        ("nan,2,1,0,\n", "row 4, column time_s: 'nan', expected seconds from 0 on (up to 9e9)"),
        ("inf,2,1,0,\n", "row 4, column time_s: 'inf', expected seconds from 0 on (up to 9e9)"),
        ("-1,2,1,0,\n", "row 4, column time_s: '-1', expected seconds from 0 on (up to 9e9)"),
        ("# late: remark\n", "row 4: 1 cells, expected 5; the row is cut after column time_s"),
    ] {
        assert_eq!(rows_message(&format!("{good}{rows}")), expected);
    }
    // A blank line counts as a line, and CR LF as one.
    assert!(rows_message("0,1,1,0,\n\n1,a,1,0,\n").starts_with("row 5, column gps_alt_m"));
    assert!(rows_message("0,1,1,0,\r\n1,a,1,0,\r\n").starts_with("row 4, column gps_alt_m"));
    assert!(rows_message("\n0,a,1,0,\r\n").starts_with("row 4, column gps_alt_m"));
    let long = rows_message(&format!("0,{},1,0,\n", "z".repeat(1000)));
    assert!(long.len() < 150, "{long}");
}

#[test]
fn a_receiver_time_too_coarse_for_f32_is_refused() {
    let head = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_pa,gps_time_s\n";
    let error = message(&format!("{head}0,1,2,1700000000.2\n"));
    assert!(error.starts_with("row 3, column gps_time_s: '1700000000.2', expected seconds below"), "{error}");
    parse(format!("{head}0,1,2,604799.8\n1,1,2,nan\n2,1,2,\n").as_bytes()).unwrap();
}

#[test]
fn a_last_row_without_line_end_is_noted() {
    let (flight, notes) = parse(format!("{HEAD}0,1,1,0,12").as_bytes()).unwrap();
    assert_eq!(flight.rows(), 1);
    assert!(notes[0].text().contains("no line end"));
}

/// Long enough for several parts; the bad row lies in the last of them.
#[test]
fn rows_are_the_same_however_many_parts_they_are_read_in() {
    let mut text = String::from(HEAD);
    let rows = 80_000;
    for row in 0..rows {
        text +=
            &format!("{row},{}.25,{},{},{row}.5\n", 2000 + row % 97, 80_000 + row % 1013, u8::from(row > 9));
    }
    let layout_of = |text: &[u8], parts| split_at_lines(text, parts).concat() == text;
    assert!(text.len() > 2 * SHORTEST_PART);
    assert!((1..9).all(|parts| layout_of(text.as_bytes(), parts)));
    for parts in [1, 2, 5] {
        let (flight, _) = parse_with(text.as_bytes(), &Parts(parts)).unwrap();
        assert_eq!(flight.rows(), rows);
        for row in (0..rows).step_by(7) {
            assert_eq!(flight.time_s[row], row as f64);
            assert_eq!(
                flight.channel(Channel::GpsAltM).unwrap().get(row),
                Some((2000 + row % 97) as f32 + 0.25)
            );
            assert_eq!(flight.extra[0].1.get(row), Some(row as f32 + 0.5));
        }
        let bad = format!("{text}80000,oops,1,1,\n");
        let line = rows + 3;
        let message = parse_with(bad.as_bytes(), &Parts(parts)).unwrap_err().to_string();
        assert!(message.starts_with(&format!("row {line}, column gps_alt_m: 'oops'")), "{message}");
    }
}

/// Values of every kind, with blank lines between, in a text of several parts.
#[test]
fn line_ends_make_no_rows_and_lose_none() {
    let rows = 80_000;
    let row = |row: usize| {
        format!("{row},{}.25,{},{},{row}.5", 2000 + row % 97, 80_000 + row % 1013, u8::from(row > 9))
    };
    for ends in [&["\n"][..], &["\r\n"], &["\r"], &["\n\n\n"], &["\r", "\n", "\r\n", "\n\r", "\n\n"]] {
        let mut text = String::from(HEAD);
        for index in 0..rows {
            text += &row(index);
            text += ends[index % ends.len()];
        }
        assert!(text.len() > 2 * SHORTEST_PART);
        let (flight, _) = parse_with(text.as_bytes(), &Parts(3)).unwrap();
        assert_eq!(flight.rows(), rows, "{ends:?}");
        assert!(flight.time_s.iter().enumerate().all(|(row, time_s)| *time_s == row as f64), "{ends:?}");
        let extra = &flight.extra[0].1;
        assert!((0..rows).all(|row| extra.get(row) == Some(row as f32 + 0.5)), "{ends:?}");
        assert_eq!(extra.len(), rows, "{ends:?}");
    }
}

fn cell() -> impl Strategy<Value = Option<f32>> {
    prop_oneof![
        2 => Just(None),
        6 => any::<f32>().prop_map(Some),
        6 => (-1e5f32..1e5).prop_map(Some),
        1 => Just(Some(f32::NAN)),
    ]
}

fn any_flight() -> impl Strategy<Value = Flight> {
    let row = (0.0..MAX_TIME_S, prop::collection::vec(cell(), 4), prop::option::of(any::<bool>()));
    (prop::collection::vec(row, 1..40), "[ -~]{0,20}", "[a-z]{1,8}").prop_map(|(rows, text, name)| {
        let mut columns = vec![Column::default(); 4];
        let mut launch = Column::default();
        let mut flight = Flight::default();
        for (time, cells, released) in rows {
            flight.time_s.push(time);
            columns.iter_mut().zip(cells).for_each(|(column, cell)| column.push(cell));
            launch.push(released.map(|released| f32::from(u8::from(released))));
        }
        flight.header.vehicle = text.trim().to_owned();
        flight.header.other.push(("key".into(), text.trim().to_owned()));
        flight.extra.push((format!("{name} \"x\", y"), columns.remove(3)));
        flight.set_channel(Channel::Launch, launch);
        for (channel, column) in [Channel::GpsAltM, Channel::BaroPa, Channel::OatC].into_iter().zip(columns) {
            flight.set_channel(channel, column);
        }
        flight
    })
}

fn text_of(flight: &Flight) -> Vec<u8> {
    let mut text = Vec::new();
    to_writer(&mut text, flight).unwrap();
    text
}

proptest! {
    #[test]
    fn every_flight_reads_back_to_the_bit(flight in any_flight()) {
        let text = text_of(&flight);
        let (read, notes) = parse(&text).unwrap();
        prop_assert_eq!(notes, []);
        prop_assert_eq!(&read.header, &flight.header);
        prop_assert_eq!(&read.time_s, &flight.time_s);
        let bits = |column: &Column| {
            (0..column.len())
                .map(|row| column.get(row).map(|value| if value.is_nan() { u32::MAX } else { value.to_bits() }))
                .collect::<Vec<_>>()
        };
        for (channel, column) in &flight.channels {
            prop_assert_eq!(bits(read.channel(*channel).unwrap()), bits(column));
        }
        prop_assert_eq!(&read.extra[0].0, &flight.extra[0].0);
        prop_assert_eq!(bits(&read.extra[0].1), bits(&flight.extra[0].1));
        prop_assert_eq!(text_of(&read), text);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = parse(&bytes);
        let _ = parse(&[HEAD.as_bytes(), &bytes].concat());
    }

    #[test]
    fn a_flight_cut_anywhere_is_an_error_or_whole_rows(flight in any_flight(), cut in any::<prop::sample::Index>()) {
        let text = text_of(&flight);
        let end = cut.index(text.len());
        match parse(&text[..end]) {
            Err(problem) => prop_assert!(!problem.to_string().contains('\n')),
            Ok((read, notes)) => {
                let at_line_end = text[..end].ends_with(b"\n");
                prop_assert_eq!(notes.len(), usize::from(!at_line_end));
                let sure = if at_line_end { read.rows() } else { read.rows() - 1 };
                prop_assert_eq!(&read.time_s[..sure], &flight.time_s[..sure]);
            }
        }
    }
}
