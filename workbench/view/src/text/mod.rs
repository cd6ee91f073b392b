//! Tables and charts as strings, for a terminal. Whether there is one, and whether it takes colours, only the
//! caller knows.

mod curve;
mod printable;
mod table;

pub use curve::stack;
pub use printable::printable;
pub use table::table;
