//! STATUSTEXT (253).

use mavlink::dialects::common::{MavSeverity, STATUSTEXT_DATA};
use mavlink::types::CharArray;

/// A text that fits into one message.
#[must_use]
pub const fn status_text(severity: MavSeverity, text: [u8; 50]) -> STATUSTEXT_DATA {
    STATUSTEXT_DATA { severity, text: CharArray::new(text), id: 0, chunk_seq: 0 }
}
