//! IGC, the log of gliders and paragliders (FAI, "Technical Specification for GNSS Flight Recorders",
//! appendix A).
//!
//! | in the log | in the flight |
//! |---|---|
//! | GNSS altitude of fixes with validity A | `gps_alt_m`; its datum by the ALG header |
//! | pressure altitude | `baro_alt_m`, above 1013.25 hPa, unless it is zero throughout or a copy |
//! | positions | `gps_vn_mps`, `gps_ve_mps`, by differences; `latitude_deg`, `longitude_deg` |
//! | SIU, VXA | `gps_sats`, `gps_vacc_m` |
//! | TAS, or IAS and density | `tas_mps` |
//! | OAT | `oat_c` |
//! | VAR, VAT, GSP, headings, ENL, FXA | signals of their own |
//! | other additional numbers | signals `igc_` and the code, as they stand |
//!
//! There is no measured vertical velocity in the format, so there is no `gps_vd_mps`.

mod convert;
mod log;
pub mod records;
mod times;
pub mod units;

pub use log::{Altitudes, Log, Losses};

use crate::import::{ImportError, Importer};
use flight_data::{Flight, Note};

/// A log is recognised by its content within this many bytes.
const SNIFFED: usize = 1 << 18;

/// The importer of IGC logs.
#[derive(Clone, Copy, Debug)]
pub struct Igc;

impl Importer for Igc {
    fn name(&self) -> &'static str {
        "IGC"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        let head = log.get(..SNIFFED).unwrap_or(log);
        head.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| {
            line.starts_with(b"HFDTE") || line.starts_with(b"HPDTE") || records::fix(line).is_some()
        })
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        convert::convert(Log::read(log))
    }
}

#[cfg(test)]
mod tests;
