//! The monitor's rules as curves: `cargo xtask monitor-curves`.

use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Parser;
use host_tests::monitor_curves::page::page;

/// Compare rules for the monitor on the same residuals, and write docs/monitor-rules.md with its picture.
#[derive(Debug, Parser)]
#[command(name = "monitor_curves")]
struct Arguments {
    /// Seed of the generated residuals.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of launches for each generated residual.
    #[arg(long, default_value_t = 2_000, value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    launches: u32,
    /// Folder for both files.
    #[arg(long, default_value = "docs")]
    folder: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let (text, picture) = page(arguments.seed, arguments.launches as usize);
    for (name, content) in [("monitor-rules.md", text), ("monitor-rules.svg", picture)] {
        let path = arguments.folder.join(name);
        fs::write(&path, content).with_context(|| format!("{} cannot be written", path.display()))?;
        println!("wrote {}", path.display());
    }
    Ok(())
}
