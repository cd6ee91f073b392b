//! `pylon studio`.

mod fly;
mod guard;
mod model_file;
mod page;
mod server;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Args;
use model::Model;

use super::failure::Failure;
use super::load;
use super::places::Places;
use super::terminal;
use model_file::ModelFile;
use server::{Server, check_threads};

const EXAMPLES: &str = "\
Examples:
  pylon studio
      open the studio in a browser; drop flights onto its page
  pylon studio flight.ulg --model ours.toml
      with a flight opened, and a model that the page's Save may write
  pylon studio logs/ --port 8040 --no-browser
      every log of a folder, on a given port; the address is printed

The page runs entirely in the browser: no data leaves this machine, and only this machine is served. Ctrl-C ends it.";

/// Show flights and their models in a browser: the cause, what an effect would change, and the error falling
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Flights to open: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// The model to start with, which the page may write: a TOML file (an empty one is a model)
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// The port to listen on (0: any that is free)
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Print the address without opening a browser
    #[arg(long)]
    no_browser: bool,
}

/// Runs the command until it is interrupted.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = arguments.model.as_deref().map(model_file).transpose()?;
    let logs = Places::find(&arguments.logs)?;
    load::refuse_repeats(&logs.files, &[])?;
    if let Some(missing) = logs.files.iter().find(|file| !file.is_file()) {
        return Err(Failure::input(format!("{}: there is no such file or folder", missing.display())));
    }
    logs.write_notes();
    check_threads()?;
    let page = page::page()?;
    let server = Server::bind(arguments.port, page, logs.files, model)?;
    terminal::put(&format!("{}\n", server.address()))?;
    // If standard error is closed, there is nowhere to report this.
    let _ = writeln!(std::io::stderr(), "the studio stays at that address until interrupted (Ctrl-C)");
    if !arguments.no_browser {
        open_browser(server.address());
    }
    server.serve()
}

/// The model file that may be written; it must exist and be a valid model.
fn model_file(path: &Path) -> Result<ModelFile, Failure> {
    let name = path.display().to_string();
    if Model::preset(&name).is_some() {
        return Err(Failure::input(format!(
            "{name} is a preset and can't be changed: the page offers it; --model takes a file (an empty one is a model: touch \
             ours.toml)"
        )));
    }
    let file = ModelFile::new(path);
    file.read()?;
    load::model(&name)?;
    Ok(file)
}

/// Opens the address in the user's browser. If that fails, the address has been printed.
fn open_browser(address: &str) {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let started = Command::new(program)
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if started.is_err() {
        let _ = writeln!(
            std::io::stderr(),
            "note: {program} could not be started: open the address in a browser"
        );
    }
}
