//! A stand-in for OpenOCD with a board on its probe: QEMU runs the image, in the directory in which OpenOCD
//! would, with the files and the exit status that OpenOCD would give it. It understands the very arguments
//! that are given to OpenOCD and no others, and fails as OpenOCD fails.
//!
//! What it cannot stand in for: the probe, the flash, the reset, the clocks, and how long anything takes.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use pylon::fly::DebugLink;

/// What is wrong with it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    None,
    /// It is too old to hand on an exit status.
    Old,
    NoProbe,
    NoBoard,
    /// The flash does not keep what is written.
    NotWritten,
    /// The core stops at something that is no call of the host.
    Halted,
    /// It hangs.
    Hung,
}

/// Each argument in a line, as OpenOCD has to get them.
const ARGUMENTS: &str = "\
-f
interface/stlink.cfg
-f
target/stm32f4x.cfg
-c
gdb_port disabled
-c
tcl_port disabled
-c
telnet_port disabled
-c
init
-c
program flight.elf verify
-c
reset halt
-c
mww 0x2001f000 0 1024
-c
catch {cortex_m vector_catch none}
-c
arm semihosting enable
-c
resume
-c
wait_halt 2147483647
-c
echo {pylon: the core has stopped, and not for a call of the host}
-c
shutdown error
";

const INTRODUCTION: &str = "\
Info : auto-selecting first available session transport \"hla_swd\". To override use 'transport select <transport>'.
Info : clock speed 2000 kHz";

/// Writes the program `openocd` into a directory and returns where it is.
pub fn install(directory: &Path, trouble: Trouble) -> PathBuf {
    let version = if trouble == Trouble::Old { "0.10.0" } else { "0.12.0" };
    let fly = "exec qemu-system-arm -machine netduinoplus2 -nographic -monitor none -serial none \
               -icount shift=0,sleep=off -semihosting-config enable=on,target=native -kernel flight.elf";
    let fail = |said: &str| format!("echo \"{said}\" >&2; exit 1");
    let run = match trouble {
        Trouble::None | Trouble::Old => fly.to_owned(),
        Trouble::NoProbe => fail("Error: open failed"),
        Trouble::NoBoard => fail("Error: init mode failed (unable to connect to the target)"),
        Trouble::NotWritten => fail("** Programming Started **\n** Programming Failed **"),
        Trouble::Halted => {
            fail("pylon: the core has stopped, and not for a call of the host\nshutdown command invoked")
        }
        Trouble::Hung => "echo '** Verified OK **' >&2; exec sleep 600".to_owned(),
    };
    let script = format!(
        "#!/bin/sh\n\
         here=$(dirname \"$0\")\n\
         echo 'Open On-Chip Debugger {version}' >&2\n\
         [ \"$*\" = --version ] && exit 0\n\
         printf '%s\\n' \"$@\" > \"$here/got\"\n\
         cmp \"$here/got\" \"$here/expected\" >&2 || exit 1\n\
         cat >&2 <<'END'\n{INTRODUCTION}\nEND\n\
         {run}\n"
    );
    fs::write(directory.join("expected"), ARGUMENTS).unwrap();
    let program = directory.join("openocd");
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    program
}

/// A link by this stand-in.
pub fn link(directory: &Path, trouble: Trouble) -> DebugLink {
    DebugLink { openocd: install(directory, trouble), ..DebugLink::default() }
}
