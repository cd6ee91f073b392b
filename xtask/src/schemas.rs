//! `cargo xtask schemas`: the published JSON schemas.

use crate::child;
use crate::setup::{self, Need};
use crate::workspace;

/// Runs the test that checks the schemas in the mode that writes them.
pub fn run(echo: bool) -> anyhow::Result<()> {
    setup::provide(Need::Npm, echo)?;
    let mut test = workspace::test(["--test", "json_results", "--", "the_published_schemas"]);
    child::run(test.env("PYLON_WRITE_SCHEMAS", "1"), echo)?;
    println!("docs/schemas is up to date");
    Ok(())
}
