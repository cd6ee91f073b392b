//! What a log contains, in its pilot's terms: `pylon open`, which is [`analysis::overview`], and its text.

mod text;

pub use analysis::overview::*;
pub use text::text;
