//! Tests that `docs/bring-up.md` lists the same pins and rates as the board's firmware.

use crate::workspace;

const FIRMWARE: &str = "firmware/src/board/f405/wiring.rs";
const DOCUMENT: &str = "docs/bring-up.md";

fn read(file: &str) -> String {
    std::fs::read_to_string(workspace::root().join(file)).unwrap()
}

/// The documentation of an item and its line, for every item.
fn items(source: &str) -> Vec<(String, &str)> {
    let mut items = Vec::new();
    let mut comment = Vec::new();
    for line in source.lines() {
        match line.strip_prefix("///") {
            Some(text) => comment.push(text.trim()),
            None => items.push((std::mem::take(&mut comment).join(" "), line)),
        }
    }
    items
}

/// `| PA5 | SPI1_SCK | ICM-42688-P, SCLK |` for every pin.
fn pin_rows(source: &str) -> Vec<String> {
    let row = |(comment, line): &(String, &str)| {
        let pin = line.strip_prefix("pub type ")?.rsplit_once("= ")?.1;
        let pin = pin.split(['<', ';']).next()?;
        let is_pin = pin.len() > 2 && pin.starts_with('P') && pin[2..].parse::<u8>().is_ok();
        let (function, wire) = comment.split_once(": ")?;
        is_pin.then(|| format!("| {pin} | {function} | {wire} |"))
    };
    items(source).iter().filter_map(row).collect()
}

/// `| Rate of ..., baud | 38400 |` for every number: the comment up to its first colon, and the number.
fn rate_rows(source: &str) -> Vec<String> {
    let row = |(comment, line): &(String, &str)| {
        let (_, number) = line.strip_prefix("pub const ")?.split_once(" = ")?;
        let number = number.strip_suffix(';')?.replace('_', "");
        let what = comment.split_once(": ").map_or(comment.as_str(), |(what, _)| what);
        // The channel of a DMA stream does not matter for wiring.
        // Nor does a constant that is not a number.
        (!comment.starts_with("See [") && number.parse::<u64>().is_ok())
            .then(|| format!("| {} | {number} |", what.trim_end_matches('.')))
    };
    items(source).iter().filter_map(row).collect()
}

/// The rows of the table under a header.
fn table<'a>(document: &'a str, header: &str) -> Vec<&'a str> {
    let rows = document.lines().skip_while(|line| *line != header).skip(2);
    rows.take_while(|line| line.starts_with('|')).collect()
}

#[test]
fn the_pin_table_is_the_firmwares() {
    let rows = pin_rows(&read(FIRMWARE));
    assert!(rows.contains(&"| PA5 | SPI1_SCK | ICM-42688-P, SCLK |".to_owned()), "{rows:#?}");
    assert_eq!(table(&read(DOCUMENT), "| pin | function | wire to |"), rows);
}

#[test]
fn the_rates_are_the_firmwares() {
    let rows = rate_rows(&read(FIRMWARE));
    assert!(rows.contains(&"| The crystal, MHz | 8 |".to_owned()), "{rows:#?}");
    assert_eq!(table(&read(DOCUMENT), "| rate | value |"), rows);
}

#[test]
fn no_pin_is_wired_twice() {
    let mut pins: Vec<_> = pin_rows(&read(FIRMWARE)).iter().map(|row| row[..7].to_owned()).collect();
    let wired = pins.len();
    pins.sort();
    pins.dedup();
    assert_eq!(pins.len(), wired);
}

#[test]
fn a_pin_with_a_mode_and_one_without_are_both_found() {
    let source = "/// output: a chip, CS\npub type A<Mode = Input> = PA4<Mode>;\n/// SPI: b\npub type B = PC10;\npub type C = SPI1;";
    assert_eq!(pin_rows(source), ["| PA4 | output | a chip, CS |", "| PC10 | SPI | b |"]);
}
