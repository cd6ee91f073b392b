//! The logs, and their division into two halves.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use kf_core::atmosphere::pressure_altitude_m;
use pylon::flight::{Channel, Column, Flight};
use pylon::import::import_file;

/// Which half of the logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// For development.
    Development,
    /// Not to be used before the end.
    Unseen,
}

impl Half {
    /// The half that a file belongs to, by its name: even or odd by FNV-1a (Fowler, Noll, Vo;
    /// draft-eastlake-fnv).
    #[must_use]
    pub fn of(name: &str) -> Self {
        // The lowest bit of the hash depends only on the sum of the bytes; the highest depends on all of
        // them.
        if hash(name) >> 63 == 0 { Self::Development } else { Self::Unseen }
    }
}

/// FNV-1a of a name: the same on every machine and with every compiler.
#[must_use]
pub fn hash(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// A log that was read.
#[derive(Clone, Debug)]
pub struct Log {
    /// Its file's name.
    pub name: String,
    /// The flight; its barometer is an altitude.
    pub flight: Flight,
}

/// The logs of a half, by name, and those that can't be read, with the reason; `None` if the folder is
/// absent.
///
/// # Errors
/// If a folder can't be listed.
pub fn logs(half: Half) -> anyhow::Result<Option<(Vec<Log>, Vec<String>)>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/flights/real");
    if !folder.exists() {
        return Ok(None);
    }
    let mut files = Vec::new();
    list(&folder, &mut files)?;
    files.sort();
    let (mut logs, mut unread) = (Vec::new(), Vec::new());
    for (name, path) in files.into_iter().filter(|(name, _)| Half::of(name) == half) {
        match import_file(&path) {
            Ok((flight, _)) => logs.push(Log { name, flight: with_altitude(flight) }),
            Err(error) => {
                // The error contains the file's whole path, which is specific to this machine.
                let error = error.to_string().replace(&format!("{}: ", path.display()), "");
                unread.push(format!("{name}: {error}"));
            }
        }
    }
    Ok(Some((logs, unread)))
}

fn list(folder: &Path, files: &mut Vec<(String, PathBuf)>) -> anyhow::Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else if let Some(name) = path.file_name().and_then(|name| name.to_str())
            && name != "SOURCES.md"
        {
            files.push((name.to_owned(), path.clone()));
        }
    }
    Ok(())
}

/// The flight with its pressures converted to pressure altitudes, to which metres can be added.
fn with_altitude(mut flight: Flight) -> Flight {
    let Some(pressure) = flight.channel(Channel::BaroPa) else { return flight };
    let mut altitude = Column::with_capacity(pressure.len());
    for row in 0..pressure.len() {
        altitude.push(pressure.get(row).and_then(pressure_altitude_m));
    }
    flight.channels.retain(|(channel, _)| *channel != Channel::BaroPa);
    flight.set_channel(Channel::BaroAltM, altitude);
    flight
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the reference implementation's test vectors.
    #[test]
    fn a_name_is_in_the_same_half_everywhere() {
        assert_eq!(hash(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(hash("foobar"), 0x8594_4171_f739_67e8);
    }
}
