//! Compare and diagnose as one module for a browser, with the default model: a flight's CSV in, what `pylon compare --json` and
//! `pylon diagnose --json` print out, but for the names of files.
//!
//! WebAssembly passes numbers only. So the CSV goes in byte by byte ([`put`]), and what [`answer`] made comes out byte by byte
//! ([`get`]).

use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard, PoisonError};

use analysis::compare::{Options, compare};
use analysis::diagnose::{NamedReplay, diagnose};
use executor::{Executor, Inline};
use model::Model;
use replay::Replay;

/// What a flight is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// How well the model agrees with it.
    Compare,
    /// Which effect the model lacks.
    Diagnose,
}

/// The answer as JSON.
///
/// # Errors
/// Why there is none, as one line.
pub fn ask(question: Question, csv: &[u8], executor: &dyn Executor) -> Result<String, String> {
    let (flight, _) = flight_data::parse(csv).map_err(|error| error.to_string())?;
    let model = Model::default();
    let json = match question {
        Question::Compare => {
            let replay = Replay::new(&flight, &model, None).map_err(|error| error.to_string())?;
            let compared = compare(&replay, &Options::default(), &mut |_| {}, executor);
            serde_json::to_string(&compared.map_err(|error| error.to_string())?.0)
        }
        Question::Diagnose => {
            let replay = Replay::to_diagnose(&flight, &model, None).map_err(|error| error.to_string())?;
            let flights = [NamedReplay { file: String::new(), replay }];
            let found = diagnose(&flights, &[], &mut || ControlFlow::Continue(()), executor);
            serde_json::to_string(&found.map_err(|error| error.to_string())?)
        }
    };
    json.map_err(|error| error.to_string())
}

static CSV: Mutex<Vec<u8>> = Mutex::new(Vec::new());
static ANSWER: Mutex<Vec<u8>> = Mutex::new(Vec::new());

fn locked(bytes: &'static Mutex<Vec<u8>>) -> MutexGuard<'static, Vec<u8>> {
    bytes.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Appends a byte to the flight's CSV.
#[unsafe(no_mangle)]
pub extern "C" fn put(byte: u32) {
    locked(&CSV).push(byte as u8);
}

/// Asks 0 to compare or 1 to diagnose; how many bytes the answer has. An error is an answer too, and begins with `error: `.
#[unsafe(no_mangle)]
pub extern "C" fn answer(question: u32) -> u32 {
    let question = if question == 0 { Question::Compare } else { Question::Diagnose };
    let text = ask(question, &locked(&CSV), &Inline).unwrap_or_else(|error| format!("error: {error}"));
    let mut answer = locked(&ANSWER);
    *answer = text.into_bytes();
    answer.len() as u32
}

/// A byte of the answer; 0 beyond its end.
#[unsafe(no_mangle)]
pub extern "C" fn get(at: u32) -> u32 {
    locked(&ANSWER).get(at as usize).copied().map_or(0, u32::from)
}
