//! What compare and diagnose say in WebAssembly is what they say natively, to the last digit: other instructions, another
//! mathematics library, one thread.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use executor::Executor;
use portable::{Question, ask};
use simulate::{Scenario, simulate};

const TARGET: &str = "wasm32-unknown-unknown";
const FLIGHTS: [&str; 3] = ["quickstart", "hidden-static-port", "paper-reconstruction"];

/// Two threads, the last job first.
struct Pair;

impl Executor for Pair {
    fn width(&self) -> usize {
        2
    }

    fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        let left = AtomicUsize::new(jobs);
        let work = || {
            while let Ok(before) =
                left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1))
            {
                job(before - 1);
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(work);
            work();
        });
    }
}

/// Builds the module; its file.
fn module() -> PathBuf {
    let mut build = Command::new(env!("CARGO"));
    build.args(["build", "--package", "portable", "--lib", "--target", TARGET, "--message-format", "json"]);
    let output = build.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let messages = String::from_utf8(output.stdout).unwrap();
    let file = messages.lines().rev().find_map(|line| {
        let end = line.find("portable.wasm\"")? + "portable.wasm".len();
        let start = line[..end].rfind('"')? + 1;
        Some(PathBuf::from(&line[start..end]))
    });
    file.unwrap_or_else(|| panic!("no module in {messages}"))
}

fn in_wasm(module: &Path, flight: &Path, question: Question) -> String {
    let mut node = Command::new("node");
    node.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/ask.mjs"));
    node.args([module, flight]).arg((question as u32).to_string());
    let output = node.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Where two texts part.
fn first_difference(a: &str, b: &str) -> String {
    let at = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
    let around = |text: &str| {
        text.get(at.saturating_sub(80)..(at + 40).min(text.len())).unwrap_or_default().to_owned()
    };
    format!("byte {at}\n  {}\n  {}", around(a), around(b))
}

#[test]
fn wasm_says_what_native_code_says() {
    let module = module();
    for name in FLIGHTS {
        let scenario = format!("{}/../flights/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&scenario).unwrap();
        let scenario = Scenario::from_toml(&text, &scenario).unwrap();
        let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
        let mut csv = Vec::new();
        flight_data::to_writer(&mut csv, &flight).unwrap();
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.csv"));
        std::fs::write(&file, &csv).unwrap();
        for question in [Question::Compare, Question::Diagnose] {
            let native = ask(question, &csv, &Pair).unwrap();
            assert!(native.len() > 1000, "{native}");
            let wasm = in_wasm(&module, &file, question);
            assert!(native == wasm, "{name} {question:?}: {}", first_difference(&native, &wasm));
        }
    }
}
