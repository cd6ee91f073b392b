//! `pylon plan`.

use std::path::PathBuf;

use clap::Args;
use pylon::flight::Flight;
use pylon::output_file::write_atomically;
use pylon::overview::quoted;
use pylon::plan::{diagnose, is_hopeless, suggest, text};
use pylon::results::PlanResult;

use super::failure::Failure;
use super::load;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::Counter;
use super::study::StudyArguments;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon plan flight.csv
      what to fly next to tell apart the effects that this flight leaves open
  pylon plan monday.csv tuesday.csv --model ours.toml -o next.toml
      also write it as a scenario; `pylon simulate next.toml -o next.csv` rehearses it
  pylon diagnose monday.csv tuesday.csv next.csv --model ours.toml
      after it was flown: what the flights show together
  pylon plan flight.csv --json | jq .outlook.sets
      for other programs";

/// Plan the shortest next flight that would resolve what the flights leave open
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    study: StudyArguments,
    /// Write the plan as a scenario for `pylon simulate`
    #[arg(short, long, value_name = "SCENARIO")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let study = &arguments.study;
    let model = load::model(&study.model)?;
    let places = study.find()?;
    if let Some(output) = &arguments.output {
        let inputs: Vec<Role<'_>> = places.files().map(|file| Role::new(file, "a flight")).collect();
        refuse_overwriting(&inputs, &[Role::new(output, "the plan")])?;
    }
    let flights = places.read(&model, study)?;
    let [learned, held] = flights.replays(&model)?;
    let mut counter = Counter::new("diagnosing", "fits");
    let (mut diagnosis, further) = diagnose(&learned, &held, &mut || counter.step());
    drop(counter);
    diagnosis.model.clone_from(&study.model);
    flights.write_left_out();
    let Some(further) = further else {
        return Err(Failure::input("no flight can be diagnosed, so there is nothing to plan for"));
    };
    let flown: Vec<&Flight> = flights.learned().collect();
    let mut counter = Counter::new("planning", "plans");
    let found = suggest(&further.planner, &flown, &model, &mut || counter.step());
    drop(counter);
    let Some((found, around)) = found else {
        return Err(Failure::input(format!(
            "no manoeuvre can be flown by the simulated aircraft at {:.0} m/s and {:.0} m, as these flights were",
            pylon::plan::Circumstances::of(&flown).speed_mps,
            pylon::plan::Circumstances::of(&flown).altitude_m,
        )));
    };
    let mut result = PlanResult::new(&diagnosis, &found, &around);
    if let Some(output) = &arguments.output {
        write_atomically(output, |file| file.write_all(found.flown.text.as_bytes()))?;
        result.file = Some(output.display().to_string());
    }
    if arguments.json {
        return terminal::put_json(&result);
    }
    let mut said = text(&result, terminal::has_colour());
    if let Some(file) = &result.file {
        let names: Vec<String> =
            study.flights.iter().map(|file| quoted(&file.display().to_string())).collect();
        let names = names.join(" ");
        let scenario = quoted(file);
        said += &format!(
            "\nWrote {file}. To rehearse it: pylon simulate {scenario} -o rehearsal.csv\n\
             After the flight: pylon diagnose {names} NEXT_FLIGHT\n"
        );
    } else if !is_hopeless(&result) {
        said += "\nTo write this as a scenario, for `pylon simulate`: -o next.toml\n";
    }
    terminal::put_coloured(&said)
}
