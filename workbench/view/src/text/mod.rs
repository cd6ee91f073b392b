//! Tables and charts as strings, for a terminal. The caller decides whether there is one and whether it
//! supports colours.

mod curve;
mod printable;
mod table;

pub use curve::stack;
pub use printable::printable;
pub use table::table;
