//! The command line of Pylon's workbench.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
