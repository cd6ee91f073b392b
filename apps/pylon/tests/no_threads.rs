//! A machine without free threads: the work is done in the existing one, or one line gives the reason.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::Path;
use std::process::{Command, Output};

use common::Recipe;

/// A user to whom the limit applies: root is exempt.
const NOBODY: &str = "65534";

/// A program in a process that may have only its first thread.
fn limited(directory: &Path, program: &str, arguments: &[&str]) -> Command {
    const LIMIT: &str = "ulimit -u 1 && exec \"$0\" \"$@\"";
    let is_root = fs::metadata("/proc/self").unwrap().uid() == 0;
    let mut command = if is_root {
        let mut command = Command::new("setpriv");
        command.args(["--reuid", NOBODY, "--regid", NOBODY, "--clear-groups", "bash", "-c", LIMIT]);
        command
    } else {
        let mut command = Command::new("bash");
        command.args(["-c", LIMIT]);
        command
    };
    command.arg(program).args(arguments).current_dir(directory);
    command
}

/// Why the limit does not work here, if so: without it this test would show nothing.
fn why_not(directory: &Path, program: &str) -> Option<String> {
    // A shell that can start no other process can start no thread either. `timeout`, because some retry for a
    // while.
    let forks = limited(directory, "sh", &["-c", "(exit 3) & wait $!"]).output();
    match forks {
        Err(error) => return Some(format!("bash or setpriv: {error}")),
        Ok(output) if output.status.code() == Some(3) => return Some("the limit does not hold".to_owned()),
        Ok(_) => {}
    }
    let version = limited(directory, program, &["--version"]).output().unwrap();
    (!version.status.success())
        .then(|| format!("another user cannot run {program}: {}", String::from_utf8_lossy(&version.stderr)))
}

/// A flight with a column so wide that its file is read in parts (from 8 MB on two cores).
fn write_wide_flight(file: &Path) {
    let mut csv = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vd_mps,baro_alt_m,wide\n".to_owned();
    let zeros = "0".repeat(4000);
    for k in 0..2400_u32 {
        let t = 0.05 * f64::from(k);
        let (altitude_m, climb_mps) = (500.0 + 27.0 * (1.0 - (t / 9.0).cos()), 3.0 * (t / 9.0).sin());
        let fix = if k % 4 == 0 { format!("{altitude_m:.3},{:.3}", -climb_mps) } else { ",".to_owned() };
        let rough = f64::from((k * 37) % 19) / 19.0;
        let launch = u8::from(k >= 1200);
        let _ = writeln!(csv, "{t:.3},{launch},{fix},{:.3},1.{zeros}", altitude_m + rough - climb_mps);
    }
    fs::write(file, csv).unwrap();
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn without_a_thread_every_command_gives_what_it_gives_with_them() {
    let program = env!("CARGO_BIN_EXE_pylon");
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path();
    // The user who runs the limited program needs access, also to write.
    fs::set_permissions(directory, fs::Permissions::from_mode(0o777)).unwrap();
    if let Some(why) = why_not(directory, program) {
        println!("skipped: without_a_thread_every_command_gives_what_it_gives_with_them: {why}");
        return;
    }
    Recipe::default().write(directory);
    write_wide_flight(&directory.join("wide.csv"));
    for arguments in [
        &["open", "wide.csv", "--json"][..],
        &["compare", "wide.csv", "--json"],
        &["compare", "made.csv", "--json"],
        &["diagnose", "made.csv", "wide.csv", "--json"],
        &["report", "made.csv", "wide.csv", "-o", "page.html", "--json"],
    ] {
        let page = directory.join("page.html");
        let run = |mut command: Command| -> (Output, Option<Vec<u8>>) {
            let output = command.output().unwrap();
            let read = fs::read(&page).ok();
            let _ = fs::remove_file(&page);
            (output, read)
        };
        let (alone, page_alone) = run(limited(directory, program, arguments));
        assert!(alone.status.success(), "{arguments:?}: {}", text(&alone.stderr));
        assert_eq!(text(&alone.stderr), "", "{arguments:?}");
        let mut command = Command::new(program);
        command.args(arguments).current_dir(directory);
        let (together, page_together) = run(command);
        assert!(together.status.success(), "{arguments:?}: {}", text(&together.stderr));
        assert!(alone.stdout == together.stdout, "{arguments:?}");
        assert!(page_alone == page_together, "{arguments:?}");
    }
    // A server that needs several threads cannot run with one.
    let studio = limited(directory, program, &["studio", "--no-browser", "--port", "0"]).output().unwrap();
    assert_eq!(studio.status.code(), Some(2));
    let error = text(&studio.stderr);
    assert!(
        error.starts_with("error: the studio needs 6 threads: ") && error.lines().count() == 1,
        "{error}"
    );
}
