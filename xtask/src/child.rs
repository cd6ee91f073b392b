//! Child processes: their output is shown only if they fail or the user asked for it.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Output of a child.
#[derive(Debug, Default)]
pub struct ChildOutput {
    /// Its standard output.
    pub stdout: String,
    /// Both streams. Lines of different streams may be in another order, unless the child was run by
    /// [`run_in_order`].
    pub all: String,
}

/// Why a child failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// It could not be started.
    #[error("`{command}` could not be started: {error}")]
    NotStarted {
        /// The command as typed.
        command: String,
        /// The system's error.
        error: io::Error,
    },
    /// It ended with an error.
    #[error("`{command}` ended with {status}")]
    Ended {
        /// The command as typed.
        command: String,
        /// Its exit code or signal.
        status: ExitStatus,
        /// All its output.
        output: ChildOutput,
    },
}

/// Runs a child to its end, without input. With `echo` all its output also goes to standard error.
pub fn run(command: &mut Command, echo: bool) -> Result<ChildOutput, Failure> {
    run_heard(command, echo, &|_| ())
}

/// As [`run`]; `hear` gets every line of its standard error as it arrives.
pub fn run_heard(
    command: &mut Command,
    echo: bool,
    hear: &(dyn Fn(&str) + Sync),
) -> Result<ChildOutput, Failure> {
    let name = shown(command);
    if echo {
        eprintln!("$ {name}");
    }
    let not_started = |error| Failure::NotStarted { command: name.clone(), error };
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(not_started)?;
    let output = Mutex::new(ChildOutput::default());
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    thread::scope(|scope| {
        scope.spawn(|| stdout.map(|stream| listen(stream, true, echo, &output, &mut |_| ())));
        scope.spawn(|| stderr.map(|stream| listen(stream, false, echo, &output, &mut |line| hear(line))));
    });
    let status = child.wait().map_err(not_started)?;
    ended(name, status, output)
}

/// As [`run`], with both streams merged in the order in which they were written; `stdout` is empty. `hear`
/// gets every line as it arrives.
pub fn run_in_order(
    command: &mut Command,
    echo: bool,
    hear: &mut dyn FnMut(&str),
) -> Result<ChildOutput, Failure> {
    let name = shown(command);
    if echo {
        eprintln!("$ {name}");
    }
    let not_started = |error| Failure::NotStarted { command: name.clone(), error };
    let mut start = || {
        let (reader, writer) = io::pipe()?;
        command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
        let child = command.spawn();
        // The command must release its ends of the pipe, or the stream would never close.
        command.stdout(Stdio::null()).stderr(Stdio::null());
        child.map(|child| (reader, child))
    };
    let (reader, mut child) = start().map_err(not_started)?;
    let output = Mutex::new(ChildOutput::default());
    listen(reader, false, echo, &output, hear);
    let status = child.wait().map_err(not_started)?;
    ended(name, status, output)
}

fn ended(command: String, status: ExitStatus, output: Mutex<ChildOutput>) -> Result<ChildOutput, Failure> {
    let output = output.into_inner().unwrap_or_else(PoisonError::into_inner);
    if status.success() { Ok(output) } else { Err(Failure::Ended { command, status, output }) }
}

/// Collects a stream until it closes.
fn listen(
    stream: impl Read,
    is_stdout: bool,
    echo: bool,
    output: &Mutex<ChildOutput>,
    hear: &mut dyn FnMut(&str),
) {
    let mut reader = BufReader::new(stream);
    let mut line = Vec::new();
    loop {
        line.clear();
        // An unreadable stream has ended; the exit status shows whether that is an error.
        if !matches!(reader.read_until(b'\n', &mut line), Ok(1..)) {
            return;
        }
        if echo {
            let _ = io::stderr().write_all(&line);
        }
        let text = String::from_utf8_lossy(&line);
        hear(&text);
        let mut output = output.lock().unwrap_or_else(PoisonError::into_inner);
        output.all.push_str(&text);
        if is_stdout {
            output.stdout.push_str(&text);
        }
    }
}

/// A command as one would type it.
pub fn shown(command: &Command) -> String {
    let variables = command.get_envs().filter_map(|(name, value)| {
        Some(format!("{}={}", name.to_string_lossy(), quoted(&value?.to_string_lossy())))
    });
    let program = command.get_program().to_string_lossy();
    // Cargo's own name is its full path.
    let program = program.rsplit('/').next().filter(|name| *name == "cargo").unwrap_or(&program).to_owned();
    let arguments = command.get_args().map(|argument| quoted(&argument.to_string_lossy()));
    variables.chain([program]).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// An argument, in quotes where a shell needs them.
fn quoted(argument: &str) -> String {
    if argument.is_empty() || argument.contains([' ', '\'', '"', '$', '*', '(', ')', ';', '&', '|']) {
        format!("'{}'", argument.replace('\'', r"'\''"))
    } else {
        argument.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn keeps_both_streams_apart_and_together() {
        let output = run(&mut shell("echo result; echo progress >&2"), false).unwrap();
        assert_eq!(output.stdout, "result\n");
        assert_eq!(output.all.len(), "result\nprogress\n".len());
        assert!(output.all.contains("progress\n"), "{}", output.all);
    }

    #[test]
    fn keeps_the_order_of_the_streams() {
        let script = "for i in 1 2 3 4 5; do echo out $i; echo err $i >&2; done";
        let mut heard = String::new();
        let output = run_in_order(&mut shell(script), false, &mut |line| heard += line).unwrap();
        let expected: String = (1..=5).map(|i| format!("out {i}\nerr {i}\n")).collect();
        assert_eq!((&output.all, &output.stdout), (&expected, &String::new()));
        assert_eq!(heard, expected);
    }

    #[test]
    fn a_failure_says_the_command_and_keeps_the_output() {
        let failure = run(&mut shell("echo why >&2; exit 3"), false).unwrap_err();
        assert_eq!(failure.to_string(), "`sh -c 'echo why >&2; exit 3'` ended with exit status: 3");
        let Failure::Ended { output, .. } = failure else { panic!("{failure}") };
        assert_eq!(output.all, "why\n");
    }

    #[test]
    fn a_missing_program_is_named() {
        let failure = run(&mut Command::new("no-such-program"), false).unwrap_err();
        assert!(failure.to_string().starts_with("`no-such-program` could not be started: "), "{failure}");
    }

    #[test]
    fn a_child_has_no_input() {
        assert_eq!(run(&mut shell("cat; echo end"), false).unwrap().stdout, "end\n");
    }

    #[test]
    fn output_that_is_not_text_does_no_harm() {
        assert_eq!(run(&mut shell(r"printf 'a\377b'"), false).unwrap().stdout, "a\u{fffd}b");
    }
}
