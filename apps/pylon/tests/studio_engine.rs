//! The studio engine's results are the command line's, byte for byte.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::process::Command;

use serde_json::json;
use studio_engine::Engine;

fn pylon(folder: &std::path::Path, arguments: &[&str]) -> Vec<u8> {
    let output =
        Command::new(env!("CARGO_BIN_EXE_pylon")).current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

#[test]
fn the_engine_exports_what_the_command_line_prints() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = Engine::new(&executor::Inline);
    let flights = ["hidden-static-port", "quickstart"];
    for name in flights {
        let scenario = format!("{}/../../flights/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        pylon(folder.path(), &["simulate", &scenario, "-o", &format!("{name}.csv")]);
        let csv = std::fs::read(folder.path().join(format!("{name}.csv"))).unwrap();
        let open =
            json!({ "call": "open", "of": { "flight": name, "file": format!("{name}.csv") } }).to_string();
        engine.ask(open.as_bytes(), &csv, &mut |_, _, _| {});
    }
    let model = json!({ "name": "default", "text": "" });
    let mut exported = |export: serde_json::Value| {
        let request = json!({ "call": "export", "of": { "export": export } }).to_string();
        let reply = engine.ask(request.as_bytes(), &[], &mut |_, _, _| {});
        assert!(reply.json.starts_with("{\"ok\""), "{}", reply.json);
        String::from_utf8(reply.bytes).unwrap()
    };
    let compared = exported(json!({ "what": "compare", "flight": flights[0], "model": model, "times": {} }));
    let printed = pylon(folder.path(), &["compare", "hidden-static-port.csv", "--json"]);
    assert_eq!(compared.as_bytes(), printed);
    let diagnosed = exported(json!({
        "what": "diagnose", "flights": flights, "hold_outs": [], "model": model, "times": {}
    }));
    let printed = pylon(folder.path(), &["diagnose", "hidden-static-port.csv", "quickstart.csv", "--json"]);
    assert_eq!(diagnosed.as_bytes(), printed);
    assert!(diagnosed.contains("by_vehicle"), "{diagnosed}");
}
