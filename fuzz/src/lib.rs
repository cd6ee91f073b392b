//! What is done with bytes that nobody meant as a log. Nothing of it may panic, hang, or take memory without
//! a bound; what is read can be written, and says what is in it.

use pylon::flight::{self, Flight};
use pylon::import::mapping::{self, Layout, LoggedTable};
use pylon::import::{self, Importer, guess, import};
use pylon::overview::{Overview, text};
use pylon::simulate::Scenario;

/// More rows than this are not analysed: a hang would be told from a long flight no more.
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
    // As a user would: whatever it is recognised as.
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

/// Parquet: Pylon's own, and as any table by the mapping that is drafted for it.
pub fn parquet(bytes: &[u8]) {
    own_parquet(bytes);
    if let Ok(table) = import::parquet::table(bytes) {
        by_draft(bytes, &table);
    }
}

/// Any text of numbers, by the mapping that is drafted for it.
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

/// A scenario; it is not flown, which may take as long as it says.
pub fn scenario(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Scenario::from_toml(text, "fuzzed.toml");
    }
}
