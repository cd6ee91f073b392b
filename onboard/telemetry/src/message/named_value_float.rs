//! NAMED_VALUE_FLOAT (251).

use mavlink::dialects::common::NAMED_VALUE_FLOAT_DATA;

use crate::named::Name;

/// A value under a name of [`crate::named`], which has a table of the units.
#[must_use]
pub const fn named_value_float(time_ms: u32, name: Name, value: f32) -> NAMED_VALUE_FLOAT_DATA {
    NAMED_VALUE_FLOAT_DATA { time_boot_ms: time_ms, value, name: name.field() }
}
