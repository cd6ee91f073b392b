//! The contents of a linked image.

use std::fs;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind};

use super::error::FlyError;

/// Start of the flight computer's RAM; everything allocated below it is flash.
const RAM_START: u64 = 0x2000_0000;

/// Linker script's symbol of the start of the retained RAM.
const RETAINED_START: &str = "_retained_start";

/// Sizes and symbols of an image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Flash that the image takes, bytes: vectors, code, constants, and the initial values of variables.
    pub flash_bytes: u64,
    /// RAM that its static variables take, bytes; without the stack.
    pub static_ram_bytes: u64,
    /// Start of the RAM that a reset leaves unchanged on the boards that fly a record (`memory.x`), if the
    /// image has one.
    pub retained_start: Option<u64>,
    /// Whether a constant names a file of cargo's registry, and so the home directory of the user who built
    /// the image.
    pub names_registry: bool,
    /// Names of all symbols, demangled.
    pub symbols: Vec<String>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`FlyError::Io`], [`FlyError::Image`].
    pub fn read(path: &Path) -> Result<Self, FlyError> {
        let bytes = fs::read(path).map_err(FlyError::io(path.display().to_string()))?;
        Self::parse(&bytes).map_err(|why| FlyError::Image { path: path.display().to_string(), why })
    }

    fn parse(bytes: &[u8]) -> Result<Self, object::Error> {
        let file = object::File::parse(bytes)?;
        let mut image = Self::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            if !sh_flags.contains(object::elf::SHF_ALLOC) {
                continue;
            }
            if section.address() >= RAM_START {
                image.static_ram_bytes += section.size();
            }
            // Initial values of variables take both flash and RAM.
            if section.kind() != SectionKind::UninitializedData {
                image.flash_bytes += section.size();
                let name = b"/registry/src/";
                image.names_registry |= section.data()?.windows(name.len()).any(|window| window == name);
            }
        }
        for symbol in file.symbols() {
            // Symbols of the log's texts are not code and may contain anything.
            let in_log = symbol.section_index().is_some_and(|index| {
                file.section_by_index(index).is_ok_and(|section| section.name() == Ok(".defmt"))
            });
            if let (Ok(name), false) = (symbol.name(), in_log) {
                if name == RETAINED_START {
                    image.retained_start = Some(symbol.address());
                }
                image.symbols.push(format!("{:#}", rustc_demangle::demangle(name)));
            }
        }
        Ok(image)
    }
}
