//! `pylon effects`.

use clap::Args;
use pylon::effect_guide::{explained, list, named, nearest};

use super::failure::Failure;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon effects
      the catalogue: what each effect is, and how large it can be
  pylon effects baro.lag
      one of them: its formula, the columns that it needs, and what it looks like
  pylon effects baro
      all of the barometer's";

/// Explain the physical effects that a model can account for
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// An effect, or a sensor whose effects are all to be explained
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(name) = &arguments.name else { return terminal::put(&list()) };
    let effects = named(name);
    if effects.is_empty() {
        let hint = nearest(name)
            .map_or_else(|| "'pylon effects' lists them".to_owned(), |nearest| format!("is it '{nearest}'?"));
        return Err(Failure::input(format!("no effect '{name}' ({hint})")));
    }
    let texts: Vec<String> = effects.into_iter().map(explained).collect();
    terminal::put(&texts.join("\n"))
}
