//! The module's results in WebAssembly are the engine's native results, to the last digit, in spite of other
//! instructions, another mathematics library and a single thread. `apps/pylon/tests/studio_engine.rs`
//! compares the engine with the command line.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use executor::Executor;
use serde_json::json;
use simulate::{Scenario, simulate};
use studio_engine::Engine;

const TARGET: &str = "wasm32-unknown-unknown";
const FLIGHTS: [&str; 3] = ["quickstart", "hidden-static-port", "paper-reconstruction"];

/// An executor with two threads that starts with the last job.
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

/// Builds the module as for the site and returns its path.
fn module() -> PathBuf {
    let mut build = Command::new(env!("CARGO"));
    build.args(["build", "--package", "studio-engine", "--lib", "--profile", "studio", "--target", TARGET]);
    let output = build.args(["--message-format", "json"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let messages = String::from_utf8(output.stdout).unwrap();
    let file = messages.lines().rev().find_map(|line| {
        let end = line.find("studio_engine.wasm\"")? + "studio_engine.wasm".len();
        let start = line[..end].rfind('"')? + 1;
        Some(PathBuf::from(&line[start..end]))
    });
    file.unwrap_or_else(|| panic!("no module in {messages}"))
}

fn in_wasm(module: &Path, flight: &Path, request: &str) -> Vec<u8> {
    let mut node = Command::new("node");
    node.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/ask.mjs")).args([module, flight]).arg(request);
    let output = node.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The first place where two texts differ.
fn first_difference(a: &[u8], b: &[u8]) -> String {
    let at = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let around = |text: &[u8]| {
        let part = text.get(at.saturating_sub(80)..(at + 40).min(text.len())).unwrap_or_default();
        String::from_utf8_lossy(part).into_owned()
    };
    format!("byte {at}\n  {}\n  {}", around(a), around(b))
}

#[test]
fn wasm_says_what_native_code_says() {
    let module = module();
    let model = json!({ "name": "default", "text": "" });
    for name in FLIGHTS {
        let scenario = format!("{}/../../../flights/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&scenario).unwrap();
        let scenario = Scenario::from_toml(&text, &scenario).unwrap();
        let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
        let mut csv = Vec::new();
        flight_data::to_writer(&mut csv, &flight).unwrap();
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.csv"));
        std::fs::write(&file, &csv).unwrap();
        let mut engine = Engine::new(&Pair);
        let open = json!({ "call": "open", "of": { "flight": "flight", "file": format!("{name}.csv") } });
        engine.ask(open.to_string().as_bytes(), &csv, &mut |_, _, _| {});
        for export in [
            json!({ "what": "compare", "flight": "flight", "model": model, "times": {} }),
            json!({ "what": "diagnose", "flights": ["flight"], "hold_outs": [], "model": model, "times": {} }),
        ] {
            let request = json!({ "call": "export", "of": { "export": export } }).to_string();
            let native = engine.ask(request.as_bytes(), &[], &mut |_, _, _| {});
            assert!(native.bytes.len() > 1000, "{}", native.json);
            let wasm = in_wasm(&module, &file, &request);
            assert!(native.bytes == wasm, "{name} {export}: {}", first_difference(&native.bytes, &wasm));
        }
    }
}
