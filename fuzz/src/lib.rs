//! Processes bytes that were never meant as a log. No step may panic, hang, or take memory without a bound;
//! whatever was read can be written, and has an overview.

use pylon::flight::{self, Flight};
use pylon::import::mapping::{self, Layout, LoggedTable};
use pylon::import::{self, Importer, guess, import};
use pylon::overview::{Overview, text};
use pylon::simulate::Scenario;

/// Flights with more rows are not analysed: a hang could no longer be distinguished from a long flight.
const MOST_ROWS: usize = 20_000;

fn used(flight: &Flight) {
    let mut written = Vec::new();
    flight::to_writer(&mut written, flight).expect("a vector takes everything");
    if flight.rows() <= MOST_ROWS {
        let overview = Overview::new("log", "fuzzed", flight, &[], None);
        assert!(!text(&overview).is_empty());
    }
}

fn by(importer: &dyn Importer, bytes: &[u8]) {
    if let Ok((flight, _)) = importer.import(bytes) {
        used(&flight);
    }
    // As for a user: by the importer that recognises it.
    if importer.recognises(bytes) {
        let _ = import(bytes);
    }
}

macro_rules! importers {
    ($($name:ident = $importer:expr;)*) => {
        $(
            #[doc = concat!("Fuzzes `", stringify!($importer), "`.")]
            pub fn $name(bytes: &[u8]) {
                by(&$importer, bytes);
            }
        )*
    };
}

importers! {
    ulog = import::ulog::Ulog;
    mcap = import::mcap::Mcap;
    altus = import::altus::Altus;
    own_parquet = import::parquet::Parquet;
    dataflash = import::dataflash::DataFlash;
    dataflash_text = import::dataflash::DataFlashText;
    igc = import::igc::Igc;
    record = import::record::Record;
    tlog = import::tlog::Tlog;
}

/// Parquet: as Pylon's own file, and as any table, with the mapping drafted for it.
pub fn parquet(bytes: &[u8]) {
    own_parquet(bytes);
    if let Ok(table) = import::parquet::table(bytes) {
        by_draft(bytes, &table);
    }
}

/// Any text of numbers, with the mapping drafted for it.
pub fn table(bytes: &[u8]) {
    if let Some(layout) = Layout::find(bytes) {
        by_draft(bytes, &LoggedTable::read(bytes, layout));
    }
}

fn by_draft(bytes: &[u8], table: &LoggedTable) {
    let draft = guess::guess(table);
    if let Ok(mapping) = mapping::Mapping::parse(&draft.text("log.csv", "mapping.toml"))
        && let Ok((flight, _)) = mapping::import(bytes, &mapping, "mapping.toml")
    {
        used(&flight);
    }
}

/// A flight's own CSV.
pub fn flight_csv(bytes: &[u8]) {
    if let Ok((flight, _)) = flight::parse(bytes) {
        used(&flight);
    }
}

/// A model file.
pub fn model(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(model) = ::model::Model::parse(text)
    {
        let _ = model.warnings();
        let _ = pylon::replay::mission(&model);
    }
}

/// A scenario; it is not flown, because it may last as long as it states.
pub fn scenario(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Scenario::from_toml(text, "fuzzed.toml");
    }
}
