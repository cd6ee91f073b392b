//! A stand-in for OpenOCD with a board on its probe: QEMU runs the image, in the directory in which OpenOCD
//! would, with the files and the exit status that OpenOCD would produce. It accepts exactly the arguments
//! that are passed to OpenOCD, and fails as OpenOCD fails.
//!
//! It does not stand in for the probe, the flash, the reset, the clocks, or the time that anything takes.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use pylon::fly::DebugLink;

/// The fault of the stand-in or its board.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    None,
    /// It is too old to pass on an exit status.
    Old,
    NoProbe,
    NoBoard,
    /// The flash does not keep the data written.
    NotWritten,
    /// The core halts at something other than a semihosting call.
    Halted,
    /// It hangs.
    Hung,
}

/// The arguments, one per line, as OpenOCD must receive them.
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

/// Writes the program `openocd` into a directory and returns its path.
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

/// A debug link through this stand-in.
pub fn link(directory: &Path, trouble: Trouble) -> DebugLink {
    DebugLink { openocd: install(directory, trouble), ..DebugLink::default() }
}
