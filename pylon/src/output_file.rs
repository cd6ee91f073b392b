//! Output files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// An output file that was not written. Nothing of it is left behind, and a file of that name that
/// was there before is as it was.
#[derive(Debug, Error)]
#[error("{}: can not be written: {reason}", path.display())]
pub struct OutputError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: io::Error,
}

/// Writes a file through `content`: without a name (elsewhere than on Linux: under a temporary one) in
/// the same directory, and named `path` only once all of it is on the disk.
///
/// A `path` that exists and is not a regular file (`/dev/stdout`, a pipe) is written to directly. A
/// symbolic link stays; the file that it leads to is replaced.
///
/// # Errors
/// [`OutputError`] when the directory is missing or read-only, the disk is full, or `content` failed.
pub fn write_atomically<F>(path: &Path, content: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    write(path, content).map_err(|reason| OutputError { path: path.to_path_buf(), reason })
}

fn write<F>(path: &Path, content: F) -> io::Result<()>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let target = match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => return Err(io::Error::other("it is a directory")),
        Ok(existing) if !existing.is_file() => {
            let mut device = BufWriter::new(File::options().write(true).open(path)?);
            content(&mut device)?;
            return device.flush();
        }
        Ok(_) => fs::canonicalize(path)?,
        Err(_) => path.to_path_buf(),
    };
    let directory = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    #[cfg(target_os = "linux")]
    if let Some(file) = unnamed::create(directory) {
        fill(&file, content)?;
        return unnamed::name(&file, directory, &target);
    }
    let temporary = temporary_file(directory)?;
    fill(temporary.as_file(), content)?;
    temporary.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

fn fill<F>(file: &File, content: F) -> io::Result<()>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let mut buffered = BufWriter::with_capacity(1 << 16, file);
    content(&mut buffered)?;
    buffered.flush()?;
    // A rename can reach the disk before the data does; without this a power cut leaves an empty file.
    file.sync_all()
}

/// Linux can write a file that has no name yet: killed at any moment, the program leaves nothing behind.
#[cfg(target_os = "linux")]
mod unnamed {
    use std::fs::{self, File};
    use std::io;
    use std::os::fd::AsRawFd as _;
    use std::path::Path;

    use rustix::fs::{AtFlags, CWD, Mode, OFlags};

    /// A file without a name in the directory, or `None` where the file system has no such thing or
    /// `/proc`, which it is named through, is not there.
    pub fn create(directory: &Path) -> Option<File> {
        let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
        // As any new file: what the user's umask leaves of it.
        let mode = Mode::from_raw_mode(0o666);
        let file = File::from(rustix::fs::open(directory, flags, mode).ok()?);
        fs::exists(link(&file)).is_ok_and(|exists| exists).then_some(file)
    }

    fn link(file: &File) -> String {
        format!("/proc/self/fd/{}", file.as_raw_fd())
    }

    /// Gives the file its name, in place of what had it. A name can only be given where none is, so
    /// that the whole file has another one in between.
    pub fn name(file: &File, directory: &Path, target: &Path) -> io::Result<()> {
        let between = tempfile::Builder::new().prefix(".pylon-").make_in(directory, |path| {
            Ok(rustix::fs::linkat(CWD, link(file), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
        })?;
        between.into_temp_path().persist(target).map_err(|error| error.error)
    }
}

fn temporary_file(directory: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pylon-");
    // Temporary files are private by default; an output file follows the user's umask.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
        builder.tempfile_in(directory)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(directory)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn writes_the_whole_file_under_its_name_only() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.csv");
        write_atomically(&path, |out| out.write_all(b"whole")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(directory.path()), ["out.csv"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_has_no_name_until_it_is_whole() {
        let directory = tempfile::tempdir().unwrap();
        if unnamed::create(directory.path()).is_none() {
            println!("skipped: the file system has no files without names");
            return;
        }
        for content in ["first", "second"] {
            let path = directory.path().join("out.csv");
            let before = names(directory.path());
            write_atomically(&path, |out| {
                out.write_all(content.as_bytes())?;
                out.flush()?;
                assert_eq!(names(directory.path()), before);
                Ok(())
            })
            .unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
            assert_eq!(names(directory.path()), ["out.csv"]);
        }
    }

    #[test]
    fn a_failure_midway_leaves_nothing_new_and_the_old_file_untouched() {
        let directory = tempfile::tempdir().unwrap();
        let fail = |out: &mut dyn Write| {
            out.write_all(&[b'x'; 1 << 17])?;
            Err(io::Error::other("disk full"))
        };
        let fresh = directory.path().join("fresh.csv");
        let message = write_atomically(&fresh, fail).unwrap_err().to_string();
        assert!(message.ends_with("fresh.csv: can not be written: disk full"), "{message}");
        assert!(names(directory.path()).is_empty());

        let old = directory.path().join("old.csv");
        fs::write(&old, "old").unwrap();
        write_atomically(&old, fail).unwrap_err();
        assert_eq!(fs::read(&old).unwrap(), b"old");
        assert_eq!(names(directory.path()), ["old.csv"]);
    }

    #[test]
    fn a_missing_directory_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("no/such/out.csv");
        assert!(write_atomically(&path, |out| out.write_all(b"x")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn follows_links_and_leaves_devices_alone() {
        use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("file");
        let link = directory.path().join("link");
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");

        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_atomically(&pipe, |out| out.write_all(b"through")).unwrap();
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(reader.join().unwrap(), b"through");

        // As any program's output: readable by others where the umask lets it be.
        let reference = directory.path().join("reference");
        fs::write(&reference, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&file), mode(&reference));
    }
}
