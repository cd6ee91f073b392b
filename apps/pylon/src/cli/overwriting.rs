//! Guards against a command overwriting one of its inputs, or one of its outputs with another.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use same_file::Handle;

use super::failure::Failure;

/// A file that a command reads or writes, and its role for the error message: "the log", "the model".
#[derive(Clone, Copy, Debug)]
pub struct Role<'a> {
    /// Its path.
    pub path: &'a Path,
    /// Its role.
    pub what: &'a str,
}

impl<'a> Role<'a> {
    /// A file and its role.
    pub const fn new(path: &'a Path, what: &'a str) -> Self {
        Self { path, what }
    }
}

/// Refuses an output that is one of the inputs or another output, by whatever path: another spelling, a
/// symbolic link or a hard link. Devices and pipes are exempt: writing to them loses nothing.
pub fn refuse_overwriting(inputs: &[Role<'_>], outputs: &[Role<'_>]) -> Result<(), Failure> {
    for (index, output) in outputs.iter().enumerate() {
        let read = inputs.iter().find(|input| is_same(input.path, output.path));
        if let Some(input) = read {
            let alias = alias(input.path, output.path);
            return Err(Failure::input(format!(
                "{}{alias} is {}, which would be lost; expected another file to write {} to",
                output.path.display(),
                input.what,
                output.what
            )));
        }
        let written = outputs.iter().take(index).find(|other| is_same(other.path, output.path));
        if let Some(other) = written {
            return Err(Failure::input(format!(
                "{}: {} and {} would both be written to it; expected two files",
                output.path.display(),
                other.what,
                output.what
            )));
        }
    }
    Ok(())
}

/// How a path that looks different leads to the same file, for the error message.
fn alias(input: &Path, output: &Path) -> String {
    if input == output { String::new() } else { format!(" (by the name {})", input.display()) }
}

fn is_same(one: &Path, other: &Path) -> bool {
    match (fs::metadata(one), fs::metadata(other)) {
        (Ok(one_data), Ok(other_data)) => {
            one_data.is_file()
                && other_data.is_file()
                && Handle::from_path(one)
                    .is_ok_and(|one| Handle::from_path(other).is_ok_and(|other| one == other))
        }
        // Neither exists yet: compare the name and the directory.
        (Err(_), Err(_)) => place(one).is_ok_and(|one| place(other).is_ok_and(|other| one == other)),
        _ => false,
    }
}

/// The path that a file which does not exist yet will have.
fn place(path: &Path) -> io::Result<PathBuf> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
    Ok(directory.canonicalize()?.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(inputs: &[&Path], outputs: &[&Path]) -> Option<String> {
        let roles = |paths: &[&'static str]| paths.to_vec();
        let (input_names, output_names) =
            (roles(&["the log", "the model"]), roles(&["the flight", "the truth"]));
        let inputs: Vec<_> =
            inputs.iter().zip(input_names).map(|(path, what)| Role::new(path, what)).collect();
        let outputs: Vec<_> =
            outputs.iter().zip(output_names).map(|(path, what)| Role::new(path, what)).collect();
        refuse_overwriting(&inputs, &outputs).err().map(|failure| format!("{failure:?}"))
    }

    #[test]
    fn an_input_is_not_overwritten_by_any_of_its_names() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("x.igc"), "x").unwrap();
        fs::write(at("y.igc"), "y").unwrap();
        fs::hard_link(at("x.igc"), at("hard")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(at("x.igc"), at("soft")).unwrap();
        let dotted = directory.path().join("./x.igc");
        for name in [at("x.igc"), dotted, at("hard"), at("soft")] {
            let refused = refusal(&[&at("x.igc")], &[&name]);
            assert!(refused.is_some_and(|line| line.contains("is the log, which would be lost")), "{name:?}");
        }
        for name in [at("y.igc"), at("new")] {
            assert_eq!(refusal(&[&at("x.igc")], &[&name]), None, "{name:?}");
        }
        assert_eq!(refusal(&[Path::new("/dev/null")], &[Path::new("/dev/null")]), None);
    }

    #[test]
    fn two_outputs_are_two_files_also_before_they_are_there() {
        let directory = tempfile::tempdir().unwrap();
        let (one, other) = (directory.path().join("a.csv"), directory.path().join("./a.csv"));
        let refused = refusal(&[], &[&one, &other]).unwrap();
        assert!(refused.contains("the flight and the truth would both be written to it"), "{refused}");
        assert_eq!(refusal(&[], &[&one, &directory.path().join("b.csv")]), None);
        assert_eq!(refusal(&[], &[Path::new("/dev/null"), Path::new("/dev/null")]), None);
    }
}
