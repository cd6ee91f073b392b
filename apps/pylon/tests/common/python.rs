//! Python with the packages that read and write what Pylon exports and imports.

use std::path::{Path, PathBuf};
use std::process::Command;

const PACKAGES: [&str; 3] = ["pyarrow", "duckdb", "mcap"];

/// The build's target folder.
pub fn target_folder() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../../target"), PathBuf::from)
}

/// Python with the packages; they are installed once, by pip into the build's folder.
pub fn python() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = target_folder().join("export-readers");
    let python = folder.join("bin/python");
    let imports = format!("import {}", PACKAGES.join(", "));
    let has_all =
        || Command::new(&python).args(["-c", &imports]).output().is_ok_and(|output| output.status.success());
    if !has_all() {
        let run = |program: &Path, arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        run(Path::new("python3"), &["-m", "venv", folder.to_str().unwrap()]);
        let requirements = here.join("tests/export_readers/requirements.txt");
        let quietly = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"];
        run(&python, &[&quietly[..], &[requirements.to_str().unwrap()]].concat());
        assert!(has_all());
    }
    python
}
