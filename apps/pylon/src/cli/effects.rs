//! `pylon effects`.

use std::path::PathBuf;

use clap::Args;
use kf_core::effect::EffectId;
use pylon::effect_guide::{Picture, explained, list, named, nearest};
use pylon::output_file::write_atomically;
use pylon::plots::draw_effect;
use pylon::results::EffectsResult;

use super::failure::Failure;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon effects
      the catalogue: what each effect is, and how large it can be
  pylon effects baro.lag
      one of them: its formula, the columns that it needs, and what it looks like on a simulated flight
  pylon effects baro.lag --svg lag.svg
      the same picture as a file
  pylon effects baro
      all of the barometer's
  pylon effects --model ours.toml
      the catalogue, and the effects that the model defines by formula
  pylon effects baro.flap_wash --model ours.toml
      one of them: its formula, the columns it reads and their units
  pylon effects --json | jq '.effects[].effect'
      for other programs";

/// Explain the physical effects that a model can account for
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// An effect, or a sensor to explain all of its effects
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// A model whose own effects, defined by formulas, are listed too
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Draw the effect on a simulated flight into this file (SVG)
    #[arg(long, value_name = "FILE", requires = "name")]
    svg: Option<PathBuf>,
    /// Print JSON
    #[arg(long, conflicts_with = "svg")]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.as_deref().map(load::model).transpose()?.unwrap_or_default();
    let Some(name) = &arguments.name else {
        return if arguments.json {
            terminal::put_json(&EffectsResult::new(&EffectId::ALL))
        } else {
            terminal::put(&list(&model))
        };
    };
    let effects = named(&model, name);
    if effects.is_empty() {
        let hint = nearest(&model, name)
            .map_or_else(|| "'pylon effects' lists them".to_owned(), |nearest| format!("is it '{nearest}'?"));
        return Err(Failure::input(format!("no effect '{name}' ({hint})")));
    }
    if arguments.json {
        return terminal::put_json(&EffectsResult::new(&effects));
    }
    if let Some(file) = &arguments.svg {
        let [effect] = effects.as_slice() else {
            return Err(Failure::input(format!(
                "--svg draws one effect, expected one of: {}",
                names(&effects)
            )));
        };
        let Some(picture) = Picture::of(*effect) else {
            return Err(Failure::input(format!(
                "{}: not in the simulator, so it cannot be drawn",
                effect.name()
            )));
        };
        let svg = draw_effect(&picture)?;
        write_atomically(file, |out| out.write_all(svg.as_bytes()))?;
        return terminal::put(&format!("{}: {}\n", file.display(), picture.caption()));
    }
    let is_one = effects.len() == 1;
    let texts = effects.into_iter().map(|effect| {
        // For many effects, a picture of each would fill pages.
        let picture = Picture::of(effect).filter(|_| is_one);
        let drawn = picture.map(|picture| format!("\n{}\n\n{}", picture.caption(), picture.text()));
        explained(&model, effect) + &drawn.unwrap_or_default()
    });
    terminal::put(&texts.collect::<Vec<_>>().join("\n"))
}

fn names(effects: &[EffectId]) -> String {
    effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(", ")
}
