//! What is in a log, in the words of who flew it: `pylon open`, which is [`analysis::overview`], and its
//! text.

mod text;

pub use analysis::overview::*;
pub use text::text;
