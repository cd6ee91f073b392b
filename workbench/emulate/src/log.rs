//! The firmware's log: defmt frames on QEMU's or OpenOCD's standard output, whose texts are in the image.

use defmt_decoder::{DecodeError, Table};

/// The lines of a log. For a frame that does not decode there is a line that reports it.
pub(super) fn lines(image: &[u8], logged: &[u8]) -> Vec<String> {
    let table = match Table::parse(image) {
        Ok(Some(table)) => table,
        Ok(None) => return vec!["(the image has no log)".to_owned()],
        Err(error) => return vec![format!("(the image's log table does not parse: {error})")],
    };
    let mut decoder = table.new_stream_decoder();
    decoder.received(logged);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let level = frame.level().map_or("", |level| level.as_str());
                lines.push(format!("{level} {}", frame.display_message()));
            }
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => {
                lines.push("(a damaged line)".to_owned());
                if !table.encoding().can_recover() {
                    return lines;
                }
            }
        }
    }
}
