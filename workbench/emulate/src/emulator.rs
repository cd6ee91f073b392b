//! Runs an image in QEMU.

use std::io::{self, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use super::error::FlyError;
use super::one_processor;

/// The emulated machine: an STM32F405RG.
const MACHINE: &str = "netduinoplus2";

/// What an image left behind after a run in QEMU or on a board ([`super::DebugLink`]).
#[derive(Debug)]
pub struct Emulation {
    /// QEMU's exit status, which is the firmware's if the firmware ended the run; `None` after a signal.
    pub code: Option<i32>,
    /// What the firmware wrote to its standard output.
    pub stdout: Vec<u8>,
    /// What the firmware or QEMU wrote to the standard error.
    pub stderr: String,
}

/// Runs an image with `directory` as the place of its files, one instruction a nanosecond and without waiting
/// for the wall clock. The output of USART1 goes into the file `serial` there, if given.
///
/// # Errors
/// [`FlyError::NoEmulator`], [`FlyError::Timeout`], [`FlyError::Io`].
pub fn emulate(
    image: &Path,
    directory: &Path,
    serial: Option<&str>,
    timeout: Duration,
) -> Result<Emulation, FlyError> {
    let serial = serial.map_or_else(|| "none".to_owned(), |file| format!("file:{file}"));
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-machine", MACHINE, "-nographic", "-monitor", "none", "-serial", &serial])
        .args(["-icount", "shift=0,sleep=off", "-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(image)
        .current_dir(directory)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    // Held until the emulation has ended.
    let _processor;
    let mut qemu;
    (qemu, _processor) = one_processor::spawn(&mut command, &image.with_file_name("")).map_err(|error| {
        match error.kind() {
            io::ErrorKind::NotFound => FlyError::NoEmulator,
            _ => FlyError::Io { what: "qemu-system-arm".to_owned(), source: error },
        }
    })?;
    // Both pipes are drained while it runs; a full one would block it.
    let drained = drain(qemu.stdout.take()).and_then(|stdout| Ok((stdout, drain(qemu.stderr.take())?)));
    let (stdout, stderr) = match drained {
        Ok(drained) => drained,
        Err(source) => {
            // Nothing else would wait for it.
            let _ = qemu.kill().and_then(|()| qemu.wait());
            return Err(FlyError::Io {
                what: "a thread that reads the output of qemu-system-arm".to_owned(),
                source,
            });
        }
    };
    let finished = stdout.recv_timeout(timeout);
    if finished.is_err() {
        let killed = qemu.kill().and_then(|()| qemu.wait());
        killed.map_err(FlyError::io("stopping qemu-system-arm"))?;
        return Err(FlyError::Timeout { seconds: timeout.as_secs() });
    }
    let code = wait(&mut qemu)?;
    Ok(Emulation {
        code,
        stdout: finished.unwrap_or_default(),
        stderr: String::from_utf8_lossy(&stderr.recv().unwrap_or_default()).into_owned(),
    })
}

fn wait(qemu: &mut Child) -> Result<Option<i32>, FlyError> {
    Ok(qemu.wait().map_err(FlyError::io("waiting for qemu-system-arm"))?.code())
}

/// Reads a pipe to its end, which it reaches when the program ends.
fn drain(pipe: Option<impl Read + Send + 'static>) -> io::Result<mpsc::Receiver<Vec<u8>>> {
    let (sender, receiver) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // A failed read ends the stream; the bytes before it are kept.
            let _ = pipe.read_to_end(&mut bytes);
        }
        // The receiver is gone if the emulation was given up.
        let _ = sender.send(bytes);
    })?;
    Ok(receiver)
}
